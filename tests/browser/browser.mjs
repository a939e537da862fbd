// Chromium, driven through chromedriver's HTTP interface, so that nothing has to be installed but Debian's chromium, chromium-driver and
// nodejs. `start` returns null where one of them is missing.

import { spawn, spawnSync } from "node:child_process";
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";

export const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const find = (name) => spawnSync("sh", ["-c", `command -v ${name}`], { encoding: "utf8" }).stdout.trim();

export class Browser {
  // `work`: a folder for the browser's own files.
  static async start(work, shots) {
    const chromium = find("chromium"), driverPath = find("chromedriver");
    if (!chromium || !driverPath) return null;
    const browser = new Browser();
    browser.shots = shots;
    if (shots) mkdirSync(shots, { recursive: true });
    browser.driver = spawn(driverPath, ["--port=0"], { stdio: ["ignore", "pipe", "inherit"] });
    browser.port = await new Promise((resolve, reject) => {
      let text = "";
      browser.driver.stdout.on("data", (chunk) => { text += chunk; const m = text.match(/successfully on port (\d+)/); if (m) resolve(m[1]); });
      browser.driver.on("exit", () => reject(new Error("chromedriver ended: " + text)));
    });
    browser.session = "";
    const { sessionId } = await browser.call("POST", "/session", { capabilities: { alwaysMatch: {
      browserName: "chrome", "goog:loggingPrefs": { browser: "ALL" }, "goog:chromeOptions": { binary: chromium, args: [
        "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-component-update",
        "--disable-sync", "--disable-dev-shm-usage", `--user-data-dir=${join(work, "profile")}`] } } } });
    browser.session = `/session/${sessionId}`;
    return browser;
  }

  async end() {
    if (this.session) await this.call("DELETE", "").catch(() => {});
    this.driver.kill();
  }

  async call(method, path, body) {
    const response = await fetch(`http://127.0.0.1:${this.port}${this.session}${path}`,
      { method, headers: { "Content-Type": "application/json" }, body: body === undefined ? undefined : JSON.stringify(body) });
    const { value } = await response.json();
    if (value && value.error) throw new Error(`${method} ${path}: ${value.message}`);
    return value;
  }

  js(script, ...args) { return this.call("POST", "/execute/sync", { script, args }); }
  cdp(cmd, params = {}) { return this.call("POST", "/goog/cdp/execute", { cmd, params }); }
  open(url) { return this.call("POST", "/url", { url }); }
  handle() { return this.call("GET", "/window"); }
  async newTab() { const { handle } = await this.call("POST", "/window/new", { type: "tab" }); await this.switchTo(handle); return handle; }
  switchTo(handle) { return this.call("POST", "/window", { handle }); }
  closeTab() { return this.call("DELETE", "/window"); }

  async click(selector) {
    const element = await this.call("POST", "/element", { using: "css selector", value: selector });
    await this.call("POST", `/element/${Object.values(element)[0]}/click`, {});
  }
  keys(...values) {
    return this.call("POST", "/actions", { actions: [{ type: "key", id: "keyboard",
      actions: values.flatMap((value) => [{ type: "keyDown", value }, { type: "keyUp", value }]) }] });
  }
  // With the button down from one place of the window to another; without `to` a move alone.
  mouse(from, to, button = 0) {
    return this.call("POST", "/actions", { actions: [{ type: "pointer", id: "mouse", parameters: { pointerType: "mouse" },
      actions: [{ type: "pointerMove", x: Math.round(from[0]), y: Math.round(from[1]), duration: 0 },
        ...(to ? [{ type: "pointerDown", button }, { type: "pointerMove", x: Math.round(to[0]), y: Math.round(to[1]), duration: 150 },
          { type: "pointerUp", button }] : [])] }] });
  }
  wheel(at, deltaY) {
    return this.call("POST", "/actions", { actions: [{ type: "wheel", id: "wheel",
      actions: [{ type: "scroll", x: Math.round(at[0]), y: Math.round(at[1]), deltaX: 0, deltaY, duration: 0 }] }] });
  }

  async size(width, height, scale = 1, dark = false) {
    await this.cdp("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: scale, mobile: width < 600 });
    await this.cdp("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: dark ? "dark" : "light" }] });
    await pause(150);
  }
  async shot(name) {
    if (!this.shots) return;
    const { data } = await this.cdp("Page.captureScreenshot", { captureBeyondViewport: true });
    writeFileSync(join(this.shots, name + ".png"), Buffer.from(data, "base64"));
  }

  // Until `script`, a JavaScript expression in the page, is true.
  async until(script, what = script, ms = 30000) {
    const end = Date.now() + ms;
    while (Date.now() < end) {
      if (await this.js(`return ${script}`)) return;
      await pause(40);
    }
    throw new Error(`not within ${ms} ms: ${what}`);
  }
}

// Runs named tests one after the other and returns how many failed.
export async function runAll(tests) {
  let failed = 0;
  for (const [name, test] of Object.entries(tests)) {
    const start = Date.now();
    try {
      await Promise.race([test(), new Promise((_, reject) => setTimeout(() => reject(new Error("not within a minute")), 60000).unref())]);
      console.log(`ok    ${name} (${Date.now() - start} ms)`);
    } catch (error) {
      ++failed;
      console.log(`FAIL  ${name}\n${error.stack}`);
    }
  }
  console.log(failed ? `${failed} failed` : "all passed");
  return failed;
}
