"use strict";
(() => {
const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);
// Of a large picture the page holds the means of squares of `reduction` × `reduction` pixels.
const { width, height, reduction } = data;

// --- Data: float32 triples in base64, little-endian like every browser's typed arrays -----------------------------------------
function floats(id) {
  const element = $(id), text = element.textContent;
  element.textContent = "";  // the text is several times as large as the numbers
  if (!text) return null;
  const binary = atob(text), bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = binary.charCodeAt(i);
  return new Float32Array(bytes.buffer);
}
const a = floats("pixels-a"), b = floats("pixels-b"), z = floats("scores");

// Shortest decimal that reads back as the same float32.
function shortest(x) {
  if (Number.isNaN(x)) return "NaN";
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "−∞";
  for (let digits = 1; digits < 9; ++digits) {
    const text = x.toPrecision(digits);
    if (Math.fround(+text) === x) return String(+text);
  }
  return String(+x.toPrecision(9));
}
function brief(x) {
  if (x === null || x === undefined) return "–";
  if (x !== 0 && (Math.abs(x) < 1e-3 || Math.abs(x) >= 1e6)) return x.toExponential(2).replace("-", "−");
  return String(+x.toPrecision(4)).replace("-", "−");
}

// Two-sided normal tail: erfc by its continued fraction for large arguments, by its series for small ones.
function twoSided(score) {
  const x = Math.abs(score) / Math.SQRT2;
  if (x === 0) return 1;
  if (x < 2.5) {
    let term = x, sum = x;
    for (let n = 1; n < 80; ++n) { term *= -x * x / n; sum += term / (2 * n + 1); }
    return 1 - 2 / Math.sqrt(Math.PI) * sum;
  }
  let fraction = 0;
  for (let n = 60; n > 0; --n) fraction = n / 2 / (x + fraction);
  return Math.exp(-x * x) / Math.sqrt(Math.PI) / (x + fraction);
}

// --- Colours --------------------------------------------------------------------------------------------------------------
const encode = new Uint8ClampedArray(4097);  // sRGB curve
for (let i = 0; i <= 4096; ++i) {
  const x = i / 4096;
  encode[i] = Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * Math.pow(x, 1 / 2.4) - 0.055));
}
const rampStops = [[10, 10, 32], [62, 28, 110], [146, 42, 120], [216, 78, 76], [247, 152, 52], [252, 252, 190]];
function ramp(t) {
  const s = Math.min(Math.max(t, 0), 1) * (rampStops.length - 1), i = Math.min(Math.floor(s), rampStops.length - 2), f = s - i;
  return rampStops[i].map((c, k) => Math.round(c + (rampStops[i + 1][k] - c) * f));
}
const rampTable = Array.from({ length: 256 }, (_, i) => ramp(i / 255));
const nanColor = [255, 0, 255];

function paint(fill) {
  const canvas = document.createElement("canvas");
  canvas.width = width; canvas.height = height;
  const context = canvas.getContext("2d"), image = context.createImageData(width, height), out = image.data;
  for (let i = 0; i < width * height; ++i) {
    fill(i, out, 4 * i);
    out[4 * i + 3] = 255;
  }
  context.putImageData(image, 0, 0);
  return canvas;
}
function paintPicture(pixels) {
  const scale = 4096 * Math.pow(2, state.exposure);
  return paint((i, out, o) => {
    for (let c = 0; c < 3; ++c) {
      const v = pixels[3 * i + c];
      if (!Number.isFinite(v)) { [out[o], out[o + 1], out[o + 2]] = nanColor; return; }
      out[o + c] = encode[Math.min(4096, Math.max(0, Math.round(v * scale)))];
    }
  });
}
function put(out, o, t) {
  const color = Number.isFinite(t) ? rampTable[Math.round(255 * Math.min(Math.max(t, 0), 1))] : nanColor;
  [out[o], out[o + 1], out[o + 2]] = color;
}
// Largest relative difference of a channel, from 10⁻⁴ to 1 on a logarithmic scale; 0.01 keeps black from deciding.
function relativeError(i) {
  let worst = 0;
  for (let c = 0; c < 3; ++c) {
    const d = Math.abs(a[3 * i + c] - b[3 * i + c]) / (Math.abs(b[3 * i + c]) + 0.01);
    if (!(d <= worst)) worst = d;
  }
  return worst;
}
const paintError = () => paint((i, out, o) => { const e = relativeError(i); put(out, o, e === 0 ? 0 : 1 + Math.log10(e) / 4); });
function largestScore(i) { return Math.max(Math.abs(z[3 * i]), Math.abs(z[3 * i + 1]), Math.abs(z[3 * i + 2])); }
// From p = 1 to 10⁻⁸ on a logarithmic scale.
const paintP = () => paint((i, out, o) => put(out, o, -Math.log10(Math.max(twoSided(largestScore(i)), 1e-300)) / 8));

