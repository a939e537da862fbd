// The page of `etendue view`: it requests the newest picture, shows it, and moves the camera. Values arrive as halves
// in linear light; exposure, tone curve and false colour are applied here, so they cost the renderer nothing.
"use strict";

const $ = (id) => document.getElementById(id);
const canvas = $("view"), context = canvas.getContext("2d");
const mover = 1 + Math.floor(Math.random() * 2 ** 50);  // identifies this page among several

// --- state from the server
// --------------------------------------------------------------------------------------------------

let state = null;    // the latest one
let mean = null;     // halves of the picture shown, three per pixel
let error = null;    // likewise for its standard error
let layer = null;    // the AOV shown: the numbers of each pixel, and how many there are
let shape = { width: 0, height: 0 };
let request = null;  // the pending one; aborted when something else is wanted
let wanted = { picture: 0, layer: 0 };

const channel = () => $("channel").value;
const isLayer = () => channel() !== "mean" && channel() !== "error";
const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

function take(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const next = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  if (next.hasPicture) {
    const count = next.width * next.height * 3;
    mean = new Uint16Array(buffer, 4 + length, count);
    error = next.hasError ? new Uint16Array(buffer, 4 + length + 2 * count, count) : null;
    shape = { width: next.width, height: next.height };
    wanted.picture = next.picture;
  }
  if (next.layer) {
    const size = next.layer.width * next.layer.height * next.layer.components * 4;
    layer = { ...next.layer, name: asked.aov, values: new Float32Array(buffer.slice(buffer.byteLength - size)) };
    wanted.layer = next.layer.number;
  }
  const before = state;
  state = next;
  tell(before);
  if (next.hasPicture || next.layer) draw();
}

let asked = {};  // parameters of the pending request
async function follow() {
  let failures = 0;
  for (;;) {
    if (document.hidden) { await pause(200); continue; }
    try {
      request = new AbortController();
      asked = { version: wanted.picture ? state.version : 0, picture: wanted.picture, layer: wanted.layer, error: channel() === "error" ? 1 : 0,
        ...(isLayer() ? { aov: channel() } : {}) };
      const answer = await fetch(`next?${new URLSearchParams(asked)}`, { signal: request.signal });
      if (!answer.ok) throw new Error(await answer.text());
      take(await answer.arrayBuffer());
      failures = 0;
    } catch (trouble) {
      if (trouble.name === "AbortError") continue;
      if (++failures > 1) lost();
      await pause(Math.min(250 * failures, 2000));
    }
  }
}

// Requests everything again.
function refresh() {
  wanted = { picture: 0, layer: 0 };
  if (request) request.abort();
}

function lost() {
  $("phase").textContent = "disconnected";
  $("phase").dataset.phase = "lost";
  problem("The viewer does not answer: it has ended, or the connection is lost. This page keeps trying. If you restart the viewer, open the new address that it prints.");
  state = state && { ...state, phase: "lost" };
}

async function post(what, parameters = {}) {
  const answer = await fetch(`${what}?${new URLSearchParams(parameters)}`, { method: "POST" });
  if (!answer.ok) problem(await answer.text());
}

// --- status -----------------------------------------------------------------------------------------------------------------

function problem(sentence) {
  $("problem").hidden = !sentence;
  if ($("problem").textContent !== sentence) $("problem").textContent = sentence;
}

function duration(seconds) {
  if (seconds === null || !Number.isFinite(seconds)) return "–";
  const s = Math.round(seconds);
  return s < 60 ? `${s} s` : s < 3600 ? `${Math.floor(s / 60)} min ${String(s % 60).padStart(2, "0")} s` : `${Math.floor(s / 3600)} h ${Math.floor(s / 60) % 60} min`;
}

const phases = { opening: "reading", rendering: "rendering", resting: "paused", done: "done", stopped: "stopped" };

