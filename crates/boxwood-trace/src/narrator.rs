//! From the steps of a walk to its trace: each gets its place in the tree, and the stack around it.

use crate::number::{finite, finite_f64};
use crate::walk::{
    BoxTrace, BoxVerdict, CellTrace, CountsTrace, Event, HitTrace, InstanceTrace, PrimitiveTrace,
    PrimitiveVerdict, RayTrace, WalkStep, WalkTrace,
};
use boxwood::geom::{EdgeTrace, PreparedRay};
use boxwood::query::{
    self, CellVisit, InstanceVisit, PrimitiveTest, Query, VolumeTest, VolumeVerdict,
};
use boxwood::{Ray, Scene, Step};
use std::collections::HashMap;

/// Walks, and tells.
pub(crate) fn narrate(scene: &Scene, ray: &Ray) -> WalkTrace {
    let walk = scene.explain(ray);
    let mut narrator = Narrator::new(scene, ray);
    let turns = next_turns(&walk.steps);
    let steps = walk.steps.iter().zip(turns);
    WalkTrace {
        boxwood_trace: crate::VERSION,
        kind: "walk".to_owned(),
        structure: crate::label(scene),
        primitives: scene.len(),
        ray: RayTrace::of(ray),
        steps: steps
            .filter_map(|(step, next)| narrator.tell(step, next))
            .collect(),
        hit: walk.hit.as_ref().map(HitTrace::of),
        counts: CountsTrace::of(&walk.counts),
    }
}

/// For each step the node that leaves the stack next.
fn next_turns(steps: &[Step]) -> Vec<Option<u32>> {
    let mut next = None;
    let mut turns: Vec<Option<u32>> = steps
        .iter()
        .rev()
        .map(|step| {
            match step {
                Step::Turn(node) => next = Some(*node),
                Step::Volume(test) if test.verdict == VolumeVerdict::Dropped => {
                    next = Some(test.node);
                }
                // Numbers inside an instance are others.
                Step::Instance(_) => next = None,
                _ => {}
            }
            next
        })
        .collect();
    turns.reverse();
    turns
}

struct Narrator<'a> {
    ray: Option<PreparedRay>,
    /// The scene at work, and those around it.
    levels: Vec<Level<'a>>,
    best_t: Option<f32>,
    /// As the last step left it.
    stack: Vec<u32>,
}

/// A scene at work.
struct Level<'a> {
    scene: &'a Scene,
    nodes: HashMap<u32, Node>,
    /// Of its root.
    depth: u32,
    /// Nested objects call each other and have no stack.
    is_nested: bool,
    /// The node whose turn it is.
    at: Option<u32>,
    is_in_cell: bool,
    stack: Vec<u32>,
}

/// What the walk does not say about a node.
#[derive(Clone, Copy)]
struct Node {
    parent: Option<u32>,
    depth: u32,
    prims: Option<u32>,
}

impl<'a> Level<'a> {
    /// Looks at every node of the structure once.
    fn new(scene: &'a Scene, depth: u32) -> Self {
        let is_grid = scene.structure() == "grid";
        Self {
            scene,
            // Cells have numbers of their own, which are not those of a tree.
            nodes: if is_grid {
                HashMap::new()
            } else {
                nodes(scene.query())
            },
            depth,
            is_nested: scene.structure() == "bounded",
            at: None,
            is_in_cell: false,
            stack: Vec::new(),
        }
    }

    fn node(&self, node: u32) -> Node {
        self.nodes.get(&node).copied().unwrap_or(Node {
            parent: None,
            depth: 0,
            prims: None,
        })
    }

    /// From the root to the node around this one.
    fn around(&self, node: u32) -> Vec<u32> {
        let mut path: Vec<u32> =
            std::iter::successors(self.node(node).parent, |&node| self.node(node).parent).collect();
        path.reverse();
        path
    }

    fn turn(&mut self, node: u32) {
        self.at = Some(node);
        if self.is_nested {
            self.stack = self.around(node);
            self.stack.push(node);
        } else {
            self.stack.retain(|&waiting| waiting != node);
        }
    }

    /// Depth of what stands in the leaf or cell at work.
    fn inside(&self) -> u32 {
        let own = match self.at {
            Some(node) => self.node(node).depth + 1,
            None => u32::from(self.is_in_cell),
        };
        self.depth + own
    }
}

/// All nodes of a structure.
fn nodes(query: &dyn Query) -> HashMap<u32, Node> {
    let mut nodes = HashMap::new();
    // Parents come first and subtrees one after the other, so the path to a node is known when it comes.
    let mut path: Vec<u32> = Vec::new();
    query.for_each_node(&mut |info| {
        path.truncate(info.depth as usize);
        let node = Node {
            parent: path.last().copied(),
            depth: info.depth,
            prims: info.prims,
        };
        nodes.insert(info.node, node);
        path.push(info.node);
    });
    nodes
}

impl<'a> Narrator<'a> {
    fn new(scene: &'a Scene, ray: &Ray) -> Self {
        Self {
            ray: PreparedRay::new(ray),
            levels: vec![Level::new(scene, 0)],
            best_t: None,
            stack: Vec::new(),
        }
    }

