// Small makers of elements, and numbers as people read them.

/** An element: `el("p", { class: "tell" }, "words", child)`. Properties that are functions listen. */
export function el(tag, properties = {}, ...children) {
  return fill(document.createElement(tag), properties, children);
}

/** The same in SVG. */
export function svg(tag, properties = {}, ...children) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), properties, children);
}

function fill(element, properties, children) {
  for (const [name, value] of Object.entries(properties)) {
    if (typeof value === "function") element.addEventListener(name, value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value != null) element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

export const button = (text, click, properties = {}) => el("button", { type: "button", click, ...properties }, text);

/** A labelled choice; `options` are `[value, text]`. The select is `.control`. */
export function choice(text, options, value, change) {
  const control = el("select", { change: () => change(control.value) });
  for (const [option, words] of options) control.append(el("option", { value: option }, words));
  control.value = value;
  return labelled(text, control);
}

/** A labelled slider that says its value in words. The input is `.control`. */
export function slider(text, { min, max, step = 1, value, say = String }, input) {
  const words = el("span");
  const control = el("input", { type: "range", min, max, step, input: () => { tell(); input(Number(control.value)); } });
  control.value = value;
  const tell = () => {
    words.textContent = say(Number(control.value));
    control.setAttribute("aria-valuetext", words.textContent);
  };
  tell();
  const label = labelled(el("span", {}, `${text}: `, words), control);
  label.set = (next) => { control.value = next; tell(); };
  return label;
}

/** A labelled box to tick. The input is `.control`. */
export function tick(text, checked, change) {
  const control = el("input", { type: "checkbox", change: () => change(control.checked) });
  control.checked = checked;
  return el("label", { class: "check" }, control, text);
}

/** Labels know their control. */
const labelled = (text, control) => el("label", {}, text, control);

/** A ledger: `bill(["box tests", "boxes"], ...)`; `.set({ boxes: "18" })`. */
export function bill(...entries) {
  const values = {};
  const list = el("dl", { class: "bill" });
  for (const [text, name] of entries) {
    values[name] = el("dd", { "data-value": name }, "–");
    list.append(el("div", {}, el("dt", {}, text), values[name]));
  }
  list.set = (found) => {
    for (const [name, value] of Object.entries(found)) values[name].textContent = value;
  };
  return list;
}

/** One line that is read out when it changes, but not at every pixel of a drag. */
export function tell() {
  const line = el("p", { class: "unseen", role: "status" });
  const seen = el("p", { class: "tell", "aria-hidden": "true" });
  const both = el("div", { class: "told" }, seen, line);
  let waiting;
  both.say = (text) => {
    seen.textContent = text;
    clearTimeout(waiting);
    waiting = setTimeout(() => { line.textContent = text; }, 250);
  };
  return both;
}

const whole = new Intl.NumberFormat("en-US", { maximumFractionDigits: 0 });
/** 40,000 */
export const count = (number) => whole.format(number);

/** Three digits that matter: 67.0, 3.80, 0.0123, 2.56 × 10⁻⁷; large ones whole. */
export function short(number) {
  if (!Number.isFinite(number)) return "–";
  if (number === 0) return "0";
  const text = Math.abs(number) >= 999.5 ? count(number) : number.toPrecision(3).replace(/e.*/, (e) => ` × 10${raised(Number(e.slice(1)))}`);
  return text.replace("-", "−");
}

const raised = (whole) => [...String(whole)].map((digit) => (digit === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit])).join("");

/** 12 µs, 3.4 ms, 5.6 s, 2.1 minutes. */
export function duration(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  if (seconds >= 172800) return `${short(seconds / 86400)} days`;
  if (seconds >= 7200) return `${short(seconds / 3600)} hours`;
  if (seconds >= 120) return `${short(seconds / 60)} minutes`;
  if (seconds >= 0.9995) return `${short(seconds)} s`;
  return seconds >= 0.9995e-3 ? `${short(seconds * 1e3)} ms` : `${short(seconds * 1e6)} µs`;
}

/** The value of a colour of the style sheet. */
export const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/** A canvas as sharp as the screen, as high as `tall(width)`. `paint(context, width, height)` draws when it must, in CSS pixels. */
export function board(properties, tall, paint) {
  const canvas = el("canvas", properties);
  const draw = () => {
    const width = canvas.clientWidth;
    if (!width) return;
    const height = tall(width);
    canvas.style.height = `${height}px`;
    const scale = Math.min(devicePixelRatio || 1, 3);
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
    const context = canvas.getContext("2d");
    context.setTransform(scale, 0, 0, scale, 0, 0);
    paint(context, width, height);
  };
  let asked = false;
  canvas.paint = () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; draw(); });
  };
  new ResizeObserver(canvas.paint).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", canvas.paint);
  return canvas;
}
