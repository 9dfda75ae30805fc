//! The commands that measure and explain: `cost`, `bounds`, `race`, `check`, `explain`.

use std::process::{Command, Output};

use serde_json::Value;

fn boxwood(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_boxwood"))
        .args(args)
        .output()
        .unwrap()
}

/// What the command prints, having ended with `code`.
#[track_caller]
fn text(args: &[&str], code: i32) -> String {
    let output = boxwood(args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {stderr}");
    assert!(
        code != 0 || stderr.is_empty(),
        "{args:?} is not quiet: {stderr}"
    );
    String::from_utf8(output.stdout).unwrap()
}

/// The JSON object that the command prints.
#[track_caller]
fn json(args: &[&str]) -> Value {
    let answer: Value = serde_json::from_str(&text(&[args, &["--json"]].concat(), 0)).unwrap();
    assert_eq!(
        (&answer["boxwood"], &answer["command"]),
        (&Value::from(1), &Value::from(args[0]))
    );
    answer
}

#[track_caller]
fn rows<'a>(answer: &'a Value, field: &str) -> &'a [Value] {
    answer[field]
        .as_array()
        .unwrap_or_else(|| panic!("no {field} in {answer}"))
}

#[track_caller]
fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn cost_is_the_arithmetic_of_the_slides() {
    let usual = json(&["cost"]);
    assert_eq!(usual["pixels"], 921_600);
    assert_eq!(usual["triangles"], 40_000);
    assert_eq!(usual["flops_per_test"], 27);
    assert_eq!(usual["brute_force_flops"], 995_328_000_000_u64);
    assert_eq!(
        json(&["cost", "--triangles", "114"])["brute_force_flops"],
        2_836_684_800_u64
    );
    let small = json(&["cost", "--size", "10x7", "--triangles", "3"]);
    assert_eq!(small["brute_force_flops"], 10 * 7 * 3 * 27);

    let frames = rows(&usual, "frames");
    assert_eq!(frames[0]["seconds_per_frame"], 9.95328);
    assert_eq!(frames[1]["seconds_per_frame"], 4.97664);
    assert!(number(&usual["peak"]["gflops"]) > 0.05);
}

#[test]
fn cost_says_what_the_slides_said_and_what_is_executed() {
    let text = text(&["cost"], 0);
    for part in [
        "1280 x 720 = 921,600 pixels",
        "x 114 triangles x 27 flop = 2,836,684,800 flop per frame",
        "x 40,000 triangles x 27 flop = 995,328,000,000 flop per frame",
        "100 GFLOPS",
        "200 GFLOPS",
        "29 / 45 / 51",
    ] {
        assert!(text.contains(part), "no {part:?} in\n{text}");
    }
}

#[test]
fn cost_of_a_scene_counts_what_each_structure_executes() {
    let answer = json(&["cost", "builtin:bush?n=4000", "--size", "64x36"]);
    let (pixels, triangles) = (64 * 36, 4000);
    assert_eq!(
        (&answer["pixels"], &answer["triangles"]),
        (&Value::from(pixels), &Value::from(triangles))
    );
    let structures = rows(&answer["scene"], "structures");
    assert_eq!(structures[0]["name"], "list");
    assert_eq!(structures[0]["primitive_tests"], pixels * triangles);
    assert_eq!(structures[0]["counted"], false);
    for structure in &structures[1..] {
        assert_eq!(structure["rays"], pixels);
        let tests = number(&structure["primitive_tests"]);
        assert!(
            tests > 0.0 && tests < 0.1 * f64::from(pixels * triangles),
            "{structure}"
        );
        assert!(number(&structure["times_less"]) > 10.0, "{structure}");
        assert!(
            number(&structure["flops"]) > 30.0 * tests
                && number(&structure["bytes"]) > 36.0 * tests
        );
    }
    assert!(structures.iter().any(|s| s["name"] == "grid") && structures.len() > 5);
}

