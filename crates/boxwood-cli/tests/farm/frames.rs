//! Lists and paths of frames, and plans of them.

use crate::common::{command, expect, folder, json, text};
use crate::help::{SIZE, names, refusal};
use std::fs;

#[test]
fn a_path_without_a_camera_between_its_keys_is_refused_before_the_first_frame() {
    let folder = folder();
    let at = folder.path();
    let path = r#"{"boxwood-path": 1, "interpolation": "linear", "keys": [
        {"frame": 1, "eye": [278, 273, -800], "target": [278, 273, 0]},
        {"frame": 3, "eye": [278, 273, 0], "target": [278, 273, -800]}
    ]}"#;
    fs::write(at.join("turn.json"), path).unwrap();
    let args = ["render", "builtin:cornell", SIZE, "--path", "turn.json"];
    let error = refusal(at, &args, 2);
    assert!(error.contains("frame 2: camera"), "{error}");
    assert_eq!(names(at), ["turn.json"]);
}

#[test]
fn frames_are_made_by_lists_shares_and_paths_and_are_those_of_single_runs() {
    let folder = folder();
    let at = folder.path();
    let turn = [
        "render",
        "builtin:bush",
        SIZE,
        "--shading=normal",
        "--turntable",
        "8",
        "-o",
        "t.##.png",
    ];
    let run = |more: &[&str]| json(at, &[&turn[..], more].concat(), 0);
    let report = run(&["--frames", "1-8x3"]);
    let outputs: Vec<&str> = report["frames"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| f["output"].as_str().unwrap())
        .collect();
    assert_eq!(outputs, ["t.01.png", "t.04.png", "t.07.png"]);
    let second = run(&["--shard=2/4", "--skip-existing"]);
    assert_eq!(second["frames"].as_array().unwrap().len(), 2);
    assert_eq!(
        names(at),
        ["t.01.png", "t.02.png", "t.04.png", "t.06.png", "t.07.png"]
    );
    let rest = run(&["--skip-existing"]);
    assert_eq!(
        (
            rest["frames"].as_array().unwrap().len(),
            rest["skipped"].as_array().unwrap().len()
        ),
        (3, 5)
    );
    let kept = json(
        at,
        &[
            &turn[..4],
            &["--turntable=8", "--frames=6", "--resume", "-o", "kept.png"],
        ]
        .concat(),
        0,
    );
    assert_eq!(kept["frames"][0]["resumed_tiles"], 0);
    let before = fs::read(at.join("t.06.png")).unwrap();
    assert!(before == fs::read(at.join("kept.png")).unwrap());
    assert!(before != fs::read(at.join("t.05.png")).unwrap());
    fs::remove_file(at.join("t.06.png")).unwrap();
    assert_eq!(run(&["--frame=6"])["frame"], 6);
    assert!(fs::read(at.join("t.06.png")).unwrap() == before);
    assert_eq!(run(&["--skip-existing"])["frames"], serde_json::json!([]));

    fs::write(at.join("cam.json"), CAM).unwrap();
    let flight = [
        "render",
        "builtin:cornell",
        SIZE,
        "--path",
        "cam.json",
        "--shading=path",
        "--spp=1",
    ];
    expect(at, &[&flight[..], &["--frames=3,1"]].concat(), 0);
    let one = [&flight[..], &["--frame=3", "-o", "x.png"]].concat();
    expect(at, &one, 0);
    let [a, b] = ["cornell.0003.png", "x.png"].map(|name| fs::read(at.join(name)).unwrap());
    assert!(a == b && at.join("cornell.0001.png").exists());
    // A frame by tiles.
    for shard in ["--shard=1/2", "--shard=2/2"] {
        expect(at, &[&one[..], &[shard]].concat(), 0);
    }
    expect(
        at,
        &["merge", "x.png.1of2.part", "x.png.2of2.part", "-o", "y.png"],
        0,
    );
    assert!(fs::read(at.join("y.png")).unwrap() == a);
}

const CAM: &str = r#"{"boxwood-path": 1, "fps": 24, "keys": [
    {"frame": 1, "eye": [278, 273, -800], "target": [278, 273, 0]},
    {"frame": 4, "eye": [400, 300, 60], "target": [150, 150, 400], "fov": 60}
]}"#;

#[test]
fn a_dry_run_says_what_would_be_made_and_makes_nothing() {
    let folder = folder();
    let at = folder.path();
    let args = [
        "render",
        "no-such.obj",
        "--turntable=4",
        "-o",
        "t.{frame:03}.exr",
        "--dry-run",
    ];
    let said = text(&expect(at, &args, 0).stdout);
    assert!(
        said.starts_with("t.001.exr, frame 1 would be made\n"),
        "{said}"
    );
    assert_eq!(said.lines().count(), 4);
    fs::write(at.join("t.002.exr"), "whole").unwrap();
    fs::write(at.join("t.003.exr"), "").unwrap();
    let report = json(
        at,
        &[&args[..], &["--skip-existing", "--shard=1/1"]].concat(),
        0,
    );
    assert_eq!(report["skipped"], serde_json::json!(["t.002.exr"]));
    assert_eq!(report["pictures"].as_array().unwrap().len(), 3);
    assert_eq!(names(at), ["t.002.exr", "t.003.exr"]);
}

#[test]
fn plans_that_cannot_be_are_refused_before_the_scene_is_read() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("cam.json"), CAM).unwrap();
    fs::write(at.join("bad.json"), CAM.replace("[400,", "[[")).unwrap();
    fs::write(at.join("typo.json"), CAM.replace("\"fov\"", "\"fow\"")).unwrap();
    let cases: [(&[&str], i32, &str); 14] = [
        (
            &["--frames", "1-4"],
            2,
            "all frames would be the same picture",
        ),
        (
            &["--turntable=4", "-o", "a.png"],
            2,
            "4 frames cannot all be this one file",
        ),
        (
            &["--turntable=4", "-o", "{scene}.png"],
            2,
            "{scene} is not known",
        ),
        (&["-o", "a.{frame}.png"], 2, "which frame?"),
        (
            &["--turntable=4", "--frames=1-4:2"],
            2,
            "a step is written as 1-240x2",
        ),
        (&["--turntable=0"], 2, "0 is not in 1..="),
        (
            &["--path=cam.json", "--frames=3-7"],
            2,
            "frame 5 is not on the path, which goes from frame 1 to 4",
        ),
        (&["--path=cam.json", "--fov=20"], 2, "cannot be used with"),
        (&["--path=bad.json"], 3, "bad.json:3:"),
        (&["--path=typo.json"], 3, "unknown field `fow`"),
        (&["--path=none.json"], 3, "none.json"),
        (&["--shard=0/4"], 2, "counted from 1"),
        (
            &["--shard=auto"],
            2,
            "neither SLURM_ARRAY_TASK_ID nor JOB_COMPLETION_INDEX is set",
        ),
        (&["--shard=1/2", "-o", "-"], 2, "need files"),
    ];
    for (args, code, what) in cases {
        let mut command = command(at);
        for name in ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX"] {
            command.env_remove(name);
        }
        let output = command
            .args(["render", "no-such.obj"])
            .args(args)
            .output()
            .unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{args:?}\n{said}");
        assert!(said.contains(what), "{args:?}\n{said}");
    }
}
