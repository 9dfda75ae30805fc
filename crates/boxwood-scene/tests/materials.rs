//! An OBJ file with its material library and its textures, as they lie on a disk.

use std::fs;
use std::path::PathBuf;

use boxwood_scene::{Model, load};

const FACES: &str =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl red\nf 1 2 3\nusemtl wood\nf 1 2 3\nusemtl wood2\nf 3 2 1\n";

/// Loads an OBJ file from a folder with these other files.
fn scene(name: &str, obj: &str, files: &[(&str, &[u8])]) -> Model {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
        .join(format!("materials-{name}-{}", std::process::id()));
    fs::create_dir_all(folder.join("tex")).unwrap();
    for (file, content) in files {
        fs::write(folder.join(file), content).unwrap();
    }
    fs::write(folder.join("a.obj"), obj).unwrap();
    let model = load(&folder.join("a.obj")).unwrap();
    fs::remove_dir_all(folder).unwrap();
    model
}

fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&[1, 2, 3, 4, 5, 6])
        .unwrap();
    bytes
}

#[test]
fn materials_and_textures_are_found_beside_the_file() {
    let mtl = b"newmtl unused\nKd 1 1 1\nnewmtl wood\nmap_Kd -s 1 1 1 tex\\wood.png\nnewmtl red\nKd 1 0 0\nKe 2 2 2\n\
                newmtl wood2\nmap_Kd tex\\wood.png\nKd 0.5 0.5 0.5\n";
    let files = [("my lib.mtl", &mtl[..]), ("tex/wood.png", &png())];
    let model = scene("found", &format!("mtllib my lib.mtl\n{FACES}"), &files);
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    assert_eq!(model.meshes[0].material_of, [0, 1, 2]);
    let names: Vec<_> = model
        .materials
        .iter()
        .map(|m| (m.name.as_str(), m.base_color_texture))
        .collect();
    assert_eq!(
        names,
        [("red", None), ("wood", Some(0)), ("wood2", Some(0))]
    );
    assert_eq!(
        (model.materials[0].base_color, model.materials[0].emission),
        ([1.0, 0.0, 0.0], [2.0; 3])
    );
    assert_eq!(model.textures.len(), 1);
    assert_eq!(model.textures[0].rgba, [[1, 2, 3, 255], [4, 5, 6, 255]]);
}

#[test]
fn two_libraries_on_one_line_are_both_read() {
    let files = [
        ("a.mtl", &b"newmtl red\nKd 1 0 0"[..]),
        ("b.mtl", b"newmtl wood\nKd 0 1 0\nnewmtl wood2"),
    ];
    let model = scene("two", &format!("mtllib a.mtl b.mtl\n{FACES}"), &files);
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    assert_eq!(model.materials[1].base_color, [0.0, 1.0, 0.0]);
}

#[test]
fn what_is_missing_or_broken_is_a_warning() {
    let mtl = b"newmtl wood\nmap_Kd gone.png\nKd 0 1 0\nnewmtl wood2\nmap_Kd broken.png\n";
    let files = [("a.mtl", &mtl[..]), ("broken.png", &png()[..40])];
    let model = scene(
        "missing",
        &format!("mtllib a.mtl\nmtllib ../secret.mtl\n{FACES}"),
        &files,
    );
    assert_eq!(model.triangle_count(), 3);
    let warnings = model.warnings.join("\n");
    for words in [
        "../secret.mtl",
        "\"red\" is not defined",
        "gone.png",
        "broken.png",
    ] {
        assert!(
            warnings.contains(words),
            "\"{words}\" is missing in: {warnings}"
        );
    }
    assert_eq!(model.warnings.len(), 4, "{warnings}");
    assert_eq!(model.materials[1].base_color, [0.0, 1.0, 0.0]);
    assert!(model.textures.is_empty());
}
