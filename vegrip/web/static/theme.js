// Light, dark, or as the system has it; kept for the next visit.
(() => {
  const order = ["", "dark", "light"];
  const set = (theme) => {
    if (theme) document.documentElement.dataset.theme = theme;
    else delete document.documentElement.dataset.theme;
    document.dispatchEvent(new Event("themechange"));
  };
  set(localStorage.getItem("vegrip-theme") || "");
  window.nextTheme = () => {
    const now = document.documentElement.dataset.theme || "";
    const next = order[(order.indexOf(now) + 1) % order.length];
    localStorage.setItem("vegrip-theme", next);
    set(next);
  };
  document.addEventListener("DOMContentLoaded", () => {
    document.getElementById("theme")?.addEventListener("click", window.nextTheme);
  });
})();
