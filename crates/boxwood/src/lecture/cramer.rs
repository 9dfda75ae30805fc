//! Cramer's rule on the 3x3 system of the slides, with its entries `a` to `l` and its early exit on beta.
//!
//! ```text
//! | a d g |   | beta  |   | j |        a..c = vertex a - vertex b      g..i = d, the ray's direction
//! | b e h | * | gamma | = | k |        d..f = vertex a - vertex c      j..l = vertex a - p, the ray's origin
//! | c f i |   | t     |   | l |
//! ```

use super::{Barycentric, Exit};
use crate::geom::{Ray, Triangle};

/// The slides' count up to the exit on beta: 9 subtractions for the entries, 5 additions and subtractions, 10 products
/// and quotients, and 3 products for M.
pub const SLIDE_FLOPS: u32 = 27;

/// What the code executes up to each [`Exit`]. The slides leave out the two additions of M, hence 29 and not 27; the
/// comparisons are not counted here, as they are not there.
pub const FLOPS: [u32; 3] = [29, 45, 51];

/// The slides' routine: `None` if the line misses the triangle, and where it was decided. `t` may lie outside the ray's
/// range; a triangle seen edge-on gives `M = 0` and is missed.
#[inline]
pub fn intersect(ray: &Ray, triangle: &Triangle) -> (Option<Barycentric>, Exit) {
    intersect_with(ray.origin, ray.dir, triangle.0)
}

/// Over any kind of number, so that a test can count.
#[inline]
fn intersect_with<N: Number>(
    p: [N; 3],
    dir: [N; 3],
    [va, vb, vc]: [[N; 3]; 3],
) -> (Option<Barycentric>, Exit) {
    let (zero, one) = (N::from(0.0), N::from(1.0));
    // Pre-calculate entries and rename.
    let [a, b, c] = [va[0] - vb[0], va[1] - vb[1], va[2] - vb[2]];
    let [d, e, f] = [va[0] - vc[0], va[1] - vc[1], va[2] - vc[2]];
    let [g, h, i] = dir;
    let [j, k, l] = [va[0] - p[0], va[1] - p[1], va[2] - p[2]];

    let (ei_hf, gf_di, dh_eg) = (e * i - h * f, g * f - d * i, d * h - e * g);
    let m = a * ei_hf + b * gf_di + c * dh_eg;
    let beta = (j * ei_hf + k * gf_di + l * dh_eg) / m;
    // Written so that NaN (M = 0) leaves here.
    if !(beta >= zero && beta <= one) {
        return (None, Exit::Beta);
    }
    let (ak_jb, jc_al, bl_kc) = (a * k - j * b, j * c - a * l, b * l - k * c);
    let gamma = (i * ak_jb + h * jc_al + g * bl_kc) / m;
    let sum = beta + gamma;
    if !(gamma >= zero && sum <= one) {
        return (None, Exit::Gamma);
    }
    let t = (f * ak_jb + e * jc_al + d * bl_kc) / m;
    (
        Some(Barycentric {
            beta: beta.value(),
            gamma: gamma.value(),
            t: -t.value(),
        }),
        Exit::Full,
    )
}

trait Number:
    Copy
    + From<f32>
    + PartialOrd
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Div<Output = Self>
{
    fn value(self) -> f32;
}

impl Number for f32 {
    fn value(self) -> f32 {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use std::ops::{Add, Div, Mul, Sub};

    thread_local!(static OPERATIONS: Cell<u32> = const { Cell::new(0) });

    /// A number that counts what is done with it.
    #[derive(Clone, Copy, PartialEq, PartialOrd)]
    struct Counting(f32);

    impl From<f32> for Counting {
        fn from(x: f32) -> Self {
            Self(x)
        }
    }

    impl Number for Counting {
        fn value(self) -> f32 {
            self.0
        }
    }

    macro_rules! count {
        ($($operation:ident $method:ident $symbol:tt),*) => {$(
            impl $operation for Counting {
                type Output = Self;
                fn $method(self, other: Self) -> Self {
                    OPERATIONS.set(OPERATIONS.get() + 1);
                    Self(self.0 $symbol other.0)
                }
            }
        )*};
    }
    count!(Add add +, Sub sub -, Mul mul *, Div div /);

    #[test]
    fn each_exit_costs_what_the_table_says() {
        let triangle = [[0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [0.0, 4.0, 5.0]];
        let counted = |x: f32, y: f32| {
            OPERATIONS.set(0);
            let wrap = |v: [f32; 3]| v.map(Counting);
            let (hit, exit) =
                intersect_with(wrap([x, y, 0.0]), wrap([0.0, 0.0, 1.0]), triangle.map(wrap));
            (hit.is_some(), exit, OPERATIONS.get())
        };
        assert_eq!(counted(-1.0, 1.0), (false, Exit::Beta, FLOPS[0]));
        assert_eq!(counted(1.0, -1.0), (false, Exit::Gamma, FLOPS[1]));
        assert_eq!(counted(1.0, 1.0), (true, Exit::Full, FLOPS[2]));
    }

    #[test]
    fn the_slides_count_lacks_the_two_additions_of_m() {
        assert_eq!(SLIDE_FLOPS, 9 + 5 + 10 + 3);
        assert_eq!(FLOPS[0], SLIDE_FLOPS + 2);
    }

    #[test]
    fn an_edge_on_triangle_is_missed_without_a_nan() {
        let ray = Ray::new([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        let edge_on = Triangle([[0.0, 0.0, 1.0], [0.0, 2.0, 1.0], [0.0, 1.0, 3.0]]);
        assert_eq!(intersect(&ray, &edge_on).0, None);
    }
}
