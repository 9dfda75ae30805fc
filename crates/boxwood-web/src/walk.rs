//! A ray's walk as the page reads it: the fields of `boxwood explain --json`, with the box of each node and what waits.

use boxwood::{
    Aabb, Ray, Scene, Step,
    geom::PreparedRay,
    query::{CellVisit, PrimitiveTest, PrimitiveVerdict, VolumeTest, VolumeVerdict},
};
use serde::Serialize;
use std::collections::HashMap;

/// A whole walk.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WalkAnswer {
    /// Name of the structure.
    pub structure: &'static str,
    /// Where the ray starts.
    pub origin: [f32; 3],
    /// Not always unit; `t` counts in its lengths.
    pub dir: [f32; 3],
    /// In order.
    pub steps: Vec<WalkStep>,
    /// The answer.
    pub hit: Option<HitAnswer>,
    /// The steps added up.
    pub counts: CountsAnswer,
}

/// One step, as deep as it stands in the tree.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WalkStep {
    /// Of the node; one more for what stands in a leaf.
    pub depth: u32,
    /// What happened.
    #[serde(flatten)]
    pub kind: StepKind,
    /// The closest hit after the step.
    pub best_t: Option<f32>,
    /// Nodes that are still to be looked into, the next one last.
    pub waiting: Vec<u32>,
}

/// What happened. Numbers that are not finite are null.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "step", rename_all = "lowercase")]
#[expect(
    missing_docs,
    reason = "the fields are those of the core's tests, with the same names"
)]
pub enum StepKind {
    /// A volume was tested or dropped.
    Box {
        node: u32,
        parent: Option<u32>,
        /// Primitives of a leaf.
        leaf_of: Option<u32>,
        near: f32,
        far: f32,
        verdict: &'static str,
        flops: u32,
        /// Smallest and largest corner; `None` for what the structure does not list.
        bounds: Option<[[f32; 3]; 2]>,
    },
    /// A grid cell was entered.
    Cell {
        cell: [u32; 3],
        enter: f64,
        t_delta: [f64; 3],
        t_next: [f64; 3],
        prims: u32,
        flops: u32,
    },
    /// A triangle was tested.
    Primitive {
        prim: u32,
        leaf: Option<u32>,
        edges: Option<[f64; 3]>,
        signs: Option<[i8; 3]>,
        t: Option<f32>,
        u: Option<f32>,
        v: Option<f32>,
        verdict: &'static str,
        flops: u32,
        corners: Option<[[f32; 3]; 3]>,
    },
}

/// What was hit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the fields are those of boxwood::Hit")]
pub struct HitAnswer {
    pub t: f32,
    pub u: f32,
    pub v: f32,
    pub prim: u32,
}

/// The work of the walk.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the fields are those of boxwood::Counts")]
pub struct CountsAnswer {
    pub nodes: u64,
    pub box_tests: u64,
    pub primitive_tests: u64,
    pub flops: u64,
    pub bytes: u64,
}

impl WalkAnswer {
    /// Walks `ray` through `scene`. Looks at every node of the structure once.
    pub(crate) fn of(scene: &Scene, ray: &Ray) -> Self {
        let walk = scene.explain(ray);
        let counts = walk.counts;
        Self {
            structure: scene.structure(),
            origin: ray.origin,
            dir: ray.dir,
            steps: Narrator::new(scene, ray).narrate(&walk.steps),
            hit: walk.hit.map(|hit| HitAnswer {
                t: hit.t,
                u: hit.u,
                v: hit.v,
                prim: hit.prim,
            }),
            counts: CountsAnswer {
                nodes: counts.nodes,
                box_tests: counts.boxes,
                primitive_tests: counts.prims,
                flops: counts.flops,
                bytes: counts.bytes,
            },
        }
    }
}

/// Finds the place of each step in the tree.
struct Narrator<'a> {
    scene: &'a Scene,
    ray: Option<PreparedRay>,
    nodes: HashMap<u32, Node>,
    waiting: Vec<Waiting>,
    /// Depth of what stands in the leaf or cell at work.
    inside: u32,
    best_t: Option<f32>,
}

#[derive(Clone, Copy)]
struct Node {
    parent: Option<u32>,
    depth: u32,
    prims: Option<u32>,
    bounds: Aabb,
}

struct Waiting {
    node: u32,
    near: f32,
    /// Primitives of a leaf that are still to be tested.
    left: u32,
}

impl<'a> Narrator<'a> {
    fn new(scene: &'a Scene, ray: &Ray) -> Self {
        let mut nodes = HashMap::new();
        // Parents come first and subtrees one after the other, so the path to a node is known when it comes.
        let mut path: Vec<u32> = Vec::new();
        scene.query().for_each_node(&mut |info| {
            path.truncate(info.depth as usize);
            let node = Node {
                parent: path.last().copied(),
                depth: info.depth,
                prims: info.prims,
                bounds: info.bounds,
            };
            nodes.insert(info.node, node);
            path.push(info.node);
        });
        Self {
            scene,
            ray: PreparedRay::new(ray),
            nodes,
            waiting: Vec::new(),
            inside: 0,
            best_t: None,
        }
    }

    fn narrate(mut self, steps: &[Step]) -> Vec<WalkStep> {
        let step = |step: &Step| {
            let (depth, kind) = match step {
                Step::Volume(test) => self.volume(test),
                Step::Cell(visit) => self.cell(visit),
                Step::Primitive(test) => self.primitive(test),
                // Scenes are shown multiplied out.
                Step::Instance(_) => return None,
            };
            Some(WalkStep {
                depth,
                kind,
                best_t: self.best_t,
                waiting: self.waiting.iter().map(|waiting| waiting.node).collect(),
            })
        };
        steps.iter().filter_map(step).collect()
    }

