// The inspectors of `etendue view` in a real browser: materials, and a path drawn over the picture.
// node inspect.mjs ETENDUE_VIEW [SCREENSHOT_FOLDER]; exits with 77 if there is no browser.

import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import assert from "node:assert/strict";
import { Browser, runAll } from "../browser/browser.mjs";
import { Viewer, makeScene, sceneText } from "./viewer.mjs";

const [program, shots] = process.argv.slice(2);
const work = mkdtempSync(join(tmpdir(), "etendue-view-inspect-"));
// A coated sphere in the middle, a checkered one behind it, a mirror on the left, a lamp on the other side.
const ball = (center, radius, bsdf) => `<mesh type="sphere"><point name="center" value="${center}"/><float name="radius" value="${radius}"/>${bsdf}</mesh>`;
const coat = (alpha) => `<bsdf type="roughplastic" id="coat"><float name="alpha" value="${alpha}"/><color name="diffuse_reflectance" value="0.6, 0.3, 0.1"/></bsdf>`;
const checkered = '<bsdf type="diffuse" id="board"><texture name="albedo" type="checkerboard"/></bsdf>';
const lamp = (radiance) => ball("2.2, 1.6, 1", 0.3, `<bsdf type="diffuse" id="dark"><color name="albedo" value="0, 0, 0"/></bsdf><emitter type="area"><color name="radiance" value="${radiance}"/></emitter>`);
const extra = (middle, radiance) => ball("0, 1, -0.5", 0.5, middle) + ball("-2.6, 1.6, 1.5", 0.9, '<bsdf type="mirror" id="silver"/>') + ball("0, 2.4, 2", 0.6, checkered) + lamp(radiance);
const text = (albedo = "0.8, 0.2, 0.1", middle = coat(0.2), radiance = "3, 3, 3") => sceneText({ albedo, extra: extra(middle, radiance) });
const scene = makeScene();
writeFileSync(scene.file, text());
let b, viewer;

const settled = (more = "true") => b.until(`state && state.phase === 'done' && shape.width === 160 && materialPanel.current && lightPanel.current && (${more})`);
const shown = () => b.js("return document.getElementById('view').toDataURL()");
const content = (id) => b.js("return document.getElementById(arguments[0]).textContent", id);
const value = (id) => b.js("return document.getElementById(arguments[0]).value", id);
const set = (id, to, event = "change") => b.js("const e = document.getElementById(arguments[0]); e.value = arguments[1]; e.dispatchEvent(new Event(arguments[2]))", id, to, event);
const choose = async (name) => {
  const row = await b.js("return [...document.getElementById('material').options].findIndex((o) => o.text.includes(arguments[0]))", name);
  assert.ok(row >= 0, `${name} is in the list`);
  await set("material", String(row));
  await b.until(`materialPanel.row && materialPanel.row.row === ${row}`);
};
const place = async (x, y) => {
  const box = await b.js("const r = document.getElementById('view').getBoundingClientRect(); return [r.left, r.top, r.width, r.height]");
  const k = Math.min(box[2] / 160, box[3] / 120);
  return [box[0] + box[2] / 2 + (x + 0.5 - 80) * k, box[1] + box[3] / 2 + (y + 0.5 - 60) * k];
};
const click = async (x, y) => { const at = await place(x, y); await b.mouse(at, [at[0] + 1, at[1]]); };
// Changes a material or light and waits for the picture with it.
async function changed(act, what = "materials") {
  const before = await b.js("return state[arguments[0]]", what);
  await act();
  await settled(`state.${what} > ${before}`);
}
const relit = (act) => changed(act, "lights");
const chooseLight = async (name) => {
  const row = await b.js("return [...document.getElementById('light').options].find((o) => o.text.includes(arguments[0])).value", name);
  await set("light", row);
  await b.until(`lightPanel.row.row === ${row}`);
};
const loads = () => b.js("return state.loads");

