//! The oriented box as a bounding volume.

use super::BoundingVolume;
use crate::geom::{Aabb, Interval, Obb, PreparedRay, Sphere, filter_pad};
use glam::DVec3;

/// A ray in double precision with the padding of the half sides.
#[derive(Clone, Copy, Debug)]
pub struct ObbRay {
    origin: [f64; 3],
    dir: [f64; 3],
    pad: f64,
}

impl BoundingVolume for Obb {
    const NAME: &'static str = "obb";
    /// 3 subtractions, two turns (15 each), then per axis: padding 1, division 1, two planes 4, comparisons 4.
    const FLOPS: u32 = 3 + 30 + 30;

    type Ray = ObbRay;
    type Pair = [Self; 2];

    fn of_points(points: &[[f32; 3]]) -> Self {
        let points: Vec<DVec3> = points
            .iter()
            .filter(|p| p.iter().all(|x| x.is_finite()))
            .map(|p| DVec3::from(p.map(f64::from)))
            .collect();
        candidate_frames(&points)
            .into_iter()
            .map(|axes| Frame::around(axes, &points))
            .min_by(|a, b| a.area().total_cmp(&b.area()))
            .map_or(EMPTY, |frame| frame.rounded_out(&points))
    }

    fn of_sphere(sphere: &Sphere) -> Self {
        if !(sphere.radius >= 0.0) {
            return EMPTY;
        }
        Self {
            center: sphere.center,
            axes: UPRIGHT,
            half: [sphere.radius; 3],
        }
    }

    fn of_volumes(volumes: &[Self]) -> Self {
        let corners: Vec<_> = volumes
            .iter()
            .filter(|v| v.half[0] >= 0.0)
            .flat_map(|v| v.grown().corners())
            .collect();
        Self::of_points(&corners)
    }

    #[inline]
    fn prepare(ray: &PreparedRay, bounds: &Aabb) -> ObbRay {
        let pad = 2.0 * filter_pad(bounds.reach(ray.origin), ray);
        ObbRay {
            origin: ray.origin.map(f64::from),
            dir: ray.dir.map(f64::from),
            pad: f64::from(pad),
        }
    }

    #[inline]
    fn interval(&self, ray: &ObbRay) -> Interval {
        if self.half[0] < 0.0 {
            return Interval::EMPTY;
        }
        let (origin, dir) = (self.in_frame(ray.origin), self.turn(ray.dir));
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        for k in 0..3 {
            let half = f64::from(self.half[k]) + ray.pad;
            // Lifting a zero direction moves the ray by less than the padding anywhere in the domain.
            let recip = 1.0
                / if dir[k].abs() < 1e-200 {
                    1e-200_f64.copysign(dir[k])
                } else {
                    dir[k]
                };
            let (a, b) = ((-half - origin[k]) * recip, (half - origin[k]) * recip);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        Interval {
            near: near as f32,
            far: far as f32,
        }
    }

    fn pair(a: &Self, b: &Self) -> [Self; 2] {
        [*a, *b]
    }

    fn of_pair(pair: &[Self; 2]) -> [Self; 2] {
        *pair
    }

    #[inline]
    fn pair_intervals(pair: &[Self; 2], ray: &Self::Ray) -> [Interval; 2] {
        pair.map(|volume| volume.interval(ray))
    }

    fn surface_area(&self) -> f64 {
        let [x, y, z] = self.half.map(|h| 2.0 * f64::from(h.max(0.0)));
        2.0 * (x * y + y * z + z * x)
    }

    fn volume(&self) -> f64 {
        self.half
            .iter()
            .map(|&h| 2.0 * f64::from(h.max(0.0)))
            .product()
    }

    fn bounds(&self) -> Aabb {
        if self.half[0] < 0.0 {
            Aabb::EMPTY
        } else {
            Aabb::of_points(&self.grown().corners())
        }
    }

    fn contains(&self, point: [f32; 3], slack: f32) -> bool {
        let p = self.in_frame(point.map(f64::from));
        (0..3).all(|k| p[k].abs() <= f64::from(self.half[k]) + f64::from(slack))
    }
}

const UPRIGHT: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const EMPTY: Obb = Obb {
    center: [0.0; 3],
    axes: UPRIGHT,
    half: [-1.0; 3],
};

impl Obb {
    /// A little larger, so that its rounded corners still enclose it.
    fn grown(&self) -> Self {
        let size = self
            .center
            .into_iter()
            .chain(self.half)
            .fold(0.0_f32, |m, x| m.max(x.abs()));
        Self {
            half: self.half.map(|h| h + size * 4.0 * f32::EPSILON),
            ..*self
        }
    }
}

/// Seven directions whose extremal points tell where a point set is long (Larsson and Källberg, "Fast Computation of
/// Tight-Fitting Oriented Bounding Boxes", Game Engine Gems 2, 2011: the DiTO-14 set).
const DIRECTIONS: [DVec3; 7] = [
    DVec3::new(1.0, 0.0, 0.0),
    DVec3::new(0.0, 1.0, 0.0),
    DVec3::new(0.0, 0.0, 1.0),
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(1.0, -1.0, -1.0),
];

/// Frames worth trying: upright, and for the largest triangles among the extremal points, each edge with the normal.
fn candidate_frames(points: &[DVec3]) -> Vec<[DVec3; 3]> {
    if points.is_empty() {
        return Vec::new();
    }
    let mut frames = vec![[DVec3::X, DVec3::Y, DVec3::Z]];
    let extremal: Vec<[DVec3; 2]> = DIRECTIONS.iter().map(|d| extremes(points, *d)).collect();
    let Some(&[p, q]) = extremal.iter().max_by(|a, b| {
        a[0].distance_squared(a[1])
            .total_cmp(&b[0].distance_squared(b[1]))
    }) else {
        return frames;
    };
    let corners = || extremal.iter().flatten().copied();
    let from_line = |r: &DVec3| (q - p).cross(*r - p).length_squared();
    let Some(r) = corners().max_by(|a, b| from_line(a).total_cmp(&from_line(b))) else {
        return frames;
    };
    push_triangle_frames(&mut frames, [p, q, r]);
    // The tetrahedra over the base triangle give three more triangles on each side.
    let normal = (q - p).cross(r - p);
    let [below, above] = extremes(points, normal);
    for apex in [below, above] {
        for face in [[p, q, apex], [q, r, apex], [r, p, apex]] {
            push_triangle_frames(&mut frames, face);
        }
    }
    frames
}

fn extremes(points: &[DVec3], dir: DVec3) -> [DVec3; 2] {
    let mut ends = [points[0]; 2];
    for &p in points {
        if p.dot(dir) < ends[0].dot(dir) {
            ends[0] = p;
        }
        if p.dot(dir) > ends[1].dot(dir) {
            ends[1] = p;
        }
    }
    ends
}

fn push_triangle_frames(frames: &mut Vec<[DVec3; 3]>, [p, q, r]: [DVec3; 3]) {
    // A triangle that is a line still has a direction; any normal to it will do.
    let longest = [q - p, r - q, p - r]
        .into_iter()
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let Some(longest) = longest.and_then(DVec3::try_normalize) else {
        return;
    };
    let normal = (q - p)
        .cross(r - p)
        .try_normalize()
        .unwrap_or_else(|| longest.any_orthonormal_vector());
    for edge in [q - p, r - q, p - r] {
        let Some(x) = edge.try_normalize() else {
            continue;
        };
        if let Some(y) = normal.cross(x).try_normalize() {
            frames.push([x, y, x.cross(y)]);
        }
    }
}

/// A box while it is being fitted.
struct Frame {
    axes: [DVec3; 3],
    min: DVec3,
    max: DVec3,
}

impl Frame {
    fn around(axes: [DVec3; 3], points: &[DVec3]) -> Self {
        let in_frame = |p: &DVec3| DVec3::new(axes[0].dot(*p), axes[1].dot(*p), axes[2].dot(*p));
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in points.iter().map(in_frame) {
            min = min.min(p);
            max = max.max(p);
        }
        Self { axes, min, max }
    }