function tell(before) {
  const s = state;
  $("scene").textContent = s.scene || "Etendue";
  document.title = s.scene ? `${s.scene} – Etendue` : "Etendue";
  $("device").textContent = s.device ? `${s.device}, ${s.driver}` : "";
  $("phase").textContent = phases[s.phase] || s.phase;
  $("phase").dataset.phase = s.phase;
  const coarse = s.width < s.fullWidth;
  $("samples").textContent = s.picture ? coarse ? `coarse, ${s.width} × ${s.height}` : `${s.samples} of ${s.target}` : "–";
  $("progress").value = s.target && !coarse ? s.samples / s.target : 0;
  $("speed").textContent = s.picture ? `${(s.samplesPerSecond * 1e-6).toFixed(2)} M/s` : "–";
  $("error").textContent = s.relativeError === null || coarse ? "–" : `${(100 * s.relativeError).toPrecision(3)} %`;
  $("left").textContent = s.phase === "done" ? "none" : duration(s.secondsLeft);
  $("pause").setAttribute("aria-pressed", String(s.paused));
  $("pause").textContent = s.paused ? "Resume" : "Pause";
  if (document.activeElement !== $("target") && s.target) $("target").value = s.target;
  problem(s.problem + (s.rejected ? `${s.problem ? "\n" : ""}${s.rejected} samples were left out because they were too large or not finite.` : ""));
  tellSettings(s);
  if (s.fullWidth) $("stage").style.setProperty("--shape", s.fullWidth / s.fullHeight);
  adoptCamera();
  followPath();
  followNumbers();
  announce(before);
}

function fill(id, value) {
  if (document.activeElement !== $(id) && $(id).value !== String(value)) $(id).value = value;
}

function tellSettings(s) {
  $("integrator").hidden = !s.integrator.path;
  fill("max-depth", s.integrator.maxDepth ?? "");
  fill("rr-depth", s.integrator.rrDepth);
  $("nee").checked = s.integrator.nee;
  $("mis").checked = s.integrator.mis;
  $("mis").disabled = !s.integrator.nee;
  const lens = s.camera.aperture !== null;
  $("aperture").disabled = $("focus").disabled = !lens;
  fill("crop", s.crop ? s.crop.join(", ") : "");
  fill("aperture", lens ? +s.camera.aperture.toPrecision(6) : "");
  fill("focus", lens ? +s.camera.focus.toPrecision(6) : "");
}

// For screen readers: what has changed, in a few words.
function announce(before) {
  if (before && before.phase === state.phase && before.problem === state.problem && before.loads === state.loads) return;
  let text = phases[state.phase] || state.phase;
  if (state.phase === "done") text = `Done: ${state.samples} samples, error ${$("error").textContent}.`;
  if (before && before.loads !== state.loads && before.loads > 0) text = "The scene was read again.";
  $("announcer").textContent = text;
}

// --- drawing ----------------------------------------------------------------------------------------------------------------

// The number for each of the 65536 halves.
const numbers = new Float32Array(65536);
for (let bits = 0; bits < 65536; ++bits) {
  const sign = bits & 0x8000 ? -1 : 1, exponent = (bits >> 10) & 31, fraction = bits & 1023;
  numbers[bits] = sign * (exponent === 31 ? (fraction ? NaN : Infinity) : exponent ? 2 ** (exponent - 15) * (1 + fraction / 1024) : 2 ** -24 * fraction);
}

// The curves of `etendue render --tonemap`. Reinhard's depends on the luminance, so it is not applied per channel.
const aces = (x) => x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);  // [Narkowicz2015]
const encode = (x) => x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;

// From dark blue through purple and orange to yellow, each step lighter than the one before.
const stops = [[0, 0, 20], [28, 20, 92], [70, 24, 124], [124, 34, 118], [180, 48, 92], [226, 80, 56], [248, 134, 30], [252, 196, 60], [255, 246, 180]];
const ramp = new Uint8Array(256 * 3);
for (let i = 0; i < 256; ++i) {
  const at = i / 255 * (stops.length - 1), k = Math.min(Math.floor(at), stops.length - 2);
  for (let c = 0; c < 3; ++c) ramp[3 * i + c] = stops[k][c] + (at - k) * (stops[k + 1][c] - stops[k][c]);
}

