// SPDX-License-Identifier: GPL-3.0-or-later
// The model's axes in a corner of the picture.
import {Vector3} from 'three';
import {svg} from './elements.js';

export function axesIn(stage) {
  const axes = ['x', 'y', 'z'].map((name, k) => ({
    name,
    direction: new Vector3().setComponent(k, 1),
    line: svg('path', {class: `axis-${name}`}),
    text: svg('text', {'text-anchor': 'middle', 'dominant-baseline': 'central'}, name),
  }));
  stage.append(svg('svg', {class: 'axes', viewBox: '-40 -40 80 80', 'aria-hidden': 'true'}, ...axes.flatMap((axis) => [axis.line, axis.text])));
  return (camera) => {
    const turn = camera.quaternion.clone().invert();
    for (const axis of axes) {
      const at = axis.direction.clone().applyQuaternion(turn);
      axis.line.setAttribute('d', `M0 0L${24 * at.x} ${-24 * at.y}`);
      axis.text.setAttribute('x', 33 * at.x);
      axis.text.setAttribute('y', -33 * at.y);
    }
  };
}
