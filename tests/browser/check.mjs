// Checks pages in headless Chromium: node check.mjs CHROMIUM AXE PAGE…
//
// Nothing is loaded, nothing is complained of, keyboard and mouse work, axe-core finds nothing in light and
// in dark, no page is wider than a telephone, it prints, and it is usable soon. PICTURES=FOLDER keeps pictures.

import { readFileSync, statSync, writeFileSync } from "node:fs";
import { basename, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Chromium, sleep } from "./chromium.mjs";

const [program, axeFile, ...pages] = process.argv.slice(2);
const axe = readFileSync(axeFile, "utf8");
const pictures = process.env.PICTURES;
let failures = 0;

// Heard by the page itself, from its first moment on: when its first figure can be used.
const WATCH = `
  window.usable = null;
  new MutationObserver((_, observer) => {
    if (document.querySelector(".enhanced .uplot canvas")) {
      observer.disconnect();
      requestAnimationFrame(() => { window.usable = performance.now(); });
    }
  }).observe(document, { childList: true, subtree: true });
`;

function fail(page, what) {
  failures += 1;
  console.log("FAILED " + basename(page) + ": " + what);
}

async function open(browser, page, { dark = false, width = 1280, height = 900, scripts = true } = {}) {
  const tab = await browser.tab();
  for (const domain of ["Page", "Runtime", "Log", "Network"]) await tab.send(domain + ".enable");
  await tab.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: width < 600 });
  await tab.send("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: dark ? "dark" : "light" }] });
  await tab.send("Emulation.setScriptExecutionDisabled", { value: !scripts });
  if (scripts) await tab.send("Page.addScriptToEvaluateOnNewDocument", { source: WATCH });
  tab.url = pathToFileURL(resolve(page)).href;
  tab.events.length = 0;
  await tab.send("Page.navigate", { url: tab.url });
  await tab.waitFor("Page.loadEventFired");
  return tab;
}

// What the page said and asked for.
function complaints(tab) {
  const all = [];
  for (const { method, params } of tab.events) {
    if (method === "Runtime.consoleAPICalled" && ["error", "warning", "assert"].includes(params.type)) {
      all.push("console: " + params.args.map((arg) => arg.value ?? arg.description).join(" "));
    } else if (method === "Runtime.exceptionThrown") {
      all.push("exception: " + (params.exceptionDetails.exception?.description ?? params.exceptionDetails.text));
    } else if (method === "Log.entryAdded" && ["error", "warning"].includes(params.entry.level)) {
      all.push("log: " + params.entry.text);
    } else if (method === "Network.requestWillBeSent") {
      const { url } = params.request;
      if (url !== tab.url && !url.startsWith("data:")) all.push("request: " + url);
    }
  }
  return all;
}

// All figures come to life when they are seen.
async function scrollThrough(tab) {
  await tab.value(`(async () => {
    for (let y = 0; y < document.documentElement.scrollHeight; y += innerHeight / 2) {
      scrollTo(0, y);
      await new Promise((done) => requestAnimationFrame(() => setTimeout(done, 20)));
    }
    scrollTo(0, 0);
  })()`);
  await sleep(50);
}

async function accessible(tab, page, look) {
  await tab.value("document.querySelectorAll('details').forEach((d) => { d.open = true; })");
  await tab.value(axe + "; 0");
  const found = JSON.parse(await tab.value(`axe.run(document, { resultTypes: ["violations", "incomplete"] }).then((r) => JSON.stringify({
    passes: r.passes.length,
    violations: r.violations.map((v) => v.id + " (" + v.impact + "): " + v.nodes.slice(0, 3).map((n) => n.target.join(" ") + " " + n.any.concat(n.all).map((c) => c.message).join("; ")).join(" | ") + (v.nodes.length > 3 ? " and " + (v.nodes.length - 3) + " more" : "")),
  }))`));
  found.violations.forEach((violation) => fail(page, "axe, " + look + ": " + violation));
  return found.passes;
}

