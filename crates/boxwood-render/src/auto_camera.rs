//! A camera for scenes that bring none.

use boxwood::{Ray, Scene, geom::MAX_COORDINATE};
use boxwood_scene::Camera;
use glam::{DVec3, Vec3};

use crate::{Surfaces, sampler::Sampler, sampling};

/// Vertical field of view from outside, in degrees: a longish lens, true in proportion.
const OUTSIDE_FOV: f32 = 35.0;
/// In rooms: a wide one.
const INSIDE_FOV: f32 = 68.0;

/// A camera that shows the scene well in a picture of `width` x `height` pixels. Always the same
/// for the same scene.
///
/// Up is +Y, or +Z for a scene that lies flat in x and y (its height along z below half of either).
/// An object is seen from outside, in front and above, to the right, as near as it fits in: "in
/// front" is +Z, or -Y where up is +Z. A room (its middle walled in on all sides, its walls facing
/// inwards or hiding an inner world) is seen from inside, at eye height, from the place and in the
/// direction that shows most. Shoots some thousands of rays. An empty scene gets a camera at `(0,
/// 0, 1)` that looks at the origin. The arithmetic is in f64, so that it does not overflow.
pub fn auto_camera(scene: &Scene, surfaces: Surfaces<'_>, width: u32, height: u32) -> Camera {
    let bounds = scene.bounds();
    let [min, max] = [bounds.min, bounds.max].map(|corner| Vec3::from(corner).as_dvec3());
    if !(min.is_finite() && max.is_finite()) || min.cmpgt(max).any() {
        return Camera {
            eye: [0.0, 0.0, 1.0],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            fov: OUTSIDE_FOV,
        };
    }
    let aspect = f64::from(width.max(1)) / f64::from(height.max(1));
    let box_of = Bounds {
        min,
        max,
        up: up_of(max - min),
    };
    if is_room(scene, surfaces, &box_of) {
        inside(scene, surfaces, &box_of, aspect)
    } else {
        outside(surfaces, &box_of, aspect)
    }
}

struct Bounds {
    min: DVec3,
    max: DVec3,
    up: DVec3,
}

impl Bounds {
    fn centre(&self) -> DVec3 {
        self.min.midpoint(self.max)
    }

    /// Never so small, even of a point, that a camera so far away would stand where it looks.
    fn diagonal(&self) -> f64 {
        let least = 1e-3 * self.centre().abs().max_element();
        match (self.max - self.min).length().max(least) {
            0.0 => 1.0,
            diagonal => diagonal,
        }
    }

    /// Along `up`.
    fn height(&self) -> f64 {
        (self.max - self.min).dot(self.up)
    }

    /// To the viewer, level.
    fn front(&self) -> DVec3 {
        if self.up == DVec3::Z {
            DVec3::NEG_Y
        } else {
            DVec3::Z
        }
    }
}

fn up_of(size: DVec3) -> DVec3 {
    let lies_in_xy = size.z < 0.5 * size.x.min(size.y);
    if lies_in_xy { DVec3::Z } else { DVec3::Y }
}

/// The nearest point from which rays can start.
fn place(point: DVec3) -> [f32; 3] {
    let limit = DVec3::splat(MAX_COORDINATE.into());
    point.clamp(-limit, limit).as_vec3().into()
}

fn ray(from: DVec3, dir: DVec3) -> Ray {
    Ray::new(place(from), dir.normalize_or_zero().as_vec3().into())
}