// --- State and drawing ----------------------------------------------------------------------------------------------------
const state = { mode: "slider", exposure: 0, zoom: 1, x: width / 2, y: height / 2, split: 0.5, pixel: null, fitted: true };
const layers = {};
function layer(name) {
  if (!layers[name]) {
    layers[name] = name === "a" ? paintPicture(a) : name === "b" ? paintPicture(b) : name === "error" ? paintError() : paintP();
  }
  return layers[name];
}
const view = $("view"), context = view.getContext("2d");
const ratio = () => window.devicePixelRatio || 1;

// Canvas coordinates (device pixels) of picture coordinates and back.
const toScreen = (x, y) => [view.width / 2 + (x - state.x) * state.zoom, view.height / 2 + (y - state.y) * state.zoom];
const toPicture = (sx, sy) => [state.x + (sx - view.width / 2) / state.zoom, state.y + (sy - view.height / 2) / state.zoom];

function drawLayer(name) {
  const [x, y] = toScreen(0, 0);
  context.imageSmoothingEnabled = state.zoom < 1;
  context.drawImage(layer(name), x, y, width * state.zoom, height * state.zoom);
}
let queued = false;
function draw() {
  if (queued) return;
  queued = true;
  requestAnimationFrame(() => { queued = false; drawNow(); });
}
function drawNow() {
  context.clearRect(0, 0, view.width, view.height);
  if (state.mode === "slider") {
    const split = Math.round(view.width * state.split);
    drawLayer("a");
    context.save();
    context.beginPath(); context.rect(split, 0, view.width - split, view.height); context.clip();
    drawLayer("b");
    context.restore();
  } else drawLayer(state.mode);
  if (state.pixel) {
    const [x, y] = toScreen(state.pixel[0], state.pixel[1]), size = Math.max(state.zoom, 5);
    const ox = x + (state.zoom - size) / 2, oy = y + (state.zoom - size) / 2;
    context.lineWidth = 1; context.strokeStyle = "#000"; context.strokeRect(ox - 1.5, oy - 1.5, size + 3, size + 3);
    context.strokeStyle = "#fff"; context.strokeRect(ox - .5, oy - .5, size + 1, size + 1);
  }
}
function fit() {
  state.zoom = Math.min(view.width / width, view.height / height);
  if (state.zoom > 4) state.zoom = Math.floor(state.zoom);  // pixels of equal size, where that costs little room
  state.x = width / 2; state.y = height / 2; state.fitted = true;
  showZoom();
}
function resize() {
  const box = view.getBoundingClientRect();
  view.width = Math.max(1, Math.round(box.width * ratio())); view.height = Math.max(1, Math.round(box.height * ratio()));
  if (state.fitted) fit(); else draw();
}
function showZoom() { $("zoom-value").textContent = `${Math.round(100 * state.zoom / ratio())} %`; draw(); }
function zoomBy(factor, sx = view.width / 2, sy = view.height / 2) {
  const [x, y] = toPicture(sx, sy);
  state.zoom = Math.min(Math.max(state.zoom * factor, 0.02), 256);
  state.x = x - (sx - view.width / 2) / state.zoom; state.y = y - (sy - view.height / 2) / state.zoom;
  state.fitted = false;
  showZoom();
}
function setMode(mode) {
  if (mode === "p" && !z) return;
  state.mode = mode;
  for (const button of document.querySelectorAll("[data-mode]")) {
    const on = button.dataset.mode === mode;
    button.setAttribute("aria-checked", on);
    button.tabIndex = on ? 0 : -1;
  }
  $("handle").style.display = mode === "slider" ? "block" : "none";
  showLegend();
  draw();
}
function setExposure(value) {
  state.exposure = Math.min(Math.max(Math.round(value * 10) / 10, -10), 10);
  $("exposure").value = state.exposure;
  $("exposure-value").textContent = (state.exposure > 0 ? "+" : "") + state.exposure.toFixed(1);
  delete layers.a; delete layers.b;
  draw();
}
function setSplit(value) {
  state.split = Math.min(Math.max(value, 0), 1);
  $("handle").style.left = `${100 * state.split}%`;
  $("handle").setAttribute("aria-valuenow", Math.round(100 * state.split));
  draw();
}
function showLegend() {
  const legend = $("legend"), texts = { error: ["relative difference", "10⁻⁴", "10⁻²", "1"], p: ["p-value (smallest of r, g, b)", "1", "10⁻⁴", "10⁻⁸"] }[state.mode];
  legend.style.display = texts ? "block" : "none";
  if (!texts) return;
  const gradient = rampStops.map((c) => `rgb(${c})`).join(",");
  legend.innerHTML = `<span>${texts[0]}</span><i style="background:linear-gradient(90deg,${gradient})"></i>` +
      `<div>${texts.slice(1).map((t) => `<span>${t}</span>`).join("")}</div>`;
}

