// SPDX-License-Identifier: GPL-3.0-or-later
// The model's triangles as three.js wants them, its edges, and a place on each face.
import {BufferAttribute, BufferGeometry, Vector3} from 'three';

/** Normals are averaged within a face alone: its vertices are its own, so edges stay sharp. */
export function partGeometry({mesh, faces}) {
  const geometry = new BufferGeometry();
  const vertices = mesh.faces.length;
  const known = new Float32Array(vertices);
  const deviation = new Float32Array(vertices);
  const limit = new Float32Array(vertices);
  for (let v = 0; v < vertices; ++v) {
    known[v] = Number.isNaN(mesh.deviations[v]) ? 0 : 1;
    deviation[v] = known[v] ? mesh.deviations[v] : 0;
    limit[v] = faces.get(mesh.faces[v])?.limit_mm ?? 0;
  }
  const add = (name, array, size) => geometry.setAttribute(name, new BufferAttribute(array, size));
  add('position', mesh.places, 3);
  add('known', known, 1);
  add('deviation', deviation, 1);
  add('limit', limit, 1);
  add('face', Float32Array.from(mesh.faces), 1);
  add('pattern', new Float32Array(vertices), 1);
  add('colour', new Float32Array(3 * vertices), 3);
  geometry.setIndex(new BufferAttribute(mesh.triangles, 1));
  geometry.computeVertexNormals();
  return geometry;
}

/** Of each face the edges that only one of its triangles has, as x y z of both ends; by id. */
export function faceEdges({mesh}) {
  const uses = new Map();
  const {triangles} = mesh;
  for (let t = 0; t < triangles.length; t += 3) {
    for (let i = 0; i < 3; ++i) {
      const a = triangles[t + i];
      const b = triangles[t + ((i + 1) % 3)];
      const key = a < b ? a * 65536 + b : b * 65536 + a;
      uses.set(key, (uses.get(key) ?? 0) + 1);
    }
  }
  const edges = new Map();
  for (const [key, count] of uses) {
    if (count !== 1) continue;
    const ends = [Math.floor(key / 65536), key % 65536];
    const id = mesh.faces[ends[0]];
    if (!edges.has(id)) edges.set(id, []);
    for (const v of ends) edges.get(id).push(mesh.places[3 * v], mesh.places[3 * v + 1], mesh.places[3 * v + 2]);
  }
  return edges;
}

/** Of each face the middle of the triangle nearest its centroid, and its normal there; by id. */
export function faceAnchors({mesh, faces}) {
  const anchors = new Map();
  const corner = (v) => new Vector3().fromArray(mesh.places, 3 * v);
  for (let t = 0; t < mesh.triangles.length; t += 3) {
    const [a, b, c] = [0, 1, 2].map((i) => corner(mesh.triangles[t + i]));
    const id = mesh.faces[mesh.triangles[t]];
    const face = faces.get(id);
    if (!face) continue;
    const place = a.clone().add(b).add(c).divideScalar(3);
    const distance = place.distanceToSquared(new Vector3(...face.point_mm));
    if (anchors.has(id) && anchors.get(id).distance <= distance) continue;
    anchors.set(id, {place, distance, normal: b.sub(a).cross(c.sub(a)).normalize()});
  }
  return anchors;
}
