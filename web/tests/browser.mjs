// A headless Chromium, the page in it, and the native programs that it is compared with.

import { execFileSync, spawn } from "node:child_process";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { chromium } from "playwright-core";

const { PAGE, CHROMIUM, BOXWOOD, EXAMPLES } = process.env;
const FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
/** Milliseconds that anything on the page may take: the machine may be busy. */
const PATIENCE = 120_000;

/** `boxwood view --web` at work: `.url` is where the page is, with `scene` opened if there is one. */
export async function serve(...scene) {
  const program = spawn(BOXWOOD, ["view", ...scene, "--web", "--page", PAGE, "--json"], { stdio: ["ignore", "pipe", "inherit"] });
  let text = "";
  for await (const line of createInterface({ input: program.stdout })) {
    text += line;
    if (line === "}") break;
  }
  return { url: JSON.parse(text).url, close: () => program.kill() };
}

const server = await serve();
const browser = await chromium.launch({ executablePath: CHROMIUM.startsWith("/") ? CHROMIUM : `/usr/bin/${CHROMIUM}`, args: FLAGS });
export const close = async () => { await browser.close(); server.close(); };

/** Opens the page at `address` (`?wasm=plain#...`) and waits until its first scene stands. `faults` collects errors and strange requests. */
export async function open(address = "", options = {}, prepare = async () => {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  const faults = [];
  page.on("console", (message) => { if (["error", "warning"].includes(message.type())) faults.push(message.text()); });
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("request", (request) => { if (!/^(http:\/\/127\.0\.0\.1[:/]|data:|blob:)/.test(request.url())) faults.push(`request to ${request.url()}`); });
  await prepare(page);
  await page.goto(/^http:/.test(address) ? address : server.url + address);
  await page.waitForFunction(() => document.documentElement.dataset.ready);
  const ask = (question, ...args) => page.evaluate(async ([question, args]) => (await import("/js/lab.js")).ask(question, ...args), [question, args]);
  return { page, faults, ask, close: () => context.close() };
}

/** What the command line says, as JSON. */
export const cli = (...args) => JSON.parse(execFileSync(BOXWOOD, [...args, "--json"], { maxBuffer: 1 << 28, stdio: ["ignore", "pipe", "ignore"] }));

/** What rays hit natively: one hash for each structure. */
export const hashes = (...args) => execFileSync(join(EXAMPLES, "hashes"), args.map(String), { encoding: "utf8" }).trim().split("\n");

/** Milliseconds per frame of each structure, natively in one thread. */
export const nativeRace = (...args) => execFileSync(join(EXAMPLES, "race"), args, { encoding: "utf8", env: { ...process.env, RAYON_NUM_THREADS: "1" } }).trim().split("\n").map(Number);

/** The text of a number on the page. */
export const value = (page, figure, name) => page.textContent(`[data-figure=${figure}] [data-value="${name}"]`);
