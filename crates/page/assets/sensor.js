// One sensor on the page: numbers, health, camera image, map, surface and charts, now or at a time in the past.

import { Charts } from './charts.js';
import { drawBar } from './colours.js';
import { drawArrows, KINDS } from './arrows.js';
import { imageText, quantile, readouts, sentences } from './health.js';
import { drawMap, drawOutline, drawPicture } from './pictures.js';
import { Surface } from './surface.js';
import { valueAt } from './wire.js';

const KEEP_S = 60;
const KEEP_EVERY_S = 0.2; // fields that are kept for looking back
const MOST_KEPT_BYTES = 64e6;
const DELAYS_S = 10;
const CHARTS_EVERY_S = 0.1;
const BEST_KEPT = .9975; // of the best sharpness, a second: after a change of gel the best is another one
const LEAST_RANGE = { depth: 0.2, displacement: 2 }; // mm, px

const element = (kind, className, text) => {
  const made = document.createElement(kind);
  if (className) made.className = className;
  if (text !== undefined) made.textContent = text;
  return made;
};

export class SensorView {
  constructor(index, about, words) {
    Object.assign(this, { index, about, words });
    this.rows = []; this.kept = []; this.keptBytes = 0; this.flagTimes = new Map(); this.delays = [];
    this.fields = null; this.bitmap = null; this.largest = 0; this.counts = null; this.best = 0; this.bestTime = 0; this.chartsDrawn = 0; this.isDirty = true;
    this.scratch = document.createElement('canvas');
    this.build();
  }

  build() {
    const root = this.root = element('section', 'sensor'), title = element('div', 'title'), about = this.about;
    root.setAttribute('aria-label', `Sensor ${about.name}`);
    title.append(element('h2', '', about.name), element('p', '', about.description));
    this.numbers = element('dl', 'numbers'); this.health = element('ul', 'health');
    this.health.setAttribute('aria-label', 'Health');
    const panels = element('div', 'panels');
    [this.picture, this.pictureNote] = this.panel(panels, 'Camera', 'camera');
    this.imageNote = element('div', 'bar'); this.picture.closest('.panel').append(this.imageNote);
    [this.map, this.mapNote] = this.panel(panels, about.gel_size_mm ? 'Depth, mm' : 'Displacement, px', 'map');
    const [surface, note] = this.panel(panels, 'Surface, depth doubled', 'surface');
    surface.tabIndex = 0; surface.setAttribute('aria-label', 'Surface; turn it with the arrow keys');
    this.surface = new Surface(surface, sentence => { note.hidden = false; note.textContent = sentence; });
    this.buildTools(); this.buildBar();
    const charts = element('div', 'charts');
    root.append(title, this.numbers, this.health, panels, charts);
    this.charts = new Charts(charts);
    this.map.addEventListener('pointermove', event => this.point(event));
    this.map.addEventListener('pointerleave', () => { this.mapNote.hidden = true; });
  }

  panel(parent, title, name) {
    const panel = element('div', `panel ${name}`), heading = element('h3', '', title), view = element('div', 'view');
    const canvas = element('canvas'), note = element('p', 'note');
    view.style.aspectRatio = `${this.about.size[0]} / ${this.about.size[1]}`;
    note.hidden = true; canvas.setAttribute('role', 'img'); canvas.setAttribute('aria-label', title);
    view.append(canvas, note); panel.append(heading, view); parent.append(panel);
    return [canvas, note, panel];
  }

  buildTools() {
    const panel = this.map.closest('.panel'), tools = element('div', 'tools');
    this.arrows = element('select'); this.arrows.setAttribute('aria-label', 'Arrows');
    for (const kind of KINDS) this.arrows.append(new Option(`arrows: ${kind}`, kind));
    this.arrows.addEventListener('change', () => { this.isDirty = true; });
    tools.append(this.arrows); panel.prepend(tools);
    this.arrowNote = element('div', 'bar'); panel.append(this.arrowNote);
  }

  buildBar() {
    const bar = element('div', 'bar');
    this.barCanvas = element('canvas'); this.barLeast = element('span'); this.barMost = element('span');
    bar.append(this.barLeast, this.barCanvas, this.barMost);
    this.arrowNote.before(bar);
  }

  nextArrows() { this.arrows.selectedIndex = (this.arrows.selectedIndex + 1) % KINDS.length; this.isDirty = true; }

  takeRow(row) {
    const age = Math.max(0, row.captured_s - this.bestTime);
    this.best = Math.max(row.sharpness, this.best * BEST_KEPT ** age); this.bestTime = row.captured_s;
    row.focus = this.best > 0 ? 100 * row.sharpness / this.best : null;
    this.rows.push(row);
    for (const flag of row.flags) this.flagTimes.set(flag, row.captured_s);
    if (this.rows.length > 200 && this.rows[100].captured_s < row.captured_s - KEEP_S) this.rows.splice(0, 100);
  }

  takeFields(fields, now) {
    this.delays.push({ time: now, screen: now - fields.captured });
    while (this.delays.length && this.delays[0].time < now - DELAYS_S) this.delays.shift();
    if (fields.picture) this.lastPicture = fields.picture; else fields.picture = this.lastPicture;
    this.latest = fields;
    const last = this.kept.at(-1);
    if (last && fields.captured - last.captured < KEEP_EVERY_S) return;
    this.kept.push(fields); this.keptBytes += fields.bytes;
    while (this.kept.length > 1 && (this.kept[0].captured < fields.captured - KEEP_S || this.keptBytes > MOST_KEPT_BYTES)) {
      this.keptBytes -= this.kept.shift().bytes;
    }
  }

