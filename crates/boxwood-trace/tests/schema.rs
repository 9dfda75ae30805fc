//! docs/trace.md and the JSON have the same fields, and its example is real.

mod common;

use boxwood::{Ray, Scene, Transform};
use boxwood_trace::{WalkTrace, build, walk};
use common::{choices, heap, rays};
use serde_json::Value;
use std::collections::BTreeSet;
use std::sync::Arc;

const DOCS: &str = include_str!("../../../docs/trace.md");

/// The names in backticks in the first column of all tables.
fn documented() -> BTreeSet<String> {
    DOCS.lines()
        .filter(|line| line.starts_with("| `"))
        .filter_map(|line| line.split('|').nth(1))
        .flat_map(|cell| cell.split('`').skip(1).step_by(2))
        .map(str::to_owned)
        .collect()
}

/// All names of fields, and all words that stand as values.
fn collect(value: &Value, fields: &mut BTreeSet<String>, words: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                fields.insert(key.clone());
                match value {
                    Value::String(word) if key != "structure" && key != "builder" => {
                        words.insert(word.clone());
                    }
                    _ => collect(value, fields, words),
                }
            }
        }
        Value::Array(all) => all.iter().for_each(|value| collect(value, fields, words)),
        _ => {}
    }
}

#[test]
fn every_field_and_word_is_documented_and_every_documented_field_occurs() {
    let (mut fields, mut words) = (BTreeSet::new(), BTreeSet::new());
    let mut add = |value: Value| collect(&value, &mut fields, &mut words);
    let mut scenes: Vec<Scene> = choices().into_iter().map(heap).collect();
    let inside = Arc::new(heap(choices()[0]));
    let placed = Scene::builder().instance(&inside, Transform::IDENTITY);
    scenes.push(placed.build().unwrap());
    for scene in &scenes {
        add(serde_json::to_value(build(scene, usize::MAX).unwrap()).unwrap());
        for ray in rays() {
            add(serde_json::to_value(walk(scene, &ray)).unwrap());
        }
    }
    assert_eq!(fields, documented());
    for word in &words {
        assert!(
            DOCS.contains(&format!("`{word}`")),
            "{word} is not documented"
        );
    }
    for word in [
        "enter",
        "dropped",
        "out of range",
        "closest",
        "leave",
        "cheaper",
        "x",
    ] {
        assert!(words.contains(word), "{word} does not occur in {words:?}");
    }
}

#[test]
fn the_example_is_what_the_crate_says() {
    let (_, example) = DOCS.split_once("```json walk\n").unwrap();
    let (example, _) = example.split_once("```").unwrap();
    let expected: WalkTrace = serde_json::from_str(example).unwrap();
    let positions = [[0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [0.0, 4.0, 5.0]];
    let scene = Scene::builder()
        .mesh(&positions, &[[0, 1, 2]])
        .structure("bvh2");
    let trace = walk(
        &scene.build().unwrap(),
        &Ray::new([1.0, 2.0, 0.0], [0.0, 0.0, 2.0]),
    );
    assert_eq!(
        trace,
        expected,
        "{}",
        serde_json::to_string_pretty(&trace).unwrap()
    );
}
