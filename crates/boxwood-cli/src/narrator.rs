//! The steps of a walk as people and programs read them: each with its place in the tree.

use std::{collections::HashMap, fmt};

use boxwood::{
    Ray, Scene, Step,
    geom::{EdgeTrace, PreparedRay},
    query::{CellVisit, PrimitiveTest, PrimitiveVerdict, VolumeTest, VolumeVerdict},
};
use serde::Serialize;

/// One step, as deep as it stands in the tree.
#[derive(Debug, Serialize)]
pub(crate) struct Line {
    pub(crate) depth: u32,
    #[serde(flatten)]
    pub(crate) step: StepAnswer,
    /// The closest hit after the step.
    pub(crate) best_t: Option<f32>,
}

/// What happened.
#[derive(Debug, Serialize)]
#[serde(tag = "step", rename_all = "lowercase")]
pub(crate) enum StepAnswer {
    Box {
        node: u32,
        parent: Option<u32>,
        leaf_of: Option<u32>,
        near: f32,
        far: f32,
        verdict: &'static str,
        flops: u32,
    },
    Cell {
        cell: [u32; 3],
        enter: f64,
        t_next: [f64; 3],
        prims: u32,
        flops: u32,
    },
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
    },
}

/// Tells the steps of a walk with the place of each in the tree.
pub(crate) struct Narrator<'a> {
    scene: &'a Scene,
    ray: Option<PreparedRay>,
    nodes: HashMap<u32, Node>,
    /// Nodes that the ray enters and that have not had their turn, the next one last.
    waiting: Vec<Waiting>,
    /// Depth of what stands in the leaf or cell at work.
    inside: u32,
    best_t: Option<f32>,
}

/// What the walk does not say about a node.
#[derive(Clone, Copy)]
struct Node {
    parent: Option<u32>,
    depth: u32,
    prims: Option<u32>,
}

struct Waiting {
    node: u32,
    near: f32,
    /// Primitives of a leaf.
    left: u32,
}