// The display byte for each half, for one exposure and curve.
const table = new Uint8ClampedArray(65536);
let tableKey = "";
function fillTable(exposure, curve) {
  const key = `${exposure} ${curve}`;
  if (key === tableKey) return;
  tableKey = key;
  const scale = 2 ** exposure;
  for (let bits = 0; bits < 65536; ++bits) {
    const x = numbers[bits] * scale;
    table[bits] = x === Infinity ? 255 : x > 0 ? 255 * encode(Math.min(1, curve === "aces" ? aces(x) : x)) : 0;
  }
}

// The display byte for numbers from 0 to 1 in 4095 steps, fine enough for all but the darkest.
const encoded = new Uint8ClampedArray(4096);
for (let i = 0; i < 4096; ++i) encoded[i] = 255 * encode(i / 4095);

const luminance = (halves, i) => 0.212671 * numbers[halves[i]] + 0.71516 * numbers[halves[i + 1]] + 0.072169 * numbers[halves[i + 2]];
const isNumber = (halves, i) => !Number.isNaN(numbers[halves[i]] + numbers[halves[i + 1]] + numbers[halves[i + 2]]);

function paintCurve(out, exposure, curve) {
  fillTable(exposure, curve);
  for (let i = 0, o = 0; i < mean.length; i += 3, o += 4) {
    out[o] = table[mean[i]];
    out[o + 1] = table[mean[i + 1]];
    out[o + 2] = table[mean[i + 2]];
    out[o + 3] = 255;
  }
}

// [Reinhard2002], equation 3.
function paintReinhard(out, exposure) {
  const scale = 2 ** exposure;
  for (let i = 0, o = 0; i < mean.length; i += 3, o += 4) {
    const factor = scale / (1 + scale * luminance(mean, i));
    for (let c = 0; c < 3; ++c) {
      const x = numbers[mean[i + c]] * factor;
      out[o + c] = x >= 1 ? 255 : x > 0 ? encoded[Math.round(4095 * x)] : 0;
    }
    out[o + 3] = 255;
  }
}

// `value` maps a pixel's index to a number from 0 to 1, or NaN if there is none.
function paintRamp(out, value) {
  for (let i = 0, o = 0; i < mean.length; i += 3, o += 4) {
    const t = value(i), k = 3 * Math.max(0, Math.min(255, Math.round(255 * t)));
    const known = !Number.isNaN(t);
    out[o] = known ? ramp[k] : 90;
    out[o + 1] = known ? ramp[k + 1] : 90;
    out[o + 2] = known ? ramp[k + 2] : 90;
    out[o + 3] = 255;
  }
}

// NaN is always shown in magenta, whatever else is shown.
function markWrong(out) {
  for (let i = 0, o = 0; i < mean.length; i += 3, o += 4) {
    if (!isNumber(mean, i)) out.set([255, 0, 255], o);
  }
}

// Layers: light is shown as a picture, directions and positions as colours over their range, and each object number in
// a colour of its own.
const spread = (n) => { let h = Math.imul(n, 2654435761) >>> 0; h ^= h >>> 15; h = Math.imul(h, 2246822519) >>> 0; return h ^ h >>> 13; };
const kNothing = 1e10;  // depths from here on mean that nothing was hit
function paintLayer(out, exposure) {
  const { values, components, name } = layer, count = layer.width * layer.height;
  const light = ["albedo", "direct", "indirect"].includes(name), id = ["instance", "primitive", "material"].includes(name);
  let low = Infinity, high = -Infinity;
  if (name === "depth" || name === "position") {
    for (const v of values) if (Math.abs(v) < kNothing) { low = Math.min(low, v); high = Math.max(high, v); }
  }
  for (let i = 0, o = 0; i < count; ++i, o += 4) {
    out[o + 3] = 255;
    for (let c = 0; c < 3; ++c) {
      const v = values[i * components + Math.min(c, components - 1)];
      let x;
      if (light) x = encode(Math.max(0, Math.min(1, v * 2 ** exposure)));
      else if (id) x = v === 0 ? 0 : (64 + (spread(v) >>> (8 * c)) % 192) / 255;
      else if (name === "uv") x = c === 2 ? 0 : v - Math.floor(v);
      else if (name === "depth") x = v >= kNothing ? 0 : high > low ? 1 - (v - low) / (high - low) : 1;
      else if (name === "position") x = high > low ? (v - low) / (high - low) : 0.5;
      else x = 0.5 + 0.5 * v;
      out[o + c] = Math.max(0, Math.min(255, Math.round(255 * x)));
      if (Number.isNaN(v)) { out.set([255, 0, 255], o); break; }
    }
  }
  return name === "depth" && high > low ? [`${high.toPrecision(3)} (dark)`, "depth", `${low.toPrecision(3)} (bright)`] : null;
}

