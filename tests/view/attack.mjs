// Attacks on a viewer by somebody on the same machine or by a web page elsewhere, through raw sockets, without a browser:
// node attack.mjs ETENDUE_VIEW

import { connect } from "node:net";
import { networkInterfaces } from "node:os";
import { readFileSync, readdirSync } from "node:fs";
import assert from "node:assert/strict";
import { Viewer, makeScene } from "./viewer.mjs";
import { pause, runAll } from "../browser/browser.mjs";

const [program] = process.argv.slice(2);
const scene = makeScene({ samples: 2, width: 1024, height: 768 });
let viewer;

// Sends bytes and returns what comes back until the other side closes the connection or `ms` have passed.
function exchange(bytes, { ms = 15000, half = false, host = "127.0.0.1", port = viewer.port } = {}) {
  return new Promise((resolve) => {
    const socket = connect(port, host), chunks = [];
    const end = () => { clearTimeout(timer); socket.destroy(); resolve(Buffer.concat(chunks)); };
    const timer = setTimeout(end, ms);
    socket.on("data", (chunk) => chunks.push(chunk));
    socket.on("end", end).on("error", end).on("close", end);
    socket.on("connect", () => half ? socket.write(bytes) : socket.end(bytes));
  });
}
const head = (method, path, headers = {}) => `${method} ${path} HTTP/1.1\r\n` +
  Object.entries({ Host: `127.0.0.1:${viewer.port}`, ...headers }).filter(([, v]) => v !== null)
    .map(([name, value]) => `${name}: ${value}\r\n`).join("") + "\r\n";
