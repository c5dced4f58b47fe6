// SPDX-License-Identifier: MIT
// The page of a session: takes what changes, draws it, sends what the buttons ask for.

import * as plots from "./plots.js";
import * as pool from "./pool.js";
import * as tables from "./tables.js";
import { fill, make, place, sentence, short, signed } from "./tables.js";

const AGAIN = 1000; // [ms] until the next attempt to connect
const SILENT = 6000; // [ms] without a message, three times the server's beat: a phone that left the network hears no end
const REFUSED = 1008; // code of a WebSocket's close
const MANY = 4; // stick positions, above which they are smaller
const COUNT = 3; // [s] before a manoeuvre
let state = null;
let driving = null; // a manoeuvre that is driven, and since when
let waiting = new Set(); // fields whose part of the page is not drawn yet
let due = false;
let gone = false; // whether the connection is lost
let finished = false; // whether seatrial has ended: it serves no report any more

// what the newest message changed is drawn with the next frame
function draw() {
  due = false;
  const changed = waiting;
  waiting = new Set();
  const any = (...names) => names.some((name) => changed.has(name));
  for (const name of ["signals", "parameters", "coverage", "uses", "others", "marks"]) {
    if (any(name)) tables[name](state[name]);
  }
  if (any("predictions") && !plots.predictions(state.predictions)) later("predictions");
  if (any("next", "inputs")) plots.sticks(driving ? driving.next : state.next, state.inputs);
  if (any("next", "walls", "pose", "track")) pool.draw(driving ? { ...state, next: driving.next } : state);
  facts();
  now();
  document.documentElement.dataset.shown = state.time; // [s] of the newest pose that is drawn
}

function later(...names) {
  names.forEach((name) => waiting.add(name));
}

function ask() {
  if (due) return;
  due = true;
  requestAnimationFrame(draw);
}

function take(message) {
  state = { ...state, ...message.state };
  later(...Object.keys(message.state || {}));
  if (message.track || message.since === 0) {
    pool.addRows(message.since || 0, message.track || []);
    later("track");
  }
  ask();
}

function facts() {
  document.title = `${state.vehicle}: seatrial live`;
  place("vehicle").textContent = `${state.vehicle}: live`;
  const lag = state.lag > 2 ? `, estimate ${short(state.lag, 2)} s behind` : "";
  place("facts").textContent =
    `${state.source}, ${state.time.toFixed(0)} s, ${state.driven.toFixed(0)} s driven, ${state.poses} poses${lag}`;
  const over = state.stopped || Boolean(state.saving);
  for (const id of ["mark", "discard", "stop"]) place(id).disabled = over;
}

// the one thing to do, and what is known about it
function order() {
  const wrong = state.signals.find((one) => one.level === "error");
  if (state.saved.length) return ["done", "Saved", state.message || "Saved. The drive is over.", saved()];
  if (gone) return ["mend", "Connection lost", "What is shown is old. Check seatrial and the network.", []];
  if (state.saving) return ["wait", "Saving", `Wait: ${state.saving}`, []];
  if (state.stopped) return ["wait", "Stopped", "The session is over.", [state.message]];
  if (wrong) return ["mend", "Mend first", ...mend(wrong)];
  if (driving) return driven();
  if (state.enough) return ["done", "Enough", "Enough for the chosen uses. Press stop and save.", []];
  if (state.next) return ["act", "Drive next", state.next.text, [[reason(state.next), state.message].join(" ").trim()]];
  if (state.message) return ["mend", "Now", state.message, []];
  if (state.poses) return ["act", "Now", "Drive: forwards and backwards, to both sides, and turns.", []];
  return ["wait", "Now", "Wait for the first pose.", []];
}

// what was found is large; what it means and what to do stands below it
function mend(wrong) {
  const [, found, advice] = /^(.*?(?:[;.?](?= )|$)) ?(.*)$/s.exec(wrong.finding);
  const why = advice ? [`${sentence(advice)} `] : [];
  return [`${wrong.name}: ${found.replace(/;$/, "")}`, wrong.edit ? [...why, "Vehicle file: ", make("code", "", wrong.edit)] : why];
}

function reason(next) {
  const walls = next.margin === null ? "" : ` Least distance from the walls ${short(next.margin, 2)} m.`;
  const gain = next.parameter ? `, for ${next.parameter}: ± ${short(next.before, 2)} now, ± ${short(next.after, 2)} expected` : "";
  return `${short(next.seconds, 2)} s${gain}.${walls}`;
}

function saved() {
  const report = make("a", "", "open the report");
  report.href = "/report";
  const paths = state.saved.map(([what, path]) => `${what} ${path}`).join(", ");
  return !finished && state.saved.some(([what]) => what === "report") ? [report, ` (${paths})`] : [paths];
}

