// Figure 4: the boxes of a tree depth by depth, and what each builder's tree costs.

import { ask } from "../lab.js";
import { bill, button, choice, count, duration, el, short, slider, tell } from "../dom.js";
import { edges, projector } from "../project.js";
import { onScene, picker, scene, sceneBoard, SIZE } from "../scenes.js";
import * as state from "../state.js";

const BUILDERS = [
  ["median", "median: half of the triangles each"],
  ["midpoint", "midpoint: half of the space each"],
  ["morton", "Morton order: along a curve"],
  ["binned", "surface area, 16 bins"],
  ["sweep", "surface area, every split tried"],
  ["refined", "surface area, then improved"],
];
const USUAL = { builder: "median", depth: 3 };
/** Of more boxes than these only some are drawn: they would be a grey cloud. */
const MOST = 4096;

export default function build(body) {
  let builder = BUILDERS.some(([name]) => name === state.get("build.builder")) ? state.get("build.builder") : USUAL.builder;
  let depth = state.getWhole("build.depth", USUAL.depth, 0, 96);
  let nodes = [];
  let run = 0;

  const scenes = picker();
  const builders = choice("Builder", BUILDERS, builder, (value) => { builder = value; state.set("build.builder", value); load(); });
  const levels = slider("Depth", { min: 0, max: 20, value: depth }, (value) => { depth = value; state.set("build.depth", value); load(); });
  levels.classList.add("grow");
  const all = button("Build with all six", compare, { class: "main" });
  const again = button("Reset", () => {
    state.reset("build");
    [builder, depth] = [USUAL.builder, USUAL.depth];
    builders.control.value = builder;
    levels.set(depth);
    load();
  });
  const view = sceneBoard({ role: "img", "aria-label": "the boxes of the tree at this depth, over the scene" }, 0.35, paint);
  const line = tell();
  const ledger = bill(["nodes", "nodes"], ["leaves", "leaves"], ["deepest leaf", "depth"], ["surface area cost", "cost"], ["KiB", "kib"]);
  const rows = BUILDERS.map(([name]) => {
    const cells = [0, 1, 2, 3, 4].map(() => el("td", {}, "–"));
    return { name, cells, row: el("tr", {}, el("th", { scope: "row" }, name), ...cells) };
  });
  const heads = ["builder", "built in, once", "surface area cost", "box tests per ray", "triangle tests per ray", "operations per ray"].map((text) => el("th", { scope: "col" }, text));
  const table = el("table", {}, el("thead", {}, el("tr", {}, ...heads)), el("tbody", {}, ...rows.map(({ row }) => row)));
  body.append(el("div", { class: "bar" }, scenes.element, builders, levels), scenes.line, view, line, ledger,
    el("div", { class: "bar" }, all, again), el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "what each builder's tree costs" }, table));
  onScene(() => {
    for (const { cells } of rows) for (const cell of cells) cell.textContent = "–";
    load();
  });

  async function load() {
    if (!scene) return;
    const mine = ++run;
    try {
      const built = await ask("build", "bvh2", builder);
      levels.control.max = built.max_depth;
      depth = Math.min(depth, built.max_depth);
      levels.set(depth);
      const numbers = await ask("nodes", built.number, depth);
      if (mine !== run) return;
      nodes = [];
      for (let i = 0; i < numbers.length; i += 7) nodes.push({ box: [numbers.slice(i, i + 3), numbers.slice(i + 3, i + 6)], prims: numbers[i + 6] });
      ledger.set({ nodes: count(built.nodes), leaves: count(built.leaves), depth: String(built.max_depth), cost: built.sah_cost == null ? "–" : short(built.sah_cost), kib: count(built.bytes / 1024) });
      const leaves = nodes.filter((node) => node.prims).length;
      const drawn = nodes.length > MOST ? ` (every ${nth(stride())} is drawn)` : "";
      line.say(`Depth ${depth} of ${built.max_depth}: ${count(nodes.length)} ${nodes.length === 1 ? "box" : "boxes"}${drawn}, ${count(leaves)} of them leaves. A random ray that meets the root pays ${built.sah_cost == null ? "–" : short(built.sah_cost)}, by the surface area heuristic.`);
      view.paint();
    } catch (error) {
      line.say(error.message);
    }
  }

  const stride = () => Math.ceil(nodes.length / MOST);

  function paint(context, width, height) {
    const project = projector(scene.camera, width, height);
    // Blue and solid with something below, green and dashed for leaves.
    for (const [isLeaf, stroke, dashes] of [[false, "#7cc4f2", []], [true, "#52e0b0", [5, 3]]]) {
      context.beginPath();
      for (const { box } of nodes.filter((node, i) => i % stride() === 0 && Boolean(node.prims) === isLeaf)) {
        for (const [from, to] of edges(box)) {
          const ends = project(from, to);
          if (!ends) continue;
          context.moveTo(...ends[0]);
          context.lineTo(...ends[1]);
        }
      }
      context.strokeStyle = stroke;
      context.setLineDash(dashes);
      context.lineWidth = nodes.length > 200 ? 0.7 : nodes.length > 20 ? 1.2 : 2;
      context.globalAlpha = nodes.length > 1000 ? 0.35 : 0.9;
      context.stroke();
    }
    context.setLineDash([]);
    context.globalAlpha = 1;
  }

  /** Every builder on the open scene; tests over every eighth row of the picture. */
  async function compare() {
    const open = scene;
    all.disabled = true;
    try {
      for (const { name, cells } of rows) {
        line.say(`Building: ${name} …`);
        const built = await ask("build", "bvh2", name);
        const sums = [0, 0, 0];
        let rays = 0;
        for (let y = 4; y < SIZE[1]; y += 8) {
          const numbers = await ask("heat", SIZE, built.number, y, 1);
          numbers.forEach((n, k) => { sums[k % 3] += n; });
          rays += SIZE[0];
        }
        if (open !== scene) break;
        [duration(built.ms / 1000), built.sah_cost == null ? "–" : short(built.sah_cost), ...sums.map((sum) => short(sum / rays))].forEach((text, i) => { cells[i].textContent = text; });
      }
      line.say("Each tree gives the same answers; they differ in what a ray pays (counted over every eighth row). The cheapest split at each step need not end in the cheapest tree.");
      body.dataset.done = "all";
    } catch (error) {
      line.say(error.message);
    }
    all.disabled = false;
  }
}

const nth = (n) => (n === 2 ? "second" : n === 3 ? "third" : `${n}th`);