    /// The trace of a step; `next` leaves the stack after it. A turn is told by the stack of the step that follows.
    fn tell(&mut self, step: &Step, next: Option<u32>) -> Option<WalkStep> {
        // There is always one: what is entered is left again.
        let level = self.levels.last_mut()?;
        let (depth, event) = match step {
            Step::Turn(node) => {
                level.turn(*node);
                return None;
            }
            Step::Volume(test) => self.volume(test, next)?,
            Step::Cell(visit) => {
                level.is_in_cell = true;
                (level.depth, cell(visit))
            }
            Step::Primitive(test) => self.primitive(test)?,
            Step::Instance(visit) => self.instance(visit)?,
        };
        let stack = self.levels.last()?.stack.clone();
        let stack_before = std::mem::replace(&mut self.stack, stack.clone());
        Some(WalkStep {
            depth,
            event,
            best_t: self.best_t,
            stack_before,
            stack_after: stack,
        })
    }

    fn volume(&mut self, test: &VolumeTest, next: Option<u32>) -> Option<(u32, Event)> {
        let level = self.levels.last_mut()?;
        let node = level.node(test.node);
        if level.is_nested {
            level.stack = level.around(test.node);
            if test.verdict == VolumeVerdict::Enter {
                level.stack.push(test.node);
            }
        } else {
            level.stack.retain(|&waiting| waiting != test.node);
            if test.verdict == VolumeVerdict::Enter && level.nodes.contains_key(&test.node) {
                level.stack.push(test.node);
            }
            // Of siblings that are entered together the one whose turn is next lies on top.
            if let Some(place) = level
                .stack
                .iter()
                .position(|&waiting| Some(waiting) == next)
            {
                let first = level.stack.remove(place);
                level.stack.push(first);
            }
        }
        // Nested objects and instances shorten the ray instead of knowing the closest hit.
        let is_behind = test.near <= test.far && self.best_t.is_some_and(|best| test.near > best);
        let verdict = match test.verdict {
            VolumeVerdict::Miss if is_behind => BoxVerdict::Farther,
            verdict => verdict.into(),
        };
        let event = Event::Box(BoxTrace {
            node: test.node,
            parent: node.parent,
            leaf_of: node.prims,
            near: finite(test.near),
            far: finite(test.far),
            verdict,
            flops: test.flops,
            bytes: test.bytes,
        });
        Some((level.depth + node.depth, event))
    }

    fn primitive(&mut self, test: &PrimitiveTest) -> Option<(u32, Event)> {
        let trace = self.edges(test.prim);
        let level = self.levels.last()?;
        let line = trace.and_then(|trace| trace.candidate);
        let verdict = match (test.verdict, line) {
            (query::PrimitiveVerdict::Closest, _) => PrimitiveVerdict::Closest,
            (query::PrimitiveVerdict::Farther, _) => PrimitiveVerdict::Farther,
            (query::PrimitiveVerdict::Miss, Some(c))
                if self.best_t.is_some_and(|best| c.t > best) =>
            {
                PrimitiveVerdict::Farther
            }
            (query::PrimitiveVerdict::Miss, Some(_)) => PrimitiveVerdict::OutOfRange,
            (query::PrimitiveVerdict::Miss, None) => PrimitiveVerdict::Miss,
        };
        // What the test of the structure found; outside the range, what the bare test finds.
        let found = test.candidate.or(line);
        if verdict == PrimitiveVerdict::Closest {
            self.best_t = found.map(|c| c.t);
        }
        let event = Event::Primitive(PrimitiveTrace {
            prim: test.prim,
            leaf: level.at,
            edges: trace.map(|trace| trace.edges),
            signs: trace.map(|trace| trace.signs),
            t: found.map(|c| c.t),
            u: found.map(|c| c.u),
            v: found.map(|c| c.v),
            verdict,
            flops: test.flops,
            bytes: test.bytes,
        });
        Some((level.inside(), event))
    }

    /// Inside an instance the ray is another one, which is not known here.
    fn edges(&self, prim: u32) -> Option<EdgeTrace> {
        let [level] = self.levels.as_slice() else {
            return None;
        };
        let triangle = level.scene.triangle_in_scene(prim)?;
        Some(triangle.trace(self.ray.as_ref()?))
    }

    fn instance(&mut self, visit: &InstanceVisit) -> Option<(u32, Event)> {
        if visit.verdict == query::InstanceVerdict::Leave && self.levels.len() > 1 {
            self.levels.pop();
        }
        let level = self.levels.last()?;
        let depth = level.inside();
        if visit.verdict == query::InstanceVerdict::Enter {
            let instance = level.scene.instances().get(visit.instance as usize)?;
            self.levels.push(Level::new(&instance.scene, depth + 1));
        }
        let event = Event::Instance(InstanceTrace {
            instance: visit.instance,
            verdict: visit.verdict.into(),
            flops: visit.flops,
            bytes: visit.bytes,
        });
        Some((depth, event))
    }
}

fn cell(visit: &CellVisit) -> Event {
    Event::Cell(CellTrace {
        cell: visit.cell,
        enter: finite_f64(visit.enter),
        t_next: visit.t_next.map(finite_f64),
        t_delta: visit.t_delta.map(finite_f64),
        prims: visit.prims,
        flops: visit.flops,
        bytes: visit.bytes,
    })
}
