// Draws diagrams when they come into view, and handles the keyboard and the theme button.
"use strict";

(() => {
  const specs = JSON.parse(document.getElementById("chart-data").textContent);
  const places = [...document.querySelectorAll("[data-chart]")];

  function draw(place) {
    if (!place.plot) pylonCharts.draw(place, specs[place.dataset.chart]);
  }

  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (entry.isIntersecting) {
        seen.unobserve(entry.target);
        draw(entry.target);
      }
    }
  }, { rootMargin: "300px" });
  for (const place of places) {
    seen.observe(place);
    place.addEventListener("dblclick", () => pylonCharts.reset(place));
    place.addEventListener("keydown", (event) => press(event, place));
  }
  addEventListener("beforeprint", () => places.filter((place) => place.checkVisibility()).forEach(draw));

  function press(event, place) {
    if (!place.plot || event.ctrlKey || event.altKey || event.metaKey) return;
    const far = event.shiftKey ? 60 : 6;
    const acts = {
      ArrowLeft: () => pylonCharts.move(place, -far),
      ArrowRight: () => pylonCharts.move(place, far),
      "+": () => pylonCharts.zoom(place, 0.5),
      "=": () => pylonCharts.zoom(place, 0.5),
      "-": () => pylonCharts.zoom(place, 2),
      0: () => pylonCharts.reset(place),
      Escape: () => pylonCharts.reset(place),
    };
    if (acts[event.key]) {
      acts[event.key]();
      event.preventDefault();
    }
  }

  const KEY = "pylon-report-colours";
  const button = document.getElementById("theme");
  const THEMES = {
    auto: { scheme: "light dark", text: "◐ auto", label: "◐ auto: the system's colours" },
    light: { scheme: "light", text: "☀ light", label: "☀ light: colours" },
    dark: { scheme: "dark", text: "☾ dark", label: "☾ dark: colours" },
  };
  let theme = "auto";

  function dress(name) {
    theme = name in THEMES ? name : "auto";
    const { scheme, text, label } = THEMES[theme];
    document.documentElement.style.colorScheme = scheme;
    button.textContent = text;
    button.setAttribute("aria-label", label);
    pylonCharts.recolour();
  }

  // A page opened from a file may not be allowed to store anything.
  function remembered() {
    try { return localStorage.getItem(KEY) ?? "auto"; } catch { return "auto"; }
  }

  button.addEventListener("click", () => {
    const names = Object.keys(THEMES);
    dress(names[(names.indexOf(theme) + 1) % names.length]);
    try { localStorage.setItem(KEY, theme); } catch { /* see above */ }
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => pylonCharts.recolour());
  dress(remembered());
})();
