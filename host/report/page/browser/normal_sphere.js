// SPDX-License-Identifier: GPL-3.0-or-later
// The extended Gaussian sphere (Horn, Proc. IEEE 72 (1984) 1671): each face a needle along its normal, as long as its
// area is large, those of one normal end to end; a dot where the face was measured, its departure from the model drawn
// larger than it is.
import {Matrix4, Vector3} from 'three';
import {html, number, svg} from './elements.js';

const kRadius = 100;
const kLongest = 60; // of the needles on one normal
const kLargestAngle = 0.3; // rad, that the largest departure is drawn as

function niceFactor(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return power * [1, 2, 5].filter((step) => step * power <= x).pop();
}

/** Needles stand on one another where normals are the same to a hundredth of a degree. */
function needles(faces) {
  const stacks = [];
  for (const face of faces) {
    const normal = new Vector3(...face.normal);
    let stack = stacks.find((other) => other.normal.dot(normal) > 1 - 1.5e-8);
    if (!stack) stacks.push((stack = {normal, area: 0, parts: []}));
    stack.parts.push({face, from: stack.area, to: stack.area + face.area_mm2});
    stack.area += face.area_mm2;
  }
  const most = Math.max(...stacks.map((stack) => stack.area));
  const length = (area) => kRadius + (kLongest * area) / most;
  return stacks.flatMap((stack) => stack.parts.map(({face, from, to}) => ({face, normal: stack.normal, from: length(from), to: length(to)})));
}

function largerThanLife(model, measured, factor) {
  const axis = model.clone().cross(measured);
  const angle = Math.atan2(axis.length(), model.dot(measured));
  return axis.lengthSq() > 0 ? model.clone().applyAxisAngle(axis.normalize(), Math.min(1.2, factor * angle)) : model.clone();
}

function circle(axis, height) {
  const across = Math.sqrt(Math.max(0, 1 - height * height));
  const u = (Math.abs(axis.z) < 0.9 ? new Vector3(0, 0, 1) : new Vector3(1, 0, 0)).cross(axis).normalize();
  const v = axis.clone().cross(u);
  const points = [];
  for (let k = 0; k <= 72; ++k) {
    const angle = (k * Math.PI) / 36;
    points.push(axis.clone().multiplyScalar(height).addScaledVector(u, across * Math.cos(angle)).addScaledVector(v, across * Math.sin(angle)));
  }
  return points;
}

