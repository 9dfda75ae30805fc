// The scene that the figures share, and the ways to another one: a list, a file, a drop.

import { ask } from "./lab.js";
import { choice, count, el } from "./dom.js";
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

/** The size of the shared pictures. */
export const SIZE = [320, 180];

/** What is open: as the worker tells it, and the picture. Null until the first is. */
export let scene = null;
const listeners = [];
const pickers = [];
let opening = Promise.resolve();

/** Calls `back` with each scene that is opened, and with the present one. */
export function onScene(back) {
  listeners.push(back);
  if (scene) back(scene);
}

/** Opens a built-in scene, or the bytes of a file, after whatever is being opened. */
export function open(name, bytes) {
  opening = opening.then(async () => {
    tell(`Opening ${name} …`);
    try {
      const seen = await ask("open", bytes ? name : `builtin:${name}`, bytes);
      const pixels = await ask("picture", SIZE);
      const picture = await createImageBitmap(new ImageData(new Uint8ClampedArray(pixels.buffer), ...SIZE));
      scene = { ...seen, title: bytes ? name : `builtin:${name}`, picture };
      if (!bytes) state.set("scene", name);
      tell([`${scene.title}: ${count(seen.triangles)} triangles.`, ...seen.warnings].join(" "));
      for (const picker of pickers) picker.chosen(bytes ? "" : name, scene.title);
      for (const listener of listeners) listener(scene);
    } catch (error) {
      tell(`${error.message}${scene ? ` — ${scene.title} stays` : ""}`, true);
    }
  });
  return opening;
}

/** Opens what the address says. */
export function openFirst() {
  const wanted = state.get("scene", USUAL);
  return open(BUILT_IN.some(([name]) => name === wanted) ? wanted : USUAL);
}

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
  await open(file.name, new Uint8Array(await file.arrayBuffer()));
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