function drawLayer() {
  if (!layer || layer.name !== channel()) return false;
  canvas.width = layer.width;
  canvas.height = layer.height;
  const image = context.createImageData(layer.width, layer.height);
  const legend = paintLayer(image.data, +$("exposure").value);
  context.putImageData(image, 0, 0);
  showLegend(legend, "#000, #fff");
  sharpen();
  read();
  return true;
}

function draw() {
  if (!mean) return;
  if (isLayer()) { if (drawLayer()) return; }
  if (canvas.width !== shape.width || canvas.height !== shape.height) { canvas.width = shape.width; canvas.height = shape.height; }
  const image = context.createImageData(shape.width, shape.height), out = image.data, exposure = +$("exposure").value;
  let legend = null;
  if (channel() === "error") {
    // From a thousandth of the pixel's luminance to all of it, on a logarithmic scale.
    paintRamp(out, (i) => {
      if (!error) return NaN;
      const e = luminance(error, i), m = Math.abs(luminance(mean, i));
      return e === Infinity ? NaN : e <= 0 ? 0 : m > 0 ? (Math.log10(e / m) + 3) / 3 : 1;
    });
    legend = ["0.1 %", "standard error of the pixel's light", "100 %"];
  } else if ($("false-color").checked) {
    paintRamp(out, (i) => {
      const l = luminance(mean, i) * 2 ** exposure;
      return l > 0 ? (Math.log2(l / 0.18) + 6) / 12 : Number.isNaN(l) ? NaN : 0;
    });
    const value = (stops) => (0.18 * 2 ** (stops - exposure)).toPrecision(2);
    legend = [value(-6), "luminance", value(6)];
  } else if ($("tone").value === "reinhard") {
    paintReinhard(out, exposure);
  } else {
    paintCurve(out, exposure, $("tone").value);
  }
  markWrong(out);
  context.putImageData(image, 0, 0);
  showLegend(legend);
  sharpen();
  read();
}

function showLegend(legend, gradient) {
  $("legend").hidden = !legend;
  if (!legend) return;
  $("legend-low").textContent = legend[0];
  $("legend-high").textContent = legend[2];
  const colors = gradient || stops.map((c) => `rgb(${c})`).join(", ");
  $("legend-what").textContent = legend[1];
  document.querySelector("#legend i").style.background = `linear-gradient(to right, ${colors})`;
}

// Pixels of a full picture are enlarged as squares; a coarse picture looks better smooth.
function sharpen() {
  const enlarged = Math.min(canvas.clientWidth / canvas.width, canvas.clientHeight / canvas.height) * devicePixelRatio;
  canvas.style.imageRendering = enlarged >= 2 && canvas.width >= (state.fullWidth || 0) ? "pixelated" : "auto";
}
addEventListener("resize", () => state && sharpen());

// --- reading values ---------------------------------------------------------------------------------------------------------

// The pixel under the pointer, or null outside the picture, which is fitted into the canvas.
function pixelAt(event) {
  const box = canvas.getBoundingClientRect(), scale = Math.min(box.width / canvas.width, box.height / canvas.height);
  const x = Math.floor((event.clientX - box.left - (box.width - canvas.width * scale) / 2) / scale);
  const y = Math.floor((event.clientY - box.top - (box.height - canvas.height * scale) / 2) / scale);
  return x >= 0 && y >= 0 && x < canvas.width && y < canvas.height ? [x, y] : null;
}

let marked = null;  // as fractions of the picture, which may be coarse now and fine later
function readAt(event) {
  const place = mean && pixelAt(event);
  if (!place) return;
  marked = [(place[0] + 0.5) / canvas.width, (place[1] + 0.5) / canvas.height];
  read();
}

