// Figure 3: sphere, box and oriented box round one shape: what a test costs, how often it says yes in vain.

import { ask } from "../lab.js";
import { button, choice, el, short, slider, svg, tell } from "../dom.js";
import * as state from "../state.js";

/** Outlines, from -1 to 1. */
const SHAPES = {
  pencil: [[-0.95, -0.12], [0.6, -0.12], [0.95, 0], [0.6, 0.12], [-0.95, 0.12]],
  leaf: [[-0.9, -0.5], [-0.2, -0.45], [0.4, -0.1], [0.85, 0.5], [0.2, 0.45], [-0.4, 0.15]],
  pebble: [[0.72, 0.1], [0.5, 0.55], [0, 0.7], [-0.5, 0.5], [-0.7, 0.05], [-0.5, -0.45], [0.05, -0.68], [0.55, -0.45]],
  angle: [[-0.8, -0.8], [0.8, -0.8], [0.8, -0.55], [-0.55, -0.55], [-0.55, 0.8], [-0.8, 0.8]],
};
const USUAL = { shape: "leaf", turn: 30, triangles: 16 };
const WORDS = { sphere: "sphere", aabb: "axis-aligned box", obb: "oriented box" };
const LOOKS = { sphere: ["var(--cull)", "0.02 0.04"], aabb: ["var(--enter)", ""], obb: ["var(--hit)", "0.09 0.04"] };
const STOPS = [1, 2, 4, 8, 16, 30, 100, 300, 1000, 10000];
const [RAYS, REACH] = [4096, 1.6];

export default function boxes(body) {
  let shape = SHAPES[state.get("boxes.shape")] ? state.get("boxes.shape") : USUAL.shape;
  let turn = state.getWhole("boxes.turn", USUAL.turn, 0, 180);
  let stop = state.getWhole("boxes.n", STOPS.indexOf(USUAL.triangles), 0, STOPS.length - 1);

  const shapes = choice("Shape", Object.keys(SHAPES).map((name) => [name, name]), shape, (value) => { shape = value; state.set("boxes.shape", value); update(); });
  const turns = slider("Turned by", { min: 0, max: 180, value: turn, say: (degrees) => `${degrees}°` }, (value) => { turn = value; state.set("boxes.turn", value); update(); });
  const many = slider("Triangles inside", { min: 0, max: STOPS.length - 1, value: stop, say: (at) => STOPS[at].toLocaleString("en-US") }, (at) => { stop = at; state.set("boxes.n", at); update(); });
  for (const one of [turns, many]) one.classList.add("grow");
  const again = button("Reset", () => {
    state.reset("boxes");
    [shape, turn, stop] = [USUAL.shape, USUAL.turn, STOPS.indexOf(USUAL.triangles)];
    shapes.control.value = shape;
    turns.set(turn);
    many.set(stop);
    update();
  });
  const outline = svg("polygon", { fill: "var(--ink)", "fill-opacity": 0.8 });
  const circle = svg("circle", look("sphere"));
  const [aabb, obb] = [svg("polygon", look("aabb")), svg("polygon", look("obb"))];
  const drawing = svg("svg", { viewBox: "-2.2 -1.15 4.4 2.3", role: "img", "aria-label": "a shape in its three bounding volumes" }, outline, circle, aabb, obb);
  const rows = Object.keys(WORDS).map((name) => {
    const cells = [0, 1, 2, 3].map(() => el("td"));
    const mark = svg("svg", { viewBox: "0 -0.05 0.4 0.1", width: 30, height: 8, "aria-hidden": "true" }, svg("line", { x2: 0.4, ...look(name), "stroke-width": 0.05 }));
    mark.classList.add("mark");
    return { name, cells, row: el("tr", {}, el("th", { scope: "row" }, mark, WORDS[name]), ...cells) };
  });
  const bare = [0, 1, 2, 3].map(() => el("td"));
  const heads = ["volume", "operations of its test", "says yes", "in vain", "operations per ray in all"].map((text) => el("th", { scope: "col" }, text));
  const table = el("table", {}, el("thead", {}, el("tr", {}, ...heads)), el("tbody", {}, el("tr", {}, el("th", { scope: "row" }, "none"), ...bare), ...rows.map(({ row }) => row)));
  const line = tell();
  body.append(el("div", { class: "bar" }, shapes, turns, many, again), drawing, line,
    el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "cost and tightness of each volume" }, table));
  update();

  function look(name) {
    return { fill: "none", stroke: LOOKS[name][0], "stroke-width": 0.02, "stroke-dasharray": LOOKS[name][1] };
  }

  async function update() {
    const asked = `${shape} ${turn} ${stop}`;
    const [sin, cos] = [Math.sin((turn * Math.PI) / 180), Math.cos((turn * Math.PI) / 180)];
    const points = SHAPES[shape].map(([x, y]) => [cos * x - sin * y, sin * x + cos * y]);
    const walls = points.flatMap((point, i) => [...point, ...points[(i + 1) % points.length]]);
    const found = await ask("volumes", walls, RAYS, REACH, STOPS[stop]);
    if (asked === `${shape} ${turn} ${stop}`) show(points, found);
  }

  function show(points, found) {
    const flat = (list) => list.map(([x, y]) => `${x},${-y}`).join(" ");
    outline.setAttribute("points", flat(points));
    const [sphere, box, turned] = found.volumes;
    ["cx", "cy", "r"].forEach((name, i) => circle.setAttribute(name, sphere.circle[i] * (i === 1 ? -1 : 1)));
    aabb.setAttribute("points", flat(box.corners));
    obb.setAttribute("points", flat(turned.corners));
    const percent = (part, whole) => `${short((100 * part) / whole || 0)} %`;
    ["–", percent(found.rays, found.rays), percent(found.rays - found.hits, found.rays), short(found.object_flops)].forEach((text, i) => { bare[i].textContent = text; });
    for (const { name, cells } of rows) {
      const volume = found.volumes.find((one) => one.name === name);
      [volume.flops, percent(volume.met, found.rays), percent(volume.in_vain, volume.met), short(volume.flops_per_ray)].forEach((text, i) => { cells[i].textContent = text; });
    }
    const all = [...found.volumes.map((volume) => [volume.flops_per_ray, `the ${WORDS[volume.name]}`]), [found.object_flops, "no volume at all"]];
    const [cost, best] = all.reduce((a, b) => (b[0] < a[0] ? b : a));
    line.say(`Of ${found.rays.toLocaleString("en-US")} rays ${percent(found.hits, found.rays)} hit the shape. Cheapest is ${best}: ${short(cost)} operations a ray, where asking the shape itself takes ${short(found.object_flops)}.`);
  }
}