let shown = "";

function now() {
  const [look, title, text, why] = order();
  const next = driving ? driving.next : state.next;
  const steps = look === "act" && next && next.commands.length ? stages(next) : [];
  place("drive").hidden = look !== "act" || !next || !next.commands.length;
  place("drive").textContent = driving ? "stop the countdown" : "count down and drive it";
  place("change").textContent = state.change;
  const all = JSON.stringify([look, title, text, why.map((part) => part.textContent || part), steps]);
  if (all === shown) return; // a screen reader hears changes only
  shown = all;
  place("now").className = look;
  place("now-title").textContent = title;
  place("order").textContent = text.replaceAll(" %", "\u00a0%");
  place("sticks").classList.toggle("many", steps.length > MANY);
  fill("why", why);
  fill("sticks", steps.map(([when, what, look_]) => make("li", look_, make("b", "", when), what)));
}

const tenths = (t) => String(Math.round(10 * t) / 10);

// times with the same sticks, as text
function stages(next) {
  const found = [];
  next.t.forEach((t, i) => {
    const held = state.inputs.map((name, k) => [name, signed(next.commands[i][k])]).filter((one) => one[1] !== "0");
    const what = held.map((one) => one.join(" ")).join(" · ") || "let go";
    const end = i + 1 < next.t.length ? next.t[i + 1] : next.seconds;
    if (found.length && found[found.length - 1].what === what) found[found.length - 1].end = end;
    else found.push({ begin: t, end, what });
  });
  const since = driving ? elapsed() : -1;
  return found.map(({ begin, end, what }) => [`${tenths(begin)}–${tenths(end)} s`, what,
    since < 0 || since < begin ? "" : since < end ? "current" : "over"]);
}

const elapsed = () => (performance.now() - driving.since) / 1000 - COUNT; // [s]

function driven() {
  const t = elapsed();
  if (t < 0) return ["act", "Get ready", `${Math.ceil(-t)} …`, [driving.next.text]];
  const last = stages(driving.next).find((one) => one[2] === "current");
  return ["act", `Drive now, ${Math.ceil(driving.next.seconds - t)} s left`, last ? last[1] : driving.next.text, []];
}

place("drive").addEventListener("click", () => {
  driving = driving ? null : { next: state.next, since: performance.now() };
  later("next");
  ask();
});

setInterval(() => {
  if (driving && elapsed() > driving.next.seconds) driving = null;
  if (state && (driving || waiting.size)) ask();
}, 200);

async function post(path, body, done) {
  place("answer").textContent = "…";
  try {
    const answer = await fetch(path, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });
    place("answer").textContent = answer.ok ? done : (await answer.text()).trim();
    return answer.ok;
  } catch {
    place("answer").textContent = "no connection to seatrial: nothing was done";
    return false;
  }
}

place("mark").addEventListener("click", async () => {
  if (await post("/api/mark", { text: place("mark-text").value }, "marked")) place("mark-text").value = "";
});
place("discard").addEventListener("click", () => {
  const seconds = Number(place("seconds").value);
  if (!place("seconds").reportValidity() || !(seconds > 0)) {
    place("answer").textContent = "nothing was discarded: give a number of seconds";
    return;
  }
  post("/api/discard", { seconds }, `the last ${seconds} s are discarded`);
});
place("stop").addEventListener("click", () => post("/api/stop", {}, "saved"));

function connection(text, lost) {
  place("connection").textContent = text;
  place("connection").classList.toggle("lost", lost);
  gone = lost;
  if (state) ask();
}

function connect() {
  const socket = new WebSocket(`ws://${location.host}/ws`);
  let heard = performance.now(), watch = 0;
  socket.addEventListener("open", () => connection("connected", false));
  socket.addEventListener("message", (event) => {
    heard = performance.now();
    take(JSON.parse(event.data));
  });
  const ended = (event) => {
    clearInterval(watch);
    socket.removeEventListener("close", ended);
    socket.close();
    finished = Boolean(state && state.saved.length);
    if (finished) return connection("seatrial has ended", false);
    connection(event.code === REFUSED ? event.reason : "connection lost; what is shown is old", true);
    return setTimeout(connect, AGAIN);
  };
  socket.addEventListener("close", ended);
  watch = setInterval(() => { if (performance.now() - heard > SILENT) ended({}); }, AGAIN);
}

if (location.search) history.replaceState(null, "", location.pathname); // the cookie has the token
addEventListener("resize", () => { if (state) { later("track"); ask(); } });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  if (state) { later("track", "next", "predictions"); ask(); }
});
connect();
