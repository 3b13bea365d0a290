// Headless Chromium over a pair of pipes: what DevTools' protocol needs and nothing else.

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const FLAGS = [
  "--headless=new",
  "--no-sandbox",
  "--disable-gpu",
  "--disable-dev-shm-usage",
  "--disable-extensions",
  "--disable-background-networking",
  "--disable-component-update",
  "--no-first-run",
  "--no-default-browser-check",
  "--hide-scrollbars",
  "--force-device-scale-factor=1",
  "--remote-debugging-pipe",
];

export class Chromium {
  constructor(program) {
    this.profile = mkdtempSync(join(tmpdir(), "pages-check-"));
    const flags = [...FLAGS, "--user-data-dir=" + this.profile];
    this.child = spawn(program, flags, { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
    this.out = this.child.stdio[3];
    this.number = 0;
    this.waiting = new Map();
    this.listeners = [];
    this.rest = "";
    this.ended = new Promise((resolve) => this.child.on("exit", resolve));
    this.child.stdio[4].setEncoding("utf8").on("data", (text) => this.heard(text));
  }

  heard(text) {
    const parts = (this.rest + text).split("\0");
    this.rest = parts.pop();
    for (const part of parts) {
      const message = JSON.parse(part);
      const waits = this.waiting.get(message.id);
      if (waits) {
        this.waiting.delete(message.id);
        if (message.error) waits.reject(new Error(waits.method + ": " + message.error.message));
        else waits.resolve(message.result);
      } else if (message.method) {
        this.listeners.forEach((listener) => listener(message));
      }
    }
  }

  send(method, params = {}, sessionId = undefined) {
    const id = ++this.number;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject, method });
      this.out.write(JSON.stringify({ id, method, params, sessionId }) + "\0");
    });
  }

  // A new tab.
  async tab() {
    const { targetId } = await this.send("Target.createTarget", { url: "about:blank" });
    const { sessionId } = await this.send("Target.attachToTarget", { targetId, flatten: true });
    return new Tab(this, targetId, sessionId);
  }

  async close() {
    await this.send("Browser.close").catch(() => {});
    await this.ended;
    rmSync(this.profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 200 });
  }
}

class Tab {
  constructor(browser, target, session) {
    Object.assign(this, { browser, target, session, events: [] });
    browser.listeners.push((message) => {
      if (message.sessionId === session) this.events.push(message);
    });
  }

  send(method, params) {
    return this.browser.send(method, params, this.session);
  }

  // The value of an expression in the page.
  async value(expression) {
    const result = await this.send("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
    if (result.exceptionDetails) {
      const { text, exception } = result.exceptionDetails;
      throw new Error(expression.slice(0, 80) + ": " + text + " " + (exception?.description ?? ""));
    }
    return result.result.value;
  }

  async waitFor(method, seconds = 30) {
    for (let waited = 0; waited < seconds * 1000; waited += 5) {
      const found = this.events.find((event) => event.method === method);
      if (found) return found;
      await sleep(5);
    }
    throw new Error(method + " did not come in " + seconds + " s");
  }

  async key(key, code = key, text = undefined) {
    const of = (type) => ({ type, key, code, text: type === "keyDown" ? text : undefined, windowsVirtualKeyCode: CODES[key] ?? key.charCodeAt(0) });
    await this.send("Input.dispatchKeyEvent", of("keyDown"));
    await this.send("Input.dispatchKeyEvent", of("keyUp"));
  }

  mouse(type, x, y, more = {}) {
    return this.send("Input.dispatchMouseEvent", { type, x, y, button: "none", ...more });
  }

  async close() {
    await this.browser.send("Target.closeTarget", { targetId: this.target });
  }
}

const CODES = { Tab: 9, Escape: 27, ArrowLeft: 37, ArrowRight: 39, Enter: 13, " ": 32, "+": 187 };

export function sleep(milliseconds) {
  return new Promise((resolve) => setTimeout(resolve, milliseconds));
}
