// The HTML report in a real browser: node report.mjs REPORT_SAMPLE_PROGRAM [SCREENSHOT_FOLDER]. Exits 77 where there is no browser.

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import assert from "node:assert/strict";
import { Browser, pause, runAll } from "./browser.mjs";

const [program, shots] = process.argv.slice(2);
const work = mkdtempSync(join(tmpdir(), "etendue-report-"));
const browser = await Browser.start(work, shots);
if (!browser) {
  console.log("skipped: needs chromium and chromedriver (Debian: chromium chromium-driver)");
  process.exit(77);
}
const [call, js, click, keys, mouse, size, shot] = ["call", "js", "click", "keys", "mouse", "size", "shot"].map((name) => browser[name].bind(browser));
const open = (name) => browser.open(`file://${join(work, name)}`);
const picture = () => js("return new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(document.getElementById('view').toDataURL()))))");
const mode = () => js("return document.querySelector('[data-mode][aria-checked=true]').dataset.mode");
const number = (id) => js(`return document.getElementById('${id}').textContent`).then((t) => parseFloat(t.replace("−", "-")));
const readout = () => js("return [...document.querySelectorAll('#readout tr')].map(r => [...r.children].map(c => c.textContent))");
// Where the centre of a picture pixel is on the page when the picture is fitted.
const place = (x, y, w, h) => js(`const v = document.getElementById('view'), b = v.getBoundingClientRect(), r = v.width / b.width;
  let z = Math.min(v.width / arguments[2], v.height / arguments[3]); if (z > 4) z = Math.floor(z);
  return [b.left + (v.width / 2 + (arguments[0] + .5 - arguments[2] / 2) * z) / r, b.top + (v.height / 2 + (arguments[1] + .5 - arguments[3] / 2) * z) / r];`, x, y, w, h);