const tests = {
  async "materials are listed, and a click on the picture chooses one"() {
    await b.open(viewer.address);
    await settled();
    const options = await b.js("return [...document.getElementById('material').options].map((o) => o.text)");
    for (const name of ["coat (roughplastic)", "silver (mirror)", "board (diffuse)"]) assert.ok(options.some((o) => o.endsWith(name)), `${name} in ${options}`);
    await b.js("const e = document.getElementById('click'); e.value = 'material'");
    await click(114, 60);
    await b.until("document.getElementById('number-albedo') && document.getElementById('number-albedo').value === '0.8, 0.2, 0.1'", "the red sphere's");
    await choose("board");
    assert.match(await content("material-numbers"), /times the texture checkerboard/, "textures are named");
    assert.equal(await value("number-albedo"), "1, 1, 1", "and what they are multiplied with can be changed");
    await choose("silver");
    assert.match(await content("material-numbers"), /no numbers/);
    await b.js("document.getElementById('click').value = 'explain'");
  },
  async "a colour changes the picture at once, and what the file says comes back"() {
    const before = await shown(), read = await loads();
    await b.js("document.getElementById('click').value = 'material'");
    await click(114, 60);
    await b.until("document.getElementById('number-albedo') && document.getElementById('number-albedo').value === '0.8, 0.2, 0.1'");
    await b.js("document.getElementById('click').value = 'explain'");
    assert.equal(await b.js("return document.getElementById('number-albedo-undo').disabled"), true);
    await changed(() => set("number-albedo", "0.1 0.2; 0.9"));
    assert.equal(await value("number-albedo"), "0.1, 0.2, 0.9");
    const blue = await shown();
    assert.notEqual(blue, before);
    const [red, , strong] = await b.js("const i = 3 * (60 * 160 + 114); return [0, 1, 2].map((c) => numbers[mean[i + c]])");
    assert.ok(strong > 3 * red, "the sphere is blue");
    assert.match(await b.js("return document.getElementById('material').selectedOptions[0].text"), /, changed$/);
    assert.equal(await loads(), read, "nothing was read again");
    // The same bytes as with these numbers in the file.
    await changed(() => b.click("#number-albedo-undo"));
    assert.equal(await value("number-albedo"), "0.8, 0.2, 0.1");
    assert.equal(await shown(), before);
    writeFileSync(scene.file, text("0.1, 0.2, 0.9"));
    await b.until(`state.loads === ${read + 1} && state.phase === 'done'`);
    await settled();
    assert.equal(await shown(), blue);
    writeFileSync(scene.file, text());
    await b.until(`state.loads === ${read + 2} && state.phase === 'done'`);
    await settled();
  },
  async "a slider, a picker, and all of a material taken back"() {
    const before = await shown();
    await choose("coat");
    assert.equal(await value("number-alpha-slider"), "0.2");
    await set("number-alpha-slider", "0.6", "input");
    await changed(() => set("number-alpha-slider", "0.65", "change"));
    assert.equal(await value("number-alpha"), "0.65");
    const rough = await shown();
    assert.notEqual(rough, before);
    await changed(() => set("number-diffuse_reflectance-picker", "#8000ff", "change"));
    assert.match(await value("number-diffuse_reflectance"), /, 0, 1$/);
    assert.notEqual(await shown(), rough);
    await b.shot("materials");
    await changed(() => b.click("#material-own"));
    assert.equal(await value("number-alpha"), "0.2");
    assert.equal(await shown(), before);
    assert.equal(await b.js("return document.getElementById('material-own').disabled"), true);
  },
  async "what a texture is multiplied with"() {
    const before = await shown(), read = await loads();
    await choose("board");
    await changed(() => set("number-albedo", "0.2, 1, 0.2"));
    assert.notEqual(await shown(), before);
    assert.equal(await loads(), read);
    await changed(() => b.click("#number-albedo-undo"));
    assert.equal(await shown(), before);
  },
  async "lights are listed, and a click on a lamp chooses it"() {
    const options = await b.js("return [...document.getElementById('light').options].map((o) => o.text)");
    assert.equal(options.length, 2, `${options}`);
    assert.match(options[0], /sphere \(area\)$/);
    assert.match(options[1], /environment$/);
    await chooseLight("environment");
    assert.equal(await value("light-number-top"), "0.6, 0.8, 1");
    assert.equal(await value("light-number-horizon"), "0.9, 0.9, 0.9");
    await b.js("document.getElementById('click').value = 'material'");
    await click(10, 20);
    await b.until("lightPanel.row.row === 0 && document.getElementById('light-number-radiance').value === '3, 3, 3'");
    assert.match(await content("announcer"), /Material .*dark.*, light .*area/);
    await b.js("document.getElementById('click').value = 'explain'");
  },
  async "a light gets brighter and another colour at once"() {
    const before = await shown(), read = await loads();
    await chooseLight("area");
    await relit(() => set("light-number-radiance", "30, 3, 1"));
    const bright = await shown();
    assert.notEqual(bright, before);
    assert.match(await b.js("return document.getElementById('light').selectedOptions[0].text"), /, changed$/);
    await relit(() => b.click("#light-number-radiance-undo"));
    assert.equal(await shown(), before);
    await set("light-number-radiance-slider", "1.5", "input");
    await relit(() => set("light-number-radiance-slider", "2", "change"));
    assert.equal(await value("light-number-radiance"), "12, 12, 12");
    assert.equal(await b.js("return document.getElementById('light-number-radiance-slider').getAttribute('aria-valuetext')"), "+2 stops");
    await relit(() => set("light-number-radiance-picker", "#ff0000", "change"));
    assert.equal(await value("light-number-radiance"), "12, 0, 0", "as bright as before");
    await b.shot("lights");
    await relit(() => set("light-number-radiance", "0"));
    await relit(() => set("light-number-radiance-slider", "1", "change"));
    assert.equal(await value("light-number-radiance"), "6, 6, 6", "black gets a colour again");
    await relit(() => b.click("#light-own"));
    assert.equal(await shown(), before);
    await chooseLight("environment");
    await relit(() => set("light-number-top", "0, 0, 3"));
    await relit(() => set("light-number-horizon", "0 0 0"));
    assert.notEqual(await shown(), before);
    await relit(() => b.click("#light-own"));
    assert.equal(await shown(), before);
    assert.equal(await loads(), read, "nothing was read again");
    // The same bytes as from a file that says so.
    writeFileSync(scene.file, text(undefined, undefined, "30, 3, 1"));
    await b.until(`state.loads === ${read + 1} && state.phase === 'done'`);
    await settled();
    assert.equal(await shown(), bright);
    writeFileSync(scene.file, text());
    await b.until(`state.loads === ${read + 2} && state.phase === 'done'`);
    await settled();
  },
  async "a light out of range is refused"() {
    const before = await shown();
    await chooseLight("area");
    await set("light-number-radiance", "-1");
    await b.until("!document.getElementById('light-problem').hidden");
    assert.match(await content("light-problem"), /two-spheres\.xml:\d+:\d+: radiance -1 is out of range/);
    await chooseLight("environment");
    await set("light-number-top", "1e99");
    await b.until("document.getElementById('light-problem').textContent.includes('radiance 1e+99 is out of range')");
    await relit(() => set("light-number-top", "0.6, 0.8, 1"));
    await b.until("document.getElementById('light-problem').hidden");
    assert.equal(await shown(), before, "nothing of it was taken");
  },
  async "a value out of range is refused with the scene's own sentence"() {
    const before = await shown();
    await choose("coat");
    await set("number-alpha", "1.5");
    await b.until("!document.getElementById('material-problem').hidden");
    assert.match(await content("material-problem"), /two-spheres\.xml:\d+:\d+: the roughness 1\.5 is not between/);
    assert.equal(await b.js("return document.getElementById('number-alpha').getAttribute('aria-invalid')"), "true");
    assert.equal(await value("number-alpha"), "1.5", "what was typed can be mended");
    await b.shot("refused");
    await set("number-int_ior", "1");
    await b.until("document.getElementById('material-problem').textContent.includes('no coat of plastic')");
    await set("number-alpha", "oops");
    await b.until("document.getElementById('material-problem').textContent.includes('value is a number')");
    await changed(() => set("number-alpha", "0.2"));
    await b.until("document.getElementById('material-problem').hidden");
    await changed(() => set("number-int_ior", "1.49"));
    assert.equal(await shown(), before, "nothing of it was taken");
  },
  async "as XML, to be pasted"() {
    await choose("coat");
    await changed(() => set("number-alpha", "0.35"));
    const rough = await shown(), read = await loads();
    await b.click("#material-show");
    await b.until("document.getElementById('material-text').value.includes('</bsdf>')");
    const fragment = await value("material-text");
    assert.match(fragment, /^<bsdf type="roughplastic" id="coat">/);
    await set("material-dialect", "mitsuba");
    await b.until("document.getElementById('material-text').value.includes('int_ior')");
    await set("material-dialect", "etendue");
    writeFileSync(scene.file, text(undefined, fragment));
    await b.until(`state.loads === ${read + 1} && state.phase === 'done'`);
    await settled();
    assert.equal(await shown(), rough, "pasted into the file it is the same, to the byte");
    writeFileSync(scene.file, text());
    await b.until(`state.loads === ${read + 2} && state.phase === 'done'`);
    await settled();
  },
  async "a path is drawn over the picture, by device and reference"() {
    await click(114, 60);
    await b.until("document.getElementById('told').textContent.includes('the same decisions')", "both have told");
    const drawn = await b.js(`const svg = document.getElementById('drawn'); return { box: svg.getAttribute('viewBox'), hidden: svg.hasAttribute('hidden'),
      device: svg.querySelectorAll('polyline.device').length, reference: svg.querySelectorAll('polyline.reference').length,
      badges: [...svg.querySelectorAll('.badge text')].map((t) => +t.textContent) }`);
    assert.equal(drawn.hidden, false);
    assert.equal(drawn.box, "0 0 160 120");
    assert.ok(drawn.device > 0 && drawn.device === drawn.reference, "both are drawn");
    assert.ok(drawn.badges.includes(1), "the first vertex is seen");
    // The first vertex is at the pixel that was clicked, in the drawing and in the table.
    assert.ok(await b.js("return document.querySelector('#drawn [data-vertex=\"1\"].badge').classList.contains('both')"), "the two agree on the place");
    const at = await b.js("return document.querySelector('#drawn [data-vertex=\"1\"].badge').getAttribute('transform').match(/translate\\(([-\\d.]+) ([-\\d.]+)\\)/).slice(1).map(Number)");
    assert.ok(Math.abs(at[0] - 114.5) <= 0.51 && Math.abs(at[1] - 60.5) <= 0.51, `${at}`);
    assert.equal(await b.js("return document.querySelector('#path tbody tr .seen').textContent"), "(114, 60)");
    const frame = await b.js(`return [...document.querySelectorAll('#drawn polyline')].every((l) => l.getAttribute('points').split(' ').every((p) => {
      const [x, y] = p.split(',').map(Number); return x >= -0.01 && x <= 160.01 && y >= -0.01 && y <= 120.01; }))`);
    assert.ok(frame, "what leaves the frame is cut off");
    await b.shot("path");
    await b.js("document.querySelector('#path tbody tr').focus()");
    assert.ok(await b.js("return document.querySelector('#drawn [data-vertex=\"1\"].badge').classList.contains('chosen')"), "a row of the table shows its vertex");
    assert.equal(await b.js("return document.getElementById('drawn').getAttribute('aria-hidden')"), "true", "the table says it");
  },
  async "the drawing follows the camera and the crop, and can be taken away"() {
    const of = "document.querySelector('#drawn [data-vertex=\"1\"].badge')", where = () => b.js(`const e = ${of}; return e ? e.getAttribute('transform') : ''`);
    const before = await where();
    await b.js("document.getElementById('view').focus()");
    await b.keys("\uE012");
    await b.until(`state.phase === 'done' && state.camera.mover !== 0 && !going && !sending && (${of} ? ${of}.getAttribute('transform') : '') !== arguments[0]`.replace("arguments[0]", JSON.stringify(before)));
    await b.click("#reset");
    await b.until("state.camera.mover === 0 && state.phase === 'done'");
    await b.until(`${of} && ${of}.getAttribute('transform') === ${JSON.stringify(before)}`);
    await set("crop", "100, 40, 40, 30");
    await b.until("state.crop !== null && document.getElementById('drawn').getAttribute('viewBox') === '100 40 40 30'");
    await set("crop", "");
    await b.until("state.crop === null && document.getElementById('drawn').getAttribute('viewBox') === '0 0 160 120'");
    await b.click("#draw-path");
    assert.ok(await b.js("return document.getElementById('drawn').hasAttribute('hidden')"));
    await b.click("#draw-path");
    assert.ok(!await b.js("return document.getElementById('drawn').hasAttribute('hidden')"));
    await settled();
  },
  async "lines: clipped before the division, behind the camera, on a sphere"() {
    const line = (a, c) => b.js("return clippedLine(arguments[0], arguments[1], [0, 0, 10, 10])", a, c);
    assert.deepEqual(await line([5, 5, 0, 1], [25, 5, 0, 1]), [[5, 5], [10, 5]]);
    assert.equal(await line([-5, 5, 0, 1], [-25, 5, 0, 1]), null);
    assert.equal(await line([5, 5, 0, -1], [5, 5, 0, -2]), null);
    const through = await line([2, 5, 0, 1], [-8, -5, 0, -1]);  // comes from behind the camera and leaves on the left
    assert.ok(Math.abs(through[1][0]) < 1e-9 && through[1][1] > 0, `${through}`);
    const sphere = { kind: "sphere", matrix: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], origin: [0, 0], pixels: [64, 32] };
    const lines = await b.js("return linesOf(arguments[0], { from: [-1, 0, -3], to: [1, 0, -3], met: true }, [0, 0, 64, 32])", sphere);
    assert.equal(lines.length, 2, "out on one side, in on the other");
    assert.deepEqual((await b.js("return placeOf(arguments[0], { to: [0, 0, 2], met: true })", sphere)).map(Math.round), [32, 16]);
  },
  async "a path of a scene that has changed is not drawn any longer"() {
    await choose("coat");
    await changed(() => set("number-alpha", "0.5"));
    assert.ok(await b.js("return document.getElementById('drawn').hasAttribute('hidden')"));
    assert.match(await content("told"), /The scene has changed since/);
    await changed(() => b.click("#material-own"));
    assert.equal(await value("number-alpha"), "0.2");
  },
  async "from a phone to a desktop, light and dark"() {
    await choose("coat");
    await click(80, 60);
    await b.until("document.getElementById('told').textContent.includes(', on ')", "both have told");
    const nameless = await b.js(`return [...document.querySelectorAll("button, select, input, textarea, canvas, progress")].filter((e) =>
      !(e.getAttribute("aria-label") || e.textContent.trim() && e.tagName === "BUTTON" || (e.labels && e.labels.length))).map((e) => e.id)`);
    assert.deepEqual(nameless, []);
    for (const [name, ...size] of [["phone", 390, 844, 2], ["desktop", 1440, 900, 1]]) {
      for (const dark of [false, true]) {
        await b.size(...size, dark);
        assert.ok(await b.js("return document.documentElement.scrollWidth <= innerWidth"), `${name}: the page scrolls sideways`);
        const small = await b.js("return [...document.querySelectorAll('button, select')].filter((e) => e.getBoundingClientRect().height < 28).map((e) => e.id)");
        assert.deepEqual(small, [], `${name}: too small for a finger`);
        await b.shot(`inspect-${name}-${dark ? "dark" : "light"}`);
      }
    }
    await b.size(1440, 900);
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
