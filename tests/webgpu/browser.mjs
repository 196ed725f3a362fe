// Chromium without a window, by its debugging protocol over pipes.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const LIMIT = 240000; // of an answer [ms]

/** A page in a browser of its own. */
export class Browser {
  #process;
  #profile = mkdtempSync(join(tmpdir(), "pelage-browser-"));
  #next = 1;
  #waiting = new Map();
  #session = "";
  #text = "";
  /** Messages of the console that are errors, and exceptions. @type {string[]} */
  errors = [];

  /** @param {string} program @param {string[]} options */
  constructor(program, options) {
    const always = ["--headless=new", "--no-sandbox", "--no-first-run", "--remote-debugging-pipe"];
    this.#process = spawn(program, [...always, `--user-data-dir=${this.#profile}`, ...options, "about:blank"], {
      stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"],
      detached: true, // a group of processes, which end together
    });
    this.#process.stdio[4].on("data", (data) => this.#take(String(data)));
    this.#process.on("exit", () => {
      for (const { reject } of this.#waiting.values()) reject(new Error(`${program} has ended`));
    });
  }

  /**
   * @param {string} address
   * @param {string} before script that runs before those of the page
   */
  async open(address, before) {
    const { targetId } = await this.#send("Target.createTarget", { url: "about:blank" });
    this.#session = (await this.#send("Target.attachToTarget", { targetId, flatten: true })).sessionId;
    await this.#send("Runtime.enable");
    await this.#send("Log.enable");
    await this.#send("Page.enable");
    await this.#send("Page.addScriptToEvaluateOnNewDocument", { source: before });
    await this.#send("Page.navigate", { url: address });
    await this.until("location.href !== 'about:blank' && document.readyState === 'complete'");
  }

  /**
   * The value of an expression in the page, or of what it promises.
   * @param {string} expression
   */
  async evaluate(expression) {
    const answer = await this.#send("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
    if (answer.exceptionDetails) throw new Error(answer.exceptionDetails.exception?.description ?? "an exception in the page");
    return answer.result.value;
  }

  /**
   * Waits until an expression is true in the page.
   * @param {string} expression
   */
  async until(expression) {
    for (const begin = Date.now(); Date.now() - begin < LIMIT; ) {
      if (await this.evaluate(expression)) return;
      await new Promise((resolve) => setTimeout(resolve, 200));
    }
    throw new Error(`the page has not come to: ${expression}`);
  }

  /**
   * Drags the mouse from a point of the page to another one.
   * @param {number[]} from
   * @param {number[]} to
   */
  async drag(from, to) {
    const mouse = (type, [x, y], buttons) =>
      this.#send("Input.dispatchMouseEvent", { type, x, y, buttons, button: "left", clickCount: 1 });
    await mouse("mousePressed", from, 1);
    await mouse("mouseMoved", to, 1);
    await mouse("mouseReleased", to, 0);
  }

  async close() {
    const ended = new Promise((resolve) => this.#process.on("exit", resolve));
    process.kill(-this.#process.pid, "SIGKILL");
    await ended;
    rmSync(this.#profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 100 });
  }

  #send(method, params = {}) {
    const id = this.#next++;
    const message = { id, method, params, ...(this.#session && { sessionId: this.#session }) };
    this.#process.stdio[3].write(`${JSON.stringify(message)}\0`);
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => reject(new Error(`no answer to ${method}`)), LIMIT);
      this.#waiting.set(id, {
        resolve: (value) => (clearTimeout(timer), resolve(value)),
        reject: (error) => (clearTimeout(timer), reject(error)),
      });
    });
  }

  #take(data) {
    const parts = (this.#text + data).split("\0");
    this.#text = parts.pop();
    for (const part of parts) {
      const { id, result, error, method, params } = JSON.parse(part);
      if (id) {
        const waiting = this.#waiting.get(id);
        this.#waiting.delete(id);
        if (error) waiting?.reject(new Error(error.message));
        else waiting?.resolve(result);
      } else if (method === "Runtime.exceptionThrown") this.errors.push(params.exceptionDetails.exception?.description);
      else if (method === "Runtime.consoleAPICalled" && params.type === "error")
        this.errors.push(params.args.map(({ value }) => value).join(" "));
      else if (method === "Log.entryAdded" && params.entry.level === "error") this.errors.push(params.entry.text);
    }
  }
}
