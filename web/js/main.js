// Puts the figures in their places, and keeps the page alive where Boxwood cannot run.

import { ask } from "./lab.js";
import { acceptDrops, onScene, openFirst, scene } from "./scenes.js";
import { onChange } from "./state.js";
import boxes from "./figures/boxes.js";
import build from "./figures/build.js";
import exercises from "./figures/exercises.js";
import grid from "./figures/grid.js";
import heat from "./figures/heat.js";
import price from "./figures/price.js";
import race from "./figures/race.js";
import split from "./figures/split.js";
import triangle from "./figures/triangle.js";
import walk from "./figures/walk.js";

const FIGURES = { boxes, build, exercises, grid, heat, price, race, split, triangle, walk };
const engine = document.getElementById("engine");

/** Replaces the still text of each figure by the figure. */
function enliven() {
  for (const place of document.querySelectorAll("[data-figure]")) {
    const name = place.dataset.figure;
    const still = place.querySelector(".still");
    const body = document.createElement("div");
    const caption = place.querySelector("figcaption");
    if (caption) {
      caption.id = `${name}-caption`;
      place.setAttribute("aria-labelledby", caption.id);
    }
    still.replaceWith(body);
    FIGURES[name](body);
  }
}

/** One section at a time, for a projector. */
function present() {
  const sections = [...document.querySelectorAll("main > section")];
  let at = Math.max(0, sections.findIndex((section) => `#${section.id}` === location.hash));
  const place = Object.assign(document.createElement("p"), { className: "place" });
  document.body.append(place);
  const show = (next) => {
    at = Math.min(Math.max(next, 0), sections.length - 1);
    sections.forEach((section, i) => section.classList.toggle("shown", i === at));
    place.textContent = `${at + 1} of ${sections.length} · Page Up, Page Down`;
    scrollTo(0, 0);
  };
  document.body.classList.add("present");
  addEventListener("keydown", (event) => {
    if (event.key === "PageDown") show(at + 1);
    else if (event.key === "PageUp") show(at - 1);
    else return;
    event.preventDefault();
  });
  show(at);
}

/** Links within the page leave the address alone: it holds the state of the figures. */
function keepAddress() {
  document.addEventListener("click", (event) => {
    const to = event.target.closest?.("a[href^='#']")?.hash;
    if (!to) return;
    event.preventDefault();
    const heading = document.querySelector(`${to} h2`);
    heading.tabIndex = -1;
    heading.focus({ preventScroll: true });
    heading.scrollIntoView();
  });
}

/** Where there is no WebAssembly. */
function standStill() {
  engine.textContent = "WebAssembly does not run in this browser, so the figures stand still; the text, its numbers and the commands are all here.";
  engine.className = "bad";
  // Scripts run here, so the browser hides what is for readers without them.
  for (const hidden of document.querySelectorAll("noscript.picture")) hidden.insertAdjacentHTML("afterend", hidden.textContent);
  document.documentElement.dataset.ready = "still";
}

async function start() {
  try {
    await ask("names");
  } catch {
    return standStill();
  }
  enliven();
  keepAddress();
  acceptDrops();
  onChange(() => location.reload());
  onScene(({ form, instructions }) => {
    engine.replaceChildren(
      "Every figure runs ", Object.assign(document.createElement("a"), { href: "#own", textContent: "Boxwood" }),
      ` itself, compiled to WebAssembly (${form === "simd" ? "with" : "without"} vector instructions: ${instructions}), on your machine. Nothing is sent anywhere.`);
    document.documentElement.dataset.ready = form;
  });
  await openFirst();
  if (!scene) engine.textContent = "The first scene could not be opened: choose another below.";
}

if (new URLSearchParams(location.search).has("present")) present();
start();
