//! Faults that were found once, each with the smallest input that showed it.

use boxwood::geom::{Candidate, PreparedRay};
use boxwood::prims::Shapes;
use boxwood::{Aabb, BoundedObject, BuildOptions, Object, Ray, STRUCTURES, Scene, Triangle};
use std::sync::Arc;

const UP: Ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);

/// Shapes in the plane z = 5 that answer a given `t`.
struct Answering(Vec<f32>);

impl Shapes for Answering {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, _: usize) -> Aabb {
        Aabb {
            min: [0.0, 0.0, 5.0],
            max: [1.0, 1.0, 5.0],
        }
    }

    fn intersect(&self, index: usize, ray: &PreparedRay) -> Option<Candidate> {
        let t = self.0[index];
        (t <= ray.t_max || t.is_nan()).then_some(Candidate { t, u: 0.0, v: 0.0 })
    }
}

fn in_every_structure(answers: &[f32]) -> Vec<Option<u32>> {
    let shapes = Arc::new(Answering(answers.to_vec()));
    let scene = |name| {
        Scene::builder()
            .shapes(shapes.clone())
            .structure(name)
            .build()
    };
    let scenes = STRUCTURES.iter().map(|s| scene(s.name).unwrap());
    scenes.map(|s| s.closest_hit(&UP).map(|h| h.prim)).collect()
}

#[test]
fn a_shape_that_answers_nan_or_infinity_is_not_hit() {
    for t in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(in_every_structure(&[t]).iter().all(Option::is_none), "{t}");
    }
}

/// `bounded` once shortened the ray that it showed to shapes, whose raw `t` may lie a little behind the bound one.
#[test]
fn shapes_that_overshoot_their_box_tie_alike_in_every_structure() {
    let answers = in_every_structure(&[5.000_006; 12]);
    assert!(answers.iter().all(|prim| *prim == Some(0)), "{answers:?}");
}

#[test]
fn a_nan_option_builds_all_the_same() {
    let nan = f32::NAN;
    let options = BuildOptions {
        grid_density: nan,
        primitive_cost: nan,
        ..BuildOptions::default()
    };
    let positions = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]];
    for structure in STRUCTURES {
        let mesh = Scene::builder().mesh(&positions, &[[0, 1, 2]; 9]);
        let scene = mesh.structure(structure.name).options(options.clone());
        let hit = scene.build().unwrap().closest_hit(&UP);
        assert_eq!(hit.map(|h| h.t), Some(5.0), "{}", structure.name);
    }
}

#[test]
fn a_triangle_is_asked_for_within_its_own_mesh() {
    let at = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
    let meshes = Scene::builder()
        .mesh(&at(5.0), &[[0, 1, 2]])
        .mesh(&at(6.0), &[[0, 1, 2]]);
    let scene = meshes.build().unwrap();
    assert_eq!(scene.triangle(0, 1), None);
    assert_eq!(scene.triangle(1, 0), Some(Triangle(at(6.0))));
    assert_eq!(scene.triangle_in_scene(1), Some(Triangle(at(6.0))));
}

#[test]
fn nested_objects_keep_to_the_domain() {
    let far = Triangle([[0.0, 0.0, 1e35], [1e35, 0.0, 1e35], [0.0, 1e35, 1e35]]);
    let object: Box<dyn Object> = Box::new((0, far));
    let nested = BoundedObject::<Aabb>::new(vec![object]);
    assert_eq!(
        nested.closest_hit(&Ray::new([1.0; 3], [0.0, 0.0, 1.0])),
        None
    );
}

#[test]
fn an_empty_grid_visits_no_cell() {
    let scene = Scene::builder()
        .mesh(&[], &[])
        .structure("grid")
        .build()
        .unwrap();
    assert!(scene.explain(&UP).steps.is_empty());
}
