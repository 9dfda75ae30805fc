//! The crate `bvh`, as its documentation shows: the boxes that the ray meets, and each shape in them.

use boxwood::{Hit, Ray};
use boxwood_measure::{Built, Clock, Contender, MeasureError, Mode, with_threads};
use boxwood_scene::FlatMesh;
use bvh::{
    aabb::{Aabb, Bounded},
    bounding_hierarchy::{BHShape, BoundingHierarchy},
    bvh::Bvh,
};
use nalgebra::{Point3, Vector3};

struct Shape {
    corners: [Point3<f32>; 3],
    prim: u32,
    node: usize,
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        self.corners
            .iter()
            .fold(Aabb::empty(), |bounds, corner| bounds.grow(corner))
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl Shape {
    /// From either side (Moeller and Trumbore, 1997); the crate's own test is for front faces only.
    fn hit(&self, ray: &bvh::ray::Ray<f32, 3>, t_min: f32, t_max: f32) -> Option<Hit> {
        let [a, b, c] = &self.corners;
        let (e1, e2) = (b - a, c - a);
        let p = ray.direction.cross(&e2);
        let inverse = 1.0 / e1.dot(&p);
        let s = ray.origin - a;
        let q = s.cross(&e1);
        let (u, v, t) = (
            s.dot(&p) * inverse,
            ray.direction.dot(&q) * inverse,
            e2.dot(&q) * inverse,
        );
        let is_hit = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= t_min && t < t_max;
        is_hit.then_some(Hit {
            t,
            u,
            v,
            prim: self.prim,
            geom: 0,
            inst: Hit::NO_INSTANCE,
        })
    }
}

struct Svenstaro {
    shapes: Vec<Shape>,
    bvh: Bvh<f32, 3>,
}

/// Builds.
pub(crate) fn build(mesh: &FlatMesh, threads: usize) -> Result<Built, MeasureError> {
    let corner = |i: u32| Point3::from(mesh.positions[i as usize]);
    let shape = |(prim, corners): (usize, &[u32; 3])| Shape {
        corners: corners.map(corner),
        prim: prim as u32,
        node: 0,
    };
    let mut shapes: Vec<Shape> = mesh.indices.iter().enumerate().map(shape).collect();
    let (bvh, time) = with_threads(threads, || {
        let clock = Clock::of_work_on(threads);
        let start = clock.now();
        let bvh = if threads > 1 {
            Bvh::build_par(&mut shapes)
        } else {
            Bvh::build(&mut shapes)
        };
        (bvh, clock.now() - start)
    })?;
    let bytes = size_of_val(&*bvh.nodes) + size_of_val(&*shapes);
    Ok(Built {
        contender: Box::new(Svenstaro { shapes, bvh }),
        time,
        bytes: Some(bytes as u64),
    })
}

fn to(ray: &Ray) -> bvh::ray::Ray<f32, 3> {
    // It makes the direction unit length itself; ours are.
    bvh::ray::Ray::new(Point3::from(ray.origin), Vector3::from(ray.dir))
}

impl Contender for Svenstaro {
    fn name(&self) -> &str {
        "bvh"
    }

    fn has(&self, mode: Mode) -> bool {
        mode == Mode::Single
    }

    fn closest_hits(&self, _: Mode, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, answer) in rays.iter().zip(hits) {
            let asked = to(ray);
            let mut best: Option<Hit> = None;
            for shape in self.bvh.traverse_iterator(&asked, &self.shapes) {
                let limit = best.map_or(ray.t_max, |best| best.t);
                best = shape.hit(&asked, ray.t_min, limit).or(best);
            }
            *answer = best;
        }
    }

    fn occluded(&self, _: Mode, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, answer) in rays.iter().zip(occluded) {
            let asked = to(ray);
            let mut shapes = self.bvh.traverse_iterator(&asked, &self.shapes);
            *answer = shapes.any(|shape| shape.hit(&asked, ray.t_min, ray.t_max).is_some());
        }
    }
}