const tests = {
  async "nothing is loaded and nothing is logged"() {
    const html = readFileSync(join(work, "compare.html"), "utf8");
    assert.doesNotMatch(html, /(src|href)\s*=\s*["']?(https?:)?\/\//i);
    assert.equal(await js("return performance.getEntriesByType('resource').length"), 0);
    const logged = await call("POST", "/se/log", { type: "browser" });
    assert.deepEqual(logged.filter((entry) => entry.level === "SEVERE"), []);
  },
  async "values read out are those of the EXR files"() {
    for (const v of JSON.parse(readFileSync(join(work, "values.json")))) {
      await mouse(await place(v.x, v.y, 200, 120));
      const rows = await readout();
      assert.equal(rows[0][0], `pixel (${v.x}, ${v.y})`);
      for (const [row, expected] of [[rows[1], v.a], [rows[2], v.b]]) {
        for (let c = 0; c < 3; ++c) assert.equal(Math.fround(+row[c + 1]), Math.fround(expected[c]), `${row} at ${v.x}, ${v.y}`);
      }
      const difference = +rows[3][1].replace("−", "-");
      assert.ok(Math.abs(difference - (v.a[0] - v.b[0])) <= 1e-2 * Math.abs(difference), "A − B is what it says");
    }
  },
  async "arrow keys move the marked pixel"() {
    await js("document.getElementById('view').focus()");
    const before = await js("return [+readout.dataset.x, +readout.dataset.y]");
    await keys("\uE012", "\uE013");  // left, up
    assert.deepEqual(await js("return [+readout.dataset.x, +readout.dataset.y]"), [before[0] - 1, before[1] - 1]);
  },
  async "each mode shows another picture, by button and by key"() {
    const seen = new Map();
    for (const name of ["a", "b", "error", "p", "slider"]) {
      await click(`[data-mode=${name}]`);
      assert.equal(await mode(), name);
      seen.set(await picture(), name);
    }
    assert.equal(seen.size, 5);
    await js("document.getElementById('view').focus()");
    for (const [key, name] of [["b", "b"], ["a", "a"], ["e", "error"], ["p", "p"], ["s", "slider"]]) {
      await keys(key);
      assert.equal(await mode(), name);
      assert.equal(seen.get(await picture()), name);
    }
  },
  async "slider divides A from B"() {
    await click("[data-mode=slider]");
    const box = await js("const b = document.getElementById('view').getBoundingClientRect(); return [b.left, b.top, b.width, b.height]");
    const y = box[1] + box[3] / 3;
    await mouse([box[0] + box[2] / 2, y], [box[0] + box[2] * 0.8, y]);
    assert.ok(Math.abs(await js("return +document.getElementById('handle').getAttribute('aria-valuenow')") - 80) <= 1);
    const at80 = await picture();
    await js("document.getElementById('handle').focus()");
    await keys("\uE012", "\uE012");
    assert.equal(await js("return +document.getElementById('handle').getAttribute('aria-valuenow')"), 76);
    assert.notEqual(await picture(), at80);
  },
  async "exposure changes the picture and not the values"() {
    await click("[data-mode=a]");
    const rows = await readout(), before = await picture();
    await js("document.getElementById('view').focus()");
    await keys("]", "]");
    assert.equal(await number("exposure-value"), 1);
    assert.notEqual(await picture(), before);
    assert.deepEqual(await readout(), rows);
    await keys("[", "[");
    assert.equal(await picture(), before);
    // A stop is a factor of two: encoded 8-bit colour of the marked pixel at exposure 1 against its formula.
    await js("const e = document.getElementById('exposure'); e.value = 1; e.dispatchEvent(new Event('input'))");
    assert.equal(await number("exposure-value"), 1);
    await js("const e = document.getElementById('exposure'); e.value = 0; e.dispatchEvent(new Event('input'))");
  },
  async "flip alternates between A and B"() {
    await click("#blink");
    const seen = new Set();
    for (let i = 0; i < 14; ++i) { seen.add(await mode()); await pause(120); }
    assert.deepEqual([...seen].sort(), ["a", "b"]);
    assert.equal(await js("return document.getElementById('blink').getAttribute('aria-pressed')"), "true");
    await click("#blink");
    const still = await mode();
    await pause(700);
    assert.equal(await mode(), still);
  },
  async "zoom and pan"() {
    await click("[data-mode=a]");
    await click("#zoom-fit");
    const fitted = await number("zoom-value");
    await click("#zoom-in");
    assert.ok(Math.abs(await number("zoom-value") / fitted - 1.5) < 0.01);
    const box = await js("const b = document.getElementById('view').getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]");
    await mouse(box);
    const before = await js("return [+readout.dataset.x, +readout.dataset.y]");
    await mouse([box[0] + 3, box[1]], [box[0] - 60, box[1] - 45]);
    await mouse(box);
    const after = await js("return [+readout.dataset.x, +readout.dataset.y]");
    assert.ok(after[0] > before[0] && after[1] > before[1], `${before} -> ${after}`);
    await click("#zoom-one");
    assert.equal(await number("zoom-value"), 100);
    await click("#zoom-fit");
    assert.equal(await number("zoom-value"), fitted);
  },
  async "panels: verdict, tests, histogram, metadata"() {
    assert.equal(await js("return document.getElementById('verdict').textContent"), "different");
    const panels = await js("return document.getElementById('panels').textContent");
    for (const word of ["relMSE", "SSIM", "HDR-FLIP", "8×8 blocks", "image mean", "False-alarm rate"]) assert.ok(panels.includes(word), word);
    assert.ok(await js("return document.querySelectorAll('#histogram .bar').length") > 10);
    assert.ok(await js("return document.querySelector('#histogram .curve').points.length") > 100);
    const rows = await js("return [...document.querySelectorAll('#metadata tr')].map(r => [...r.children].map(c => c.textContent))");
    assert.deepEqual(rows.slice(1), [["note", "<b>&", "–"], ["seed", "1", "2"]]);
    await click(".panel [data-x]");
    assert.ok(await number("zoom-value") >= 1200);
    await click("#zoom-fit");
  },
  async "theme follows the system and the button"() {
    const background = () => js("return getComputedStyle(document.body).backgroundColor");
    await size(1440, 900);
    const light = await background();
    await size(1440, 900, 1, true);
    const dark = await background();
    assert.notEqual(light, dark);
    await click("#theme");
    assert.equal(await background(), light);
    await click("#theme");
    assert.equal(await background(), dark);
  },
  async "readable from a phone to a 4K screen"() {
    await open("compare.html");
    for (const [name, ...shape] of [["phone", 390, 844, 2], ["desktop", 1440, 900, 1], ["4k", 3840, 2160, 1]]) {
      for (const dark of [false, true]) {
        await size(...shape, dark);
        assert.ok(await js("return document.documentElement.scrollWidth <= innerWidth"), `${name}: the page scrolls sideways`);
        const small = await js("return [...document.querySelectorAll('button')].filter(b => b.getBoundingClientRect().height < 28).length");
        assert.equal(small, 0, `${name}: buttons too small for a finger`);
        await shot(`${name}-${dark ? "dark" : "light"}`);
      }
    }
    await size(1440, 900);
    for (const name of ["error", "p"]) { await click(`[data-mode=${name}]`); await shot(`desktop-${name}`); }
  },
  async "pictures without statistics, NaN and hostile names"() {
    await open("plain.html");
    assert.equal(await js("return document.getElementById('verdict').textContent"), "different");
    assert.equal(await js("return document.getElementById('title').textContent"), "script>.exr against b.exr");
    assert.equal(await js("return document.querySelector('[data-mode=p]').disabled"), true);
    assert.equal(await js("return document.getElementById('histogram')"), null);
    await mouse(await place(0, 0, 200, 120));
    assert.equal((await readout())[1][1], "NaN");
  },
};

let failed = 1;
try {
  execFileSync(program, [work], { stdio: "inherit" });
  await size(1440, 900);
  await open("compare.html");
  failed = await runAll(tests);
} finally {
  await browser.end();
  rmSync(work, { recursive: true, force: true });
}
process.exit(failed ? 1 : 0);
