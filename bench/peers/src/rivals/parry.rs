//! parry3d: its triangle mesh, one ray at a time.

use boxwood::{Hit, Ray};
use boxwood_measure::{Built, Clock, Contender, MeasureError, Mode};
use boxwood_scene::FlatMesh;
use parry3d::{math::Vector, query::RayCast, shape::TriMesh};

struct Parry(TriMesh);

/// Builds; it has no threads of its own.
pub(crate) fn build(mesh: &FlatMesh) -> Result<Built, MeasureError> {
    let vertices: Vec<Vector> = mesh
        .positions
        .iter()
        .map(|p| Vector::new(p[0], p[1], p[2]))
        .collect();
    let indices = mesh.indices.clone();
    let clock = Clock::of_work_on(1);
    let start = clock.now();
    let built = TriMesh::new(vertices, indices).map_err(|cause| MeasureError::Contender {
        name: "parry3d".to_owned(),
        cause: cause.to_string(),
        remedy: "leave it out with --only".to_owned(),
    })?;
    let time = clock.now() - start;
    let bytes = built.total_memory_size() as u64;
    Ok(Built {
        contender: Box::new(Parry(built)),
        time,
        bytes: Some(bytes),
    })
}

impl Parry {
    fn ask(&self, ray: &Ray) -> Option<(u32, f32)> {
        let asked = parry3d::query::Ray::new(ray.origin.into(), ray.dir.into());
        let test = |prim, best| self.0.triangle(prim).cast_local_ray(&asked, best, false);
        self.0.bvh().cast_ray(&asked, ray.t_max.min(f32::MAX), test)
    }
}

impl Contender for Parry {
    fn name(&self) -> &str {
        "parry3d"
    }

    fn has(&self, mode: Mode) -> bool {
        mode == Mode::Single
    }

    fn closest_hits(&self, _: Mode, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, answer) in rays.iter().zip(hits) {
            let hit = |(prim, t)| Hit {
                t,
                u: 0.0,
                v: 0.0,
                prim,
                geom: 0,
                inst: Hit::NO_INSTANCE,
            };
            *answer = self.ask(ray).map(hit);
        }
    }

    /// It has no such question, so that the closest hit must do.
    fn occluded(&self, _: Mode, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, answer) in rays.iter().zip(occluded) {
            *answer = self.ask(ray).is_some();
        }
    }
}
