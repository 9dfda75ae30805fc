//! The second half of the exact test, for one ray and a triangle that it hits for certain: the same operations as
//! `Triangle::intersect` and `Aabb::bind`, with corners or axes in lanes.

use super::finish::{larger, smaller};
use super::form::{Form, Store};
use super::layout::Ref;
use super::pending::Best;
use crate::geom::{Candidate, OWN_PAD, PreparedRay, max, min};
use fearless_simd::{f32x4, f32x8, f64x4, prelude::*};

/// `None` if the ray's range says otherwise.
#[inline(always)]
pub(super) fn evaluate_one<S: Simd, M: Form>(
    simd: S,
    store: &Store<M>,
    ray: &PreparedRay,
    leaf: Ref,
    lane: usize,
) -> Option<Best> {
    let (corners, prim) = store.triangle(leaf, lane);
    let candidate = weigh(simd, ray, &corners);
    let t = bind(simd, ray, &corners, candidate.t)?;
    ray.contains(t).then_some(Best {
        candidate: Candidate { t, ..candidate },
        prim,
    })
}

/// Where the line meets the plane.
#[inline(always)]
fn weigh<S: Simd>(simd: S, ray: &PreparedRay, [a, b, c]: &[[f32; 3]; 3]) -> Candidate {
    let [kx, ky, kz] = ray.axes;
    // The first corner comes again, to be turned round.
    let row = |k: usize| f32x4::simd_from(simd, [a[k], b[k], c[k], a[k]]);
    let depth = row(kz) - f32x4::splat(simd, ray.origin[kz]);
    let both = |of: [f32; 2]| f32x4::splat(simd, of[0]).combine(f32x4::splat(simd, of[1]));
    let depths: f32x8<S> = depth.combine(depth);
    let flat = (row(kx).combine(row(ky)) - both([ray.origin[kx], ray.origin[ky]]))
        - both(ray.shear) * depths;
    // Corners b, c, a and c, a, b.
    let next = flat.slide_within_blocks::<1>(flat);
    let after = flat.slide_within_blocks::<2>(next);
    let ((x1, y1), (x2, y2)) = (next.widen(), after.widen());
    let edges: f64x4<S> = x1 * y2 - y1 * x2;
    let terms = edges * depths.widen().0;
    let (edges, terms): ([f64; 4], [f64; 4]) = (edges.into(), terms.into());
    let determinant = edges[0] + edges[1] + edges[2];
    let depth = (terms[0] + terms[1] + terms[2]) / determinant;
    Candidate {
        t: (depth * ray.t_per_depth) as f32 + 0.0,
        u: (edges[1] / determinant).abs() as f32,
        v: (edges[2] / determinant).abs() as f32,
    }
}

/// Binds `t` to the triangle's own padded box.
#[inline(always)]
fn bind<S: Simd>(simd: S, ray: &PreparedRay, corners: &[[f32; 3]; 3], t: f32) -> Option<f32> {
    let row = |v: &[f32; 3]| f32x4::simd_from(simd, [v[0], v[1], v[2], 0.0]);
    let [a, b, c] = [row(&corners[0]), row(&corners[1]), row(&corners[2])];
    let (origin, recip) = (row(&ray.origin), row(&ray.recip));
    let least = smaller(smaller(a, b), c) - origin;
    let most = larger(larger(a, b), c) - origin;
    let reach = larger(least.abs(), most.abs());
    let reach = max(max(reach[0], reach[1]), reach[2]);
    let pad = f32x4::splat(simd, reach * OWN_PAD + ray.pad_floor);
    let (enter, leave) = ((least - pad) * recip, (most + pad) * recip);
    let (near, far) = (smaller(enter, leave), larger(enter, leave));
    let near = max(max(near[0], near[1]), near[2]);
    let far = min(min(far[0], far[1]), far[2]);
    (near <= far).then(|| max(near, min(far, t)))
}
