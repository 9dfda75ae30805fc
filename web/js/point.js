// Where a hand or the arrow keys point.

/** Answers arrow keys with `by(right, up)`: so many units each, more with shift. */
export const arrows = (unit, more, by) => (event) => {
  const step = event.shiftKey ? more : unit;
  const way = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key];
  if (!way) return;
  event.preventDefault();
  by(...way);
};

/** Where in `[left, top, width, height]`, which `element` shows, the pointer is: right and down. */
export function placeOf(event, element, [left, top, width, height]) {
  const box = element.getBoundingClientRect();
  return [left + ((event.clientX - box.left) / box.width) * width, top + ((event.clientY - box.top) / box.height) * height];
}

/** Listeners of a handle: while it is held, `by(event)` hears of each move. */
export const held = (by) => ({
  pointerdown: (event) => event.target.setPointerCapture(event.pointerId),
  pointermove: (event) => { if (event.target.hasPointerCapture(event.pointerId)) by(event); },
});
