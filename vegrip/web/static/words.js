// Numbers and time as a person reads them.
export const dash = "–";
export const number = (value, digits = 2) => (value == null ? dash : value.toFixed(digits));
export const withStd = (one, scale, digits) => {
  if (!one || one.value == null) return dash;
  const spread = one.std == null ? "?" : (one.std * scale).toFixed(digits);
  return `${(one.value * scale).toFixed(digits)} ± ${spread}${one.valid ? "" : " (not valid)"}`;
};
export const ago = (seconds) => {
  if (seconds == null) return "never";
  if (seconds < 60) return `${Number.isInteger(seconds) ? seconds : seconds.toFixed(1)} s`;
  return seconds < 3600 ? `${Math.floor(seconds / 60)} min` : `${Math.floor(seconds / 3600)} h`;
};
export const untilSlip = (margin) => {
  if (!margin) return dash;
  if (margin.never && margin.earliest_never) return "never, as held";
  const likely = margin.never ? "never" : margin.time_to_slip == null ? dash : `${spell(margin.time_to_slip)}`;
  const early = margin.earliest_never ? "never" : margin.earliest == null ? dash : `${spell(margin.earliest)}`;
  return `${likely}, earliest ${early}`;
};
const spell = (s) => (s >= 100 ? `${Math.round(s)} s` : `${s.toPrecision(2)} s`);
// The least round number that is not below `value`, so that a scale seldom changes.
export const niceAbove = (value) => {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 1.5, 2, 3, 4, 6, 8, 10].map((m) => m * power).find((m) => m >= value * 0.999999);
};
