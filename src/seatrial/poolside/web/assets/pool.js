// SPDX-License-Identifier: MIT
// The pool from above: walls, track, boat, the next manoeuvre. x of the file's axes is up, and y is to the left
// in forward-left-up axes, to the right in forward-right-down axes.

import { place } from "./tables.js";

const MARGIN = 26; // [px]
const RECENT = 10; // [s] of the track that is drawn darker
const LEAST = 2; // [m] that are shown
const track = [];
let view = null; // scale and centre that hold everything

export function addRows(since, rows) {
  track.length = since;
  for (const row of rows) track.push(row);
}

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function bounds(state) {
  const found = { x: [Infinity, -Infinity], y: [Infinity, -Infinity] };
  const take = (x, y) => {
    found.x = [Math.min(found.x[0], x), Math.max(found.x[1], x)];
    found.y = [Math.min(found.y[0], y), Math.max(found.y[1], y)];
  };
  for (const [x, y] of state.walls) take(x, y);
  for (const row of track) take(row[1], row[2]);
  for (const [x, y] of state.next ? state.next.path : []) take(x, y);
  if (state.pose) take(state.pose[0], state.pose[1]);
  return found;
}

// metres to pixels
function transform(state, width, height) {
  const { x, y } = bounds(state);
  if (!(x[0] <= x[1])) return null;
  const tall = Math.max(x[1] - x[0], LEAST), wide = Math.max(y[1] - y[0], LEAST);
  const scale = Math.min((width - 2 * MARGIN) / wide, (height - 2 * MARGIN) / tall);
  const side = state.axes === "forward-right-down" ? 1 : -1;
  const [cx, cy] = [(x[0] + x[1]) / 2, (y[0] + y[1]) / 2];
  return { scale, side, at: (px, py) => [width / 2 + side * scale * (py - cy), height / 2 - scale * (px - cx)] };
}

function line(pen, points, look, thick, dash = []) {
  pen.strokeStyle = look;
  pen.lineWidth = thick;
  pen.setLineDash(dash);
  pen.beginPath();
  points.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  pen.stroke();
}

function boat(pen, at, heading, look) {
  pen.save();
  pen.translate(...at);
  pen.rotate(heading);
  pen.fillStyle = look;
  pen.beginPath();
  for (const [x, y] of [[0, -13], [8, 10], [0, 5], [-8, 10]]) pen.lineTo(x, y);
  pen.fill();
  pen.restore();
}

export function draw(state) {
  const canvas = place("pool");
  const ratio = devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  view = transform(state, width, height);
  if (!view) return;
  const { at, scale, side } = view;
  const [text, quiet, accent, warn] = ["--text", "--quiet", "--accent", "--warn"].map(colour);
  if (state.walls.length) line(pen, [...state.walls, state.walls[0]].map(([x, y]) => at(x, y)), text, 3);
  line(pen, track.map((row) => at(row[1], row[2])), quiet, 1);
  const newest = track.length ? track[track.length - 1][0] : 0;
  line(pen, track.filter((row) => row[0] >= newest - RECENT).map((row) => at(row[1], row[2])), accent, 3);
  if (state.next) {
    const path = state.next.path;
    line(pen, path.map(([x, y]) => at(x, y)), warn, 3, [8, 5]);
    if (path.length) boat(pen, at(path[path.length - 1][0], path[path.length - 1][1]), side * path[path.length - 1][2], warn);
  }
  if (state.pose) boat(pen, at(state.pose[0], state.pose[1]), side * state.pose[2], accent);
  ruler(pen, scale, height, quiet);
  canvas.setAttribute("aria-label", described(state));
}

function ruler(pen, scale, height, look) {
  const metres = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100].find((m) => m * scale >= 50) || 200;
  line(pen, [[MARGIN, height - 6], [MARGIN + metres * scale, height - 6]], look, 2);
  pen.fillStyle = look;
  pen.font = "13px system-ui, sans-serif";
  pen.fillText(`${metres} m`, MARGIN, height - 10);
}

function described(state) {
  const pose = state.pose ? `The boat is at x ${state.pose[0].toFixed(1)} m, y ${state.pose[1].toFixed(1)} m. ` : "";
  const next = state.next ? `The next manoeuvre lasts ${state.next.seconds.toFixed(0)} s.` : "";
  return `Track of the boat. ${pose}${next}`;
}
