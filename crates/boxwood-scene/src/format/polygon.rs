//! Polygons to triangles: always `n - 2` of them, which cover the polygon if it is flat and simple.
//!
//! Convex polygons become a fan about their first corner, as all readers do it. Concave ones are cut by ears (Eberly,
//! "Triangulation by Ear Clipping", 2002). A polygon that has no ear, since it crosses itself or is not flat, loses
//! its next corner instead, so that the count holds whatever the input. Corners on a straight line are kept: a
//! neighbour may use them, and leaving them out would open a crack.

/// Cuts polygons; keeps its memory from one to the next.
#[derive(Debug)]
pub(crate) struct Triangulator {
    work_left: u64,
    flat: Vec<[f64; 2]>,
    next: Vec<usize>,
}

/// Point-in-triangle tests for one file, about two seconds. A hostile file could ask for the square of its length.
const WORK: u64 = 400_000_000;

impl Default for Triangulator {
    fn default() -> Self {
        Self {
            work_left: WORK,
            flat: Vec::new(),
            next: Vec::new(),
        }
    }
}

impl Triangulator {
    /// Calls `emit` with the corners of each triangle, as indices into `polygon`. Fewer than three corners give none.
    pub(crate) fn cut(&mut self, polygon: &[[f32; 3]], mut emit: impl FnMut([usize; 3])) {
        let n = polygon.len();
        if n > 3 && self.work_left > 0 {
            flatten(polygon, &mut self.flat);
            if !is_convex(&self.flat) {
                return self.clip_ears(n, emit);
            }
        }
        for i in 1..n.saturating_sub(1) {
            emit([0, i, i + 1]);
        }
    }

    /// True if a polygon may have been cut badly because the work for this file was used up.
    pub(crate) fn gave_up(&self) -> bool {
        self.work_left == 0
    }

    fn clip_ears(&mut self, n: usize, mut emit: impl FnMut([usize; 3])) {
        self.next.clear();
        self.next.extend((1..n).chain([0]));
        // The corner before the one looked at; corners refused since the last ear; corners left.
        let (mut before, mut refused, mut left) = (n - 1, 0, n);
        while left > 3 {
            let corner = self.next[before];
            let after = self.next[corner];
            if self.work_left > 0 && refused < left && !self.is_ear(before, corner, after) {
                (before, refused) = (corner, refused + 1);
                continue;
            }
            emit([before, corner, after]);
            self.next[before] = after;
            (refused, left) = (0, left - 1);
            // Going on behind the ear keeps the triangles from all sharing one corner.
            before = after;
        }
        let corner = self.next[before];
        emit([before, corner, self.next[corner]]);
    }

    /// Can `corner` be cut off? It must turn left, and no other corner may lie in the triangle.
    fn is_ear(&mut self, before: usize, corner: usize, after: usize) -> bool {
        let [a, b, c] = [before, corner, after].map(|i| self.flat[i]);
        self.work_left = self.work_left.saturating_sub(1);
        if area2(a, b, c) <= 0.0 {
            return false;
        }
        let mut other = self.next[after];
        while other != before && self.work_left > 0 {
            self.work_left = self.work_left.saturating_sub(1);
            let p = self.flat[other];
            // A polygon with a hole visits the corners of its bridge twice: the twin of a corner is not inside.
            let twin = p == a || p == b || p == c;
            if !twin && area2(a, b, p) >= 0.0 && area2(b, c, p) >= 0.0 && area2(c, a, p) >= 0.0 {
                return false;
            }
            other = self.next[other];
        }
        true
    }
}

/// Twice the area of `abc`, positive if it turns left.
fn area2(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Drops the axis along which the polygon's normal (Newell's sum) is longest, so that it turns left.
fn flatten(polygon: &[[f32; 3]], flat: &mut Vec<[f64; 2]>) {
    let origin = polygon[0].map(f64::from);
    let local = |p: [f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) - origin[k]);
    let mut normal = [0.0; 3];
    for (i, &p) in polygon.iter().enumerate() {
        let (p, q) = (local(p), local(polygon[(i + 1) % polygon.len()]));
        for (k, n) in normal.iter_mut().enumerate() {
            let (y, z) = ((k + 1) % 3, (k + 2) % 3);
            *n += p[y] * q[z] - p[z] * q[y];
        }
    }
    let longest = (0..3).fold(0, |best, k| {
        if normal[k].abs() > normal[best].abs() {
            k
        } else {
            best
        }
    });
    let (mut x, mut y) = ((longest + 1) % 3, (longest + 2) % 3);
    if normal[longest] < 0.0 {
        (x, y) = (y, x);
    }
    flat.clear();
    flat.extend(polygon.iter().map(|&p| local(p)).map(|p| [p[x], p[y]]));
}

