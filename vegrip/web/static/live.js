// The live page: keeps what the server sends, draws it when the browser is ready for a frame.
import { Plots } from "./plots.js";
import { drawMargin, drawPressure, drawSurface, pressureScale, surfaceScale } from "./svg.js";
import { ago, dash, number, untilSlip, withStd } from "./words.js";
import { NodeDialog } from "./node_dialog.js";

const TRAIL = 50; // loads that are drawn behind the present one: two seconds
const SILENT = 1500; // [ms] without an event after which the server is called silent
const $ = (id) => document.getElementById(id);
const put = (node, html) => { if (node.dataset.html !== html) { node.dataset.html = html; node.innerHTML = html; } };
const text = (value) => String(value).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);

const state = { now: null, layout: null, columns: {}, trails: {}, scales: {}, selected: null, received: 0, drawn: 0, plotted: 0, dirty: false, frames: 0 };
window.vegrip = state; // for the tests
const plots = new Plots($("plots"));
const dialog = new NodeDialog($("node-dialog"));

const receive = (event) => {
  const message = JSON.parse(event.data);
  state.received = performance.now();
  if (message.layout) {
    state.layout = message.layout;
    state.columns = message.history;
    plots.build(message.layout);
  }
  for (const columns of message.columns ?? []) {
    for (const [finger, column] of Object.entries(columns)) {
      const kept = (state.columns[finger] ??= []);
      kept.push(column);
      if (kept.length > state.layout.count) kept.shift();
    }
  }
  state.now = message;
  for (const [name, finger] of Object.entries(message.fingers)) {
    const trail = (state.trails[name] ??= []);
    if (finger.load) trail.push(finger.load);
    if (!finger.load || trail.length > TRAIL) trail.shift();
  }
  state.dirty = true;
};

const connect = () => {
  const source = new EventSource("/live");
  source.onmessage = receive;
  source.onerror = () => { if (source.readyState === EventSource.CLOSED) setTimeout(connect, 1000); };
};

const frame = () => {
  state.frames += 1;
  const silent = performance.now() - state.received > SILENT;
  showConnection(silent);
  if (state.dirty && state.now && !document.hidden) {
    state.dirty = false;
    draw(state.now);
  }
  requestAnimationFrame(frame);
};

const showConnection = (silent) => {
  const chip = $("connection");
  const [name, said] = !state.received ? ["unknown", "connecting"] : silent ? ["bad", "the server of this page does not answer"] : ["ok", "live"];
  if (chip.dataset.said === said) return;
  chip.dataset.said = said;
  chip.className = `chip ${name}`;
  chip.textContent = said;
  document.body.classList.toggle("gone", silent && state.received > 0);
  if (silent && state.received) {
    put($("alarms"), `<li class="bad">The server of this page does not answer; what is shown is old. If it was started again, open the address that it printed.</li>`);
  }
};

const draw = (now) => {
  const names = Object.keys(now.fingers);
  if (!names.includes(state.selected)) state.selected = names[0] ?? null;
  $("empty").hidden = names.length > 0 || Object.keys(now.nodes).length > 0;
  drawAlarms(now.alarms);
  put($("states"), now.states.map((one) => `<li class="calm">${text(one.text)}</li>`).join(""));
  drawFingers(now.fingers, names);
  drawNodes(now.nodes);
  dialog.attend(now.nodes);
  put($("log"), [...now.log].reverse().map((line) => `<li><span class="soft">${line.time.toFixed(1).padStart(8)} s</span> <span class="${line.style.split(" ").pop()}">${text(line.text)}</span></li>`).join("") || `<li class="soft">nothing has happened yet</li>`);
  const active = Object.values(now.nodes).filter((node) => node.state === "active" && node.presence === "running").length;
  $("summary").textContent = names.length ? `${names.length} fingers, ${active} active ${active === 1 ? "node" : "nodes"}` : "";
  const finger = now.fingers[state.selected];
  $("detail").hidden = $("model-card").hidden = !finger;
  if (finger) drawDetail(state.selected, finger);
};

