// Draws the inspector's path over the picture, with its vertices where the camera sees them, for device and reference.
// The table below the picture says the same in words.
"use strict";

let explained = null;  // what device and reference answered for a sample, and for which scene

// Homogeneous film coordinates of a point (w = 1) or direction (w = 0) in world space, before the division.
const projected = (m, [x, y, z], w) => [0, 4, 8, 12].map((r) => m[r] * x + m[r + 1] * y + m[r + 2] * z + m[r + 3] * w);

// The position on the film of a spherical camera.
function onSphere({ origin, pixels }, [x, y, z]) {
  const share = [0.5 - 0.5 * Math.atan2(x, z) / Math.PI, Math.atan2(Math.hypot(x, z), y) / Math.PI];
  return [0, 1].map((i) => (share[i] - origin[i]) * pixels[i]);
}

// The position of a segment's end in the picture; null behind the camera.
function placeOf(projection, vertex) {
  const h = projected(projection.matrix, vertex.to, vertex.met ? 1 : 0);
  if (projection.kind === "sphere") return onSphere(projection, h);
  return h[3] > 0 ? [h[0] / h[3], h[1] / h[3]] : null;
}

// The two ends of the part of a line that lies inside the frame [left, top, right, bottom], or null if there is none.
// Clipping is done before the division, where each side of the frame is a plane, as is the boundary of what lies behind
// the camera.
function clippedLine(a, b, [left, top, right, bottom]) {
  const nearest = 1e-3 * Math.max(Math.abs(a[3]), Math.abs(b[3]));
  // Rays begin at the camera itself, where the direction would be rounding error alone.
  const sides = [(h) => h[3] - nearest, (h) => h[0] - left * h[3], (h) => right * h[3] - h[0], (h) => h[1] - top * h[3], (h) => bottom * h[3] - h[1]];
  let from = 0, to = 1;
  for (const side of sides) {
    const p = side(a), q = side(b);
    if (p < 0 && q < 0) return null;
    if (p < 0) from = Math.max(from, p / (p - q));
    if (q < 0) to = Math.min(to, p / (p - q));
  }
  const at = (t) => { const h = a.map((v, i) => v + t * (b[i] - v)); return [h[0] / h[3], h[1] / h[3]]; };
  return from <= to ? [at(from), at(to)] : null;
}

// A segment as lines in the picture. For a spherical camera it is curved, and may leave on one side and come back on
// the other.
function linesOf(projection, vertex, frame) {
  const a = projected(projection.matrix, vertex.from, 1), b = projected(projection.matrix, vertex.to, vertex.met ? 1 : 0);
  if (projection.kind === "plane") {
    const line = clippedLine(a, b, frame);
    return line ? [line] : [];
  }
  const kSteps = 64, lines = [[]];
  for (let i = 0; i <= kSteps; ++i) {
    const t = i / kSteps, place = onSphere(projection, a.map((v, k) => v + t * (b[k] - v)));
    const line = lines[lines.length - 1], last = line[line.length - 1];
    if (last && Math.abs(place[0] - last[0]) > projection.pixels[0] / 2) lines.push([place]);
    else line.push(place);
  }
  return lines;
}

const inFrame = (place, [left, top, right, bottom]) => place[0] >= left && place[0] <= right && place[1] >= top && place[1] <= bottom;

// The column "seen at" of the table: in words, what the drawing shows.
function seenAt(vertex) {
  const projection = state && state.camera.projection;
  if (!vertex.met) return "leaves the scene";
  if (!projection) return "–";
  const place = placeOf(projection, vertex), [x, y] = state.crop || [0, 0];
  if (!place) return "behind the camera";
  if (!inFrame(place, [x, y, x + state.fullWidth, y + state.fullHeight])) return "outside";
  return `(${place.map(Math.floor).join(", ")})`;
}

function shape2d(tag, attributes, parent) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  parent.append(made);
  return made;
}

function drawSegments(drawing, by, path, projection, frame) {
  for (const [i, vertex] of path.entries()) {
    for (const line of linesOf(projection, vertex, frame))
      shape2d("polyline", { class: `${by}${vertex.met ? "" : " leaves"}`, "data-vertex": i + 1, points: line.map((p) => p.map((v) => v.toFixed(2)).join()).join(" ") }, drawing);
  }
}

function drawBadge(drawing, by, number, place, unit) {
  const badge = shape2d("g", { class: `badge ${by}`, "data-vertex": number, transform: `translate(${place.map((v) => v.toFixed(2)).join(" ")}) scale(${unit})` }, drawing);
  shape2d("circle", { r: 9 }, badge);
  shape2d("text", { dy: "0.36em" }, badge).textContent = number;
}

// The first vertices come last, so that they lie on top.
function drawBadges(drawing, told, projection, frame, unit) {
  const seen = (vertex) => { const place = vertex && vertex.met && placeOf(projection, vertex); return place && inFrame(place, frame) ? place : null; };
  const device = told.device ? told.device.path : [], reference = told.reference ? told.reference.path : [];
  for (let i = Math.max(device.length, reference.length) - 1; i >= 0; --i) {
    const a = seen(device[i]), b = seen(reference[i]);
    const same = a && b && Math.hypot(a[0] - b[0], a[1] - b[1]) < 2 * unit;
    if (b && !same) drawBadge(drawing, "reference", i + 1, b, unit);
    if (a) drawBadge(drawing, same ? "both" : "device", i + 1, a, unit);
  }
}

