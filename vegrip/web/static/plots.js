// The last half minute of one finger, one plot below the other on one axis of time.
/* global uPlot */
const QUANTITIES = [
  { name: "margin", label: "margin [1]", scale: 1, low: "bound", range: [0, 1], wanted: true },
  { name: "normal_force", label: "N [N]", scale: 1, other: "command", floor: 0 },
  { name: "contact_radius", label: "a [mm]", scale: 1e3, floor: 0 },
  { name: "pressure_exponent", label: "k [1]", scale: 1, floor: 1 },
  { name: "friction_coefficient", label: "mu [1]", scale: 1, floor: 0 },
];
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export class Plots {
  constructor(root) {
    this.root = root;
    this.plots = [];
    this.ranges = QUANTITIES.map(() => [0, 1]);
    new ResizeObserver(() => this.resize()).observe(root);
  }

  build(layout) {
    this.layout = layout;
    this.plots.forEach((one) => one.destroy());
    this.root.replaceChildren();
    const ink = colour("--soft"), grid = { stroke: colour("--line"), width: 1 };
    const blue = colour("--blue"), band = colour("--band"), orange = colour("--orange");
    this.plots = QUANTITIES.map((quantity, i) => {
      const last = i === QUANTITIES.length - 1, div = document.createElement("div");
      div.className = last ? "plot last" : "plot";
      this.root.append(div);
      const series = [{}, { stroke: "transparent" }, { stroke: "transparent" }, { stroke: blue, width: 2 }, { stroke: orange, width: 1.5, dash: [6, 4] }];
      series.slice(1).forEach((one) => Object.assign(one, { points: { show: false }, spanGaps: false }));
      return new uPlot({
        width: this.root.clientWidth, height: last ? 152 : 128, series, bands: [{ series: [2, 1], fill: band }],
        legend: { show: false }, cursor: { show: false }, padding: [8, 8, 0, 0],
        scales: { x: { time: false, range: [-30, 0] }, y: { range: () => this.ranges[i] } },
        axes: [
          { stroke: ink, grid, ticks: grid, size: last ? 40 : 16, label: last ? "time [s]" : undefined, labelSize: 16, labelFont: "12px system-ui", font: "11px system-ui", values: last ? undefined : () => [] },
          { stroke: ink, grid, ticks: grid, size: 64, label: quantity.label, labelSize: 18, labelFont: "12px system-ui", font: "11px system-ui", space: 24 },
        ],
      }, [[], [], [], [], []], div);
    });
  }

  resize() {
    this.plots.forEach((one, i) => one.setSize({ width: this.root.clientWidth, height: i === this.plots.length - 1 ? 152 : 128 }));
  }

  // columns: those of one finger, oldest first; wanted: the margin that is wanted.
  draw(columns, wanted) {
    const { names, bands, period } = this.layout, count = columns.length;
    const t = columns.map((_, i) => (i - count + 1) * period);
    const part = (name, which, scale) => {
      const at = 3 * names.indexOf(name) + which;
      return bridged(columns.map((one) => (one[at] == null ? null : one[at] * scale)));
    };
    QUANTITIES.forEach((quantity, i) => {
      const value = part(quantity.name, 2, quantity.scale);
      let low, high;
      if (quantity.low) {
        low = part(quantity.low, 0, 1);
        high = part(quantity.name, 1, 1);
      } else {
        const least = part(quantity.name, 0, quantity.scale), most = part(quantity.name, 1, quantity.scale);
        const at = 3 * names.length + bands.indexOf(quantity.name);
        let std = 0;
        const two = columns.map((one) => 2 * quantity.scale * (std = one[at] ?? std));
        low = least.map((v, j) => (v == null ? null : Math.max(v - two[j], Math.min(v, quantity.floor)))); // none is below
        high = most.map((v, j) => (v == null ? null : v + two[j]));
      }
      const other = quantity.wanted ? t.map(() => wanted) : quantity.other ? part(quantity.other, 2, 1) : t.map(() => null);
      this.ranges[i] = quantity.range ? [Math.max(-1, Math.min(0, leastOf(low))), 1] : spread([...value, ...other], [...low, ...high]);
      this.plots[i].setData([t, low, high, value, other]);
    });
  }
}

const PATIENCE = 12; // columns: half a second; a longer gap is shown as one
// Values with short gaps bridged by what came before them: a slow node says nothing in many a column.
const bridged = (values) => {
  let last = null, since = 0;
  return values.map((value) => {
    if (value != null) { last = value; since = 0; return value; }
    since += 1;
    return since <= PATIENCE ? last : null;
  });
};

const present = (values) => values.filter((v) => v != null);
const leastOf = (values) => Math.min(0, ...present(values));

// The range of an axis: all values, and of their band what is no more than half of the largest of them away.
const spread = (values, band) => {
  const all = present(values);
  if (!all.length) return [0, 1];
  const low = Math.min(...all), high = Math.max(...all), far = 0.5 * Math.max(Math.abs(low), Math.abs(high));
  const near = present(band).map((v) => Math.min(Math.max(v, low - far), high + far));
  const least = Math.min(low, ...near), most = Math.max(high, ...near);
  const middle = (least + most) / 2, half = Math.max((most - least) / 2, 0.05 * Math.abs(middle), 1e-6) * 1.12;
  return [middle - half, middle + half];
};