const ask = async (...request) => (await exchange(head(...request))).toString("latin1");
const status = (answer) => +(/^HTTP\/1\.1 (\d{3})/.exec(answer) || [])[1] || 0;
const ownPath = (rest = "") => viewer.path + rest;
const memory = () => +/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${viewer.process.pid}/status`, "utf8"))[1] / 1024;
const threads = () => +/Threads:\s+(\d+)/.exec(readFileSync(`/proc/${viewer.process.pid}/status`, "utf8"))[1];

// Requires a quick answer, whatever else is going on.
async function answersSoon() {
  const start = Date.now();
  assert.equal(status(await ask("GET", ownPath("view.css"))), 200);
  assert.ok(Date.now() - start < 3000, `an answer took ${Date.now() - start} ms`);
}

const tests = {
  async "the page, with what keeps a browser from misusing it"() {
    const answer = await ask("GET", ownPath());
    assert.equal(status(answer), 200);
    assert.match(answer, /Content-Security-Policy: default-src 'none'/i);
    assert.match(answer, /frame-ancestors 'none'/);
    assert.match(answer, /X-Content-Type-Options: nosniff/i);
    assert.match(answer, /Referrer-Policy: no-referrer/i);
    assert.match(answer, /Cache-Control: no-store/i);
    assert.doesNotMatch(answer, /Access-Control-Allow/i);
    assert.match(viewer.path, /^\/[0-9a-f]{32}\/$/);
  },
  async "without the token there is nothing"() {
    const t = viewer.path.slice(1, -1);
    const wrong = t.replace(/./g, (c) => c === "0" ? "1" : "0");
    for (const path of ["/", "/view.js", "/next", `/${wrong}/`, `/${t.slice(0, -1)}/`, `/${t}0/`, `/${t.toUpperCase()}x/`, `//${t}/`, `/x/${t}/`, `/${t}`, `/?${t}`, "/favicon.ico"]) {
      const answer = await ask("GET", path);
      assert.equal(status(answer), 404, path);
      assert.ok(!answer.includes(t), "the token is not given away");
    }
    assert.equal(status(await ask("POST", "/camera?eye=1,2,3&target=0,0,0&up=0,1,0")), 404);
  },
  async "a Host of somebody else's is refused (a name that was made to mean this machine)"() {
    for (const host of ["evil.example", "evil.example:80", `127.0.0.1.evil.example:${viewer.port}`, "localhost.evil.example", "127.0.0.1@evil.example",
      "localhost:80@evil.example", "[::1].evil.example", "[::1", "", "127.0.0.1:x", "10.0.0.1", "127.evil"])
      assert.equal(status(await ask("GET", ownPath(), { Host: host })), 421, host);
    assert.equal(status(await ask("GET", ownPath(), { Host: null })), 421, "none");
    assert.equal(status(await ask("GET", ownPath(), { host: "localhost", Host: "evil.example" })), 421, "two");
    for (const host of ["localhost", "localhost:9000", "127.0.0.1:1", "[::1]:80"]) assert.equal(status(await ask("GET", ownPath(), { Host: host })), 200, host);
  },
  async "pages of other origins are refused"() {
    const own = `http://127.0.0.1:${viewer.port}`;
    for (const origin of ["http://evil.example", "null", "https://127.0.0.1:" + viewer.port, "http://127.0.0.1:1", own + ".evil.example", "file://"]) {
      assert.equal(status(await ask("POST", ownPath("reset"), { Origin: origin })), 403, origin);
      assert.equal(status(await ask("GET", ownPath("next"), { Origin: origin })), 403, origin);
    }
    assert.equal(status(await ask("POST", ownPath("reset"), { "Sec-Fetch-Site": "cross-site" })), 403);
    assert.equal(status(await ask("POST", ownPath("reset"), { Origin: own })), 204);
  },
  async "no file can be read"() {
    for (const path of ["../../../../etc/passwd", "..%2f..%2f..%2fetc%2fpasswd", "%2e%2e/%2e%2e/etc/passwd", "/etc/passwd", "..\\..\\etc\\passwd", "view.css/../../etc/passwd",
      "picture.exr/../../etc/passwd", "view.css%00.html", "%00", "two-spheres.xml", "floor.obj", "file:///etc/passwd", "camera.xml?dialect=/etc/passwd"]) {
      const answer = await ask("GET", ownPath(path));
      assert.ok([404, 400].includes(status(answer)) || path.startsWith("camera.xml"), `${path}: ${status(answer)}`);
      assert.ok(!answer.includes("root:"), path);
    }
    assert.ok([400, 404].includes(status(await ask("GET", "http://127.0.0.1/etc/passwd"))));
  },
  async "methods, bodies, ranges"() {
    for (const method of ["PUT", "DELETE", "OPTIONS", "PATCH"]) assert.ok([405, 400].includes(status(await ask(method, ownPath()))), method);
    for (const method of ["TRACE", "CONNECT", "get", "PRI", ""]) assert.ok([0, 400, 405].includes(status(await ask(method, ownPath()))), method);
    assert.equal(status(await exchange(head("POST", ownPath("reset"), { "Content-Length": 5 }) + "hello").then(String)), 413);
    assert.equal(status(await exchange(head("POST", ownPath("reset"), { "Transfer-Encoding": "chunked" }) + "ffffffff\r\n").then(String)), 413);
    const ranges = "bytes=" + Array(300).fill("0-").join(",");
    const answer = await ask("GET", ownPath("view.js"), { Range: ranges });
    assert.equal(status(answer), 200);
    assert.ok(answer.length < 100000, "the bytes come once");
  },
  async "wrong numbers"() {
    const place = "eye=0,1,-6&target=0,0,0&up=0,1,0";
    for (const query of ["", "eye=1,2,3", "eye=1,2&target=0,0,0&up=0,1,0", "eye=nan,0,0&target=0,0,0&up=0,1,0", "eye=inf,0,0&target=0,0,0&up=0,1,0", "eye=1e300,0,0&target=0,0,0&up=0,1,0",
      "eye=0,0,0&target=0,0,0&up=0,1,0", "eye=0,0,-1&target=0,0,0&up=0,0,1", "eye=0,0,-1&target=0,0,0&up=0,0,0", "eye=1,2,3,4&target=0,0,0&up=0,1,0", `${place}&fov=0`, `${place}&fov=180`, `${place}&fov=x`, `${place}&fov=nan`])
      assert.equal(status(await ask("POST", ownPath("camera?" + query))), 400, query);
    for (const query of ["samples=0", "samples=-1", "samples=1e30", "samples=1.5", "samples=x", "samples="]) assert.equal(status(await ask("POST", ownPath("settings?" + query))), 400, query);
    for (const query of ["crop=1", "crop=1,2,3", "crop=0,0,0,1", "crop=1,2,3,4,5", "crop=-1,0,1,1", "crop=0,0,1e9,1", "crop=a,b,c,d", "maxDepth=0", "maxDepth=-1", "maxDepth=1e12", "rrDepth=x"]) assert.equal(status(await ask("POST", ownPath("settings?" + query))), 400, query);
    for (const query of ["aperture=-1", "aperture=nan", "focus=0", "focus=1e300"]) assert.equal(status(await ask("POST", ownPath(`camera?${place}&${query}`))), 400, query);
    for (const query of ["", "x=1", "x=-1&y=0", "x=1&y=1e12", "x=a&y=b"]) for (const page of ["point", "explain"]) assert.equal(status(await ask("GET", ownPath(`${page}?${query}`))), 400, query);
    assert.equal(status(await ask("GET", ownPath("explain?x=4000&y=0&by=reference"))), 409);
    assert.equal(status(await ask("GET", ownPath("picture.png?tone=x"))), 400);
    assert.equal(status(await ask("GET", ownPath("next?aov=hit&layer=x"))), 200);
    assert.equal(status(await ask("GET", ownPath("next?version=-1&picture=1e400&error=%ff"))), 200);
    for (const [query, code] of [["", 404], ["row=99", 404], ["row=-1&name=top&value=1", 404], ["row=1e99", 404], ["row=0&name=top&value=x", 400], ["row=0&name=top&value=1,2", 400],
      ["row=0&name=radiance&value=1", 409], ["row=0&name=top&value=-1", 409], ["row=0&name=top&value=nan", 400], ["row=0&name=top&value=inf", 409], ["row=0&name=top&value=1e-40", 409],
      ["row=0&value=1", 409], [`row=0&name=${"n".repeat(5000)}`, 409]])
      assert.equal(status(await ask("POST", ownPath("light?" + query))), code, query);
    for (const query of ["", "row=1", "row=x"]) assert.equal(status(await ask("GET", ownPath("light?" + query))), 404, query);
    assert.equal((await viewer.done()).problem, "");
  },
  async "a thousand reloads leave nothing behind"() {
    const files = () => readdirSync(`/proc/${viewer.process.pid}/fd`).length;
    const reload = async (times) => {
      const { loads } = await viewer.next();
      for (let i = 0; i < times / 8; ++i) await Promise.all(Array.from({ length: 8 }, () => viewer.post("reload").then((r) => assert.equal(r.status, 204))));
      const state = await viewer.until((s) => s.loads > loads && s.phase === "done");
      assert.equal(state.problem, "");
      return state.loads - loads;
    };
    await reload(200);
    const before = memory(), open = files(), times = await reload(800);
    assert.ok(memory() - before < 40, `${memory() - before} MiB more after the scene was read ${times} times`);
    assert.ok(files() <= open + 10, `${files()} open files, ${open} before`);
  },
  async "requests that never end are cut off, and kept by nobody"() {
    const before = memory();
    const mebibytes = Buffer.alloc(4 << 20, "a");
    for (const bytes of [mebibytes, Buffer.concat([Buffer.from(`GET /${"a".repeat(1 << 20)} HTTP/1.1\r\n\r\n`)]), Buffer.concat([Buffer.from(`GET ${ownPath()} HTTP/1.1\r\nX: `), mebibytes]),
      Buffer.from(`GET ${ownPath()} HTTP/1.1\r\n` + "A: b\r\n".repeat(1 << 18)), Buffer.from(head("GET", ownPath("next?" + "a=b&".repeat(1 << 16))))]) {
      const start = Date.now(), answer = (await exchange(bytes)).toString("latin1");
      assert.notEqual(status(answer), 200);
      assert.ok(Date.now() - start < 4000, "at once, not when the time is up");
    }
    assert.ok(memory() - before < 16, `${memory() - before} MiB more`);
    await answersSoon();
  },
  async "bytes that are no request"() {
    let seed = 1;
    const random = () => (seed = (seed * 1103515245 + 12345) & 0x7fffffff) >> 8 & 255;
    const tls = Buffer.from("16030100a5010000a10303", "hex");
    for (const bytes of [Buffer.alloc(0), Buffer.from("\0\0\0\0\r\n\r\n"), tls, Buffer.from("\r\n\r\n"), Buffer.from("GET\r\n\r\n"), Buffer.from("GET / HTTP/9.9\r\n\r\n"), Buffer.from("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"),
      Buffer.from(`GET ${ownPath()}%zz%u HTTP/1.1\r\n\r\n`), Buffer.from(`GET ${ownPath()} HTTP/1.1\r\nHost\r\n:\r\n: x\r\n\r\n`), ...Array.from({ length: 60 }, () => Buffer.from(Array.from({ length: 200 }, random)))])
      assert.notEqual(status((await exchange(bytes, { ms: 8000 })).toString("latin1")), 200);
    await answersSoon();
  },
  async "three hundred half-open connections hold up nobody and are closed in time"() {
    const sockets = [], closed = [];
    for (let i = 0; i < 300; ++i) {
      const socket = connect(viewer.port, "127.0.0.1");
      closed.push(new Promise((resolve) => socket.on("close", resolve)));
      socket.on("error", () => {}).on("connect", () => socket.write(i % 2 ? `GET ${ownPath()} HTTP/1.1\r\nHost: 127` : ""));
      socket.resume();
      sockets.push(socket);
    }
    await pause(300);
    await answersSoon();
    await viewer.next();
    assert.ok(threads() < 140, `${threads()} threads`);
    const start = Date.now();
    await Promise.race([Promise.all(closed), pause(10000)]);
    assert.ok(Date.now() - start < 8000, "all are closed");
    await answersSoon();
  },
  async "clients that do not read slow nobody, and are no more than so many"() {
    const before = memory(), sockets = [], answers = [];
    for (let i = 0; i < 70; ++i) {
      const socket = connect({ port: viewer.port, host: "127.0.0.1", highWaterMark: 1 });
      socket.on("error", () => {});
      socket.on("readable", () => { if (answers[i] === undefined) answers[i] = status(String(socket.read(12))); });
      socket.write(head("GET", ownPath("next?version=0&picture=0")));
      sockets.push(socket);
    }
    await pause(1500);
    assert.ok(answers.includes(503), "there is an end of guests");
    assert.ok(answers.filter((s) => s === 200).length >= 30);
    // Some of them leave. A new page then gets pictures as if the others did not exist.
    for (const socket of sockets.splice(0, 40)) socket.destroy();
    await pause(300);
    for (let i = 0; i < 3; ++i) {
      const { picture } = await viewer.next(), start = Date.now();
      assert.equal((await viewer.post(`camera?eye=0,${2 + i},-6&target=0,0,0&up=0,1,0`)).status, 204);
      await viewer.until((s) => s.picture > picture);
      assert.ok(Date.now() - start < 4000, `a new picture took ${Date.now() - start} ms`);
    }
    assert.ok(memory() - before < 400, `${memory() - before} MiB more`);
    for (const socket of sockets) socket.destroy();
  },
  async "only this machine is listened to"() {
    const others = Object.values(networkInterfaces()).flat().filter((a) => !a.internal && a.family === "IPv4");
    for (const { address } of others) assert.equal((await exchange(head("GET", ownPath()), { host: address, ms: 3000 })).length, 0, address);
  },
  async "Ctrl-C ends it cleanly with connections open"() {
    const socket = connect(viewer.port, "127.0.0.1");
    socket.on("error", () => {});
    socket.write("GET /");
    const waiting = viewer.next(1e9, 1e9).catch(() => null);
    await pause(200);
    const start = Date.now(), { code, signal } = await viewer.end();
    assert.deepEqual({ code, signal }, { code: 0, signal: null }, viewer.errors);
    assert.ok(Date.now() - start < 4000, `${Date.now() - start} ms`);
    await waiting;
    socket.destroy();
    assert.match(viewer.errors, /has ended\./);
  },
  async "listening elsewhere has to be asked for, and then takes numbers but no strange names"() {
    const open = await Viewer.start(program, scene.file, "--listen", "0.0.0.0");
    try {
      const at = (host) => exchange(`GET ${open.path} HTTP/1.1\r\nHost: ${host}\r\n\r\n`, { port: open.port }).then((b) => status(b.toString("latin1")));
      assert.equal(await at(`192.0.2.7:${open.port}`), 200);
      assert.equal(await at(`evil.example:${open.port}`), 421);
      assert.equal(await at(`localhost:${open.port}`), 200);
    } finally {
      assert.equal((await open.end("SIGTERM")).code, 0);
    }
  },
};

try {
  viewer = await Viewer.start(program, scene.file);
  await viewer.done();
  process.exitCode = await runAll(tests) ? 1 : 0;
} finally {
  if (viewer) viewer.process.kill("SIGKILL");
  scene.remove();
}
process.exit();  // even if sockets are still waiting
