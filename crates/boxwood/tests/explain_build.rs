//! A build that is explained is the real build: its steps lead to the tree that the builder gives, bit for bit.

mod common;

use boxwood::build::{BuildInput, BuildStep, Choice, LeafRule, MergeStep, NodeMove, SetStep, Why};
use boxwood::build::{Topology, TopologyNode};
use boxwood::prims::Triangles;
use boxwood::{Aabb, AxisRule, BUILDERS, BuildOptions, BuildWalk, Builder, Scene};
use common::{Mesh, scenes, triangles};
use std::collections::HashMap;
use std::ops::Range;

fn boxes(prims: &Triangles) -> Vec<Aabb> {
    let bounds = prims.as_slice().iter().map(boxwood::Triangle::bounds);
    bounds
        .map(|b| if b.is_in_domain() { b } else { Aabb::EMPTY })
        .collect()
}

/// Scenes of all kinds, and one that is large enough for every part of the builders.
fn all() -> Vec<(&'static str, Mesh)> {
    let mut all = scenes();
    all.push(("a large star", common::star(60, 90, 5.0)));
    all
}

fn explained(
    mesh: &Mesh,
    options: &BuildOptions,
    rule: Option<LeafRule>,
) -> (BuildWalk, Vec<Aabb>) {
    let prims = Triangles::new(triangles(mesh));
    let boxes = boxes(&prims);
    let input = BuildInput::new(&prims, &boxes);
    let input = rule.map_or(input, |rule| input.with_leaves(rule));
    let walk = options
        .builder
        .explain(&input, options, usize::MAX)
        .unwrap();
    assert_eq!(walk.tree, options.builder.build(&input, options).unwrap());
    assert_eq!(walk.step_count, walk.steps.len());
    (walk, boxes)
}

fn for_every_build(mut check: impl FnMut(&str, &BuildOptions, &BuildWalk, &[Aabb])) {
    for (name, mesh) in all() {
        for builder in BUILDERS {
            for (axis, bins, max_leaf) in [(AxisRule::Longest, 16, 4), (AxisRule::RoundRobin, 7, 1)]
            {
                let options = BuildOptions {
                    axis,
                    bins,
                    max_leaf,
                    round_share: 0.3,
                    split_budget: 0.3,
                    ..BuildOptions::with(*builder)
                };
                for rule in [None, Some(LeafRule::ROWS_OF_8)] {
                    let (walk, boxes) = explained(&mesh, &options, rule);
                    let name = format!("{} of {name}", builder.name);
                    check(&name, &options, &walk, &boxes);
                }
            }
        }
    }
}

fn sets(walk: &BuildWalk) -> Vec<&SetStep> {
    walk.steps
        .iter()
        .filter_map(|step| match step {
            BuildStep::Set(set) => Some(set),
            _ => None,
        })
        .collect()
}

fn merges(walk: &BuildWalk) -> Vec<&MergeStep> {
    walk.steps
        .iter()
        .filter_map(|step| match step {
            BuildStep::Merge(merge) => Some(merge),
            _ => None,
        })
        .collect()
}

fn moves(walk: &BuildWalk) -> Vec<&NodeMove> {
    walk.steps
        .iter()
        .filter_map(|step| match step {
            BuildStep::Move(step) => Some(step),
            _ => None,
        })
        .collect()
}

/// The tree that the splits alone say.
fn grown(walk: &BuildWalk) -> Topology {
    let sets = sets(walk);
    let mut nodes = vec![None; sets.len()];
    for set in &sets {
        let node = match set.choice {
            Choice::Leaf(_) => {
                TopologyNode::leaf(set.bounds, set.slots.start, set.slots.len() as u32)
            }
            Choice::Split { children, .. } => TopologyNode::inner(set.bounds, children[0]),
        };
        let place = &mut nodes[set.node as usize];
        assert!(place.replace(node).is_none(), "each node once");
    }
    Topology {
        nodes: nodes.into_iter().map(Option::unwrap).collect(),
        order: walk.order.clone(),
        is_split: false,
    }
}

/// The slots under each node.
fn below(tree: &Topology) -> Vec<Range<u32>> {
    let mut slots = vec![0..0; tree.nodes.len()];
    for (i, node) in tree.nodes.iter().enumerate().rev() {
        slots[i] = match node.is_leaf() {
            true => node.slots(),
            false => {
                let first = node.first as usize;
                slots[first].start..slots[first + 1].end
            }
        };
    }
    slots
}

