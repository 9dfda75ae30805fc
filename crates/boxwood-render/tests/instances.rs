//! What stands in many places looks as if it were there many times.

use boxwood::{BuildOptions, Ray, Scene};
use boxwood_render::Surfaces;
use boxwood_scene::{Instance, Material, Mesh, Model};
use glam::{Mat4, Quat, Vec3};

/// A bent, coloured sheet, four times, once of them mirrored, over a floor that is there once.
fn model() -> Model {
    let positions: Vec<[f32; 3]> = (0..25)
        .map(|i| (i % 5, i / 5))
        .map(|(x, y)| [x as f32, y as f32 * 0.7, (x * y) as f32 * 0.11])
        .collect();
    let quad = |i: u32| [[i, i + 1, i + 6], [i, i + 6, i + 5]];
    let indices: Vec<[u32; 3]> = (0..20).filter(|i| i % 5 < 4).flat_map(quad).collect();
    let tilted = |p: &[f32; 3]| Vec3::new(0.1 * p[0], 0.2, 1.0).normalize().to_array();
    let sheet = Mesh {
        normals: positions.iter().map(tilted).collect(),
        uvs: positions.iter().map(|p| [p[0], p[1]]).collect(),
        material_of: (0..indices.len() as u32).map(|i| i % 3).collect(),
        positions,
        indices,
        ..Mesh::default()
    };
    let floor = Mesh {
        positions: vec![[-90.0, -9.0, -90.0], [90.0, -9.0, -90.0], [0.0, -9.0, 90.0]],
        indices: vec![[0, 2, 1]],
        ..Mesh::default()
    };
    let color = |i: u32| Material {
        base_color: [i as f32 * 0.3, 0.5, 0.1],
        ..Material::default()
    };
    let at = |scale: Vec3, turn: f32, x: f32| Instance {
        mesh: 0,
        world_from_mesh: Mat4::from_scale_rotation_translation(
            scale,
            Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), turn),
            Vec3::new(x, 0.0, 1.0),
        ),
    };
    let still = Instance {
        mesh: 1,
        world_from_mesh: Mat4::IDENTITY,
    };
    Model {
        meshes: vec![sheet, floor],
        instances: vec![
            at(Vec3::ONE, 0.3, -9.0),
            still,
            at(Vec3::new(-1.0, 1.0, 2.0), 0.5, 0.0),
            at(Vec3::new(0.5, 1.5, 1.0), -0.8, 5.0),
            at(Vec3::splat(1.2), 3.0, 11.0),
        ],
        materials: (0..3).map(color).collect(),
        ..Model::default()
    }
}

#[test]
fn folded_surfaces_look_like_the_flattened_ones() {
    let model = model();
    let (flat, folded) = (model.flatten().unwrap(), model.fold().unwrap());
    let plain = Scene::new(&flat.positions, &flat.indices).unwrap();
    let scene = folded.build("bvh2", &BuildOptions::default()).unwrap();
    assert_eq!((scene.len(), folded.parts.len()), (5, 1));
    let (looks, folded_looks) = (
        Surfaces::new(&flat, &model),
        Surfaces::of_folded(&folded, &model),
    );
    assert_eq!(folded_looks.triangle_count(), flat.indices.len() as u64);
    assert_eq!(folded_looks.shown().count(), flat.indices.len());

    let (mut compared, mut backs) = (0, 0);
    for i in 0..4000 {
        let (x, y) = ((i % 63) as f32 * 0.47 - 14.0, (i / 63) as f32 * 0.13 - 4.0);
        let from = Vec3::new(0.3 * x, 2.0, if i % 2 == 0 { 20.0 } else { -20.0 });
        let ray = Ray::between(from.to_array(), [x, y, 1.5]).with_range(0.0, f32::INFINITY);
        let [Some(one), Some(other)] = [plain.closest_hit(&ray), scene.closest_hit(&ray)] else {
            continue;
        };
        if (one.t - other.t).abs() > 1e-4 * one.t {
            continue;
        }
        let (a, b) = (looks.at(&ray, &one), folded_looks.at(&ray, &other));
        if a.base_color != b.base_color {
            // Beside an edge: another triangle.
            continue;
        }
        compared += 1;
        backs += usize::from(a.back);
        assert_eq!(a.back, b.back, "{ray:?}");
        assert!((a.position - b.position).length() < 1e-3, "{ray:?}");
        assert!(a.face_normal.dot(b.face_normal) > 0.999, "{ray:?}");
        assert!(
            a.normal.dot(b.normal) > 0.999,
            "{ray:?}: {} {}",
            a.normal,
            b.normal
        );
        assert!((a.uv - b.uv).length() < 1e-2, "{ray:?}");
        let normal = Vec3::from(scene.normal(&other).unwrap()).normalize();
        assert!(normal.dot(b.face_normal).abs() > 0.999, "{ray:?}");
    }
    assert!(compared > 1500 && backs > 300, "{compared}, {backs}");
}
