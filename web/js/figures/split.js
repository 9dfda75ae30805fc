// Figure 4, first half: a tree is built before the reader's eyes, split by split.

import { ask } from "../lab.js";
import { bill, board, button, choice, color, count, el, short, svg, tell } from "../dom.js";
import { edges, projector } from "../project.js";
import { onScene, picker, scene, sceneBoard } from "../scenes.js";
import { program, stepper } from "../stepper.js";
import * as state from "../state.js";

const BUILDERS = [
  ["median", "median: half of the triangles each"],
  ["midpoint", "midpoint: half of the space each"],
  ["binned", "surface area, 16 bins"],
  ["sweep", "surface area, every split tried"],
];
const USUAL = "binned";
/** Steps that are told: those of the sets nearest to the root. */
const MOST = 200;
const AXES = ["x", "y", "z"];
const PROGRAMS = {
  weighs: ["build(set):", "  few triangles? a leaf", "  for each plane: its cost", "  as a leaf cheaper? a leaf", "  split at the cheapest plane", "  build(left), build(right)"],
  rules: ["build(set):", "  few triangles? a leaf", "  take the longest axis", "  cannot be parted? a leaf", "  split there by the rule", "  build(left), build(right)"],
};
const WHY = {
  few: "so few make a leaf",
  cheaper: "no split is cheaper than testing them all: a leaf",
  alike: "their centres cannot be told apart",
  deep: "so deep in the tree a set is only halved",
};