// The pixel of the whole film, whatever part of it is shown.
function filmPixel() {
  const [x, y] = state.crop || [0, 0];
  return [x + Math.floor(marked[0] * state.fullWidth), y + Math.floor(marked[1] * state.fullHeight)];
}

function read() {
  if (!marked) return;
  const place = [Math.floor(marked[0] * shape.width), Math.floor(marked[1] * shape.height)];
  const full = filmPixel();
  if (isLayer() && layer && layer.name === channel()) {
    const at = (Math.floor(marked[1] * layer.height) * layer.width + Math.floor(marked[0] * layer.width)) * layer.components;
    $("readout").textContent = `pixel (${full}): ${[...layer.values.slice(at, at + layer.components)].map((v) => v.toPrecision(6)).join(" ")}`;
    return;
  }
  const i = 3 * (place[1] * shape.width + place[0]);
  const text = (halves) => [0, 1, 2].map((c) => numbers[halves[i + c]].toPrecision(4)).join(" ");
  $("readout").textContent = `pixel (${full}): ${text(mean)}${error ? ` ± ${text(error)}` : ""}`;
}

// --- the camera -------------------------------------------------------------------------------------------------------------

const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const sub = (a, b) => add(a, b, -1);
const mul = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(...a);
const unit = (a) => mul(a, 1 / norm(a));
// Rodrigues' formula.
const turned = (v, axis, angle) => add(add(mul(v, Math.cos(angle)), cross(axis, v), Math.sin(angle)), axis, dot(axis, v) * (1 - Math.cos(angle)));

let camera = null;       // as it is, or as it was last requested
let touched = 0;         // when this page last moved it
let sending = false, unsent = false, going = false;

function adoptCamera() {
  const mine = performance.now() - touched < 1500 && state.camera.mover !== 0;
  if (camera && (mine || going || unsent || sending)) return;
  camera = structuredClone(state.camera);
  showFov();
}

function showFov() {
  const known = camera && camera.fov !== null;
  $("fov").disabled = !known;
  if (!known) { $("fov-value").textContent = "–"; return; }
  $("fov").value = camera.fov;
  $("fov-value").textContent = `${+camera.fov.toFixed(1)}°`;
}

// The directions forward and to the right of the picture.
function axes() {
  const ahead = unit(sub(camera.target, camera.eye));
  return { ahead, right: mul(unit(cross(ahead, camera.up)), camera.mirrored ? -1 : 1) };
}

// Turns a direction, but stops short of straight up or down.
function tilted(v, axis, angle) {
  const limit = 0.02, now = Math.acos(Math.max(-1, Math.min(1, dot(unit(v), unit(camera.up)))));
  const after = turned(v, axis, angle), then = Math.acos(Math.max(-1, Math.min(1, dot(unit(after), unit(camera.up)))));
  return (then < limit || then > Math.PI - limit) && Math.abs(then - Math.PI / 2) > Math.abs(now - Math.PI / 2) - 1e-9 ? v : after;
}

function orbit(x, y) {
  const sign = camera.mirrored ? -1 : 1, up = unit(camera.up);
  let offset = turned(sub(camera.eye, camera.target), up, -x * sign);
  const across = unit(cross(mul(offset, -1), up));
  offset = tilted(offset, across, -y);
  camera.eye = add(camera.target, offset);
}

function look(x, y) {
  const sign = camera.mirrored ? -1 : 1, up = unit(camera.up);
  let ahead = turned(sub(camera.target, camera.eye), up, -x * sign);
  ahead = tilted(ahead, unit(cross(ahead, up)), -y);
  camera.target = add(camera.eye, ahead);
}

// `x` and `y` are fractions of the picture's height.
function pan(x, y) {
  const { ahead, right } = axes(), above = unit(cross(cross(ahead, camera.up), ahead));
  const height = 2 * norm(sub(camera.target, camera.eye)) * Math.tan((camera.fov || 40) * Math.PI / 360);
  const shift = add(mul(right, -x * height), above, y * height);
  camera.eye = add(camera.eye, shift);
  camera.target = add(camera.target, shift);
}