/// The tree with its nodes and slots depth first, primitives once in each leaf, as builders give it.
fn tidy(tree: &Topology) -> (Vec<TopologyNode>, Vec<u32>) {
    fn copy(tree: &Topology, from: u32, at: usize, to: &mut (Vec<TopologyNode>, Vec<u32>)) {
        let node = tree.nodes[from as usize];
        if node.is_leaf() {
            let first = to.1.len();
            for slot in node.slots() {
                let prim = tree.order[slot as usize];
                if !to.1[first..].contains(&prim) {
                    to.1.push(prim);
                }
            }
            let count = to.1.len() - first;
            to.0[at] = TopologyNode::leaf(node.bounds, first as u32, count as u32);
            return;
        }
        let first = to.0.len();
        to.0[at] = TopologyNode::inner(node.bounds, first as u32);
        to.0.extend([node; 2]);
        copy(tree, node.first, first, to);
        copy(tree, node.first + 1, first + 1, to);
    }
    let mut to = (Vec::new(), Vec::new());
    if let Some(root) = tree.nodes.first() {
        to.0.push(*root);
        copy(tree, 0, 0, &mut to);
    }
    to
}

/// A move as docs/trace.md has it.
fn apply(tree: &mut Topology, step: &NodeMove) {
    let parent_of = |tree: &Topology, node: u32| {
        let is_parent = |n: &TopologyNode| !n.is_leaf() && (n.first..n.first + 2).contains(&node);
        tree.nodes.iter().position(is_parent)
    };
    let (node, to) = (step.node, step.to);
    let sibling = ((node - 1) ^ 1) + 1;
    let parent = parent_of(tree, node).unwrap();
    tree.nodes[parent] = tree.nodes[sibling as usize];
    tree.nodes[sibling as usize] = tree.nodes[to as usize];
    tree.nodes[to as usize] = TopologyNode::inner(Aabb::EMPTY, node.min(sibling));
    for from in [Some(to as usize), parent_of(tree, parent as u32)] {
        let mut at = from;
        while let Some(index) = at {
            let first = tree.nodes[index].first as usize;
            tree.nodes[index].bounds = tree.nodes[first]
                .bounds
                .union(&tree.nodes[first + 1].bounds);
            at = parent_of(tree, index as u32);
        }
    }
}

#[test]
fn replaying_the_steps_gives_the_tree_of_the_builder() {
    let mut moved = 0;
    for_every_build(|name, options, walk, _| {
        // After moves, what is more than 63 deep is halved anew.
        let moves_nodes = [Builder::BINNED, Builder::REFINED].contains(&options.builder);
        if moves_nodes && name.ends_with("exponential") {
            return;
        }
        if !walk.curve.is_empty() || walk.tree.nodes.len() > 3000 && !moves(walk).is_empty() {
            return;
        }
        let mut tree = grown(walk);
        for step in moves(walk) {
            apply(&mut tree, step);
            moved += 1;
        }
        let (nodes, order) = tidy(&tree);
        assert_eq!(
            (&nodes, &order),
            (&walk.tree.nodes, &walk.tree.order),
            "{name}"
        );
    });
    assert!(moved > 100, "{moved}");
}

#[test]
fn every_set_is_parted_by_its_plane() {
    for_every_build(|name, _, walk, boxes| {
        let by_node: HashMap<u32, &SetStep> =
            sets(walk).iter().map(|set| (set.node, *set)).collect();
        for set in sets(walk) {
            let Choice::Split {
                plane, children, ..
            } = set.choice
            else {
                continue;
            };
            let [left, right] = children.map(|child| by_node[&child]);
            assert_eq!(
                (left.parent, right.parent),
                (Some(set.node), Some(set.node))
            );
            assert_eq!(left.slots.start..right.slots.end, set.slots, "{name}");
            assert_eq!(left.slots.len(), plane.left as usize, "{name}");
            // Parts of split primitives have boxes of their own.
            if walk.order.len() > boxes.len() {
                continue;
            }
            let centers = |slots: &Range<u32>| -> Vec<f32> {
                slots
                    .clone()
                    .map(|slot| {
                        let b = &boxes[walk.order[slot as usize] as usize];
                        0.5 * (b.min[plane.axis] + b.max[plane.axis])
                    })
                    .collect()
            };
            // Where a bin begins is rounded.
            let near = 1e-5 * (1.0 + plane.at.abs());
            let before = centers(&left.slots).into_iter().fold(f32::MIN, f32::max);
            let behind = centers(&right.slots).into_iter().fold(f32::MAX, f32::min);
            assert!(
                before <= plane.at + near && behind >= plane.at - near,
                "{name}: {before} {plane:?} {behind}"
            );
        }
    });
}

#[test]
fn the_chosen_plane_costs_least_and_less_than_a_leaf_that_may_be() {
    let mut chosen = 0;
    for_every_build(|name, options, walk, _| {
        for set in sets(walk) {
            let least = set
                .planes
                .iter()
                .filter_map(|p| p.cost)
                .min_by(f32::total_cmp);
            match set.choice {
                Choice::Split {
                    plane,
                    why: Why::Rule,
                    ..
                } => {
                    assert!(set.planes.contains(&plane), "{name}");
                    assert_eq!(plane.cost, least, "{name}");
                    chosen += usize::from(least.is_some());
                }
                Choice::Leaf(Why::Cheaper) => {
                    assert!(
                        least.is_none_or(|cost| cost >= 0.999 * set.leaf_cost.unwrap()),
                        "{name}"
                    );
                }
                Choice::Leaf(_) => assert!(set.slots.len() <= options.max_leaf.max(8) as usize),
                Choice::Split { plane, .. } => assert_eq!(plane.cost, None),
            }
        }
    });
    assert!(chosen > 10_000, "{chosen}");
}

