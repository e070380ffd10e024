// Draws arrows of displacement along the surface or of traction.

import { fit } from './pictures.js';

export const KINDS = ['shear', 'traction', 'none'];

/** Draws the arrows; returns what the longest one stands for, or null if there are none. */
export function drawArrows(canvas, fields, kind) {
  if (kind === 'none') return null;
  const { arrowColumns: columns, arrowRows: rows, shift, traction } = fields, { context, width, height, scale } = fit(canvas);
  const parts = kind === 'shear' ? 2 : 3, values = kind === 'shear' ? shift : traction;
  let longest = 0;
  for (let i = 0; i < columns * rows; i++) {
    const length = Math.hypot(values[parts * i], values[parts * i + 1]);
    if (length > longest) longest = length;
  }
  const least = kind === 'shear' ? (fields.isDisplacement ? 0.5 : 0.02) : 0.002;
  const pitch = Math.min(width / columns, height / rows), factor = (1.3 * pitch) / Math.max(longest, 10 * least);
  const path = new Path2D();
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const i = row * columns + column, x = values[parts * i], y = values[parts * i + 1], length = Math.hypot(x, y);
      if (!(length > least)) continue;
      arrow(path, ((column + .5) * width) / columns, ((row + .5) * height) / rows, x * factor, y * factor, 3 * scale);
    }
  }
  for (const [style, line] of [['#000', 3], ['#fff', 1.3]]) {
    context.strokeStyle = style; context.lineWidth = line * scale; context.lineCap = 'round'; context.stroke(path);
  }
  return longest > least ? longest : null;
}

function arrow(path, x, y, dx, dy, head) {
  const length = Math.hypot(dx, dy), tip = Math.min(head, .6 * length), ux = dx / length, uy = dy / length;
  const ex = x + dx, ey = y + dy;
  path.moveTo(x, y); path.lineTo(ex, ey);
  path.moveTo(ex - tip * (ux + .6 * uy), ey - tip * (uy - .6 * ux)); path.lineTo(ex, ey);
  path.lineTo(ex - tip * (ux - .6 * uy), ey - tip * (uy + .6 * ux));
}
