//! Frames: the same picture whoever answers the rays, and on however many threads; shadows where they belong.

use std::sync::atomic::{AtomicU64, Ordering};

use boxwood::{Hit, Ray, Scene};
use boxwood_render::{FrameRays, Frames, Image, Surfaces, Tracer, View, auto_camera};
use boxwood_scene::{Camera, FlatMesh, Model};

fn empty_image() -> Image {
    Image {
        width: 0,
        height: 0,
        rgb: Vec::new(),
    }
}

fn bush() -> (Model, FlatMesh) {
    let model = boxwood_scene::open("builtin:bush?n=3000").unwrap();
    let mesh = model.flatten().unwrap();
    (model, mesh)
}

fn scene(mesh: &FlatMesh, structure: &str) -> Scene {
    let builder = Scene::builder().mesh(&mesh.positions, &mesh.indices);
    builder.structure(structure).build().unwrap()
}

fn draw(scene: &Scene, (model, mesh): (&Model, &FlatMesh), threads: usize) -> (Image, FrameRays) {
    let surfaces = Surfaces::new(mesh, model);
    // Neither side is a multiple of a tile's.
    let view = View::new(auto_camera(scene, surfaces, 101, 67), 101, 67).unwrap();
    let mut image = empty_image();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let rays = pool
        .build()
        .unwrap()
        .install(|| Frames::new(surfaces, &view).draw(scene, &view, &mut image));
    (image, rays)
}

#[test]
fn every_structure_draws_the_same_picture_on_one_thread_and_on_three() {
    let (model, mesh) = bush();
    let first = draw(&scene(&mesh, "bvh2"), (&model, &mesh), 1);
    assert_eq!(first.1.camera, 101 * 67);
    assert!(
        first.1.shadow > 500 && first.1.shadow < first.1.camera,
        "{:?}",
        first.1
    );
    for structure in boxwood::STRUCTURES {
        let other = draw(&scene(&mesh, structure.name), (&model, &mesh), 3);
        assert!(other == first, "{} draws another picture", structure.name);
    }
}

#[test]
fn a_roof_throws_its_shadow_on_the_floor_and_both_sides_of_it_can_be_seen() {
    let square = |y: f32, half: f32, x: f32| {
        [
            [x - half, y, half],
            [x + half, y, half],
            [x + half, y, -half],
            [x - half, y, -half],
        ]
    };
    let mesh = FlatMesh {
        positions: [square(0.0, 30.0, 0.0), square(1.0, 1.5, 0.0)].concat(),
        // The roof's corners run clockwise as seen from above.
        indices: vec![[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]],
        ..FlatMesh::default()
    };
    let model = Model::default();
    let scene = Scene::new(&mesh.positions, &mesh.indices).unwrap();
    let camera = Camera {
        eye: [0.0, 9.0, 12.0],
        target: [0.0; 3],
        up: [0.0, 1.0, 0.0],
        fov: 45.0,
    };
    let view = View::new(camera, 64, 64).unwrap();
    let frames = Frames::new(Surfaces::new(&mesh, &model), &view);
    let mut image = empty_image();
    let rays = frames.draw(&scene, &view, &mut image);
    let at = |[x, y]: [usize; 2]| i32::from(image.rgb[y * 64 + x][1]);
    // The pixel of a point in the plane z = 0, by the camera's own geometry.
    let pixel = |x: f32, y: f32| {
        let ahead = [0.0, -0.6, -0.8_f32];
        let to = [x, y - 9.0, -12.0];
        let depth = to[1] * ahead[1] + to[2] * ahead[2];
        let up = to[1] * 0.8 - to[2] * 0.6;
        let scale = 32.0 / (22.5_f32.to_radians().tan() * depth);
        [(32.0 + x * scale) as usize, (32.0 - up * scale) as usize]
    };
    let (roof, lit) = (at(pixel(0.0, 1.0)), at(pixel(-6.0, 0.0)));
    // The sun stands to the left and behind: at this height of the roof the shadow's middle is at x = 0.76.
    let shaded = at(pixel(2.0, 0.0));
    assert!((roof - lit).abs() <= 2, "roof {roof}, floor {lit}");
    assert!(shaded < lit - 60, "shadow {shaded}, floor {lit}");
    assert_eq!(rays.camera, 64 * 64);
}

#[test]
fn a_picture_can_be_drawn_again_in_another_size_and_without_a_scene() {
    let (mesh, model) = (FlatMesh::default(), Model::default());
    let scene = Scene::new(&[], &[]).unwrap();
    let surfaces = Surfaces::new(&mesh, &model);
    let camera = auto_camera(&scene, surfaces, 40, 24);
    let large = View::new(camera, 40, 24).unwrap();
    let small = View::new(camera, 5, 3).unwrap();
    let frames = Frames::new(surfaces, &large);
    let (mut image, mut again) = (empty_image(), empty_image());
    frames.draw(&scene, &large, &mut image);
    for view in [&small, &large] {
        let rays = frames.draw(&scene, view, &mut again);
        assert_eq!([again.width, again.height], [view.width(), view.height()]);
        assert_eq!(again.rgb.len() as u64, rays.camera);
        assert_eq!(rays.shadow, 0);
    }
    assert_eq!(image, again);
}

/// Counts what it passes on.
struct Counting<'a> {
    scene: &'a Scene,
    closest: AtomicU64,
    shadow: AtomicU64,
    /// Of a batch.
    least: AtomicU64,
}

impl Tracer for Counting<'_> {
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.closest.fetch_add(rays.len() as u64, Ordering::Relaxed);
        self.least.fetch_min(rays.len() as u64, Ordering::Relaxed);
        Tracer::closest_hits(self.scene, rays, hits);
    }

    fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.shadow.fetch_add(rays.len() as u64, Ordering::Relaxed);
        Tracer::occluded_each(self.scene, rays, occluded);
    }
}

#[test]
fn all_rays_go_through_the_tracer_in_batches() {
    let (model, mesh) = bush();
    let scene = scene(&mesh, "bvh2");
    let surfaces = Surfaces::new(&mesh, &model);
    let view = View::new(auto_camera(&scene, surfaces, 128, 64), 128, 64).unwrap();
    let tracer = Counting {
        scene: &scene,
        closest: AtomicU64::new(0),
        shadow: AtomicU64::new(0),
        least: AtomicU64::new(u64::MAX),
    };
    let rays = Frames::new(surfaces, &view).draw(&tracer, &view, &mut empty_image());
    assert_eq!(tracer.closest.into_inner(), rays.camera);
    assert_eq!(tracer.shadow.into_inner(), rays.shadow);
    assert!(tracer.least.into_inner() >= 64);
}