/// Fits every corner of every triangle between the four planes of the view.
fn outside(surfaces: Surfaces<'_>, bounds: &Bounds, aspect: f64) -> Camera {
    let side = bounds.up.cross(bounds.front());
    let back = (bounds.front() + side * 0.62 + bounds.up * 0.46).normalize();
    let right = bounds.up.cross(back).normalize();
    let up = back.cross(right);
    let half_height = libm::tan(f64::from(OUTSIDE_FOV).to_radians() * 0.5);
    let half_width = half_height * aspect;

    let centre = bounds.centre();
    // Without the triangles that can never be hit.
    let corners = || {
        surfaces
            .shown()
            .map(|(_, _, triangle)| triangle.map(Vec3::as_dvec3))
            .filter(|triangle| {
                triangle
                    .iter()
                    .all(|p| p.abs().max_element() <= MAX_COORDINATE.into())
            })
            .flatten()
            .map(|p| p - centre)
    };
    // The eye at (x, depth) sees a point (px, pz) if |px - x| <= slope * (depth - pz): two lines,
    // whose intersection is the nearest such eye.
    let fit = |axis: DVec3, slope: f64| {
        let (mut left, mut rightmost) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        for p in corners() {
            let (across, toward) = (p.dot(axis), slope * p.dot(back));
            rightmost = rightmost.max(across + toward);
            left = left.max(-across + toward);
        }
        ((rightmost - left) * 0.5, (rightmost + left) * 0.5 / slope)
    };
    let (x, depth_x) = fit(right, half_width);
    let (y, depth_y) = fit(up, half_height);
    let nearest = corners()
        .map(|p| p.dot(back))
        .fold(f64::NEG_INFINITY, f64::max);
    let depth = depth_x.max(depth_y);
    // Some air around; and never so near that a flat thing is touched.
    let depth = nearest + ((depth - nearest) * 1.14).max(0.05 * bounds.diagonal());
    let target = centre + right * x + up * y;
    Camera {
        eye: place(target + back * depth),
        target: place(target),
        up: bounds.up.as_vec3().into(),
        fov: OUTSIDE_FOV,
    }
}

/// Whether the middle of the scene is walled in by surfaces that are meant to be seen from there.
fn is_room(scene: &Scene, surfaces: Surfaces<'_>, bounds: &Bounds) -> bool {
    let seen = Look::around(scene, surfaces, eye_level(bounds, bounds.centre()), bounds);
    let from_outside = backs_from_outside(scene, surfaces, bounds);
    let walled_in = seen.hit_share > 0.85;
    walled_in && (seen.back_share < 0.35 && seen.depth > 0.08 || from_outside > 0.9)
}

/// At 45 % of the height, under or over `place`.
fn eye_level(bounds: &Bounds, place: DVec3) -> DVec3 {
    let floor = if bounds.up == DVec3::Z {
        bounds.min.z
    } else {
        bounds.min.y
    };
    place + bounds.up * (floor + 0.45 * bounds.height() - place.dot(bounds.up))
}

/// What rays from a point meet.
#[derive(Clone, Copy, Debug)]
struct Look {
    /// Of all rays.
    hit_share: f32,
    /// Of those that hit, the ones that see a triangle from behind.
    back_share: f32,
    /// Mean distance of the hits, in diagonals.
    depth: f32,
}

impl Look {
    /// In all directions.
    fn around(scene: &Scene, surfaces: Surfaces<'_>, eye: DVec3, bounds: &Bounds) -> Self {
        let rays = (0..256).map(|i| {
            let dir = sampling::sphere(Sampler::new(0, 0, 0, i).next_pair());
            ray(eye, dir.as_dvec3())
        });
        Self::along(scene, surfaces, bounds, rays)
    }

    fn along(
        scene: &Scene,
        surfaces: Surfaces<'_>,
        bounds: &Bounds,
        rays: impl Iterator<Item = Ray>,
    ) -> Self {
        let (mut n, mut hits, mut backs, mut depth) = (0u32, 0u32, 0u32, 0.0);
        for ray in rays {
            n += 1;
            if let Some(hit) = scene.closest_hit(&ray) {
                hits += 1;
                backs += u32::from(surfaces.at(&ray, &hit).back);
                depth += (f64::from(hit.t) / bounds.diagonal()) as f32;
            }
        }
        let of_hits = |x: f32| if hits > 0 { x / hits as f32 } else { 0.0 };
        Self {
            hit_share: hits as f32 / n.max(1) as f32,
            back_share: of_hits(backs as f32),
            depth: of_hits(depth),
        }
    }
}

/// Of the rays towards the scene from all around: the share that sees a triangle from behind.
fn backs_from_outside(scene: &Scene, surfaces: Surfaces<'_>, bounds: &Bounds) -> f32 {
    let rays = (0..256).map(|i| {
        let mut sampler = Sampler::new(1, 0, 0, i);
        let eye =
            bounds.centre() + sampling::sphere(sampler.next_pair()).as_dvec3() * bounds.diagonal();
        let [x, y] = sampler.next_pair();
        let aim =
            bounds.min + (bounds.max - bounds.min) * Vec3::new(x, y, sampler.next()).as_dvec3();
        ray(eye, aim - eye)
    });
    Look::along(scene, surfaces, bounds, rays).back_share
}

