// The scene that the figures share, and the ways to another one: a list, a file, a drop.

import { ask } from "./lab.js";
import { read } from "./files.js";
import { board, choice, count, el } from "./dom.js";
import * as state from "./state.js";

const BUILT_IN = [
  ["bush", "a box bush, 40,000 triangles"],
  ["stadium", "a teapot in a stadium"],
  ["cornell", "the Cornell box"],
  ["terrain", "a terrain"],
  ["hairball", "a hairball"],
  ["sphere", "a sphere"],
  ["soup", "triangles at random"],
];
const USUAL = "bush";

/** The size of the pictures whose pixels are counted and walked. */
export const SIZE = [320, 180];
/** The picture comes from coarse to fine: until the last of these at once, the rest when the figures have their numbers. */
const COARSE = [[32, 18], [80, 45], [160, 90], SIZE];
const FINER = [[640, 360], [1280, 720]];
/** Milliseconds that the next picture may take, by the last: there are scenes of which a few pixels are work for minutes. */
const PATIENCE = 4000;
/** As the reader of files has it. */
const MOST_MEGABYTES = 512;

/** What is open: as the worker tells it, and the picture. Null until the first is. */
export let scene = null;
const listeners = [];
const pickers = [];
let opening = Promise.resolve();
/** Between a wish and its scene: the worker may have the new one already, which is not to be asked for what the old one still wants. */
let isOpening = false;

/** Calls `back` with each scene that is opened, and with the present one. */
export function onScene(back) {
  listeners.push(back);
  if (scene) back(scene);
}

/** Opens a built-in scene, or the bytes of a file, after whatever is being opened. */
export function open(name, bytes) {
  opening = opening.then(async () => {
    tell(`Opening ${name} …`);
    isOpening = true;
    try {
      const model = bytes && await read(name, bytes);
      const seen = await ask("open", model ? name : `builtin:${name}`, model);
      const title = bytes ? name : `builtin:${name}`;
      scene = { ...seen, title, named: bytes ? name.replaceAll(/[^\w.-]/g, "?") : title, ...await firstPicture() };
      performance.mark("first picture");
      if (!bytes && isListed(name)) state.set("scene", name);
      else state.forget("scene");
      tell([`${scene.title}: ${count(seen.triangles)} triangles.`, ...seen.warnings].join(" "));
      for (const picker of pickers) picker.chosen(bytes || !isListed(name) ? "" : name, scene.title);
      for (const listener of listeners) listener(scene);
    } catch (error) {
      tell(`${error.message}${scene ? ` — ${scene.title} stays` : ""}`, true);
    }
    isOpening = false;
    if (scene) refine(scene);
  });
  return opening;
}

/** As fine as patience allows, and what a pixel of it took in milliseconds. */
async function firstPicture() {
  let [picture, pace] = [null, 0];
  for (const [width, height] of COARSE) {
    if (pace * width * height > PATIENCE) break;
    const start = performance.now();
    picture = await traced([width, height]);
    pace = (performance.now() - start) / (width * height);
  }
  return { picture, pace };
}

async function traced(size) {
  const pixels = await ask("picture", size);
  return createImageBitmap(new ImageData(new Uint8ClampedArray(pixels.buffer), ...size));
}

/** Draws the picture of `shown` finer and finer, as long as it is the open scene. */
async function refine(shown) {
  for (const size of FINER.slice(shown.refined ?? 0)) {
    // Whatever the figures ask meanwhile comes first.
    await new Promise((done) => setTimeout(done, 300));
    if (isOpening || scene !== shown || shown.pace * size[0] * size[1] > PATIENCE) return;
    const picture = await traced(size).catch(() => null);
    if (scene !== shown || !picture) return;
    shown.picture = picture;
    shown.refined = (shown.refined ?? 0) + 1;
    for (const canvas of shows) canvas.paint();
  }
}

/** Boards that show the scene. */
const shows = new Set();

/** A board that is painted over the scene's picture, dimmed by `shade`, and again when the picture becomes finer. */
export function sceneBoard(properties, shade, paint) {
  const canvas = board(properties, (width) => (width * SIZE[1]) / SIZE[0], (context, width, height) => {
    if (!scene) return;
    // Pixels stay pixels, as long as there are fewer than on the screen.
    context.imageSmoothingEnabled = scene.picture.width > width;
    context.imageSmoothingQuality = "high";
    context.drawImage(scene.picture, 0, 0, width, height);
    context.fillStyle = `rgb(0 0 0 / ${shade})`;
    context.fillRect(0, 0, width, height);
    paint(context, width, height);
  });
  shows.add(canvas);
  return canvas;
}

/** Opens what the address says: `?open=NAME`, built in or the model that is served beside the page, else a built-in scene of the list. */
export async function openFirst() {
  const own = new URLSearchParams(location.search).get("open");
  if (own?.startsWith("builtin:")) return open(own.slice("builtin:".length));
  if (own) {
    const answer = await fetch("model").catch(() => null);
    if (answer?.ok) return open(own, new Uint8Array(await answer.arrayBuffer()));
  }
  const wanted = state.get("scene", USUAL);
  return open(isListed(wanted) ? wanted : USUAL);
}

const isListed = (name) => BUILT_IN.some(([one]) => one === name);

function tell(text, bad = false) {
  for (const picker of pickers) {
    picker.line.textContent = text;
    picker.line.className = bad ? "says" : "";
  }
}

/** A choice of scenes with a way in for the reader's own; `.line` tells what became of it. */
export function picker() {
  const list = choice("Scene", [...BUILT_IN.map(([name, about]) => [name, about]), ["file", "a file of yours …"]], state.get("scene", USUAL), (name) => {
    if (name === "file") input.click();
    else open(name);
  });
  const input = el("input", { type: "file", accept: ".obj,.ply,.stl,.glb,.gltf", hidden: true, "aria-label": "a scene file", change: () => take(input.files[0]) });
  const line = el("p", { role: "status" });
  const one = {
    element: el("span", {}, list, input),
    line,
    chosen: (name, title) => {
      list.control.querySelector("[value=own]")?.remove();
      if (!name) list.control.prepend(el("option", { value: "own" }, title));
      list.control.value = name || "own";
    },
  };
  pickers.push(one);
  return one;
}

async function take(file) {
  if (!file) return;
  if (file.size > MOST_MEGABYTES << 20) return tell(`${file.name} has ${count(file.size / (1 << 20))} MiB: the page reads files of up to ${MOST_MEGABYTES}. The command line reads larger ones.`, true);
  const bytes = await file.arrayBuffer().catch(() => null);
  if (!bytes) return tell(`${file.name} cannot be read: is it a folder, or no longer there?`, true);
  await open(file.name, new Uint8Array(bytes));
  for (const one of pickers) one.chosen(scene?.title.startsWith("builtin:") ? scene.title.slice(8) : "", scene?.title ?? "");
}

/** Lets files be dropped anywhere on the page. They stay on this machine. */
export function acceptDrops() {
  const mark = (on) => document.body.classList.toggle("drop", on);
  addEventListener("dragover", (event) => { event.preventDefault(); mark(true); });
  addEventListener("dragleave", (event) => { if (!event.relatedTarget) mark(false); });
  addEventListener("drop", (event) => { event.preventDefault(); mark(false); take(event.dataTransfer.files[0]); });
}

/** The camera as arguments of the command line. */
export function cameraFlags({ camera: { eye, target, up, fov } }) {
  return `--vp ${eye} --vi ${target} --vu ${up} --fov ${fov}`;
}
