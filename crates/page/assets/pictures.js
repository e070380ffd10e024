// Draws the camera's image and the map of depth, with the outline of contact.

import { colour } from './colours.js';
import { NOT_VALID } from './wire.js';

/** Makes a canvas as large as it is shown; returns its context and size. */
export function fit(canvas) {
  const scale = Math.min(window.devicePixelRatio || 1, 2);
  const width = Math.round(canvas.clientWidth * scale), height = Math.round(canvas.clientHeight * scale);
  if (width > 0 && (canvas.width !== width || canvas.height !== height)) { canvas.width = width; canvas.height = height; }
  return { context: canvas.getContext('2d'), width: canvas.width, height: canvas.height, scale };
}

/** Draws values from −largest to largest as colours. */
export function drawMap(canvas, fields, largest, scratch) {
  const { columns, rows, values, step } = fields, { context, width, height } = fit(canvas);
  if (scratch.width !== columns || scratch.height !== rows) { scratch.width = columns; scratch.height = rows; }
  const image = new ImageData(columns, rows);
  for (let i = 0; i < values.length; i++) {
    if (values[i] !== NOT_VALID) colour((values[i] * step) / largest, image.data, 4 * i);
  }
  scratch.getContext('2d').putImageData(image, 0, 0);
  context.clearRect(0, 0, width, height);
  context.drawImage(scratch, 0, 0, width, height);
}

/** Draws the outline of contact: white with a dark edge, so that it is seen on every colour. */
export function drawOutline(canvas, fields) {
  const { columns, rows, contact } = fields, { context, width, height, scale } = fit(canvas);
  const sx = width / columns, sy = height / rows, path = new Path2D();
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) {
      const inside = contact[y * columns + x];
      if (x + 1 < columns && inside !== contact[y * columns + x + 1]) { path.moveTo((x + 1) * sx, y * sy); path.lineTo((x + 1) * sx, (y + 1) * sy); }
      if (y + 1 < rows && inside !== contact[(y + 1) * columns + x]) { path.moveTo(x * sx, (y + 1) * sy); path.lineTo((x + 1) * sx, (y + 1) * sy); }
    }
  }
  for (const [style, line] of [['#000', 3.5], ['#fff', 1.6]]) {
    context.strokeStyle = style; context.lineWidth = line * scale; context.lineCap = 'round'; context.stroke(path);
  }
}

/** Draws the part of the camera's image that the fields show. */
export function drawPicture(canvas, bitmap, region, frameSize) {
  const { context, width, height } = fit(canvas);
  const sx = bitmap.width / frameSize[0], sy = bitmap.height / frameSize[1];
  context.drawImage(bitmap, region[0] * sx, region[1] * sy, region[2] * sx, region[3] * sy, 0, 0, width, height);
}