function dolly(factor) {
  const offset = sub(camera.eye, camera.target);
  if (norm(offset) * factor < 1e-9 || norm(offset) * factor > 1e12) return;
  camera.eye = add(camera.target, mul(offset, factor));
}

function walk(ahead, right, up) {
  const a = axes(), step = norm(sub(camera.target, camera.eye));
  const shift = add(add(mul(a.ahead, ahead * step), a.right, right * step), unit(camera.up), up * step);
  camera.eye = add(camera.eye, shift);
  camera.target = add(camera.target, shift);
}

function setFov(degrees) {
  if (camera.fov === null) return;
  camera.fov = Math.max(1, Math.min(170, degrees));
  showFov();
}

// Sends one request at a time; of the changes made meanwhile, only the last is sent.
async function sendCamera(goingOn) {
  touched = performance.now();
  going = goingOn;
  unsent = true;
  if (sending) return;
  sending = true;
  while (unsent) {
    unsent = false;
    const c = camera;
    try {
      await post("camera", { eye: c.eye, target: c.target, up: c.up, ...(c.fov === null ? {} : { fov: c.fov }),
        ...(c.aperture === null ? {} : { aperture: c.aperture, focus: c.focus }), moving: going ? 1 : 0, mover });
    } catch { break; }  // follow() reports a lost connection
  }
  sending = false;
}

function act(change, goingOn = false) {
  if (!camera) return;
  change();
  sendCamera(goingOn);
}

// --- pointers ---------------------------------------------------------------------------------------------------------------

const pointers = new Map();
let corner = null;  // where the crop being drawn begins
let action = "", pressed = null;  // where the button went down, while it may become a click

canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  action = event.button === 2 ? "look" : event.button === 1 || event.shiftKey ? "pan" : $("drag").value;
  corner = [event.clientX, event.clientY];
  pressed = event.button === 0 && pointers.size === 1 && !event.shiftKey ? [event.clientX, event.clientY] : null;
  if (event.button === 1) event.preventDefault();
});

canvas.addEventListener("pointermove", (event) => {
  const last = pointers.get(event.pointerId);
  if (!last) { readAt(event); return; }
  const x = event.clientX - last[0], y = event.clientY - last[1], size = canvas.clientHeight || 1;
  if (x === 0 && y === 0) return;
  if (pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < 4) return;  // a hand is never quite still
  pressed = null;
  const before = [...pointers.values()];
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  if (action === "crop" && pointers.size === 1) {
    showMark(event);
  } else if (pointers.size === 2) {
    const after = [...pointers.values()], span = (p) => Math.hypot(p[0][0] - p[1][0], p[0][1] - p[1][1]) || 1;
    act(() => { dolly(span(before) / span(after)); pan(x / 2 / size, y / 2 / size); }, true);
  } else if (action === "pan") {
    act(() => pan(x / size, y / size), true);
  } else {
    act(() => (action === "look" ? look : orbit)(x / size * (action === "look" ? -1.5 : 4), y / size * (action === "look" ? -1.5 : 4)), true);
  }
});

for (const end of ["pointerup", "pointercancel"]) {
  canvas.addEventListener(end, (event) => {
    if (!pointers.delete(event.pointerId)) return;
    if (pressed && end === "pointerup") click(event);
    if (!pressed && action === "crop") endMark(end === "pointerup" ? event : null);
    pressed = null;
    if (pointers.size === 0 && going) sendCamera(false);
  });
}
canvas.addEventListener("contextmenu", (event) => event.preventDefault());

// The pixel of the film at a position in the window, clamped to the part that is shown.
function cornerAt(x, y) {
  const box = canvas.getBoundingClientRect(), scale = Math.min(box.width / state.fullWidth, box.height / state.fullHeight);
  const [left, top] = state.crop || [0, 0], cut = (v, most) => Math.max(0, Math.min(most, Math.round(v)));
  return [left + cut((x - box.left - (box.width - state.fullWidth * scale) / 2) / scale, state.fullWidth),
    top + cut((y - box.top - (box.height - state.fullHeight * scale) / 2) / scale, state.fullHeight)];
}