  /** The sensor starts anew: the program was started again. */
  forget() { this.rows = []; this.kept = []; this.keptBytes = 0; this.latest = null; this.delays = []; this.flagTimes.clear(); }

  /** Draws the state at the time `at`; the present one if it is null. */
  draw(at, now) {
    const isPast = at !== null, rows = isPast ? this.rows.filter(row => row.captured_s <= at) : this.rows, row = rows.at(-1);
    const fields = isPast ? this.kept.findLast(kept => kept.captured <= at) ?? this.kept[0] : this.latest;
    const isOld = !isPast && row && now - row.captured_s > 1;
    this.root.classList.toggle('old', Boolean(isOld));
    if (fields && (fields !== this.fields || this.isDirty)) { this.fields = fields; this.isDirty = false; this.drawFields(fields); }
    this.surface.draw();
    if (now - this.chartsDrawn >= CHARTS_EVERY_S) {
      this.chartsDrawn = now;
      this.drawText(rows, row, isPast, now);
      if (this.charts.parent.offsetParent !== null) this.charts.draw(this.rows, isPast ? at : now);
    }
  }

  drawFields(fields) {
    const kind = fields.isDisplacement ? 'displacement' : 'depth';
    let least = 0, most = 0;
    for (const value of fields.values) if (value > -32768) { if (value < least) least = value; if (value > most) most = value; }
    const found = Math.max(most * fields.step, -least * fields.step, LEAST_RANGE[kind]);
    // The range grows at once and shrinks slowly, so that colours do not flicker.
    this.largest = Math.max(found, .97 * this.largest);
    drawMap(this.map, fields, this.largest, this.scratch);
    drawOutline(this.map, fields);
    const longest = drawArrows(this.map, fields, this.arrows.value), unit = this.arrows.value === 'traction' ? 'MPa' : fields.isDisplacement ? 'px' : 'mm';
    this.arrowNote.textContent = longest === null ? '\u00a0' : `longest arrow ${longest.toFixed(unit === 'px' ? 1 : 3)} ${unit}`;
    const bottom = Math.min(0, least * fields.step);
    drawBar(this.barCanvas, bottom < -.02 * this.largest ? bottom : 0, this.largest);
    this.barLeast.textContent = bottom < -.02 * this.largest ? bottom.toFixed(2) : '0';
    this.barMost.textContent = `${this.largest.toFixed(2)} ${fields.isDisplacement ? 'px' : 'mm'}`;
    const mmPerPx = this.about.mm_per_px ?? 1;
    this.surface.show(fields, this.largest, (mmPerPx * this.about.size[0]) / fields.columns);
    this.drawCamera(fields);
  }

  async drawCamera(fields) {
    if (fields.picture && fields.picture !== this.pictureShown) {
      this.pictureShown = fields.picture;
      try { this.bitmap = await createImageBitmap(new Blob([fields.picture], { type: 'image/jpeg' })); this.pictureNote.hidden = true; }
      catch { this.bitmap = null; this.pictureNote.hidden = false; this.pictureNote.textContent = 'The browser cannot decode this picture.'; }
    }
    if (!this.bitmap) return;
    const whole = [0, 0, ...this.about.frame_size];
    drawPicture(this.picture, this.bitmap, fields.isWholeFrame ? this.about.region : whole, this.about.frame_size);
    drawOutline(this.picture, fields);
  }

  drawText(rows, row, isPast, now) {
    const recent = rows.filter(other => row && other.captured_s > row.captured_s - 2), span = recent.length > 1 ? recent.at(-1).captured_s - recent[0].captured_s : 0;
    const rate = span > 0 ? (recent.length - 1) / span : null;
    const last = rows.slice(-1000).filter(other => row && other.captured_s > row.captured_s - DELAYS_S);
    const sorted = values => values.sort((a, b) => a - b);
    const reading = sorted(last.map(other => 1000 * (other.ready_s - other.captured_s))), screen = sorted(this.delays.map(delay => 1000 * delay.screen));
    const delays = { reading: [quantile(reading, .5), quantile(reading, .99)], screen: isPast ? [null, null] : [quantile(screen, .5), quantile(screen, .99)] };
    replace(this.numbers, readouts(row, rate, delays).map(([label, value, unit]) => {
      const box = element('div'), shown = element('dd', '', `${value} `);
      shown.append(element('small', '', unit)); box.append(element('dt', '', label), shown);
      return box;
    }));
    const image = imageText(row);
    if (this.imageNote.textContent !== image) this.imageNote.textContent = image;
    const state = { row, flagTimes: this.flagTimes, counts: this.counts, now, isPast, words: this.words };
    replace(this.health, sentences(state).map(([kind, text]) => element('li', kind, text)));
  }

  point(event) {
    if (!this.fields) return;
    const box = this.map.getBoundingClientRect(), part = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    const [column, row] = [Math.floor(part[0] * this.fields.columns), Math.floor(part[1] * this.fields.rows)];
    const value = valueAt(this.fields, column, row), unit = this.fields.isDisplacement ? 'px' : 'mm';
    const place = `x ${Math.round(part[0] * this.about.size[0])}, y ${Math.round(part[1] * this.about.size[1])} px`;
    this.mapNote.hidden = false;
    this.mapNote.textContent = value === null ? `${place}: no valid value` : `${place}: ${value.toFixed(3)} ${unit}`;
  }
}

/** Replaces the children if their text has changed, so that a screen reader is not disturbed. */
function replace(parent, children) {
  const text = children.map(child => child.className + child.textContent).join('|');
  if (parent.dataset.text === text) return;
  parent.dataset.text = text;
  parent.replaceChildren(...children);
}
