// From the scene to the picture, by the camera that Boxwood used: only for lines drawn over pictures.

const minus = (a, b) => a.map((x, k) => x - b[k]);
const dot = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.hypot(...a));

/** A function from two points to the ends of their line in a picture `width` x `height`, or null if it is behind the eye. */
export function projector({ eye, target, up, fov }, width, height) {
  const forward = unit(minus(target, eye));
  const right = unit(cross(forward, up));
  const above = cross(right, forward);
  const scale = height / 2 / Math.tan((fov * Math.PI) / 360);
  const seen = (point) => {
    const way = minus(point, eye);
    return [dot(way, right), dot(way, above), dot(way, forward)];
  };
  const flat = ([x, y, depth]) => [width / 2 + (scale * x) / depth, height / 2 - (scale * y) / depth];
  return (from, to) => {
    let [a, b] = [seen(from), seen(to)];
    const near = 1e-4 * Math.max(Math.abs(a[2]), Math.abs(b[2]));
    if (a[2] < near && b[2] < near) return null;
    const cut = (p, q) => p.map((x, k) => x + ((q[k] - x) * (near - p[2])) / (q[2] - p[2]));
    if (a[2] < near) a = cut(a, b);
    if (b[2] < near) b = cut(b, a);
    return [flat(a), flat(b)];
  };
}

/** The twelve edges of a box. */
export function edges([low, high]) {
  const corner = (i) => [0, 1, 2].map((k) => (i >> k & 1 ? high : low)[k]);
  const pairs = [];
  for (let i = 0; i < 8; i++) for (let k = 0; k < 3; k++) if (!(i >> k & 1)) pairs.push([corner(i), corner(i | 1 << k)]);
  return pairs;
}
