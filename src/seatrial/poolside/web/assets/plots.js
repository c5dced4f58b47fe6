// SPDX-License-Identifier: MIT
// Plots of plotly: predictions one second ahead, and the sticks of the next manoeuvre over time.

import { fill, make, place, short } from "./tables.js";

const dark = matchMedia("(prefers-color-scheme: dark)");
const SYMBOLS = { surge: ["u", "m/s"], sway: ["v", "m/s"], yaw: ["r", "rad/s"] };
const EVERY = 1000; // [ms] between two drawings of a plot: a phone has other work
const CONFIG = { responsive: true, displayModeBar: false, staticPlot: true };

const cycle = () => (dark.matches ? ["#56b4e9", "#d55e00", "#009e73", "#cc79a7", "#e69f00"]
  : ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00"]);

// plotly reads a little HTML in texts
const plain = (text) => text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");

function layout(across, up) {
  const [text, grid] = dark.matches ? ["#e8eaed", "#363c42"] : ["#1a1d21", "#dfe3e7"];
  const axis = { gridcolor: grid, zerolinecolor: grid, automargin: true };
  return { paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", margin: { l: 48, r: 8, t: 26, b: 34 },
    font: { family: getComputedStyle(document.body).fontFamily, size: 12, color: text },
    xaxis: { ...axis, title: { text: across } }, yaxis: { ...axis, title: { text: up } },
    legend: { orientation: "h", x: 0, y: 1.01, yanchor: "bottom" }, showlegend: true };
}

function caption(one) {
  const unit = SYMBOLS[one.axis][1];
  const expected = one.expected === null ? "" : `, expected ${short(one.expected, 2)}`;
  return `RMS ${short(one.rms, 2)} ${unit}${expected}; ${short(one.constant, 2)} if velocity stays constant`;
}

let drawn = 0;

export function predictions(found) {
  if (place("predictions").childElementCount !== found.length) {
    fill("predictions", found.map((one) =>
      make("figure", "", make("h3", "one", one.axis), make("div", "plot row"), make("figcaption", ""))));
  }
  const { top, bottom } = place("predictions").getBoundingClientRect();
  if (performance.now() - drawn < EVERY || bottom < 0 || top > innerHeight) return false;
  drawn = performance.now();
  [...place("predictions").children].forEach((figure, i) => {
    const one = found[i], [blue, red] = cycle(), [letter, unit] = SYMBOLS[one.axis];
    const trace = (name, y, color, dash) => ({ type: "scatter", mode: "lines", name, x: one.t, y, line: { color, dash, width: 1.5 } });
    const data = [trace("measured", one.measured, blue, "solid"), trace("predicted", one.predicted, red, "dash")];
    window.Plotly.react(figure.querySelector(".plot"), data, layout("t [s]", `${letter} [${unit}]`), CONFIG);
    figure.querySelector("figcaption").textContent = caption(one);
  });
  return true;
}

export function sticks(next, inputs) {
  const box = place("sticks-plot");
  box.hidden = !next || !next.commands.length;
  if (box.hidden) return;
  const colours = cycle();
  const t = [...next.t, next.seconds];
  const data = inputs.map((name, i) => {
    const own = next.commands.map((row) => row[i]);
    return { type: "scatter", mode: "lines", name: plain(name), x: t, y: [...own, own[own.length - 1]],
      line: { shape: "hv", color: colours[i % colours.length], width: 2 } };
  });
  const look = layout("t [s] of the manoeuvre", "stick");
  look.yaxis.range = [-1.05, 1.05];
  window.Plotly.react(box, data, look, CONFIG);
}
