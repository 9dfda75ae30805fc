//! The commands that make pictures: what they write, to where, and what survives when they fail.

mod common;

use std::{fs, io::Write, process::Stdio};

use common::{SMALL, command, expect, folder, is_under_nohup, json, send, text};
use serde_json::Value;

#[test]
fn the_demonstration_traces_one_frame_five_ways_with_one_answer() {
    let folder = folder();
    let report = json(folder.path(), &["demo", "--size", "64x36"], 0);
    assert_eq!(report["triangles"], 40_000);
    assert_eq!(report["brute_force_flops"], 64_u64 * 36 * 40_000 * 27);
    let ways = report["ways"].as_array().unwrap();
    assert_eq!(ways.len(), 5);
    assert!(
        ways.iter().all(|way| way["same_answer"] == true),
        "{ways:?}"
    );
    assert_eq!(ways[0]["primitive_tests_per_ray"], 40_000.0);
    assert!(
        ways[3]["primitive_tests_per_ray"].as_f64() < ways[1]["primitive_tests_per_ray"].as_f64()
    );
    assert_eq!(report["drawing"]["camera_rays"], 64 * 36);
    assert!(report["drawing"]["frames_per_second"].as_f64() > Some(1.0));
    for name in ["boxwood.png", "boxwood-heat.png"] {
        assert!(
            fs::read(folder.path().join(name))
                .unwrap()
                .starts_with(b"\x89PNG"),
            "{name}"
        );
    }
    // Without a command: the same, for people.
    let output = expect(
        folder.path(),
        &["--threads", "1", "demo", "--size", "32x18"],
        0,
    );
    let shown = text(&output.stdout);
    assert!(
        shown.contains("32 x 18 x 40,000 x 27 = 622,080,000 flop per frame by brute force"),
        "{shown}"
    );
    assert!(
        shown.contains("1 thread,") && shown.contains("next: boxwood "),
        "{shown}"
    );
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
}

#[test]
fn every_builtin_scene_can_be_inspected_and_rendered() {
    let folder = folder();
    let list = json(folder.path(), &["list"], 0);
    let builtins: Vec<String> = list["builtins"]
        .as_array()
        .unwrap()
        .iter()
        .map(|b| format!("builtin:{}", b["name"].as_str().unwrap()))
        .collect();
    assert!(builtins.len() >= 6, "{builtins:?}");
    for name in builtins {
        let found = json(folder.path(), &["inspect", &name], 0);
        let instanced = name.contains("instanced");
        let (shown, stored) = (&found["triangles"], &found["unique_triangles"]);
        assert!(shown.as_u64() > Some(30), "{name}");
        assert_eq!(shown != stored, instanced, "{name}");
        assert!(
            found["bounds"]["min"][0].as_f64() < found["bounds"]["max"][0].as_f64(),
            "{name}"
        );
        assert!(
            instanced || found["structure"]["sah_cost"].as_f64() > Some(1.0),
            "{name}"
        );
        expect(
            folder.path(),
            &[
                "render",
                &name,
                SMALL,
                "-o",
                "a.png",
                "--shading",
                "eyelight",
            ],
            0,
        );
        assert!(
            fs::read(folder.path().join("a.png")).unwrap().len() > 500,
            "{name}"
        );
    }
}

#[test]
fn every_shading_and_structure_renders_and_structures_give_one_picture() {
    let folder = folder();
    let list = json(folder.path(), &["list"], 0);
    let names = |kind: &str| -> Vec<String> {
        list[kind]
            .as_array()
            .unwrap()
            .iter()
            .map(|entry| entry["name"].as_str().unwrap().to_owned())
            .collect()
    };
    for shading in names("shadings") {
        let args = [
            "render",
            "builtin:cornell",
            SMALL,
            "--spp",
            "1",
            "--shading",
            &shading,
            "-o",
            "a.exr",
        ];
        let report = json(folder.path(), &args, 0);
        assert_eq!(
            (
                &report["complete"],
                report["rays"].as_u64() >= Some(48 * 27)
            ),
            (&Value::from(true), true)
        );
    }
    let picture = |structure: &str, threads: &str| {
        let file = format!("{structure}.png");
        let scene = "builtin:stadium";
        let args = [
            "render",
            scene,
            SMALL,
            "--spp",
            "1",
            "--structure",
            structure,
            "--threads",
            threads,
            "-o",
            &file,
        ];
        expect(folder.path(), &args, 0);
        fs::read(folder.path().join(file)).unwrap()
    };
    let first = picture("list", "2");
    for structure in names("structures") {
        assert!(picture(&structure, "1") == first, "{structure}");
    }
}

