// Reads a small scene again and again: node reload.mjs ETENDUE_VIEW [TIMES]. Prints the viewer's resident memory, open files and threads
// ten times on the way, and fails if any of them has grown after the first tenth. docs/view.md has the numbers.

import { readdirSync, readFileSync } from "node:fs";
import { makeScene, Viewer } from "./viewer.mjs";

const [program, times = "2000"] = process.argv.slice(2);
const scene = makeScene({ samples: 1, width: 16, height: 12 });
const viewer = await Viewer.start(program, scene.file);
const start = Date.now();

function usage() {
  const folder = `/proc/${viewer.process.pid}`, status = readFileSync(`${folder}/status`, "latin1");
  const number = (name) => +status.match(new RegExp(`${name}:\\s+(\\d+)`))[1];
  return { mebibytes: number("VmRSS") / 1024, files: readdirSync(`${folder}/fd`).length, threads: number("Threads") };
}

let failed = "";
try {
  let state = await viewer.done(), first;
  const begun = state.loads;
  for (let step = 1; step <= 10; ++step) {
    while (state.loads - begun < (step * +times) / 10) {
      const { loads } = state;
      await viewer.post("reload");
      state = await viewer.until((s) => s.loads > loads);
      if (state.problem) throw new Error(state.problem);
    }
    const now = usage();
    first ??= now;
    console.log(`${state.loads - begun} reloads in ${((Date.now() - start) / 1000).toFixed(0)} s: ${now.mebibytes.toFixed(1)} MiB, ${now.files} files, ${now.threads} threads`);
    // An allocator keeps some of what it has handed out; connections come and go.
    if (now.mebibytes > first.mebibytes + 8 || now.files > first.files + 8 || now.threads > first.threads + 8) failed = "more and more";
  }
  if ((await viewer.done()).rejected > 0) failed = "samples were rejected";
} finally {
  await viewer.end("SIGKILL");
  scene.remove();
}
if (failed) throw new Error(failed);
