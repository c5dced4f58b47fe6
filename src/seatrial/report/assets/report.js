// SPDX-License-Identifier: MIT
// Draws the plots when they come into view, links the time axes, follows light, dark and paper.
(function () {
  "use strict";
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const touch = matchMedia("(pointer: coarse)");
  const BRIGHTER = { "#000000": "#f2f2f2", "#0072b2": "#56b4e9", "#56b4e9": "#2f7fb0",
    "rgba(0,114,178,0.15)": "rgba(86,180,233,0.22)" };
  const NARROW = 500; // [px] of a plot with a smaller legend
  const LOW = 100; // [px] a lower panel has steps between its ticks that fit
  const TICK_HEIGHT = 17, LETTER = 0.56; // [px] of a tick's label with its room; [font size] of a letter
  const TITLE = 13, LEAST_TITLE = 10; // [px]
  const FOLDS = "details.run, details.fold, details.kept";
  const stores = new Map();
  let printing = false, linking = false;

  const plots = () => [...document.querySelectorAll(".plot")];
  const drawn = (div) => div.dataset.drawn === "yes";
  const numbers = (text) => text.split(",").map(Number);
  const isDark = () => dark.matches && !printing;

  function store(id) {
    if (!stores.has(id)) {
      const packed = JSON.parse(document.getElementById(id).textContent);
      stores.set(id, { figures: packed.figures, columns: packed.columns, ready: [] });
    }
    return stores.get(id);
  }

  // [exponent, step, step, null, step ...] to numbers; see embed.py
  function column(kept, i) {
    if (!kept.ready[i]) {
      const [exponent, ...steps] = kept.columns[i];
      const power = Math.pow(10, Math.abs(exponent));
      let total = 0;
      kept.ready[i] = steps.map((d) => {
        if (d === null) return null;
        total += d;
        return exponent < 0 ? total / power : total * power;
      });
    }
    return kept.ready[i];
  }

  function unpack(value, kept) {
    if (Array.isArray(value)) return value.map((part) => unpack(part, kept));
    if (value && typeof value === "object") {
      if ("column" in value) return column(kept, value.column);
      return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, unpack(v, kept)]));
    }
    return isDark() && value in BRIGHTER ? BRIGHTER[value] : value;
  }

  // of a low panel fewer ticks and a smaller title, so that neither runs into the next one
  function fitted(axis, height, traces) {
    const [begin, end] = axis.domain || [0, 1];
    const room = height * (end - begin), text = axis.title ? axis.title.text.replace(/<[^>]*>/g, "") : "";
    const size = Math.max(LEAST_TITLE, Math.min(TITLE, Math.floor(room / (LETTER * Math.max(text.length, 1)))));
    const step = room < LOW && !axis.tickvals && axis.type !== "log" ? stepOf(traces, room) : 0;
    return { ...(step ? { tick0: 0, dtick: step } : {}), title: { ...axis.title, font: { size } } };
  }

  // the smallest round step whose labels have room; 0: no values
  function stepOf(traces, room) {
    let low = Infinity, high = -Infinity;
    for (const trace of traces) {
      for (const y of trace.y) if (y !== null) { low = Math.min(low, y); high = Math.max(high, y); }
    }
    const least = 1.1 * (high - low) * TICK_HEIGHT / room, power = Math.pow(10, Math.floor(Math.log10(least)));
    return high > low ? power * [1, 2, 3, 4, 5, 6, 8, 10].find((step) => step * power >= least * 0.9999) : 0;
  }

  function dressed(layout, height, data) {
    const [text, grid] = isDark() ? ["#e8eaed", "#363c42"] : ["#1a1d21", "#dfe3e7"];
    const modebar = { bgcolor: "rgba(0,0,0,0)", color: isDark() ? "#a3abb3" : "#5a6169", activecolor: text };
    const whole = { ...layout }, margin = { l: 52, r: 10, t: 36, b: 40, ...layout.margin };
    for (const name of ["xaxis", "yaxis", "yaxis2", "yaxis3"]) {
      if (!layout[name]) continue;
      const title = { ...layout[name].title, standoff: 6, font: { size: TITLE } };
      const traces = data.filter((trace) => (trace.yaxis || "y") === name.replace("axis", ""));
      const own = name === "xaxis" ? {} : fitted(layout[name], height - margin.t - margin.b, traces);
      whole[name] = { gridcolor: grid, zerolinecolor: grid, linecolor: grid, automargin: true,
        ...layout[name], ...own, title: { ...title, ...own.title } };
    }
    return {
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", hovermode: "closest",
      font: { family: getComputedStyle(document.body).fontFamily, size: 12, color: text },
      margin, dragmode: touch.matches ? false : "zoom",
      hoverlabel: { namelength: -1 }, modebar, ...whole,
      legend: { orientation: "h", x: 0, y: 1.01, yanchor: "bottom", bgcolor: "rgba(0,0,0,0)", ...layout.legend },
    };
  }

  function draw(div) {
    const kept = store(div.dataset.run);
    const figure = unpack(kept.figures[div.dataset.figure], kept);
    const linked = div.closest(".linked"), known = drawn(div);
    if (linked && linked.dataset.range && div.classList.contains("wide")) {
      figure.layout.xaxis.range = numbers(linked.dataset.range);
    }
    div.dataset.drawn = "yes";
    const narrow = div.clientWidth < NARROW; // its tools would cover the legend; a drag zooms all the same
    const config = { responsive: true, displaylogo: false, displayModeBar: touch.matches || narrow ? false : "hover",
      modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"], doubleClick: "autosize",
      toImageButtonOptions: { format: "png", scale: 3, filename: `${div.dataset.run}-${div.dataset.figure}` } };
    const layout = dressed(figure.layout, div.clientHeight, figure.data);
    if (narrow) layout.legend = { ...layout.legend, font: { size: 10 }, itemwidth: 30 };
    Plotly.react(div, figure.data, layout, config);
    if (!known && linked) div.on("plotly_relayout", (change) => follow(div, change));
  }

  // all time axes of a recording show the same stretch
  function show(linked, range) {
    const [begin, end] = numbers(linked.dataset.whole);
    const shown = [Math.max(begin, range[0]), Math.min(end, range[1])];
    linked.dataset.range = shown.join(",");
    linking = true;
    const done = [...linked.querySelectorAll(".plot.wide")].filter(drawn).map((div) =>
      Plotly.relayout(div, { "xaxis.range": [...shown] }));
    return Promise.all(done).finally(() => { linking = false; });
  }

  function follow(div, change) {
    if (linking || !div.classList.contains("wide")) return;
    const linked = div.closest(".linked");
    if (change["xaxis.autorange"]) show(linked, numbers(linked.dataset.whole));
    else if ("xaxis.range[0]" in change) show(linked, [...div.layout.xaxis.range]);
  }

  function press(button) {
    if (button.dataset.do === "all") {
      const runs = [...document.querySelectorAll(FOLDS)];
      const open = runs.some((run) => !run.open);
      runs.forEach((run) => { run.open = open; });
      button.textContent = open ? "close all" : "open all";
      return;
    }
    const linked = button.closest(".linked");
    const [begin, end] = numbers(linked.dataset.whole);
    const home = numbers(linked.dataset.window);
    const now = numbers(linked.dataset.range || linked.dataset.window);
    const width = Math.min(now[1] - now[0], end - begin);
    if (button.dataset.do === "whole") show(linked, [begin, end]);
    else if (button.dataset.do === "window") show(linked, home);
    else {
      const start = now[0] + (button.dataset.do === "later" ? 0.8 : -0.8) * width;
      const first = Math.min(Math.max(start, begin), end - width);
      show(linked, [first, first + width]);
    }
  }

  const watcher = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (entry.isIntersecting && !drawn(entry.target)) draw(entry.target);
    }
  }, { rootMargin: "300px" });

  const index = document.querySelector(".equation msub"); // without a font for mathematics it is not lowered
  if (index) {
    const [letter, below] = [...index.children].map((part) => part.getBoundingClientRect());
    document.body.classList.toggle("flat", below.bottom < letter.bottom + 0.1 * letter.height);
  }

  const redraw = () => plots().filter(drawn).forEach(draw);
  let opened = [];
  addEventListener("beforeprint", () => {
    printing = true;
    opened = [...document.querySelectorAll(FOLDS)].filter((part) => !part.open);
    opened.forEach((run) => { run.open = true; });
    document.body.classList.add("printing");
    plots().forEach(draw);
    plots().forEach((div) => Plotly.Plots.resize(div));
  });
  addEventListener("afterprint", () => {
    printing = false;
    opened.forEach((run) => { run.open = false; });
    document.body.classList.remove("printing");
    redraw();
    plots().filter((div) => div.offsetParent).forEach((div) => Plotly.Plots.resize(div));
  });
  dark.addEventListener("change", redraw);
  document.addEventListener("click", (event) => {
    const button = event.target.closest("button[data-do]");
    if (button) press(button);
  });
  document.addEventListener("toggle", (event) => {
    if (!event.target.open) return;
    event.target.querySelectorAll(".plot").forEach((div) => { if (drawn(div)) Plotly.Plots.resize(div); });
  }, true);
  // a link to a folded section opens it
  function unfold() {
    const target = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    const fold = target && target.querySelector(":scope > details.fold");
    if (fold) { fold.open = true; target.scrollIntoView(); }
  }
  addEventListener("hashchange", unfold);
  document.addEventListener("click", (event) => { if (event.target.closest("nav a")) setTimeout(unfold); });
  if (matchMedia("(max-width: 500px)").matches) {
    document.querySelectorAll("details.narrow").forEach((part) => { part.open = false; });
  }
  unfold();
  plots().forEach((div) => watcher.observe(div));
})();
