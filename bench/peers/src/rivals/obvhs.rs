//! obvhs: its eight-wide compressed tree, one ray at a time.

use boxwood::{Hit, Ray};
use boxwood_measure::{Built, Clock, Contender, MeasureError, Mode, with_threads};
use boxwood_scene::FlatMesh;
use obvhs::{
    BvhBuildParams,
    cwbvh::{CwBvh, builder::build_cwbvh_from_tris},
    ray::RayHit,
    triangle::Triangle,
};
use std::time::Duration;

struct Obvhs {
    name: &'static str,
    bvh: CwBvh,
    /// In the order of the tree.
    triangles: Vec<Triangle>,
}

/// Builds by its `medium_build`, or with `slow` by its `very_slow_build`.
pub(crate) fn build(mesh: &FlatMesh, slow: bool, threads: usize) -> Result<Built, MeasureError> {
    let corner = |i: u32| mesh.positions[i as usize].into();
    let triangle = |[a, b, c]: &[u32; 3]| Triangle {
        v0: corner(*a),
        v1: corner(*b),
        v2: corner(*c),
    };
    let triangles: Vec<Triangle> = mesh.indices.iter().map(triangle).collect();
    let (name, params) = if slow {
        ("obvhs-slow", BvhBuildParams::very_slow_build())
    } else {
        ("obvhs", BvhBuildParams::medium_build())
    };
    let (bvh, time) = with_threads(threads, || {
        let clock = Clock::of_work_on(threads);
        let start = clock.now();
        let bvh = build_cwbvh_from_tris(&triangles, params, &mut Duration::default());
        (bvh, clock.now() - start)
    })?;
    let triangles: Vec<_> = bvh
        .primitive_indices
        .iter()
        .map(|i| triangles[*i as usize])
        .collect();
    let bytes =
        size_of_val(&*bvh.nodes) + size_of_val(&*bvh.primitive_indices) + size_of_val(&*triangles);
    Ok(Built {
        contender: Box::new(Obvhs {
            name,
            bvh,
            triangles,
        }),
        time,
        bytes: Some(bytes as u64),
    })
}

fn to(ray: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(ray.origin.into(), ray.dir.into(), ray.t_min, ray.t_max)
}

impl Contender for Obvhs {
    fn name(&self) -> &str {
        self.name
    }

    fn has(&self, mode: Mode) -> bool {
        mode == Mode::Single
    }

    fn closest_hits(&self, _: Mode, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, answer) in rays.iter().zip(hits) {
            let mut found = RayHit::none();
            let is_hit = self.bvh.ray_traverse(to(ray), &mut found, |ray, i| {
                self.triangles[i].intersect(ray)
            });
            // It gives no u and v.
            *answer = is_hit.then(|| Hit {
                t: found.t,
                u: 0.0,
                v: 0.0,
                prim: self.bvh.primitive_indices[found.primitive_id as usize],
                geom: 0,
                inst: Hit::NO_INSTANCE,
            });
        }
    }

    fn occluded(&self, _: Mode, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, answer) in rays.iter().zip(occluded) {
            *answer = !self
                .bvh
                .ray_traverse_miss(to(ray), |ray, i| self.triangles[i].intersect(ray));
        }
    }
}