#[test]
fn check_finds_no_difference_in_a_closed_and_an_open_scene() {
    let ball = json(&[
        "check",
        "builtin:sphere?n=200",
        "--rays",
        "2000",
        "--aim",
        "vertices",
        "--seed",
        "5",
    ]);
    for (field, expected) in [
        ("rays", 2000),
        ("differences", 0),
        ("misses", 0),
        ("parity_errors", 0),
        ("seed", 5),
    ] {
        assert_eq!(ball[field], expected, "{field}");
    }
    assert_eq!(
        (&ball["closed"], &ball["aim"]),
        (&Value::from(true), &Value::from("vertices"))
    );
    assert!(number(&ball["parity_rays"]) > 1900.0 && number(&ball["hits"]) > 500.0);
    let structures = rows(&ball, "rays_by_structure");
    assert_eq!(ball["structures"], structures.len());
    assert!(
        structures.len() > 20
            && structures
                .iter()
                .all(|row| row["rays"] == 2000 && row["differences"] == 0)
    );

    let cornell = json(&["check", "builtin:cornell", "--rays", "3000"]);
    assert_eq!(
        (&cornell["differences"], &cornell["parity_errors"]),
        (&Value::from(0), &Value::from(0))
    );
}

#[test]
fn check_says_how_many_rays_each_structure_got() {
    let flags = [
        "check",
        "builtin:soup?n=30000",
        "--rays",
        "2000",
        "--oracle-budget",
        "0",
    ];
    let answer = json(&flags);
    assert_eq!(answer["oracle_rays"], 1);
    let text = text(&flags, 0);
    assert!(
        text.contains(
            "the first 1 rays were compared with brute force, the other 1,999 with wide binned"
        ),
        "{text}"
    );
    assert!(
        text.contains("\n0 differences, 0 of them lost hits\n"),
        "{text}"
    );
}

#[test]
fn check_has_the_same_digest_for_any_number_of_threads() {
    let digest = |threads| {
        let answer = json(&[
            "check",
            "builtin:cornell",
            "--rays",
            "5000",
            "--threads",
            threads,
        ]);
        answer["digest"].as_str().unwrap().to_owned()
    };
    assert_eq!(digest("1"), digest("3"));
}

#[test]
fn race_gives_the_same_answer_in_every_lane() {
    let answer = json(&[
        "race",
        "builtin:bush?n=3000",
        "--rays",
        "3000",
        "--size",
        "160x90",
    ]);
    assert_eq!(answer["same_answer"], true);
    let parts = ["camera_rays", "bounced_rays", "random_rays"].map(|field| number(&answer[field]));
    assert!(
        parts.iter().all(|n| *n > 0.0) && parts.iter().sum::<f64>() == number(&answer["rays"]),
        "{parts:?}"
    );
    let structures = rows(&answer, "structures");
    assert_eq!(
        (&structures[0]["name"], &structures[0]["estimated"]),
        (&Value::from("list"), &Value::from(false))
    );
    assert_eq!(structures[0]["primitive_tests_per_ray"], 3000.0);
    for row in structures {
        assert!(
            row["same_answer"] == true
                && number(&row["ns_per_ray"]) > 1.0
                && number(&row["single_ns_per_ray"]) > 1.0,
            "{row}"
        );
        assert!(
            number(&row["mrays_per_second"]) > 0.0 && number(&row["bytes"]) > 1000.0,
            "{row}"
        );
    }
    assert!(
        structures[1..]
            .iter()
            .all(|row| number(&row["primitive_tests_per_ray"]) < 200.0)
    );
}

#[test]
fn race_has_as_many_random_rays_as_pixels() {
    let answer = json(&["race", "builtin:bush?n=3000", "--size", "64x36"]);
    let [camera, random] = ["camera_rays", "random_rays"].map(|field| number(&answer[field]));
    assert_eq!([camera, random], [2304.0; 2]);
}

