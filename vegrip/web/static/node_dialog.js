// Parameters and lifecycle of one node, with the command that does the same.
const text = (value) => String(value).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
const RISKY = new Set(["deactivate", "cleanup", "shutdown"]); // the hand is no longer commanded

const asked = async (path, values, method = "GET") => {
  const init = method === "GET" ? {} : { method, headers: { "content-type": "application/json" }, body: JSON.stringify(values) };
  const address = method === "GET" ? `${path}?${new URLSearchParams(values)}` : path;
  try {
    const answer = await fetch(address, init);
    const reply = await answer.json();
    return answer.ok ? { reply } : { error: reply.error };
  } catch {
    return { error: "the server of this page does not answer" };
  }
};

export class NodeDialog {
  constructor(root) {
    this.root = root;
    root.addEventListener("click", (event) => this.click(event));
    root.addEventListener("change", (event) => { if (event.target.dataset.parameter) this.set(event.target); });
  }

  get isOpen() { return this.root.open; }

  // What the nodes report: another person, or the node itself, may have changed its state.
  attend(nodes) {
    const received = nodes[this.node]?.state;
    if (!this.isOpen || received === this.received) return;
    this.received = received;
    this.showState();
  }

  async open(node) {
    if (!node) return;
    this.node = node;
    this.sure = null;
    this.root.innerHTML = `<div style="display:flex;gap:12px;align-items:center"><h3 id="node-title">${text(node)}</h3><span class="grow"></span><button type="button" data-close>close (Esc)</button></div><p class="state"></p><label>find <input type="search" class="find" placeholder="e.g. margin"></label><div class="rows">…</div><p class="say" role="status"></p><pre class="command">vegrip param list ${text(node)}</pre>`;
    this.root.querySelector(".find").addEventListener("input", (event) => this.filter(event.target.value));
    this.root.showModal();
    await Promise.all([this.showParameters(), this.showState()]);
  }

  async showParameters() {
    const { reply, error } = await asked("/parameters", { node: this.node });
    if (error) return this.say(error, "bad");
    this.rows = reply;
    this.root.querySelector(".rows").innerHTML = `<table><tr><th>parameter</th><th>value</th><th>unit</th><th>bounds</th><th>meaning</th></tr>${reply.map(row).join("")}</table>`;
  }

  async showState() {
    const { reply, error } = await asked("/state", { node: this.node });
    if (error) return this.say(error, "bad");
    if (reply.state !== this.shown) this.sure = null;
    this.shown = reply.state;
    const html = `<b>${text(reply.state)}</b>${reply.on_hold ? " (on hold)" : ""} ${reply.transitions.map((name) => `<button type="button" class="${RISKY.has(name) ? "danger" : ""}" data-transition="${name}">${name}</button>`).join(" ")}`;
    const line = this.root.querySelector(".state");
    if (line.dataset.html === html) return; // a button that is replaced while it is pressed is not pressed
    line.dataset.html = html;
    line.innerHTML = html;
  }

  filter(words) {
    for (const line of this.root.querySelectorAll("tr[data-row]")) line.hidden = !line.textContent.toLowerCase().includes(words.toLowerCase());
  }

  async click(event) {
    const { close, transition } = event.target.dataset;
    if (close !== undefined) return this.root.close();
    if (!transition) return;
    this.command(`vegrip lifecycle set ${this.node} ${transition}`);
    if (RISKY.has(transition) && this.sure !== transition) {
      this.sure = transition;
      event.target.textContent = `${transition}: press again`;
      return this.say("The hand is then no longer commanded and holds by its own fail-safe. Press again to do it.", "warn");
    }
    this.sure = null;
    this.say(`${transition}: the node is asked`, "unknown"); // configuring may compile a model first
    const { reply, error } = await asked("/state", { node: this.node, target: transition }, "POST");
    this.say(error ?? `the node is ${reply.state}`, error ? "bad" : "ok");
    await this.showState();
  }

  async set(input) {
    const name = input.dataset.parameter, before = this.rows.find((one) => one.name === name);
    const value = read(input, before);
    this.command(`vegrip param set ${this.node} ${name} ${input.value}`);
    const { reply, error } = await asked("/parameters", { node: this.node, name, value }, "POST");
    if (error) {
      input.value = before.value;
      return this.say(error, "bad");
    }
    this.rows = reply;
    this.say(`${name} is ${reply.find((one) => one.name === name).value}`, "ok");
  }

  say(words, level) {
    const line = this.root.querySelector(".say");
    line.className = `say ${level}`;
    line.textContent = words;
  }

  command(words) { this.root.querySelector("pre.command").textContent = words; }
}

const read = (input, before) => {
  if (before.type === "bool") return input.value === "true";
  if (before.type === "str") return input.value;
  const value = Number(input.value);
  return input.value.trim() === "" || Number.isNaN(value) ? input.value : value;
};

const row = (one) => {
  const bounds = one.choices.length ? one.choices.join(" | ") : one.low == null && one.high == null ? "" : `${one.low ?? ""} … ${one.high ?? ""}`;
  const shown = text(typeof one.value === "object" && one.value !== null ? JSON.stringify(one.value) : one.value);
  const field = !one.live || typeof one.value === "object" ? `<code>${shown}</code>` : one.type === "bool" || one.choices.length
    ? `<select data-parameter="${text(one.name)}" aria-label="${text(one.name)}">${(one.choices.length ? one.choices : ["true", "false"]).map((v) => `<option ${String(one.value) === v ? "selected" : ""}>${text(v)}</option>`).join("")}</select>`
    : `<input class="value" data-parameter="${text(one.name)}" aria-label="${text(one.name)}" value="${shown}">`;
  return `<tr data-row><td><code>${text(one.name)}</code></td><td>${field}</td><td>${one.unit === "1" ? "" : text(one.unit)}</td><td class="soft">${text(bounds)}</td><td class="soft">${text(one.doc)}${one.live ? "" : " (fixed while running)"}</td></tr>`;
};
