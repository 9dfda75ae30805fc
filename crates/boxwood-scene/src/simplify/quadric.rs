//! The squared distance to a set of planes, as one quadratic form.

use std::ops::Add;

use glam::{DMat3, DVec3};

/// `w * x^T A x + 2 b^T x + c`: the weighted sum of squared distances from `x` to planes (Garland & Heckbert, 3.4).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quadric {
    /// The upper triangle of A: xx, xy, xz, yy, yz, zz.
    a: [f64; 6],
    b: DVec3,
    c: f64,
    weight: f64,
}

impl Quadric {
    /// The plane through `point` with the unit `normal`.
    pub(super) fn of_plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let n = normal;
        let d = -n.dot(point);
        Self {
            a: [
                n.x * n.x,
                n.x * n.y,
                n.x * n.z,
                n.y * n.y,
                n.y * n.z,
                n.z * n.z,
            ]
            .map(|x| x * weight),
            b: n * (d * weight),
            c: d * d * weight,
            weight,
        }
    }

    /// Sum of the weights of its planes.
    pub(super) fn weight(&self) -> f64 {
        self.weight
    }

    /// The sum of squared distances at `x`, never negative.
    pub(super) fn at(&self, x: DVec3) -> f64 {
        (x.dot(self.matrix() * x) + 2.0 * self.b.dot(x) + self.c).max(0.0)
    }

    /// Where an edge from `p` to `q` should collapse to, and what that costs.
    ///
    /// The minimum of the form, if it is well defined and near the edge; else the best of both ends and the middle.
    pub(super) fn best_place(&self, p: DVec3, q: DVec3) -> (DVec3, f64) {
        let middle = (p + q) * 0.5;
        let ends = [p, q, middle].map(|x| (x, self.at(x)));
        let [mut best, others @ ..] = ends;
        for other in others {
            if other.1 < best.1 {
                best = other;
            }
        }
        match self.minimum() {
            Some(x)
                if x.distance_squared(middle) <= p.distance_squared(q) && self.at(x) < best.1 =>
            {
                (x, self.at(x))
            }
            _ => best,
        }
    }

    /// `None` where the planes have a line or a plane in common, or nearly so.
    fn minimum(&self) -> Option<DVec3> {
        let matrix = self.matrix();
        let size = (self.a[0] + self.a[3] + self.a[5]) / 3.0;
        let well_posed = matrix.determinant() > 1e-6 * size * size * size;
        well_posed.then(|| matrix.inverse() * -self.b)
    }

    fn matrix(&self) -> DMat3 {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        DMat3::from_cols(
            DVec3::new(xx, xy, xz),
            DVec3::new(xy, yy, yz),
            DVec3::new(xz, yz, zz),
        )
    }
}

impl Add for Quadric {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            a: std::array::from_fn(|i| self.a[i] + other.a[i]),
            b: self.b + other.b,
            c: self.c + other.c,
            weight: self.weight + other.weight,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_squared_distances() {
        let quadric = Quadric::of_plane(DVec3::X, DVec3::new(3.0, 5.0, 7.0), 2.0)
            + Quadric::of_plane(DVec3::Y, DVec3::new(3.0, 5.0, 7.0), 1.0);
        assert_eq!(quadric.at(DVec3::new(4.0, 7.0, 1e3)), 2.0 + 4.0);
    }

    #[test]
    fn three_planes_meet_in_their_corner() {
        let corner = DVec3::new(0.25, 0.5, 1.5);
        let quadric = [DVec3::X, DVec3::Y, DVec3::Z]
            .map(|normal| Quadric::of_plane(normal, corner, 1.0))
            .into_iter()
            .fold(Quadric::default(), Add::add);
        let (place, cost) =
            quadric.best_place(DVec3::new(0.0, 0.5, 1.5), DVec3::new(1.0, 1.0, 1.0));
        assert!(place.distance(corner) < 1e-12 && cost < 1e-12);
    }

    #[test]
    fn one_plane_takes_an_end_of_the_edge_or_its_middle() {
        let quadric = Quadric::of_plane(DVec3::Z, DVec3::ZERO, 1.0);
        assert_eq!(
            quadric.best_place(DVec3::X, DVec3::new(2.0, 0.0, 3.0)),
            (DVec3::X, 0.0)
        );
    }
}
