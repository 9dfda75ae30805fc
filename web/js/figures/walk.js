// Figure 5: the walk of one pixel's ray, step by step.

import { ask } from "../lab.js";
import { bill, board, button, choice, color, count, el, short, svg, tell } from "../dom.js";
import { edges, projector } from "../project.js";
import { onScene, picker, scene, sceneBoard, SIZE } from "../scenes.js";
import { program, stepper } from "../stepper.js";
import { arrows, placeOf } from "../point.js";
import * as state from "../state.js";

const WAYS = [
  ["bvh2 binned", "binary, surface area"],
  ["bvh2 median", "binary, median"],
  ["bvh2 midpoint", "binary, midpoint"],
  ["bvh2 morton", "binary, Morton order"],
  ["bvh2 sweep", "binary, every split tried"],
  ["wide binned", "eight wide"],
];
const USUAL = { way: "bvh2 binned", pixel: [160, 90] };
/** Colour, dashes and words of each verdict: never colour alone. */
const LOOKS = {
  enter: ["enter", [], "met"],
  miss: ["miss", [2, 4], "missed"],
  farther: ["cull", [7, 4], "behind the closest hit"],
  dropped: ["cull", [7, 4], "behind the closest hit"],
};
const LINES = ["while a node waits:", "  take the next; behind the hit? drop it", "  test the boxes of its children", "  in a leaf: test its triangles,", "    keep the closest hit", "done"];

/** Figure 7 sends readers here with a pixel. */
export let visit = () => {};

