//! The trace of a walk: its numbers are the scene's, its stack is one, its JSON comes back.

mod common;

use boxwood::{Ray, Scene, Transform};
use boxwood_trace::{
    BoxVerdict, Event, InstanceVerdict, PrimitiveVerdict, WalkStep, WalkTrace, build, walk,
};
use common::{choices, heap, rays};
use std::collections::HashMap;
use std::sync::Arc;

fn for_every_walk(mut check: impl FnMut(&str, &Scene, &Ray, &WalkTrace)) {
    for choice in choices() {
        let scene = heap(choice);
        for ray in rays() {
            let trace = walk(&scene, &ray);
            check(&format!("{choice:?} {ray:?}"), &scene, &ray, &trace);
        }
    }
}

fn flops(event: &Event) -> (u32, u32) {
    match event {
        Event::Box(e) => (e.flops, e.bytes),
        Event::Cell(e) => (e.flops, e.bytes),
        Event::Primitive(e) => (e.flops, e.bytes),
        Event::Instance(e) => (e.flops, e.bytes),
    }
}

#[test]
fn hits_and_counts_are_those_of_the_scene_and_of_the_steps() {
    for_every_walk(|name, scene, ray, trace| {
        let mut counts = boxwood::Counts::default();
        let hit = scene.closest_hit_counted(ray, &mut counts);
        let found = trace.hit.map(|hit| (hit.t, hit.u, hit.v, hit.prim));
        assert_eq!(
            found,
            hit.map(|hit| (hit.t, hit.u, hit.v, hit.prim)),
            "{name}"
        );
        let sum = |f: &dyn Fn(&Event) -> u64| trace.steps.iter().map(|s| f(&s.event)).sum::<u64>();
        let tests = sum(&|e| u64::from(matches!(e, Event::Primitive(_))));
        let boxes =
            sum(&|e| u64::from(matches!(e, Event::Box(b) if b.verdict != BoxVerdict::Dropped)));
        let traced = &trace.counts;
        assert_eq!(
            (traced.primitive_tests, traced.box_tests),
            (tests, boxes),
            "{name}"
        );
        assert_eq!(traced.flops, sum(&|e| flops(e).0.into()), "{name}");
        assert_eq!(traced.bytes, sum(&|e| flops(e).1.into()), "{name}");
        assert_eq!(
            (traced.flops, traced.nodes),
            (counts.flops, counts.nodes),
            "{name}"
        );
        let best = trace.steps.last().and_then(|step| step.best_t);
        assert_eq!(best, trace.hit.map(|hit| hit.t), "{name}");
    });
}

/// The stack after a step follows from the one before: what has its turn goes, what is entered comes.
fn assert_stack(name: &str, nodes: &HashMap<u32, Option<u32>>, step: &WalkStep) {
    let (before, after) = (&step.stack_before, &step.stack_after);
    let parent = match &step.event {
        Event::Box(test) => test.parent,
        Event::Primitive(test) => test.leaf,
        _ => None,
    };
    // Only what was on top may be gone: the node at work, or a dropped one.
    let gone: Vec<&u32> = before.iter().filter(|node| !after.contains(node)).collect();
    if let [node] = gone[..] {
        let is_dropped = matches!(&step.event, Event::Box(b) if b.verdict == BoxVerdict::Dropped && b.node == *node);
        assert!(
            is_dropped || parent == Some(*node),
            "{name}: {node} is gone at {step:?}"
        );
        assert_eq!(
            before.last(),
            Some(node),
            "{name}: the last has its turn, {step:?}"
        );
    }
    assert!(gone.len() < 2, "{name}: {step:?}");
    let come: Vec<&u32> = after.iter().filter(|node| !before.contains(node)).collect();
    match &step.event {
        Event::Box(b) if b.verdict == BoxVerdict::Enter && nodes.contains_key(&b.node) => {
            assert_eq!(come, [&b.node], "{name}: {step:?}");
        }
        _ => assert!(come.is_empty(), "{name}: {step:?}"),
    }
}

#[test]
fn the_last_node_of_the_stack_has_its_turn_next() {
    let mut deepest = 0;
    for choice in choices() {
        if ["grid", "bounded"].contains(&choice.structure) {
            continue;
        }
        let scene = heap(choice);
        let mut nodes = HashMap::new();
        scene.query().for_each_node(&mut |node| {
            nodes.insert(node.node, node.prims);
        });
        for ray in rays() {
            let name = format!("{choice:?} {ray:?}");
            let trace = walk(&scene, &ray);
            let mut last: &[u32] = &[];
            for step in &trace.steps {
                assert_eq!(step.stack_before, last, "{name}");
                assert_stack(&name, &nodes, step);
                last = &step.stack_after;
                deepest = deepest.max(last.len());
                if let Event::Primitive(test) = &step.event {
                    assert!(
                        choice.structure == "list" || nodes[&test.leaf.unwrap()].is_some(),
                        "{name}: a leaf holds the primitive"
                    );
                }
            }
            assert!(last.is_empty(), "{name}: {last:?} waits in vain");
        }
    }
    assert!(deepest > 4, "{deepest}");
}

#[test]
fn primitives_stand_in_the_leaf_that_the_build_put_them_in() {
    for choice in choices() {
        if choice.structure != "bvh2" {
            continue;
        }
        let scene = heap(choice);
        let tree = build(&scene, usize::MAX).unwrap().tree.unwrap();
        for ray in rays() {
            for step in walk(&scene, &ray).steps {
                if let Event::Primitive(test) = step.event {
                    let leaf = tree.nodes[test.leaf.unwrap() as usize];
                    let slots = leaf.first as usize..(leaf.first + leaf.count) as usize;
                    assert!(tree.order[slots].contains(&test.prim), "{choice:?} {ray:?}");
                }
            }
        }
    }
}

