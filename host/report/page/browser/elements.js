// SPDX-License-Identifier: GPL-3.0-or-later
// DOM elements from a tag, attributes and children; text is never taken for markup.

const kSvg = 'http://www.w3.org/2000/svg';

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

export const html = (tag, attributes = {}, ...children) => fill(document.createElement(tag), attributes, children);
export const svg = (tag, attributes = {}, ...children) => fill(document.createElementNS(kSvg, tag), attributes, children);

/** "+0.402", with a true minus sign; an en dash when there is no number. */
export function number(value, decimals, withSign = false) {
  if (typeof value !== 'number' || !Number.isFinite(value)) return '–';
  const text = Math.abs(value).toFixed(decimals);
  const isZero = !/[1-9]/.test(text);
  return (isZero ? '' : value < 0 ? '−' : withSign ? '+' : '') + text;
}
