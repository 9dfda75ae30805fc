//! Bounding volumes around a shape, seen from above: how often each says yes, and what asking it costs.

use boxwood::{
    Aabb, Obb, Query, Ray, Sphere, Triangle,
    prims::Triangles,
    structure::{Indexed, List},
    volume::{BoundingVolume, FittedVolume},
};
use serde::Serialize;

use super::upright;

/// The shape and its volumes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumesAnswer {
    /// Random rays from all around.
    pub rays: usize,
    /// Rays that hit the shape.
    pub hits: usize,
    /// Operations to test the shape itself, wall by wall, for a ray that misses.
    pub object_flops: u32,
    /// Sphere, axis-aligned box, oriented box.
    pub volumes: Vec<VolumeAnswer>,
}

/// One volume.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeAnswer {
    /// As in [`boxwood::VOLUMES`].
    pub name: &'static str,
    /// Of one test.
    pub flops: u32,
    /// Rays that meet it.
    pub met: usize,
    /// Of those, the ones that miss the shape: false yeses.
    pub in_vain: usize,
    /// Operations per ray: its test, and the shape's where it says yes.
    pub flops_per_ray: f64,
    /// Corners in order, or none for a circle.
    pub corners: Vec<[f32; 2]>,
    /// Middle and radius, or none for a box.
    pub circle: Option<[f32; 3]>,
}

/// Fits the three volumes around walls and asks them about `rays` lines in the plane, uniform over all that come within `reach` of
/// the origin. `triangles` is what the shape stands for: its own test costs as many.
pub fn volumes(
    walls: &[[f32; 4]],
    rays: u32,
    reach: f32,
    triangles: u32,
) -> Result<VolumesAnswer, String> {
    let shape: Vec<Triangle> = walls.iter().flat_map(upright).collect();
    let points: Vec<[f32; 3]> = shape.iter().flat_map(|triangle| triangle.0).collect();
    let rays: Vec<Ray> = (0..rays).map(|i| line(i, reach)).collect();
    let list = Indexed::<List, _>::new(&Triangles::new(shape), &Default::default())
        .map_err(|error| error.to_string())?;
    let hits: Vec<bool> = rays.iter().map(|ray| list.occluded(ray)).collect();
    let object_flops = triangles.saturating_mul(Triangle::FLOPS_MISS);
    let answer = |name, flops, volume: &dyn FittedVolume| {
        let met = volume.hits(&rays);
        let in_vain = met.iter().zip(&hits).filter(|(met, hit)| **met && !**hit);
        let (met, in_vain) = (met.iter().filter(|met| **met).count(), in_vain.count());
        let share = met as f64 / rays.len().max(1) as f64;
        VolumeAnswer {
            name,
            flops,
            met,
            in_vain,
            flops_per_ray: f64::from(flops) + share * f64::from(object_flops),
            corners: Vec::new(),
            circle: None,
        }
    };
    let (sphere, aabb, obb) = (
        Sphere::of_points(&points),
        Aabb::of_points(&points),
        Obb::of_points(&points),
    );
    let [x, y, _] = sphere.center;
    let volumes = vec![
        VolumeAnswer {
            circle: Some([x, y, sphere.radius]),
            ..answer("sphere", <Sphere as BoundingVolume>::FLOPS, &sphere)
        },
        VolumeAnswer {
            corners: corners_of_aabb(&aabb),
            ..answer("aabb", <Aabb as BoundingVolume>::FLOPS, &aabb)
        },
        VolumeAnswer {
            corners: corners_of_obb(&obb),
            ..answer("obb", <Obb as BoundingVolume>::FLOPS, &obb)
        },
    ];
    Ok(VolumesAnswer {
        rays: rays.len(),
        hits: hits.iter().filter(|hit| **hit).count(),
        object_flops,
        volumes,
    })
}

/// Line `i`: turned by the golden angle, moved aside by van der Corput's sequence, so that any number of them is even.
fn line(i: u32, reach: f32) -> Ray {
    let turn = f64::from(i) * (std::f64::consts::PI * (3.0 - libm::sqrt(5.0)));
    let aside = 2.0 * f64::from(i.reverse_bits()) / f64::from(u32::MAX) - 1.0;
    let (sin, cos) = libm::sincos(turn);
    let (reach, far) = (f64::from(reach), 4.0 * f64::from(reach));
    let origin = [
        -sin * aside * reach - cos * far,
        cos * aside * reach - sin * far,
    ];
    Ray::new(
        [origin[0] as f32, origin[1] as f32, 0.0],
        [cos as f32, sin as f32, 0.0],
    )
}

fn corners_of_aabb(aabb: &Aabb) -> Vec<[f32; 2]> {
    let ([x0, y0, _], [x1, y1, _]) = (aabb.min, aabb.max);
    vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
}

/// Where the box, one of whose axes is upright, cuts the plane.
fn corners_of_obb(obb: &Obb) -> Vec<[f32; 2]> {
    let upright = (0..3).max_by(|&a, &b| obb.axes[a][2].abs().total_cmp(&obb.axes[b][2].abs()));
    let level: Vec<usize> = (0..3).filter(|&axis| Some(axis) != upright).collect();
    let corner = |signs: [f32; 2]| {
        [0, 1].map(|k| {
            let along = |i: usize| signs[i] * obb.half[level[i]] * obb.axes[level[i]][k];
            obb.center[k] + along(0) + along(1)
        })
    };
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(corner)
        .to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat bar, turned.
    fn bar(turn: f64) -> Vec<[f32; 4]> {
        let (sin, cos) = libm::sincos(turn);
        let at = |x: f64, y: f64| [(cos * x - sin * y) as f32, (sin * x + cos * y) as f32];
        let corners = [at(-3.0, -0.4), at(3.0, -0.4), at(3.0, 0.4), at(-3.0, 0.4)];
        (0..4)
            .map(|i| {
                let [[x0, y0], [x1, y1]] = [corners[i], corners[(i + 1) % 4]];
                [x0, y0, x1, y1]
            })
            .collect()
    }

    #[test]
    fn a_turned_bar_is_tight_in_an_oriented_box_and_loose_in_the_others() {
        let found = volumes(&bar(0.7), 4000, 5.0, 1000).unwrap();
        let in_vain = |name| {
            let volume = found.volumes.iter().find(|volume| volume.name == name);
            volume.unwrap().in_vain
        };
        assert!(in_vain("obb") < found.hits / 20, "{found:?}");
        assert!(in_vain("aabb") > found.hits / 4 && in_vain("sphere") > found.hits / 4);
        for volume in &found.volumes {
            assert_eq!(volume.met - volume.in_vain, found.hits, "{}", volume.name);
        }
    }

    #[test]
    fn an_upright_box_is_as_tight_as_the_oriented_one() {
        let found = volumes(&bar(0.0), 4000, 5.0, 1000).unwrap();
        assert!(found.volumes[1].in_vain < found.hits / 20);
        assert!(found.volumes[1].flops_per_ray <= found.volumes[2].flops_per_ray * 1.02);
    }

    #[test]
    fn lines_are_even_over_all_that_come_near() {
        // Cauchy: the share of lines through a convex shape is its perimeter over that of the circle.
        let found = volumes(&bar(0.3), 20_000, 5.0, 1).unwrap();
        let share = found.hits as f64 / found.rays as f64;
        let expected = 2.0 * (6.0 + 0.8) / (std::f64::consts::TAU * 5.0);
        assert!((share - expected).abs() < 0.01, "{share} {expected}");
    }
}