#[test]
fn race_by_frames_draws_the_same_picture_in_every_lane() {
    let answer = json(&["race", "builtin:bush?n=3000", "--frames", "--size", "99x45"]);
    assert_eq!(answer["same_picture"], true);
    assert_eq!(answer["camera_rays"], 99 * 45);
    assert!(number(&answer["shadow_rays"]) > 100.0);
    let structures = rows(&answer, "structures");
    assert!(structures.len() > 2 && structures.iter().all(|row| row["name"] != "list"));
    for row in structures {
        let (share, ms) = (number(&row["query_share"]), number(&row["ms_per_frame"]));
        assert!(share > 0.0 && share <= 1.0, "{row}");
        let per_second = number(&row["frames_per_second"]);
        assert!((ms * per_second - 1e3).abs() < 1.0, "{row}");
    }
}

#[test]
fn race_marks_what_is_estimated() {
    let text = text(&["race", "builtin:soup?n=60000", "--rays", "2000"], 0);
    assert!(text.contains("\nlist est."), "{text}");
    assert!(
        text.contains("est.: list was asked about the first 333 rays"),
        "{text}"
    );
    assert!(!text.contains(" NO"), "{text}");
}

#[test]
fn bounds_weighs_each_volume() {
    let answer = json(&[
        "bounds",
        "builtin:bush?n=3000",
        "--rays",
        "2000",
        "--size",
        "160x90",
    ]);
    let volumes = rows(&answer, "volumes");
    let named = |name: &str| volumes.iter().find(|v| v["name"] == name).unwrap();
    assert_eq!(
        (
            &named("aabb")["volume_to_aabb"],
            &named("aabb")["area_to_aabb"]
        ),
        (&Value::from(1.0), &Value::from(1.0))
    );
    assert!(number(&named("obb")["area_to_aabb"]) <= 1.0 + 1e-5);
    assert_eq!(
        (
            &named("aabb")["flops_per_test"],
            &named("obb")["flops_per_test"]
        ),
        (&Value::from(24), &Value::from(63))
    );
    let kinds = rows(&answer, "kinds");
    assert_eq!(
        (&kinds[0]["rays"], &kinds[1]["rays"]),
        (&Value::from("camera"), &Value::from("random"))
    );
    for kind in kinds {
        let hit_object = number(&kind["hit_object"]);
        for volume in rows(kind, "volumes") {
            // Whoever hits the object hits its volume: the shares must fit together.
            let (hit, missed) = (
                number(&volume["hit_volume"]),
                number(&volume["hit_volume_but_miss_object"]),
            );
            assert!((hit * (1.0 - missed) - hit_object).abs() < 1e-9, "{volume}");
            assert!(
                number(&volume["list"]["bare_ns"]) > number(&volume["bvh2"]["bare_ns"]),
                "{volume}"
            );
        }
    }
    // Random lines through a sphere twice as large as the one around the box: most miss, so a volume pays.
    assert!(
        rows(&kinds[1], "volumes")
            .iter()
            .all(|v| v["list"]["is_worth_it"] == true),
        "{answer}"
    );
}

#[test]
fn bounds_ends_with_a_verdict() {
    let text = text(&["bounds", "builtin:sphere?n=800", "--rays", "500"], 0);
    for part in [
        "is a bounding volume around its 800 triangles worth it?",
        "500 camera rays",
        "500 random rays",
        "worth it, ",
    ] {
        assert!(text.contains(part), "no {part:?} in\n{text}");
    }
    let lines = text
        .lines()
        .filter(|line| line.contains("around a list of triangles: "))
        .count();
    assert_eq!(lines, 6, "a line for each volume and kind of rays");
}

