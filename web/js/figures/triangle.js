// Figure 2: a point, two triangles that share an edge, and the signs that decide.

import { ask } from "../lab.js";
import { bill, button, el, short, svg, tell } from "../dom.js";
import { arrows, held, placeOf } from "../point.js";
import * as state from "../state.js";

/**
 * Corners a, b, c, d as seen along the ray, with their depths; triangles are a b c and b a d. Then the ray.
 *
 * All lie on a lattice, so that the middle of an edge is a number that computers have, and lies on the edge to the last bit.
 */
const USUAL = [-2.375, -1.125, 1.875, 1.25, 2.25, -2, -2.625, 2, 0.875, -0.625];
const onLattice = (value) => Math.round(value * 64) / 64;
const DEPTHS = [3, 5, 4, 4.5];
const NAMES = ["a", "b", "c", "d", "ray"];
const VIEW = [-4.4, -2.75, 8.8, 5.5];
const signs = { "-1": "−", 0: "0", 1: "+" };

export default function triangle(body) {
  let places = state.getList("triangle.at", USUAL);
  const drawing = svg("svg", { viewBox: VIEW.join(" "), role: "group", "aria-label": "two triangles and a ray, seen along the ray" });
  const faces = [0, 1].map(() => svg("polygon", { stroke: "var(--ink)", "stroke-width": 0.03, "stroke-linejoin": "round" }));
  const rays = [0, 1, 2].map(() => svg("line", { stroke: "var(--soft)", "stroke-width": 0.02, "stroke-dasharray": "0.1 0.08" }));
  const labels = [0, 1, 2].map(() => svg("text", { "font-size": 0.32, "font-weight": 700, "text-anchor": "middle", "dominant-baseline": "central", fill: "var(--ink)" }));
  const letters = [0, 1, 2, 3].map((i) => svg("text", { "font-size": 0.27, fill: "var(--ink)", "font-style": "italic" }, NAMES[i]));
  const handles = NAMES.map((name, i) => svg("circle", {
    class: "handle", r: i < 4 ? 0.13 : 0.2, tabindex: 0, role: "slider", "aria-label": i < 4 ? `corner ${name}` : "the ray",
    "aria-valuemin": -5, "aria-valuemax": 5, fill: i < 4 ? "var(--ink)" : "var(--paper)", "fill-opacity": i < 4 ? 1 : 0.4,
    stroke: i < 4 ? "transparent" : "var(--cull)", "stroke-width": i < 4 ? 0.5 : 0.08,
    ...held((event) => {
      const [x, y] = placeOf(event, drawing, VIEW);
      move(i, x, -y);
    }),
    keydown: arrows(1 / 16, 1 / 2, (right, up) => move(i, places[2 * i] + right, places[2 * i + 1] + up)),
  }));
  drawing.append(...faces, ...rays, ...labels, ...letters, ...handles);
  const rows = ["a b c", "b a d"].map((name) => {
    const cells = [0, 1, 2, 3, 4, 5].map(() => el("td"));
    return { cells, row: el("tr", {}, el("th", { scope: "row" }, name), ...cells) };
  });
  const heads = ["triangle", "edge 1", "edge 2", "edge 3", "u", "v", "t"].map((text) => el("th", { scope: "col" }, text));
  const table = el("table", {}, el("thead", {}, el("tr", {}, ...heads)), el("tbody", {}, ...rows.map(({ row }) => row)));
  const ledger = bill(["operations, exact test of a b c", "exact"], ["Cramer's rule stopped after", "exit"], ["operations of Cramer's rule", "cramer"]);
  const line = tell();
  const onEdge = button("Put the ray on the shared edge", () => { [0, 1].forEach((k) => { places[8 + k] = (places[k] + places[2 + k]) / 2; }); update(); });
  const again = button("Reset", () => { places = [...USUAL]; update(); state.reset("triangle"); });
  body.append(drawing, line, el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "the numbers of both tests" }, table), ledger, el("div", { class: "bar" }, onEdge, again));
  update();

  function move(i, x, y) {
    const within = (value, k) => Math.min(Math.max(value, VIEW[k] + 0.2), VIEW[k] + VIEW[k + 2] - 0.2);
    [places[2 * i], places[2 * i + 1]] = [onLattice(within(x, 0)), onLattice(-within(-y, 1))];
    update();
  }

  async function update() {
    const asked = [...places];
    state.set("triangle.at", asked.join(","));
    const corner = (i) => [asked[2 * i], asked[2 * i + 1], DEPTHS[i]];
    const ray = [asked[8], asked[9], 0, 0, 0, 1];
    const found = await Promise.all([[0, 1, 2], [1, 0, 3]].map((corners) => ask("test", [...corners.flatMap(corner), ...ray])));
    if (asked.join() === places.join()) show(asked, found);
  }

  function show(at, found) {
    const point = (i) => [at[2 * i], -at[2 * i + 1]];
    [[0, 1, 2], [1, 0, 3]].forEach((corners, i) => {
      faces[i].setAttribute("points", corners.map(point).join(" "));
      faces[i].setAttribute("fill", found[i].hit ? "var(--hit)" : "var(--miss)");
      faces[i].setAttribute("fill-opacity", found[i].hit ? 0.55 : 0.13);
    });
    letters.forEach((letter, i) => place(letter, point(i), 0.22));
    handles.forEach((handle, i) => {
      const [x, y] = point(i);
      handle.setAttribute("cx", x);
      handle.setAttribute("cy", y);
      handle.setAttribute("aria-valuenow", at[2 * i]);
      handle.setAttribute("aria-valuetext", `x ${at[2 * i]}, y ${at[2 * i + 1]}`);
    });
    // Edge k is opposite to corner k: its sign stands at its middle.
    [[1, 2], [2, 0], [0, 1]].forEach(([from, to], k) => {
      const middle = [0, 1].map((axis) => (point(from)[axis] + point(to)[axis]) / 2);
      labels[k].textContent = signs[found[0].signs[k]];
      labels[k].setAttribute("fill", found[0].signs[k] === found[0].signs[(k + 1) % 3] || found[0].signs[k] === found[0].signs[(k + 2) % 3] ? "var(--enter)" : "var(--cull)");
      place(labels[k], middle, 0);
      ["x1", "y1", "x2", "y2"].forEach((name, j) => rays[k].setAttribute(name, [...point(k), ...point(4)][j]));
    });
    rows.forEach(({ cells }, i) => {
      const { edges, signs: sign, hit } = found[i];
      edges.forEach((edge, k) => { cells[k].textContent = `${short(edge)} (${signs[sign[k]]})`; });
      const [t, u, v] = hit ?? [NaN, NaN, NaN];
      [u, v, t].forEach((value, k) => { cells[3 + k].textContent = short(value); });
    });
    const [abc, bad] = found;
    ledger.set({ exact: String(abc.flops), exit: abc.cramer_exit === "t" ? "t: all" : { beta: "β", gamma: "γ" }[abc.cramer_exit], cramer: String(abc.cramer_flops) });
    const tie = [...abc.edges, ...bad.edges].some((edge) => edge === 0);
    const what = abc.hit ? "Triangle a b c is hit" : bad.hit ? "Triangle b a d is hit" : "Neither triangle is hit";
    const hit = abc.hit ?? bad.hit;
    const why = !hit ? ": in each, the signs differ." : tie ? ", and it alone: an edge function is exactly zero, and both triangles read the rule of ties alike." : ": its three signs agree.";
    line.say(`${what}${why}${hit ? ` t is ${short(hit[0])}.` : ""}`);
  }

  function place(text, [x, y], off) {
    text.setAttribute("x", x + off);
    text.setAttribute("y", y - off);
  }
}