#[test]
fn nested_objects_show_the_calls_that_are_open() {
    let choice = choices()
        .into_iter()
        .find(|c| c.structure == "bounded")
        .unwrap();
    let trace = walk(&heap(choice), &rays()[0]);
    for step in &trace.steps {
        match &step.event {
            Event::Box(test) => assert_eq!(
                step.stack_after.last().copied(),
                match test.verdict {
                    BoxVerdict::Enter => Some(test.node),
                    _ => test.parent,
                }
            ),
            Event::Primitive(test) => assert_eq!(step.stack_after.last().copied(), test.leaf),
            _ => panic!("{step:?}"),
        }
    }
}

#[test]
fn a_grid_is_walked_from_face_to_face() {
    let choice = choices()
        .into_iter()
        .find(|c| c.structure == "grid")
        .unwrap();
    let scene = heap(choice);
    let mut steps = 0;
    for ray in rays() {
        let trace = walk(&scene, &ray);
        let cells: Vec<_> = trace
            .steps
            .iter()
            .filter_map(|step| match &step.event {
                Event::Cell(cell) => Some(cell),
                _ => None,
            })
            .collect();
        for pair in cells.windows(2) {
            let next = |k: usize| pair[0].t_next[k].unwrap_or(f64::INFINITY);
            let axis = (0..3).min_by(|&a, &b| next(a).total_cmp(&next(b))).unwrap();
            assert_eq!(pair[1].enter, pair[0].t_next[axis]);
            assert_eq!(pair[1].t_delta, pair[0].t_delta);
            let delta = pair[0].t_delta[axis].unwrap();
            assert_eq!(pair[1].t_next[axis], Some(next(axis) + delta));
            let apart = (0..3).map(|k| pair[0].cell[k].abs_diff(pair[1].cell[k]));
            assert_eq!(apart.sum::<u32>(), 1);
            steps += 1;
        }
    }
    assert!(steps > 50, "{steps}");
}

#[test]
fn json_comes_back_with_the_same_bits() {
    for_every_walk(|name, _, _, trace| {
        let json = serde_json::to_string(trace).unwrap();
        let back: WalkTrace = serde_json::from_str(&json).unwrap();
        assert_eq!(&back, trace, "{name}");
        assert_eq!(serde_json::to_string(&back).unwrap(), json, "{name}");
    });
}

#[test]
fn the_text_says_the_same_as_the_data() {
    for_every_walk(|name, _, _, trace| {
        let text = trace.text(usize::MAX);
        let lines = |part: &str| text.lines().filter(|line| line.contains(part)).count();
        let is = |verdict| {
            let same = |e: &Event| matches!(e, Event::Primitive(p) if p.verdict == verdict);
            trace.steps.iter().filter(|step| same(&step.event)).count()
        };
        assert_eq!(
            lines("the closest so far"),
            is(PrimitiveVerdict::Closest),
            "{name}\n{text}"
        );
        assert_eq!(
            lines("not the closest"),
            is(PrimitiveVerdict::Farther),
            "{name}\n{text}"
        );
        assert_eq!(
            lines("edges"),
            trace.counts.primitive_tests as usize,
            "{name}\n{text}"
        );
        match &trace.hit {
            Some(hit) => {
                assert!(text.contains(&format!("\nhit: triangle {} at t = {}, ", hit.prim, hit.t)));
            }
            None => assert!(text.contains("\nno hit\n"), "{text}"),
        }
        if trace.steps.len() > 3 {
            let rest = format!("\n... and {} steps more\n", trace.steps.len() - 3);
            assert!(trace.text(3).contains(&rest), "{name}");
        }
    });
}

#[test]
fn inside_an_instance_numbers_and_stack_are_its_own() {
    let choice = choices()
        .into_iter()
        .find(|c| c.structure == "bvh2")
        .unwrap();
    let inside = Arc::new(heap(choice));
    let scene = Scene::builder()
        .instance(&inside, Transform::IDENTITY)
        .instance(&inside, Transform::translation([0.0, 0.0, 20.0]))
        .structure("bvh2")
        .build()
        .unwrap();
    let ray = rays()[0];
    let (trace, alone) = (walk(&scene, &ray), walk(&inside, &ray));
    let [one, other] = [&trace, &alone].map(|trace| trace.hit.unwrap());
    assert_eq!((one.t, one.prim, one.inst), (other.t, other.prim, Some(0)));
    let closest = |trace: &WalkTrace| -> Vec<(Option<u32>, u32)> {
        let test = |step: &WalkStep| match &step.event {
            Event::Primitive(test) => Some((test.leaf, test.prim)),
            _ => None,
        };
        trace.steps.iter().filter_map(test).collect()
    };
    assert_eq!(closest(&trace), closest(&alone));
    let entered = |step: &&WalkStep| matches!(&step.event, Event::Instance(i) if i.verdict == InstanceVerdict::Enter);
    let entered = trace.steps.iter().filter(entered).count();
    assert_eq!(trace.counts.instances, entered as u64);
    let depth = |trace: &WalkTrace| trace.steps.iter().map(|step| step.depth).max().unwrap();
    assert_eq!(depth(&trace), depth(&alone) + 2);
}
