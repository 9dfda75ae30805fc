//! The command line as its users meet it: the binary itself, run in a folder of its own.

use std::{
    fs,
    io::Write,
    path::Path,
    process::{Command, Output, Stdio},
};

use serde_json::Value;

const SMALL: &str = "--size=48x27";

fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_boxwood"));
    command.current_dir(folder).stdin(Stdio::null());
    command
}

#[track_caller]
fn run(folder: &Path, args: &[&str]) -> Output {
    command(folder)
        .args(args)
        .output()
        .expect("the binary runs")
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder for the test")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs, and says everything if the exit code is another.
#[track_caller]
fn expect(folder: &Path, args: &[&str], code: i32) -> Output {
    let output = run(folder, args);
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(
        output.status.code(),
        Some(code),
        "boxwood {}\n{out}\n{err}",
        args.join(" ")
    );
    output
}

#[track_caller]
fn json(folder: &Path, args: &[&str], code: i32) -> Value {
    let mut with_json = args.to_vec();
    with_json.push("--json");
    let output = expect(folder, &with_json, code);
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{args:?}: {e}\n{}", text(&output.stdout)))
}

/// The names under "Commands:" in the help.
fn commands() -> Vec<String> {
    let help = text(&expect(&folder().path().to_owned(), &["--help"], 0).stdout);
    let (_, list) = help
        .split_once("Commands:\n")
        .expect("help lists the commands");
    let lines = list.lines().take_while(|line| line.starts_with("  "));
    lines
        .filter(|line| !line.starts_with("   "))
        .map(|line| line.split_whitespace().next().unwrap().to_owned())
        .collect()
}

#[test]
fn every_command_has_help_with_examples_and_a_manual_page() {
    let folder = folder();
    let commands = commands();
    assert!(
        commands.len() >= 14 && commands[0] == "demo",
        "{commands:?}"
    );
    for name in &commands {
        let help = text(&expect(folder.path(), &[name, "--help"], 0).stdout);
        assert!(
            help.contains("Usage:") && help.contains("Examples:") && help.contains("--json"),
            "{name}:\n{help}"
        );
        assert!(
            help.contains(&format!("boxwood {name}")) || name == "demo",
            "{name} has no example of its own"
        );
        let page = text(&expect(folder.path(), &["man", name], 0).stdout);
        assert!(page.contains(&format!(".TH boxwood-{name}")), "{page}");
    }
    let help = text(&expect(folder.path(), &["--help"], 0).stdout);
    assert!(
        help.contains("Exit codes: 0") && help.contains("builtin:NAME"),
        "{help}"
    );
}

#[test]
fn every_command_prints_one_versioned_json_object() {
    let folder = folder();
    let at = folder.path();
    let hill = "builtin:terrain?n=2000";
    expect(at, &["render", "builtin:cornell", SMALL, "-o", "a.png"], 0);
    let lines: [&[&str]; 14] = [
        &["demo", "--size", "64x36"],
        &["render", hill, SMALL, "-o", "hill.png"],
        &["inspect", hill],
        &["cost"],
        &["bounds", hill],
        &["race", hill, SMALL],
        &["check", hill, "--rays", "200"],
        &["explain", hill, "--pixel", "24,13", SMALL],
        &["simplify", hill, "--triangles", "500", "-o", "hill.ply"],
        &["diff", "a.png", "a.png"],
        &["list"],
        &["doctor"],
        &["completions", "bash"],
        &["man"],
    ];
    let tested: Vec<&str> = lines.iter().map(|line| line[0]).collect();
    assert_eq!(tested, commands(), "this table has every command");
    for line in lines {
        let object = json(at, line, 0);
        assert_eq!(
            (&object["boxwood"], &object["command"]),
            (&Value::from(1), &Value::from(line[0]))
        );
    }
}

#[test]
fn the_demonstration_traces_one_frame_four_ways_with_one_answer() {
    let folder = folder();
    let report = json(folder.path(), &["demo", "--size", "64x36"], 0);
    assert_eq!(report["triangles"], 40_000);
    assert_eq!(report["brute_force_flops"], 64_u64 * 36 * 40_000 * 27);
    let ways = report["ways"].as_array().unwrap();
    assert_eq!(ways.len(), 4);
    assert!(
        ways.iter().all(|way| way["same_answer"] == true),
        "{ways:?}"
    );
    assert_eq!(ways[0]["primitive_tests_per_ray"], 40_000.0);
    assert!(
        ways[3]["primitive_tests_per_ray"].as_f64() < ways[1]["primitive_tests_per_ray"].as_f64()
    );
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
fn wrong_usage_ends_with_2_and_a_way_out() {
    let folder = folder();
    let cases: [(&[&str], &str); 16] = [
        (&["rendr"], "render"),
        (&["render"], "FILE"),
        (
            &["render", "builtin:bush", "--shading", "whited"],
            "whitted",
        ),
        (&["render", "builtin:bush", "--structure", "bhv2"], "bvh2"),
        (
            &["render", "builtin:bush", "--size", "0x3"],
            "as in 1280x720",
        ),
        (&["render", "builtin:bush", "--size", "70000x3"], "65535"),
        (&["render", "builtin:bush", "--threads", "0"], "threads"),
        (
            &["render", "builtin:cornell", "--fov", "180"],
            "choose more than 0 and less than 180",
        ),
        (
            &["render", "builtin:cornell", "--vp", "1,2"],
            "3 plain numbers",
        ),
        (
            &["render", "builtin:cornell", "--camera", "7"],
            "counted from 0",
        ),
        (
            &["render", "builtin:cornell", SMALL, "--crop", "0,0,49,3"],
            "within the picture",
        ),
        (
            &["render", "builtin:cornell", "--size", "60000x60000"],
            "crops",
        ),
        (
            &["render", "builtin:cornell", "-o", "a.jpg"],
            ".png or .exr",
        ),
        (
            &["render", "builtin:cornell", "-o", "no/such/a.png"],
            "create it",
        ),
        (
            &["render", "builtin:cornell", "-o", "-", "--json"],
            "standard output",
        ),
        (&["man", "rendre"], "known: demo, render"),
    ];
    for (args, remedy) in cases {
        let output = expect(folder.path(), args, 2);
        let error = text(&output.stderr);
        assert!(
            error.starts_with("error: ") && error.contains(remedy),
            "{args:?}: {error}"
        );
        assert!(output.stdout.is_empty(), "{args:?}");
    }
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        0,
        "nothing is written"
    );
}

#[test]
fn refused_inputs_end_with_3_and_name_file_line_and_cause() {
    let folder = folder();
    fs::write(
        folder.path().join("bad.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
    )
    .unwrap();
    fs::write(folder.path().join("bad.png"), "no picture").unwrap();
    let cases: [(&[&str], &str); 6] = [
        (&["inspect", "bad.obj"], "error: bad.obj:4: "),
        (&["render", "bad.obj"], "error: bad.obj:4: "),
        (&["inspect", "no-such.obj"], "error: no-such.obj: "),
        (&["inspect", "builtin:bsh"], "help: did you mean bush?"),
        (
            &["inspect", "builtin:soup?n=60000000"],
            "help: soup can have 1 to 50000000",
        ),
        (
            &["diff", "bad.png", "bad.png"],
            "error: bad.png: cannot read the picture",
        ),
    ];
    for (args, words) in cases {
        let output = expect(folder.path(), args, 3);
        assert!(
            text(&output.stderr).contains(words),
            "{args:?}: {}",
            text(&output.stderr)
        );
        assert!(output.stdout.is_empty(), "{args:?}");
    }
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
        assert!(
            found["triangles"].as_u64() > Some(30)
                && found["triangles"] == found["unique_triangles"],
            "{name}"
        );
        assert!(
            found["bounds"]["min"][0].as_f64() < found["bounds"]["max"][0].as_f64(),
            "{name}"
        );
        assert!(
            found["structure"]["sah_cost"].as_f64() > Some(1.0),
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
fn simplify_reaches_the_number_and_says_so() {
    let folder = folder();
    let args = [
        "simplify",
        "builtin:sphere?n=2000",
        "--triangles",
        "114",
        "-o",
        "ball.ply",
    ];
    let report = json(folder.path(), &args, 0);
    let found = json(folder.path(), &["inspect", "ball.ply"], 0);
    assert_eq!(
        (&report["triangles"], &found["triangles"]),
        (&Value::from(114), &Value::from(114))
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
fn a_reader_who_leaves_early_is_no_failure() {
    let folder = folder();
    for args in [
        &["completions", "bash"][..],
        &["list"],
        &["list", "--json"],
        &["man"],
    ] {
        let mut child = command(folder.path())
            .args(args)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(
            (output.status.code(), text(&output.stderr)),
            (Some(0), String::new()),
            "{args:?}"
        );
    }
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

#[cfg(unix)]
#[test]
fn ctrl_c_saves_what_is_done_and_ends_with_4() {
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
    let killed = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    let Ok(true) = killed.map(|status| status.success()) else {
        println!("skipped: there is no `kill` here");
        return;
    };
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
