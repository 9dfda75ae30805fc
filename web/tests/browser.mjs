// A headless Chromium, the page in it, and the native programs that it is compared with.

import { execFileSync } from "node:child_process";
import { chromium } from "playwright-core";

const { PAGE, CHROMIUM, BOXWOOD, HASHES } = process.env;
const FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
/** Milliseconds that anything on the page may take: the machine may be busy. */
const PATIENCE = 120_000;

const browser = await chromium.launch({ executablePath: CHROMIUM.startsWith("/") ? CHROMIUM : `/usr/bin/${CHROMIUM}`, args: FLAGS });
export const close = () => browser.close();

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
  await page.goto(PAGE + address);
  await page.waitForFunction(() => document.documentElement.dataset.ready);
  const ask = (question, ...args) => page.evaluate(async ([question, args]) => (await import("/js/lab.js")).ask(question, ...args), [question, args]);
  return { page, faults, ask, close: () => context.close() };
}

/** What the command line says, as JSON. */
export const cli = (...args) => JSON.parse(execFileSync(BOXWOOD, [...args, "--json"], { maxBuffer: 1 << 28, stdio: ["ignore", "pipe", "ignore"] }));

/** What rays hit natively: one hash for each structure. */
export const hashes = (...args) => execFileSync(HASHES, args.map(String), { encoding: "utf8" }).trim().split("\n");

/** The text of a number on the page. */
export const value = (page, figure, name) => page.textContent(`[data-figure=${figure}] [data-value="${name}"]`);
