// Somebody who does anything at all with the page of `etendue view`: buttons, values that make no sense, drags, keys, tabs, files that
// change. Whatever it was, no script fails, the viewer lives, and with everything put back the picture is the first one again.
// node random.mjs ETENDUE_VIEW [SCREENSHOT_FOLDER [SECONDS [SEED]]]. Exits 77 where node's browser is missing.

import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import assert from "node:assert/strict";
import { Browser, pause } from "../browser/browser.mjs";
import { Viewer, makeScene, sceneText } from "./viewer.mjs";

const [program, shots, seconds = "20", seed = "1"] = process.argv.slice(2);
const work = mkdtempSync(join(tmpdir(), "etendue-view-random-"));
const lamp = '<mesh type="sphere"><point name="center" value="0, 2.5, 1"/><float name="radius" value="0.4"/><bsdf type="roughplastic"/><emitter type="area"><color name="radiance" value="4, 3, 2"/></emitter></mesh>';
const text = (albedo = "0.8, 0.2, 0.1") => sceneText({ albedo, extra: lamp });
const scene = makeScene();
writeFileSync(scene.file, text());
let b, viewer;

// A generator of its own, so that a seed brings the same deeds again.
let word = (+seed ^ 0x9e3779b9) >>> 0;
const random = () => { word ^= word << 13; word >>>= 0; word ^= word >>> 17; word ^= word << 5; word >>>= 0; return word / 2 ** 32; };
const below = (n) => Math.floor(random() * n);
const one = (list) => list[below(list.length)];

// Errors of the page's scripts are kept by the page itself; that of a page that was left would be lost.
const watch = () => b.js("if (!window.wrong) { window.wrong = []; addEventListener('error', (e) => wrong.push(e.message)); addEventListener('unhandledrejection', (e) => wrong.push(String(e.reason && e.reason.stack || e.reason))); }");
async function open() {
  await b.open(viewer.address);
  await b.until("document.readyState === 'complete'");
  await watch();
}
async function check(deeds) {
  const wrong = await b.js("return window.wrong || ['the page was not watched']");
  assert.deepEqual(wrong, [], `seed ${seed}, after ${deeds.slice(-8).join("; ")}`);
  assert.equal(viewer.process.exitCode, null, `the viewer ended: ${viewer.errors}`);
}

const values = ["0", "-1", "1", "0.5", "1e9", "1e-9", "nan", "inf", "", "x", "0.2, 0.9, 0.4", "1 2", "1,2,3,4", "10, 10, 60, 40", "-5, 0, 1, 1", "3", "17", "<b>", "é", "9".repeat(400)];
const place = async () => {
  const [left, top, width, height] = await b.js("const r = document.getElementById('view').getBoundingClientRect(); return [Math.max(0, r.left), Math.max(0, r.top), Math.min(innerWidth, r.right) - Math.max(0, r.left), Math.min(innerHeight, r.bottom) - Math.max(0, r.top)]");
  return width < 8 || height < 8 ? null : [left + 2 + random() * (width - 4), top + 2 + random() * (height - 4)];
};
const deeds = {
  async button() {
    return b.js(`const all = [...document.querySelectorAll('button')].filter((e) => !e.disabled && e.offsetParent && !e.id.startsWith('save-') && !e.id.endsWith('-copy'));
      const e = all[Math.floor(arguments[0] * all.length)]; e.click(); return e.id`, random());
  },
  async value() {
    return b.js(`const all = [...document.querySelectorAll('input, select')].filter((e) => e.offsetParent), e = all[Math.floor(arguments[0] * all.length)];
      if (e.type === 'checkbox') { e.click(); return e.id; }
      e.value = e.tagName === 'SELECT' ? e.options.length ? e.options[Math.floor(arguments[1] * e.options.length)].value : '' : e.type === 'range' ? +e.min + arguments[1] * (e.max - e.min) :
        e.type === 'color' ? '#' + Math.floor(arguments[1] * 0xffffff).toString(16).padStart(6, '0') : arguments[2];
      if (arguments[3] || e.tagName !== 'SELECT') e.dispatchEvent(new Event('input')); e.dispatchEvent(new Event('change')); return e.id + '=' + e.value`, random(), random(), one(values), random() < 0.5);
  },
  async drag() {
    const from = await place(), to = await place();
    if (from && to) await b.mouse(from, to, one([0, 0, 1, 2]));
  },
  async click() {
    const at = await place();
    if (at) await b.mouse(at, at);
  },
  async wheel() {
    const at = await place();
    if (at) await b.wheel(at, Math.round((random() - 0.5) * one([10, 300, 5000])));
  },
  async keys() {
    await b.js("document.getElementById('view').focus({ preventScroll: true })");
    await b.keys(...Array.from({ length: 1 + below(5) }, () => one(["\uE012", "\uE013", "\uE014", "\uE015", "w", "a", "s", "d", "q", "e", "+", "-", "f", "[", "]", "c", "v", " ", "r", "\uE004", "\uE00C", "1"])));
  },
  async file() {
    writeFileSync(scene.file, one([text(), text("0.1, 0.2, 0.9"), text().slice(0, below(800)), text().replace("sphere", "spere"), text().replace("160", String(1 + below(200)))]));
  },
  async size() { await b.size(...one([[390, 844, 2], [1440, 900, 1], [800, 300, 1]]), random() < 0.5); },
  async again() { await open(); },
  async burst() { await Promise.all(Array.from({ length: 20 }, () => viewer.post("reload").then((r) => r.arrayBuffer()).catch(() => {}))); },
};
const often = ["button", "button", "value", "value", "value", "value", "drag", "drag", "click", "wheel", "keys", "keys", "file", "size", "again", "burst"];

// What the first page showed comes back once all that others may have changed is as it was.
async function back() {
  writeFileSync(scene.file, text());
  await b.size(1440, 900);
  await open();
  await pause(1200);  // the file's new time is noticed
  await viewer.post("settings?crop=&samples=8&paused=0");
  await viewer.post("reload");
  await viewer.post("reset");
  await b.until("state && state.phase === 'done' && state.camera.mover === 0 && state.problem === '' && shape && shape.width === 160 && shape.height === 120 && state.samples === 8", "all is as at first", 60000);
  await pause(300);
  return b.js("return document.getElementById('view').toDataURL()");
}

async function run() {
  await open();
  const first = await back(), done = [], end = Date.now() + 1000 * seconds;
  while (Date.now() < end) {
    const deed = one(often);
    done.push(`${deed} ${await deeds[deed]() ?? ""}`.trim());
    await check(done);
    if (random() < 0.2) await pause(below(400));
  }
  await b.shot("random");
  await check(done);
  assert.equal(await back(), first, `seed ${seed}: another picture after ${done.length} deeds`);
  await check(done);
  const kilobytes = +/VmHWM:\s+(\d+)/.exec(readFileSync(`/proc/${viewer.process.pid}/status`, "utf8"))[1];
  console.log(`${done.length} deeds, seed ${seed}; the viewer took at most ${Math.round(kilobytes / 1024)} MiB`);
}

try {
  b = await Browser.start(work, shots);
  if (!b) {
    console.log("skipped: needs chromium and chromedriver (Debian: chromium chromium-driver)");
    process.exitCode = 77;
  } else {
    viewer = await Viewer.start(program, scene.file);
    await run();
  }
} finally {
  if (viewer) await viewer.end("SIGKILL");
  if (b) await b.end();
  rmSync(work, { recursive: true, force: true });
  scene.remove();
}