    fn volume(&mut self, test: &VolumeTest) -> (u32, StepKind) {
        let known = self.nodes.get(&test.node).copied();
        let parent = known.and_then(|node| node.parent);
        let prims = known.and_then(|node| node.prims);
        // The node whose children are tested has its turn now; so has one that is dropped.
        let is_next = |waiting: &Waiting| Some(waiting.node) == parent || waiting.node == test.node;
        if self.waiting.last().is_some_and(is_next) {
            self.waiting.pop();
        }
        if test.verdict == VolumeVerdict::Enter {
            let next = Waiting {
                node: test.node,
                near: test.near,
                left: prims.unwrap_or(0),
            };
            self.enter(next, parent);
        }
        let kind = StepKind::Box {
            node: test.node,
            parent,
            leaf_of: prims,
            near: test.near,
            far: test.far,
            verdict: self.verdict(test),
            flops: test.flops,
            bounds: known.map(|node| [node.bounds.min, node.bounds.max]),
        };
        (known.map_or(0, |node| node.depth), kind)
    }

    fn verdict(&self, test: &VolumeTest) -> &'static str {
        let is_behind = self.best_t.is_some_and(|best| test.near > best);
        match test.verdict {
            VolumeVerdict::Enter => "enter",
            // Nested objects shorten the ray instead of knowing the closest hit.
            VolumeVerdict::Miss if test.near <= test.far && is_behind => "farther",
            VolumeVerdict::Miss => "miss",
            VolumeVerdict::Farther => "farther",
            VolumeVerdict::Dropped => "dropped",
        }
    }

    /// Of two entered siblings the nearer has its turn first; of two as near, the first.
    fn enter(&mut self, next: Waiting, parent: Option<u32>) {
        let sibling_first = self.waiting.last().is_some_and(|last| {
            let last_parent = self.nodes.get(&last.node).and_then(|node| node.parent);
            parent.is_some() && last_parent == parent && last.near <= next.near
        });
        let at = self.waiting.len() - usize::from(sibling_first);
        self.waiting.insert(at, next);
    }

    fn cell(&mut self, visit: &CellVisit) -> (u32, StepKind) {
        self.inside = 1;
        let kind = StepKind::Cell {
            cell: visit.cell,
            enter: visit.enter,
            t_delta: visit.t_delta,
            t_next: visit.t_next,
            prims: visit.prims,
            flops: visit.flops,
        };
        (0, kind)
    }

    fn primitive(&mut self, test: &PrimitiveTest) -> (u32, StepKind) {
        let leaf = self.waiting.last().map(|leaf| leaf.node);
        if let Some(leaf) = self.waiting.last_mut() {
            self.inside = self.nodes.get(&leaf.node).map_or(0, |node| node.depth + 1);
            leaf.left = leaf.left.saturating_sub(1);
            if leaf.left == 0 {
                self.waiting.pop();
            }
        }
        let triangle = self.scene.triangle_in_scene(test.prim);
        let trace = triangle.zip(self.ray.as_ref()).map(|(t, ray)| t.trace(ray));
        // What the test of the structure found; outside the range, what the bare test finds.
        let bare = trace.and_then(|trace| trace.candidate);
        let found = test.candidate.or(bare);
        let verdict = match (test.verdict, bare) {
            (PrimitiveVerdict::Closest, _) => "closest",
            (PrimitiveVerdict::Farther, _) => "farther",
            (PrimitiveVerdict::Miss, Some(c)) if self.best_t.is_some_and(|best| c.t > best) => {
                "farther"
            }
            (PrimitiveVerdict::Miss, Some(_)) => "out of range",
            (PrimitiveVerdict::Miss, None) => "miss",
        };
        if test.verdict == PrimitiveVerdict::Closest {
            self.best_t = found.map(|c| c.t);
        }
        let kind = StepKind::Primitive {
            prim: test.prim,
            leaf,
            edges: trace.map(|trace| trace.edges),
            signs: trace.map(|trace| trace.signs),
            t: found.map(|c| c.t),
            u: found.map(|c| c.u),
            v: found.map(|c| c.v),
            verdict,
            flops: test.flops,
            corners: triangle.map(|triangle| triangle.0),
        };
        (self.inside, kind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Lab;

    #[test]
    fn the_steps_add_up_and_end_with_nothing_waiting() {
        let mut lab = Lab::open("builtin:cornell", None).unwrap();
        for structure in ["list", "bounded", "bvh2", "wide", "grid"] {
            let number = lab.build(structure, "median").unwrap().number;
            let walk = lab.walk(number, 161, 97).unwrap();
            let tests = |is_it: fn(&StepKind) -> bool| {
                walk.steps.iter().filter(|step| is_it(&step.kind)).count() as u64
            };
            let boxes = tests(
                |kind| matches!(kind, StepKind::Box { verdict, .. } if *verdict != "dropped"),
            );
            let prims = tests(|kind| matches!(kind, StepKind::Primitive { .. }));
            assert_eq!(boxes, walk.counts.box_tests, "{structure}");
            assert_eq!(prims, walk.counts.primitive_tests, "{structure}");
            let last = walk.steps.last().unwrap();
            assert_eq!(last.best_t, walk.hit.map(|hit| hit.t), "{structure}");
        }
    }
}
