// SPDX-License-Identifier: GPL-3.0-or-later
// The page comes alive: what is plain HTML stays as it is, pictures are added.
import {readData} from './data.js';
import {axesIn} from './axes.js';
import {html} from './elements.js';
import {facePanel} from './face_panel.js';
import {wireFaceTable} from './face_table.js';
import {matrixOf} from './findings_view.js';
import {drawLegend} from './legend.js';
import {normalSphere} from './normal_sphere.js';
import {PartView} from './part_view.js';
import {rangeImages} from './range_images.js';
import {Scale} from './scale.js';
import {Selection} from './selection.js';
import {Vector3} from 'three';

const kModes = [['deviation', 'Deviation'], ['verdict', 'Verdict'], ['coverage', 'Coverage'], ['points', 'Measured points']];
const kViews = [['Fit', [1, -1.25, 0.8], 'Standard view (Home)'], ['Front', [0, -1, 0], 'Along +y'], ['Back', [0, 1, 0], 'Along −y'], ['Left', [-1, 0, 0], 'Along +x'],
  ['Right', [1, 0, 0], 'Along −x'], ['Top', [0, 0, 1], 'Along −z'], ['Bottom', [0, 0, -1], 'Along +z']];

function hasWebGL() {
  try {
    return Boolean(document.createElement('canvas').getContext('webgl2'));
  } catch {
    return false;
  }
}

function buildPicture(picture, data, selection, scale) {
  const stage = html('div', {class: 'stage'}, html('canvas', {tabindex: 0, role: 'img', 'aria-label': 'The part in 3-D; arrow keys turn it, + and − zoom, Home resets, a click chooses a face'}),
    html('canvas', {class: 'paper', 'aria-hidden': 'true'}),    html('div', {class: 'labels', 'aria-hidden': 'true'}));
  const legend = html('div', {class: 'legend'});
  const modes = html('fieldset', {class: 'modes'}, html('legend', {}, 'Show'));
  const views = html('div', {class: 'directions', role: 'group', 'aria-label': 'Look from'});
  picture.append(html('div', {class: 'tools'}, modes, views), stage, legend);
  let mode = 'deviation';
  let view = null;
  const show = (next) => {
    mode = next;
    view?.setMode(mode);
    drawLegend(legend, data, mode, scale);
  };
  for (const [value, name] of kModes)
    modes.append(html('label', {}, html('input', {type: 'radio', name: 'mode', value, checked: value === mode, onchange: () => show(value)}), name));
  scale.listen(() => drawLegend(legend, data, mode, scale));
  if (!hasWebGL()) {
    stage.replaceChildren(html('p', {class: 'hint'}, 'This browser has no WebGL 2, so the part is not drawn; all numbers are here.'));
    return null;
  }
  view = new PartView(stage, data, selection, scale);
  view.drawAxes = axesIn(stage);
  view.setTheme();
  for (const [name, direction, title] of kViews) views.append(html('button', {type: 'button', title, onclick: () => view.look(new Vector3(...direction))}, name));
  show(mode);
  view.show = (next) => {
    modes.querySelector(`[value=${next}]`).checked = true;
    show(next);
  };
  return view;
}

function wireFindings(view) {
  for (const item of document.querySelectorAll('li[data-finding]')) {
    const {finding, index} = item.dataset;
    item.append(' ', html('button', {type: 'button', onclick: () => {
      view.showFinding(finding, Number(index));
      view.stage.scrollIntoView({block: 'nearest'});
    }}, 'Show'));
  }
}

/** A button for each equivalent pose that shows the points as they would lie in it. */
function wireEquivalents(view, data) {
  const items = [...document.querySelectorAll('li[data-equivalent]')];
  if (!items.length) return;
  const T_part_model = matrixOf(data.report.pose).invert();
  const buttons = items.map((item) => {
    const other = data.report.equivalents[Number(item.dataset.equivalent)];
    const button = html('button', {type: 'button', 'aria-pressed': 'false'}, 'Show points so');
    button.addEventListener('click', () => {
      const isOn = button.getAttribute('aria-pressed') === 'true';
      for (const each of buttons) each.setAttribute('aria-pressed', String(each === button && !isOn));
      view.setPose(isOn ? null : matrixOf(other).multiply(T_part_model));
      if (!isOn) view.show('points');
    });
    item.append(' ', button);
    return button;
  });
}

function start() {
  const data = readData();
  const selection = new Selection(data.faces.keys());
  const scale = new Scale(data.limit);
  const picture = document.getElementById('picture');
  const view = buildPicture(picture, data, selection, scale);
  const panel = html('div', {class: 'panel', 'aria-live': 'polite'});
  picture.append(panel);
  facePanel(panel, data, selection, scale);
  wireFaceTable(selection);
  rangeImages(document.getElementById('views'), data, selection, scale);
  normalSphere(document.getElementById('normals'), data, selection);
  if (view) {
    wireFindings(view);
    wireEquivalents(view, data);
    const theme = window.matchMedia('(prefers-color-scheme: dark)');
    theme.addEventListener('change', () => view.setTheme());
    window.addEventListener('beforeprint', () => view.print(true));
    window.addEventListener('afterprint', () => view.print(false));
  }
  const asked = /^#face-(\d+)$/.exec(window.location.hash);
  const worst = data.report.faces.filter((face) => face.verdict === 'fail' || face.verdict === 'undecided');
  if (asked) selection.choose(Number(asked[1]), 'link');
  else if (worst.length) selection.choose(Number(document.querySelector('tr[data-face]').dataset.face), 'start');
  performance.mark('ready');
  document.documentElement.dataset.ready = 'yes';
}

start();
