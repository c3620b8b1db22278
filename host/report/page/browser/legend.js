// SPDX-License-Identifier: GPL-3.0-or-later
// What the picture's colours mean, for the mode that is on.
import {kCoverage, kDiverging, kVerdicts, css, gradient} from './colours.js';
import {html, number} from './elements.js';

const swatch = (name, text, colour) => html('span', {class: 'swatch'}, html('i', {class: name, style: colour ? `background:${colour}` : null}), text);

function deviationBar(data, scale) {
  const full = scale.fullColour;
  const at = (mm) => `left:${50 + (50 * mm) / full}%`;
  const ticks = [[-full, 'end'], [0, ''], [full, 'end']].map(([mm, kind]) => html('span', {class: `tick ${kind}`, style: at(mm)}, number(mm, 3, true)));
  if (data.hasLimits && data.limit < 0.9 * full)
    for (const mm of [-data.limit, data.limit]) ticks.push(html('span', {class: 'tick limit', style: at(mm)}, `${number(mm, 3, true)} limit`));
  return html('div', {class: 'bar-row'},
    html('button', {type: 'button', title: 'Full colour at half the deviation', 'aria-label': 'Finer colours', onclick: () => scale.change(0.5)}, '−'),
    html('div', {class: 'bar'}, html('div', {class: 'ramp', style: `background:${gradient(kDiverging)}`}), ticks),
    html('button', {type: 'button', title: 'Full colour at twice the deviation', 'aria-label': 'Coarser colours', onclick: () => scale.change(2)}, '+'));
}

export function drawLegend(legend, data, mode, scale) {
  const grey = swatch('hatched', 'not measured');
  const missing = data.report.missing_faces.length ? swatch('missing', 'missing') : null;
  const extra = data.report.extra_faces.length || data.report.misplaced.length ? swatch('extra', 'extra or misplaced') : null;
  if (mode === 'deviation' || mode === 'points') {
    const {all, shown, outside} = data.points;
    const some = shown + outside < all ? `${shown} of ${all} points are shown; every number uses all of them.` : `All ${all} points${outside ? ` but ${outside} far from the part` : ''} are shown.`;
    legend.replaceChildren(...[deviationBar(data, scale),
      html('p', {}, 'Deviation in mm, + is excess material. ', mode === 'points' ? some : 'Each place has the mean of the points about it; dark lines are at the face’s own limits. ',
        mode === 'points' ? swatch('loose', 'on no face') : grey, missing, extra)].filter(Boolean));
  } else if (mode === 'coverage') {
    legend.replaceChildren(html('div', {class: 'bar-row'}, html('div', {class: 'bar'}, html('div', {class: 'ramp', style: `background:${gradient(kCoverage)}`}),
      [0, 50, 100].map((share) => html('span', {class: 'tick', style: `left:${share}%`}, `${share} %`)))),
    html('p', {}, ...['Share of the face’s area near its own points. ', grey, missing, extra].filter(Boolean)));
  } else {
    const present = new Set(data.report.faces.map((face) => face.verdict));
    legend.replaceChildren(html('p', {}, ...Object.entries(kVerdicts).filter(([key]) => present.has(key)).map(([key, v]) => swatch(key, `${v.symbol} ${v.word}`, css(v.colour))), ...[missing, extra].filter(Boolean)));
  }
}
