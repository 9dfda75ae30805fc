//! Whole pictures: the same for any number of threads, in crops, on any machine; interrupted; of
//! empty scenes.

use std::sync::{
    Mutex,
    atomic::{AtomicBool, AtomicU32, Ordering},
};

use boxwood::{BuildOptions, Builder, Scene};
use boxwood_render::{
    Crop, Film, PointLight, RenderError, RenderOptions, SHADINGS, Session, Shading, Surfaces,
    TileWork, View, Watch, auto_camera, render,
};
use boxwood_scene::{Camera, FlatMesh, Material, Model};

/// A floor, a mirror wall, a sphere-like rough-metal diamond and a lamp: something for every
/// shading.
fn model() -> (FlatMesh, Model) {
    let materials = vec![
        Material {
            base_color: [0.7, 0.6, 0.5],
            ..Material::default()
        },
        Material {
            base_color: [0.9; 3],
            metallic: 1.0,
            roughness: 0.05,
            ..Material::default()
        },
        Material {
            base_color: [0.9, 0.6, 0.2],
            metallic: 1.0,
            roughness: 0.4,
            ..Material::default()
        },
        Material {
            emission: [9.0, 8.0, 6.0],
            ..Material::default()
        },
    ];
    let mut mesh = FlatMesh::default();
    let mut quad = |corners: [[f32; 3]; 4], material: u32| {
        let first = u32::try_from(mesh.positions.len()).unwrap();
        mesh.positions.extend(corners);
        mesh.indices
            .extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.material_of.extend([material; 2]);
    };
    quad(
        [
            [-3.0, 0.0, 3.0],
            [3.0, 0.0, 3.0],
            [3.0, 0.0, -3.0],
            [-3.0, 0.0, -3.0],
        ],
        0,
    );
    quad(
        [
            [-3.0, 0.0, -3.0],
            [3.0, 0.0, -3.0],
            [3.0, 2.5, -3.0],
            [-3.0, 2.5, -3.0],
        ],
        1,
    );
    quad(
        [
            [-0.5, 3.0, -0.5],
            [0.5, 3.0, -0.5],
            [0.5, 3.0, 0.5],
            [-0.5, 3.0, 0.5],
        ],
        3,
    );
    for (a, b) in [
        ([1.0, 0.8, 0.0], [0.0, 0.8, -1.0]),
        ([0.0, 0.8, 1.0], [1.0, 0.8, 0.0]),
    ] {
        quad([[0.0, 0.1, 0.0], b, [0.0, 1.7, 0.0], a], 2);
        quad(
            [[0.0, 0.1, 0.0], a, [0.0, 1.7, 0.0], b].map(|[x, y, z]: [f32; 3]| [-x, y, -z]),
            2,
        );
    }
    (
        mesh,
        Model {
            materials,
            ..Model::default()
        },
    )
}

/// The lecture's partition: a tree that no tuning of the default builder changes.
fn scene(mesh: &FlatMesh) -> Scene {
    let options = BuildOptions::with(Builder::named("median").expect("the lecture's builder"));
    Scene::builder()
        .mesh(&mesh.positions, &mesh.indices)
        .structure("bvh2")
        .options(options)
        .build()
        .unwrap()
}

fn view(width: u32, height: u32) -> View {
    let camera = Camera {
        eye: [2.5, 2.2, 5.5],
        target: [0.0, 0.9, 0.0],
        up: [0.0, 1.0, 0.0],
        fov: 42.0,
    };
    View::new(camera, width, height).unwrap()
}

fn options(shading: &'static Shading) -> RenderOptions {
    RenderOptions {
        samples: Some(3),
        seed: 11,
        ..RenderOptions::new(shading)
    }
}

fn shoot(options: &RenderOptions, threads: usize) -> Film {
    let (mesh, model) = model();
    let scene = scene(&mesh);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    pool.install(|| {
        render(
            &scene,
            Surfaces::new(&mesh, &model),
            &view(53, 37),
            options,
            Watch::default(),
        )
    })
    .unwrap()
}

/// FNV-1a of the picture's bytes.
fn hash(film: &Film) -> u64 {
    let step = |hash: u64, &byte: &u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    film.to_image()
        .rgb
        .as_flattened()
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, step)
}

/// By lamplight, and where the name says so, with daylight besides. A change here is a change of
/// the product's pictures: look at them, and say why in the commit. The failing test prints the new
/// lines.
const GOLDEN: &[(&str, u64)] = &[
    ("eyelight", 0x9189_52e7_b1c1_90b3),
    ("normal", 0xa4e0_e2fc_84b7_5606),
    ("uv", 0x7369_545e_6352_84eb),
    ("depth", 0x9e88_8213_7617_c995),
    ("part", 0xb2ec_2257_3cf0_5049),
    ("prim", 0x6a43_4bda_2f77_dc60),
    ("heat-tests", 0x4ccb_ff10_9daa_d247),
    ("heat-boxes", 0x405e_86a1_75b0_d0df),
    ("heat-prims", 0xc483_49e3_5cc4_98a9),
    ("whitted", 0xfa75_ceb2_874f_0c12),
    ("ao", 0xc252_13cf_a6fd_de2b),
    ("path", 0x3081_b39e_19d2_76f2),
    ("whitted by day", 0x1299_855c_2003_c10d),
    ("path by day", 0x99ac_8d4c_cafa_602f),
];

