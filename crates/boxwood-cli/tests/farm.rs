//! Pictures from many processes and from killed ones: the bytes are those of one process that was left alone.

mod common;

use std::{
    fs,
    path::Path,
    process::{Child, Stdio},
    time::Duration,
};

use common::{command, expect, folder, json, text};

/// Shadings with noise, with a scale over the whole picture, and with a measured exposure; both formats.
const LOOKS: [(&str, &str); 4] = [
    ("builtin:bush", "--shading=ao --spp=2"),
    ("builtin:stadium", "--shading=heat-tests"),
    ("builtin:cornell", "--shading=path --spp=2"),
    ("builtin:sphere", "--shading=depth --crop=7,5,90,50"),
];
/// Not a whole number of tiles.
const SIZE: &str = "--size=109x67";

fn words<'a>(scene: &'a str, look: &'a str, output: &'a str) -> Vec<&'a str> {
    let mut words = vec!["render", scene, SIZE, "-o", output];
    words.extend(look.split(' '));
    words
}

fn spawn(folder: &Path, args: &[&str]) -> Child {
    let mut command = command(folder);
    command.args(args).stdout(Stdio::null());
    command
        .stderr(Stdio::null())
        .spawn()
        .expect("the binary runs")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[track_caller]
fn refusal(folder: &Path, args: &[&str], code: i32) -> String {
    text(&expect(folder, args, code).stderr)
}

#[test]
fn four_processes_and_a_merge_give_the_bytes_of_one() {
    for (scene, look) in LOOKS {
        let folder = folder();
        let at = folder.path();
        for output in ["one.png", "one.exr"] {
            expect(at, &words(scene, look, output), 0);
        }
        let shards = ["--shard=1/4", "--shard=2/4", "--shard=3/4", "--shard=4/4"];
        let children: Vec<Child> = shards
            .iter()
            .map(|shard| spawn(at, &[&words(scene, look, "p.png")[..], &[shard]].concat()))
            .collect();
        for mut child in children {
            assert!(child.wait().unwrap().success(), "{scene} {look}");
        }
        let parts = [
            "p.png.3of4.part",
            "p.png.1of4.part",
            "p.png.4of4.part",
            "p.png.2of4.part",
        ];
        for (output, one) in [("p.png", "one.png"), ("p.exr", "one.exr")] {
            expect(at, &[&["merge"][..], &parts, &["-o", output]].concat(), 0);
            let [merged, one] = [output, one].map(|name| fs::read(at.join(name)).unwrap());
            assert!(merged == one, "{scene} {look} {output}");
        }
        assert_eq!(names(at).len(), 8, "no other files: {:?}", names(at));
    }
}

#[test]
fn a_shard_that_is_done_is_done_and_one_that_is_damaged_is_mended() {
    let folder = folder();
    let at = folder.path();
    let args = [
        &words("builtin:cornell", "--shading=normal", "a.png")[..],
        &["--shard=2/2"],
    ]
    .concat();
    let first = json(at, &args, 0);
    assert_eq!(
        (&first["shard"], &first["resumed_tiles"]),
        (&"2/2".into(), &0.into())
    );
    let part = at.join("a.png.2of2.part");
    let bytes = fs::read(&part).unwrap();
    assert!(
        !text(&bytes).contains("instructions"),
        "machines may differ"
    );
    let again = json(at, &args, 0);
    // 7 x 5 tiles.
    assert_eq!(again["resumed_tiles"], 17);
    assert!(fs::read(&part).unwrap() == bytes);
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 2] ^= 1;
    fs::write(&part, &damaged).unwrap();
    let said = text(&expect(at, &args, 0).stderr);
    assert!(said.contains("1 damaged tile passed over"), "{said}");
    // The rest stands where it stood, and the tile behind it.
    let mended = fs::read(&part).unwrap();
    assert!(mended.starts_with(&damaged) && mended.len() > bytes.len());
    assert_eq!(json(at, &args, 0)["resumed_tiles"], 17);
    assert_eq!(names(at), ["a.png.2of2.part"]);
    let other = [&args[..args.len() - 1], &["--shard=1/2"]].concat();
    expect(at, &other, 0);
    let parts = ["a.png.1of2.part", "a.png.2of2.part"];
    expect(at, &[&["merge"][..], &parts, &["-o", "m.png"]].concat(), 0);
    expect(at, &args[..args.len() - 1], 0);
    assert!(fs::read(at.join("m.png")).unwrap() == fs::read(at.join("a.png")).unwrap());

    // Where no size can be read, nothing is thrown away.
    let mut lost = bytes.clone();
    let header = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize + 20;
    lost[header + 8] ^= 1;
    fs::write(&part, &lost).unwrap();
    let error = refusal(at, &args, 3);
    assert!(
        error.contains(&format!("is damaged at byte {header}")),
        "{error}"
    );
    assert!(fs::read(&part).unwrap() == lost);
}