/// From the place and in the direction that shows most: far walls, fronts, nothing right before the
/// lens.
fn inside(scene: &Scene, surfaces: Surfaces<'_>, bounds: &Bounds, aspect: f64) -> Camera {
    let mut best = (f32::NEG_INFINITY, bounds.centre(), bounds.front());
    for place in places(bounds) {
        let eye = eye_level(bounds, place);
        for step in 0..12 {
            let (sin, cos) = libm::sincos(f64::from(step) * std::f64::consts::TAU / 12.0);
            let side = bounds.up.cross(bounds.front());
            let dir = (bounds.front() * cos + side * sin - bounds.up * 0.1).normalize();
            let score = view_score(scene, surfaces, bounds, eye, dir, aspect);
            if score > best.0 {
                best = (score, eye, dir);
            }
        }
    }
    let (_, eye, dir) = best;
    let target = eye + dir * (0.3 * bounds.diagonal());
    Camera {
        eye: place(eye),
        target: place(target),
        up: bounds.up.as_vec3().into(),
        fov: INSIDE_FOV,
    }
}

/// An even grid of places, away from the walls.
fn places(bounds: &Bounds) -> impl Iterator<Item = DVec3> {
    const STEPS: i32 = 5;
    let side = bounds.up.cross(bounds.front());
    let half = (bounds.max - bounds.min) * 0.5;
    let (front, side) = (
        bounds.front() * half.dot(bounds.front().abs()),
        side * half.dot(side.abs()),
    );
    let centre = bounds.centre();
    let at = |i: i32| f64::from(2 * i - (STEPS - 1)) / f64::from(STEPS);
    (0..STEPS * STEPS).map(move |i| centre + front * at(i / STEPS) + side * at(i % STEPS))
}

fn view_score(
    scene: &Scene,
    surfaces: Surfaces<'_>,
    bounds: &Bounds,
    eye: DVec3,
    dir: DVec3,
    aspect: f64,
) -> f32 {
    const GRID: i32 = 8;
    let half_height = libm::tan(f64::from(INSIDE_FOV).to_radians() * 0.5);
    let right = dir.cross(bounds.up).normalize();
    let up = right.cross(dir);
    let (mut score, mut prims) = (0.0, std::collections::BTreeSet::new());
    for i in 0..GRID * GRID {
        let at = |i: i32| f64::from(2 * i + 1 - GRID) / f64::from(GRID);
        let way =
            dir + right * (at(i % GRID) * half_height * aspect) + up * (at(i / GRID) * half_height);
        let ray = ray(eye, way);
        let Some(hit) = scene.closest_hit(&ray) else {
            continue;
        };
        prims.insert((hit.inst, hit.prim));
        let distance = (f64::from(hit.t) / bounds.diagonal()) as f32;
        // Diminishing worth of distance; what stands right before the lens or shows its back counts
        // against.
        score += (distance / (distance + 0.15)) - if distance < 0.04 { 0.8 } else { 0.0 };
        score -= if surfaces.at(&ray, &hit).back {
            0.6
        } else {
            0.0
        };
    }
    // Things to look at, rather than bare walls.
    score + 0.4 * prims.len() as f32
}

#[cfg(test)]
mod tests {
    use boxwood_scene::{FlatMesh, Model};

    use super::*;
    use crate::View;