#[test]
fn every_shading_gives_its_golden_picture_on_one_thread_and_on_two() {
    let mut differing = Vec::new();
    let mut check = |name: String, options: &RenderOptions| {
        let (one, two) = (shoot(options, 1), shoot(options, 2));
        assert!(one == two, "{name} differs between one thread and two");
        let hash = hash(&one);
        if !GOLDEN.contains(&(name.as_str(), hash)) {
            differing.push(format!("    (\"{name}\", {hash:#018x}),"));
        }
    };
    for shading in SHADINGS {
        check(shading.name.to_owned(), &options(shading));
    }
    for name in ["whitted", "path"] {
        let by_day = RenderOptions {
            sky: Some(1.0),
            ..options(Shading::named(name).unwrap())
        };
        check(format!("{name} by day"), &by_day);
    }
    assert!(
        differing.is_empty(),
        "not the golden pictures:\n{}",
        differing.join("\n")
    );
}

#[test]
fn colours_do_not_depend_on_whether_rays_are_counted() {
    for name in ["eyelight", "path"] {
        let mut options = options(Shading::named(name).unwrap());
        let counted = shoot(&options, 2);
        options.counts = false;
        let plain = shoot(&options, 2);
        assert_eq!(plain.color, counted.color);
        assert_eq!(plain.normal, counted.normal);
        assert_eq!((plain.rays, plain.counts.rays), (counted.rays, 0));
        assert!(counted.counts.rays == 53 * 37 && counted.box_tests.iter().any(|&n| n > 0));
    }
}

#[test]
fn a_crop_has_the_pixels_of_the_whole() {
    for name in ["path", "prim"] {
        let mut options = options(Shading::named(name).unwrap());
        let whole = shoot(&options, 2);
        let crop = Crop {
            x: 7,
            y: 11,
            width: 21,
            height: 19,
        };
        options.crop = Some(crop);
        let part = shoot(&options, 2);
        assert_eq!((part.window, part.full_size), (crop, [53, 37]));
        for (i, color) in part.color.iter().enumerate() {
            let at = (i / 21 + 11) * 53 + i % 21 + 7;
            assert_eq!(
                (*color, part.prim[i]),
                (whole.color[at], whole.prim[at]),
                "{name}, pixel {i}"
            );
        }
    }
}