// --- Read-out -------------------------------------------------------------------------------------------------------------
function row(head, values, kind = "td") {
  return `<tr><th scope="row">${head}</th>${values.map((v) => `<${kind}>${v}</${kind}>`).join("")}</tr>`;
}
function mark(x, y) {
  x = Math.min(Math.max(x, 0), width - 1); y = Math.min(Math.max(y, 0), height - 1);
  state.pixel = [x, y];
  const i = y * width + x, rgb = [0, 1, 2], value = (p) => rgb.map((c) => shortest(p[3 * i + c]));
  const first = [x * reduction, y * reduction];
  const last = [Math.min(first[0] + reduction, data.fullWidth) - 1, Math.min(first[1] + reduction, data.fullHeight) - 1];
  const place = reduction === 1 ? `pixel (${x}, ${y})` : `mean of pixels (${first}) to (${last})`;
  const rows = [row("A", value(a)), row("B", value(b)), row("A − B", rgb.map((c) => brief(a[3 * i + c] - b[3 * i + c])))];
  if (z) {
    rows.push(row(reduction === 1 ? "z" : "worst z", rgb.map((c) => brief(z[3 * i + c]))));
    rows.push(row("p", rgb.map((c) => brief(twoSided(z[3 * i + c])))));
  }
  const readout = $("readout");
  readout.dataset.x = x; readout.dataset.y = y;
  readout.innerHTML = `<table><tr><th>${place}</th><td>red</td><td>green</td><td>blue</td></tr>${rows.join("")}</table>`;
  draw();
}

// --- Pointer, wheel, keys -------------------------------------------------------------------------------------------------
const pointers = new Map();
let moved = 0, pinch = 0;
const local = (event) => {
  const box = view.getBoundingClientRect();
  return [(event.clientX - box.left) * ratio(), (event.clientY - box.top) * ratio()];
};
const markAt = (event) => {
  const [x, y] = toPicture(...local(event));
  if (x >= 0 && y >= 0 && x < width && y < height) mark(Math.floor(x), Math.floor(y));
};
const spread = () => { const [p, q] = [...pointers.values()]; return Math.hypot(p[0] - q[0], p[1] - q[1]); };
view.addEventListener("pointerdown", (event) => {
  view.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, local(event));
  moved = 0;
  if (pointers.size === 2) pinch = spread();
});
view.addEventListener("pointermove", (event) => {
  if (!pointers.has(event.pointerId)) { if (event.pointerType === "mouse") markAt(event); return; }
  const before = pointers.get(event.pointerId), now = local(event);
  pointers.set(event.pointerId, now);
  if (pointers.size === 2) {
    const [p, q] = [...pointers.values()], size = spread();
    if (pinch > 0) zoomBy(size / pinch, (p[0] + q[0]) / 2, (p[1] + q[1]) / 2);
    pinch = size; moved = 99;
    return;
  }
  moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
  if (moved > 4) {
    state.x -= (now[0] - before[0]) / state.zoom; state.y -= (now[1] - before[1]) / state.zoom; state.fitted = false;
    draw();
  }
});
const release = (event) => { if (pointers.delete(event.pointerId) && event.type === "pointerup" && moved <= 4) markAt(event); };
view.addEventListener("pointerup", release);
view.addEventListener("pointercancel", release);
view.addEventListener("wheel", (event) => { event.preventDefault(); zoomBy(Math.pow(1.0018, -event.deltaY), ...local(event)); }, { passive: false });

