// The check page: shows what the server has made, and says what was pressed.
const $ = (id) => document.getElementById(id);
const text = (value) => String(value).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
const put = (node, html) => {
  if (node.dataset.html === html) return;
  const focused = document.activeElement?.id; // what is replaced must not lose the keyboard
  node.dataset.html = html;
  node.innerHTML = html;
  if (focused && node.querySelector(`#${CSS.escape(focused)}`)) $(focused).focus();
};

let received = 0;
const alarm = (level, words) => put($("alarms"), words ? `<li class="${level}"><span>${text(words)}</span></li>` : "");

const receive = (event) => {
  const message = JSON.parse(event.data);
  received += 1;
  put($("progress"), message.progress);
  $("busy").hidden = !message.progress;
  document.body.classList.remove("gone");
  if (message.body === undefined) return;
  $("recording").textContent = message.name;
  $("connection").className = `chip ${message.level}`;
  $("connection").textContent = message.verdict;
  alarm(message.error ? "bad" : "ok", message.error || message.note);
  put($("body"), message.body);
  put($("commands"), message.commands);
};

const connect = () => {
  const source = new EventSource("/live");
  source.onmessage = receive;
  source.onerror = () => {
    if (!received) return;
    alarm("bad", "The server of this page does not answer. What was found is kept in the folder of the check: start the command again and open the address that it prints.");
    document.body.classList.add("gone");
    if (source.readyState === EventSource.CLOSED) setTimeout(connect, 1000);
  };
};

const ask = async (values) => {
  try {
    const answer = await fetch("/do", { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(values) });
    if (!answer.ok) alarm("bad", (await answer.json()).error);
  } catch {
    alarm("bad", "The server of this page does not answer.");
  }
};

document.addEventListener("click", (event) => {
  const button = event.target.closest("button[data-do]");
  if (button) ask(button.dataset);
});
document.addEventListener("change", (event) => {
  const choice = event.target.closest("select[data-do]");
  if (choice) ask({ do: choice.dataset.do, [choice.name]: choice.value });
});
document.addEventListener("submit", (event) => {
  event.preventDefault();
  ask({ do: event.target.dataset.do, ...Object.fromEntries(new FormData(event.target)) });
});
connect();
