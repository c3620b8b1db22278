// SPDX-License-Identifier: GPL-3.0-or-later
// The numbers of the chosen face, and how its points lie.
import {kDiverging, kVerdicts, colourAt, css} from './colours.js';
import {html, number, svg} from './elements.js';

const kNames = {
  offset_mm: ['Offset', 'offset', 'mm', 4],
  tilt_mrad: ['Tilt', 'tilt_mrad', 'mrad', 3],
  form_mm: ['Form', 'form', 'mm', 4],
  profile_mm: ['Profile', 'profile', 'mm', 4],
  radius_mm: ['Radius', 'radius', 'mm', 4],
  position_mm: ['Position', 'position', 'mm', 4],
};

function deviations(face) {
  const rows = Object.entries(kNames)
    .filter(([key]) => key in face.deviations)
    .map(([key, [name, uKey, unit, decimals]]) =>
      html('tr', {}, html('th', {scope: 'row'}, name), html('td', {class: 'number'}, number(face.deviations[key], decimals, key === 'offset_mm' || key === 'radius_mm')),
        html('td', {class: 'number'}, number(face.U_mm[uKey], decimals)), html('td', {}, unit)));
  if (!rows.length) return null;
  return html('table', {}, html('thead', {}, html('tr', {}, html('th', {scope: 'col'}, 'Measured'), html('th', {scope: 'col', class: 'number'}, 'Deviation'),
    html('th', {scope: 'col', class: 'number'}, '± U'), html('th', {}))), html('tbody', {}, rows));
}

function criteria(face) {
  if (!face.criteria.length) return null;
  const rows = face.criteria.map((c) => {
    const unit = 'deviation_mrad' in c ? 'mrad' : 'mm';
    const verdict = kVerdicts[c.verdict];
    return html('tr', {}, html('th', {scope: 'row'}, c.criterion + (c.datum ? ` to ${c.datum}` : '')), html('td', {class: 'number'}, number(c[`deviation_${unit}`], 4, true)),
      html('td', {class: 'number'}, number(c[`U_${unit}`], 4)), html('td', {class: 'number'}, `${number(c[`limit_${unit}`], 3)} ${unit}`),
      html('td', {}, html('span', {class: `badge ${c.verdict}`}, `${verdict.symbol} ${verdict.word}`)));
  });
  return html('table', {}, html('thead', {}, html('tr', {}, ...['Judged by', 'Deviation', '± U', '± Limit', ''].map((name, k) => html('th', {scope: 'col', class: k ? 'number' : null}, name)))),
    html('tbody', {}, rows));
}

function histogram(face, fullColour) {
  const {half_width_mm: half, counts} = face.histogram;
  if (!counts.length) return null;
  const [width, height, foot] = [360, 120, 18];
  const most = Math.max(...counts);
  const x = (mm) => (width * (mm / half + 1)) / 2;
  const step = width / counts.length;
  const bars = counts.map((count, k) => {
    const tall = (count / most) * (height - 8);
    const mm = ((k + 0.5) / counts.length) * 2 * half - half;
    return svg('rect', {x: k * step + 0.4, y: height - tall, width: step - 0.8, height: tall, fill: css(colourAt(kDiverging, mm / fullColour)), class: 'column'});
  });
  const lines = [svg('path', {class: 'zero', d: `M${x(0)} 0V${height}`})];
  const isTight = face.limit_mm > 0 && x(face.limit_mm) - x(0) < 40;
  const label = (mm, text, anchor = 'middle') => svg('text', {x: x(mm), y: height + 13, 'text-anchor': anchor}, text);
  const labels = [];
  if (!isTight) labels.push(label(0, '0'));
  if (face.limit_mm > 0) {
    for (const limit of [-face.limit_mm, face.limit_mm]) {
      lines.push(svg('path', {class: 'limit', d: `M${x(limit)} 0V${height}`}));
      if (!isTight) labels.push(label(limit, number(limit, 3, true)));
    }
    if (isTight) labels.push(label(-face.limit_mm, `±${number(face.limit_mm, 3)}`, 'start'));
  }
  // The offset with its uncertainty.
  const offset = face.deviations.offset_mm;
  if (Number.isFinite(offset)) {
    const U = face.U_mm.offset ?? 0;
    lines.push(svg('path', {class: 'u', d: `M${x(offset - U)} 5H${Math.max(x(offset + U), x(offset - U) + 1)}`}), svg('circle', {class: 'dot', cx: x(offset), cy: 5, r: 3.5}));
  }
  const says = `Histogram of ${face.points_used} points from ${number(-half, 3)} to ${number(half, 3)} mm`;
  return html('figure', {}, svg('svg', {class: 'histogram', viewBox: `0 0 ${width} ${height + foot}`, role: 'img', 'aria-label': says}, ...bars, ...lines, ...labels),
    html('figcaption', {}, `Points to the model, mm (${number(-half, 3, true)} to ${number(half, 3, true)}; what lies beyond is in the last bars). The dot is the offset with U; dashed lines are the limits.`));
}

function facts(face) {
  const list = [
    ['Covered', `${number(100 * face.coverage, 0)} % of ${number(face.area_mm2, 1)} mm²`],
    ['Points', `${face.points_used} used, ${face.points_rejected} rejected`],
  ];
  if (face.points_to_model) {
    const p = face.points_to_model;
    list.push(['All points to the model', `mean ${number(p.mean_mm, 4, true)}, rms ${number(p.rms_mm, 4)}, 95 % within ${number(p.p95_mm, 4)}, largest ${number(p.max_mm, 4)} mm`]);
  }
  if (face.roughness) {
    const r = face.roughness;
    list.push(['Left by the fit', `rms ${number(r.rms_mm, 4)}, peak to valley ${number(r.peak_to_valley_mm, 4)} mm; the machine alone ${number(r.machine_sigma_mm, 4)} mm`]);
  }
  return html('dl', {}, list.map(([name, value]) => html('div', {}, html('dt', {}, name), html('dd', {}, value))));
}

export function facePanel(panel, data, selection, scale) {
  const show = () => {
    const face = data.faces.get(selection.id);
    if (!face) {
      panel.replaceChildren(html('p', {class: 'hint'}, 'Choose a face in the picture or in the table to see its numbers. Arrow keys walk through the table, or turn the picture when it has the focus.'));
      return;
    }
    const verdict = kVerdicts[face.verdict];
    panel.replaceChildren(...[
      html('h2', {}, `Face ${face.id} `, html('span', {class: 'quiet'}, `${face.type}, surface ${face.surface} `), html('span', {class: `badge ${face.verdict}`}, `${verdict.symbol} ${verdict.word}`)),
      face.reason ? html('p', {}, face.reason) : null,
      criteria(face),
      histogram(face, scale.fullColour),
      deviations(face),
      facts(face),
    ].filter(Boolean));
  };
  selection.listen(show);
  scale.listen(show);
  show();
}