function drawPath() {
  const drawing = $("drawn"), projection = state && state.camera.projection;
  const shown = explained && $("draw-path").checked && projection && state.fullWidth && !isStale();
  drawing.toggleAttribute("hidden", !shown);
  drawing.replaceChildren();
  if (!shown) return;
  const [x, y] = state.crop || [0, 0], frame = [x, y, x + state.fullWidth, y + state.fullHeight];
  drawing.setAttribute("viewBox", `${x} ${y} ${state.fullWidth} ${state.fullHeight}`);
  const box = canvas.getBoundingClientRect();
  const unit = 1 / Math.max(1e-6, Math.min(box.width / state.fullWidth, box.height / state.fullHeight));  // of the film, for one of the screen
  for (const by of ["reference", "device"])
    if (explained.told[by]) drawSegments(drawing, by, explained.told[by].path, projection, frame);
  drawBadges(drawing, explained.told, projection, frame, unit);
}

// Whether the path belongs to another scene than the one shown.
const isStale = () => ["loads", "materials", "lights"].some((count) => explained[count] !== state[count]);

// Redraws if the camera has moved or the scene has changed.
let drawnFor = "";
function followPath() {
  if (!explained) return;
  const now = JSON.stringify([state.camera.projection, state.crop, state.fullWidth, state.loads, state.materials, state.lights]);
  if (now === drawnFor) return;
  drawnFor = now;
  drawPath();
  const rows = $("path").querySelectorAll("tbody tr");
  for (const [i, row] of rows.entries()) row.querySelector(".seen").textContent = isStale() ? "–" : seenAt(eitherVertex(explained.told, i));
  if (isStale() && !explained.said) {
    explained.said = true;
    $("told").textContent += " The scene has changed since then; explain the path again.";
  }
}

const eitherVertex = (told, i) => (told.device && told.device.path[i]) || (told.reference && told.reference.path[i]);

function highlight(number) {
  for (const part of $("drawn").querySelectorAll("[data-vertex]")) part.classList.toggle("chosen", part.dataset.vertex === String(number));
}

// The reference answers first: the device has to compile a kernel before its first answer.
let explaining = 0;
async function explain() {
  const parameters = { x: $("pixel-x").value, y: $("pixel-y").value, sample: $("sample").value }, mine = ++explaining;
  const told = {};
  $("told").textContent = "…";
  try {
    await Promise.all(["reference", "device"].map(async (by) => {
      told[by] = await ask("explain", { ...parameters, by });
      if (mine === explaining) showPath(parameters, told);
    }));
  } catch (trouble) {
    if (mine !== explaining) return;
    $("told").textContent = trouble.message;
    $("path").hidden = $("path-key").hidden = true;
    explained = null;
    drawPath();
  }
}

// Both use the same random numbers, so their paths are the same except for rounding.
function showPath({ x, y, sample }, told) {
  const table = $("path").firstElementChild, words = ["meets", "light", "reached", "lobe", "survives"];
  const cells = (tag, texts) => texts.map((text) => { const cell = document.createElement(tag); cell.textContent = text; return cell; });
  const number = (v) => v ? v.radiance.map((n) => n.toPrecision(4)).join(" ") : "–";
  const head = document.createElement("tr"), both = told.device && told.reference;
  const device = told.device ? told.device.path : [], reference = told.reference ? told.reference.path : [];
  head.append(...cells("th", ["segment", "meets", "seen at", "light", "reached", "lobe", "survives", "light so far: device", "reference"]));
  table.replaceChildren(document.createElement("thead"), document.createElement("tbody"));
  table.tHead.append(head);
  let different = 0;
  for (let i = 0; i < Math.max(device.length, reference.length); ++i) {
    const row = document.createElement("tr"), a = device[i], b = reference[i];
    const texts = words.map((word) => !both || (a && b && a[word] === b[word]) ? (a || b)[word] : `${a ? a[word] : "–"} / ${b ? b[word] : "–"}`);
    if (both && texts.some((text) => text.includes(" / "))) { row.className = "differs"; ++different; }
    texts.splice(1, 0, seenAt(a || b));
    row.append(...cells("td", [i + 1, ...texts, number(a), number(b)]));
    row.children[2].className = "seen";
    row.tabIndex = 0;
    for (const event of ["pointerenter", "focus"]) row.addEventListener(event, () => highlight(i + 1));
    for (const event of ["pointerleave", "blur"]) row.addEventListener(event, () => highlight(0));
    table.tBodies[0].append(row);
  }
  $("path").hidden = $("path-key").hidden = false;
  const where = `Pixel (${x}, ${y}), sample ${sample}`;
  $("told").textContent = !both ? `${where}: ${told.reference ? "the reference has answered; waiting for the device" : "the device has answered; waiting for the reference"} …` :
    `${where}, on ${told.device.device} and the reference: ${different ? `${different} vertices decided differently` : "the same decisions"}.`;
  explained = { told, loads: state.loads, materials: state.materials, lights: state.lights, said: false };
  drawnFor = "";
  followPath();
}
$("inspect").addEventListener("submit", (event) => { event.preventDefault(); explain(); });
$("draw-path").addEventListener("change", drawPath);
addEventListener("resize", () => explained && drawPath());