#[test]
fn explain_tells_each_step_of_the_walk() {
    let flags = ["explain", "builtin:cornell", "--pixel", "640,360"];
    let text = text(&[&flags[..], &["--structure", "bvh2"]].concat(), 0);
    for part in [
        "box 0: t ",
        "\n  box 1 in 0: ",
        ", missed",
        ", entered",
        "edges ",
        "the closest so far",
        "\nhit: triangle ",
    ] {
        assert!(text.contains(part), "no {part:?} in\n{text}");
    }
    let hits: Vec<Value> = [
        &["--structure", "bvh2"],
        &["--structure", "wide"],
        &["--structure", "grid"],
        &["--structure", "list"],
        &["--structure", "bounded"],
    ]
    .map(|choice| json(&[&flags[..], &choice[..]].concat()))
    .into_iter()
    .map(|answer| {
        let steps = rows(&answer, "steps");
        let tests = steps
            .iter()
            .filter(|step| step["step"] == "primitive")
            .count();
        assert_eq!(answer["counts"]["primitive_tests"], tests);
        let closest = steps
            .iter()
            .rfind(|step| step["verdict"] == "closest")
            .unwrap();
        assert_eq!(
            (&closest["t"], &closest["best_t"]),
            (&answer["hit"]["t"], &answer["hit"]["t"])
        );
        answer["hit"].clone()
    })
    .collect();
    assert!(
        hits.iter()
            .all(|hit| *hit == hits[0] && hit["prim"].is_u64()),
        "{hits:?}"
    );
}

#[test]
fn explained_triangles_stand_under_their_leaf() {
    for structure in ["bvh2", "bounded"] {
        let answer = json(&[
            "explain",
            "builtin:bush?n=3000",
            "--pixel",
            "640,400",
            "--structure",
            structure,
            "--builder",
            "median",
        ]);
        let steps = rows(&answer, "steps");
        let leaf = |node: &Value| {
            steps
                .iter()
                .find(|step| step["step"] == "box" && step["node"] == *node)
                .unwrap()
        };
        let triangles: Vec<&Value> = steps
            .iter()
            .filter(|step| step["step"] == "primitive")
            .collect();
        assert!(!triangles.is_empty());
        for triangle in triangles {
            let leaf = leaf(&triangle["leaf"]);
            assert!(
                leaf["leaf_of"].is_u64() && leaf["verdict"] == "enter",
                "{triangle} in {leaf}"
            );
            assert_eq!(number(&triangle["depth"]), number(&leaf["depth"]) + 1.0);
        }
        for step in steps
            .iter()
            .filter(|step| step["step"] == "box" && step["parent"].is_u64())
        {
            let parent = leaf(&step["parent"]);
            assert_eq!(
                number(&step["depth"]),
                number(&parent["depth"]) + 1.0,
                "{step} in {parent}"
            );
        }
    }
}

#[test]
fn explain_says_of_no_ray_that_it_is_none_and_shortens_long_walks() {
    let text_of = |ray: &str, more: &[&str]| {
        text(
            &[&["explain", "builtin:cornell", "--ray", ray], more].concat(),
            0,
        )
    };
    let none = text_of("0,0,0,0,0,0", &[]);
    assert!(
        none.contains("this is no ray") && none.contains("\nno hit\n0 box tests"),
        "{none}"
    );
    let short = text_of(
        "278,273,-800,0,0,1",
        &["--structure", "list", "--lines", "3"],
    );
    assert!(short.contains("... and 29 steps more"), "{short}");
    assert_eq!(short.matches("\ntriangle ").count(), 3);
}

#[test]
fn impossible_requests_are_refused_with_a_way_out() {
    let refused = |args: &[&str], code: i32, part: &str| {
        let output = boxwood(args);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {stderr}");
        assert!(stderr.contains(part), "{args:?}: {stderr}");
    };
    refused(&["explain", "builtin:cornell"], 2, "--pixel");
    refused(
        &["explain", "builtin:cornell", "--pixel", "1280,0"],
        2,
        "choose from 0,0 to 1279,719",
    );
    refused(
        &["explain", "builtin:cornell", "--ray", "1,2,3"],
        2,
        "6 plain numbers",
    );
    refused(
        &["check", "builtin:cornell", "--aim", "sideways"],
        2,
        "mixed",
    );
    refused(&["check", "no-such-file.obj"], 3, "no-such-file.obj");
    refused(&["cost", "--triangles", "many"], 2, "many");
    refused(&["bounds", "builtin:cornell", "--rays", "0"], 2, "0");
}