#[test]
fn pictures_go_to_stdout_and_scenes_come_from_stdin() {
    let folder = folder();
    expect(
        folder.path(),
        &[
            "simplify",
            "builtin:terrain?n=2000",
            "--triangles",
            "800",
            "-o",
            "hill.obj",
        ],
        0,
    );
    let scene = fs::read(folder.path().join("hill.obj")).unwrap();
    let piped = |args: &[&str]| {
        let mut child = command(folder.path())
            .args(args)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(&scene).unwrap();
        child.wait_with_output().unwrap()
    };
    let output = piped(&["render", "-", SMALL, "-o", "-"]);
    assert!(
        output.status.success() && output.stdout.starts_with(b"\x89PNG"),
        "{}",
        text(&output.stderr)
    );
    assert!(
        output.stderr.is_empty(),
        "quiet when piped: {}",
        text(&output.stderr)
    );
    let output = piped(&["inspect", "-", "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["triangles"], 800);
    let output = piped(&["simplify", "-", "--triangles", "100", "-o", "-"]);
    assert!(
        output.stdout.starts_with(b"ply\n"),
        "{}",
        text(&output.stderr)
    );
}

#[test]
fn diff_tells_equal_near_and_far_apart() {
    let folder = folder();
    let at = folder.path();
    let render = |file: &str, seed: &str| {
        expect(
            at,
            &[
                "render",
                "builtin:cornell",
                SMALL,
                "--shading",
                "path",
                "--spp",
                "1",
                "--seed",
                seed,
                "-o",
                file,
            ],
            0,
        );
    };
    render("a.png", "1");
    render("b.png", "2");
    render("c.png", "1");
    let same = json(at, &["diff", "a.png", "c.png"], 0);
    assert_eq!(
        (&same["equal"], &same["rmse"]),
        (&Value::from(true), &Value::from(0.0))
    );
    let other = json(at, &["diff", "a.png", "b.png"], 1);
    assert!(other["flip"].as_f64() > Some(0.0) && other["differing_pixels"].as_u64() > Some(0));
    expect(at, &["diff", "a.png", "b.png", "--threshold", "0.0001"], 1);
    expect(
        at,
        &[
            "diff",
            "a.png",
            "b.png",
            "--threshold",
            "1",
            "-o",
            "flip.png",
        ],
        0,
    );
    assert!(
        fs::read(at.join("flip.png"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
    expect(
        at,
        &[
            "render",
            "builtin:cornell",
            "--size",
            "9x9",
            "-o",
            "small.png",
        ],
        0,
    );
    let output = expect(at, &["diff", "a.png", "small.png"], 3);
    assert!(
        text(&output.stderr).contains("48x27 and 9x9"),
        "{}",
        text(&output.stderr)
    );
}

#[test]
fn a_picture_in_place_survives_whatever_goes_wrong() {
    let folder = folder();
    let picture = folder.path().join("a.png");
    fs::write(&picture, "precious").unwrap();
    fs::write(folder.path().join("bad.obj"), "v 0 0 zero\n").unwrap();
    expect(folder.path(), &["render", "bad.obj", "-o", "a.png"], 3);
    expect(
        folder.path(),
        &["render", "builtin:cornell", "-o", "a.png", "--fov", "-1"],
        2,
    );
    assert_eq!(fs::read(&picture).unwrap(), b"precious");
    expect(
        folder.path(),
        &["render", "builtin:cornell", SMALL, "-o", "a.png"],
        0,
    );
    assert!(fs::read(&picture).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        2,
        "no temporary file is left"
    );
}

#[test]
fn a_crop_is_a_piece_of_the_whole_picture() {
    let folder = folder();
    let size = |crop: &[&str]| {
        let args = [&["render", "builtin:cornell", SMALL, "-o", "a.png"], crop].concat();
        let report = json(folder.path(), &args, 0);
        (report["width"].as_u64(), report["height"].as_u64())
    };
    assert_eq!(size(&[]), (Some(48), Some(27)));
    assert_eq!(size(&["--crop", "7,3,20,11"]), (Some(20), Some(11)));
}

#[cfg_attr(not(unix), ignore = "sends signals")]
#[test]
fn ctrl_c_saves_what_is_done_and_ends_with_4() {
    if is_under_nohup() {
        return;
    }
    let folder = folder();
    let child = command(folder.path())
        .args([
            "render",
            "builtin:bush",
            "--size",
            "1600x1200",
            "--shading",
            "path",
            "--spp",
            "5000",
            "-o",
            "a.png",
        ])
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    // Long enough for some tiles, much too short for all.
    std::thread::sleep(std::time::Duration::from_secs(6));
    send("INT", &child);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
    let said = text(&output.stderr);
    if said.contains("before the first tile") {
        println!("the machine was too slow for a first tile: {said}");
    } else {
        assert!(said.contains("interrupted: a.png holds the "), "{said}");
        assert!(
            fs::read(folder.path().join("a.png"))
                .unwrap()
                .starts_with(b"\x89PNG")
        );
    }
}

#[cfg_attr(not(unix), ignore = "sends signals")]
#[test]
fn a_process_that_is_ended_while_it_writes_leaves_no_part_of_a_file() {
    if is_under_nohup() {
        return;
    }
    let folder = folder();
    let mut child = command(folder.path())
        .args(["simplify", "builtin:soup?n=400000"])
        .args(["--triangles", "400000", "-o", "a.obj"])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let names = || -> Vec<String> {
        let entries = fs::read_dir(folder.path()).unwrap();
        let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
        entries
            .map(|entry| name(entry).to_string_lossy().into_owned())
            .collect()
    };
    while names().is_empty() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    send("TERM", &child);
    match child.wait().unwrap().code() {
        Some(130) => assert!(names().iter().all(|name| name == "a.obj"), "{:?}", names()),
        code => assert_eq!((code, names()), (Some(0), vec!["a.obj".to_owned()])),
    }
}
