// The transport of figures that go step by step: buttons, a slider, and the arrow keys on it.

import { button, el } from "./dom.js";

/** `show(step)` is called with 0 to `length`; `.length(n)` sets how many there are, `.to(step)` goes there. */
export function stepper(label, show) {
  let [at, most] = [0, 0];
  const words = el("span");
  const range = el("input", { type: "range", min: 0, max: 0, step: 1, "aria-label": label, input: () => to(Number(range.value)), keydown: leap });
  const ends = [button("|◀", () => to(0), { "aria-label": "to the start" }), button("◀", () => to(at - 1), { "aria-label": "one step back" })];
  const ons = [button("▶", () => to(at + 1), { "aria-label": "one step on" }), button("▶|", () => to(most), { "aria-label": "to the end" })];
  const element = el("div", { class: "bar" }, ...ends, ...ons, el("label", { class: "grow" }, words, range));

  /** Shift makes ten steps of one. */
  function leap(event) {
    const way = { ArrowRight: 10, ArrowUp: 10, ArrowLeft: -10, ArrowDown: -10 }[event.key];
    if (!event.shiftKey || !way) return;
    event.preventDefault();
    to(at + way);
  }

  function to(next) {
    at = Math.min(Math.max(next, 0), most);
    range.value = at;
    range.setAttribute("aria-valuetext", `step ${at} of ${most}`);
    words.textContent = `step ${at} of ${most}`;
    for (const end of ends) end.disabled = at === 0;
    for (const on of ons) on.disabled = at === most;
    show(at);
  }

  return { element, to, length: (n) => { most = n; range.max = n; } };
}

/** Lines of pseudo-code of which one is at work: `.run(2)`. */
export function program(...lines) {
  const items = lines.map((text) => el("li", {}, text));
  const list = el("ol", { class: "lines", "aria-label": "the algorithm" }, ...items);
  list.run = (now) => items.forEach((item, i) => {
    item.classList.toggle("now", i === now);
    if (i === now) item.setAttribute("aria-current", "step");
    else item.removeAttribute("aria-current");
  });
  return list;
}