    fn area(&self) -> f64 {
        let d = self.max - self.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// To single precision: the half sides are measured again in the rounded frame, then rounded up.
    fn rounded_out(&self, points: &[DVec3]) -> Obb {
        let middle = (self.min + self.max) * 0.5;
        let center = self.axes[0] * middle.x + self.axes[1] * middle.y + self.axes[2] * middle.z;
        let mut obb = Obb {
            center: center.to_array().map(|x| x as f32),
            axes: self.axes.map(|axis| axis.to_array().map(|x| x as f32)),
            half: [0.0; 3],
        };
        for p in points {
            let q = obb.in_frame(p.to_array());
            for k in 0..3 {
                obb.half[k] = obb.half[k].max((q[k].abs() * (1.0 + 1e-7)) as f32);
            }
        }
        obb.half = obb.half.map(f32::next_up);
        obb
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn a_turned_box_is_fitted_tightly() {
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, 0.8, -0.3);
        let mut random = Random::new(2);
        let half = DVec3::new(5.0, 1.0, 0.25);
        let mut points: Vec<[f32; 3]> = Aabb {
            min: [-5.0, -1.0, -0.25],
            max: [5.0, 1.0, 0.25],
        }
        .corners()
        .to_vec();
        points.extend((0..200).map(|_| {
            [
                random.signed() * 5.0,
                random.signed(),
                random.signed() * 0.25,
            ]
        }));
        for p in &mut points {
            *p = (turn * DVec3::from(p.map(f64::from)))
                .to_array()
                .map(|x| x as f32);
        }
        let volume = <Obb as BoundingVolume>::of_points(&points).volume();
        assert!(volume < 8.0 * half.x * half.y * half.z * 1.05, "{volume}");
        assert!(volume < 0.3 * <Aabb as BoundingVolume>::of_points(&points).volume());
    }

    #[test]
    fn flat_and_straight_point_sets_have_a_box() {
        let flat = <Obb as BoundingVolume>::of_points(&[
            [0.0, 0.0, 0.0],
            [2.0, 2.0, 0.0],
            [1.0, 3.0, 0.0],
        ]);
        assert!(flat.volume() < 1e-4, "{flat:?}");
        let line = <Obb as BoundingVolume>::of_points(&[[0.0; 3], [1.0; 3], [3.0; 3]]);
        assert!(line.surface_area() < 1e-3, "{line:?}");
    }
}
