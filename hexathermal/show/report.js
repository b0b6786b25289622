"use strict";
(async () => {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const inside = (id) => document.getElementById(id).textContent;
  const darker = JSON.parse(inside("store-colours"));

  async function inflated(id) {
    const packed = Uint8Array.from(atob(inside(id)), (letter) => letter.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  }

  const channels = (colour) => [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16));
  const luminance = (rgb) => {
    const [r, g, b] = rgb.map((c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  // as seen in the reader's scheme: a partner that is named, or lighter until it stands out from the paper
  function seen(colour) {
    if (!dark.matches) return colour;
    const named = darker[colour.toUpperCase()];
    if (named) return named;
    let rgb = channels(colour);
    const paper = luminance(channels("#171B21"));
    while ((luminance(rgb) + 0.05) / (paper + 0.05) < 3.2) rgb = rgb.map((c) => c + 0.1 * (255 - c) + 1);
    return "#" + rgb.map((c) => Math.min(255, Math.round(c)).toString(16).padStart(2, "0")).join("");
  }
  const colours = /(#[0-9a-f]{6})([0-9a-f]{2})?(?=")/gi;
  const themed = (text) => JSON.parse(text.replace(colours, (_all, solid, veil) => seen(solid) + (veil || "")));

  if (typeof DecompressionStream === "undefined") return; // the still pictures stay
  const specs = JSON.parse(await inflated("store-plots"));
  const texts = Object.fromEntries(Object.entries(specs).map(([name, one]) => [name, JSON.stringify(one)]));
  const script = document.createElement("script");
  script.textContent = await inflated("store-plotly");
  document.head.append(script);
  const hidden = {};

  // a long title of a panel in two lines, on a telephone
  function folded(words, width) {
    if (words.length - 7 <= (width - 100) / 7.2) return words; // less its marks of bold letters; margins, and a letter
    const at = words.indexOf(" ", Math.floor(words.length / 2) - 4);
    return at < 0 ? words : words.slice(0, at) + "<br>" + words.slice(at + 1);
  }

  function draw(name) {
    const figure = document.getElementById(name);
    const pane = figure.querySelector(".live");
    const { data, layout } = themed(texts[name]);
    for (const trace of data) {
      const group = trace.legendgroup || trace.name;
      if (hidden[name] && hidden[name].has(group)) trace.visible = false;
    }
    layout.dragmode = matchMedia("(pointer: coarse)").matches ? false : "zoom";
    if (figure.clientWidth < 480) {
      layout.font.size = 11;
      layout.margin.r = Math.min(layout.margin.r, 44);
      for (const title of layout.annotations) title.text = folded(title.text, figure.clientWidth);
      if (layout.annotations.length && layout.annotations[0].text.includes("<br>")) layout.margin.t += 14;
    }
    figure.classList.add("drawn");
    const options = { responsive: true, displayModeBar: false, doubleClick: "reset", scrollZoom: false };
    for (const button of figure.querySelectorAll(".curve"))
      button.style.setProperty("--mark", seen(button.dataset.colour));
    return Plotly.react(pane, data, layout, options);
  }

  const axesOf = (pane) => Object.keys(pane._fullLayout).filter((key) => /^[xy]axis\d*$/.test(key));

  function zoom(pane, factor, moveX = 0, moveY = 0) {
    const change = {};
    for (const key of axesOf(pane)) {
      const axis = pane._fullLayout[key];
      const [low, high] = axis.range;
      const middle = (low + high) / 2 + (high - low) * (key[0] === "x" ? moveX : moveY);
      change[key + ".range"] = [middle - ((high - low) / 2) * factor, middle + ((high - low) / 2) * factor];
    }
    Plotly.relayout(pane, change);
  }

  function reset(pane) {
    const original = JSON.parse(texts[pane.closest("figure").id]).layout;
    const change = {};
    for (const key of axesOf(pane)) {
      const own = original[key] || {};
      if (own.range) change[key + ".range"] = own.range;
      else change[key + ".autorange"] = own.autorange || true;
    }
    Plotly.relayout(pane, change);
  }

  const KEYS = {
    ArrowLeft: (pane) => zoom(pane, 1, -0.15),
    ArrowRight: (pane) => zoom(pane, 1, 0.15),
    ArrowUp: (pane) => zoom(pane, 1, 0, 0.15),
    ArrowDown: (pane) => zoom(pane, 1, 0, -0.15),
    "+": (pane) => zoom(pane, 0.7),
    "=": (pane) => zoom(pane, 0.7),
    "-": (pane) => zoom(pane, 1 / 0.7),
    0: reset,
  };

  function prepare(figure) {
    const name = figure.id;
    const pane = figure.querySelector(".live");
    pane.addEventListener("keydown", (event) => {
      const act = KEYS[event.key];
      if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      act(pane);
    });
    for (const button of figure.querySelectorAll("[data-do]"))
      button.addEventListener("click", () => KEYS[button.dataset.do](pane));
    for (const button of figure.querySelectorAll(".curve"))
      button.addEventListener("click", () => {
        hidden[name] = hidden[name] || new Set();
        const off = button.getAttribute("aria-pressed") === "true";
        button.setAttribute("aria-pressed", String(!off));
        if (off) hidden[name].add(button.dataset.curve);
        else hidden[name].delete(button.dataset.curve);
        draw(name);
      });
    const save = figure.querySelector(".save");
    save.addEventListener("click", async () => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([JSON.parse(await tables)[name]], { type: "text/csv" }));
      link.download = name + ".csv";
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  }

  const tables = inflated("store-tables");
  const figures = [...document.querySelectorAll("figure[data-plot]")];
  figures.forEach(prepare);
  dark.addEventListener("change", () => figures.forEach((figure) => draw(figure.id)));
  for (const figure of figures) {
    await draw(figure.id);
    await new Promise((done) => setTimeout(done));
  }
  document.documentElement.dataset.report = "drawn";
})();
