//! A ray's walk as the page reads it: the trace of `boxwood explain --json`, and what each step is about as points to draw.

use boxwood::{Ray, Scene};
use boxwood_trace::{Event, WalkStep, WalkTrace};
use serde::Serialize;
use std::collections::HashMap;

/// A whole walk.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WalkAnswer {
    /// As the command line tells it.
    #[serde(flatten)]
    pub trace: WalkTrace,
    /// For each step: two corners of a box, three of a triangle, or nothing.
    pub points: Vec<Vec<[f32; 3]>>,
}

impl WalkAnswer {
    /// Walks `ray` through `scene`. Looks at every node of the structure once.
    pub(crate) fn of(scene: &Scene, ray: &Ray) -> Self {
        let trace = boxwood_trace::walk(scene, ray);
        let mut boxes = HashMap::new();
        scene.query().for_each_node(&mut |node| {
            boxes.insert(node.node, vec![node.bounds.min, node.bounds.max]);
        });
        let points = |step: &WalkStep| match &step.event {
            Event::Box(test) => boxes.get(&test.node).cloned(),
            Event::Primitive(test) => scene.triangle_in_scene(test.prim).map(|t| t.0.to_vec()),
            Event::Cell(_) | Event::Instance(_) => None,
        };
        Self {
            points: trace
                .steps
                .iter()
                .map(|step| points(step).unwrap_or_default())
                .collect(),
            trace,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Lab;

    #[test]
    fn every_box_has_two_corners_and_every_triangle_three() {
        let mut lab = Lab::open("builtin:cornell", None).unwrap();
        for structure in ["list", "bounded", "bvh2", "wide"] {
            let number = lab.build(structure, "median").unwrap().number;
            let walk = lab.walk(number, 161, 97).unwrap();
            assert!(walk.trace.hit.is_some());
            for (step, points) in walk.trace.steps.iter().zip(&walk.points) {
                let wanted = if matches!(step.event, Event::Box(_)) {
                    2
                } else {
                    3
                };
                assert_eq!(points.len(), wanted, "{structure}: {step:?}");
            }
        }
    }
}
