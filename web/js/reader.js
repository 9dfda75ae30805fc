// Reads one file.

import start, { read } from "../wasm/files.js";

self.addEventListener("message", async ({ data: { name, bytes } }) => {
  try {
    await start();
    const model = read(name, bytes);
    self.postMessage({ model }, [model.buffer]);
  } catch (error) {
    // What is not an exception of ours is a trap: it has no words for the reader.
    const told = error instanceof WebAssembly.RuntimeError || error instanceof RangeError;
    self.postMessage({ error: told ? `${name} could not be read: is there memory for it?` : error.message });
  }
});