    /// A box with its faces outwards, or inwards as in a room, and a small one standing in it.
    fn box_scene(size: [f32; 3], inwards: bool) -> FlatMesh {
        let mut mesh = FlatMesh::default();
        let mut add = |min: [f32; 3], size: [f32; 3], flip: bool| {
            let first = mesh.positions.len() as u32;
            let corner = |i: usize| {
                std::array::from_fn(|k| min[k] + if i >> k & 1 == 1 { size[k] } else { 0.0 })
            };
            mesh.positions.extend((0..8).map(corner));
            let sides = [
                [0, 4, 6, 2],
                [1, 3, 7, 5],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 2, 3, 1],
                [4, 5, 7, 6],
            ];
            for [a, b, c, d] in sides.map(|side| side.map(|i: u32| i + first)) {
                let pair = if flip {
                    [[a, c, b], [a, d, c]]
                } else {
                    [[a, b, c], [a, c, d]]
                };
                mesh.indices.extend(pair);
            }
        };
        add([-1.5, 2.0, 0.5], size, inwards);
        let beside = |k: usize, start: f32| start + 0.35 * size[k];
        let inner = [beside(0, -1.5), 2.0, beside(2, 0.5)];
        add(inner, size.map(|x| 0.2 * x), false);
        mesh
    }

    fn camera_of(mesh: &FlatMesh) -> (Camera, Scene) {
        let scene = Scene::new(&mesh.positions, &mesh.indices).unwrap();
        let model = Model::default();
        (
            auto_camera(&scene, Surfaces::new(mesh, &model), 320, 200),
            scene,
        )
    }

    #[test]
    fn an_object_is_seen_whole_and_from_outside() {
        for size in [[4.0, 3.0, 5.0], [0.04, 0.09, 0.02], [400.0, 3.0, 50.0]] {
            let mesh = box_scene(size, false);
            let (camera, scene) = camera_of(&mesh);
            let bounds = scene.bounds();
            assert!((0..3).any(|k| camera.eye[k] < bounds.min[k] || camera.eye[k] > bounds.max[k]));
            let view = View::new(camera, 320, 200).unwrap();
            let seen = |x: f32, y: f32| scene.closest_hit(&view.ray(x, y)).is_some();
            let border = (0..320).flat_map(|x| [(x as f32, 0.0), (x as f32, 200.0)]);
            assert!(
                !border.into_iter().any(|(x, y)| seen(x, y)),
                "{size:?} touches the border"
            );
            assert!(
                (0..200).all(|y| !seen(0.0, y as f32) && !seen(320.0, y as f32)),
                "{size:?}"
            );
            let points = (0..320).flat_map(|x| (0..20).map(move |y| (x as f32, y as f32 * 10.0)));
            assert!(
                points.filter(|&(x, y)| seen(x, y)).count() > 300,
                "{size:?}"
            );
        }
    }

    #[test]
    fn a_room_is_seen_from_inside_and_never_from_behind_its_walls() {
        let mesh = box_scene([4.0, 3.0, 5.0], true);
        let (camera, scene) = camera_of(&mesh);
        let bounds = scene.bounds();
        assert!((0..3).all(|k| camera.eye[k] > bounds.min[k] && camera.eye[k] < bounds.max[k]));
        let model = Model::default();
        let (surfaces, view) = (
            Surfaces::new(&mesh, &model),
            View::new(camera, 32, 20).unwrap(),
        );
        for (x, y) in (0..640).map(|i| (i % 32, i / 32)) {
            let ray = view.pixel_ray(x, y);
            assert!(!surfaces.at(&ray, &scene.closest_hit(&ray).unwrap()).back);
        }
    }

    #[test]
    fn a_flat_map_in_x_and_y_has_its_height_along_z() {
        assert_eq!(
            camera_of(&box_scene([40.0, 30.0, 2.0], false)).0.up,
            [0.0, 0.0, 1.0]
        );
        assert_eq!(
            camera_of(&box_scene([40.0, 2.0, 30.0], false)).0.up,
            [0.0, 1.0, 0.0]
        );
        assert_eq!(
            camera_of(&box_scene([4.0, 3.0, 5.0], false)).0.up,
            [0.0, 1.0, 0.0]
        );
    }

    #[test]
    fn a_point_and_a_scene_as_large_as_can_be_get_a_camera_too() {
        let point = [[1.0; 3]; 3];
        let origin = [[0.0; 3]; 3];
        let huge = [[-1e30, -1e30, 0.0], [1e30, -1e30, 1e30], [0.0, 1e30, -1e30]];
        let tiny = [[0.0; 3], [1e-30, 0.0, 0.0], [0.0, 1e-30, 0.0]];
        // This one is beyond 2^100 and can never be hit.
        let far = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 3e38]];
        for corners in [point, origin, huge, tiny, far] {
            let mesh = FlatMesh {
                positions: corners.to_vec(),
                indices: vec![[0, 1, 2]],
                ..FlatMesh::default()
            };
            let (camera, _) = camera_of(&mesh);
            View::new(camera, 320, 200).unwrap_or_else(|error| panic!("{corners:?}: {error}"));
        }
    }
}