export default function walk(body) {
  let way = WAYS.some(([name]) => name === state.get("walk.way")) ? state.get("walk.way") : USUAL.way;
  let pixel = state.getList("walk.px", USUAL.pixel);
  let wanted = state.getWhole("walk.step", -1, 0, 1e6);
  let answer = null;
  let at = 0;

  const scenes = picker();
  const ways = choice("Tree", WAYS, way, (value) => { way = value; state.set("walk.way", way); load(); });
  const again = button("Reset", () => {
    state.reset("walk");
    [way, pixel] = [USUAL.way, [...USUAL.pixel]];
    ways.control.value = way;
    load();
  }, { class: "end" });
  const view = sceneBoard({ tabindex: 0, role: "application", "aria-roledescription": "picture", "aria-label": "the scene; arrow keys move the pixel whose ray is walked" }, 0.25, paintView);
  view.addEventListener("click", (event) => go(placeOf(event, view, [0, 0, ...SIZE])));
  view.addEventListener("keydown", arrows(1, 10, (right, up) => go([pixel[0] + right, pixel[1] - up])));
  const along = board({ role: "img", "aria-label": "each test as a stretch of the ray" }, (width) => Math.max(170, width / 3.4), paintAlong);
  const steps = stepper("step of the walk", show);
  const line = tell();
  const code = program(...LINES);
  const waiting = el("p", { class: "stack" });
  const ledger = bill(["box tests", "boxes"], ["triangle tests", "prims"], ["operations", "flops"], ["triangles in all", "all"]);
  const mark = (name, dashes, words) => el("li", {}, svg("svg", { viewBox: "0 0 36 12", "aria-hidden": "true" }, svg("line", { x1: 0, x2: 36, y1: 6, y2: 6, stroke: `var(--${name})`, "stroke-width": 3, "stroke-dasharray": dashes.join(" ") })), words);
  const key = el("ul", { class: "key" }, mark("enter", [], "met"), mark("miss", [2, 4], "missed"), mark("cull", [7, 4], "culled: behind the closest hit"), mark("hit", [], "triangle tested, ring: hit"), el("li", {}, "at the left margin: not on the ray"));
  body.append(el("div", { class: "bar" }, scenes.element, ways, again), scenes.line,
    el("div", { class: "two" }, el("div", {}, view, key), el("div", {}, code, waiting)),
    steps.element, line, along, ledger);
  visit = (at, tree) => { choose(tree); go(at); document.getElementById("walk").scrollIntoView(); };
  onScene(() => { if (!inPicture(pixel)) pixel = [...USUAL.pixel]; load(); });

  function inPicture([x, y]) {
    return x >= 0 && y >= 0 && x < SIZE[0] && y < SIZE[1];
  }

  function choose(tree) {
    way = tree;
    ways.control.value = way;
    state.set("walk.way", way);
  }

  function go([x, y]) {
    pixel = [Math.min(Math.max(Math.floor(x), 0), SIZE[0] - 1), Math.min(Math.max(Math.floor(y), 0), SIZE[1] - 1)];
    state.set("walk.px", pixel.join(","));
    load();
  }

  async function load() {
    const asked = `${way} ${pixel}`;
    try {
      const { number } = await ask("build", ...way.split(" "));
      const found = await ask("walk", SIZE, number, ...pixel);
      if (asked !== `${way} ${pixel}`) return;
      answer = found;
      sayCommand();
      steps.length(answer.steps.length);
      steps.to(wanted >= 0 ? wanted : answer.steps.length);
      wanted = -1;
    } catch (error) {
      line.say(error.message);
    }
  }

  function sayCommand() {
    const [structure, builder] = way.split(" ");
    document.querySelector("[data-cli=walk]").textContent = `boxwood explain ${scene.named} --size ${SIZE.join("x")} --pixel ${pixel} --structure ${structure} --builder ${builder}`;
  }

  function show(next) {
    at = next;
    const done = answer.steps.slice(0, at);
    const now = done.at(-1);
    const tested = (kind) => done.filter((step) => step.step === kind && step.verdict !== "dropped").length;
    ledger.set({ boxes: count(tested("box")), prims: count(tested("primitive")), flops: count(done.reduce((sum, step) => sum + step.flops, 0)), all: count(scene.triangles) });
    waiting.replaceChildren("waiting: ", ...(now?.stack_after.length ? now.stack_after.map((node) => el("span", { class: "n" }, String(node))) : ["nothing"]));
    code.run(at === answer.steps.length ? 5 : lineOf(now));
    line.say(sentence(now));
    state.set("walk.step", at);
    view.paint();
    along.paint();
  }

  function lineOf(step) {
    if (!step) return 0;
    if (step.step === "primitive") return step.verdict === "closest" ? 4 : 3;
    return step.verdict === "dropped" ? 1 : 2;
  }

  function sentence(step) {
    const where = `Pixel ${pixel[0]}, ${pixel[1]}. `;
    if (!step) return `${where}The ray starts at the eye; the root's box is to be tested.`;
    const end = at === answer.steps.length ? (answer.hit ? ` Answer: triangle ${count(answer.hit.prim)} at t ${short(answer.hit.t)}.` : " Answer: nothing is hit.") : "";
    if (step.step === "primitive") {
      const words = { closest: `hit at t ${short(step.t)}, the closest so far`, farther: `hit at t ${short(step.t)}, not the closest`, miss: "missed", "out of range": "hit outside the ray's range" }[step.verdict];
      return `Step ${at}: triangle ${count(step.prim)} ${words}.${end}`;
    }
    const kind = step.leaf_of ? `leaf ${step.node} of ${step.leaf_of} triangles` : `box ${step.node}`;
    if (step.verdict === "dropped") return `Step ${at}: ${kind} had waited; by now a closer hit is known, so it is dropped without a test.${end}`;
    const inside = step.near != null && step.near <= step.far ? `the ray is inside from t ${short(step.near)} to ${short(step.far)}` : "the three slabs do not overlap";
    return `Step ${at}: ${kind} ${LOOKS[step.verdict][2]}; ${inside}.${end}`;
  }

  function paintView(context, width, height) {
    if (!answer) return;
    const project = projector(scene.camera, width, height);
    const done = answer.steps.slice(0, at);
    const latest = done.findLastIndex((step) => step.step === "box");
    done.forEach((step, i) => {
      const isNow = i === at - 1;
      const points = answer.points[i];
      if (step.step === "box" && points.length === 2) {
        const [name, dashes] = LOOKS[step.verdict];
        outline(context, project, edges(points), PAINTS[name], dashes, isNow || i === latest ? 2.5 : 1, isNow || i === latest ? 1 : 0.35);
      } else if (points.length === 3) {
        const [a, b, c] = points;
        outline(context, project, [[a, b], [b, c], [c, a]], PAINTS.hit, [], isNow ? 3 : 1.5, 1);
      }
    });
    const [x, y] = [((pixel[0] + 0.5) / SIZE[0]) * width, ((pixel[1] + 0.5) / SIZE[1]) * height];
    for (const [stroke, radius] of [["#000", 8], ["#fff", 6]]) {
      context.beginPath();
      context.arc(x, y, radius, 0, 7);
      context.lineWidth = 2;
      context.strokeStyle = stroke;
      context.stroke();
    }
  }

  function outline(context, project, lines, stroke, dashes, weight, alpha) {
    context.beginPath();
    for (const [from, to] of lines) {
      const ends = project(from, to);
      if (!ends) continue;
      context.moveTo(...ends[0]);
      context.lineTo(...ends[1]);
    }
    context.globalAlpha = alpha;
    context.setLineDash(dashes);
    context.lineWidth = weight;
    context.strokeStyle = stroke;
    context.stroke();
    context.setLineDash([]);
    context.globalAlpha = 1;
  }

  /** Each test a row; the stretch inside the box a bar; the closest hit a line down. */
  function paintAlong(context, width, height) {
    if (!answer) return;
    // What does not lie on the ray stands in a margin of its own.
    const margin = 4, left = 26, right = width - 4, top = 4, bottom = height - 20;
    context.fillStyle = color("line");
    context.fillRect(left - 5, top, 1, bottom - top);
    const met = answer.steps.filter((step) => step.step === "box" && step.near != null && step.far != null && step.near <= step.far && step.far > 0);
    const ends = met.map((step) => step.far);
    const end = Math.max(...ends, answer.hit?.t ?? 0, 1e-30) * 1.03;
    const start = Math.max(0, Math.min(...met.map((step) => Math.max(step.near, 0)), answer.hit?.t ?? Infinity) * 0.97) || 0;
    const x = (t) => left + ((Math.min(Math.max(t, start), end) - start) / (end - start || 1)) * (right - left);
    const row = Math.min(14, (bottom - top) / Math.max(answer.steps.length, 1));
    answer.steps.slice(0, at).forEach((step, i) => {
      const y = top + (i + 0.5) * row;
      const isNow = i === at - 1;
      context.lineWidth = Math.max(1.5, row * (isNow ? 0.75 : 0.45));
      if (step.step === "box") {
        const [name, dashes] = LOOKS[step.verdict];
        context.strokeStyle = color(name);
        context.setLineDash(dashes);
        context.beginPath();
        if (step.near <= step.far) { context.moveTo(x(step.near), y); context.lineTo(Math.max(x(step.far), x(step.near) + 2), y); }
        else { context.moveTo(margin, y); context.lineTo(margin + 14, y); }
        context.stroke();
        context.setLineDash([]);
      } else if (step.t != null) {
        context.strokeStyle = color("hit");
        context.lineWidth = 2;
        context.beginPath();
        context.arc(x(step.t), y, Math.max(2.5, row * 0.4), 0, 7);
        context.stroke();
      } else {
        context.fillStyle = color("hit");
        context.fillRect(margin, y - 1, 14, 2);
      }
    });
    const best = answer.steps[at - 1]?.best_t;
    if (best != null) {
      context.strokeStyle = color("hit");
      context.lineWidth = 1;
      context.beginPath();
      context.moveTo(x(best), top);
      context.lineTo(x(best), bottom);
      context.stroke();
    }
    context.fillStyle = color("soft");
    context.font = "12px system-ui, sans-serif";
    context.textBaseline = "bottom";
    context.textAlign = "left";
    context.fillText(`t = ${short(start)}`, left, height);
    context.textAlign = "right";
    context.fillText(`t = ${short(end)}`, right, height);
    if (best != null) {
      context.textAlign = "center";
      context.fillStyle = color("hit");
      context.fillText(`closest hit ${short(best)}`, Math.min(Math.max(x(best), 130), width - 130), height);
    }
  }
}

/** Over a picture colours must be light, whatever the page is. */
const PAINTS = { enter: "#7cc4f2", miss: "#e8e8e8", cull: "#ffb454", hit: "#52e0b0" };