/// Starts, kills at a random moment, and starts again, until it comes through by itself.
fn kill_and_resume(folder: &Path, kills: usize, mut random: u64, within: Duration) {
    let at = folder;
    let look = "--shading=path --spp=8";
    let scene = "builtin:cornell";
    let resumed = [&words(scene, look, "a.png")[..], &["--resume"]].concat();
    let (mut left, mut resumed_with_tiles) = (kills, 0);
    while left > 0 {
        let log = fs::metadata(at.join("a.png.tiles"));
        // More than the header, which is shorter than a tile.
        resumed_with_tiles += usize::from(log.is_ok_and(|log| log.len() > 12_000));
        let mut child = spawn(at, &resumed);
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let share = (random >> 40) as f64 / f64::from(1 << 24);
        std::thread::sleep(within.mul_f64(share));
        child.kill().unwrap();
        if !child.wait().unwrap().success() {
            left -= 1;
        }
        let picture = at.join("a.png");
        if picture.exists() {
            // Ended before the kill, or between the picture and the end of the file of tiles.
            assert!(
                fs::read(&picture).unwrap() == fs::read(at.join("one.png")).unwrap(),
                "kill {left}"
            );
            fs::remove_file(picture).unwrap();
        }
    }
    expect(at, &resumed, 0);
    assert!(fs::read(at.join("a.png")).unwrap() == fs::read(at.join("one.png")).unwrap());
    assert!(!at.join("a.png.tiles").exists());
    assert!(
        resumed_with_tiles * 4 > kills,
        "{resumed_with_tiles} of {kills}"
    );
}

/// How long the picture takes, so that kills fall anywhere in it.
fn uninterrupted(folder: &Path) -> Duration {
    let start = std::time::Instant::now();
    expect(
        folder,
        &words("builtin:cornell", "--shading=path --spp=8", "one.png"),
        0,
    );
    start.elapsed()
}

#[test]
fn a_render_that_is_killed_and_resumed_gives_the_same_bytes() {
    let folder = folder();
    let time = uninterrupted(folder.path());
    kill_and_resume(folder.path(), 6, 1, time);
}

#[test]
#[ignore = "a hundred kills; `cargo xtask farm-test` runs it"]
fn a_hundred_kills_change_nothing() {
    let folder = folder();
    let time = uninterrupted(folder.path());
    kill_and_resume(folder.path(), 100, 2, time);
}

#[test]
fn a_torn_tail_is_dropped_and_the_rest_is_taken_over() {
    let folder = folder();
    let at = folder.path();
    let args = [
        &words("builtin:cornell", "--shading=uv", "a.png")[..],
        &["--shard=1/1"],
    ]
    .concat();
    expect(at, &args, 0);
    let (part, log) = (at.join("a.png.1of1.part"), at.join("a.png.1of1.tiles"));
    let whole = fs::read(&part).unwrap();
    expect(at, &["merge", "a.png.1of1.part", "-o", "one.png"], 0);
    // From a torn header on to all but the last byte.
    for cut in [0, 5, 40, whole.len() / 3, whole.len() - 1] {
        fs::remove_file(&part).unwrap();
        fs::write(&log, &whole[..cut]).unwrap();
        let report = json(at, &args, 0);
        let taken = report["resumed_tiles"].as_u64().unwrap();
        assert_eq!(taken > 0, cut > 1000, "cut at {cut}: {taken}");
        expect(at, &["merge", "a.png.1of1.part", "-o", "a.png"], 0);
        assert!(fs::read(at.join("a.png")).unwrap() == fs::read(at.join("one.png")).unwrap());
        assert!(!log.exists());
    }
}

