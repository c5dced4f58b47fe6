// SPDX-License-Identifier: MIT
// Tables and lists. Texts of logs are set as text, never as HTML.

const ANY = 100; // times value or half-width, above which any width is enough
const NORMAL_95 = 1.96; // half-width of a 95 % interval, in standard errors
const MARKS = { fit: ["good", "✓"], limited: ["fair", "~"], "not fit": ["poor", "✗"] };
const WORDS = { ok: "✓ ok", warning: "! look", error: "✗ mend" };

// an element: its parts are elements or texts
export function make(kind, look, ...parts) {
  const found = document.createElement(kind);
  if (look) found.className = look;
  found.append(...parts);
  return found;
}

export const place = (id) => document.getElementById(id);
export const fill = (id, parts) => place(id).replaceChildren(...parts);

// three significant digits, without an exponent where it is not needed
export function short(value, digits = 3) {
  if (value === null || value === undefined) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e5) return value.toExponential(digits - 1).replace("-", "−");
  const places = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return value.toFixed(Math.min(places, 6)).replace("-", "−");
}

// an estimate with the decimals of its half-width: rounded coarser, the interval shown would not be around it
function estimate(value, half, unit) {
  const decimals = half > 0 ? Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(half)))) : 0;
  const own = half > 0 && Math.abs(value) < 1e5 ? value.toFixed(decimals).replace("-", "−") : short(value);
  return `${own} ± ${short(half, 2)} ${unit.replaceAll("^2", "²").replaceAll("^3", "³")}`;
}

// a sentence of its own
export const sentence = (text) => (text ? `${text[0].toUpperCase()}${text.slice(1)}${text.endsWith(".") ? "" : "."}` : "");

export function signed(value) {
  const percent = Math.round(100 * value);
  return percent === 0 ? "0" : `${percent > 0 ? "+" : "−"}${Math.abs(percent)} %`;
}

// X_u is X with a lowered u
export function symbol(name) {
  const [letter, ...below] = name.split("_");
  return below.length && letter.length === 1 ? [letter, make("sub", "", below.join("_"))] : [name];
}

const seconds = (value) => (value === null ? "–" : value < 1 ? `${Math.round(1000 * value)} ms` : `${short(value)} s`);

export function signals(found) {
  const rows = [];
  for (const one of found) {
    const name = make("th", "", one.name);
    name.scope = "row";
    rows.push(make("tr", "", name, make("td", `level-${one.level}`, WORDS[one.level] || one.level),
      make("td", "", one.rate === null ? "–" : `${short(one.rate)} Hz`), make("td", "", seconds(one.age)),
      make("td", "", seconds(one.delay)), make("td", "", seconds(one.jitter)), make("td", "", `${one.gaps}`),
      make("td", "", `${one.jumps}`), make("td", "", one.value.map((value) => short(value)).join(", "))));
    if (one.finding || one.edit) {
      const cell = make("td", "finding", one.finding);
      cell.colSpan = 8;
      if (one.edit) cell.append(" Vehicle file: ", make("code", "", one.edit));
      const why = make("th", "");
      why.scope = "row";
      why.append(make("span", "note", "finding"));
      rows.push(make("tr", "", why, cell));
    }
  }
  fill("signals", rows);
}

export function parameters(found) {
  fill("parameters", found.map((one) => {
    const half = NORMAL_95 * one.error;
    const name = make("th", "", ...symbol(one.name));
    name.scope = "row";
    const scale = one.needed === null ? Math.abs(one.value) : 2 * one.needed; // of half the bar
    const share = Math.min(1, scale > 0 ? half / scale : 1);
    const inner = make("i");
    inner.style.left = `${50 * (1 - share)}%`;
    inner.style.width = `${100 * share}%`;
    const bar = make("span", `interval ${one.needed === null ? "free" : one.known ? "known" : ""}`, inner);
    if (one.needed !== null) bar.append(make("s"), make("s"));
    const known = one.needed === null ? "not needed" : one.known ? "✓ known" : `${short(half / one.needed, 2)} times too wide`;
    return make("tr", "", name, make("td", "", estimate(one.value, half, one.unit)), make("td", "", bar),
      make("td", "", needed(one, half)), make("td", "", known));
  }));
}

function needed(one, half) {
  if (one.needed === null) return "–";
  return one.needed > ANY * Math.max(half, Math.abs(one.value)) ? "any" : `± ${short(one.needed, 2)}`;
}

export function coverage(found) {
  const most = 10; // [s] of a full colour
  fill("coverage", found.map((one) => {
    const unit = one.axis === "yaw" ? "rad/s" : "m/s";
    const head = make("tr", "", make("td", ""));
    for (let i = 0; i + 1 < one.commands.length; i++) {
      const cell = make("th", "", `${signed((one.commands[i] + one.commands[i + 1]) / 2)}`);
      cell.scope = "col";
      head.append(cell);
    }
    const body = make("tbody", "");
    for (let row = one.seconds.length - 1; row >= 0; row--) { // the fastest on top
      const name = make("th", "", short((one.speeds[row] + one.speeds[row + 1]) / 2, 2));
      name.scope = "row";
      body.append(make("tr", "", name, ...one.seconds[row].map((value) => {
        const cell = make("td", "", value >= 0.5 ? `${Math.round(value)}` : "");
        cell.style.setProperty("--share", Math.min(1, value / most));
        return cell;
      })));
    }
    return make("table", "heat", make("caption", "", `${one.axis} [${unit}]`), make("thead", "", head), body);
  }));
}

export function uses(found) {
  fill("uses", found.map((one) => {
    const [look, sign] = MARKS[one.level] || ["fair", "?"];
    const inner = make("i");
    inner.style.width = `${Math.round(100 * Math.min(1, Math.max(0, one.share)))}%`;
    return make("li", "", make("span", `mark ${look}`, sign), make("b", "", `${one.use}: ${one.level}`),
      make("span", `share ${look}`, inner), make("span", "", `${Math.floor(100 * one.share)} % of what is needed is known. ${sentence(one.reason)}`.replaceAll(" %", "\u00a0%")));
  }));
}

export function others(found) {
  place("others-title").hidden = found.length === 0;
  fill("others", found.map((one) => make("li", "", `${one.text} (${short(one.seconds, 2)} s${one.parameter ? `, for ${one.parameter}` : ""})`)));
}

export function marks(found) {
  const rows = found.map(([t, text]) => make("li", "", `${t.toFixed(1)} s ${text}`));
  fill("marks", rows.length ? rows.reverse() : [make("li", "", "none")]);
}
