// SPDX-License-Identifier: GPL-3.0-or-later
// Which deviation has full colour. It starts at twice the limit, so that the limits lie half way.

export class Scale {
  constructor(limit) {
    this.limit = limit;
    this.fullColour = 2 * limit;
    this.listeners = [];
  }
  listen(listener) {
    this.listeners.push(listener);
  }
  change(factor) {
    this.fullColour *= factor;
    for (const listener of this.listeners) listener();
  }
}
