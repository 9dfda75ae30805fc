// The way to the worker that runs Boxwood: each call is a promise.

const worker = new Worker(new URL("worker.js" + location.search, import.meta.url), { type: "module" });
const waiting = new Map();
let calls = 0;

worker.addEventListener("message", ({ data: { id, value, error } }) => {
  const { resolve, reject } = waiting.get(id) ?? {};
  waiting.delete(id);
  if (error !== undefined) reject?.(new Error(error));
  else resolve?.(value);
});

worker.addEventListener("error", (event) => {
  event.preventDefault();
  for (const { reject } of waiting.values()) reject(new Error("the worker stopped: reload the page"));
  waiting.clear();
});

/** Asks the worker; its answers come in the order of the questions. */
export function ask(question, ...args) {
  return new Promise((resolve, reject) => {
    const id = ++calls;
    waiting.set(id, { resolve, reject });
    worker.postMessage({ id, question, args });
  });
}