const handle = $("handle");
const slide = (event) => { const box = view.getBoundingClientRect(); setSplit((event.clientX - box.left) / box.width); };
handle.addEventListener("pointerdown", (event) => { handle.setPointerCapture(event.pointerId); slide(event); });
handle.addEventListener("pointermove", (event) => {
  if (handle.hasPointerCapture(event.pointerId)) slide(event); else if (event.pointerType === "mouse") markAt(event);
});
handle.addEventListener("keydown", (event) => {
  const step = { ArrowLeft: -0.02, ArrowRight: 0.02 }[event.key];
  if (step) { setSplit(state.split + step); event.preventDefault(); event.stopPropagation(); }
});

let timer = null;
function setBlink(on) {
  clearInterval(timer);
  timer = on ? setInterval(() => setMode(state.mode === "a" ? "b" : "a"), 500) : null;
  $("blink").setAttribute("aria-pressed", on);
  if (on) setMode(state.mode === "a" ? "b" : "a");
}
function toggleTheme() {
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  root.dataset.theme = dark ? "light" : "dark";
}
function pick(mode) { setBlink(false); setMode(mode); }
const keys = {
  a: () => pick("a"), b: () => pick("b"), s: () => pick("slider"), e: () => pick("error"), p: () => pick("p"),
  "[": () => setExposure(state.exposure - 0.5), "]": () => setExposure(state.exposure + 0.5),
  "+": () => zoomBy(1.5), "=": () => zoomBy(1.5), "-": () => zoomBy(1 / 1.5), "0": fit,
  "1": () => zoomBy(ratio() / state.zoom), t: toggleTheme,
};
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const tag = event.target.tagName;
  if (event.key === " " && tag !== "BUTTON" && tag !== "SUMMARY" && tag !== "INPUT") { setBlink(!timer); event.preventDefault(); return; }
  const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  if (arrow && event.target === view) {
    const step = event.shiftKey ? 10 : 1, [x, y] = state.pixel || [Math.floor(width / 2), Math.floor(height / 2)];
    mark(x + step * arrow[0], y + step * arrow[1]);
    event.preventDefault();
    return;
  }
  if (arrow && event.target.dataset.mode) {  // arrows walk a radio group
    const buttons = [...document.querySelectorAll("[data-mode]:not(:disabled)")], i = buttons.indexOf(event.target);
    const next = buttons[(i + (arrow[0] + arrow[1]) + buttons.length) % buttons.length];
    pick(next.dataset.mode); next.focus(); event.preventDefault();
    return;
  }
  const action = keys[event.key.toLowerCase()];
  if (action) { action(); event.preventDefault(); }
});
for (const button of document.querySelectorAll("[data-mode]")) button.addEventListener("click", () => pick(button.dataset.mode));
$("blink").addEventListener("click", () => setBlink(!timer));
$("exposure").addEventListener("input", (event) => setExposure(+event.target.value));
$("exposure").addEventListener("dblclick", () => setExposure(0));
$("zoom-in").addEventListener("click", () => zoomBy(1.5));
$("zoom-out").addEventListener("click", () => zoomBy(1 / 1.5));
$("zoom-fit").addEventListener("click", fit);
$("zoom-one").addEventListener("click", () => zoomBy(ratio() / state.zoom));
$("theme").addEventListener("click", toggleTheme);

// --- Panels ---------------------------------------------------------------------------------------------------------------
function panel(title, html) {
  const section = document.createElement("section");
  section.className = "panel";
  section.innerHTML = `<h2>${title}</h2>${html}`;
  $("panels").append(section);
  return section;
}
function text(value) { const span = document.createElement("span"); span.textContent = value; return span.innerHTML; }
function pairs(rows) { return `<table>${rows.map(([k, v]) => `<tr><th scope="row">${k}</th><td>${v}</td></tr>`).join("")}</table>`; }

