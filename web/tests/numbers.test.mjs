// Every number on the page is the command line's.

import assert from "node:assert/strict";
import { after, test } from "node:test";
import { cli, close, hashes, open, value } from "./browser.mjs";

after(close);

const SIZE = [320, 180];

test("a million rays hit the same natively, with vector instructions and without", async () => {
  const rays = 1_000_000;
  const structures = ["wide", "bvh2", "grid"];
  const native = hashes("builtin:bush", rays, 7, ...structures);
  assert.ok(native.every((hash) => hash === native[0]));
  for (const form of ["simd", "plain"]) {
    const { page, ask, close } = await open(`?wasm=${form}`);
    assert.equal(await page.evaluate(() => document.documentElement.dataset.ready), form);
    for (const structure of form === "simd" ? structures : ["wide"]) {
      const { number } = await ask("build", structure);
      assert.equal(await ask("hash", number, rays, 7), native[0], `${form} ${structure}`);
    }
    await close();
  }
});

test("the price is that of boxwood cost", async () => {
  const { page, close } = await open();
  const { brute_force_flops } = cli("cost");
  await page.waitForFunction(() => document.querySelector("[data-value=flops]").textContent.includes(","));
  assert.equal((await value(page, "price", "flops")).replaceAll(",", ""), String(brute_force_flops));
  assert.equal(brute_force_flops, 995_328_000_000);
  await close();
});

test("the work of a frame is that of boxwood cost, for each structure", async () => {
  const { ask, close } = await open();
  const { scene } = cli("cost", "builtin:bush", "--size", SIZE.join("x"));
  for (const [structure, name] of [["bvh2", "bvh2 binned aabb"], ["wide", "wide binned"], ["grid", "grid"]]) {
    const { number } = await ask("build", structure);
    const numbers = Object.values(await ask("heat", SIZE, number, 0, SIZE[1]));
    const sum = (k) => numbers.reduce((total, n, i) => (i % 3 === k ? total + n : total), 0);
    const row = scene.structures.find((row) => row.name === name);
    assert.ok(row, `${name} among ${scene.structures.map((row) => row.name)}`);
    if (structure !== "grid") assert.equal(sum(0), row.box_tests, name);
    assert.equal(sum(1), row.primitive_tests, name);
    assert.equal(sum(2), row.flops, name);
  }
  await close();
});

test("every step of a walk is that of boxwood explain", async () => {
  const { ask, close } = await open();
  for (const [structure, builder] of [["bvh2", "binned"], ["bvh2", "median"], ["wide", "binned"], ["grid", "binned"]]) {
    const { number } = await ask("build", structure, builder);
    for (const [x, y] of [[160, 90], [101, 63], [5, 4]]) {
      const here = await ask("walk", SIZE, number, x, y);
      const there = cli("explain", "builtin:bush", "--size", SIZE.join("x"), "--pixel", `${x},${y}`, "--structure", structure, "--builder", builder);
      assert.deepEqual([here.counts, here.hit, here.ray], [there.counts, there.hit, there.ray]);
      // How far eight boxes are padded depends on the instruction set; what becomes of them does not.
      const plain = ({ near, far, ...step }) => (structure === "wide" ? step : { near, far, ...step });
      assert.deepEqual(here.steps.map(plain), there.steps.map(plain), `${structure} ${builder} ${x},${y}`);
    }
  }
  await close();
});

test("every step of a build is that of boxwood build --trace", async () => {
  const { page, ask, close } = await open();
  for (const builder of ["median", "midpoint", "binned", "sweep", "morton"]) {
    const { number } = await ask("build", "bvh2", builder);
    const here = await ask("steps", number, 200);
    const there = cli("build", "builtin:bush", "--structure", "bvh2", "--builder", builder, "--steps", "200");
    for (const key of Object.keys(here)) assert.deepEqual(here[key], there[key], `${builder} ${key}`);
    assert.equal(here.steps.length, 200);
  }
  // And what the figure says of a step is what the step says.
  const there = cli("build", "builtin:bush", "--structure", "bvh2", "--builder", "binned", "--steps", "200");
  await page.waitForFunction(() => document.querySelector("[data-figure=split] .unseen").textContent.includes("Step 1:"));
  assert.equal(await value(page, "split", "set"), there.steps[0].count.toLocaleString("en-US"));
  assert.equal(await value(page, "split", "weighed"), String(there.steps[0].weighed));
  assert.equal(await value(page, "split", "all"), there.steps_total.toLocaleString("en-US"));
  await close();
});

