// How soon `etendue view` shows something: node latency.mjs ETENDUE_VIEW SCENE [ROUNDS] [OPTION...]. Prints the medians of four times in
// milliseconds: from the command to the first picture that a page receives; from a camera move, as a drag sends it, to the first picture
// of that camera; from there to the first picture of full size; and from a change of a light, as its slider sends it, to the first
// picture with it. docs/view.md has the numbers.

import { performance } from "node:perf_hooks";
import { Viewer } from "./viewer.mjs";

const [program, scene, rounds = "5", ...options] = process.argv.slice(2);
const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
const times = { first: [], drag: [], full: [], light: [] };

for (let round = 0; round < +rounds; ++round) {
  const start = performance.now();
  const viewer = await Viewer.start(program, scene, "--spp", "4", ...options);
  try {
    const first = await viewer.until((s) => s.hasPicture);
    times.first.push(performance.now() - start);
    let state = await viewer.done();
    const { eye, target, up } = state.camera, mover = 77;
    for (let step = 1; step <= 5; ++step) {
      const moved = eye.map((v, i) => v + 0.01 * step * (target[i] - eye[i]));
      const asked = performance.now(), before = state.picture;
      await viewer.post(`camera?${new URLSearchParams({ eye: moved, target, up, moving: 1, mover })}`);
      state = await viewer.until((s) => s.hasPicture && s.picture > before && s.camera.eye.every((v, i) => v === moved[i]));
      times.drag.push(performance.now() - asked);
      await viewer.post(`camera?${new URLSearchParams({ eye: moved, target, up, moving: 0, mover })}`);
      state = await viewer.until((s) => s.picture > before && s.width === s.fullWidth && s.samples > 0);
      times.full.push(performance.now() - asked);
      state = await viewer.done();
    }
    const { numbers: [number] } = await (await fetch(`${viewer.address}light?row=0`)).json();
    for (let step = 0; step <= 5; ++step) {
      const value = [].concat(number.value).map((v) => (v + 0.01) * (1 + step));
      const asked = performance.now(), before = state;
      await viewer.post(`light?${new URLSearchParams({ row: 0, name: number.name, value, moving: 1 })}`);
      state = await viewer.until((s) => s.hasPicture && s.picture > before.picture && s.lights > before.lights);
      if (step > 0) times.light.push(performance.now() - asked);  // the first may compile a kernel
      await viewer.post(`light?${new URLSearchParams({ row: 0, name: number.name, value, moving: 0 })}`);
      state = await viewer.done();
    }
    if (round === 0) console.log(`${state.scene}, ${state.fullWidth} x ${state.fullHeight}; first picture ${first.width} x ${first.height}; ${state.device}`);
  } finally {
    await viewer.end("SIGKILL");
  }
}
for (const [what, values] of Object.entries(times))
  console.log(`${what}: median ${median(values).toFixed(0)} ms, ${Math.min(...values).toFixed(0)} to ${Math.max(...values).toFixed(0)}, of ${values.length}`);
