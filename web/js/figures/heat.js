// Figure 7: what each pixel's ray cost, two structures side by side.

import { ask } from "../lab.js";
import { bill, board, button, choice, color, count, el, short, slider, tell, tick } from "../dom.js";
import { onScene, picker, scene, SIZE } from "../scenes.js";
import { visit } from "./walk.js";
import { arrows, placeOf } from "../point.js";
import * as state from "../state.js";

const WAYS = [
  ["grid binned", "uniform grid"],
  ["bvh2 binned", "binary tree, surface area"],
  ["bvh2 median", "binary tree, median"],
  ["bvh2 morton", "binary tree, Morton order"],
  ["wide binned", "eight wide"],
];
const KINDS = [["prims", "triangle tests"], ["boxes", "box tests (cells)"]];
const USUAL = { left: "grid binned", right: "bvh2 binned", kind: "prims", log: "1", split: 50 };
/** Rows that are counted at once: others get their turn between. */
const BAND = 6;

export default function heat(body) {
  const named = (name) => WAYS.some(([way]) => way === name);
  const fromAddress = (name) => (named(state.get(`heat.${name}`)) ? state.get(`heat.${name}`) : USUAL[name]);
  let ways = [fromAddress("left"), fromAddress("right")];
  let kind = state.get("heat.kind", USUAL.kind) === "boxes" ? "boxes" : "prims";
  let log = state.get("heat.log", USUAL.log) === "1";
  let split = state.getWhole("heat.split", USUAL.split, 0, 100);
  let maps = [null, null];
  let scale = null;
  let images = [null, null];
  let run = 0;
  let near = false;

  const scenes = picker();
  const sides = ["left", "right"].map((name, i) => choice(name === "left" ? "Left" : "Right", WAYS, ways[i], (value) => { ways[i] = value; state.set(`heat.${name}`, value); load(); }));
  const kinds = choice("Colour by", KINDS, kind, (value) => { kind = value; state.set("heat.kind", kind); recolor(); });
  const logs = tick("logarithmic", log, (value) => { log = value; state.set("heat.log", log ? 1 : 0); recolor(); });
  const cut = slider("Border between the two", { min: 0, max: 100, value: split, say: (at) => `${at} %` }, (at) => { split = at; state.set("heat.split", at); view.paint(); });
  cut.classList.add("grow");
  const worst = button("Walk the worst pixel of the tree", goToWorst);
  const again = button("Reset", () => {
    state.reset("heat");
    [ways, kind, log, split] = [[USUAL.left, USUAL.right], USUAL.kind, true, USUAL.split];
    sides.forEach((side, i) => { side.control.value = ways[i]; });
    kinds.control.value = kind;
    logs.control.checked = log;
    cut.set(split);
    load();
  });
  const view = board({ tabindex: 0, role: "application", "aria-roledescription": "heat map", "aria-label": "tests of each pixel; arrow keys move the pixel that is read" }, (width) => (width * SIZE[1]) / SIZE[0], paint);
  let pixel = [160, 90];
  view.addEventListener("pointermove", (event) => read(placeOf(event, view, [0, 0, ...SIZE])));
  view.addEventListener("keydown", arrows(1, 10, (right, up) => read([pixel[0] + right, pixel[1] - up])));
  const legend = board({ role: "img", "aria-label": "the scale of colours" }, () => 38, paintLegend);
  const line = tell();
  const ledger = bill(["left: boxes (cells) per ray", "boxes0"], ["left: triangle tests per ray", "prims0"], ["right: boxes (cells) per ray", "boxes1"], ["right: triangle tests per ray", "prims1"], ["brute force: triangle tests per ray", "all"]);
  body.append(el("div", { class: "bar" }, scenes.element, ...sides, kinds, logs), scenes.line, view, legend, line,
    el("div", { class: "bar" }, cut, worst, again), ledger);
  onScene(() => { maps = [null, null]; load(); });
  // Counting is work: it waits until the figure is nearly in view.
  new IntersectionObserver(([entry]) => {
    if (near || !entry.isIntersecting) return;
    near = true;
    if (scene) load();
  }, { rootMargin: "600px" }).observe(body);

  async function load() {
    sayCommand();
    if (!near) return;
    const mine = ++run;
    maps = [null, null];
    images = [null, null];
    try {
      for (const i of [0, 1]) {
        maps[i] = i && ways[1] === ways[0] ? maps[0] : await counted(i, mine);
        if (mine !== run) return;
        await recolor(mine);
      }
      line.say(summary());
      body.dataset.done = ways.join();
    } catch (error) {
      line.say(error.message);
    }
  }

  /** All pixels of one structure, band by band. */
  async function counted(i, mine) {
    const { number } = await ask("build", ...ways[i].split(" "));
    const map = { boxes: new Uint32Array(SIZE[0] * SIZE[1]), prims: new Uint32Array(SIZE[0] * SIZE[1]) };
    for (let y = 0; y < SIZE[1]; y += BAND) {
      const numbers = await ask("heat", SIZE, number, y, BAND);
      if (mine !== run) return null;
      for (let k = 0; k < numbers.length / 3; k++) {
        map.boxes[y * SIZE[0] + k] = numbers[3 * k];
        map.prims[y * SIZE[0] + k] = numbers[3 * k + 1];
      }
      line.say(`Counting ${i ? "right" : "left"}: row ${Math.min(y + BAND, SIZE[1])} of ${SIZE[1]}.`);
    }
    const mean = (numbers) => numbers.reduce((sum, n) => sum + n, 0) / numbers.length;
    ledger.set({ [`boxes${i}`]: short(mean(map.boxes)), [`prims${i}`]: short(mean(map.prims)), all: count(scene.triangles) });
    return map;
  }

  /** One scale for both. */
  async function recolor(mine = run) {
    const known = maps.filter(Boolean);
    if (!known.length) return;
    const both = new Uint32Array(known.flatMap((map) => [...map[kind]]));
    const found = await ask("heatScale", both);
    const codes = await Promise.all(known.map((map) => ask("heatCodes", map[kind], found.high, log)));
    const bitmaps = await Promise.all(codes.map((code) => createImageBitmap(new ImageData(new Uint8ClampedArray(code.buffer), ...SIZE))));
    if (mine !== run) return;
    scale = { ...found, codes: await ask("heatCodes", new Uint32Array(LEGEND).map((_, i) => Math.round(numberAt(i / (LEGEND - 1), found.high))), found.high, log) };
    images = [bitmaps[0], bitmaps[1] ?? null];
    view.paint();
    legend.paint();
    sayCommand();
  }

  /** The count at a share of the scale: the inverse of the scale's own rule. */
  const numberAt = (share, high) => (log ? Math.expm1(share * Math.log1p(high)) : share * high);
  const shareOf = (number, high) => (log ? Math.log1p(number) / Math.log1p(high) : number / high);

  function paint(context, width, height) {
    context.imageSmoothingEnabled = false;
    const border = images[1] ? (split / 100) * SIZE[0] : SIZE[0];
    const k = width / SIZE[0];
    if (!images[0]) {
      if (scene) context.drawImage(scene.picture, 0, 0, width, height);
      return;
    }
    if (border > 0) context.drawImage(images[0], 0, 0, border, SIZE[1], 0, 0, border * k, height);
    if (border < SIZE[0]) context.drawImage(images[1], border, 0, SIZE[0] - border, SIZE[1], border * k, 0, width - border * k, height);
    context.fillStyle = "#fff";
    if (images[1]) context.fillRect(border * k - 1, 0, 2, height);
    context.font = "600 13px system-ui, sans-serif";
    context.textBaseline = "top";
    const name = (i) => WAYS.find(([way]) => way === ways[i])[1].replace(width < 500 ? /,.*/ : "", "");
    const put = (text, x, align) => {
      context.textAlign = align;
      const wide = context.measureText(text).width + 12;
      context.fillStyle = "rgb(0 0 0 / 0.6)";
      context.fillRect(align === "left" ? x : x - wide, 8, wide, 22);
      context.fillStyle = "#fff";
      context.fillText(text, align === "left" ? x + 6 : x - 6, 12);
    };
    put(name(0), 8, "left");
    if (images[1]) put(name(1), width - 8, "right");
  }

  const LEGEND = 256;
  function paintLegend(context, width, height) {
    if (!scale) return;
    const strip = new ImageData(LEGEND, 1);
    strip.data.set(scale.codes);
    const bar = new OffscreenCanvas(LEGEND, 1);
    bar.getContext("2d").putImageData(strip, 0, 0);
    context.drawImage(bar, 0, 4, width, Math.min(14, height - 22));
    context.fillStyle = color("soft");
    context.font = "12px system-ui, sans-serif";
    context.textBaseline = "top";
    const marks = log ? [0, 1, 3, 10, 30, 100, 300, 1000, 3000, 10000, 30000, 100000] : [0, 0.25, 0.5, 0.75, 1].map((share) => Math.round(share * scale.high));
    let last = -Infinity;
    for (const mark of marks.filter((mark) => mark <= scale.high)) {
      const x = shareOf(mark, scale.high) * width;
      if (x - last < 36) continue;
      last = x;
      context.textAlign = x < 10 ? "left" : x > width - 20 ? "right" : "center";
      context.fillText(count(mark), x, Math.min(20, height - 16));
    }
  }

  function read([x, y]) {
    pixel = [Math.min(Math.max(Math.floor(x), 0), SIZE[0] - 1), Math.min(Math.max(Math.floor(y), 0), SIZE[1] - 1)];
    const i = pixel[1] * SIZE[0] + pixel[0];
    const words = maps.map((map, side) => map && `${side ? "right" : "left"} ${count(map.boxes[i])} box and ${count(map.prims[i])} triangle tests`);
    line.say(`Pixel ${pixel[0]}, ${pixel[1]}: ${words.filter(Boolean).join("; ")}.`);
  }

  function summary() {
    const mean = (map) => map[kind].reduce((sum, n) => sum + n, 0) / map[kind].length;
    const most = (map) => map[kind].reduce((a, b) => Math.max(a, b), 0);
    const what = KINDS.find(([name]) => name === kind)[1];
    return `On average ${short(mean(maps[0]))} ${what} per ray on the left, ${short(mean(maps[1]))} on the right; at most ${count(most(maps[0]))} and ${count(most(maps[1]))}. Brute force: ${count(scene.triangles)}.`;
  }

  function goToWorst() {
    // Of a grid there is no walk down a tree.
    const side = [1, 0].find((i) => maps[i] && !ways[i].startsWith("grid"));
    if (side === undefined) return;
    const map = maps[side];
    let at = 0;
    map[kind].forEach((n, i) => { if (n > map[kind][at]) at = i; });
    visit([at % SIZE[0], Math.floor(at / SIZE[0])], ways[side]);
  }

  function sayCommand() {
    if (!scene) return;
    const [structure, builder] = ways[0].split(" ");
    document.querySelector("[data-cli=heat]").textContent = `boxwood render ${scene.named} --shading heat-${kind} --structure ${structure}${structure === "grid" ? "" : ` --builder ${builder}`} --size ${SIZE.join("x")}${log ? " --log" : ""} -o heat.png`;
  }
}
