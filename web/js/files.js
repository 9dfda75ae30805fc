// A reader's own file becomes a model, in a worker that lives as long as that takes: what a broken file may do ends with it.

/** The model in `bytes`, for the lab. */
export function read(name, bytes) {
  const worker = new Worker(new URL("reader.js", import.meta.url), { type: "module" });
  return new Promise((resolve, reject) => {
    worker.addEventListener("message", ({ data: { model, error } }) => (model ? resolve(model) : reject(new Error(error))));
    worker.addEventListener("error", (event) => {
      event.preventDefault();
      reject(new Error(`${name} could not be read: is there memory for it?`));
    });
    worker.postMessage({ name, bytes }, [bytes.buffer]);
  }).finally(() => worker.terminate());
}
