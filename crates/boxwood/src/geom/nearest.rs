//! The place of a surface that is nearest to a point.
//!
//! The nearest place of a triangle is the foot of the point on its plane, if that lies inside, else it is on an edge or a corner
//! (Ericson, *Real-Time Collision Detection*, 2005, 5.1.5). All seven candidates are places of the triangle, kept in its box
//! whatever rounding does to them, so the least distance is taken instead of deciding by signs, which slivers would deceive. In
//! double precision products of single-precision coordinates neither overflow nor underflow.

use super::Triangle;

/// Where a surface is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The place: `(1 - u - v) * v0 + u * v1 + v * v2`, rounded.
    pub point: [f32; 3],
    /// From the point to the place, never negative.
    pub distance: f32,
    /// Weight of the second vertex, 0..=1.
    pub u: f32,
    /// Weight of the third vertex, 0..=1.
    pub v: f32,
    /// Primitive within its geometry.
    pub prim: u32,
    /// Geometry (mesh) within the scene, in the order added.
    pub geom: u32,
}

/// What a triangle answers, before ids are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Distance, squared.
    pub squared: f64,
    /// Weight of the second vertex.
    pub u: f64,
    /// Weight of the third vertex.
    pub v: f64,
}

impl Triangle {
    /// The place that is nearest to `point`. Both finite.
    pub fn nearest(&self, point: &[f32; 3]) -> Foot {
        let [a, b, c] = self.0;
        let (ab, ac, bc) = (minus(&b, &a), minus(&c, &a), minus(&c, &b));
        let (ap, bp) = (minus(point, &a), minus(point, &b));
        let (on_ab, on_ac, on_bc) = (along(&ab, &ap), along(&ac, &ap), along(&bc, &bp));
        let rim = [
            [0.0, 0.0],
            [1.0, 0.0],
            [0.0, 1.0],
            [on_ab, 0.0],
            [0.0, on_ac],
            [1.0 - on_bc, on_bc],
        ];
        let places = rim.into_iter().chain(inside(&ab, &ac, &ap));
        places.fold(self.foot(point, [0.0, 0.0]), |best, weights| {
            let foot = self.foot(point, weights);
            if foot.squared < best.squared {
                foot
            } else {
                best
            }
        })
    }

    fn foot(&self, point: &[f32; 3], [u, v]: [f64; 2]) -> Foot {
        let place = self.place(u, v);
        let off: [f64; 3] = std::array::from_fn(|k| f64::from(point[k]) - place[k]);
        let squared = dot(&off, &off);
        Foot { squared, u, v }
    }

    /// A place by its weights, in the triangle's box: so no box is farther than what it holds.
    pub(crate) fn place(&self, u: f64, v: f64) -> [f64; 3] {
        std::array::from_fn(|k| {
            let [a, b, c] = self.0.map(|corner| f64::from(corner[k]));
            let place = (1.0 - u - v) * a + u * b + v * c;
            place.clamp(a.min(b).min(c), a.max(b).max(c))
        })
    }
}

fn minus(a: &[f32; 3], b: &[f32; 3]) -> [f64; 3] {
    std::array::from_fn(|k| f64::from(a[k]) - f64::from(b[k]))
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The share of an edge where its point nearest to `p` lies, both from the edge's start.
fn along(edge: &[f64; 3], p: &[f64; 3]) -> f64 {
    let length = dot(edge, edge);
    if length > 0.0 {
        (dot(edge, p) / length).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// The weights of the foot on the plane, if it lies inside.
fn inside(ab: &[f64; 3], ac: &[f64; 3], ap: &[f64; 3]) -> Option<[f64; 2]> {
    let (bb, bc, cc) = (dot(ab, ab), dot(ab, ac), dot(ac, ac));
    let (bp, cp) = (dot(ab, ap), dot(ac, ap));
    let area = bb * cc - bc * bc;
    let (u, v) = ((cc * bp - bc * cp) / area, (bb * cp - bc * bp) / area);
    (area > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some([u, v])
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Triangle = Triangle([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);

    #[test]
    fn each_region_has_its_place() {
        for (point, place, squared) in [
            ([0.25, 0.25, 2.0], [0.25, 0.25, 0.0], 4.0),
            ([-1.0, -1.0, 0.0], [0.0, 0.0, 0.0], 2.0),
            ([3.0, -1.0, 0.0], [1.0, 0.0, 0.0], 5.0),
            ([-1.0, 3.0, 0.0], [0.0, 1.0, 0.0], 5.0),
            ([0.5, -2.0, 0.0], [0.5, 0.0, 0.0], 4.0),
            ([-2.0, 0.5, 0.0], [0.0, 0.5, 0.0], 4.0),
            ([1.0, 1.0, 0.0], [0.5, 0.5, 0.0], 0.5),
        ] {
            let foot = UNIT.nearest(&point);
            assert_eq!((UNIT.place(foot.u, foot.v), foot.squared), (place, squared));
        }
    }

    #[test]
    fn triangles_without_area_are_edges_or_points() {
        let [p, q] = [[1.0, 2.0, 3.0], [3.0, 2.0, 3.0]];
        for corners in [[p, p, q], [p, q, p], [p, q, q], [q, [2.0, 2.0, 3.0], p]] {
            let triangle = Triangle(corners);
            let foot = triangle.nearest(&[1.5, 3.0, 3.0]);
            assert_eq!(
                triangle.place(foot.u, foot.v),
                [1.5, 2.0, 3.0],
                "{corners:?}"
            );
            assert_eq!(foot.squared, 1.0);
        }
        let foot = Triangle([p; 3]).nearest(&q);
        assert_eq!((foot.squared, foot.u, foot.v), (4.0, 0.0, 0.0));
    }

    #[test]
    fn neither_the_largest_nor_the_smallest_numbers_break_it() {
        for scale in [1e-38, 1e-20, 1.0, 1e15, 1e30_f32] {
            let corners = UNIT.0.map(|corner| corner.map(|x| x * scale));
            let foot = Triangle(corners).nearest(&[0.25 * scale, 0.25 * scale, 2.0 * scale]);
            let expected = f64::from(2.0 * scale).powi(2);
            assert!((foot.squared / expected - 1.0).abs() < 1e-6, "{scale}");
        }
    }

    #[test]
    fn a_corner_near_by_is_found_though_another_is_beyond_all_bounds() {
        let triangle = Triangle([[1e30, -1e30, 1e30], [1.0, 2.0, 3.0], [-1e30, 0.0, 1e29]]);
        let foot = triangle.nearest(&[1.0, 2.0, 2.5]);
        assert!(foot.squared <= 0.25, "{foot:?}");
    }
}
