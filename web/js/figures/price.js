// Figure 1: pixels x triangles x 27, and how long that takes here.

import { ask } from "../lab.js";
import { bill, button, choice, count, duration, el, short, slider, tell } from "../dom.js";
import { onScene, scene, SIZE } from "../scenes.js";
import * as state from "../state.js";

const USUAL = { size: "1280x720", triangles: 40000 };
const SIZES = ["320x180", "640x360", "1280x720", "1920x1080", "3840x2160"];
/** Triangles the slider stops at: the lecture's bunny, its game model, and what is usual today. */
const STOPS = [12, 114, 500, 1000, 2000, 5000, 10000, 20000, 40000, 70000, 100000, 200000, 500000, 1e6, 2e6, 5e6, 1e7];
/** Seconds of brute force. */
const PATIENCE = 1;

export default function price(body) {
  let size = SIZES.includes(state.get("price.size")) ? state.get("price.size") : USUAL.size;
  let triangles = STOPS[state.getWhole("price.n", STOPS.indexOf(USUAL.triangles), 0, STOPS.length - 1)];
  let speed = null;

  const sizes = choice("Picture", SIZES.map((name) => [name, name.replace("x", " × ")]), size, (value) => { size = value; state.set("price.size", size); update(); });
  const many = slider("Triangles", { min: 0, max: STOPS.length - 1, value: STOPS.indexOf(triangles), say: (at) => count(STOPS[at]) }, (at) => {
    triangles = STOPS[at];
    state.set("price.n", at);
    update();
  });
  many.classList.add("grow");
  const measure = button("Measure on this machine", run, { class: "main" });
  const product = el("p", { class: "n" });
  const big = el("p", { class: "big", "data-value": "flops" });
  const ledger = bill(["on a laptop of 100 GFLOPS", "laptop"], ["here, in this browser (estimated)", "here"], ["frames a second here (estimated)", "rate"]);
  const line = tell();
  const again = button("Reset", () => {
    state.reset("price");
    [size, triangles] = [USUAL.size, USUAL.triangles];
    sizes.control.value = size;
    many.set(STOPS.indexOf(triangles));
    update();
  });
  body.append(el("div", { class: "bar" }, sizes, many, measure, again), product, big, ledger, line);
  onScene(() => { speed = null; update(); });
  update();

  async function update() {
    const [width, height] = size.split("x").map(Number);
    const wanted = `${size} ${triangles}`;
    const found = await ask("price", width, height, triangles);
    if (wanted !== `${size} ${triangles}`) return;
    product.textContent = `${count(width)} × ${count(height)} pixels × ${count(triangles)} triangles × ${found.flops_per_test} operations =`;
    big.textContent = `${count(found.flops)}`;
    const seconds = speed ? (found.pixels * triangles) / speed : NaN;
    ledger.set({ laptop: `${duration(found.seconds_at_100_gflops)} a frame`, here: speed ? `${duration(seconds)} a frame` : "measure it", rate: short(1 / seconds) });
    line.say(`That is ${short(found.flops / 1e9)} GFLOP for one frame, and an interactive program wants 30 of them a second.`);
  }

  /** Brute force on scattered rows of the open scene, until patience ends. */
  async function run() {
    if (!scene) return;
    measure.disabled = true;
    try {
      const { number } = await ask("build", "list");
      let [tests, ms] = [0, 0];
      for (let i = 0; ms < 1000 * PATIENCE && i < SIZE[1]; i++) {
        const shot = await ask("shoot", SIZE, number, (i * 67) % SIZE[1], 1);
        tests += shot.rays * scene.triangles;
        ms += shot.ms;
        speed = (1000 * tests) / ms;
        await update();
      }
      line.say(`Estimated from ${count(tests)} tests of ${count(tests / scene.triangles)} rays in ${duration(ms / 1000)}: ${short(speed / 1e6)} million tests a second, in one thread.`);
    } catch (error) {
      line.say(error.message);
    }
    measure.disabled = false;
  }
}
