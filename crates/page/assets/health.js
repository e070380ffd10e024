// The problems of a sensor, in words, and the numbers of the current reading.

const HOLD_S = 4; // a flag is shown this long after it was last raised
const SILENT_S = 1;
// With one of these flags all values are useless; with the others some of them may be wrong.
const BAD = new Set(['lost', 'gel-misfit', 'no-texture', 'other-sensor']);

/** The quantile of sorted values below which this part of them lies. */
export const quantile = (sorted, part) => (sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))] : null);

// + 0 turns -0 into 0.
const number = (value, digits) => (value == null || !Number.isFinite(value) ? '–' : (Number(value.toFixed(digits)) + 0).toFixed(digits));

/** The numbers of a row as label, value and unit. */
export function readouts(row, rate, delays) {
  const shear = row?.force_n ? Math.hypot(row.force_n[0], row.force_n[1]) : null;
  return [
    ['Depth', number(row?.depth_mm, 2), 'mm'],
    ['Contact', number(row?.area_mm2, 1), 'mm²'],
    ['Force, pressing', number(row?.force_n?.[2], 2), 'N'],
    ['Force, shear', number(shear, 2), 'N'],
    ['Torque', number(row?.torque_nmm, 1), 'N mm'],
    ['Readings', number(rate, 0), 'per s'],
    ['To reading, p50 / p99', `${number(delays.reading[0], 0)} / ${number(delays.reading[1], 0)}`, 'ms'],
    ['To screen, p50 / p99', `${number(delays.screen[0], 0)} / ${number(delays.screen[1], 0)}`, 'ms'],
  ];
}

/** Exposure and focus of the image, for a person who adjusts the camera. */
export function imageText(row) {
  if (!row) return '\u00a0';
  return `mean level ${number(row.mean_level, 0)} of 255, ${number(100 * row.saturated, 1)} % saturated, focus ${number(row.focus, 0)} % of the best`;
}

/** Sentences on the state of a sensor, each with how serious it is: bad, warn, past or good. */
export function sentences({ row, flagTimes, counts, now, isPast, words }) {
  const out = [];
  if (!row) out.push(['warn', 'no reading yet']);
  else if (!isPast && counts?.is_ended) out.push(['bad', 'the source has ended; these are the last values']);
  else if (!isPast && now - row.captured_s > SILENT_S) out.push(['bad', `no new reading for ${(now - row.captured_s).toFixed(0)} s; the values are old`]);
  for (const flag of row?.flags ?? []) out.push([BAD.has(flag) ? 'bad' : 'warn', words.get(flag) ?? flag]);
  if (!isPast) {
    for (const [flag, time] of flagTimes) {
      if (!row?.flags.includes(flag) && now - time < HOLD_S) out.push(['past', `${words.get(flag) ?? flag}, ${(now - time).toFixed(0)} s ago`]);
    }
  }
  if (out.length === 0) out.push(['good', 'no problem found']);
  if (counts && !isPast) {
    const dropped = [[counts.dropped, 'dropped because tracking was busy'], [counts.dropped_by_camera, 'dropped by the camera'], [counts.damaged, 'damaged']];
    const words = dropped.filter(([count]) => count > 0).map(([count, why]) => `${count} ${why}`);
    if (words.length) out.push(['past', `missing frames so far: ${words.join(', ')}`]);
    if (counts.restarts) out.push(['past', `the camera was started again ${counts.restarts} times`]);
  }
  return out;
}
