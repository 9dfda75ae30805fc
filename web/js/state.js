// The state of all figures in the address, so that it can be shared: `#v=1&scene=bush&walk.px=160,90`.

const VERSION = "1";
const values = new URLSearchParams(location.hash.slice(1));
if (values.get("v") !== VERSION) for (const name of [...values.keys()]) values.delete(name);

let waiting;
function write() {
  clearTimeout(waiting);
  // Browsers allow few changes of the address a second.
  waiting = setTimeout(() => {
    values.delete("v");
    const rest = values.toString().replaceAll("%2C", ",").replaceAll("%3A", ":");
    history.replaceState(null, "", rest ? `#v=${VERSION}&${rest}` : location.pathname + location.search);
  }, 200);
}

/** What the address says, or `usual`. */
export const get = (name, usual) => values.get(name) ?? usual;

/** The same for a whole number within bounds. */
export function getWhole(name, usual, min, max) {
  const text = values.get(name);
  const number = text === null ? NaN : Number(text);
  return Number.isInteger(number) && number >= min && number <= max ? number : usual;
}

/** The same for a list of numbers of the usual length. */
export function getList(name, usual) {
  const list = values.get(name)?.split(",").map(Number);
  return list?.length === usual.length && list.every(Number.isFinite) ? list : [...usual];
}

/** Keeps a value in the address. */
export function set(name, value) {
  values.set(name, String(value));
  write();
}

/** Forgets a value. */
export function forget(name) {
  values.delete(name);
  write();
}

/** Forgets all values of one figure. */
export function reset(figure) {
  for (const name of [...values.keys()]) if (name.startsWith(`${figure}.`)) values.delete(name);
  write();
}

/** Calls `back` when the reader follows a link with another state. */
export function onChange(back) {
  addEventListener("hashchange", () => { if (location.hash.startsWith("#v=")) back(); });
}