export default function split(body) {
  let builder = BUILDERS.some(([name]) => name === state.get("split.builder")) ? state.get("split.builder") : USUAL;
  let wanted = state.getWhole("split.step", 1, 0, MOST);
  let trace = null;
  let at = 0;
  let run = 0;

  const scenes = picker();
  const builders = choice("Builder", BUILDERS, builder, (value) => { builder = value; state.set("split.builder", value); wanted = at; load(); });
  const again = button("Reset", () => {
    state.reset("split");
    [builder, wanted] = [USUAL, 1];
    builders.control.value = builder;
    load();
  }, { class: "end" });
  const view = sceneBoard({ role: "img", "aria-label": "the set that is split, over the scene" }, 0.35, paintView);
  const chart = board({ role: "img", "aria-label": "the cost of each plane that was weighed" }, (width) => Math.max(180, width / 3.6), paintChart);
  const codes = el("div");
  let code = program("");
  const steps = stepper("step of the build", show);
  const line = tell();
  const ledger = bill(["triangles in the set", "set"], ["planes weighed", "weighed"], ["cost of the split", "cost"], ["cost as a leaf", "leaf"], ["sets in the whole tree", "all"]);
  const mark = (paint, dashes, words) => el("li", {}, svg("svg", { viewBox: "0 0 36 12", "aria-hidden": "true" }, svg("rect", { width: 36, height: 12, rx: 2, fill: "#333" }), svg("line", { x1: 2, x2: 34, y1: 6, y2: 6, stroke: PAINTS[paint], "stroke-width": 3, "stroke-dasharray": dashes })), words);
  const key = el("ul", { class: "key" }, mark("set", "", "the set"), mark("left", "", "its left part"), mark("right", "7 4", "its right part"), mark("leaf", "2 3", "leaves so far"));
  const axes = el("ul", { class: "key" }, ...AXES.map((axis, k) => el("li", {}, svg("svg", { viewBox: "0 0 36 12", "aria-hidden": "true" }, dot(k)), `planes across ${axis}`)), el("li", {}, "ring: the chosen one"));
  body.append(el("div", { class: "bar" }, scenes.element, builders, again), scenes.line,
    el("div", { class: "two" }, el("div", {}, view, key), codes), steps.element, line, chart, axes, ledger);
  onScene(load);

  async function load() {
    if (!scene) return;
    const mine = ++run;
    try {
      const { number } = await ask("build", "bvh2", builder);
      const found = await ask("steps", number, MOST);
      if (mine !== run) return;
      trace = found;
      const weighs = trace.steps.some((step) => step.leaf_cost != null);
      code = program(...PROGRAMS[weighs ? "weighs" : "rules"]);
      codes.replaceChildren(code);
      for (const of of [chart, axes]) of.hidden = !weighs;
      sayCommand();
      steps.length(trace.steps.length);
      steps.to(Math.min(wanted, trace.steps.length));
    } catch (error) {
      line.say(error.message);
    }
  }

  function sayCommand() {
    document.querySelector("[data-cli=split]").textContent = `boxwood build ${scene.named} --structure bvh2 --builder ${builder} --trace`;
  }

  function show(next) {
    [at, wanted] = [next, next];
    const step = trace.steps[at - 1];
    const number = (value) => (value == null ? "–" : short(value));
    ledger.set({ set: step?.count == null ? "–" : count(step.count), weighed: step?.weighed == null ? "–" : count(step.weighed), cost: number(step?.plane?.cost), leaf: number(step?.leaf_cost), all: count(trace.steps_total) });
    code.run(lineOf(step));
    line.say(sentence(step));
    state.set("split.step", at);
    view.paint();
    chart.paint();
  }

  function lineOf(step) {
    if (!step) return 0;
    if (step.step === "split") return 4;
    return step.why === "few" ? 1 : 3;
  }

  function sentence(step) {
    if (!step) return `Nothing is built yet: one set of ${count(trace.primitives - trace.skipped)} triangles.`;
    if (step.step === "move") return `Step ${at}: the tree stands; node ${step.node} moves to beside node ${step.to}, which makes the boxes smaller.`;
    const set = `Step ${at}: set ${step.node}, ${count(step.count)} triangles, ${step.depth} deep`;
    if (step.step === "leaf") return `${set}: ${WHY[step.why] ?? "a leaf"}.`;
    const { axis, at: place, left, right, cost } = step.plane;
    const where = `split at ${axis} = ${short(place)}: ${count(left)} to one side, ${count(right)} to the other`;
    if (cost == null) return `${set}: ${where}.${step.why === "deep" ? ` (${WHY.deep}.)` : ""}`;
    return `${set}: of ${count(step.weighed)} planes the cheapest costs ${short(cost)}, a leaf would cost ${short(step.leaf_cost)}; ${where}.`;
  }

  /** The box of a child: as its own step tells it, else what the plane leaves. */
  function childBox(step, side) {
    const own = trace.steps.find((other) => (other.step === "split" || other.step === "leaf") && other.node === step.children[side]);
    if (own) return [own.bounds.min, own.bounds.max];
    const [min, max] = [[...step.bounds.min], [...step.bounds.max]];
    (side === 0 ? max : min)[AXES.indexOf(step.plane.axis)] = step.plane.at;
    return [min, max];
  }

  function paintView(context, width, height) {
    if (!trace) return;
    const project = projector(scene.camera, width, height);
    const outline = (box, stroke, dashes, weight, alpha = 1) => {
      context.beginPath();
      for (const [from, to] of edges(box)) {
        const ends = project(from, to);
        if (!ends) continue;
        context.moveTo(...ends[0]);
        context.lineTo(...ends[1]);
      }
      [context.globalAlpha, context.lineWidth, context.strokeStyle] = [alpha, weight, stroke];
      context.setLineDash(dashes);
      context.stroke();
    };
    for (const step of trace.steps.slice(0, at)) {
      if (step.step === "leaf") outline([step.bounds.min, step.bounds.max], PAINTS.leaf, [2, 3], 1, 0.7);
      else if (step.step === "split") outline([step.bounds.min, step.bounds.max], PAINTS.set, [], 1, 0.15);
    }
    const now = trace.steps[at - 1];
    if (now?.bounds) outline([now.bounds.min, now.bounds.max], now.step === "leaf" ? PAINTS.leaf : PAINTS.set, [], 3);
    if (now?.step === "split") {
      outline(childBox(now, 0), PAINTS.left, [], 2);
      outline(childBox(now, 1), PAINTS.right, [7, 4], 2);
    }
    context.setLineDash([]);
    context.globalAlpha = 1;
  }

  /** Each plane a mark: where it stands in the box, and what the split would cost. */
  function paintChart(context, width, height) {
    const step = trace?.steps[at - 1];
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = color("soft");
    const planes = step?.planes ?? [];
    const priced = planes.filter((plane) => plane.cost != null);
    if (!priced.length) {
      context.textAlign = "center";
      context.textBaseline = "middle";
      const words = !step ? "go on a step, and the planes appear" : planes.length ? "this builder weighs no costs: one plane by its rule" : "no plane was weighed";
      context.fillText(words, width / 2, height / 2);
      return;
    }
    const [left, right, top, bottom] = [8, width - 8, 22, height - 22];
    const costs = priced.map((plane) => plane.cost);
    const isNear = step.leaf_cost <= 1.5 * Math.max(...costs);
    const [low, high] = [Math.min(...costs, isNear ? step.leaf_cost : Infinity), Math.max(...costs, isNear ? step.leaf_cost : 0)];
    const span = high - low || high || 1;
    const y = (cost) => bottom - 6 - ((cost - low) / span) * (bottom - top - 12);
    const x = ({ axis, at: place }) => {
      const k = AXES.indexOf(axis);
      const [min, max] = [step.bounds.min[k], step.bounds.max[k]];
      return left + 6 + ((place - min) / (max - min || 1)) * (right - left - 12);
    };
    context.fillStyle = color("line");
    context.fillRect(left, bottom, right - left, 1);
    for (const plane of priced) {
      const k = AXES.indexOf(plane.axis);
      context.fillStyle = color(INKS[k]);
      symbol(context, k, x(plane), y(plane.cost), 4.5);
    }
    if (step.step === "split") {
      context.strokeStyle = color("ink");
      context.lineWidth = 2;
      context.beginPath();
      context.arc(x(step.plane), y(step.plane.cost), 9, 0, 7);
      context.stroke();
    }
    context.fillStyle = color("soft");
    context.textBaseline = "bottom";
    context.textAlign = "left";
    context.fillText("one side of the box", left, height - 4);
    context.textAlign = "right";
    context.fillText("the other", right, height - 4);
    context.textBaseline = "top";
    context.textAlign = "left";
    context.fillText(`cost ↑   from ${short(low)} to ${short(high)}`, left, 2);
    context.textAlign = "right";
    if (isNear) {
      context.strokeStyle = color("hit");
      context.lineWidth = 1.5;
      context.setLineDash([5, 4]);
      context.beginPath();
      context.moveTo(left, y(step.leaf_cost));
      context.lineTo(right, y(step.leaf_cost));
      context.stroke();
      context.setLineDash([]);
      context.fillStyle = color("hit");
    }
    context.fillText(`as a leaf ${short(step.leaf_cost)}${isNear ? "" : ", far above"}`, right, 2);
  }
}

