// SPDX-License-Identifier: GPL-3.0-or-later
// Short texts over the picture, each at a place of the part.
import {Vector3} from 'three';
import {html} from './elements.js';

export class Labels {
  constructor(layer) {
    this.layer = layer;
    this.labels = [];
  }

  /** Each: place, text, kind; normal of the surface there, key, isChosen where there are any. The first come first. */
  set(labels) {
    this.labels = labels.map((label) => ({...label, element: html('span', {class: `label ${label.kind}${label.isChosen ? ' chosen' : ''}`, 'data-key': label.key}, label.text)}));
    this.labels.sort((a, b) => Boolean(b.isChosen) - Boolean(a.isChosen));
    this.layer.replaceChildren(...this.labels.map((label) => label.element));
    for (const label of this.labels) label.size = [label.element.offsetWidth, label.element.offsetHeight];
  }

  place(camera, [across, down]) {
    const towards = new Vector3();
    camera.getWorldDirection(towards).negate();
    const taken = [];
    for (const {place, normal, element, size: [width, height]} of this.labels) {
      const at = place.clone().project(camera);
      const [x, y] = [((at.x + 1) / 2) * across, ((1 - at.y) / 2) * down];
      element.style.left = `${x}px`;
      element.style.top = `${y}px`;
      const isBehind = Boolean(normal) && normal.dot(towards) < 0;
      // One that would lie over another is only a dot.
      const box = [x - width / 2, y - 1.4 * height, x + width / 2, y];
      const isFree = taken.every((other) => box[2] < other[0] || box[0] > other[2] || box[3] < other[1] || box[1] > other[3]);
      const isShown = element.classList.contains('chosen') || (isFree && !isBehind);
      if (isShown) taken.push(box);
      element.classList.toggle('crowded', !isShown);
      element.classList.toggle('behind', isBehind);
    }
  }

  flash(key) {
    for (const {element} of this.labels) element.classList.toggle('chosen', element.dataset.key === key);
  }
}
