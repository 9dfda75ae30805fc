//! `boxwood bench`: the race as data, pages, and comparing with an earlier run.

mod common;

use std::{
    fs,
    process::Stdio,
    time::{Duration, Instant},
};

use common::{command, expect, folder, is_under_nohup, json, send, text};
use serde_json::Value;

const QUICK: [&str; 8] = [
    "bench",
    "builtin:terrain?n=2000",
    "--size",
    "16",
    "--rounds",
    "3",
    "--only",
    "grid,bvh2 binned aabb",
];

#[test]
fn bench_measures_every_set_in_every_way_and_saves_it() {
    let folder = folder();
    let at = folder.path();
    let files = ["--threads", "2", "--save", "a.json", "--html", "a.html"];
    let answer = json(at, &[&QUICK[..], &files].concat(), 0);
    assert_eq!(
        (&answer["schema"], &answer["same_answer"]),
        (&Value::from(1), &Value::from(true))
    );
    let rows = answer["rows"].as_array().unwrap();
    let names: Vec<_> = rows
        .iter()
        .map(|row| row["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["bvh2 binned aabb", "grid"]);
    for row in rows {
        assert!(
            row["build_ms"].as_f64() > Some(0.0) && row["bytes_per_triangle"].as_f64() > Some(10.0)
        );
        assert_eq!(row["agreement"]["rays"], row["agreement"]["same_bits"]);
        for way in ["single", "batch", "single_all", "batch_all"] {
            for set in ["primary", "shadow", "ao", "diffuse", "random"] {
                assert!(row[way][set].as_f64() > Some(0.0), "{way} {set}: {row}");
            }
        }
        let cells = row["cells"].as_array().unwrap();
        assert_eq!(cells.len(), 20);
        assert!(
            cells
                .iter()
                .all(|cell| cell["of_floor"].as_f64() > Some(0.0))
        );
    }
    let saved: Value =
        serde_json::from_str(&fs::read_to_string(at.join("a.json")).unwrap()).unwrap();
    assert_eq!(saved["rows"], answer["rows"]);
    let page = fs::read_to_string(at.join("a.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("<svg"));
}

#[test]
fn bench_names_what_got_worse_and_ends_with_1() {
    let folder = folder();
    let at = folder.path();
    let with = |more: &[&'static str]| [&QUICK[..], more].concat();
    expect(at, &with(&["--save", "before.json"]), 0);
    // To a hundredth: no machine is as busy as that.
    let calm = expect(
        at,
        &with(&["--baseline", "before.json", "--tolerance", "10000"]),
        0,
    );
    assert!(
        text(&calm.stdout).contains("0 of "),
        "{}",
        text(&calm.stdout)
    );
    // Before, it was a million times as fast.
    let mut before: Value =
        serde_json::from_str(&fs::read_to_string(at.join("before.json")).unwrap()).unwrap();
    let cell = &mut before["rows"][1]["cells"][0];
    let what = format!(
        "grid, {}, {}, 1 thread",
        cell["set"].as_str().unwrap(),
        cell["mode"].as_str().unwrap()
    );
    cell["mrays"] = (1e6 * cell["mrays"].as_f64().unwrap()).into();
    cell["noise"] = 0.0.into();
    fs::write(at.join("before.json"), before.to_string()).unwrap();
    let worse = expect(
        at,
        &with(&[
            "--baseline",
            "before.json",
            "--tolerance",
            "1000",
            "--html",
            "a.html",
        ]),
        1,
    );
    assert!(
        text(&worse.stdout).contains(&format!("WORSE  {what}")),
        "{}",
        text(&worse.stdout)
    );
    assert!(
        fs::read_to_string(at.join("a.html"))
            .unwrap()
            .contains("Against the baseline")
    );
}

#[test]
fn bench_refuses_what_it_cannot_compare_or_find() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("no.json"), "{}").unwrap();
    let refusal = |args: &[&str], code| text(&expect(at, args, code).stderr);
    let error = refusal(&["bench", "builtin:bush", "--baseline", "no.json"], 3);
    assert!(
        error.contains("no.json: is not a report") && error.contains("help: save one"),
        "{error}"
    );
    let error = refusal(&["bench", "builtin:bush", "--only", "bvh3"], 2);
    assert!(
        error.contains("--only bvh3") && error.contains("boxwood list"),
        "{error}"
    );
    let error = refusal(&["bench", "builtin:bush", "--html", "a.txt"], 2);
    assert!(error.contains(".html"), "{error}");
    let away = ["--vp", "0,900,0", "--vi", "0,1900,1"];
    let error = refusal(&[&["bench", "builtin:bush"][..], &away].concat(), 2);
    assert!(
        error.contains("sees nothing") && error.contains("help: give another camera"),
        "{error}"
    );
}

#[cfg_attr(not(unix), ignore = "sends signals")]
#[test]
fn bench_ends_soon_after_ctrl_c() {
    if is_under_nohup() {
        return;
    }
    let folder = folder();
    // Long enough to be built, much too short for a first round: brute force is among them.
    let child = command(folder.path())
        .args(["bench", "builtin:terrain?n=100000", "--only", "list,grid"])
        .args(["--size", "512", "--rounds", "1000"])
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(8));
    send("INT", &child);
    let start = Instant::now();
    let output = child.wait_with_output().unwrap();
    if output.status.code().is_none() {
        println!("the machine was too slow to begin");
        return;
    }
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
    // A second or two; a debug build on a busy machine takes its time, but not the minute and more of counting everything.
    let time = start.elapsed();
    assert!(time < Duration::from_secs(20), "{time:?}");
}
