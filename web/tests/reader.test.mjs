// What a reader meets: with a mouse, with keys alone, on a phone, without WebAssembly, with files of their own.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { after, test } from "node:test";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { close, nativeRace, open, serve } from "./browser.mjs";

after(close);

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const told = (page, figure) => page.textContent(`[data-figure=${figure}] .unseen[role=status]`);
const tells = (figure) => (page, words) => page.waitForFunction(([figure, words]) => document.querySelector(`[data-figure=${figure}] .unseen`)?.textContent.includes(words), [figure, words]);
const walkIsAt = tells("walk");
const buildIsAt = tells("split");
/** Seconds until the first picture, in a browser that has the machine to itself. */
const FIRST_PICTURE = 10;

/** Waits until every figure that works by itself has its numbers. */
async function settled(page) {
  await page.locator("#heat").scrollIntoViewIfNeeded();
  await page.waitForSelector("[data-figure=heat] [data-done]");
  await walkIsAt(page, "Answer");
}

test("it loads without an error and without a request to anywhere else", async () => {
  const { page, faults, close } = await open();
  await settled(page);
  assert.deepEqual(faults, []);
  const [first, all] = await page.evaluate(() => [performance.getEntriesByName("first picture")[0].startTime / 1000, performance.now() / 1000]);
  console.log(`  the first picture is there after ${first.toFixed(1)} s, all figures after ${all.toFixed(1)} s`);
  assert.ok(first < FIRST_PICTURE, `${first} s`);
  await close();
});

for (const size of ["320x180", "640x360"]) {
  test(`the race at ${size} ends, with the same answer for all`, async () => {
    const { page, faults, close } = await open(`#v=1&race.size=${size}`);
    await page.click("text=Start the race");
    await page.waitForSelector("[data-figure=race] [data-done]");
    const text = (cell) => page.textContent(`[data-value="${cell}"]`);
    const names = ["list", "grid", "bvh2", "wide"];
    const native = nativeRace("builtin:bush", size, ...names);
    for (const [i, name] of names.entries()) {
      const fps = Number((await text(`${name}.fps`)).replaceAll(",", ""));
      console.log(`  ${name}: ${await text(`${name}.ms`)} a frame, ${fps} a second, ${((fps * native[i]) / 1000).toFixed(2)} of native on one thread`);
      if (name !== "list") assert.equal(await text(`${name}.same`), "yes, every bit");
    }
    assert.deepEqual(faults, []);
    await close();
  });
}

test("the address holds the state and gives it back", async () => {
  const { page, close } = await open("#v=1&scene=cornell&walk.px=100,50&walk.step=3&walk.way=bvh2+median&price.n=1&price.size=640x360");
  await walkIsAt(page, "Step 3");
  assert.match(await page.textContent("[data-figure=price] .n"), /640 × 360 pixels × 114 triangles/);
  await page.getByRole("slider", { name: "step of the walk" }).press("ArrowRight");
  await walkIsAt(page, "Step 4");
  await page.waitForFunction(() => location.hash.includes("walk.step=4"));
  const said = await told(page, "walk");
  await page.reload();
  await walkIsAt(page, "Step 4");
  assert.equal(await told(page, "walk"), said);
  await close();
});

test("keys alone go through the walk, and every step is told", async () => {
  const { page, close } = await open("#v=1&scene=cornell");
  await walkIsAt(page, "Answer");
  const range = page.getByRole("slider", { name: "step of the walk" });
  await range.focus();
  await page.keyboard.press("Home");
  await walkIsAt(page, "The ray starts");
  const most = Number(await range.getAttribute("max"));
  const seen = new Set();
  for (let step = 1; step <= most; step++) {
    await page.keyboard.press("ArrowRight");
    await walkIsAt(page, `Step ${step}:`);
    seen.add(await told(page, "walk"));
  }
  assert.equal(seen.size, most);
  await page.locator("[data-figure=walk] canvas[tabindex]").focus();
  await page.keyboard.press("Shift+ArrowRight");
  await page.waitForFunction(() => location.hash.includes("walk.px=170,90"));
  await close();
});

test("keys alone go through a build, and every step is told", async () => {
  const { page, close } = await open("#v=1&scene=cornell&split.builder=sweep");
  await buildIsAt(page, "Step 1:");
  const range = page.getByRole("slider", { name: "step of the build" });
  await range.focus();
  await page.keyboard.press("Home");
  await buildIsAt(page, "Nothing is built yet");
  const most = Number(await range.getAttribute("max"));
  assert.ok(most > 10);
  for (let step = 1; step <= most; step++) {
    await page.keyboard.press("ArrowRight");
    await buildIsAt(page, `Step ${step}:`);
    assert.match(await told(page, "split"), /split at|leaf/);
  }
  assert.match(await page.evaluate(() => location.hash), /split\.step=/);
  await close();
});

test("boxwood view --web opens the page with the model that it was given", async () => {
  const folder = mkdtempSync(join(tmpdir(), "boxwood-"));
  const file = join(folder, "a roof.obj");
  writeFileSync(file, "v 0 0 0\nv 4 0 0\nv 4 3 1\nv 0 3 1\nf 1 2 3\nf 1 3 4\n");
  const server = await serve(file);
  const { page, faults, close } = await open(server.url);
  await page.waitForFunction(() => document.querySelector("[data-figure=walk] p[role=status]").textContent.includes("a roof.obj: 2 triangles"));
  assert.deepEqual(faults, []);
  await close();
  server.close();
  rmSync(folder, { recursive: true });
});