export function normalSphere(section, data, selection) {
  const planes = [...data.faces.values()].filter((face) => face.type === 'plane');
  if (!planes.length) return;
  const pins = needles(planes);
  const pairs = data.measured.filter((m) => m.model && data.faces.get(m.model)?.type === 'plane');
  const loose = data.measured.filter((m) => !m.model);
  const angleOf = (m) => {
    const [a, b] = [new Vector3(...data.faces.get(m.model).normal), new Vector3(...m.normal)];
    return Math.atan2(a.clone().cross(b).length(), a.dot(b));
  };
  const largest = Math.max(1e-6, ...pairs.map(angleOf));
  const factor = niceFactor(Math.max(1, kLargestAngle / largest));
  const ends = pairs.map((m) => {
    const pin = pins.find((other) => other.face.id === m.model);
    const model = new Vector3(...pin.face.normal);
    return {id: m.model, measured: m, model: model.clone().multiplyScalar((pin.from + pin.to) / 2), at: largerThanLife(model, new Vector3(...m.normal), factor).multiplyScalar((pin.from + pin.to) / 2), angle: angleOf(m)};
  });
  const rings = [...data.faces.values()].filter((face) => face.type === 'cylinder' || face.type === 'cone')
    .map((face) => ({id: face.id, points: circle(new Vector3(...face.axis), face.type === 'cone' ? -Math.sin(face.half_angle_rad) : 0)}));

  const picture = svg('svg', {class: 'sphere', viewBox: '-175 -175 350 350', tabindex: 0, role: 'img', 'aria-label': `Normals of ${planes.length} plane faces of the model, ${pairs.length} of them with a measured one`});
  const turn = {azimuth: -0.67, elevation: 0.5};
  const draw = () => {
    const view = new Vector3(Math.cos(turn.elevation) * Math.cos(turn.azimuth), Math.cos(turn.elevation) * Math.sin(turn.azimuth), Math.sin(turn.elevation));
    const right = new Vector3(-Math.sin(turn.azimuth), Math.cos(turn.azimuth), 0);
    const up = view.clone().cross(right);
    const rows = new Matrix4().set(right.x, right.y, right.z, 0, -up.x, -up.y, -up.z, 0, view.x, view.y, view.z, 0, 0, 0, 0, 1);
    const seen = (p) => p.clone().applyMatrix4(rows);
    const path = (points) => points.map((p, k) => `${k ? 'L' : 'M'}${p.x.toFixed(1)} ${p.y.toFixed(1)}`).join('');
    const shapes = [svg('circle', {class: 'globe', r: kRadius})];
    // Parallels and meridians, the front half of each.
    const grid = [-0.5, 0, 0.5].map((h) => circle(new Vector3(0, 0, 1), h)).concat([0, 1, 2, 3].map((k) => circle(new Vector3(Math.cos((k * Math.PI) / 4), Math.sin((k * Math.PI) / 4), 0), 0)));
    const front = (points) => {
      let d = '';
      let drawing = false;
      for (const p of points.map((q) => seen(q).multiplyScalar(kRadius))) {
        if (p.z >= 0) d += `${drawing ? 'L' : 'M'}${p.x.toFixed(1)} ${p.y.toFixed(1)}`;
        drawing = p.z >= 0;
      }
      return d;
    };
    for (const points of grid) shapes.push(svg('path', {class: 'grid', d: front(points)}));
    for (const ring of rings) shapes.push(svg('path', {class: `ring${ring.id === selection.id ? ' chosen' : ''}`, d: front(ring.points), 'data-face': ring.id}));
    const items = [];
    for (const pin of pins) {
      const [a, b] = [seen(pin.normal.clone().multiplyScalar(pin.from + 1)), seen(pin.normal.clone().multiplyScalar(pin.to - 1))];
      const isBehind = a.z < 0;
      const kind = `pin ${pin.face.verdict}${isBehind ? ' behind' : ''}${pin.face.id === selection.id ? ' chosen' : ''}`;
      const says = `face ${pin.face.id}: ${number(pin.face.area_mm2, 0)} mm²`;
      items.push([a.z, svg('path', {class: kind, d: path([a, b]), 'data-face': pin.face.id}, svg('title', {}, says))]);
      if (pin.face.id === selection.id) items.push([200, svg('text', {class: 'name', x: b.x * 1.06, y: b.y * 1.06, 'text-anchor': 'middle'}, `${pin.face.id}`)]);
    }
    for (const end of ends) {
      const [a, b] = [seen(end.model), seen(end.at)];
      const isBehind = b.z < 0 ? ' behind' : '';
      items.push([b.z, svg('path', {class: `link${isBehind}`, d: path([a, b])})]);
      items.push([b.z + 1, svg('circle', {class: `measured${isBehind}${end.id === selection.id ? ' chosen' : ''}`, cx: b.x, cy: b.y, r: 4, 'data-face': end.id}, svg('title', {}, `face ${end.id} as measured, ${number(1e3 * end.angle, 3)} mrad from the model`))]);
    }
    for (const m of loose) {
      const p = seen(new Vector3(...m.normal).multiplyScalar(kRadius));
      items.push([p.z, svg('path', {class: `loose${p.z < 0 ? ' behind' : ''}`, d: `M${p.x - 5} ${p.y - 5}L${p.x + 5} ${p.y + 5}M${p.x - 5} ${p.y + 5}L${p.x + 5} ${p.y - 5}`}, svg('title', {}, `a measured face that the model does not have, ${number(m.area_mm2, 0)} mm²`))]);
    }
    items.sort((a, b) => a[0] - b[0]);
    const behind = items.filter(([z]) => z < 0).map((item) => item[1]);
    picture.replaceChildren(...behind, ...shapes, ...items.filter(([z]) => z >= 0).map((item) => item[1]));
  };

  let pressed = null;
  picture.addEventListener('pointerdown', (event) => {
    pressed = {x: event.clientX, y: event.clientY, ...turn, moved: false};
    picture.setPointerCapture(event.pointerId);
  });
  picture.addEventListener('pointermove', (event) => {
    if (!pressed) return;
    const [dx, dy] = [event.clientX - pressed.x, event.clientY - pressed.y];
    if (Math.hypot(dx, dy) > 4) pressed.moved = true;
    if (!pressed.moved) return;
    turn.azimuth = pressed.azimuth - dx / 120;
    turn.elevation = Math.min(1.5, Math.max(-1.5, pressed.elevation + dy / 120));
    draw();
  });
  picture.addEventListener('pointerup', (event) => {
    const was = pressed;
    pressed = null;
    if (was?.moved) return;
    const target = document.elementFromPoint(event.clientX, event.clientY)?.closest('[data-face]');
    if (target && picture.contains(target)) selection.choose(Number(target.dataset.face), 'sphere');
  });
  picture.addEventListener('keydown', (event) => {
    const [across, tilt] = {ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, 0.15], ArrowDown: [0, -0.15]}[event.key] ?? [];
    if (across === undefined) return;
    turn.azimuth += across;
    turn.elevation = Math.min(1.5, Math.max(-1.5, turn.elevation + tilt));
    event.preventDefault();
    draw();
  });
  selection.listen(draw);
  section.replaceChildren(html('h2', {}, 'Sphere of normals'),
    html('p', {}, `Each needle is a plane face of the model along its normal, as long as its area is large, faces of one direction end to end. Dots are the measured faces, linked to the model’s; their angles to it (at most ${number(1e3 * largest, 3)} mrad) are drawn ${factor.toLocaleString('en')} times as large. A cross is a measured face that the model does not have${rings.length ? ', a ring the normals of a cylinder or cone' : ''}. Drag, or use the arrow keys, to turn.`),
    picture);
  draw();
}
