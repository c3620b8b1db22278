// SPDX-License-Identifier: GPL-3.0-or-later
// Colours that people with any kind of colour vision tell apart: blue to orange through near-white for deviations,
// light to dark blue for coverage, and for verdicts four of Okabe and Ito's (Color Universal Design, 2008).

/** Deviation over full colour, from -1 to 1; the limit is at a half. */
export const kDiverging = [
  [-1, [8, 48, 107]],
  [-0.5, [92, 158, 212]],
  [0, [246, 246, 244]],
  [0.5, [247, 164, 74]],
  [1, [140, 45, 4]],
];
export const kCoverage = [
  [0, [238, 243, 248]],
  [1, [58, 128, 190]],
];

export const kVerdicts = {
  fail: {word: 'Fail', symbol: '✗', colour: [213, 94, 0]},
  undecided: {word: 'Undecided', symbol: '?', colour: [240, 196, 25]},
  not_measured: {word: 'Not measured', symbol: '○', colour: [150, 155, 160]},
  pass: {word: 'Pass', symbol: '✓', colour: [0, 158, 115]},
  skipped: {word: 'Skipped', symbol: '–', colour: [196, 202, 208]},
  none: {word: 'No tolerance', symbol: '·', colour: [170, 190, 210]},
};

export function colourAt(stops, t) {
  let k = 1;
  while (k < stops.length - 1 && t > stops[k][0]) ++k;
  const [t0, a] = stops[k - 1];
  const [t1, b] = stops[k];
  const s = Math.min(1, Math.max(0, (t - t0) / (t1 - t0)));
  return a.map((x, i) => x + s * (b[i] - x));
}

export const css = ([r, g, b]) => `rgb(${Math.round(r)} ${Math.round(g)} ${Math.round(b)})`;
export const gradient = (stops) => {
  const [from, to] = [stops[0][0], stops[stops.length - 1][0]];
  return `linear-gradient(to right, ${stops.map(([t, c]) => `${css(c)} ${(100 * (t - from)) / (to - from)}%`).join(', ')})`;
};
/** The same stops as a GLSL function of one number. */
export const glsl = (name, stops) => {
  const vec = (c) => `vec3(${c.map((x) => (x / 255).toFixed(4)).join(', ')})`;
  let body = `  vec3 c = ${vec(stops[0][1])};\n`;
  for (let k = 1; k < stops.length; ++k) {
    const [from, to] = [stops[k - 1][0].toFixed(4), stops[k][0].toFixed(4)];
    body += `  c = mix(c, ${vec(stops[k][1])}, clamp((t - (${from})) / ((${to}) - (${from})), 0.0, 1.0));\n`;
  }
  return `vec3 ${name}(float t) {\n${body}  return c;\n}\n`;
};
