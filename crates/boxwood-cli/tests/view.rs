//! `boxwood view` where there is no window: how it ends, and what survives.
#![cfg(feature = "view")]

mod common;

use std::{
    fs,
    path::Path,
    process::Stdio,
    time::{Duration, Instant},
};

use common::{SMALL, command, expect, folder, is_under_nohup, json, send, text};

const HILL: &str = "builtin:terrain?n=2000";

#[test]
fn output_that_cannot_be_written_ends_with_2_after_the_report() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("turn.script"), "orbit 3\n").unwrap();
    let mut line = vec!["view", HILL, SMALL, "--headless", "--script", "turn.script"];
    line.extend(["--state", "no/such/x.json"]);
    let output = expect(at, &line, 2);
    let (told, said) = (text(&output.stdout), text(&output.stderr));
    assert!(told.contains("orbit 360"), "{told}");
    assert!(
        said.contains("no/such/x.json") && said.contains("help: the folder does not exist"),
        "{said}"
    );
    if Path::new("/dev/full").exists() {
        fs::write(at.join("full.script"), "wait 1\nshot /dev/full\n").unwrap();
        let line = ["view", HILL, SMALL, "--headless", "--script", "full.script"];
        let said = text(&expect(at, &line, 2).stderr);
        assert!(
            said.contains("/dev/full") && said.contains("help: the disk is full"),
            "{said}"
        );
    }
}

#[test]
fn a_camera_that_shows_nothing_ends_with_2_and_the_way_out() {
    let folder = folder();
    let cases: [([&str; 2], &str); 3] = [
        (["--vp=1,2,3", "--vi=1,2,3"], "help: move --vi"),
        (["--camera", "99"], "counted from 0"),
        (["--fov", "180"], "less than 180"),
    ];
    for ([one, two], help) in cases {
        let line = ["view", "builtin:cornell", SMALL, "--headless", one, two];
        let said = text(&expect(folder.path(), &line, 2).stderr);
        assert!(said.contains(help), "{said}");
        assert_eq!(said.matches("builtin:cornell: ").count(), 1, "{said}");
    }
}

#[test]
fn sizes_that_no_memory_holds_are_refused_and_the_one_in_use_is_reported() {
    let folder = folder();
    let at = folder.path();
    let huge = ["view", HILL, "--headless", "--size", "65535x65535"];
    let said = text(&expect(at, &huge, 2).stderr);
    assert!(said.contains("more than 67,108,864 pixels"), "{said}");
    let line = [
        "view",
        HILL,
        "--headless",
        "--script",
        "s",
        "--state",
        "s.json",
    ];
    fs::write(at.join("s"), "orbit 2\n").unwrap();
    let remember = |size: &str| {
        let state = format!("{{\"version\": 1, \"size\": {size}}}");
        fs::write(at.join("s.json"), state).unwrap();
    };
    remember("[4000000000, 4000000000]");
    let said = text(&expect(at, &line, 3).stderr);
    assert!(said.contains("s.json: a size of 4000000000"), "{said}");
    remember("[0, 27]");
    let report = json(at, &line, 0);
    assert_eq!([&report["width"], &report["height"]], [1, 27]);
}

#[test]
fn a_scene_that_is_missing_is_told_once_and_leaves_the_state_as_it_was() {
    let folder = folder();
    let at = folder.path();
    let state = "{\"version\": 1, \"file\": \"gone.obj\", \"fov\": 20.0}";
    fs::write(at.join("s.json"), state).unwrap();
    let said = text(&expect(at, &["view", "--headless", SMALL, "--state", "s.json"], 3).stderr);
    assert_eq!(said.matches("gone.obj").count(), 1, "{said}");
    assert_eq!(fs::read_to_string(at.join("s.json")).unwrap(), state);
}

#[cfg(unix)]
#[test]
fn a_state_without_end_is_refused() {
    let folder = folder();
    let line = ["view", HILL, "--headless", SMALL, "--state", "/dev/zero"];
    let said = text(&expect(folder.path(), &line, 3).stderr);
    assert!(said.contains("not a regular file"), "{said}");
}

#[cfg_attr(not(unix), ignore = "sends signals")]
#[test]
fn an_interrupted_script_saves_the_state_and_ends_with_4() {
    if is_under_nohup() {
        return;
    }
    for signal in ["INT", "TERM"] {
        let folder = folder();
        let at = folder.path();
        fs::write(at.join("s"), "orbit 2\nshot ready.png\nstill 1000000\n").unwrap();
        let child = command(at)
            .args(["view", HILL, SMALL, "--headless", "--script", "s"])
            .args(["--state", "s.json"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let start = Instant::now();
        while !at.join("ready.png").exists() {
            assert!(start.elapsed() < Duration::from_secs(60), "no picture");
            std::thread::sleep(Duration::from_millis(10));
        }
        send(signal, &child);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
        assert!(text(&output.stdout).contains("orbit 360"));
        let state = fs::read_to_string(at.join("s.json")).unwrap();
        assert!(state.contains("builtin:terrain"), "{state}");
    }
}
