//! `boxwood build -o`: a scene as a file, and that file as the scene of every other command.

mod common;

use std::fs;

use boxwood::Scene;
use common::{SMALL, expect, folder, json, text};

#[test]
fn a_saved_scene_is_a_file_like_others() {
    let folder = folder();
    let at = folder.path();
    let said = text(&expect(at, &["build", "builtin:sphere?n=1800", "-o", "a.bwx"], 0).stdout);
    let scene = Scene::open(at.join("a.bwx")).unwrap();
    let hash = scene.content_hash().unwrap().to_string();
    assert!(
        said.contains("1,800 triangles") && said.ends_with(&format!("{hash}\n")),
        "{said}"
    );
    assert_eq!(scene.len(), 1800);
    // With vertices that are shared, as they were.
    let of = |file: &str| json(at, &["inspect", file], 0);
    let (saved, built) = (of("a.bwx"), of("builtin:sphere?n=1800"));
    for field in ["triangles", "vertices", "bounds"] {
        assert!(
            saved[field] == built[field] && !saved[field].is_null(),
            "{saved} {built}"
        );
    }
    // Neither normals nor cameras are saved.
    let camera = "--vp 0,-4,3 --vi 0,0,0 --vu 0,0,1 --fov 40 --shading heat-tests";
    for (file, picture) in [("a.bwx", "a.png"), ("builtin:sphere?n=1800", "b.png")] {
        let mut args = vec!["render", file, SMALL, "-o", picture];
        args.extend(camera.split(' '));
        expect(at, &args, 0);
    }
    expect(at, &["diff", "a.png", "b.png"], 0);
    // Saved again it is the same file.
    expect(at, &["build", "a.bwx", "-o", "b.bwx"], 0);
    assert_eq!(
        fs::read(at.join("a.bwx")).unwrap(),
        fs::read(at.join("b.bwx")).unwrap()
    );
    let listed = text(&expect(at, &["list", "formats"], 0).stdout);
    assert!(listed.contains("bwx"), "{listed}");
}

#[test]
fn json_says_what_was_saved_and_standard_output_takes_the_file() {
    let folder = folder();
    let at = folder.path();
    let answer = json(at, &["build", "builtin:cornell", "-o", "a.bwx"], 0);
    let bytes = fs::read(at.join("a.bwx")).unwrap();
    assert_eq!(answer["saved"]["bytes"], bytes.len());
    assert_eq!(answer["saved"]["hash"].as_str().unwrap().len(), 64);
    assert!(answer["steps"].is_array(), "{answer}");
    assert_eq!(
        expect(at, &["build", "builtin:cornell", "-o", "-"], 0).stdout,
        bytes
    );
}

#[test]
fn what_cannot_be_saved_or_opened_is_said() {
    let folder = folder();
    let at = folder.path();
    let error = |args: &[&str], code| text(&expect(at, args, code).stderr);
    let grid = error(
        &[
            "build",
            "builtin:cornell",
            "--structure",
            "grid",
            "-o",
            "a.bwx",
        ],
        2,
    );
    assert!(
        grid.contains("structure grid is not saved") && grid.contains("wide"),
        "{grid}"
    );
    let name = error(&["build", "builtin:cornell", "-o", "a.png"], 2);
    assert!(name.contains("does not end in .bwx"), "{name}");
    assert!(fs::read_dir(at).unwrap().next().is_none());
    expect(at, &["build", "builtin:cornell", "-o", "a.bwx"], 0);
    let mut bytes = fs::read(at.join("a.bwx")).unwrap();
    bytes[700] ^= 1;
    fs::write(at.join("a.bwx"), bytes).unwrap();
    let broken = error(&["inspect", "a.bwx"], 3);
    assert!(
        broken.contains("a.bwx: the content is not what was saved"),
        "{broken}"
    );
}