const drawAlarms = (alarms) => {
  put($("alarms"), alarms.map((one) => `<li class="${one.level}"><span>${one.level === "bad" ? "▲" : "!"}</span><span>${text(one.text)}</span><span class="lasts">${one.lasts >= 1 ? `for ${ago(one.lasts)}` : ""}</span></li>`).join(""));
};

const drawFingers = (fingers, names) => {
  const root = $("fingers");
  if (root.dataset.names !== names.join("\n")) {
    root.dataset.names = names.join("\n");
    root.replaceChildren(...names.map(makeFinger));
  }
  names.forEach((name, i) => drawFinger(root.children[i], name, fingers[name]));
};

const makeFinger = (name) => {
  const button = document.createElement("button");
  button.type = "button";
  button.addEventListener("click", () => select(name));
  button.innerHTML = `<span class="name"><span>${text(name)}</span><span class="status"></span></span><span class="soft label">slip margin</span><span class="big"></span><span class="bar fresh-only"></span><span class="mini fresh-only"></span><dl class="facts"></dl>`;
  return button;
};

const drawFinger = (card, name, finger) => {
  const margin = finger.margin, bad = finger.alarm?.level === "bad", probing = finger.health.friction === "probed";
  const kind = `card finger${finger.fresh ? "" : " stale"}${bad ? " bad" : ""}`;
  if (card.className !== kind) card.className = kind;
  card.setAttribute("aria-pressed", name === state.selected);
  const [level, said] = !finger.fresh ? ["unknown", "old"]
    : finger.alarm ? [finger.alarm.level, finger.alarm.label]
    : finger.health.condition !== "ok" ? [finger.health.level, finger.health.input]
    : probing ? ["calm", "probing"] : ["ok", "ok"];
  put(card.querySelector(".status"), `<span class="chip ${level}">${text(said)}</span>`);
  put(card.querySelector(".big"), finger.fresh
    ? finger.in_contact === false ? `air <small>no contact, no margin</small>` : `${number(margin.value)} <small>${margin.bound == null ? "its bound is not known yet" : `≥ ${number(margin.bound)}, sure to ${margin.confidence == null ? "?" : (100 * margin.confidence).toFixed(0)} %`}</small>`
    : `${dash} <small>${finger.age == null ? "no news yet" : `no news for ${ago(finger.age)}`}</small>`);
  put(card.querySelector(".bar"), drawMargin(finger.in_contact ? margin : margin && { wanted: margin.wanted }));
  const scale = (state.scales[name] = surfaceScale(finger.surface, finger.load, state.scales[name]));
  put(card.querySelector(".mini"), drawSurface(finger, state.trails[name] ?? [], scale, true));
  const wanted = margin?.wanted == null ? dash : number(margin.wanted);
  put(card.querySelector(".facts"), `<dt>wanted</dt><dd>${wanted}</dd><dt>slips in</dt><dd>${!finger.in_contact ? dash : probing ? "probing on purpose" : untilSlip(margin)}</dd><dt>command</dt><dd>${finger.command ? `<b>${number(finger.command.force)} N</b>` : dash}</dd><dd class="why">${finger.command ? text(finger.command.words) : ""}</dd>`);
};

const drawDetail = (name, finger) => {
  $("surface-title").textContent = `${name}: friction limit surface`;
  $("plots-title").textContent = `${name}: last 30 s`;
  $("model-title").textContent = `${name}: model`;
  put($("surface"), drawSurface(finger, state.trails[name] ?? [], state.scales[name]));
  const key = `${name} pressure`;
  state.scales[key] = pressureScale(finger.contact, state.scales[key]);
  put($("pressure"), drawPressure(finger, state.scales[key]));
  drawModel(finger);
  const now = performance.now();
  if (now - state.plotted > 75 && state.layout) { // twelve times a second: a screen column is wider than that
    state.plotted = now;
    plots.draw(state.columns[name] ?? [], finger.margin?.wanted ?? null);
  }
};