#[test]
fn merges_along_the_curve_give_the_nodes_of_the_tree() {
    for_every_build(|name, _, walk, boxes| {
        let merges = merges(walk);
        if merges.is_empty() {
            return;
        }
        assert!(walk.curve.is_sorted_by_key(|place| place.code), "{name}");
        let slots = below(&walk.tree);
        let mut clusters: Vec<Vec<u32>> = walk.curve.iter().map(|place| vec![place.prim]).collect();
        let mut named = 0;
        for merge in merges {
            assert_eq!(merge.cluster as usize, clusters.len(), "{name}");
            let [a, b] = merge.parts.map(|part| clusters[part as usize].clone());
            let mut prims = [a, b].concat();
            prims.sort_unstable();
            assert_eq!(merge.count as usize, prims.len());
            let around = Aabb::of_boxes(prims.iter().map(|&prim| &boxes[prim as usize]));
            assert_eq!(merge.bounds, around, "{name}");
            if let Some(node) = merge.node {
                let range = &slots[node as usize];
                let mut below = walk.tree.order[range.start as usize..range.end as usize].to_vec();
                below.sort_unstable();
                assert_eq!(below, prims, "{name}: node {node}");
                let is_leaf = walk.tree.nodes[node as usize].is_leaf();
                assert_eq!(is_leaf, merge.is_leaf, "{name}: node {node}");
                named += 1;
            }
            clusters.push(prims);
        }
        assert_eq!(clusters.last().map(Vec::len), Some(walk.tree.order.len()));
        let single = walk
            .tree
            .nodes
            .iter()
            .filter(|node| node.count == 1)
            .count();
        // What is more than 63 deep is halved.
        let is_deep = name.ends_with("exponential");
        assert!(
            is_deep || named + single >= walk.tree.nodes.len(),
            "{name}: {named} named"
        );
    });
}

#[test]
fn a_limit_keeps_the_nodes_nearest_to_the_root() {
    let mesh = common::star(20, 30, 3.0);
    for builder in BUILDERS {
        let scene = Scene::builder()
            .mesh(&mesh.0, &mesh.1)
            .structure("bvh2")
            .options(BuildOptions::with(*builder))
            .build()
            .unwrap();
        let whole = scene.explain_build(usize::MAX).unwrap();
        let some = scene.explain_build(20).unwrap();
        assert_eq!((some.steps.len(), some.step_count), (20, whole.step_count));
        assert_eq!(some.tree, whole.tree);
        assert!(some.steps.iter().all(|step| whole.steps.contains(step)));
        let depth = |walk: &BuildWalk| sets(walk).iter().map(|set| set.depth).max();
        assert!(
            depth(&some).is_none_or(|deepest| deepest < 8),
            "{}",
            builder.name
        );
        assert_eq!(scene.explain_build(0).unwrap().steps, []);
    }
}

#[test]
fn grids_tell_the_resolutions_that_they_try() {
    for (name, mesh) in all() {
        let scene = Scene::builder()
            .mesh(&mesh.0, &mesh.1)
            .structure("grid")
            .build()
            .unwrap();
        let walk = scene.explain_build(usize::MAX).unwrap();
        let (last, before) = walk.steps.split_last().unwrap();
        let BuildStep::Grid(taken) = last else {
            panic!("{name}: {last:?}");
        };
        let mut references = 0;
        scene
            .query()
            .for_each_node(&mut |cell| references += cell.prims.unwrap() as usize);
        assert!(taken.references.is_none_or(|n| n == references), "{name}");
        for step in before {
            assert!(
                matches!(step, BuildStep::Grid(grid) if grid.references.is_none()),
                "{name}"
            );
        }
    }
}

#[test]
fn what_cannot_be_told_apart_is_halved() {
    let one = [[0.0, 0.0, 1.0], [1.0, 0.25, 1.5], [0.25, 1.0, 1.0]];
    let indices = vec![[0, 1, 2]; 100];
    for builder in [Builder::BINNED, Builder::MIDPOINT] {
        let scene = Scene::builder()
            .mesh(&one, &indices)
            .structure("bvh2")
            .options(BuildOptions::with(builder))
            .build()
            .unwrap();
        let walk = scene.explain_build(usize::MAX).unwrap();
        let Choice::Split { plane, why, .. } = sets(&walk)[0].choice else {
            panic!("100 are no leaf");
        };
        assert_eq!((plane.left, why), (50, Why::Alike), "{}", builder.name);
    }
}