impl<'a> Narrator<'a> {
    /// Looks at every node of the structure once.
    pub(crate) fn new(scene: &'a Scene, ray: &Ray) -> Self {
        let mut nodes = HashMap::new();
        // Parents come first and subtrees one after the other, so the path to a node is known when it comes.
        let mut path: Vec<u32> = Vec::new();
        scene.query().for_each_node(&mut |info| {
            path.truncate(info.depth as usize);
            nodes.insert(
                info.node,
                Node {
                    parent: path.last().copied(),
                    depth: info.depth,
                    prims: info.prims,
                },
            );
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

    /// A line for each step.
    pub(crate) fn narrate(mut self, steps: &[Step]) -> Vec<Line> {
        let line = |step: &Step| match step {
            Step::Volume(test) => Some(self.volume(test)),
            Step::Cell(visit) => Some(self.cell(visit)),
            Step::Primitive(test) => Some(self.primitive(test)),
            // Scenes are explained multiplied out.
            Step::Instance(_) => None,
        };
        steps.iter().filter_map(line).collect()
    }

    fn volume(&mut self, test: &VolumeTest) -> Line {
        let VolumeTest {
            node,
            near,
            far,
            verdict,
            flops,
            ..
        } = *test;
        let known = self.nodes.get(&node).copied();
        let Node {
            parent,
            depth,
            prims,
        } = known.unwrap_or(Node {
            parent: None,
            depth: 0,
            prims: None,
        });
        // The node whose children are tested has its turn now; so has one that is dropped.
        if self
            .waiting
            .last()
            .is_some_and(|w| Some(w.node) == parent || w.node == node)
        {
            self.waiting.pop();
        }
        if verdict == VolumeVerdict::Enter {
            self.enter(
                Waiting {
                    node,
                    near,
                    left: prims.unwrap_or(0),
                },
                parent,
            );
        }
        let verdict = match verdict {
            VolumeVerdict::Enter => "enter",
            // Nested objects shorten the ray instead of knowing the closest hit.
            VolumeVerdict::Miss if near <= far && self.best_t.is_some_and(|best| near > best) => {
                "farther"
            }
            VolumeVerdict::Miss => "miss",
            VolumeVerdict::Farther => "farther",
            VolumeVerdict::Dropped => "dropped",
        };
        let step = StepAnswer::Box {
            node,
            parent,
            leaf_of: prims,
            near,
            far,
            verdict,
            flops,
        };
        Line {
            depth,
            step,
            best_t: self.best_t,
        }
    }

    /// Of two entered siblings the nearer has its turn first; of two as near, the first.
    fn enter(&mut self, next: Waiting, parent: Option<u32>) {
        let sibling_first = self.waiting.last().is_some_and(|last| {
            let last_parent = self.nodes.get(&last.node).and_then(|n| n.parent);
            parent.is_some() && last_parent == parent && last.near <= next.near
        });
        let at = self.waiting.len() - usize::from(sibling_first);
        self.waiting.insert(at, next);
    }

    fn cell(&mut self, visit: &CellVisit) -> Line {
        let CellVisit {
            cell,
            enter,
            t_next,
            prims,
            flops,
            ..
        } = *visit;
        self.inside = 1;
        Line {
            depth: 0,
            step: StepAnswer::Cell {
                cell,
                enter,
                t_next,
                prims,
                flops,
            },
            best_t: self.best_t,
        }
    }

    fn primitive(&mut self, test: &PrimitiveTest) -> Line {
        let leaf = self.waiting.last().map(|leaf| leaf.node);
        if let Some(leaf) = self.waiting.last_mut() {
            self.inside = self.nodes.get(&leaf.node).map_or(0, |node| node.depth + 1);
            leaf.left = leaf.left.saturating_sub(1);
            if leaf.left == 0 {
                self.waiting.pop();
            }
        }
        let trace = self.trace(test.prim);
        let verdict = match (test.verdict, trace.and_then(|trace| trace.candidate)) {
            (PrimitiveVerdict::Closest, _) => "closest",
            (PrimitiveVerdict::Farther, _) => "farther",
            (PrimitiveVerdict::Miss, Some(c)) if self.best_t.is_some_and(|best| c.t > best) => {
                "farther"
            }
            (PrimitiveVerdict::Miss, Some(_)) => "out of range",
            (PrimitiveVerdict::Miss, None) => "miss",
        };
        // What the test of the structure found; outside the range, what the bare test finds.
        let found = test.candidate.or(trace.and_then(|trace| trace.candidate));
        if test.verdict == PrimitiveVerdict::Closest {
            self.best_t = found.map(|c| c.t);
        }
        let step = StepAnswer::Primitive {
            prim: test.prim,
            leaf,
            edges: trace.map(|trace| trace.edges),
            signs: trace.map(|trace| trace.signs),
            t: found.map(|c| c.t),
            u: found.map(|c| c.u),
            v: found.map(|c| c.v),
            verdict,
            flops: test.flops,
        };
        Line {
            depth: self.inside,
            step,
            best_t: self.best_t,
        }
    }

    fn trace(&self, prim: u32) -> Option<EdgeTrace> {
        Some(
            self.scene
                .triangle_in_scene(prim)?
                .trace(self.ray.as_ref()?),
        )
    }
}

impl fmt::Display for StepAnswer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Box {
                node,
                parent,
                leaf_of,
                near,
                far,
                verdict,
                ..
            } => {
                let kind = if leaf_of.is_some() { "leaf" } else { "box" };
                let of = parent.map_or_else(String::new, |parent| format!(" in {parent}"));
                let prims =
                    leaf_of.map_or_else(String::new, |prims| format!(", {}", triangles(prims)));
                write!(f, "{kind} {node}{of}{prims}: ")?;
                let inside = format!("t {near:.6} .. {far:.6}");
                match *verdict {
                    "dropped" => write!(f, "dropped, a closer hit is known"),
                    "miss" if near > far => write!(f, "{inside}, missed"),
                    "miss" => write!(f, "{inside}, outside the ray's range"),
                    "farther" => write!(f, "{inside}, behind the closest hit"),
                    _ => write!(f, "{inside}, entered"),
                }
            }
            Self::Cell {
                cell: [x, y, z],
                enter,
                t_next: [nx, ny, nz],
                prims,
                ..
            } => {
                write!(
                    f,
                    "cell {x},{y},{z}: from t {enter:.6}, {}, next faces at t {nx:.6}, {ny:.6}, {nz:.6}",
                    triangles(*prims)
                )
            }
            Self::Primitive {
                prim,
                leaf,
                edges,
                signs,
                t,
                verdict,
                ..
            } => {
                let of = leaf.map_or_else(String::new, |leaf| format!(" in {leaf}"));
                write!(f, "triangle {prim}{of}: ")?;
                if let (Some(edges), Some(signs)) = (edges, signs) {
                    let edge = |k: usize| match (edges[k], signs[k]) {
                        (0.0, sign) => format!(
                            "0 ({})",
                            if sign < 0 {
                                "-"
                            } else if sign > 0 {
                                "+"
                            } else {
                                "a point"
                            }
                        ),
                        (edge, _) => format!("{edge:+.3e}"),
                    };
                    write!(f, "edges {} {} {}; ", edge(0), edge(1), edge(2))?;
                }
                match (*verdict, t) {
                    ("closest", Some(t)) => write!(f, "hit at t {t:.6}, the closest so far"),
                    ("farther", Some(t)) => write!(f, "hit at t {t:.6}, not the closest"),
                    ("out of range", Some(t)) => {
                        write!(f, "the line hits at t {t:.6}, outside the ray's range")
                    }
                    _ => write!(f, "missed"),
                }
            }
        }
    }
}

fn triangles(count: u32) -> String {
    if count == 1 {
        "1 triangle".to_owned()
    } else {
        format!("{count} triangles")
    }
}
