// SPDX-License-Identifier: GPL-3.0-or-later
// How the part and its points are shaded.
import {DoubleSide, ShaderMaterial} from 'three';
import {kDiverging, glsl} from './colours.js';

/** Modes of the faces' shader. */
export const kByDeviation = 0;
export const kByFace = 1;
export const kPlain = 2;

// Hatching is drawn on the screen, so that its lines are as wide at any zoom.
const kHatch = `
uniform float pixel;
float hatch(float every) { return step(mod(gl_FragCoord.x + gl_FragCoord.y, every * pixel), 1.6 * pixel); }
float crossHatch(float every) { return max(hatch(every), step(mod(gl_FragCoord.x - gl_FragCoord.y, every * pixel), 1.6 * pixel)); }
`;

export function faceMaterial() {
  return new ShaderMaterial({
    side: DoubleSide,
    polygonOffset: true,
    polygonOffsetFactor: 1.5,
    polygonOffsetUnits: 2,
    uniforms: {mode: {value: kByDeviation}, fullColour: {value: 1}, pixel: {value: 1}, chosen: {value: 0}},
    vertexShader: `
      attribute float deviation, known, limit, face, pattern;
      attribute vec3 colour;
      varying float vDeviation, vKnown, vLimit, vFace, vPattern;
      varying vec3 vColour, vNormal;
      void main() {
        vDeviation = deviation; vKnown = known; vLimit = limit; vFace = face; vPattern = pattern; vColour = colour;
        vNormal = normalMatrix * normal;
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
      }`,
    fragmentShader: `
      uniform int mode;
      uniform float fullColour, chosen;
      varying float vDeviation, vKnown, vLimit, vFace, vPattern;
      varying vec3 vColour, vNormal;
      ${kHatch}
      ${glsl('diverging', kDiverging)}
      void main() {
        vec3 c = vColour;
        if (mode == ${kByDeviation}) {
          // About the face's own limits a dark line.
          c = diverging(vDeviation / fullColour);
          float off = abs(abs(vDeviation) - vLimit) / max(fwidth(vDeviation), 1e-9);
          if (vLimit > 0.0 && off < 0.9 * pixel) c = vec3(0.12);
        } else if (mode == ${kPlain}) {
          c = vec3(0.86, 0.87, 0.88);
        }
        if (mode != ${kPlain} && vKnown < 0.5) c = mix(vec3(0.80, 0.81, 0.82), vec3(0.52, 0.54, 0.56), hatch(7.0));
        if (vPattern > 1.5) c = mix(vec3(1.0, 0.93, 0.88), vec3(0.84, 0.37, 0.0), crossHatch(9.0));
        else if (vPattern > 0.5 && mode == ${kByFace}) c = mix(c, c * 0.62, hatch(7.0));
        float light = abs(dot(normalize(vNormal), normalize(vec3(0.35, 0.55, 0.9))));
        c *= 0.70 + 0.30 * light;
        if (chosen > 0.0 && abs(vFace - chosen) > 0.5) c = mix(c, vec3(0.78), 0.22);
        gl_FragColor = vec4(c, 1.0);
      }`,
  });
}

export function pointMaterial() {
  return new ShaderMaterial({
    uniforms: {fullColour: {value: 1}, pixel: {value: 1}, chosen: {value: 0}, towards: {value: 0}},
    vertexShader: `
      attribute float deviation, face;
      uniform float fullColour, pixel, chosen, towards;
      varying vec3 vColour;
      ${glsl('diverging', kDiverging)}
      void main() {
        vColour = face < 0.5 ? vec3(0.45, 0.15, 0.55) : diverging(deviation / fullColour);
        if (chosen > 0.0 && abs(face - chosen) > 0.5) vColour = mix(vColour, vec3(0.75), 0.6);
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
        gl_Position.z -= towards * gl_Position.w; // points just below the surface are seen too
        gl_PointSize = (chosen > 0.0 && abs(face - chosen) < 0.5 ? 3.4 : 2.6) * pixel;
      }`,
    fragmentShader: `
      varying vec3 vColour;
      void main() {
        if (length(gl_PointCoord - 0.5) > 0.5) discard;
        gl_FragColor = vec4(vColour * 0.94, 1.0);
      }`,
  });
}

/** Surfaces that are measured but not the model's: purple, hatched. */
export function patchMaterial() {
  return new ShaderMaterial({
    side: DoubleSide,
    transparent: true,
    polygonOffset: true,
    polygonOffsetFactor: -1,
    polygonOffsetUnits: -2,
    uniforms: {pixel: {value: 1}},
    vertexShader: 'void main() { gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }',
    fragmentShader: `
      ${kHatch}
      void main() { gl_FragColor = mix(vec4(0.60, 0.30, 0.72, 0.55), vec4(0.35, 0.08, 0.48, 0.9), hatch(8.0)); }`,
  });
}