#[test]
fn an_interrupted_picture_keeps_its_finished_tiles_and_says_so() {
    let (mesh, model) = model();
    let scene = scene(&mesh);
    let options = options(Shading::named("eyelight").unwrap());
    let whole = shoot(&options, 1);
    let cancel = AtomicBool::new(false);
    let reports = Mutex::new(Vec::new());
    let report = |progress: boxwood_render::Progress| {
        reports.lock().unwrap().push(progress);
        if progress.pixels > 500 {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    let watch = Watch {
        cancel: Some(&cancel),
        report: Some(&report),
    };
    let film = render(
        &scene,
        Surfaces::new(&mesh, &model),
        &view(53, 37),
        &options,
        watch,
    )
    .unwrap();
    assert!(!film.is_complete());
    assert!(film.finished_share() > 0.0 && film.finished_share() < 1.0);
    let finished = (0..film.color.len())
        .filter(|&i| film.is_finished(i))
        .count() as u64;
    let reports = reports.into_inner().unwrap();
    assert_eq!(reports.iter().map(|r| r.pixels).max(), Some(finished));
    assert!(
        reports
            .iter()
            .all(|r| r.all_pixels == 53 * 37 && r.rays >= r.pixels)
    );
    for i in (0..film.color.len()).filter(|&i| film.is_finished(i)) {
        assert_eq!(film.color[i], whole.color[i]);
    }
}

#[test]
fn the_data_layers_say_what_the_centre_rays_hit() {
    let film = shoot(&options(Shading::named("heat-prims").unwrap()), 2);
    let (mesh, _) = model();
    let scene = scene(&mesh);
    for i in 0..film.color.len() {
        let hit = scene.closest_hit(&view(53, 37).pixel_ray(i as u32 % 53, i as u32 / 53));
        assert_eq!(film.depth[i], hit.map_or(f32::INFINITY, |hit| hit.t));
        assert_eq!(film.prim[i], hit.map_or(u32::MAX, |hit| hit.prim));
        assert_eq!(
            film.material[i],
            hit.map_or(u32::MAX, |hit| mesh.material_of[hit.prim as usize])
        );
    }
    assert_eq!(film.rays, 53 * 37);
    assert_eq!(
        film.prim_tests.iter().map(|&n| u64::from(n)).sum::<u64>(),
        film.counts.prims
    );
    let scale = film.scale.unwrap();
    assert_eq!(scale.max, *film.prim_tests.iter().max().unwrap() as f32);
}

#[test]
fn an_empty_scene_is_a_picture_of_the_background() {
    let (mesh, model) = (FlatMesh::default(), Model::default());
    let scene = Scene::new(&[], &[]).unwrap();
    let surfaces = Surfaces::new(&mesh, &model);
    let view = View::new(auto_camera(&scene, surfaces, 20, 10), 20, 10).unwrap();
    for shading in SHADINGS {
        let film = render(&scene, surfaces, &view, &options(shading), Watch::default()).unwrap();
        assert!(film.prim.iter().all(|&prim| prim == u32::MAX));
        assert!(
            film.color.iter().flatten().all(|x| x.is_finite()),
            "{}",
            shading.name
        );
    }
}

#[test]
fn impossible_options_are_refused_with_a_remedy() {
    let (mesh, model) = model();
    let scene = scene(&mesh);
    let base = options(Shading::named("ao").unwrap());
    let refused = [
        RenderOptions {
            samples: Some(0),
            ..base.clone()
        },
        RenderOptions {
            samples: Some(u32::MAX),
            ..base.clone()
        },
        RenderOptions {
            crop: Some(Crop {
                x: 50,
                y: 0,
                width: 4,
                height: 1,
            }),
            ..base.clone()
        },
        RenderOptions {
            crop: Some(Crop {
                x: u32::MAX,
                y: 0,
                width: 4,
                height: 1,
            }),
            ..base.clone()
        },
        RenderOptions {
            crop: Some(Crop {
                x: 0,
                y: 0,
                width: 0,
                height: 1,
            }),
            ..base.clone()
        },
    ];
    for options in refused {
        let result = render(
            &scene,
            Surfaces::new(&mesh, &model),
            &view(53, 37),
            &options,
            Watch::default(),
        );
        assert!(
            result.unwrap_err().to_string().contains("; choose"),
            "{options:?}"
        );
    }
    let other = FlatMesh::default();
    let result = render(
        &scene,
        Surfaces::new(&other, &model),
        &view(5, 3),
        &base,
        Watch::default(),
    );
    assert!(
        result
            .unwrap_err()
            .to_string()
            .contains("same flattened mesh")
    );
}

#[test]
fn a_point_light_casts_a_hard_shadow() {
    let square = |y: f32, x: [f32; 2]| {
        [
            [x[0], y, 1.0],
            [x[1], y, 1.0],
            [x[1], y, -1.0],
            [x[0], y, -1.0],
        ]
    };
    let mesh = FlatMesh {
        positions: [square(0.0, [-3.0, 3.0]), square(1.0, [-1.25, -0.25])].concat(),
        indices: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
        ..FlatMesh::default()
    };
    let model = Model::default();
    let mut options = options(Shading::named("whitted").unwrap());
    options.lights = vec![PointLight {
        position: [0.0, 2.0, 0.0],
        intensity: [5.0; 3],
        radius: 0.3,
    }];
    // From below the roof, a row of floor points from x = -2.75 on, a quarter apart.
    let camera = Camera {
        eye: [0.0, 0.5, 0.0],
        target: [0.0; 3],
        up: [0.0, 0.0, -1.0],
        fov: 5.0,
    };
    let view = View::new(camera, 126, 1).unwrap();
    options.samples = Some(1);
    let film = render(
        &scene(&mesh),
        Surfaces::new(&mesh, &model),
        &view,
        &options,
        Watch::default(),
    )
    .unwrap();
    let row: Vec<f32> = film.color.iter().map(|c| c[1]).collect();
    let ambient = row.iter().copied().fold(f32::INFINITY, f32::min);
    // The roof's edge at x = -0.25 throws its shadow to x = -0.5: lit from there on, at once.
    for (x, light) in row.iter().enumerate() {
        let at = film.depth[x] * view.pixel_ray(x as u32, 0).dir[0];
        let shadow = at < -0.5 && at > -2.5;
        assert_eq!(
            *light < 1.05 * ambient,
            shadow,
            "at {at}: {light}, ambient {ambient}"
        );
    }
}

#[test]
fn after_a_tile_that_could_not_be_kept_no_other_is_kept() {
    let (mesh, model) = model();
    let scene = scene(&mesh);
    let options = options(Shading::named("normal").unwrap());
    let view = view(400, 300);
    let surfaces = Surfaces::new(&mesh, &model);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build();
    let kept = AtomicU32::new(0);
    let keep = |_: &Film, _: &TileWork| {
        kept.fetch_add(1, Ordering::Relaxed);
        std::thread::sleep(std::time::Duration::from_millis(20));
        Err(RenderError::Encode {
            format: "tile",
            cause: "the disk is full".to_owned(),
        })
    };
    let made = pool.unwrap().install(|| {
        let session = Session::new(&scene, surfaces, &view, &options)?;
        let film = session.film()?;
        let tiles: Vec<u32> = (0..film.finished.len() as u32).collect();
        session.expose(film, &tiles, Watch::default(), &keep)
    });
    assert!(made.is_err());
    assert_eq!(kept.into_inner(), 1);
}
