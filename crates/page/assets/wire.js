// Reads the binary message with the fields of one reading. The format is described in docs/live.md.

const HEADER = 64;
export const NOT_VALID = -32768;

const padded = bytes => (bytes + 3) & ~3;

/** The fields of a message, as views of its bytes; null if it is something else. */
export function fieldsOf(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < HEADER || view.getUint32(0, true) !== 1) return null;
  const columns = view.getUint32(32, true), rows = view.getUint32(36, true);
  const arrowColumns = view.getUint32(48, true), arrowRows = view.getUint32(52, true);
  const cells = columns * rows, arrows = arrowColumns * arrowRows, pictureBytes = view.getUint32(56, true);
  let at = HEADER;
  const next = bytes => { const begin = at; at += padded(bytes); return begin; };
  const values = new Int16Array(buffer, next(2 * cells), cells);
  const contact = new Uint8Array(buffer, next(cells), cells);
  const shift = new Float32Array(buffer, next(8 * arrows), 2 * arrows);
  const traction = new Float32Array(buffer, next(12 * arrows), 3 * arrows);
  const picture = pictureBytes > 0 ? new Uint8Array(buffer, next(pictureBytes), pictureBytes) : null;
  return {
    sensor: view.getUint32(4, true), sequence: view.getFloat64(8, true),
    captured: view.getFloat64(16, true), ready: view.getFloat64(24, true),
    columns, rows, step: view.getFloat32(40, true), isDisplacement: view.getUint32(44, true) === 1,
    values, contact, arrowColumns, arrowRows, shift, traction,
    picture, isWholeFrame: view.getUint32(60, true) === 1, bytes: buffer.byteLength,
  };
}

/** The value of a cell, mm or px; null where it is not valid. */
export function valueAt(fields, column, row) {
  const steps = fields.values[row * fields.columns + column];
  return steps === undefined || steps === NOT_VALID ? null : steps * fields.step;
}