test("the tree is that of boxwood inspect", async () => {
  const { ask, close } = await open();
  const there = JSON.stringify(cli("inspect", "builtin:bush", "--structure", "bvh2"));
  const here = await ask("build", "bvh2");
  assert.ok(there.includes(`"nodes":${here.nodes}`) && there.includes(String(here.leaves)), `${here.nodes} nodes`);
  await close();
});

test("the numbers in the running text are the command line's", async () => {
  const { page, close } = await open("", {}, (page) => page.route("**/*.wasm", (route) => route.abort()));
  const text = (figure) => page.textContent(`[data-figure=${figure}] .still`);
  const tests = (scene, name) => {
    const { structures } = cli("cost", scene, "--size", SIZE.join("x")).scene;
    const { rays, box_tests, primitive_tests } = structures.find((row) => row.name === name);
    return [box_tests / rays, primitive_tests / rays];
  };
  const near = (said, is) => assert.ok(Math.abs(said / is - 1) < 0.1, `${said} is said, ${is} is so`);
  const numbers = (words) => [...words.matchAll(/\d[\d,]*/g)].map(([digits]) => Number(digits.replaceAll(",", "")));
  const [, boxes, triangles] = numbers(await text("walk"));
  const bush = tests("builtin:bush", "bvh2 binned aabb");
  near(boxes, bush[0]);
  near(triangles, bush[1]);
  const [grid, tree] = numbers(await text("heat"));
  near(grid, tests("builtin:stadium", "grid")[1]);
  near(tree, tests("builtin:stadium", "bvh2 binned aabb")[1]);
  const [root] = cli("build", "builtin:bush", "--structure", "bvh2", "--builder", "binned", "--steps", "1").steps;
  assert.equal(numbers(await text("split"))[0], root.weighed);
  await close();
});

test("the exercises know their answers", async () => {
  const { page, close } = await open();
  const items = page.locator("#exercises li");
  const { counts } = cli("explain", "builtin:bush", "--size", SIZE.join("x"), "--pixel", "160,90", "--structure", "bvh2", "--builder", "binned");
  const answers = ["2,836,684,800", "0.5", "15", String(counts.primitive_tests)];
  for (const [i, answer] of answers.entries()) {
    const item = items.nth(i);
    await item.getByRole("button", { name: "Show" }).click();
    await page.waitForFunction(([i, answer]) => document.querySelectorAll("#exercises li [role=status]")[i].textContent.startsWith(`${answer}.`), [i, answer]);
    await item.getByRole("textbox").fill(answer);
    await item.getByRole("button", { name: "Check" }).click();
    await page.waitForFunction((i) => document.querySelectorAll("#exercises li [role=status]")[i].textContent.startsWith("✓"), i);
  }
  await close();
});

test("each builder's tree is shown depth by depth, and all six are compared", async () => {
  const { page, ask, close } = await open();
  await page.click("text=Build with all six");
  await page.waitForSelector("[data-figure=build] [data-done]");
  const { number, leaves, max_depth } = await ask("build", "bvh2", "binned");
  const deepest = Object.values(await ask("nodes", number, max_depth));
  assert.equal(deepest.length, 7 * leaves);
  const cells = await page.$$eval("[data-figure=build] tbody tr", (rows) => rows.map((row) => [...row.children].map((cell) => cell.textContent)));
  assert.equal(cells.length, 6);
  console.log(cells.map((row) => `  ${row.join("  ")}`).join("\n"));
  await close();
});