// Tab to every figure; arrows read, plus zooms, Escape shows all; the legend switches.
async function keyboard(tab, page) {
  const figures = await tab.value("document.querySelectorAll('.live').length");
  if (figures === 0) return 0;
  await tab.value("document.activeElement.blur(); scrollTo(0, 0)");
  const reached = new Set();
  let worked = 0;
  for (let presses = 0; presses < 3000 && reached.size < figures; presses++) {
    await tab.key("Tab");
    const at = await tab.value("[...document.querySelectorAll('.live')].indexOf(document.activeElement)");
    if (at < 0 || reached.has(at)) continue;
    reached.add(at);
    if (worked < 3) {
      await plot(tab, page, at);
      worked += 1;
    }
  }
  if (reached.size < figures) fail(page, "Tab reaches " + reached.size + " of " + figures + " figures");
  return reached.size;
}

async function plot(tab, page, at) {
  const figure = "[...document.querySelectorAll('.live')][" + at + "]";
  const visible = await tab.value(`(() => { const r = ${figure}.getBoundingClientRect(); const s = getComputedStyle(${figure}); return r.height > 50 && s.outlineStyle !== "none"; })()`);
  if (!visible) fail(page, "figure " + (at + 1) + " has the focus and does not show it");
  const read = () => tab.value(figure + ".querySelector('.x-read').textContent");
  const zoomed = () => tab.value("!" + figure + ".querySelector('.tools button').hidden");
  await tab.key("ArrowRight");
  const first = await read();
  // A machine may rest for a while.
  let second = first;
  for (let n = 0; n < 100 && second === first; n++) {
    await tab.key("ArrowRight");
    second = await read();
  }
  if (!first || first === second) fail(page, `figure ${at + 1}: arrows do not move the read-out (“${first}”, “${second}”)`);
  if (!(await tab.value(figure + ".querySelector('[aria-live]').textContent"))) fail(page, `figure ${at + 1}: nothing is announced`);
  await tab.key("+", "Equal", "+");
  if (!(await zoomed())) fail(page, `figure ${at + 1}: plus does not zoom`);
  await tab.key("Escape");
  if (await zoomed()) fail(page, `figure ${at + 1}: Escape does not show all`);
}

// Drag to zoom, point to read, switch a curve.
async function mouse(tab, page) {
  const box = await tab.value(`(() => {
    const over = document.querySelector(".live .u-over");
    if (!over) return null;
    over.scrollIntoView({ block: "center" });
    const r = over.getBoundingClientRect();
    return { x: r.x, y: r.y, w: r.width, h: r.height };
  })()`);
  if (!box) return;
  const live = "document.querySelector('.live')";
  const [y, x0, x1] = [box.y + box.h / 2, box.x + box.w * 0.3, box.x + box.w * 0.6];
  await tab.mouse("mouseMoved", x0, y);
  await sleep(60);
  if (!(await tab.value(live + ".querySelector('.x-read').textContent"))) fail(page, "pointing reads nothing");
  await tab.mouse("mousePressed", x0, y - box.h / 4, { button: "left", buttons: 1, clickCount: 1 });
  for (let part = 1; part <= 5; part++) {
    await tab.mouse("mouseMoved", x0 + ((x1 - x0) * part) / 5, y - box.h / 4 + (box.h / 2) * (part / 5), { button: "left", buttons: 1 });
  }
  await tab.mouse("mouseReleased", x1, y + box.h / 4, { button: "left", clickCount: 1 });
  await sleep(60);
  if (await tab.value(live + ".querySelector('.tools button').hidden")) fail(page, "dragging does not zoom");
  await tab.value(live + ".querySelector('.tools button').click()");
  const legend = "document.querySelector('.enhanced .legend button')";
  await tab.value(legend + ".click()");
  if ((await tab.value(legend + ".getAttribute('aria-pressed')")) !== "false") fail(page, "the legend does not switch");
  await tab.value(legend + ".click()");
}

