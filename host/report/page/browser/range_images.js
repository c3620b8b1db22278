// SPDX-License-Identifier: GPL-3.0-or-later
// For each view a picture of measured less model along the beams. Colours as everywhere: orange where material is in
// excess (nearer than the model), blue where it is missing.
import {kDiverging, colourAt} from './colours.js';
import {html, number} from './elements.js';

const kNoModel = [122, 31, 160];
const kFrame = [20, 20, 20];
const kTallest = 230; // of a picture, in pixels of the page
const kShades = 512; // of the diverging scale, from end to end

/** Colours as a canvas stores them, one number each: red, green, blue and full opacity from the lowest byte up. */
const word = ([r, g, b]) => ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
const kRamp = Uint32Array.from({length: kShades + 1}, (_, k) => word(colourAt(kDiverging, (2 * k) / kShades - 1)));

function paint(canvas, {width, height, beyond, faces}, fullColour, chosen) {
  const context = canvas.getContext('2d');
  const pixels = context.createImageData(width, height);
  const words = new Uint32Array(pixels.data.buffer);
  const isOther = (x, y) => x < 0 || y < 0 || x >= width || y >= height || faces[y * width + x] !== chosen;
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const k = y * width + x;
      if (beyond[k] === Infinity) continue;
      const isRim = chosen && faces[k] === chosen && (isOther(x - 1, y) || isOther(x + 1, y) || isOther(x, y - 1) || isOther(x, y + 1));
      if (isRim) words[k] = word(kFrame);
      else if (beyond[k] === -Infinity) words[k] = word(kNoModel);
      else words[k] = kRamp[Math.round((Math.min(1, Math.max(-1, -beyond[k] / fullColour)) + 1) * (kShades / 2))];
    }
  }
  context.putImageData(pixels, 0, 0);
}

export function rangeImages(section, data, selection, scale) {
  if (!data.images.length) return;
  const severalScans = data.images.some((image) => image.scan > 1);
  const repaints = [];
  const figures = data.images.map((image) => {
    const canvas = html('canvas', {width: image.width, height: image.height, role: 'img'});
    const shown = image.views.length > 4 ? `${image.views.slice(0, 3).join(', ')} … ${image.views.at(-1)}` : image.views.join(', ');
    const name = `${severalScans ? `Scan ${image.scan}, view` : 'View'}${image.views.length > 1 ? 's' : ''} ${shown}`;
    canvas.style.maxWidth = `${(kTallest * image.width) / image.height}px`;
    const numbers = `mean ${number(image.mean_mm, 3, true)}, rms ${number(image.rms_mm, 3)} mm, ${image.rays} rays`;
    canvas.setAttribute('aria-label', `${name}: ${numbers}`);
    const off = image.rays - image.on_model;
    const caption = html('figcaption', {}, html('b', {}, name), html('br'), numbers, off ? html('span', {class: 'quiet'}, `, ${off} where the model has nothing`) : null);
    const pixelAt = (event) => {
      const box = canvas.getBoundingClientRect();
      const x = Math.floor(((event.clientX - box.left) / box.width) * image.width);
      const y = Math.floor(((event.clientY - box.top) / box.height) * image.height);
      return Math.min(image.height - 1, Math.max(0, y)) * image.width + Math.min(image.width - 1, Math.max(0, x));
    };
    canvas.addEventListener('pointermove', (event) => {
      const k = pixelAt(event);
      const beyond = image.beyond[k];
      canvas.title = beyond === Infinity ? '' : beyond === -Infinity ? 'a point where the model has nothing' : `face ${image.faces[k]}: ${number(beyond, 3, true)} mm`;
    });
    canvas.addEventListener('click', (event) => selection.choose(image.faces[pixelAt(event)], 'view'));
    const repaint = () => paint(canvas, image, scale.fullColour, selection.id);
    repaint();
    repaints.push(repaint);
    return html('figure', {class: 'view'}, canvas, caption);
  });
  section.replaceChildren(html('h2', {}, 'Range errors, as seen'),
    html('p', {}, 'Measured less model along each beam, as the machine saw the part from each of its places; + is farther than the model. Orange: nearer, material in excess. Blue: farther, material missing. Purple: a point where the model has nothing. Colours as in the picture of the part; about the rims of faces single beams slip past an edge.'),
    html('div', {class: 'views'}, figures));
  const all = () => repaints.forEach((repaint) => repaint());
  selection.listen(all);
  scale.listen(all);
}