function showMark(event) {
  const stage = $("stage").getBoundingClientRect(), mark = $("mark");
  mark.hidden = false;
  mark.style.left = `${Math.min(corner[0], event.clientX) - stage.left}px`;
  mark.style.top = `${Math.min(corner[1], event.clientY) - stage.top}px`;
  mark.style.width = `${Math.abs(corner[0] - event.clientX)}px`;
  mark.style.height = `${Math.abs(corner[1] - event.clientY)}px`;
}

function endMark(event) {
  $("mark").hidden = true;
  if (!event || !state.fullWidth) return;
  const a = cornerAt(...corner), c = cornerAt(event.clientX, event.clientY);
  const size = [Math.abs(a[0] - c[0]), Math.abs(a[1] - c[1])];
  if (size[0] > 0 && size[1] > 0) post("settings", { crop: [Math.min(a[0], c[0]), Math.min(a[1], c[1]), ...size].join() });
  $("drag").value = "orbit";  // hardly anyone wants a second crop at once
}

$("crop").addEventListener("change", () => post("settings", { crop: $("crop").value.replace(/[\s;×x]+/g, ",").replace(/,+/g, ",").replace(/^,|,$/g, "") }));

let wheelEnd = 0;
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  const lines = event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1;
  act(() => dolly(Math.exp(Math.max(-200, Math.min(200, event.deltaY * lines)) * 0.0015)), true);
  clearTimeout(wheelEnd);
  wheelEnd = setTimeout(() => sendCamera(false), 200);
}, { passive: false });

// --- clicks -----------------------------------------------------------------------------------------------------------------

async function ask(what, parameters) {
  const answer = await fetch(`${what}?${new URLSearchParams(parameters)}`);
  if (!answer.ok) throw new Error((await answer.text()).trim());
  return answer.json();
}

async function click(event) {
  readAt(event);
  if (!marked || !state.fullWidth) return;
  const [x, y] = filmPixel();
  if ($("click").value === "explain") {
    $("pixel-x").value = x;
    $("pixel-y").value = y;
    return explain();
  }
  try {
    const point = await ask("point", { x, y });
    if (!point.hit) { $("announcer").textContent = "Nothing was hit at that pixel."; return; }
    if ($("click").value === "material") return choosePoint(point);
    if ($("click").value === "focus") act(() => { camera.focus = point.focus; });
    else act(() => { camera.target = point.position; });
  } catch (trouble) { problem(trouble.message); }
}

// --- keys -------------------------------------------------------------------------------------------------------------------

const held = new Map();  // keys that act while they are held down, and what each does per second
const motions = {
  ArrowLeft: [(t) => orbit(t, 0), (t) => pan(t / 2, 0)], ArrowRight: [(t) => orbit(-t, 0), (t) => pan(-t / 2, 0)],
  ArrowUp: [(t) => orbit(0, t), (t) => pan(0, t / 2)], ArrowDown: [(t) => orbit(0, -t), (t) => pan(0, -t / 2)],
  w: [(t) => walk(t / 2, 0, 0)], s: [(t) => walk(-t / 2, 0, 0)], a: [(t) => walk(0, -t / 2, 0)], d: [(t) => walk(0, t / 2, 0)],
  q: [(t) => walk(0, 0, -t / 2)], e: [(t) => walk(0, 0, t / 2)],
  "+": [(t) => dolly(Math.exp(-t))], "=": [(t) => dolly(Math.exp(-t))], "-": [(t) => dolly(Math.exp(t))],
  f: [(t) => setFov(camera.fov * Math.exp(t)), (t) => setFov(camera.fov * Math.exp(-t))],
};
const strokes = {
  "[": () => step("exposure", -0.25), "]": () => step("exposure", 0.25),
  c: () => $("false-color").click(), r: () => $("reset").click(), " ": () => $("pause").click(),
  v: () => { $("channel").value = channel() === "mean" ? "error" : "mean"; $("channel").dispatchEvent(new Event("change")); },
};

function step(id, by) {
  $(id).value = +$(id).value + by;
  $(id).dispatchEvent(new Event("input"));
}

let lastFrame = 0;
function glide(now) {
  if (held.size === 0) { lastFrame = 0; sendCamera(false); return; }
  const seconds = lastFrame ? Math.min((now - lastFrame) / 1000, 0.1) : 0;
  lastFrame = now;
  if (seconds > 0) act(() => { for (const motion of held.values()) motion(seconds); }, true);
  requestAnimationFrame(glide);
}