#[cfg_attr(not(unix), ignore = "limits the size of files")]
#[test]
fn a_full_disk_leaves_whole_tiles() {
    let folder = folder();
    let at = folder.path();
    // Whole tiles only, so that their records have one length.
    let render =
        "render builtin:cornell --size 128x96 --shading normal --threads 4 -o a.png --resume";
    let boxwood = env!("CARGO_BIN_EXE_boxwood");
    let limited = format!("trap '' XFSZ; ulimit -f 64; exec '{boxwood}' {render}");
    let output = std::process::Command::new("sh")
        .current_dir(at)
        .args(["-c", &limited])
        .output()
        .unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    let log = fs::read(at.join("a.png.tiles")).unwrap();
    let header = u32::from_le_bytes(log[12..16].try_into().unwrap()) as usize + 20;
    let record = 12 + 64 + 16 * 16 * 44 + 4;
    let tiles = (log.len() - header) / record;
    assert!(
        tiles > 0 && (log.len() - header).is_multiple_of(record),
        "{} bytes",
        log.len()
    );
    let words: Vec<&str> = render.split(' ').collect();
    assert_eq!(json(at, &words, 0)["resumed_tiles"], tiles);
}

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
fn another_scene_and_other_options_are_refused_by_name() {
    let folder = folder();
    let at = folder.path();
    expect(
        at,
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
    let args = |more: &[&'static str]| {
        let base = ["render", "hill.obj", SIZE, "-o", "a.png", "--shard=1/2"];
        [&base[..], more].concat()
    };
    expect(at, &args(&[]), 0);
    let changes: [(&[&str], &str); 8] = [
        (&["--seed=7"], "--seed is 7 here and 0 there"),
        (&["--shading=ao"], "--shading is ao here and whitted there"),
        (&["--size=64x64"], "--size is 64x64"),
        (&["--crop=0,0,9,9"], "--crop is 0,0,9,9"),
        (&["--fov=20"], "--vp is"),
        (&["--light=1,2,3"], "--light is"),
        (
            &["--structure=grid"],
            "--structure is grid here and wide there",
        ),
        (&["--max-leaf=2"], "--max-leaf is 2 here and 4 there"),
    ];
    for (change, what) in changes {
        let error = refusal(at, &args(change), 3);
        let named = error.contains(what) || (what == "--vp is" && error.contains("--fov is 20"));
        assert!(
            named && error.contains("a.png.1of2.part: was begun for another picture"),
            "{error}"
        );
        assert!(error.contains("help: remove the file"), "{error}");
    }
    let hill = fs::read_to_string(at.join("hill.obj")).unwrap();
    let line = hill.lines().find(|line| line.starts_with("f ")).unwrap();
    let [a, b, c] = line[2..].split(' ').collect::<Vec<_>>()[..] else {
        panic!("{line}")
    };
    fs::write(
        at.join("hill.obj"),
        hill.replacen(line, &format!("f {b} {c} {a}"), 1),
    )
    .unwrap();
    let error = refusal(at, &args(&[]), 3);
    assert!(error.contains("the scene is "), "{error}");
}

#[test]
fn merge_refuses_what_does_not_go_together() {
    let folder = folder();
    let at = folder.path();
    let shard = |output: &str, look: &str, shard: &str| {
        let args = [
            &words("builtin:cornell", look, output)[..],
            &["--shard", shard],
        ]
        .concat();
        expect(at, &args, 0);
    };
    shard("a.png", "--shading=normal --spp=1", "1/3");
    shard("a.png", "--shading=normal --spp=1", "3/3");
    shard("b.png", "--shading=normal --spp=2", "2/3");
    let merge =
        |parts: &[&str]| refusal(at, &[&["merge"][..], parts, &["-o", "m.png"]].concat(), 3);
    let error = merge(&["a.png.1of3.part", "a.png.3of3.part"]);
    // 7 x 5 tiles, of which every third is missing.
    assert!(
        error.contains("12 of the picture's 35 tiles are missing: 1, 4, 7,"),
        "{error}"
    );
    let help = "boxwood render builtin:cornell --size=109x67 -o a.png --shading=normal --spp=1 --shard 2/3";
    assert!(error.contains(help), "{error}");
    let error = merge(&["a.png.1of3.part", "b.png.2of3.part"]);
    let what = "b.png.2of3.part: --spp is 2 here and 1 in a.png.1of3.part";
    assert!(error.contains(what), "{error}");
    let error = merge(&["a.png.1of3.part", "a.png.1of3.part"]);
    assert!(
        error.contains("tile 0 is in a.png.1of3.part too"),
        "{error}"
    );

    let bytes = fs::read(at.join("a.png.1of3.part")).unwrap();
    let mut damaged = bytes.clone();
    damaged[bytes.len() - 3000] ^= 4;
    fs::write(at.join("damaged"), &damaged).unwrap();
    assert!(merge(&["damaged"]).contains("is damaged at byte "));
    let mut other = bytes.clone();
    other[20] ^= 1;
    fs::write(at.join("other"), &other).unwrap();
    assert!(merge(&["other"]).contains("its header is damaged"));
    fs::write(at.join("torn"), &bytes[..bytes.len() - 1]).unwrap();
    assert!(merge(&["torn", "a.png.3of3.part"]).contains("13 of the picture's 35"));
    fs::write(at.join("short"), &bytes[..100]).unwrap();
    assert!(merge(&["short"]).contains("ends before its first tile"));
    fs::write(at.join("foreign"), "P6 1 1").unwrap();
    assert!(merge(&["foreign"]).contains("is not a file of tiles"));
    assert!(merge(&["none"]).contains("none: "));
    assert!(merge(&["."]).contains("is not a plain file"));
    assert!(!at.join("m.png").exists());
}

#[test]
fn a_second_process_on_the_same_tiles_is_sent_away() {
    let folder = folder();
    let at = folder.path();
    let look = "--shading=path --spp=20000";
    let args = [&words("builtin:cornell", look, "a.png")[..], &["--resume"]].concat();
    let mut child = spawn(at, &args);
    let log = at.join("a.png.tiles");
    while !fs::metadata(&log).is_ok_and(|found| found.len() > 0) {
        assert!(child.try_wait().unwrap().is_none(), "it works for long");
        std::thread::sleep(Duration::from_millis(5));
    }
    let error = refusal(at, &args, 4);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(
        error.contains("another process is at work on it"),
        "{error}"
    );
}

#[cfg_attr(not(unix), ignore = "sends signals")]
#[test]
fn ctrl_c_keeps_the_tiles_and_writes_no_half_picture() {
    if common::is_under_nohup() {
        return;
    }
    let folder = folder();
    let at = folder.path();
    let args = [
        &words("builtin:cornell", "--shading=path --spp=3000", "a.png")[..],
        &["--resume"],
    ]
    .concat();
    let mut child = {
        let mut command = command(at);
        command.args(&args).stderr(Stdio::piped()).spawn().unwrap()
    };
    // The first tile.
    let log = at.join("a.png.tiles");
    while !fs::metadata(&log).is_ok_and(|found| found.len() > 6000) {
        assert!(child.try_wait().unwrap().is_none(), "it works for long");
        std::thread::sleep(Duration::from_millis(5));
    }
    let killed = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(
        killed.is_ok_and(|status| status.success()),
        "there is a `kill`"
    );
    let output = child.wait_with_output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(
        said.contains("% of the tiles are kept in ") && said.contains("a.png.tiles"),
        "{said}"
    );
    assert_eq!(names(at), ["a.png.tiles"]);
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

#[test]
fn the_schedulers_say_which_shard_it_is() {
    let folder = folder();
    let at = folder.path();
    let auto = |variables: &[(&str, &str)]| {
        let mut command = command(at);
        command.args([
            "render",
            "builtin:cornell",
            "--turntable=8",
            "--shard=auto",
            "--dry-run",
        ]);
        let output = command.envs(variables.iter().copied()).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let slurm = auto(&[
        ("SLURM_ARRAY_TASK_ID", "7"),
        ("SLURM_ARRAY_TASK_MIN", "5"),
        ("SLURM_ARRAY_TASK_MAX", "8"),
        ("SLURM_ARRAY_TASK_COUNT", "4"),
    ]);
    assert_eq!(
        slurm,
        "cornell.0003.png, frame 3 would be made\ncornell.0007.png, frame 7 would be made\n"
    );
    let kubernetes = auto(&[("JOB_COMPLETION_INDEX", "7"), ("JOB_COMPLETIONS", "8")]);
    assert_eq!(kubernetes, "cornell.0008.png, frame 8 would be made\n");
}
