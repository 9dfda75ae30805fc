// Runs Boxwood. One question at a time, in order; long work is asked for in pieces, so that others get their turn.

/** A function that returns a 128-bit vector: valid only where these exist. */
const SIMD = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11]);
const wanted = new URLSearchParams(self.location.search).get("wasm");
const form = wanted === "plain" || !WebAssembly.validate(SIMD) ? "plain" : "simd";

const boxwood = import(`../wasm/${form}.js`).then(async (module) => {
  const { memory } = await module.default();
  return { ...module, memory };
});
boxwood.catch(() => {}); // told with each answer

let lab = null;
let size = [320, 180];
/** Milliseconds of each build, by its number. */
let times = [];

function the() {
  if (!lab) throw new Error("no scene is open yet");
  return lab;
}

/** Turns the camera to pictures of another size, where it is not. */
function look([width, height]) {
  if (size[0] !== width || size[1] !== height) the().look(width, height);
  size = [width, height];
}

const questions = {
  /** Opens a scene in place of the last; that one stays if this one is broken. */
  open: ({ Lab }, name, model) => {
    const next = new Lab(name, model);
    lab?.free();
    [lab, size, times] = [next, [320, 180], []];
    return { ...JSON.parse(lab.seen()), form };
  },
  /** `ms` is what building took, the first time; later it is found built. */
  build: (_, structure, builder = "binned") => {
    let start = performance.now();
    const built = JSON.parse(the().build(structure, builder));
    if (built.number === 0 && times[0] === undefined) {
      // It was there from the beginning, unclocked.
      start = performance.now();
      lab.rebuild(0);
    }
    times[built.number] ??= performance.now() - start;
    return { ...built, ms: times[built.number] };
  },
  nodes: (_, number, depth) => the().nodes(number, depth),
  picture: (_, shape) => the().picture(...shape),
  steps: (_, number, limit) => JSON.parse(the().steps(number, limit)),
  heat: (_, shape, number, y, rows) => { look(shape); return the().heat(number, y, rows); },
  /** The clock runs inside, so that messages cost nothing. */
  shoot: (_, shape, number, y, rows) => {
    look(shape);
    const start = performance.now();
    const shot = JSON.parse(the().shoot(number, y, rows));
    return { ...shot, ms: performance.now() - start };
  },
  walk: (_, shape, number, x, y) => { look(shape); return JSON.parse(the().walk(number, x, y)); },
  hash: (_, number, rays, seed) => the().hash(number, rays, seed),
  price: ({ price }, ...numbers) => JSON.parse(price(...numbers)),
  test: ({ test }, numbers) => JSON.parse(test(new Float32Array(numbers))),
  volumes: ({ volumes }, walls, ...numbers) => JSON.parse(volumes(new Float32Array(walls), ...numbers)),
  grid: ({ grid_walk }, walls, columns, ray) => JSON.parse(grid_walk(new Float32Array(walls), columns, new Float32Array(ray))),
  heatScale: ({ heat_scale }, counts) => JSON.parse(heat_scale(counts)),
  heatCodes: ({ heat_codes }, counts, top, log) => heat_codes(counts, top, log),
  names: ({ names }) => JSON.parse(names()),
  heap: ({ memory }) => memory.buffer.byteLength,
};

self.addEventListener("message", async ({ data: { id, question, args } }) => {
  try {
    const value = questions[question](await boxwood, ...args);
    self.postMessage({ id, value }, value?.buffer instanceof ArrayBuffer ? [value.buffer] : []);
  } catch (error) {
    self.postMessage({ id, error: error instanceof Error ? error.message : String(error) });
  }
});
