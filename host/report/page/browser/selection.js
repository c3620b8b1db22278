// SPDX-License-Identifier: GPL-3.0-or-later
// The one face that picture, table, panel, views and sphere show together.

export class Selection {
  constructor(ids) {
    this.ids = new Set(ids);
    this.id = 0; // 0: none
    this.listeners = [];
  }

  /** `listener(id, source)` is called after each change; `source` says who made it. */
  listen(listener) {
    this.listeners.push(listener);
  }

  choose(id, source) {
    const next = this.ids.has(id) ? id : 0;
    this.id = next;
    for (const listener of this.listeners) listener(next, source);
  }
}
