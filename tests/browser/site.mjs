// The site of docs in a real browser, from files: node site.mjs FOLDER_OF_THE_SITE [SCREENSHOT_FOLDER]. Exits 77 where there is none.

import { existsSync, mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import assert from "node:assert/strict";
import { Browser, runAll } from "./browser.mjs";

const [folder, shots] = process.argv.slice(2);
const site = resolve(folder);
const work = mkdtempSync(join(tmpdir(), "etendue-site-"));
const browser = existsSync(join(site, "index.html")) ? await Browser.start(work, shots) : null;
if (!browser) {
  console.log("skipped: needs the site (site.pages), chromium and chromedriver (Debian: chromium chromium-driver)");
  process.exit(77);
}
const pages = readdirSync(site, { recursive: true }).map(String).filter((name) => name.endsWith(".html")).sort();
const open = (name) => browser.open(`file://${join(site, name)}`);

// What does not fit into the page's width, is not there or went wrong.
const faults = (name, width) => browser.js(`
  const width = arguments[0];  // window.innerWidth of a telephone grows with what is too wide
  for (const image of document.images) image.loading = "eager";
  const wrong = [];
  if (document.documentElement.scrollWidth > width + 1) wrong.push("wider than the window");
  const scrolls = (e) => e.tagName !== "ARTICLE" && (["auto", "scroll"].includes(getComputedStyle(e).overflowX) || scrolls(e.parentElement));
  const wide = [...document.querySelectorAll("article *:not(.katex *)")].filter((e) => e.getBoundingClientRect().right > width + 1 && !scrolls(e.parentElement));
  if (wide.length) wrong.push("beyond the edge: " + wide[0].outerHTML.slice(0, 120));
  for (const image of document.images) if (image.complete && !image.naturalWidth) wrong.push("no picture: " + image.src);
  for (const formula of document.querySelectorAll(".formula"))
    if (!formula.querySelector(".katex") || formula.querySelector(".katex-error")) wrong.push("no formula: " + formula.textContent);
  return wrong;`, width).then((wrong) => wrong.map((text) => `${name}: ${text}`));

async function look(some, width, height) {
  await browser.size(width, height);
  const wrong = [];
  for (const name of some) {
    await open(name);
    await browser.until("document.readyState === 'complete'");
    wrong.push(...await faults(name, width));
    if (["index.html", "docs/plugins/materials.html", "docs/report.html", "docs/mitsuba.html"].includes(name))
      await browser.shot(`${name.replace(/.*\//, "").replace(".html", "")}-${width}`);
  }
  assert.deepEqual(wrong, []);
}

const tests = {
  async "search works without a server"() {
    await open("search.html?q=roughconductor");
    await browser.until("document.querySelectorAll('#search-results li a').length > 0", "results of a search");
    const links = await browser.js("return [...document.querySelectorAll('#search-results li a')].map((a) => a.href)");
    assert.ok(links.some((link) => link.includes("docs/plugins/materials.html")), links.join("\n"));
  },
  async "nothing comes from elsewhere"() {
    await open("docs/report.html");
    const loaded = await browser.js("return performance.getEntriesByType('resource').map((entry) => entry.name)");
    assert.deepEqual(loaded.filter((name) => !name.startsWith("file://")), []);
  },
};

for (let i = 0; i < pages.length; i += 8) {
  const some = pages.slice(i, i + 8), from = `${some[0]} … ${some.at(-1)}`;
  tests[`fit a telephone: ${from}`] = () => look(some, 390, 844);
  tests[`fit a desktop: ${from}`] = () => look(some, 1280, 900);
}

try {
  process.exitCode = await runAll(tests) ? 1 : 0;
} finally {
  await browser.end();
  rmSync(work, { recursive: true, force: true, maxRetries: 5 });
}