/** Of the axes: a colour and a shape each. */
const INKS = ["enter", "cull", "hit"];
/** Over a picture colours must be light, whatever the page is. */
const PAINTS = { set: "#ffffff", left: "#7cc4f2", right: "#ffb454", leaf: "#52e0b0" };

function symbol(context, kind, x, y, size) {
  context.beginPath();
  if (kind === 0) context.arc(x, y, size, 0, 7);
  else if (kind === 1) context.rect(x - size * 0.9, y - size * 0.9, size * 1.8, size * 1.8);
  else {
    context.moveTo(x, y - size * 1.7);
    context.lineTo(x + size * 1.6, y + size * 1.2);
    context.lineTo(x - size * 1.6, y + size * 1.2);
    context.closePath();
    // Hollow, as planes across x and z often coincide.
    context.strokeStyle = context.fillStyle;
    context.lineWidth = 1.5;
    context.stroke();
    return;
  }
  context.fill();
}

/** The same for the key. */
function dot(kind) {
  const fill = `var(--${INKS[kind]})`;
  if (kind === 0) return svg("circle", { cx: 18, cy: 6, r: 5, fill });
  if (kind === 1) return svg("rect", { x: 13.5, y: 1.5, width: 9, height: 9, fill });
  return svg("path", { d: "M18 1 L24 11 L12 11 Z", fill: "none", stroke: fill, "stroke-width": 1.5 });
}
