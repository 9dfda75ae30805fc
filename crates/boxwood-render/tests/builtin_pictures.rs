//! Golden pictures of the built-in scenes: small ones, by hash. They change only with a reason, which stands in the
//! commit that changes them.

use boxwood::BuildOptions;
use boxwood_render::{RenderOptions, Shading, Surfaces, View, Watch, auto_camera, render};

/// Scene, shading, structure, and the hash of the picture's 8-bit pixels.
const GOLDEN: &[(&str, &str, &str, u64)] = &[
    ("builtin:bush", "whitted", "bvh2", 0x624d24efb6f4d524),
    ("builtin:bush", "heat-prims", "grid", 0xb6f9e329c5fa51b3),
    ("builtin:cornell", "path", "bvh2", 0x6cb58b46079b23ed),
    ("builtin:stadium", "heat-boxes", "bvh2", 0x17001dffaf884f3e),
    ("builtin:terrain?n=5000", "ao", "bvh2", 0x4bcd8a518fb3c7b3),
    (
        "builtin:hairball?n=6000",
        "normal",
        "bvh2",
        0x002fcbe8692faf8c,
    ),
    ("builtin:soup?n=2000", "prim", "grid", 0x4fe8dbd7612da27a),
    (
        "builtin:sphere?n=2000",
        "eyelight",
        "bounded",
        0x2a6ad4792c88564f,
    ),
    (
        "builtin:instanced_grove",
        "whitted",
        "bvh2",
        0x968c20a92b2505a4,
    ),
];

/// FNV-1a, 64 bits.
fn hash(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xcbf2_9ce4_8422_2325, |h, b| {
        (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3)
    })
}

fn picture(name: &str, shading: &str, structure: &str) -> u64 {
    let model = boxwood_scene::open(name).unwrap();
    let mesh = model.fold().unwrap();
    let scene = mesh.build(structure, &BuildOptions::default()).unwrap();
    let surfaces = Surfaces::of_folded(&mesh, &model);
    let (width, height) = (96, 64);
    let own = model.cameras.first().copied();
    let camera = own.unwrap_or_else(|| auto_camera(&scene, surfaces, width, height));
    let view = View::new(camera, width, height).unwrap();
    let mut options = RenderOptions::new(Shading::named(shading).unwrap());
    options.samples = Some(4);
    let film = render(&scene, surfaces, &view, &options, Watch::default()).unwrap();
    hash(film.to_image().rgb.into_iter().flatten())
}

#[test]
fn built_in_scenes_look_as_they_did() {
    let mut changed = Vec::new();
    for &(name, shading, structure, golden) in GOLDEN {
        let found = picture(name, shading, structure);
        if found != golden {
            changed.push(format!(
                "(\"{name}\", \"{shading}\", \"{structure}\", {found:#018x}),"
            ));
        }
    }
    assert!(
        changed.is_empty(),
        "look at the pictures, then:\n{}",
        changed.join("\n")
    );
}
