//! The trace of a build: replayed from its JSON it gives the structure, and walks know its nodes.

mod common;

use boxwood::BuildOptions;
use boxwood::build::{BuildInput, Builder};
use boxwood_trace::{
    Axis, BuildTrace, Event, LeafTrace, SplitTrace, StepTrace, WhyTrace, build, walk,
};
use common::{choices, heap, rays};
use std::collections::{HashMap, HashSet};

fn for_every_build(mut check: impl FnMut(&str, &boxwood::Scene, &BuildTrace)) {
    for choice in choices() {
        let scene = heap(choice);
        let trace = build(&scene, usize::MAX).unwrap();
        check(&format!("{choice:?}"), &scene, &trace);
    }
}

#[test]
fn json_comes_back_with_the_same_bits() {
    for_every_build(|name, _, trace| {
        let json = serde_json::to_string(trace).unwrap();
        let back: BuildTrace = serde_json::from_str(&json).unwrap();
        assert_eq!(&back, trace, "{name}");
        assert_eq!(serde_json::to_string(&back).unwrap(), json, "{name}");
    });
}

/// Splits all primitives by what the JSON says alone: the plane and the boxes, no slots.
#[test]
fn splitting_by_the_planes_of_the_json_gives_the_leaves() {
    let mut planes = 0;
    for_every_build(|name, scene, trace| {
        let trace: BuildTrace =
            serde_json::from_str(&serde_json::to_string(trace).unwrap()).unwrap();
        let boxes = scene.geometry().boxes();
        let mut sets: HashMap<u32, Vec<u32>> = HashMap::new();
        sets.insert(0, (0..boxes.len() as u32).collect());
        for step in &trace.steps {
            match step {
                StepTrace::Split(SplitTrace {
                    set,
                    plane,
                    children,
                }) => {
                    let mut prims = sets.remove(&set.node).unwrap();
                    let k = plane.axis as usize;
                    let center = |prim: &u32| {
                        let b = &boxes[*prim as usize];
                        (b.min[k] + b.max[k], *prim)
                    };
                    prims.sort_unstable_by(|a, b| {
                        let (a, b) = (center(a), center(b));
                        a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
                    });
                    let right = prims.split_off(plane.left as usize);
                    assert_eq!(right.len(), plane.right as usize, "{name}");
                    assert!(
                        center(&prims[prims.len() - 1]).0 <= 2.0 * plane.at + 1e-5,
                        "{name}"
                    );
                    assert!(center(&right[0]).0 >= 2.0 * plane.at - 1e-5, "{name}");
                    sets.insert(children[0], prims);
                    sets.insert(children[1], right);
                    planes += 1;
                }
                StepTrace::Leaf(LeafTrace { set, prims }) => {
                    let mut expected = sets.remove(&set.node).unwrap();
                    let mut prims = prims.clone();
                    expected.sort_unstable();
                    prims.sort_unstable();
                    assert_eq!(prims, expected, "{name}: leaf {}", set.node);
                }
                _ => {}
            }
        }
        let is_split = matches!(trace.steps.first(), Some(StepTrace::Split(_)));
        assert_eq!(sets.is_empty(), is_split, "{name}: every set has its step");
    });
    assert!(planes > 500, "{planes}");
}

#[test]
fn the_tree_is_that_of_the_builder() {
    for_every_build(|name, scene, trace| {
        let Some(builder) = &trace.builder else {
            assert_eq!(trace.tree, None, "{name}");
            return;
        };
        let boxes = scene.geometry().boxes();
        let input = BuildInput::of_boxes(&boxes);
        let input =
            match trace.structure.starts_with("wide") || trace.structure.starts_with("compact") {
                true => input.with_leaves(boxwood::build::LeafRule::ROWS_OF_8),
                false => input,
            };
        let builder = Builder::named(builder).unwrap();
        let options: &BuildOptions = scene.options();
        let tree = builder.build(&input, options).unwrap();
        let traced = trace.tree.as_ref().unwrap();
        assert_eq!(traced.order, tree.order, "{name}");
        assert_eq!(traced.nodes.len(), tree.nodes.len(), "{name}");
        for (a, b) in traced.nodes.iter().zip(&tree.nodes) {
            assert_eq!(
                (a.bounds, a.first, a.count),
                (b.bounds.into(), b.first, b.count),
                "{name}"
            );
        }
    });
}

