// Colours of depth: perceptually uniform from dark blue (zero) to yellow, readable with every kind of colour vision
// (the stops of the map cividis). A bulge, below zero, turns to pink. Cells without a value are transparent.

const UP = ['00224e', '123570', '3b496c', '575d6d', '707173', '8a8678', 'a59c74', 'c3b369', 'e1cc55', 'fee838'];
const DOWN = ['00224e', '4a2260', '8f3f7d', 'd873a0', 'ffb3cf'];
const SIZE = 256;

const channels = hex => [0, 2, 4].map(at => parseInt(hex.slice(at, at + 2), 16));

function table(stops) {
  const colours = stops.map(channels), out = new Uint8Array(3 * SIZE);
  for (let i = 0; i < SIZE; i++) {
    const place = (i / (SIZE - 1)) * (colours.length - 1), below = Math.min(Math.floor(place), colours.length - 2);
    for (let c = 0; c < 3; c++) {
      out[3 * i + c] = Math.round(colours[below][c] + (place - below) * (colours[below + 1][c] - colours[below][c]));
    }
  }
  return out;
}

const up = table(UP), down = table(DOWN);

/** Writes the colour of a value between −1 and 1 to four bytes. */
export function colour(value, bytes, at) {
  const [map, part] = value < 0 ? [down, -value] : [up, value];
  const index = 3 * Math.min(SIZE - 1, Math.round(part * (SIZE - 1)));
  bytes[at] = map[index]; bytes[at + 1] = map[index + 1]; bytes[at + 2] = map[index + 2]; bytes[at + 3] = 255;
}

/** Draws the colours from `least` to `most` from left to right. */
export function drawBar(canvas, least, most) {
  const width = 256, image = new ImageData(width, 1), largest = Math.max(most, -least, 1e-9);
  for (let x = 0; x < width; x++) colour((least + (x / (width - 1)) * (most - least)) / largest, image.data, 4 * x);
  canvas.width = width; canvas.height = 1;
  canvas.getContext('2d').putImageData(image, 0, 0);
}

/** All colours from −1 to 1, for the surface's texture. */
export function textureBytes() {
  const bytes = new Uint8Array(4 * 2 * SIZE);
  for (let i = 0; i < 2 * SIZE; i++) colour((i - SIZE) / (SIZE - 1), bytes, 4 * i);
  return bytes;
}
