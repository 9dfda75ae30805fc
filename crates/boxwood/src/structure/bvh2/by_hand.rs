//! The measure of the traits: the closest hit of one structure and one primitive, written out as one loop without visitor,
//! observer or generic parameter. `bench/trace` compares; the answers are the same bits.

use super::{Bvh2, Later, address, octant, prefetch};
use crate::build::MAX_DEPTH;
use crate::geom::{Aabb, Hit, PreparedRay, Ray, SlabRay, Triangle};
use crate::prims::Triangles;
use crate::simd::Stack;
use crate::structure::{Accel, Indexed};
use std::hint::select_unpredictable;

/// As [`Query::closest_hit`](crate::Query::closest_hit) of the same.
#[inline(never)]
pub fn closest_hit(indexed: &Indexed<Bvh2<Aabb>, Triangles>, ray: &Ray) -> Option<Hit> {
    let ray = &PreparedRay::new(ray)?;
    let (bvh, triangles) = (indexed.accel(), indexed.prims().as_slice());
    let (volume, root) = bvh.root.as_ref()?;
    let slab_ray = SlabRay::new(ray, &bvh.bounds);
    if !slab_ray.interval(volume).meets(ray.t_min, ray.t_max) {
        return None;
    }
    let octant = octant(ray);
    let (mut best, mut prim) = ((ray.t_max, 0.0, 0.0), u32::MAX);
    let mut memory = Stack::memory::<MAX_DEPTH>();
    let mut stack = Stack::new(&mut memory);
    let mut child = *root;
    loop {
        if child.count > 0 {
            for slot in child.first..child.first + u32::from(child.count) {
                let triangle = &triangles[slot as usize];
                if let Some((t, u, v)) = tested(triangle, ray) {
                    let id = bvh.order()[slot as usize];
                    if t < best.0 || (t == best.0 && id < prim) {
                        (best, prim) = ((t, u, v), id);
                    }
                }
            }
        } else {
            let pair = &bvh.pairs[child.first as usize];
            let [a, b] = [pair.child(0), pair.child(1)];
            for c in [a, b] {
                let node = address(&bvh.pairs, c.first as usize);
                let leaf = address(triangles, c.first as usize);
                prefetch(select_unpredictable(c.count == 0, node, leaf));
            }
            let [near, far] = slab_ray.pair(&pair.volumes);
            let node = 2 * child.first + 1;
            let hit = |near: f32, far: f32| near.max(ray.t_min) <= far.min(best.0);
            let first = Later {
                child: a,
                node,
                near: near.x,
            };
            let second = Later {
                child: b,
                node: node + 1,
                near: near.y,
            };
            let next = match (hit(near.x, far.x), hit(near.y, far.y)) {
                (true, true) if pair.second_first >> octant & 1 == 1 => {
                    stack.push(first);
                    Some(b)
                }
                (true, true) => {
                    stack.push(second);
                    Some(a)
                }
                (true, false) => Some(a),
                (false, true) => Some(b),
                (false, false) => None,
            };
            if let Some(next) = next {
                child = next;
                continue;
            }
        }
        child = loop {
            match stack.pop() {
                Some(later) if later.near <= best.0 => break later.child,
                Some(_) => {}
                None => {
                    let (t, u, v) = best;
                    let (geom, inst) = (0, Hit::NO_INSTANCE);
                    return (prim != u32::MAX).then_some(Hit {
                        t,
                        u,
                        v,
                        prim,
                        geom,
                        inst,
                    });
                }
            }
        };
    }
}

/// The exact test with the definition's binding and range.
#[inline(always)]
fn tested(triangle: &Triangle, ray: &PreparedRay) -> Option<(f32, f32, f32)> {
    let candidate = triangle.intersect(ray)?;
    let t = triangle.bounds().bind(ray, candidate.t)?;
    ray.contains(t).then_some((t, candidate.u, candidate.v))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Query;
    use crate::build::BuildOptions;
    use crate::testing::Random;

    #[test]
    fn the_loop_by_hand_answers_as_the_traits_do() {
        let mut random = Random::new(11);
        let mut point = |scale: f32| [0; 3].map(|_| random.signed() * scale);
        let soup = (0..3000).map(|_| {
            let corner = point(3.0);
            Triangle([0; 3].map(|_| {
                let edge = point(0.4);
                [0, 1, 2].map(|k| corner[k] + edge[k])
            }))
        });
        let triangles = Triangles::new(soup.collect());
        let indexed = Indexed::<Bvh2<Aabb>, _>::new(&triangles, &BuildOptions::default()).unwrap();
        let mut hits = 0;
        for _ in 0..5000 {
            let ray = Ray::new(point(4.0), point(1.0));
            let expected = indexed.closest_hit(&ray);
            assert_eq!(closest_hit(&indexed, &ray), expected, "{ray:?}");
            hits += usize::from(expected.is_some());
        }
        assert!(hits > 500, "the sample must hit: {hits}");
    }
}
