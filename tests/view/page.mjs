// The page of `etendue view` in a real browser: node page.mjs ETENDUE_VIEW [SCREENSHOT_FOLDER]; exits with 77 if there is no
// browser.

import { mkdirSync, mkdtempSync, readdirSync, rmSync, unlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import assert from "node:assert/strict";
import { Browser, pause, runAll } from "../browser/browser.mjs";
import { Viewer, floorText, makeScene, sceneText } from "./viewer.mjs";

const [program, shots] = process.argv.slice(2);
const work = mkdtempSync(join(tmpdir(), "etendue-view-page-"));
const scene = makeScene();
const downloads = join(work, "downloads");
mkdirSync(downloads);
let b, viewer;

const camera = () => b.js("return structuredClone(camera)");
// Whether the picture is complete and belongs to the camera on the page.
const settled = () => b.until(`state && state.phase === 'done' && camera && !sending && !going && !unsent &&
  ["eye", "target", "up", "fov"].every((name) => String(state.camera[name]) === String(camera[name]))`);
async function reset() {
  await b.click("#reset");
  await b.until("state.camera.mover === 0");
  await settled();
}
const middle = () => b.js("const r = document.getElementById('view').getBoundingClientRect(); return [r.left + r.width / 2, r.top + r.height / 2]");
const shown = () => b.js("return document.getElementById('view').toDataURL()");
const text = (id) => b.js(`return document.getElementById('${id}').textContent`);
const choose = (id, value) => b.js("const e = document.getElementById(arguments[0]); e.value = arguments[1]; e.dispatchEvent(new Event('change'))", id, value);
const focus = () => b.js("document.getElementById('view').focus()");
const length = (v) => Math.hypot(...v);
const minus = (a, c) => a.map((x, i) => x - c[i]);

async function open() {
  await b.open(viewer.address);
  await settled();
}

const tests = {
  async "a picture, nothing from elsewhere, nothing logged"() {
    await open();
    assert.equal(await text("scene"), "two-spheres");
    assert.equal(await b.js("return document.getElementById('view').width"), 160);
    const colors = await b.js("const d = context.getImageData(0, 0, 160, 120).data, s = new Set(); for (let i = 0; i < d.length; i += 4) s.add(d[i] << 16 | d[i + 1] << 8 | d[i + 2]); return s.size");
    assert.ok(colors > 100, `${colors} colours`);
    const sites = await b.js("return performance.getEntriesByType('resource').map((e) => new URL(e.name).origin).filter((o) => o !== location.origin)");
    assert.deepEqual(sites, []);
    const logged = await b.call("POST", "/se/log", { type: "browser" });
    assert.deepEqual(logged.filter((entry) => entry.level === "SEVERE"), []);
    assert.match(await text("samples"), /8 of 8/);
    assert.match(await text("error"), /%$/);
  },
  async "dragging orbits: the target stays, the picture follows the mouse"() {
    const before = await camera(), picture = await shown(), at = await middle();
    const red = () => b.js("let n = 0, x = 0; for (let i = 0; i < mean.length / 3; ++i) if (numbers[mean[3 * i]] > 3 * numbers[mean[3 * i + 2]]) { ++n; x += i % shape.width; } return x / n");
    const place = await red();
    await b.mouse(at, [at[0] + 60, at[1]]);
    await settled();
    const after = await camera();
    assert.deepEqual(after.target, before.target);
    assert.ok(Math.abs(length(minus(after.eye, after.target)) / length(minus(before.eye, before.target)) - 1) < 1e-9, "as far away as before");
    assert.ok(length(minus(after.eye, before.eye)) > 0.5);
    assert.notEqual(await shown(), picture);
    // The server has the same camera and renders from there.
    const server = await viewer.until((s) => s.phase === "done");
    assert.deepEqual(server.camera.eye, after.eye);
    assert.ok(Math.abs(await red() - place) > 1, "the red sphere is elsewhere");
    await reset();
    assert.equal(await shown(), picture, "the same picture as before, to the byte");
  },
  async "dragging with Shift's mode pans, the right button looks around, the wheel goes nearer"() {
    const at = await middle();
    let before = await camera();
    await b.js("document.getElementById('drag').value = 'pan'");
    await b.mouse(at, [at[0] + 40, at[1] + 20]);
    await settled();
    let after = await camera();
    assert.ok(length(minus(minus(after.eye, before.eye), minus(after.target, before.target))) < 1e-9, "eye and target move alike");
    assert.ok(length(minus(after.eye, before.eye)) > 0.1);
    await b.js("document.getElementById('drag').value = 'orbit'");
    before = after;
    await b.mouse(at, [at[0] + 40, at[1]], 2);
    await settled();
    after = await camera();
    assert.deepEqual(after.eye, before.eye);
    assert.ok(length(minus(after.target, before.target)) > 0.1);
    before = after;
    await b.wheel(at, -200);
    await settled();
    after = await camera();
    assert.ok(length(minus(after.eye, after.target)) < 0.9 * length(minus(before.eye, before.target)));
    await reset();
  },
  async "keys: orbit, walk, field of view, exposure, false colour"() {
    await focus();
    let before = await camera();
    for (const [key, what] of [["\uE012", "orbit"], ["w", "walk"], ["e", "up"]]) {
      await b.keys(key);
      await settled();
      const after = await camera();
      assert.ok(length(minus(after.eye, before.eye)) > 0.01, what);
      before = after;
    }
    await b.keys("f");
    await settled();
    assert.ok((await camera()).fov > before.fov);
    const picture = await shown();
    await b.keys("]", "]");
    assert.equal(await text("exposure-value"), "+0.5");
    assert.notEqual(await shown(), picture);
    await b.keys("[", "[");
    assert.equal(await shown(), picture);
    await b.keys("c");
    assert.notEqual(await shown(), picture);
    assert.equal(await b.js("return document.getElementById('legend').hidden"), false);
    await b.keys("c");
    assert.equal(await shown(), picture);
    await b.keys("r");
    await b.until("state.camera.mover === 0");
    await settled();
  },
  async "exposure and tone curve follow their formulas"() {
    const pixel = "const i = 60 * 160 + 40, d = context.getImageData(40, 60, 1, 1).data;";
    const srgb = (x) => Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * Math.min(1, x) ** (1 / 2.4) - 0.055));
    const [value, byte] = await b.js(`${pixel} return [numbers[mean[3 * i]], d[0]]`);
    assert.ok(value > 0.01 && Math.abs(byte - srgb(value)) <= 1, `${value} is ${byte}`);
    await b.js("exposure.value = 1; exposure.dispatchEvent(new Event('input'))");
    assert.ok(Math.abs(await b.js(`${pixel} return d[0]`) - srgb(2 * value)) <= 1);
    await b.js("tone.value = 'reinhard'; tone.dispatchEvent(new Event('change'))");
    assert.ok(Math.abs(await b.js(`${pixel} return d[0]`) - srgb(2 * value / (1 + 2 * await b.js(`${pixel} return luminance(mean, 3 * i)`)))) <= 1);
    await b.js("tone.value = 'aces'; tone.dispatchEvent(new Event('change'))");
    const x = 2 * value;
    assert.ok(Math.abs(await b.js(`${pixel} return d[0]`) - srgb(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14))) <= 1);
    await b.js("tone.value = 'none'; exposure.value = 0; exposure.dispatchEvent(new Event('input'))");
  },
  async "the standard error comes when it is asked for, after the picture is done as well"() {
    await choose("channel", "error");
    await b.until("error !== null && state.phase === 'done'", "the standard error");
    const seen = await b.js("return error.slice(3 * (60 * 160 + 40), 3 * (60 * 160 + 40) + 3).map((h) => h)");
    assert.ok(Object.values(seen).some((h) => h > 0));
    await b.shot("error");
    await choose("channel", "mean");
    await settled();
  },
  async "AOVs: depth, shapes, normals"() {
    await reset();
    const at = (x, y) => b.js(`const k = (arguments[1] * layer.width + arguments[0]) * layer.components; return [...layer.values.slice(k, k + layer.components)]`, x, y);
    await choose("channel", "depth");
    await b.until("layer && layer.name === 'depth'");
    const [near] = await at(114, 60), [sky] = await at(80, 2);
    assert.ok(near > 4.5 && near < 6.5, `the sphere is ${near} away`);
    assert.equal(sky, Math.fround(1e10));
    await b.shot("depth");
    await choose("channel", "instance");
    await b.until("layer && layer.name === 'instance'");
    assert.deepEqual([await at(114, 60), await at(46, 60), await at(80, 2)].map(([n]) => n), [1, 2, 0]);
    await choose("channel", "shading_normal");
    await b.until("layer && layer.name === 'shading_normal'");
    const normal = await at(114, 60);
    assert.ok(Math.abs(length(normal) - 1) < 0.05, `${normal} has length 1`);
    const { sameAsDrawn } = await b.js("const d = context.getImageData(114, 60, 1, 1).data, k = (60 * 160 + 114) * 3; return { sameAsDrawn: Math.abs(d[0] - 255 * (0.5 + 0.5 * layer.values[k])) <= 1 }");
    assert.ok(sameAsDrawn);
    await choose("channel", "mean");
    await settled();
  },
  async "a click explains a path, by device and reference"() {
    const box = await b.js("const r = document.getElementById('view').getBoundingClientRect(); return [r.left, r.top, r.width, r.height]");
    const k = Math.min(box[2] / 160, box[3] / 120), place = (x, y) => [box[0] + box[2] / 2 + (x + 0.5 - 80) * k, box[1] + box[3] / 2 + (y + 0.5 - 60) * k];
    const click = (at) => b.mouse(at, [at[0] + 1, at[1]]);
    const before = await camera();
    await click(place(114, 60));
    await b.until("document.getElementById('told').textContent.includes('the same decisions')", "both have told");
    assert.match(await text("told"), /Pixel \(114, 60\), sample 0, .*the same decisions/);
    const cells = await b.js("return [...document.querySelector('#path tbody tr').children].map((c) => c.textContent)");
    assert.equal(cells[1], "instance 0, 0");
    assert.deepEqual(await camera(), before, "a click is no drag");
    await b.shot("explained");
    await b.js("document.getElementById('pixel-x').value = 160");
    await b.click("#inspect button");
    await b.until("document.getElementById('told').textContent.includes('no pixel of 160x120')");
    // The same click sets the focus or the point to orbit.
    await choose("click", "focus");
    await click(place(114, 60));
    await b.until("state.camera.focus > 4.5 && state.camera.focus < 6.5");
    await b.js("aperture.value = 0.4; aperture.dispatchEvent(new Event('change'))");
    await b.until("state.camera.aperture === 0.4");
    await settled();
    assert.match(await (await fetch(viewer.address + "camera.xml")).text(), /<camera type="thinlens">/);
    await choose("click", "target");
    await click(place(114, 60));
    await b.until("Math.abs(camera.target[0] + 1.2) < 0.81", "the point is what is orbited");
    await settled();
    const target = (await camera()).target;
    assert.ok(Math.abs(length(minus(target, [-1.2, 0.8, 0])) - 0.8) < 0.01, `${target} lies on the red sphere`);
    await choose("click", "explain");
    await reset();
    assert.equal((await camera()).aperture, 0);
  },
  async "a crop gets all samples: marked by the mouse, or by its numbers"() {
    const before = await shown();
    const box = await b.js("const r = document.getElementById('view').getBoundingClientRect(); return [r.left, r.top, r.width, r.height]");
    const k = Math.min(box[2] / 160, box[3] / 120), corner = (x, y) => [box[0] + box[2] / 2 + (x - 80) * k, box[1] + box[3] / 2 + (y - 60) * k];
    await choose("drag", "crop");
    await b.mouse(corner(100, 40), corner(140, 70));
    await b.until("state.crop !== null && state.phase === 'done' && shape.width === state.crop[2] && shape.height === state.crop[3]");
    const crop = await b.js("return state.crop");
    for (const [i, n] of [100, 40, 40, 30].entries()) assert.ok(Math.abs(crop[i] - n) <= 1, `${crop}`);
    assert.equal(await b.js("return document.getElementById('drag').value"), "orbit");
    await b.shot("crop");
    // The crop shows what the picture showed there: red and green keep their places.
    const colors = await b.js("const i = 3 * (15 * shape.width + 20); return [numbers[mean[i]], numbers[mean[i + 1]]]");
    assert.ok(colors[0] > 2 * colors[1], "the red sphere");
    await b.mouse(await middle());
    assert.match(await text("readout"), /pixel \(1[12]\d,5\d\)/);
    await b.js("const e = document.getElementById('crop'); e.value = '0, 40 30x20'; e.dispatchEvent(new Event('change'))");
    await b.until("String(state.crop) === '0,40,30,20' && state.phase === 'done'");
    await b.js("const e = document.getElementById('crop'); e.value = ''; e.dispatchEvent(new Event('change'))");
    await b.until("state.crop === null && state.phase === 'done' && shape.width === 160");
    await settled();
    assert.equal(await shown(), before, "the whole picture again, to the byte");
  },
  async "parameters of the integrator"() {
    const before = await shown();
    await b.js("const e = document.getElementById('max-depth'); e.value = 2; e.dispatchEvent(new Event('change'))");
    await b.until("state.integrator.maxDepth === 2 && state.phase === 'done'");
    await settled();
    assert.notEqual(await shown(), before);
    await b.click("#nee");
    await b.until("state.integrator.nee === false && state.phase === 'done'");
    assert.equal(await b.js("return document.getElementById('mis').disabled"), true);
    await b.click("#reload");
    await b.until("state.integrator.nee === true && state.integrator.maxDepth !== 2 && state.phase === 'done'");
    await settled();
    assert.equal(await shown(), before);
  },
  async "a changed file is read again; with an error the last good picture stays, and the error says where"() {
    const before = await shown(), loads = await b.js("return state.loads");
    writeFileSync(scene.file, sceneText({ albedo: "0.1, 0.2, 0.9" }));
    await b.until(`state.loads === ${loads + 1} && state.phase === 'done'`);
    assert.notEqual(await shown(), before);
    const blue = await shown();
    writeFileSync(scene.file, sceneText({ albedo: "0.1, 0.2" }));
    await b.until("state.problem !== ''");
    assert.match(await text("problem"), /two-spheres\.xml:\d+:\d+: /);
    assert.equal(await b.js("return getComputedStyle(document.getElementById('problem')).display === 'none'"), false);
    await b.shot("problem");
    await settled();
    assert.equal(await shown(), blue, "the last good picture");
    // The camera of the last valid scene can still be moved.
    await focus();
    await b.keys("\uE012");
    await settled();
    assert.notEqual(await shown(), blue);
    writeFileSync(scene.file, sceneText());
    await b.until("state.problem === '' && state.phase === 'done'");
    assert.notEqual((await camera()).eye[0], 0, "who moved the camera keeps it");
    await reset();
    assert.equal(await shown(), before, "the first scene again, to the byte");
  },
  async "a mesh that changes, goes and comes back"() {
    const before = await shown(), loads = await b.js("return state.loads");
    writeFileSync(scene.mesh, floorText(1));
    await b.until(`state.loads > ${loads} && state.phase === 'done'`);
    assert.notEqual(await shown(), before);
    unlinkSync(scene.mesh);
    await b.until("state.problem !== ''");
    assert.match(await text("problem"), /floor\.obj/);
    writeFileSync(scene.mesh, floorText());
    await b.until("state.problem === '' && state.phase === 'done'");
    await settled();
    assert.equal(await shown(), before);
  },
  async "a mesh that only the broken version of the scene names"() {
    const before = await shown();
    writeFileSync(scene.file, sceneText({ extra: '<mesh type="obj"><string name="filename" value="late.obj"/><bsdf type="diffuse"/></mesh>' }));
    await b.until("state.problem.includes('late.obj')");  // not what is read while the file is being written
    writeFileSync(join(scene.folder, "late.obj"), floorText(0.1).replaceAll(" 0 ", " 1 "));
    await b.until("state.problem === '' && state.phase === 'done'");
    await settled();
    assert.notEqual(await shown(), before);
    writeFileSync(scene.file, sceneText());
    await b.until("state.phase === 'done' && document.getElementById('view').toDataURL() === arguments[0]".replace("arguments[0]", JSON.stringify(before)));
  },
  async "two pages: both follow, each with an exposure of its own"() {
    const first = await b.handle(), second = await b.newTab();
    await open();
    await b.js("exposure.value = 2; exposure.dispatchEvent(new Event('input'))");
    await focus();
    await b.keys("\uE013");
    await settled();
    const moved = await camera();
    await b.switchTo(first);
    await b.until(`state.phase === 'done' && camera.eye[1] === ${moved.eye[1]}`, "the first page follows");
    assert.equal(await text("exposure-value"), "0");
    await b.switchTo(second);
    await b.closeTab();
    await b.switchTo(first);
    await reset();
  },
  async "disconnected, and connected again"() {
    viewer.process.kill("SIGSTOP");
    await b.cdp("Network.enable");
    await b.cdp("Network.emulateNetworkConditions", { offline: true, latency: 0, downloadThroughput: -1, uploadThroughput: -1 });
    await b.js("refresh()");
    await b.until("document.getElementById('phase').dataset.phase === 'lost'", "the page says that it is disconnected");
    assert.equal(await b.js("return document.getElementById('problem').hidden"), false);
    await b.cdp("Network.emulateNetworkConditions", { offline: false, latency: 0, downloadThroughput: -1, uploadThroughput: -1 });
    viewer.process.kill("SIGCONT");
    await b.until("document.getElementById('phase').dataset.phase === 'done'", "connected again");
    assert.equal(await b.js("return document.getElementById('problem').hidden"), true);
    await focus();
    await b.keys("\uE014");
    await settled();
  },
  async "samples, pausing, saving"() {
    await b.js("target.value = 24; target.dispatchEvent(new Event('change'))");
    await b.until("state.samples === 24 && state.phase === 'done'");
    await b.click("#pause");
    await b.until("state.paused");
    assert.equal(await b.js("return document.getElementById('pause').getAttribute('aria-pressed')"), "true");
    await b.click("#pause");
    await b.until("!state.paused");
    await b.click("#save-exr");
    await b.click("#save-shown");
    const end = Date.now() + 10000;
    const there = () => readdirSync(downloads).filter((name) => !name.endsWith(".crdownload")).sort();
    while (there().length < 2 && Date.now() < end) await pause(50);
    assert.deepEqual(there(), ["two-spheres-shown.png", "two-spheres.exr"]);
    await b.click("#camera-show");
    await b.until("document.getElementById('camera-text').value.includes('<camera type=\"perspective\">')");
  },
  async "usable without a mouse, readable from a phone to a 4K screen"() {
    const nameless = await b.js(`return [...document.querySelectorAll("button, select, input, textarea, canvas, progress")].filter((e) =>
      !(e.getAttribute("aria-label") || e.textContent.trim() && e.tagName === "BUTTON" || (e.labels && e.labels.length))).map((e) => e.id)`);
    assert.deepEqual(nameless, []);
    const reached = new Set();
    await b.js("document.activeElement.blur()");
    for (let i = 0; i < 60; ++i) { await b.keys("\uE004"); reached.add(await b.js("return document.activeElement.id")); }
    for (const id of ["view", "channel", "exposure", "tone", "false-color", "drag", "fov", "reset", "target", "pause", "reload", "save-exr", "camera-copy"])
      assert.ok(reached.has(id), `${id} is reached by Tab`);
    assert.equal(await b.js("return document.getElementById('announcer').getAttribute('aria-live')"), "polite");
    for (const [name, ...size] of [["phone", 390, 844, 2], ["desktop", 1440, 900, 1], ["4k", 3840, 2160, 1]]) {
      for (const dark of [false, true]) {
        await b.size(...size, dark);
        assert.ok(await b.js("return document.documentElement.scrollWidth <= innerWidth"), `${name}: the page scrolls sideways`);
        const small = await b.js("return [...document.querySelectorAll('button, select')].filter((e) => e.getBoundingClientRect().height < 28).length");
        assert.equal(small, 0, `${name}: too small for a finger`);
        await b.shot(`${name}-${dark ? "dark" : "light"}`);
      }
    }
    await b.size(1440, 900);
  },
  async "ended by Ctrl-C while pages are open"() {
    const start = Date.now();
    const { code, signal } = await viewer.end();
    assert.equal(signal, null);
    assert.equal(code, 0, viewer.errors);
    assert.ok(Date.now() - start < 5000);
    await b.until("document.getElementById('phase').dataset.phase === 'lost'");
  },
};

let failed = 1;
try {
  b = await Browser.start(work, shots);
  if (!b) {
    console.log("skipped: needs chromium and chromedriver (Debian: chromium chromium-driver)");
    process.exitCode = 77;
  } else {
    await b.size(1440, 900);
    await b.cdp("Page.setDownloadBehavior", { behavior: "allow", downloadPath: downloads });
    viewer = await Viewer.start(program, scene.file);
    failed = await runAll(tests);
    process.exitCode = failed ? 1 : 0;
  }
} finally {
  if (viewer) await viewer.end("SIGKILL");
  if (b) await b.end();
  rmSync(work, { recursive: true, force: true });
  scene.remove();
}
