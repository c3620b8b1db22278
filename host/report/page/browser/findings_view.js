// SPDX-License-Identifier: GPL-3.0-or-later
// Missing, misplaced and extra faces and faults of the material, where they are in the picture.
import {ArrowHelper, BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial, SphereGeometry, Vector3} from 'three';
import {patchMaterial} from './materials.js';

const kPurple = 0x6a1b8a;
const kOrange = 0xd55e00;

export function matrixOf({rotation: r, translation_mm: t}) {
  return new Matrix4().set(...r[0], t[0], ...r[1], t[1], ...r[2], t[2], 0, 0, 0, 1);
}

export function addFindings(scene, data, edges, anchors, radius) {
  const material = patchMaterial();
  const labels = [];
  const places = new Map();
  const add = (kind, index, place, text, normal) => {
    places.set(`${kind}${index}`, {place, normal});
    labels.push({place, text, kind, key: `${kind}${index}`});
  };
  const {report} = data;

  report.missing_faces.forEach((id, k) => {
    const anchor = anchors.get(id);
    if (anchor) add('missing', k, anchor.place, `∅ ${id} missing`, anchor.normal);
  });

  // Where the feature was found: its model faces moved by what its own pose is off the part's.
  const T_model_part = matrixOf(report.pose);
  report.misplaced.forEach((feature, k) => {
    const moved = T_model_part.clone().multiply(matrixOf(feature.pose).invert());
    const middle = new Vector3();
    for (const id of feature.faces) {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(Float32Array.from(edges.get(id) ?? []), 3));
      geometry.applyMatrix4(moved);
      const lines = new LineSegments(geometry, new LineBasicMaterial({color: kPurple, depthTest: false, transparent: true}));
      lines.renderOrder = 3;
      scene.add(lines);
      if (anchors.has(id)) middle.addScaledVector(anchors.get(id).place, 1 / feature.faces.length);
    }
    const to = middle.clone().applyMatrix4(moved);
    const shift = to.clone().sub(middle);
    if (shift.length() > 1e-6) {
      const length = Math.max(shift.length(), 0.15 * radius);
      const arrow = new ArrowHelper(shift.clone().normalize(), middle, length, kPurple, 0.05 * radius, 0.03 * radius);
      arrow.line.material.depthTest = arrow.cone.material.depthTest = false;
      arrow.renderOrder = 3;
      scene.add(arrow);
    }
    add('misplaced', k, to, `↦ misplaced ${k + 1}`);
  });

  data.extraPatches.forEach((patch, k) => {
    const extra = report.extra_faces[k];
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(patch, 3));
    scene.add(new Mesh(geometry, material));
    add('extra', k, new Vector3(...extra.point_mm), `+ extra ${k + 1}`, new Vector3(...extra.equation.normal));
  });

  report.material_faults.forEach((fault, k) => {
    const place = new Vector3(...fault.point_mm);
    const ball = new Mesh(new SphereGeometry(0.025 * radius, 16, 12), new MeshBasicMaterial({color: fault.kind === 'missing' ? kOrange : kPurple}));
    ball.position.copy(place);
    scene.add(ball);
    add('material', k, place, fault.kind === 'missing' ? `⊖ missing here` : `⊕ excess here`, anchors.get(fault.face)?.normal);
  });

  return {material, labels, placeOf: (kind, index) => places.get(`${kind}${index}`)};
}
