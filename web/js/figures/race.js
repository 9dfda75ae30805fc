// Figure 8: the same frame by brute force, grid, binary tree and wide tree, on this machine.

import { ask } from "../lab.js";
import { button, choice, color, count, board, duration, el, short, tell } from "../dom.js";
import { onScene, picker, scene } from "../scenes.js";
import * as state from "../state.js";

const RUNNERS = [
  ["list", "brute force"],
  ["grid", "uniform grid"],
  ["bvh2", "binary tree"],
  ["wide", "eight wide"],
];
const SIZES = ["320x180", "640x360", "1280x720"];
const USUAL = "320x180";
/** Each is timed for so long, in ms, and at least one frame or row. */
const TIME = 1200;
/** Frames are drawn in bands of so many rows, so that the page can ask for other things between. */
const BAND = 30;

export default function race(body) {
  let size = SIZES.includes(state.get("race.size")) ? state.get("race.size") : USUAL;
  let results = [];
  let run = 0;

  const scenes = picker();
  const sizes = choice("Picture", SIZES.map((name) => [name, name.replace("x", " × ")]), size, (value) => { size = value; state.set("race.size", size); clear(); });
  const start = button("Start the race", begin, { class: "main" });
  const copy = button("Copy as JSON", () => navigator.clipboard?.writeText(JSON.stringify(record(), null, 1)).then(() => line.say("Copied."), () => line.say("This browser does not let the page copy.")), { disabled: true });
  const again = button("Reset", () => { state.reset("race"); size = USUAL; sizes.control.value = size; clear(); }, { class: "end" });
  const view = board({ role: "img", "aria-label": "time per frame of each structure" }, (width) => Math.max(190, width / 3.4), paint);
  const line = tell();
  const rows = RUNNERS.map(([name, words]) => {
    const cells = Object.fromEntries(["ms", "fps", "boxes", "prims", "build", "same"].map((column) => [column, el("td", { "data-value": `${name}.${column}` }, "–")]));
    return { cells, row: el("tr", {}, el("th", { scope: "row" }, words), ...Object.values(cells)) };
  });
  const heads = ["structure", "time per frame", "frames a second", "box tests per ray", "triangle tests per ray", "build", "same answer"].map((text) => el("th", { scope: "col" }, text));
  const table = el("table", {}, el("thead", {}, el("tr", {}, ...heads)), el("tbody", {}, ...rows.map(({ row }) => row)));
  body.append(el("div", { class: "bar" }, scenes.element, sizes, start, copy, again), scenes.line, view, line,
    el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "the results of the race" }, table));
  onScene(clear);

  function clear() {
    run++;
    results = [];
    start.disabled = false;
    copy.disabled = true;
    for (const { cells } of rows) for (const cell of Object.values(cells)) cell.textContent = "–";
    if (scene) document.querySelector("[data-cli=race]").textContent = `boxwood race ${scene.named} --size ${size}`;
    line.say("Four structures, one after the other, about a second each.");
    view.paint();
  }

  async function begin() {
    if (!scene) return;
    clear();
    const mine = run;
    start.disabled = true;
    try {
      // The fastest first: then every other is compared with it.
      for (const i of [3, 2, 1, 0]) {
        line.say(`Running: ${RUNNERS[i][1]} …`);
        const result = await timed(RUNNERS[i][0], () => mine !== run);
        if (mine !== run) return;
        results[i] = result;
        tellRow(i);
        view.paint();
      }
      copy.disabled = false;
      const [list, , , wide] = results;
      const part = { "320x180": ", of a sixteenth of the pixels of 1280 × 720", "640x360": ", of a quarter of the pixels of 1280 × 720" }[size] ?? "";
      line.say(`Eight wide is ${short(list.ms / wide.ms)} times as fast as brute force here, with the same answer: ${short(1000 / wide.ms)} frames a second in one thread${part}. Tests are counted over every eighth row.`);
      body.dataset.done = size;
    } catch (error) {
      line.say(error.message);
    }
    start.disabled = false;
  }

  /** Whole frames until the time is up; of brute force scattered rows, scaled up. */
  async function timed(name, isOver) {
    const shape = size.split("x").map(Number);
    const [width, height] = shape;
    const built = await ask("build", name);
    const samples = name === "list";
    const band = samples ? 1 : BAND;
    const bands = Math.ceil(height / band);
    const hashes = new Map();
    let [ms, rays, i] = [0, 0, 0];
    while (!isOver() && (ms < TIME || (!samples && i < bands))) {
      const y = (samples ? (i * 67) % height : (i % bands) * band);
      const shot = await ask("shoot", shape, built.number, y, band);
      hashes.set(y, shot.hash);
      [ms, rays, i] = [ms + shot.ms, rays + shot.rays, i + 1];
      if (samples && i === height) break;
    }
    return {
      structure: name, builder: built.builder, build_ms: built.ms, estimated: samples, rays,
      ms: (ms / rays) * width * height,
      ...(samples ? { boxes: 0, prims: scene.triangles } : await counts(shape, built.number)),
      same: samples ? await agrees(shape, hashes) : null,
    };
  }

  /** Tests per ray, over every eighth row. */
  async function counts(shape, number) {
    let [boxes, prims, rays] = [0, 0, 0];
    for (let y = 0; y < shape[1]; y += 8) {
      const numbers = await ask("heat", shape, number, y, 1);
      for (let k = 0; k < numbers.length; k += 3) [boxes, prims, rays] = [boxes + numbers[k], prims + numbers[k + 1], rays + 1];
    }
    return { boxes: boxes / rays, prims: prims / rays };
  }

  /** Whether all others hit the same on the rows of brute force, bit for bit. */
  async function agrees(shape, hashes) {
    for (const [name] of RUNNERS.slice(1)) {
      const { number } = await ask("build", name);
      for (const [y, hash] of hashes) if ((await ask("shoot", shape, number, y, 1)).hash !== hash) return name;
    }
    return true;
  }

  function tellRow(i) {
    const result = results[i];
    const { cells } = rows[i];
    cells.ms.textContent = duration(result.ms / 1000) + (result.estimated ? " est." : "");
    cells.fps.textContent = short(1000 / result.ms);
    cells.boxes.textContent = short(result.boxes);
    cells.prims.textContent = short(result.prims);
    cells.build.textContent = result.structure === "list" ? "–" : duration(result.build_ms / 1000);
    if (!result.estimated) return;
    const same = result.same;
    rows.forEach(({ cells }, k) => { cells.same.textContent = k === 0 ? `${count(result.rays)} rays` : same === true ? "yes, every bit" : RUNNERS[k][0] === same ? "NO" : "yes"; });
  }

  const record = () => ({ scene: scene.title, triangles: scene.triangles, size, instructions: scene.instructions, results });

  /** Bars on a logarithmic scale from a tenth of a millisecond. */
  function paint(context, width, height) {
    const [left, right, top, bottom] = [Math.min(110, width * 0.28), width - 8, 4, height - 20];
    const [low, high] = [0.1, Math.max(1e5, ...results.filter(Boolean).map((result) => result.ms * 1.5))];
    const x = (ms) => left + (Math.log(Math.max(ms, low) / low) / Math.log(high / low)) * (right - left);
    context.font = "13px system-ui, sans-serif";
    context.textBaseline = "middle";
    for (let ms = 1; ms <= high; ms *= 10) {
      context.fillStyle = color("line");
      context.fillRect(x(ms), top, 1, bottom - top);
      context.fillStyle = color("soft");
      context.textAlign = "center";
      if (width > 500 || Math.log10(ms) % 2 === 0) context.fillText(duration(ms / 1000), Math.min(x(ms), width - 24), height - 9);
    }
    const step = (bottom - top) / RUNNERS.length;
    RUNNERS.forEach(([, words], i) => {
      const y = top + step * (i + 0.5);
      context.fillStyle = color("ink");
      context.textAlign = "right";
      context.fillText(words, left - 8, y);
      if (!results[i]) return;
      context.fillStyle = color(i === 0 ? "miss" : i === 3 ? "hit" : "enter");
      context.fillRect(left, y - step * 0.3, x(results[i].ms) - left, step * 0.6);
    });
    context.setLineDash([6, 4]);
    context.strokeStyle = color("cull");
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(x(1000 / 30), top);
    context.lineTo(x(1000 / 30), bottom);
    context.stroke();
    context.setLineDash([]);
  }
}
