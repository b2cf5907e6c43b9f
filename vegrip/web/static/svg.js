// Drawings as text: the limit surface with the load in it, the pressure over the contact, the margin as a bar.
import { niceAbove } from "./words.js";

const path = (points) => "M" + points.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L");
// Of force and torque to points of the drawing; scales: what the axes end at.
const plane = (box, scale) => (f, m) => [box.x + (f / scale.f) * box.w, box.y + box.h / 2 - (m / scale.m) * (box.h / 2)];

const outline = (surface, size, at) => {
  const upper = surface.curve.map(([f, m]) => [f * surface.force * size, m * surface.torque * size]);
  const lower = [...upper].reverse().map(([f, m]) => [f, -m]);
  return path([...upper, ...lower].map(([f, m]) => at(f, m))) + "Z";
};

export const surfaceScale = (surface, load, before) => {
  if (!surface && !load && before) return before;
  const f = niceAbove(1.05 * Math.max(surface?.force ?? 0, load?.force ?? 0, 0.05));
  const m = niceAbove(1.05 * Math.max(surface?.torque ?? 0, Math.abs(load?.torque ?? 0), 1e-4));
  const keep = (now, old) => (old && now < old && now > old / 1.9 ? old : now);
  return { f: keep(f, before?.f), m: keep(m, before?.m) };
};

// Limit surface; trail: loads {force, torque}, oldest first.
export const drawSurface = (finger, trail, scale, small = false) => {
  const w = small ? 190 : 340, h = small ? 92 : 250;
  const box = small ? { x: 4, y: 4, w: w - 8, h: h - 8 } : { x: 46, y: 10, w: w - 62, h: h - 52 };
  const at = plane(box, scale);
  const [x0, y0] = at(0, 0);
  const parts = [`<path class="axis" d="M${box.x} ${y0}H${box.x + box.w}M${box.x} ${box.y}V${box.y + box.h}"/>`];
  const s = finger.surface, load = finger.load;
  if (s) {
    parts.push(`<path d="${outline(s, 1, at)}" fill="var(--safe)" stroke="var(--blue)" stroke-width="${small ? 1.5 : 2}"/>`);
    if (s.sure > 0) parts.push(`<path d="${outline(s, s.sure, at)}" fill="var(--sure)" stroke="var(--blue)" stroke-width="1" stroke-dasharray="3 3"/>`);
  }
  if (load) {
    const [x, y] = at(load.force, load.torque);
    parts.push(`<path d="M${x0} ${y0}L${x.toFixed(1)} ${y.toFixed(1)}" stroke="var(--soft)" stroke-width="1"/>`);
    const pieces = small ? 1 : 4, points = trail.map((one) => at(one.force, one.torque));
    for (let i = 0; i < pieces; i++) {
      const from = Math.floor((i * points.length) / pieces), piece = points.slice(from, Math.floor(((i + 1) * points.length) / pieces) + 1);
      if (piece.length > 1) parts.push(`<path d="${path(piece)}" fill="none" stroke="var(--orange)" stroke-width="2" opacity="${(0.25 + (0.6 * (i + 1)) / pieces).toFixed(2)}"/>`);
    }
    const out = finger.margin && finger.margin.bound != null && finger.margin.bound < 0;
    const r = small ? 4 : 6;
    parts.push(out
      ? `<path d="M${x - r} ${y - r}L${x + r} ${y + r}M${x - r} ${y + r}L${x + r} ${y - r}" stroke="var(--red)" stroke-width="3.5"/>`
      : `<circle cx="${x.toFixed(1)}" cy="${y.toFixed(1)}" r="${r}" fill="var(--orange)" stroke="var(--card)" stroke-width="1.5"/>`);
  }
  if (!s) parts.push(`<text x="${box.x + box.w / 2}" y="${box.y + box.h / 2 - 8}" text-anchor="middle">${finger.in_contact === false ? "in the air" : "no estimate"}</text>`);
  if (!small) {
    const t = scale.m * 1e3, digits = t < 10 ? (t < 1 ? 2 : 1) : 0;
    for (const part of [0, 0.5, 1]) {
      const [x] = at(part * scale.f, 0);
      parts.push(`<text x="${x}" y="${box.y + box.h + 15}" text-anchor="middle">${+(part * scale.f).toPrecision(3)}</text>`);
    }
    for (const part of [-1, 0, 1]) parts.push(`<text x="${box.x - 6}" y="${at(0, part * scale.m)[1] + 4}" text-anchor="end">${(part * t).toFixed(digits)}</text>`);
    parts.push(`<text x="${box.x + box.w / 2}" y="${h - 6}" text-anchor="middle">tangential force [N]</text>`);
    parts.push(`<text transform="translate(12 ${box.y + box.h / 2}) rotate(-90)" text-anchor="middle">torque [N mm]</text>`);
  }
  return `<svg viewBox="0 0 ${w} ${h}" width="100%" role="img" aria-label="limit surface and load">${parts.join("")}</svg>`;
};

