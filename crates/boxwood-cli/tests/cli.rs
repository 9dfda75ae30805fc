//! The command line as its users meet it: help, JSON, exit codes, pipes.

mod common;

use std::{fs, process::Stdio};

use common::{SMALL, command, expect, folder, json, text};
use serde_json::Value;

/// The names under "Commands:" in the help.
fn commands() -> Vec<String> {
    let help = text(&expect(folder().path(), &["--help"], 0).stdout);
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
        commands.len() >= 15 && commands[0] == "demo",
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
    fs::write(at.join("turn.script"), "wait 1\norbit 3\n").unwrap();
    expect(
        at,
        &["render", hill, SMALL, "--shard=1/1", "-o", "b.png"],
        0,
    );
    let lines: [&[&str]; 18] = [
        &["demo", "--size", "64x36"],
        &["render", hill, SMALL, "-o", "hill.png"],
        &["merge", "b.png.1of1.part", "-o", "b.png"],
        &["view", hill, "--headless", "--script", "turn.script", SMALL],
        &["inspect", hill],
        &["cost"],
        &["bounds", hill],
        &["race", hill, SMALL],
        &[
            "bench", hill, "--size", "16", "--rounds", "1", "--only", "grid",
        ],
        &["check", hill, "--rays", "200"],
        &["build", hill],
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
fn negative_numbers_are_told_their_range() {
    let folder = folder();
    let render = ["render", "builtin:cornell", SMALL];
    let cases: [(&[&str], &str); 9] = [
        (&["--fov", "-5"], "more than 0"),
        (&["--sky", "-1"], "0 or more"),
        (&["--top", "-3"], "0 or more"),
        (&["--density", "-1"], "0.01 to 64"),
        (&["--spp", "-1"], "not in 1"),
        (&["--crop", "-1,0,5,5"], "as in 320"),
        (&["--seed", "-1"], "0 or more"),
        (&["--threads", "-1"], "not in 1..=1024"),
        (&["--threads", "1025"], "not in 1..=1024"),
    ];
    let others: [(&[&str], &str); 4] = [
        (&["check", "builtin:cornell", "--rays", "-1"], "not in 1"),
        (
            &["explain", "builtin:cornell", "--pixel", "-1,5"],
            "640,360",
        ),
        (&["diff", "a", "b", "--threshold", "-1"], "0 to 1"),
        (&["cost", "--triangles", "-5"], "0 or more"),
    ];
    let with_render = cases.map(|(args, words)| ([&render[..], args].concat(), words));
    let others = others.map(|(args, words)| (args.to_vec(), words));
    for (args, words) in with_render.into_iter().chain(others) {
        let error = text(&expect(folder.path(), &args, 2).stderr);
        assert!(error.contains(words), "{args:?}: {error}");
    }
}

#[test]
fn scenes_without_triangles_are_refused_where_there_must_be_some() {
    let folder = folder();
    fs::write(folder.path().join("empty.obj"), "v 1 2 3\n").unwrap();
    for name in ["render", "bench"] {
        let said = text(&expect(folder.path(), &[name, "empty.obj"], 3).stderr);
        let expected = "error: empty.obj: the scene has no triangles\nhelp: give one that has some";
        assert!(said.contains(expected), "{name}: {said}");
    }
    let shape = text(&expect(folder.path(), &["inspect", "empty.obj"], 0).stdout);
    assert!(shape.contains("bounds      empty"), "{shape}");
}

#[test]
fn one_section_of_the_list_can_be_asked_for() {
    let folder = folder();
    let shown = text(&expect(folder.path(), &["list", "shadings"], 0).stdout);
    assert!(shown.starts_with("Shadings (--shading)\n") && !shown.contains("Structures"));
    let answer = json(folder.path(), &["list", "volumes"], 0);
    assert!(answer["volumes"].is_array() && answer["shadings"].is_null());
    let said = text(&expect(folder.path(), &["list", "colours"], 2).stderr);
    assert!(said.contains("shadings"), "{said}");
}

#[test]
fn scenes_at_the_end_of_the_numbers_are_shown_or_refused_in_plain_words() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("point.obj"), "v 1 1 1\nf 1 1 1\n").unwrap();
    expect(at, &["render", "point.obj", SMALL], 0);
    fs::write(
        at.join("huge.obj"),
        "v -1e30 0 0\nv 1e30 0 0\nv 0 1e30 1e30\nf 1 2 3\n",
    )
    .unwrap();
    expect(at, &["render", "huge.obj", SMALL], 0);
    fs::write(
        at.join("far.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 1e37\nv 0 1 0\nf 1 2 3\nf 1 2 4\n",
    )
    .unwrap();
    let said = text(&expect(at, &["render", "far.obj", SMALL], 0).stderr);
    assert!(
        said.contains("warning: 1 of 2 triangles lie beyond 2^100"),
        "{said}"
    );
    let eye = ["render", "builtin:cornell", SMALL, "--vp", "0,0,1e35"];
    let said = text(&expect(at, &eye, 2).stderr);
    assert!(said.contains("beyond 2^100"), "{said}");
    let said = text(&expect(at, &["inspect", ""], 2).stderr);
    assert!(said.contains("the name is empty"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn memory_that_is_not_there_is_refused_in_plain_words() {
    let folder = folder();
    let limited = |args: &str| {
        let line = format!(
            "ulimit -v 4000000; exec {} {args}",
            env!("CARGO_BIN_EXE_boxwood")
        );
        let mut shell = std::process::Command::new("sh");
        shell.current_dir(folder.path()).args(["-c", &line]);
        shell.output().expect("there is a shell")
    };
    let scene = limited("inspect 'builtin:soup?n=20000000'");
    assert_eq!(scene.status.code(), Some(3), "{}", text(&scene.stderr));
    assert!(text(&scene.stderr).contains("GiB are available"));
    let film = limited("render builtin:cornell --size 16384x16384 --threads 2");
    assert_eq!(film.status.code(), Some(2), "{}", text(&film.stderr));
    assert!(text(&film.stderr).contains("help: use --crop or a smaller --size"));
    let stdout = limited("list > /dev/full");
    assert_eq!(stdout.status.code(), Some(2));
    assert!(text(&stdout.stderr).starts_with("error: standard output: "));
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