/// Does no corner turn right?
fn is_convex(flat: &[[f64; 2]]) -> bool {
    let n = flat.len();
    (0..n).all(|i| area2(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(polygon: &[[f32; 3]]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::new();
        Triangulator::default().cut(polygon, |triangle| triangles.push(triangle));
        triangles
    }

    /// The sum of the triangles' areas without sign, and the polygon's own area.
    fn areas(polygon: &[[f32; 3]]) -> (f64, f64) {
        let mut flat = Vec::new();
        flatten(polygon, &mut flat);
        let parts = cut(polygon)
            .iter()
            .map(|&[a, b, c]| area2(flat[a], flat[b], flat[c]).abs())
            .sum();
        let n = flat.len();
        let whole: f64 = (0..n)
            .map(|i| area2([0.0; 2], flat[i], flat[(i + 1) % n]))
            .sum();
        (parts, whole)
    }

    #[test]
    fn convex_polygons_become_fans_about_the_first_corner() {
        let quad = [
            [0.0, 0.0, 1.0],
            [2.0, 0.0, 1.0],
            [2.5, 1.0, 1.0],
            [0.0, 3.5, 1.0],
        ];
        assert_eq!(cut(&quad), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(cut(&quad[..3]), [[0, 1, 2]]);
        assert!(cut(&quad[..2]).is_empty() && cut(&[]).is_empty());
    }

    #[test]
    fn concave_polygons_are_covered_exactly_in_every_plane_and_sense() {
        // An arrow head, a comb, and a square with a square hole reached over a bridge.
        let arrow = vec![[0.0, 0.0], [4.0, -3.0], [1.0, 0.0], [4.0, 3.5]];
        let comb: Vec<[f32; 2]> = [[0.0, 0.0], [9.0, 0.0]]
            .into_iter()
            .chain((0..9).flat_map(|i| [[9.0 - i as f32, 5.0], [8.5 - i as f32, 1.0]]))
            .collect();
        let holed = vec![
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 5.0],
            [0.0, 5.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ];
        for flat in [arrow, comb, holed] {
            for axis in 0..3 {
                for reversed in [false, true] {
                    let mut polygon: Vec<[f32; 3]> = flat
                        .iter()
                        .map(|p| {
                            let mut q = [7.0; 3];
                            (q[(axis + 1) % 3], q[(axis + 2) % 3]) = (p[0], p[1]);
                            q
                        })
                        .collect();
                    if reversed {
                        polygon.reverse();
                    }
                    assert_eq!(cut(&polygon).len(), polygon.len() - 2);
                    let (parts, whole) = areas(&polygon);
                    assert!(
                        (parts - whole).abs() < 1e-9,
                        "{parts} for {whole}: {polygon:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn degenerate_polygons_still_give_n_minus_two() {
        let point = [[1.0, 2.0, 3.5]; 7];
        let line: Vec<[f32; 3]> = (0..9).map(|i| [(i * 5 % 9) as f32, 0.0, 0.0]).collect();
        let crossing = [
            [0.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.3, 2.0, 1.0],
        ];
        let huge = [
            [3e38, 0.0, 0.0],
            [-3e38, 1.0, 0.0],
            [3e38, 2e38, -3e38],
            [0.0, -3e38, 3e38],
            [1.0, 1.0, 1.0],
        ];
        for polygon in [&point[..], &line, &crossing, &huge] {
            let triangles = cut(polygon);
            assert_eq!(triangles.len(), polygon.len() - 2);
            assert!(
                triangles
                    .iter()
                    .all(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
            );
        }
    }

    #[test]
    fn a_hostile_polygon_ends_soon() {
        // A spiral comb in which almost no corner is an ear.
        let polygon: Vec<[f32; 3]> = (0..60_000)
            .map(|i| {
                let (tooth, side) = ((i / 2) as f32, (i % 2) as f32);
                [tooth, side * tooth * tooth, 0.0]
            })
            .collect();
        let mut triangulator = Triangulator {
            work_left: 1_000_000,
            ..Triangulator::default()
        };
        let mut count = 0;
        triangulator.cut(&polygon, |_| count += 1);
        assert_eq!(count, polygon.len() - 2);
    }
}