canvas.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || !camera) return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (motions[key]) {
    event.preventDefault();
    if (event.repeat) return;
    const motion = (event.shiftKey && motions[key][1]) || motions[key][0];
    act(() => motion(0.12), true);  // a tap is a step
    if (held.size === 0) requestAnimationFrame(glide);
    held.set(key, motion);
  } else if (strokes[key]) {
    event.preventDefault();
    strokes[key]();
  }
});
canvas.addEventListener("keyup", (event) => held.delete(event.key.length === 1 ? event.key.toLowerCase() : event.key));
canvas.addEventListener("blur", () => held.clear());

// --- controls ---------------------------------------------------------------------------------------------------------------

$("exposure").addEventListener("input", () => {
  const stops = +$("exposure").value;
  $("exposure-value").textContent = `${stops > 0 ? "+" : stops < 0 ? "−" : ""}${Math.abs(stops)}`;
  draw();
});
$("tone").addEventListener("change", draw);
$("false-color").addEventListener("change", draw);
$("channel").addEventListener("change", () => { draw(); refresh(); });
$("fov").addEventListener("input", () => act(() => setFov(+$("fov").value), true));
$("fov").addEventListener("change", () => act(() => setFov(+$("fov").value)));
$("aperture").addEventListener("change", () => act(() => { if ($("aperture").value >= 0) camera.aperture = +$("aperture").value; }));
$("focus").addEventListener("change", () => act(() => { if ($("focus").value > 0) camera.focus = +$("focus").value; }));
$("max-depth").addEventListener("change", () => post("settings", { maxDepth: $("max-depth").value || 2 ** 30 }));
$("rr-depth").addEventListener("change", () => post("settings", { rrDepth: $("rr-depth").value }));
for (const id of ["nee", "mis"]) $(id).addEventListener("change", () => post("settings", { [id]: $(id).checked ? 1 : 0 }));
$("nearer").addEventListener("click", () => act(() => dolly(0.8)));
$("farther").addEventListener("click", () => act(() => dolly(1.25)));
$("reset").addEventListener("click", () => { touched = -Infinity; post("reset"); });
$("reload").addEventListener("click", () => post("reload"));
$("pause").addEventListener("click", () => post("settings", { paused: state && state.paused ? 0 : 1 }));
$("target").addEventListener("change", () => post("settings", { samples: $("target").value }));

function keep(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

async function save(extension) {
  const answer = await fetch(`picture.${extension}?exposure=${$("exposure").value}&tone=${$("tone").value}`);
  if (!answer.ok) { problem(await answer.text()); return; }
  const name = /filename="([^"]*)"/.exec(answer.headers.get("Content-Disposition") || "");
  keep(await answer.blob(), name ? name[1] : `picture.${extension}`);
}
$("save-exr").addEventListener("click", () => save("exr"));
$("save-png").addEventListener("click", () => save("png"));
$("save-shown").addEventListener("click", () => canvas.toBlob((blob) => keep(blob, `${(state && state.scene) || "picture"}-shown.png`)));

async function showCamera() {
  const answer = await fetch(`camera.xml?dialect=${$("dialect").value}`);
  const text = await answer.text();
  $("camera-text").value = text.trimEnd();
  return answer.ok;
}
$("camera-show").addEventListener("click", showCamera);
$("dialect").addEventListener("change", showCamera);
$("camera-copy").addEventListener("click", async () => {
  if (await showCamera()) copyText("camera-text", "The camera");
});

async function copyText(id, what) {
  try {
    await navigator.clipboard.writeText($(id).value);
    $("announcer").textContent = `${what} was copied to the clipboard.`;
  } catch {
    $(id).select();  // the clipboard needs a secure connection; without one, the user's own copy command works
    $("announcer").textContent = `${what} is selected; press Ctrl-C to copy it.`;
  }
}

document.addEventListener("visibilitychange", () => { if (!document.hidden) refresh(); });
addEventListener("DOMContentLoaded", follow);  // once the other scripts have loaded
