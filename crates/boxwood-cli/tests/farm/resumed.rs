//! What was killed, cut off or interrupted goes on.

use crate::common::{command, expect, folder, json, send, text};
use crate::help::{SIZE, names, refusal, spawn, words};
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

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
    if crate::common::is_under_nohup() {
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
    send("INT", &child);
    let output = child.wait_with_output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(
        said.contains("% of the tiles are kept in ") && said.contains("a.png.tiles"),
        "{said}"
    );
    assert_eq!(names(at), ["a.png.tiles"]);
}
