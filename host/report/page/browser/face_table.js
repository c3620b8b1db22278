// SPDX-License-Identifier: GPL-3.0-or-later
// The table of faces that is in the page already: rows to click, or to walk with the arrow keys.

export function wireFaceTable(selection) {
  const rows = [...document.querySelectorAll('tr[data-face]')];
  const idOf = (row) => Number(row.dataset.face);
  const focusable = (row) => rows.forEach((other) => (other.tabIndex = other === row ? 0 : -1));
  if (rows.length) focusable(rows[0]);

  const go = (row) => {
    if (!row) return;
    selection.choose(idOf(row), 'table');
    row.focus();
  };
  rows.forEach((row, k) => {
    row.addEventListener('click', (event) => {
      event.preventDefault();
      go(row);
    });
    row.addEventListener('keydown', (event) => {
      const next = {ArrowDown: rows[k + 1], ArrowUp: rows[k - 1], Home: rows[0], End: rows[rows.length - 1], Enter: row, ' ': row}[event.key];
      if (event.key === 'Escape') selection.choose(0, 'table');
      else if (next) go(next);
      else return;
      event.preventDefault();
    });
  });
  selection.listen((id, source) => {
    for (const row of rows) {
      const isIt = idOf(row) === id;
      if (isIt) row.setAttribute('aria-current', 'true');
      else row.removeAttribute('aria-current');
      if (!isIt) continue;
      focusable(row);
      if (source !== 'table' && source !== 'start') row.scrollIntoView({block: 'nearest'});
    }
  });
  // "face 14" anywhere in the text.
  document.addEventListener('click', (event) => {
    const link = event.target.closest?.('a[href^="#face-"]');
    if (!link || link.closest('tr[data-face]')) return;
    event.preventDefault();
    selection.choose(Number(link.getAttribute('href').slice(6)), 'link');
  });
}