#[test]
fn walks_and_builds_number_nodes_alike() {
    for_every_build(|name, scene, trace| {
        assert_eq!(
            (trace.nodes.len(), trace.nodes_total),
            (trace.stats.nodes, trace.stats.nodes)
        );
        let nodes: HashMap<u32, _> = trace.nodes.iter().map(|node| (node.node, node)).collect();
        assert_eq!(nodes.len(), trace.nodes.len(), "{name}");
        if trace.structure == "grid" {
            return;
        }
        for ray in rays() {
            for step in walk(scene, &ray).steps {
                if let Event::Box(test) = step.event {
                    let node = nodes[&test.node];
                    assert_eq!(
                        (node.parent, node.depth, node.prims),
                        (test.parent, step.depth, test.leaf_of),
                        "{name}"
                    );
                }
            }
        }
    });
}

#[test]
fn the_tree_of_bvh2_has_the_numbers_of_its_walks() {
    for_every_build(|name, _, trace| {
        if trace.structure.starts_with("bvh2") && trace.structure.contains("aabb") {
            let tree = trace.tree.as_ref().unwrap();
            for node in &trace.nodes {
                assert_eq!(tree.nodes[node.node as usize].bounds, node.bounds, "{name}");
            }
        }
    });
}

#[test]
fn the_text_has_every_step_and_its_numbers() {
    for_every_build(|name, _, trace| {
        let text = trace.text();
        let count = |part: &str| {
            text.lines()
                .filter(|line| line.trim_start().starts_with(part))
                .count()
        };
        let is = |f: fn(&StepTrace) -> bool| trace.steps.iter().filter(|step| f(step)).count();
        let splits = is(|s| matches!(s, StepTrace::Split(_)));
        let leaves = is(|s| matches!(s, StepTrace::Leaf(_)));
        assert_eq!(count("split into "), splits, "{name}\n{text}");
        assert_eq!(count("leaf of "), leaves, "{name}\n{text}");
        assert_eq!(count("node "), splits + leaves, "{name}\n{text}");
        let others = trace.steps.len() - splits - leaves;
        let grids = is(|s| matches!(s, StepTrace::Grid(_)));
        assert_eq!(count("round ") + grids, others, "{name}\n{text}");
        for part in [&trace.structure, &trace.outcome()] {
            assert!(text.contains(part.as_str()), "{name}: no {part} in\n{text}");
        }
    });
}

#[test]
fn a_limit_is_kept_and_the_totals_are_given() {
    for choice in choices() {
        let scene = heap(choice);
        let (whole, some) = (
            build(&scene, usize::MAX).unwrap(),
            build(&scene, 5).unwrap(),
        );
        assert_eq!(
            (some.steps_total, some.nodes_total),
            (whole.steps_total, whole.nodes_total)
        );
        assert_eq!(some.stats, whole.stats);
        assert!(some.steps.len() <= 5 && some.nodes.len() <= 5 && some.curve.len() <= 5);
        if whole.steps_total > 5 {
            assert_eq!(
                (some.steps.len(), some.order.len(), some.tree),
                (5, 0, None)
            );
            let rest = format!("\n... and {} steps more\n", whole.steps_total - 5);
            assert!(build(&scene, 5).unwrap().text().contains(&rest));
        }
    }
}

#[test]
fn every_kind_of_step_axis_and_reason_occurs() {
    let (mut axes, mut whys, mut kinds) = (HashSet::new(), HashSet::new(), HashSet::new());
    for_every_build(|_, _, trace| {
        for step in &trace.steps {
            kinds.insert(std::mem::discriminant(step));
            let set = match step {
                StepTrace::Split(split) => {
                    axes.insert(split.plane.axis as usize);
                    &split.set
                }
                StepTrace::Leaf(leaf) => &leaf.set,
                _ => continue,
            };
            whys.insert(format!("{:?}", set.why));
        }
    });
    assert_eq!(kinds.len(), 5, "split, leaf, merge, move, grid");
    assert!(
        [Axis::X, Axis::Y]
            .iter()
            .all(|axis| axes.contains(&(*axis as usize)))
    );
    for why in [WhyTrace::Few, WhyTrace::Cheaper, WhyTrace::Rule] {
        assert!(whys.contains(&format!("{why:?}")), "{why:?} of {whys:?}");
    }
}
