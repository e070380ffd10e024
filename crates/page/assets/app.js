// The page: sensors, keys, the slider for the past, and requests to the program.

import { Connection } from './connection.js';
import { KINDS } from './arrows.js';
import { SensorView } from './sensor.js';
import { fieldsOf } from './wire.js';

const MOST_EVENTS = 50;
const $ = id => document.getElementById(id);

let views = [], chosen = null, pausedAt = null, isConnected = false, isRecording = false, signature = '', version = '', denial = '';

const connection = new Connection({
  opened() { isConnected = true; denial = ''; },
  denied(text) { if (denial !== text) tell(text); denial = text; },
  lost() { isConnected = false; },
  hello(hello) { take(hello); },
  readings(rows) { if (pausedAt === null) for (const row of rows) views[row.sensor]?.takeRow(row); },
  fields(buffer) {
    const fields = pausedAt === null ? fieldsOf(buffer) : null;
    if (fields) views[fields.sensor]?.takeFields(fields, connection.now());
  },
  state(state) {
    state.sensors.forEach((counts, index) => { if (views[index]) views[index].counts = counts; });
    isRecording = state.recording !== null;
    $('record').setAttribute('aria-pressed', isRecording);
    $('record').textContent = isRecording ? 'Recording' : 'Record';
    $('recording').textContent = isRecording ? `Recording to ${state.recording[0]}, ${state.recording[2].toFixed(0)} s, ${(state.recording[1] / 1e6).toFixed(1)} MB` : '';
  },
  event({ sensor, text }) { tell(`${views[sensor]?.about.name ?? sensor}: ${text}`); },
  refused(text) { tell(text); },
});

function take(hello) {
  const now = JSON.stringify(hello);
  version = hello.version;
  if (now === signature) { views.forEach(view => view.forget()); return; }
  signature = now;
  const words = new Map(hello.flags);
  views = hello.sensors.map((about, index) => new SensorView(index, about, words));
  $('sensors').replaceChildren(...views.map(view => view.root));
  buildTabs();
  show(views.length > 1 ? null : 0);
}

function buildTabs() {
  const tabs = views.length > 1 ? [['All', null], ...views.map(view => [view.about.name, view.index])] : [];
  $('tabs').replaceChildren(...tabs.map(([name, index]) => {
    const tab = document.createElement('button');
    tab.textContent = name; tab.setAttribute('role', 'tab'); tab.dataset.index = index ?? '';
    tab.addEventListener('click', () => show(index));
    return tab;
  }));
}

function show(index) {
  chosen = index;
  $('sensors').classList.toggle('all', index === null);
  views.forEach(view => { view.root.hidden = index !== null && view.index !== index; view.isDirty = true; view.surface.isDirty = true; });
  for (const tab of $('tabs').children) tab.setAttribute('aria-selected', tab.dataset.index === String(index ?? ''));
}

function tell(text) {
  const item = document.createElement('li');
  item.textContent = `${new Date().toLocaleTimeString()}  ${text}`;
  $('events').prepend(item);
  while ($('events').children.length > MOST_EVENTS) $('events').lastChild.remove();
}

function pause() {
  pausedAt = pausedAt === null ? connection.now() : null;
  $('past').hidden = pausedAt === null; $('time').value = 0;
  $('pause').setAttribute('aria-pressed', pausedAt !== null);
  $('pause').textContent = pausedAt === null ? 'Pause' : 'Continue';
  views.forEach(view => { if (pausedAt === null) view.forget(); view.isDirty = true; });
}

const send = request => { if (!connection.send(request)) tell('the program cannot be reached'); };
const rezero = () => views.forEach(view => { if (chosen === null || chosen === view.index) send({ rezero: view.index }); });
const record = () => send({ record: !isRecording });

function theme() {
  const root = document.documentElement, isDark = matchMedia('(prefers-color-scheme: dark)').matches;
  const next = (root.dataset.theme ?? (isDark ? 'dark' : 'light')) === 'dark' ? 'light' : 'dark';
  root.dataset.theme = next;
  localStorage.setItem('theme', next);
  views.forEach(view => view.charts.make());
}

const KEYS = { ' ': pause, z: rezero, r: record, t: theme, a: () => views.forEach(view => view.nextArrows()), '?': () => $('help').showModal() };

document.addEventListener('keydown', event => {
  const isText = event.target.matches('input, select, dialog *') || (event.key === ' ' && event.target.matches('button'));
  if (isText || event.ctrlKey || event.metaKey || event.altKey) return;
  const digit = Number.parseInt(event.key, 10);
  if (digit >= 0 && views.length > 1 && digit <= views.length) { show(digit === 0 ? null : digit - 1); return; }
  const act = KEYS[event.key.toLowerCase()];
  if (act) { event.preventDefault(); act(); }
});
for (const [id, act] of [['pause', pause], ['rezero', rezero], ['record', record], ['theme', theme], ['keys', () => $('help').showModal()]]) {
  $(id).addEventListener('click', act);
}
const stored = localStorage.getItem('theme');
if (stored) document.documentElement.dataset.theme = stored;
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => views.forEach(view => view.charts.make()));
window.addEventListener('resize', () => views.forEach(view => { view.isDirty = true; view.surface.isDirty = true; }));

function state(now) {
  if (!isConnected) return ['old', denial ? 'Refused' : 'Connection lost'];
  if (pausedAt !== null) return ['past', 'Paused'];
  if (views.length && views.every(view => view.counts?.is_ended)) return ['old', 'Ended'];
  const ages = views.filter(view => view.rows.length).map(view => now - view.rows.at(-1).captured_s);
  if (ages.length === 0) return ['wait', 'Waiting for readings'];
  return Math.max(...ages) > 1 ? ['old', 'Values are old'] : ['live', 'Live'];
}

function draw() {
  requestAnimationFrame(draw);
  const now = connection.now(), [kind, text] = state(now), chip = $('state');
  if (chip.textContent !== text) { chip.textContent = text; chip.dataset.kind = kind; }
  const back = Number($('time').value), at = pausedAt === null ? null : pausedAt + back;
  $('time-text').textContent = back === 0 ? 'when paused' : `${(-back).toFixed(1)} s before`;
  for (const view of views) if (!view.root.hidden) view.draw(at, now);
}
requestAnimationFrame(draw);

// For tests, and for who wants to look inside.
window.fingervision = { get views() { return views; }, get version() { return version; }, connection, kinds: KINDS };
