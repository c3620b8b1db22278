// SPDX-License-Identifier: GPL-3.0-or-later
// Reads what host/report/page/page_data.cpp wrote. Lengths in mm, model frame; NaN where nothing was measured.

const kNone = -32768;
const kAbove = 32767;

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

const uint16 = (base64) => new Uint16Array(bytesOf(base64).buffer);

/** Steps to mm; what the writer calls infinite stays so. */
function lengths(base64, unit) {
  const steps = new Int16Array(bytesOf(base64).buffer);
  const out = new Float32Array(steps.length);
  for (let i = 0; i < steps.length; ++i) {
    const s = steps[i];
    out[i] = s === kNone ? NaN : s === kAbove ? Infinity : s === -kAbove ? -Infinity : s * unit;
  }
  return out;
}

/** Shares of the box to mm: x, y, z, x, y, z ... */
function places(base64, [low, high]) {
  const shares = uint16(base64);
  const out = new Float32Array(shares.length);
  for (let i = 0; i < shares.length; ++i) out[i] = low[i % 3] + (shares[i] / 65535) * (high[i % 3] - low[i % 3]);
  return out;
}

export function readData() {
  const raw = JSON.parse(document.getElementById('data').textContent);
  const {box_mm: box, unit_mm: unit} = raw;
  const faces = new Map();
  raw.report.faces.forEach((face, k) => faces.set(face.id, {...face, ...raw.normals.model[k], histogram: raw.histograms[k]}));
  return {
    report: raw.report,
    part: raw.part_mm,
    limit: raw.limit_mm,
    hasLimits: raw.has_limits,
    faces,
    measured: raw.normals.measured,
    mesh: {
      places: places(raw.mesh.places, box),
      faces: uint16(raw.mesh.faces),
      deviations: lengths(raw.mesh.deviations, unit),
      triangles: uint16(raw.mesh.triangles),
      coarser: raw.mesh.coarser,
    },
    points: {
      all: raw.points.all,
      shown: raw.points.shown,
      outside: raw.points.outside,
      places: places(raw.points.places, box),
      deviations: lengths(raw.points.deviations, unit),
      faces: uint16(raw.points.faces),
    },
    extraPatches: raw.extra_patches.map((patch) => places(patch, box)),
    images: raw.images.map((image) => ({...image, beyond: lengths(image.beyond, unit), faces: uint16(image.faces)})),
  };
}
