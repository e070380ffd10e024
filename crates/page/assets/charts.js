// Curves of the last minute.

const WINDOW_S = 60;
const HEIGHT = 150;
const TICKS_S = [-60, -50, -40, -30, -20, -10, 0];

const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** The charts of a sensor: title, unit, and for each curve its name, its value in a row of numbers, and its dashes. */
const CHARTS = [
  { title: 'Force', unit: 'N', curves: [['z (pressing)', row => row.force_n?.[2]], ['x', row => row.force_n?.[0], [6, 3]], ['y', row => row.force_n?.[1], [2, 3]]] },
  { title: 'Depth', unit: 'mm', curves: [['largest depth', row => row.depth_mm]] },
  { title: 'Contact and torque', unit: 'mm², N mm', curves: [['area, mm²', row => row.area_mm2], ['torque, N mm', row => row.torque_nmm, [6, 3]]] },
  { title: 'Time from capture to reading', unit: 'ms', curves: [['ms', row => 1000 * (row.ready_s - row.captured_s)]] },
];

/** Draws the numbers of one sensor over time. */
export class Charts {
  constructor(parent) {
    this.parent = parent;
    this.make();
    new ResizeObserver(() => this.charts.forEach(({ plot, box }) => plot.setSize({ width: Math.max(120, box.clientWidth), height: HEIGHT }))).observe(parent);
  }

  /** Makes the charts anew, as after a change of colours. */
  make() {
    this.charts?.forEach(({ plot }) => plot.destroy());
    this.parent.textContent = '';
    this.charts = CHARTS.map(chart => {
      const box = document.createElement('div'), title = document.createElement('h3');
      box.className = 'chart'; title.textContent = `${chart.title}, ${chart.unit}`;
      box.append(title); this.parent.append(box);
      const axis = { stroke: css('--faint'), grid: { stroke: css('--line'), width: 1 }, ticks: { stroke: css('--line') }, font: '11px system-ui' };
      const series = chart.curves.map(([label, , dash], index) => ({
        label, dash, stroke: css(`--chart-${index + 1}`), width: 1.6, points: { show: false }, spanGaps: false,
        value: (_, value) => (value == null ? '–' : value.toFixed(2)),
      }));
      const plot = new uPlot({
        width: Math.max(120, box.clientWidth), height: HEIGHT, cursor: { y: false }, legend: { live: true },
        scales: { x: { time: false, range: () => [this.end - WINDOW_S, this.end] } },
        axes: [{ ...axis, splits: () => TICKS_S.map(tick => this.end + tick), values: (_, places) => places.map(place => `${Math.round(place - this.end)} s`) }, { ...axis, size: 46 }],
        series: [{ label: 'time', value: (_, value) => (value == null ? '–' : `${(value - this.end).toFixed(1)} s`) }, ...series],
      }, chart.curves.map(() => []).concat([[]]), box);
      return { chart, plot, box };
    });
  }

  /** Shows rows up to the time `end`, s. */
  draw(rows, end) {
    this.end = end;
    // More points than pixels are not seen.
    const skip = Math.max(1, Math.ceil(rows.length / 1500)), shown = skip > 1 ? rows.filter((_, index) => index % skip === 0) : rows;
    const times = shown.map(row => row.captured_s);
    for (const { chart, plot } of this.charts) {
      plot.setData([times, ...chart.curves.map(([, value]) => shown.map(row => value(row) ?? null))]);
    }
  }
}
Charts.WINDOW_S = WINDOW_S;