test("files are taken from the reader: a good one, a broken one, an empty one", async () => {
  const { page, faults, close } = await open();
  const drop = (name, text) => page.evaluate(([name, text]) => {
    const data = new DataTransfer();
    data.items.add(new File([text], name));
    dispatchEvent(new DragEvent("drop", { dataTransfer: data, cancelable: true }));
  }, [name, text]);
  const says = (words) => page.waitForFunction((words) => document.querySelector("[data-figure=walk] p[role=status]").textContent.includes(words), words);
  await drop("roof.obj", "v 0 0 0\nv 4 0 0\nv 4 3 1\nv 0 3 1\nf 1 2 3\nf 1 3 4\n");
  await says("roof.obj: 2 triangles");
  await drop("broken.obj", "v 0 0 0\nf 1 2 3\n");
  await says("broken.obj:2:");
  await says("roof.obj stays");
  await drop("empty.obj", "");
  await says("no triangles");
  assert.deepEqual(faults, []);
  await close();
});

test("a file of triangles that all lie in one place does not hold the page", async () => {
  const { page, close } = await open();
  await page.evaluate((text) => {
    const data = new DataTransfer();
    data.items.add(new File([text], "heap.obj"));
    dispatchEvent(new DragEvent("drop", { dataTransfer: data, cancelable: true }));
  }, `v 0 0 0\nv 1 0 0\nv 0 1 0\n${"f 1 2 3\n".repeat(20000)}`);
  await page.waitForFunction(() => document.querySelector("[data-figure=walk] p[role=status]").textContent.includes("heap.obj: 20,000 triangles"));
  await close();
});

test("the ray on the shared edge hits one triangle, by the rule of ties", async () => {
  const { page, close } = await open();
  await page.click("text=Put the ray on the shared edge");
  await tells("triangle")(page, "exactly zero");
  // A handle that was dragged has the focus, and a frame in the drawing's own large units would cover it.
  const handle = page.getByRole("slider", { name: "the ray", exact: true });
  await handle.hover();
  await page.mouse.down();
  await page.mouse.move(500, 400);
  await page.mouse.up();
  assert.ok(await handle.evaluate((one) => one === document.activeElement && getComputedStyle(one).outlineStyle === "none"));
  await close();
});

for (const [width, height, zoom] of [[390, 844, 1], [1280, 720, 1], [640, 360, 2], [320, 640, 1]]) {
  test(`nothing sticks out sideways at ${width} x ${height}`, async () => {
    const { page, close } = await open("", { viewport: { width, height }, deviceScaleFactor: zoom });
    await settled(page);
    const [inside, all] = await page.evaluate(() => [document.documentElement.clientWidth, document.documentElement.scrollWidth]);
    assert.equal(all, inside);
    await close();
  });
}

test("a reader without WebAssembly gets text, numbers and commands", async () => {
  const { page, close } = await open("", {}, (page) => page.route("**/*.wasm", (route) => route.abort()));
  assert.equal(await page.evaluate(() => document.documentElement.dataset.ready), "still");
  assert.match(await page.textContent("#engine"), /stand still/);
  assert.match(await page.textContent("[data-figure=price]"), /995,328,000,000/);
  const picture = page.getByAltText("A bush in a pot");
  await picture.scrollIntoViewIfNeeded();
  assert.ok(await picture.evaluate((image) => image.decode().then(() => image.naturalWidth > 0)));
  await close();
});

test("who wants less motion gets none", async () => {
  const { page, close } = await open("", { reducedMotion: "reduce" });
  assert.equal(await page.evaluate(() => getComputedStyle(document.documentElement).scrollBehavior), "auto");
  assert.equal(await page.evaluate(() => document.getAnimations().length), 0);
  await close();
});

test("on a projector there is one section at a time", async () => {
  const { page, close } = await open("?present");
  assert.deepEqual(await page.$$eval("main > section", (all) => all.filter((one) => one.offsetHeight).map((one) => one.id)), ["price"]);
  await page.keyboard.press("PageDown");
  assert.ok(await page.isVisible("#triangle") && !(await page.isVisible("#price")));
  await close();
});

for (const scheme of ["light", "dark"]) {
  test(`axe finds nothing in ${scheme}`, async () => {
    // The checker itself is a script that the page's policy would refuse.
    const { page, close } = await open("", { colorScheme: scheme, bypassCSP: true });
    await settled(page);
    await page.evaluate(AXE);
    const { violations } = await page.evaluate(() => globalThis.axe.run());
    assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html).join(" | ")}`), []);
    await close();
  });
}

test("memory is steady after 200 scenes", async () => {
  const { ask, close } = await open("#v=1&scene=cornell");
  const some = async (count) => {
    for (let i = 0; i < count; i++) {
      await ask("open", i % 2 ? "builtin:cornell" : "builtin:sphere?n=2000");
      await ask("picture", [320, 180]);
    }
    return ask("heap");
  };
  // As large as the page ever asks for.
  await ask("picture", [1280, 720]);
  const before = await some(20);
  const later = await some(180);
  console.log(`  ${before >> 10} KiB after 20 scenes, ${later >> 10} KiB after 200`);
  assert.equal(later, before);
  await close();
});
