//! Shapes of your own in every structure: `cargo run --release -p boxwood --example own_primitive`.

use boxwood::geom::{Candidate, PreparedRay};
use boxwood::prims::Shapes;
use boxwood::{Aabb, Ray, STRUCTURES, Scene};
use std::sync::Arc;

/// Discs that face z: centre and radius.
struct Discs(Vec<([f32; 3], f32)>);

impl Shapes for Discs {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, index: usize) -> Aabb {
        let ([x, y, z], r) = self.0[index];
        Aabb {
            min: [x - r, y - r, z],
            max: [x + r, y + r, z],
        }
    }

    fn intersect(&self, index: usize, ray: &PreparedRay) -> Option<Candidate> {
        let ([x, y, z], r) = self.0[index];
        let t = (z - ray.origin[2]) / ray.dir[2];
        let (dx, dy) = (
            ray.origin[0] + t * ray.dir[0] - x,
            ray.origin[1] + t * ray.dir[1] - y,
        );
        (dx * dx + dy * dy <= r * r).then_some(Candidate {
            t,
            u: dx / r,
            v: dy / r,
        })
    }
}

fn main() -> Result<(), boxwood::BuildError> {
    let discs = (0..1000)
        .map(|i| {
            (
                [(i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32],
                0.45,
            )
        })
        .collect();
    let discs = Arc::new(Discs(discs));
    let ray = Ray::new([3.25, 4.25, -1.0], [0.0, 0.0, 2.0]);
    for structure in STRUCTURES {
        let scene = Scene::builder()
            .shapes(discs.clone())
            .structure(structure.name)
            .build()?;
        println!("{:8} {:?}", structure.name, scene.closest_hit(&ray));
    }
    Ok(())
}
