// Figure 6: the uniform grid from above, cell by cell.

import { ask } from "../lab.js";
import { bill, button, el, short, slider, svg, tell } from "../dom.js";
import { program, stepper } from "../stepper.js";
import { arrows, held, placeOf } from "../point.js";
import * as state from "../state.js";

const WALLS = [
  [0.4, 0.5, 2.0, 0.4], [1.3, 3.6, 1.8, 5.0], [3.2, 7.9, 4.9, 8.5], [4.0, 2.2, 4.4, 3.6], [6.3, 0.5, 7.6, 1.4], [6.2, 6.6, 7.5, 6.0],
  [8.4, 3.0, 9.0, 4.3], [10.2, 7.0, 11.6, 8.2], [10.9, 1.0, 11.3, 2.6], [12.6, 4.6, 13.3, 6.0], [14.2, 0.7, 15.6, 1.8], [14.9, 7.4, 15.6, 8.6],
];
const USUAL = { ray: [-0.8, 1.1, 12.2, 6.6], columns: 8 };
const VIEW = [-1.4, -9.6, 18.4, 10.2];
const LINES = ["start in the first cell", "test the triangles of the cell", "if a hit lies before the next face: done", "step across the nearer face,", "  and add its constant offset to its t"];

export default function grid(body) {
  let ray = state.getList("grid.ray", USUAL.ray);
  let columns = state.getWhole("grid.columns", USUAL.columns, 3, 24);
  let wanted = state.getWhole("grid.step", -1, 0, 1e4);
  let answer = null;

  const cells = svg("g");
  const visited = svg("g");
  const walls = WALLS.map(([x0, y0, x1, y1]) => svg("line", { x1: x0, y1: -y0, x2: x1, y2: -y1, stroke: "var(--ink)", "stroke-width": 0.11, "stroke-linecap": "round" }));
  const path = svg("line", { stroke: "var(--cull)", "stroke-width": 0.06 });
  const point = svg("circle", { r: 0.16, fill: "var(--hit)" });
  const faces = ["x", "y"].map((axis) => svg("g", {}, svg("circle", { r: 0.1, fill: "var(--paper)", stroke: "var(--enter)", "stroke-width": 0.05 }), svg("text", { "font-size": 0.36, fill: "var(--enter)" }, axis)));
  const handles = ["start of the ray", "a point on the ray"].map((name, i) => svg("circle", {
    class: "handle", r: 0.28, tabindex: 0, role: "slider", "aria-label": name, "aria-valuemin": -1, "aria-valuemax": 17, fill: "var(--paper)", stroke: "var(--cull)", "stroke-width": 0.09,
    ...held((event) => {
      const [x, y] = placeOf(event, drawing, VIEW);
      move(i, x, -y);
    }),
    keydown: arrows(0.1, 1, (right, up) => move(i, ray[2 * i] + right, ray[2 * i + 1] + up)),
  }));
  const drawing = svg("svg", { viewBox: VIEW.join(" "), role: "group", "aria-label": "a grid with walls and a ray, from above" }, cells, visited, ...walls, path, ...faces, point, ...handles);
  const size = slider("Cells across", { min: 3, max: 24, value: columns }, (value) => { columns = value; state.set("grid.columns", columns); load(); });
  size.classList.add("grow");
  const again = button("Reset", () => {
    state.reset("grid");
    [ray, columns] = [[...USUAL.ray], USUAL.columns];
    size.set(columns);
    load();
  });
  const steps = stepper("cell of the walk", show);
  const line = tell();
  const code = program(...LINES);
  const rows = ["x", "y"].map((axis) => {
    const values = [el("td"), el("td")];
    return { values, row: el("tr", {}, el("th", { scope: "row" }, axis), ...values) };
  });
  const heads = ["axis", "t of the next face", "constant offset"].map((text) => el("th", { scope: "col" }, text));
  const table = el("table", {}, el("thead", {}, el("tr", {}, ...heads)), el("tbody", {}, ...rows.map(({ row }) => row)));
  const ledger = bill(["cells visited", "cells"], ["triangle tests in all, two a wall", "tests"], ["operations in all", "flops"], ["cells in all", "all"]);
  body.append(el("div", { class: "bar" }, size, again), drawing, steps.element, line, el("div", { class: "two" }, code, table), ledger);
  load();

  function move(i, x, y) {
    const next = [...ray];
    next[2 * i] = Number(Math.min(Math.max(x, -1), 16.6).toFixed(2));
    next[2 * i + 1] = Number(Math.min(Math.max(y, -0.2), 9.2).toFixed(2));
    if (Math.hypot(next[2] - next[0], next[3] - next[1]) < 0.3) return;
    ray = next;
    state.set("grid.ray", ray.join(","));
    load();
  }

  async function load() {
    const asked = `${ray} ${columns}`;
    const found = await ask("grid", WALLS.flat(), columns, [ray[0], ray[1], ray[2] - ray[0], ray[3] - ray[1]]);
    if (asked !== `${ray} ${columns}`) return;
    answer = found;
    drawGrid();
    steps.length(answer.steps.length);
    steps.to(wanted >= 0 ? wanted : answer.steps.length);
    wanted = -1;
  }

  const side = (axis) => (answer.bounds[1][axis] - answer.bounds[0][axis]) / answer.cells[axis];
  const cellAt = ([column, row], looks) => svg("rect", { x: answer.bounds[0][0] + column * side(0), y: -(answer.bounds[0][1] + (row + 1) * side(1)), width: side(0), height: side(1), ...looks });
  const along = (t) => [ray[0] + t * (ray[2] - ray[0]), -(ray[1] + t * (ray[3] - ray[1]))];

  function drawGrid() {
    const [[x0, y0], [x1, y1]] = answer.bounds;
    const lines = [];
    for (let i = 0; i <= answer.cells[0]; i++) lines.push([x0 + i * side(0), -y0, x0 + i * side(0), -y1]);
    for (let i = 0; i <= answer.cells[1]; i++) lines.push([x0, -(y0 + i * side(1)), x1, -(y0 + i * side(1))]);
    cells.replaceChildren(
      ...answer.filled.map(([column, row]) => cellAt([column, row], { fill: "var(--ink)", "fill-opacity": 0.07 })),
      ...lines.map(([a, b, c, d]) => svg("line", { x1: a, y1: b, x2: c, y2: d, stroke: "var(--line)", "stroke-width": 0.03 })));
    handles.forEach((handle, i) => {
      handle.setAttribute("cx", ray[2 * i]);
      handle.setAttribute("cy", -ray[2 * i + 1]);
      handle.setAttribute("aria-valuenow", ray[2 * i]);
      handle.setAttribute("aria-valuetext", `x ${ray[2 * i]}, y ${ray[2 * i + 1]}`);
    });
  }

  function show(at) {
    const done = answer.steps.slice(0, at);
    const now = done.at(-1);
    const isEnd = at === answer.steps.length;
    visited.replaceChildren(...done.map((step, i) => cellAt(step.cell, i === at - 1 ? { fill: "var(--enter)", "fill-opacity": 0.34 } : { fill: "var(--enter)", "fill-opacity": 0.14 })));
    const tested = new Set(done.flatMap((step) => step.tested));
    walls.forEach((wall, i) => wall.setAttribute("stroke", answer.hit && isEnd && answer.hit[1] === i ? "var(--hit)" : tested.has(i) ? "var(--cull)" : "var(--ink)"));
    const end = along(answer.hit && isEnd ? answer.hit[0] : 20);
    ["x1", "y1", "x2", "y2"].forEach((name, i) => path.setAttribute(name, [ray[0], -ray[1], ...end][i]));
    point.setAttribute("visibility", answer.hit && isEnd ? "visible" : "hidden");
    if (answer.hit) ["cx", "cy"].forEach((name, i) => point.setAttribute(name, along(answer.hit[0])[i]));
    faces.forEach((face, axis) => {
      const t = now?.t_next[axis];
      face.setAttribute("visibility", t == null ? "hidden" : "visible");
      if (t != null) face.setAttribute("transform", `translate(${along(t)})`);
      face.lastChild.setAttribute("x", 0.15);
      face.lastChild.setAttribute("y", axis ? 0.4 : -0.18);
    });
    rows.forEach(({ values }, axis) => {
      values[0].textContent = now?.t_next[axis] == null ? "–" : now.t_next[axis].toFixed(4);
      const offset = answer.steps[0]?.t_delta[axis];
      values[1].textContent = offset == null ? "never" : offset.toFixed(4);
    });
    ledger.set({ cells: String(at), tests: String(answer.tests), flops: String(answer.flops), all: `${answer.cells[0]} × ${answer.cells[1]}` });
    code.run(!now ? 0 : isEnd ? 2 : now.tested.length ? 1 : 3);
    line.say(sentence(now, at, isEnd));
    state.set("grid.step", at);
  }

  function sentence(now, at, isEnd) {
    if (!answer.steps.length) return "The ray misses the whole grid: no cell is visited.";
    if (!now) return "The ray is about to enter the grid.";
    const names = now.tested.map((wall) => wall + 1).join(", ");
    const tests = now.tested.length > 1 ? `walls ${names} are tested` : names ? `wall ${names} is tested` : "nothing new to test";
    const where = `Cell ${at}: column ${now.cell[0]}, row ${now.cell[1]}; ${tests}. `;
    if (isEnd) return where + (answer.hit ? `Wall ${answer.hit[1] + 1}${now.tested.includes(answer.hit[1]) ? "" : ", tested in a cell before,"} is hit at t ${short(answer.hit[0])}, before the next face.` : "The ray leaves the grid: nothing is hit.");
    const [x, y] = now.t_next.map((t) => t ?? Infinity);
    return where + (x < y ? "The next face along x is nearer: one column on." : "The next face along y is nearer: one row on.");
  }
}