const drawModel = (finger) => {
  const { health, contact } = finger;
  const level = health.consistent ? "ok" : health.channel ? "warn" : "unknown";
  const values = [["N", "normal_force", 1, 3, "N"], ["a", "contact_radius", 1e3, 3, "mm"], ["k", "pressure_exponent", 1, 3, ""], ["mu", "friction_coefficient", 1, 3, ""], ["delta", "indentation", 1e3, 3, "mm"]];
  const rows = values.map(([symbol, key, scale, digits, unit]) => `<tr><td>${symbol}</td><td class="num">${withStd(contact?.[key], scale, digits)}</td><td>${unit}</td><td class="soft">now</td></tr>`);
  const learned = finger.learned.map((one) => `<tr><td>${text(one.symbol)}</td><td class="num">${one.value ?? dash} ± ${one.std ?? "?"}</td><td>${text(one.unit)}</td><td class="soft">learned over ${one.excited ?? 0} s${one.valid ? "" : ", not yet valid"}</td></tr>`);
  put($("model"), `<p><span class="chip ${level}">${text(health.words || "no news")}</span></p><p class="soft">normalised innovation squared ${number(health.nis)} (1 is right); measurements refused ${health.rejected ?? dash}${health.suspect ? `; suspect <b>${text(health.suspect)}</b>` : ""}</p><div class="scroll"><table><tr><th>quantity</th><th class="num">value ± std</th><th></th><th></th></tr>${rows.join("")}${learned.join("")}</table></div>`);
};

const COLUMNS = ["state", "in [Hz]", "out [Hz]", "p50 / p99 / max [ms]", "late", "dropped", "refused now"];
const isNumber = (i) => i > 0 && i < 6;
const HEAD = `<tr><th>node</th><th></th>${COLUMNS.map((name, i) => `<th class="${isNumber(i) ? "num" : ""}">${name}</th>`).join("")}</tr>`;

// Rows stay while their numbers change: a button that is replaced while it is pressed is not pressed.
const drawNodes = (nodes) => {
  const table = $("nodes"), names = Object.keys(nodes);
  if (table.dataset.names !== names.join("\n")) {
    table.dataset.names = names.join("\n");
    table.innerHTML = HEAD + (names.map((name) => `<tr><td>${text(name)}</td><td><button type="button" data-node="${text(name)}">parameters</button></td>${COLUMNS.map((label) => `<td data-label="${label}"></td>`).join("")}</tr>`).join("") || `<tr><td colspan="9" class="soft">no node yet</td></tr>`);
  }
  names.forEach((name, i) => drawNode(table.rows[i + 1], nodes[name]));
};

const drawNode = (row, one) => {
  const running = one.presence === "running", rate = (v) => (running ? number(v, 0) : dash), ms = (v) => (v == null || !running ? dash : (v / 1e3).toFixed(2));
  const level = running ? (one.state === "active" ? "ok" : "warn") : one.presence === "stopped" || one.presence === "starting" ? "unknown" : "bad";
  const said = running ? one.state ?? "running" : `${one.presence} ${ago(one.age)}`;
  const refused = Object.entries(one.refused).map(([why, count]) => `${why} ${count}`).join(", ");
  const cells = [`<span class="chip ${level}">${said}</span>`, rate(one.rate_in), rate(one.rate_out), `${ms(one.latency_p50)} / ${ms(one.latency_p99)} / ${ms(one.latency_max)}`, one.misses ?? dash, one.dropped ?? dash, text(refused).replaceAll("_", "_<wbr>") || dash];
  cells.forEach((html, i) => {
    row.cells[i + 2].className = isNumber(i) ? "num" : "";
    put(row.cells[i + 2], String(html));
  });
  row.querySelector("button").disabled = !running;
};

const select = (name) => { state.selected = name; state.plotted = 0; state.dirty = true; };

$("nodes").addEventListener("click", (event) => { const node = event.target.dataset?.node; if (node) dialog.open(node); });
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || dialog.isOpen || /INPUT|SELECT|TEXTAREA/.test(event.target.tagName)) return;
  const names = Object.keys(state.now?.fingers ?? {}), place = Number(event.key) - 1;
  if (names[place]) select(names[place]);
  else if (event.key === "t") window.nextTheme();
  else if (event.key === "p") dialog.open(state.now?.fingers[state.selected]?.source || Object.keys(state.now?.nodes ?? {})[0]);
});
document.addEventListener("themechange", () => state.layout && plots.build(state.layout));
connect();
requestAnimationFrame(frame);
