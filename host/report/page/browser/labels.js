// SPDX-License-Identifier: GPL-3.0-or-later
// Short texts over the picture, each at a place of the part.
import {html} from './elements.js';

export class Labels {
  constructor(layer) {
    this.layer = layer;
    this.labels = [];
  }

  /** Each: place, text, kind; normal of the surface there, key, isChosen where there are any. */
  set(labels) {
    this.labels = labels.map((label) => ({...label, element: html('span', {class: `label ${label.kind}${label.isChosen ? ' chosen' : ''}`, 'data-key': label.key}, label.text)}));
    this.layer.replaceChildren(...this.labels.map((label) => label.element));
  }

  place(camera, stage) {
    const towards = camera.position.clone().normalize();
    camera.getWorldDirection(towards).negate();
    for (const {place, normal, element} of this.labels) {
      const at = place.clone().project(camera);
      element.style.left = `${((at.x + 1) / 2) * stage.clientWidth}px`;
      element.style.top = `${((1 - at.y) / 2) * stage.clientHeight}px`;
      element.classList.toggle('behind', Boolean(normal) && normal.dot(towards) < 0);
    }
  }

  flash(key) {
    for (const {element} of this.labels) element.classList.toggle('chosen', element.dataset.key === key);
  }
}
