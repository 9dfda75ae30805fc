// The exercises at the end: the answers are computed when they are asked for.

import { ask } from "../lab.js";
import { button, count, el } from "../dom.js";
import { scene, SIZE } from "../scenes.js";

/** Question, the answer from Boxwood, and what to say when it is found. */
const EXERCISES = [
  {
    question: "The lecture's bunny has 114 triangles. How many operations is a frame of 1280 × 720 by brute force?",
    answer: async () => (await ask("price", 1280, 720, 114)).flops,
    why: "1280 × 720 × 114 × 27: 2.8 GFLOP, which a laptop does in a fraction of a second. It is the 40,000 that hurt.",
  },
  {
    question: "A triangle has its corners at (0, 0), (4, 0) and (0, 4). The ray meets it at (1, 2). What is v, the weight of the third corner?",
    answer: async () => (await ask("test", [0, 0, 5, 4, 0, 5, 0, 4, 5, 1, 2, 0, 0, 0, 1])).hit[2],
    why: "p = (1 − u − v) a + u b + v c: the y of the point is 4 v.",
  },
  {
    question: "A ray crosses a grid of 8 × 8 cells from corner to opposite corner, but through no inner corner. How many cells does it visit?",
    answer: async () => (await ask("grid", [0, 0, 0.01, 0.01, 7.99, 7.99, 8, 8], 8, [-0.4, -0.41, 8.5, 8.52])).steps.length,
    why: "Each step crosses one face: 7 along x, 7 along y, and the cell it starts in.",
  },
  {
    question: "In the walk above, with the bush and the binary tree by surface area: how many triangles does the ray of pixel 160, 90 test?",
    answer: async () => {
      if (scene?.title !== "builtin:bush") throw new Error("Open the bush first, in any figure above: the question is about it.");
      const { number } = await ask("build", "bvh2", "binned");
      return (await ask("walk", SIZE, number, 160, 90)).counts.primitive_tests;
    },
    why: "Out of 40,000: that is the point of the whole page.",
  },
];

export default function exercises(body) {
  body.append(el("ol", {}, ...EXERCISES.map(item)));
}

function item({ question, answer, why }) {
  const input = el("input", { type: "text", inputmode: "decimal", "aria-label": "your answer", size: 16 });
  const says = el("span", { role: "status" });
  const tell = (text, look) => { says.textContent = text; says.className = look; };
  const check = async () => {
    try {
      const right = await answer();
      if (numberOf(input.value) === right) tell(`✓ Yes. ${why}`, "right");
      else tell("✗ Not yet.", "wrong");
    } catch (error) {
      tell(error.message, "wrong");
    }
  };
  const show = () => answer().then((right) => tell(`${plain(right)}. ${why}`, ""), (error) => tell(error.message, "wrong"));
  const form = el("form", { submit: (event) => { event.preventDefault(); check(); } }, input, el("button", { type: "submit" }, "Check"), button("Show", show), says);
  return el("li", {}, question, form);
}

/** 2,836,684,800 or 0.5 or 0,5 or 1/2. */
function numberOf(text) {
  const plain = text.replaceAll(/\s/g, "");
  const parts = (/^\d{1,3}(,\d{3})+$/.test(plain) ? plain.replaceAll(",", "") : plain.replace(",", ".")).split("/");
  return plain && parts.length <= 2 ? parts.map(Number).reduce((above, below) => above / below) : NaN;
}

const plain = (number) => (Number.isInteger(number) ? count(number) : String(number));
