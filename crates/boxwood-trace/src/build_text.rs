//! A build for people: a paragraph for each set, a line for each merge, move and grid.

use crate::build::{
    Axis, Bounds, BuildTrace, GridTrace, LeafTrace, MergeTrace, MoveTrace, PlaneTrace, SetTrace,
    SplitTrace, StepTrace, WhyTrace,
};
use crate::number::{counted, grouped, point, short};
use std::fmt;

impl BuildTrace {
    /// What was built, the steps that are told, and what came of them.
    pub fn text(&self) -> String {
        let mut lines = vec![self.summary(), String::new()];
        lines.extend(self.steps.iter().map(StepTrace::to_string));
        if self.steps.len() < self.steps_total {
            let rest = grouped((self.steps_total - self.steps.len()) as u64);
            lines.push(format!("... and {rest} steps more"));
        }
        if self.steps_total > 0 {
            lines.push(String::new());
        }
        lines.push(self.outcome());
        lines.join("\n")
    }

    /// `bvh2 (binned, aabb) over 36 triangles in (0, 0, 0) .. (5, 5, 5)`.
    pub fn summary(&self) -> String {
        let around = self
            .bounds
            .map_or_else(String::new, |bounds| format!(" in {bounds}"));
        let skipped = match self.skipped {
            0 => String::new(),
            n => format!(" ({} of them can never be hit)", grouped(n as u64)),
        };
        let prims = counted(self.primitives, "primitive");
        format!("{} over {prims}{skipped}{around}", self.structure)
    }

    /// The totals in one line.
    pub fn outcome(&self) -> String {
        let stats = &self.stats;
        let cost = stats.sah_cost.map_or_else(String::new, |cost| {
            format!(
                ", {} visits and tests for a random line",
                short(cost as f32)
            )
        });
        format!(
            "{}: {}, {}, {} deep, {}, {} bytes{cost}",
            counted(self.steps_total, "step"),
            counted(stats.nodes, "node"),
            match stats.leaves {
                1 => "1 leaf".to_owned(),
                n => format!("{} leaves", grouped(n as u64)),
            },
            stats.max_depth,
            counted(stats.references, "reference"),
            grouped(stats.bytes as u64)
        )
    }
}

impl fmt::Display for StepTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Split(split) => split.fmt(f),
            Self::Leaf(leaf) => leaf.fmt(f),
            Self::Merge(merge) => merge.fmt(f),
            Self::Move(step) => step.fmt(f),
            Self::Grid(grid) => grid.fmt(f),
        }
    }
}

impl SetTrace {
    fn indent(&self) -> String {
        "  ".repeat(self.depth as usize)
    }

    /// The set, and for each axis what was weighed.
    fn head(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let indent = self.indent();
        let prims = counted(self.count as usize, "primitive");
        write!(f, "{indent}node {}: {prims} in {}", self.node, self.bounds)?;
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let planes: Vec<&PlaneTrace> = self.planes.iter().filter(|p| p.axis == axis).collect();
            let best = planes
                .iter()
                .min_by(|a, b| cost_of(a).total_cmp(&cost_of(b)));
            if let Some(best) = best {
                let (k, told) = (axis as usize, planes.len());
                let centers = format!(
                    "{} .. {}",
                    short(self.centers.min[k]),
                    short(self.centers.max[k])
                );
                write!(
                    f,
                    "\n{indent}  {axis}: centres in {centers}; {}",
                    counted(told, "plane")
                )?;
                write!(f, ", best {best}")?;
            }
        }
        Ok(())
    }

    fn leaf_cost(&self) -> String {
        self.leaf_cost
            .map_or_else(String::new, |cost| format!(", as a leaf {}", short(cost)))
    }
}

/// Those without costs come last.
fn cost_of(plane: &PlaneTrace) -> f32 {
    plane.cost.unwrap_or(f32::INFINITY)
}

impl fmt::Display for SplitTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.set.head(f)?;
        let [left, right] = self.children;
        let why = match self.set.why {
            WhyTrace::Alike => "; halved, as the rule does not part them",
            WhyTrace::Deep => "; halved, as the tree is deep",
            _ => "",
        };
        write!(
            f,
            "\n{}  split into {left} and {right} at {} = {}{}{why}",
            self.set.indent(),
            self.plane.axis,
            self.plane,
            self.set.leaf_cost()
        )
    }
}

impl fmt::Display for LeafTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.set.head(f)?;
        let why = match self.set.why {
            WhyTrace::Few => "few enough",
            WhyTrace::Cheaper => "no split is cheaper",
            WhyTrace::Alike => "they cannot be told apart",
            _ => "few enough, and deep",
        };
        write!(f, "\n{}  leaf of {}", self.set.indent(), list(&self.prims))?;
        match self.set.leaf_cost {
            Some(cost) => write!(f, ", cost {}: {why}", short(cost)),
            None => write!(f, ": {why}"),
        }
    }
}

/// The first few.
fn list(prims: &[u32]) -> String {
    let shown: Vec<String> = prims.iter().take(8).map(u32::to_string).collect();
    match prims.len() - shown.len() {
        0 => shown.join(", "),
        rest => format!("{} and {rest} more", shown.join(", ")),
    }
}

/// `278 (18 | 18), cost 12.3`.
impl fmt::Display for PlaneTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({} | {})", short(self.at), self.left, self.right)?;
        match self.cost {
            Some(cost) => write!(f, ", cost {}", short(cost)),
            None => Ok(()),
        }
    }
}

impl fmt::Display for MergeTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = self.parts;
        write!(
            f,
            "round {}: {a} and {b} become {}",
            self.round, self.cluster
        )?;
        let prims = counted(self.count as usize, "primitive");
        write!(f, ", {prims} in {}", self.bounds)?;
        match (self.node, self.is_leaf) {
            (Some(node), true) => write!(f, "; leaf {node}"),
            (Some(node), false) => write!(f, "; node {node}"),
            (None, _) => f.write_str("; inside of a leaf"),
        }
    }
}

impl fmt::Display for MoveTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            round,
            node,
            to,
            gain,
        } = self;
        write!(
            f,
            "round {round}: node {node} is put beside {to}, gain {}",
            short(*gain)
        )
    }
}

impl fmt::Display for GridTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.cells;
        let density = short(self.density as f32);
        write!(f, "{density} cells per primitive: {x} x {y} x {z} cells, ")?;
        match self.references {
            Some(n) => f.write_str(&counted(n, "reference")),
            None => write!(f, "more than {} references", grouped(self.limit as u64)),
        }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        })
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} .. {}", point(self.min), point(self.max))
    }
}
