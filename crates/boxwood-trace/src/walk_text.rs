//! A walk for people: a line for each step, indented by depth.

use crate::number::{Fixed, counted, grouped};
use crate::walk::{
    BoxTrace, BoxVerdict, CellTrace, Event, InstanceTrace, InstanceVerdict, PrimitiveTrace,
    PrimitiveVerdict, RayTrace, WalkTrace,
};
use std::fmt;

impl WalkTrace {
    /// The ray, up to `limit` steps, the answer and what it cost.
    pub fn text(&self, limit: usize) -> String {
        let mut lines = vec![self.ray.to_string(), String::new()];
        if !self.ray.is_valid {
            lines.push(
                "this is no ray (no direction, or numbers out of range): it hits nothing\n"
                    .to_owned(),
            );
        }
        lines.extend(
            self.steps
                .iter()
                .take(limit)
                .map(|step| format!("{}{}", "  ".repeat(step.depth as usize), step.event)),
        );
        if self.steps.len() > limit {
            let rest = grouped((self.steps.len() - limit) as u64);
            lines.push(format!("... and {rest} steps more"));
        }
        lines.push(String::new());
        lines.push(self.answer());
        lines.push(self.cost());
        lines.join("\n")
    }

    /// `hit: triangle 3 at t = 2.5, u = 0.25, v = 0.5`, or `no hit`.
    pub fn answer(&self) -> String {
        let Some(hit) = &self.hit else {
            return "no hit".to_owned();
        };
        let instance = hit
            .inst
            .map_or_else(String::new, |path| format!(", in instance {path}"));
        format!(
            "hit: triangle {} at t = {}, u = {}, v = {}{instance}",
            hit.prim, hit.t, hit.u, hit.v
        )
    }

    /// The tests of all steps together, with flops and bytes.
    pub fn cost(&self) -> String {
        let counts = &self.counts;
        format!(
            "{} box tests, {} boxes or cells entered; {} triangle tests; {} flop, {} bytes read",
            grouped(counts.box_tests),
            grouped(counts.nodes),
            grouped(counts.primitive_tests),
            grouped(counts.flops),
            grouped(counts.bytes)
        )
    }
}

impl fmt::Display for RayTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |x: &Option<f32>| x.map_or_else(|| "-".to_owned(), |x| x.to_string());
        let point = |p: &[Option<f32>; 3]| format!("({})", p.each_ref().map(number).join(", "));
        write!(
            f,
            "ray from {} along {}, t in {} .. {}",
            point(&self.origin),
            point(&self.dir),
            number(&self.t_min),
            self.t_max
                .map_or_else(|| "inf".to_owned(), |t| t.to_string())
        )
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Box(test) => test.fmt(f),
            Self::Cell(visit) => visit.fmt(f),
            Self::Primitive(test) => test.fmt(f),
            Self::Instance(visit) => visit.fmt(f),
        }
    }
}

impl fmt::Display for BoxTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.leaf_of.is_some() {
            "leaf"
        } else {
            "box"
        };
        write!(f, "{kind} {}", self.node)?;
        if let Some(parent) = self.parent {
            write!(f, " in {parent}")?;
        }
        if let Some(prims) = self.leaf_of {
            write!(f, ", {}", counted(prims as usize, "triangle"))?;
        }
        let is_beside = match (self.near, self.far) {
            (Some(near), Some(far)) => near > far,
            _ => true,
        };
        if self.verdict != BoxVerdict::Dropped {
            write!(f, ": t {} .. {}", Fixed(self.near), Fixed(self.far))?;
        }
        f.write_str(match self.verdict {
            BoxVerdict::Dropped => ": dropped, a closer hit is known",
            BoxVerdict::Miss if is_beside => ", missed",
            BoxVerdict::Miss => ", outside the ray's range",
            BoxVerdict::Farther => ", behind the closest hit",
            BoxVerdict::Enter => ", entered",
        })
    }
}

impl fmt::Display for CellTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([x, y, z], [nx, ny, nz]) = (self.cell, self.t_next.map(Fixed));
        write!(
            f,
            "cell {x},{y},{z}: from t {}, {}, next faces at t {nx}, {ny}, {nz}",
            Fixed(self.enter),
            counted(self.prims as usize, "triangle")
        )
    }
}

impl fmt::Display for PrimitiveTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "triangle {}", self.prim)?;
        if let Some(leaf) = self.leaf {
            write!(f, " in {leaf}")?;
        }
        f.write_str(": ")?;
        if let (Some(edges), Some(signs)) = (self.edges, self.signs) {
            let [a, b, c] = [0, 1, 2].map(|k| edge(edges[k], signs[k]));
            write!(f, "edges {a} {b} {c}; ")?;
        }
        match (self.verdict, self.t) {
            (PrimitiveVerdict::Closest, Some(t)) => {
                write!(f, "hit at t {t:.6}, the closest so far")
            }
            (PrimitiveVerdict::Farther, Some(t)) => write!(f, "hit at t {t:.6}, not the closest"),
            (PrimitiveVerdict::OutOfRange, Some(t)) => {
                write!(f, "the line hits at t {t:.6}, outside the ray's range")
            }
            _ => f.write_str("missed"),
        }
    }
}

/// A zero with the sign that the rule of ties gives it.
fn edge(edge: f64, sign: i8) -> String {
    match (edge, sign) {
        (0.0, ..0) => "0 (-)".to_owned(),
        (0.0, 1..) => "0 (+)".to_owned(),
        (0.0, 0) => "0 (a point)".to_owned(),
        _ => format!("{edge:+.3e}"),
    }
}

impl fmt::Display for InstanceTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.verdict {
            InstanceVerdict::Enter => "the ray is turned into its space",
            InstanceVerdict::Masked => "not there for this ray",
            InstanceVerdict::Miss => "in its space this is no ray",
            InstanceVerdict::Leave => "left",
        };
        write!(f, "instance {}: {what}", self.instance)
    }
}