function metricsPanel(c) {
  const m = c.metrics, percent = (x) => `${brief(100 * x)} %`, range = (i, f) => `[${f(i[0])}, ${f(i[1])}]`;
  const rows = [["MSE", brief(m.mse)], ["RMSE", brief(m.rmse)], ["relMSE", brief(m.relmse)], ["MAE", brief(m.mae)],
    ["PSNR", m.psnr === null ? "∞ dB" : `${brief(m.psnr)} dB`], ["SSIM", brief(m.ssim)]];
  if (m.flip !== null) rows.push(["FLIP (clamped to [0, 1])", brief(m.flip)]);
  if (m.hdrflip !== null) rows.push(["HDR-FLIP", brief(m.hdrflip)]);
  rows.push(["bias of the luminance", `${brief(m.bias)} ${range(m.biasInterval, brief)}`],
    ["relative bias", `${percent(m.relbias)} ${range(m.relbiasInterval, percent)}`]);
  if (m.nonfinite) rows.push(["NaN or infinite pixels", `<span class="failed">${m.nonfinite}</span>`]);
  for (const l of c.limits) {
    rows.push([`limit on ${text(l.metric)}`, `<span class="${l.kept ? "passed" : "failed"}">${brief(l.value)} ${l.side === "above" ? "≤" : "≥"} ${brief(l.limit)}: ${l.kept ? "kept" : "failed"}</span>`]);
  }
  panel("Distance of A from B", pairs(rows) + `<p>Intervals hold with ${100 * m.biasLevel} % confidence, from the ${m.biasFrom}.</p>` +
    c.notes.map((n) => `<p>${text(n)}</p>`).join(""));
}
function testsPanel(t) {
  const rows = t.families.map((f) => f.tests === 0 ? row(text(f.name), ["none", "", "", ""]) :
    row(text(f.name), [f.tests, brief(f.familyP), f.rejectedByHolm, `<span class="${f.passed ? "passed" : "failed"}">${f.passed ? "passed" : "failed"}</span>`]));
  const worst = t.families.filter((f) => f.tests > 0).map((f) =>
    `<button type="button" data-x="${f.worst.x}" data-y="${f.worst.y}" title="Show this pixel">${text(f.name)}: (${f.worst.x}, ${f.worst.y}) ${f.worst.channel}, z = ${brief(f.worst.z)}</button>`);
  const section = panel("Does chance explain the difference?",
    `<div class="scroll"><table><tr><th>means of</th><td>tests</td><td>family p</td><td>rejected</td><td></td></tr>${rows.join("")}</table></div>` +
    `<p>False-alarm rate ${brief(t.significance)} for all tests together, Šidák inside each family. A bias of ` +
    `${brief(100 * t.detectableRelativeBias)} % of the image mean would be found with probability 0.99.</p><p>Worst places: ${worst.join(" ")}</p>`);
  for (const button of section.querySelectorAll("[data-x]")) {
    button.addEventListener("click", () => {
      mark(Math.floor(button.dataset.x / reduction), Math.floor(button.dataset.y / reduction));
      state.x = state.pixel[0] + .5; state.y = state.pixel[1] + .5; state.zoom = Math.max(state.zoom, 12 * ratio()); state.fitted = false;
      showZoom();
      view.scrollIntoView({ block: "nearest", behavior: "smooth" });
    });
  }
}
// Scores against the standard normal density; a right pair of pictures fills the curve.
function histogramPanel() {
  if (reduction > 1) return;  // the page holds the worst score of each square, which follows another law
  const bins = 48, limit = 6, counts = new Array(bins).fill(0);
  let n = 0, outside = 0;
  for (const score of z) {
    if (score === 0 || !Number.isFinite(score)) continue;  // 0: not tested, or equal to the bit
    ++n;
    if (Math.abs(score) >= limit) ++outside; else ++counts[Math.floor((score + limit) / (2 * limit) * bins)];
  }
  if (n === 0) return;
  const w = 480, h = 220, base = h - 24, step = 2 * limit / bins, density = (x) => Math.exp(-x * x / 2) / Math.sqrt(2 * Math.PI);
  const top = Math.max(density(0), ...counts.map((c) => c / n / step)) * 1.08;
  const px = (x) => 10 + (x + limit) / (2 * limit) * (w - 20), py = (y) => base - y / top * (base - 8);
  const bars = counts.map((c, i) => c === 0 ? "" : `<rect class="bar" x="${px(-limit + i * step).toFixed(1)}" y="${py(c / n / step).toFixed(1)}" width="${((w - 20) / bins - 1).toFixed(1)}" height="${(base - py(c / n / step)).toFixed(1)}"/>`);
  const curve = Array.from({ length: 121 }, (_, i) => -limit + i * limit / 60).map((x) => `${px(x).toFixed(1)},${py(density(x)).toFixed(1)}`);
  const ticks = [-6, -4, -2, 0, 2, 4, 6].map((x) => `<text x="${px(x)}" y="${h - 6}" text-anchor="middle">${String(x).replace("-", "−")}</text>`);
  panel("Scores against the normal curve", `<svg id="histogram" viewBox="0 0 ${w} ${h}" role="img" aria-label="Histogram of ${n} z-scores with the standard normal density">` +
    `<line class="axis" x1="10" x2="${w - 10}" y1="${base}" y2="${base}"/>${bars.join("")}<polyline class="curve" points="${curve.join(" ")}"/>${ticks.join("")}</svg>` +
    `<p>${n} scores of pixels and channels, ${outside} beyond ±${limit} (expected ${brief(n * twoSided(limit))}). Equal pictures with independent noise fill the curve; ` +
    `a shift is a bias, a wide base a wrong place, a narrow one shared noise.</p>`);
}
function samplesPanel(v) {
  const s = v.L2;
  panel("Sample by sample, equal random numbers", pairs([["samples", s.samples], ["equal to the bit", s.equalToTheBit],
    ["branch flips per million", `${brief(s.flipsPerMillion)} (limit ${s.limits.flipsPerMillion})`],
    ["median relative error", `${brief(s.medianError)} (limit ${brief(s.limits.median)})`], ["99.9 % relative error", brief(s.p999Error)],
    ["largest relative error", brief(s.maxError)], ["beyond " + s.limits.off + ", per million", `${brief(s.offPerMillion)} (limit ${s.limits.offPerMillion})`],
    ["paired p of the means", brief(s.pairedP)]]) +
    (s.located.length ? `<p>${s.located.slice(0, 5).map((d) => text(d.what ? `pixel (${d.x}, ${d.y}), sample ${d.sample}, bounce ${d.bounce}: ${d.what} ${d.device} on the device, ${d.reference} on the reference` :
      `pixel (${d.x}, ${d.y}), sample ${d.sample}: relative error ${brief(d.relativeError)}`)).join("<br>")}</p>` : "") +
    (Object.keys(s.firstDifferences).length ? `<p>First differences: ${Object.entries(s.firstDifferences).map(([k, n]) => `${text(k)} × ${n}`).join(" · ")}</p>` : ""));
}
function metadataPanel(rows) {
  const body = rows.length === 0 ? "<p>No difference.</p>" :
    `<div class="scroll"><table id="metadata"><tr><th></th><td class="text">A</td><td class="text">B</td></tr>${rows.map((d) =>
      `<tr><th scope="row">${text(d.name)}</th><td class="text">${text(d.test) || "–"}</td><td class="text">${text(d.reference) || "–"}</td></tr>`).join("")}</table></div>`;
  panel("Metadata that differ", body);
}

// --- Start ----------------------------------------------------------------------------------------------------------------
$("title").textContent = data.title;
$("subtitle").textContent = data.subtitle + (reduction > 1 ? ` · shown as means of ${reduction} × ${reduction} pixels` : "");
$("verdict").textContent = data.verdict;
$("verdict").className = data.verdict === "not tested" && data.passed ? "" : data.passed ? "good" : "bad";
$("label-a").textContent = data.labelA;
$("label-b").textContent = data.labelB;
if (!z) document.querySelector('[data-mode="p"]').disabled = true;
if (data.validation) samplesPanel(data.validation);
if (data.comparison.tests) testsPanel(data.comparison.tests);
metricsPanel(data.comparison);
if (z) histogramPanel();
metadataPanel(data.comparison.metadata);
$("stage").style.setProperty("--shape", `${width} / ${height}`);
new ResizeObserver(resize).observe($("stage"));
resize();
setMode("slider");
setSplit(0.5);
mark(Math.floor(width / 2), Math.floor(height / 2));
})();
