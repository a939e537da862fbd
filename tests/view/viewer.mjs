// Starts a viewer and talks to it, for the tests of `etendue view`.

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

// A red and a green sphere above a floor, which is a mesh file.
export function sceneText({ albedo = "0.8, 0.2, 0.1", fov = 40, extra = "", samples = 8, width = 160, height = 120 } = {}) {
  return `<scene>
  <integrator type="path"/>
  <sampler type="independent"><integer name="sampleCount" value="${samples}"/></sampler>
  <camera type="perspective">
    <integer name="width" value="${width}"/><integer name="height" value="${height}"/><float name="fov" value="${fov}"/>
    <transform name="toWorld"><lookat origin="0, 1.5, -6" target="0, 0.5, 0" up="0, 1, 0"/></transform>
    <rfilter type="box"/>
  </camera>
  <color name="sky_top" value="0.6, 0.8, 1"/><color name="sky_horizon" value="0.9, 0.9, 0.9"/>
  <mesh type="sphere"><point name="center" value="-1.2, 0.8, 0"/><float name="radius" value="0.8"/>
    <bsdf type="diffuse"><color name="albedo" value="${albedo}"/></bsdf></mesh>
  <mesh type="sphere"><point name="center" value="1.2, 0.8, 0"/><float name="radius" value="0.8"/>
    <bsdf type="diffuse"><color name="albedo" value="0.1, 0.7, 0.2"/></bsdf></mesh>
  <mesh type="obj"><string name="filename" value="floor.obj"/><bsdf type="diffuse"/></mesh>
  ${extra}
</scene>
`;
}
export const floorText = (size = 5) => `v ${-size} 0 ${-size}\nv ${size} 0 ${-size}\nv ${size} 0 ${size}\nv ${-size} 0 ${size}\nf 1 4 3\nf 1 3 2\n`;

// A folder with that scene; `remove` deletes it.
export function makeScene(options) {
  const folder = mkdtempSync(join(tmpdir(), "etendue-view-test-"));
  const file = join(folder, "two-spheres.xml"), mesh = join(folder, "floor.obj");
  writeFileSync(mesh, floorText());
  writeFileSync(file, sceneText(options));
  return { folder, file, mesh, remove: () => rmSync(folder, { recursive: true, force: true }) };
}

export class Viewer {
  static async start(program, ...args) {
    const viewer = new Viewer();
    viewer.errors = "";
    viewer.process = spawn(program, args, { stdio: ["ignore", "pipe", "pipe"] });
    viewer.process.stderr.on("data", (chunk) => { viewer.errors += chunk; });
    viewer.ended = new Promise((resolve) => viewer.process.on("exit", (code, signal) => resolve({ code, signal })));
    viewer.address = await new Promise((resolve, reject) => {
      let text = "";
      viewer.process.stdout.on("data", (chunk) => { text += chunk; if (text.includes("\n")) resolve(text.split("\n")[0]); });
      viewer.ended.then(() => reject(new Error("the viewer ended: " + viewer.errors)));
    });
    const { hostname, port, pathname } = new URL(viewer.address);
    return Object.assign(viewer, { hostname, port: +port, path: pathname });
  }

  // The state, and its picture as half-precision numbers if it has one.
  async next(version = 0, picture = 0, error = 0) {
    const buffer = await (await fetch(`${this.address}next?version=${version}&picture=${picture}&error=${error}`)).arrayBuffer();
    const length = new DataView(buffer).getUint32(0, true);
    const state = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    return { ...state, bytes: Buffer.from(buffer, 4 + length) };
  }

  // The first state that meets the condition.
  async until(condition, ms = 60000) {
    const end = Date.now() + ms;
    let version = 0;
    for (;;) {
      const state = await this.next(version, 0);
      if (condition(state)) return state;
      if (Date.now() > end) throw new Error(`not within ${ms} ms; ${JSON.stringify({ ...state, bytes: undefined })}\n${this.errors}`);
      version = state.version;
    }
  }
  done() { return this.until((s) => s.phase === "done"); }

  post(what) { return fetch(this.address + what, { method: "POST" }); }

  async end(signal = "SIGINT") {
    this.process.kill(signal);
    return this.ended;
  }
}