// Pressure over peak pressure at r over a.
const shape = (r, k) => (r >= 1 ? 0 : (1 - r ** k) ** (1 / k));

export const pressureScale = (contact, before) => {
  if (!contact?.peak_pressure && before) return before;
  const a = niceAbove(1.15 * (contact?.contact_radius?.value ?? 0) || 1e-3), p = niceAbove(1.05 * (contact?.peak_pressure ?? 0) || 1e3);
  const keep = (now, old) => (old && now < old && now > old / 1.9 ? old : now);
  return { a: keep(a, before?.a), p: keep(p, before?.p) };
};

export const drawPressure = (finger, scale) => {
  const w = 340, h = 230, box = { x: 46, y: 10, w: w - 62, h: 120 }, middle = box.x + box.w / 2, foot = box.y + box.h;
  const parts = [`<path class="axis" d="M${box.x} ${foot}H${box.x + box.w}M${middle} ${box.y}V${foot}"/>`];
  const c = finger.contact, a = c?.contact_radius?.value, peak = c?.peak_pressure;
  const X = (r) => middle + (r / scale.a) * (box.w / 2);
  if (peak && a > 0) {
    const k = Math.max(c.pressure_exponent.value ?? 2, 1), std = c.contact_radius.std ?? 0, points = [];
    for (let i = -40; i <= 40; i++) { const s = Math.sin((i / 40) * Math.PI / 2); points.push([X(s * a), foot - (shape(Math.abs(s), k) * peak / scale.p) * box.h]); }
    const stops = [0, 0.25, 0.5, 0.7, 0.85, 0.95, 1].map((r) => `<stop offset="${r}" stop-color="var(--blue)" stop-opacity="${(0.08 + 0.8 * shape(r, k)).toFixed(2)}"/>`).join("");
    const rx = (r) => ((r / scale.a) * box.w) / 2, cy = foot + 44;
    parts.push(`<defs><radialGradient id="patch">${stops}</radialGradient></defs>`);
    parts.push(`<path d="${path(points)}Z" fill="var(--band)" stroke="var(--blue)" stroke-width="2"/>`);
    parts.push(`<ellipse cx="${middle}" cy="${cy}" rx="${rx(a)}" ry="${rx(a) * 0.26}" fill="url(#patch)" stroke="var(--blue)" stroke-width="1.5"/>`);
    for (const r of [a - std, a + std]) if (r > 0) parts.push(`<ellipse cx="${middle}" cy="${cy}" rx="${rx(r)}" ry="${rx(r) * 0.26}" fill="none" stroke="var(--soft)" stroke-dasharray="3 3"/>`);
  } else parts.push(`<text x="${middle}" y="${foot - 40}" text-anchor="middle">${finger.in_contact === false ? "in the air" : "no estimate"}</text>`);
  for (const part of [-1, 0, 1]) parts.push(`<text x="${X(part * scale.a)}" y="${foot + 14}" text-anchor="middle">${+(part * scale.a * 1e3).toPrecision(3)}</text>`);
  for (const part of [0, 1]) parts.push(`<text x="${box.x - 6}" y="${foot - part * box.h + 4}" text-anchor="end">${+(part * scale.p / 1e3).toPrecision(3)}</text>`);
  parts.push(`<text x="${middle}" y="${h - 4}" text-anchor="middle">distance from the centre [mm]</text>`);
  parts.push(`<text transform="translate(12 ${box.y + box.h / 2}) rotate(-90)" text-anchor="middle">pressure [kPa]</text>`);
  return `<svg viewBox="0 0 ${w} ${h}" width="100%" role="img" aria-label="pressure profile and contact circle">${parts.join("")}</svg>`;
};

// The margin from 0 (slips) to 1 (no load): light up to its value, full up to its lower bound, a tick where it is wanted.
export const drawMargin = (margin) => {
  const w = 190, h = 26, X = (v) => 4 + Math.min(Math.max(v, 0), 1) * (w - 8), parts = [`<rect x="4" y="6" width="${w - 8}" height="10" rx="5" fill="var(--faint)" stroke="var(--line)"/>`];
  if (margin && margin.value != null) {
    const low = margin.bound ?? 0, colour = low < 0 ? "var(--red)" : margin.wanted != null && low < margin.wanted * 0.5 ? "var(--orange)" : "var(--blue)";
    parts.push(`<rect x="4" y="6" width="${(X(margin.value) - 4).toFixed(1)}" height="10" rx="5" fill="${colour}" opacity=".35"/>`);
    parts.push(`<rect x="4" y="6" width="${(X(low) - 4).toFixed(1)}" height="10" rx="5" fill="${colour}"/>`);
  }
  if (margin?.wanted != null) {
    const x = X(margin.wanted).toFixed(1);
    parts.push(`<path d="M${x} 2V20" stroke="var(--ink)" stroke-width="2"/><path d="M${x} 20l-4 6h8z" fill="var(--ink)"/>`);
  }
  return `<svg viewBox="0 0 ${w} ${h}" width="100%" aria-hidden="true">${parts.join("")}</svg>`;
};