async function prints(tab, page) {
  await tab.send("Emulation.setEmulatedMedia", { media: "print" });
  const bad = await tab.value(`(() => {
    const shown = (node) => getComputedStyle(node).display !== "none";
    const live = [...document.querySelectorAll(".live")].filter(shown).length;
    const missing = [...document.querySelectorAll(".picture.wide")].filter((node) => !shown(node)).length;
    return { live, missing };
  })()`);
  if (bad.live + bad.missing > 0) fail(page, `in print ${bad.live} canvases are shown and ${bad.missing} pictures are not`);
  const { data } = await tab.send("Page.printToPDF", { printBackground: true, preferCSSPageSize: true });
  const pdf = Buffer.from(data, "base64");
  if (!pdf.subarray(0, 5).equals(Buffer.from("%PDF-"))) fail(page, "no PDF is printed");
  keep(page, ".pdf", pdf);
  return pdf.length;
}

function keep(page, ending, bytes) {
  if (pictures) writeFileSync(join(pictures, basename(page, ".html") + ending), bytes);
}

async function picture(tab, page, name) {
  if (!pictures) return;
  const { cssContentSize } = await tab.send("Page.getLayoutMetrics");
  const clip = { x: 0, y: 0, width: cssContentSize.width, height: Math.min(cssContentSize.height, 16000), scale: 1 };
  const { data } = await tab.send("Page.captureScreenshot", { format: "png", captureBeyondViewport: true, clip });
  keep(page, "-" + name + ".png", Buffer.from(data, "base64"));
}

async function check(browser, page) {
  const facts = {};
  let tab = await open(browser, page);
  // Figures further down come to life when they come near.
  const near = await tab.value("(() => { const f = document.querySelector('figure.chart'); return f !== null && f.getBoundingClientRect().top < innerHeight + 250; })()");
  for (let waited = 0; near && waited < 5000 && (await tab.value("window.usable")) === null; waited += 20) await sleep(20);
  const paint = await tab.value("performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? null");
  const usable = near ? await tab.value("window.usable") : await tab.value("performance.getEntriesByType('navigation')[0].loadEventEnd");
  Object.assign(facts, { bytes: statSync(page).size, paint: Math.round(paint), usable: Math.round(usable) });
  if (usable === null) fail(page, "no figure comes to life");
  await scrollThrough(tab);
  await picture(tab, page, "light");
  facts.figures = await keyboard(tab, page);
  await mouse(tab, page);
  facts.rules = await accessible(tab, page, "light");
  facts.pdf = await prints(tab, page);
  complaints(tab).forEach((complaint) => fail(page, complaint));
  await tab.close();

  tab = await open(browser, page, { dark: true });
  await scrollThrough(tab);
  await picture(tab, page, "dark");
  await accessible(tab, page, "dark");
  complaints(tab).forEach((complaint) => fail(page, complaint));
  await tab.close();

  tab = await open(browser, page, { width: 360, height: 740 });
  await scrollThrough(tab);
  const over = await tab.value("document.documentElement.scrollWidth - innerWidth");
  if (over > 1) fail(page, `on a telephone it is ${over} px too wide`);
  await picture(tab, page, "narrow");
  complaints(tab).forEach((complaint) => fail(page, complaint));
  await tab.close();

  tab = await open(browser, page, { scripts: false });
  await picture(tab, page, "still");
  complaints(tab).forEach((complaint) => fail(page, complaint));
  await tab.close();
  console.log(basename(page) + ": " + JSON.stringify(facts));
}

const browser = new Chromium(program);
try {
  for (const page of pages) await check(browser, page);
} catch (error) {
  console.log("FAILED " + error.stack);
  failures += 1;
} finally {
  await browser.close();
}
process.exitCode = failures > 0 ? 1 : 0;
