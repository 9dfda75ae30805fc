//! The frame's tree, told set by set: the tree is built as ever, then each set is looked at again by the same rule.

use super::{Cut, Frame, PATIENCE, Reference, Set, Split, longest, top_down};
use crate::build::input::Watch;
use crate::build::steps::{BuildStep, BuildWalk, Choice, Plane, SetStep, Why, told};
use crate::build::{BuildInput, BuildOptions, Progress};
use crate::error::BuildError;
use crate::geom::Aabb;
use std::ops::Range;

/// What a rule weighs in a set.
pub(crate) struct Look {
    pub(crate) planes: Vec<Plane>,
    pub(crate) weighed: usize,
    /// The one that the rule takes.
    pub(crate) best: Option<Plane>,
    pub(crate) leaf_cost: Option<f32>,
}

impl Look {
    /// One plane, and no costs.
    pub(crate) fn at(axis: usize, at: f32, left: usize) -> Self {
        let plane = Plane {
            axis,
            at,
            left: left as u32,
            cost: None,
        };
        Self {
            planes: vec![plane],
            weighed: 1,
            best: Some(plane),
            leaf_cost: None,
        }
    }

    /// No plane.
    pub(crate) const NONE: Self = Self {
        planes: Vec::new(),
        weighed: 0,
        best: None,
        leaf_cost: None,
    };
}

/// [`top_down`] with its steps, up to `limit` of them.
pub(crate) fn explain(
    input: &BuildInput<'_>,
    options: &BuildOptions,
    split: &impl Split,
    limit: usize,
) -> Result<BuildWalk, BuildError> {
    let tree = top_down(input, options, split)?;
    // The build has reported its progress.
    let silent = Progress::default();
    let frame = Frame {
        split,
        leaf_limit: input.leaf_limit(options),
        watch: Watch::start(&silent, tree.order.len())?,
    };
    let slots = tree.slots_below();
    let is_told = told(&tree, limit);
    let mut steps = Vec::new();
    // Depth first, as the frame goes.
    let mut waiting: Vec<(usize, Option<u32>, usize)> =
        Vec::from_iter(is_told.first().map(|_| (0, None, 0)));
    while let Some((index, parent, depth)) = waiting.pop() {
        if !is_told[index] {
            continue;
        }
        let node = &tree.nodes[index];
        if !node.is_leaf() {
            let below = |child| (child as usize, Some(index as u32), depth + 1);
            waiting.extend([below(node.first + 1), below(node.first)]);
        }
        let mut refs: Vec<Reference> = tree.order[range(&slots[index])]
            .iter()
            .map(|&prim| Reference {
                bounds: input.boxes[prim as usize],
                prim,
            })
            .collect();
        let set = Set::new(&mut refs, depth);
        let centers = halved(&set.centers);
        let (look, choice) = frame.look(set, [node.first, node.first + 1])?;
        steps.push(BuildStep::Set(SetStep {
            node: index as u32,
            parent,
            depth: depth as u32,
            slots: slots[index].clone(),
            bounds: node.bounds,
            centers,
            planes: look.planes,
            weighed: look.weighed as u32,
            leaf_cost: look.leaf_cost,
            choice,
        }));
    }
    Ok(BuildWalk {
        steps,
        step_count: tree.nodes.len(),
        order: tree.order.clone(),
        curve: Vec::new(),
        tree,
    })
}

impl<S: Split> Frame<'_, S> {
    /// What the rule weighs in a set, and what becomes of it.
    fn look(&self, mut set: Set<'_>, children: [u32; 2]) -> Result<(Look, Choice), BuildError> {
        let (count, is_deep) = (set.refs.len(), set.depth >= PATIENCE);
        let look = match count {
            0 | 1 => Look::NONE,
            _ if is_deep => Look::NONE,
            _ => self.split.look(&mut set)?,
        };
        let why = |otherwise| if is_deep { Why::Deep } else { otherwise };
        let choice = match self.place(&mut set)? {
            None if count == 1 => Choice::Leaf(Why::Few),
            None if look.leaf_cost.is_some() => Choice::Leaf(why(Why::Cheaper)),
            None => Choice::Leaf(why(Why::Few)),
            Some(Cut {
                middle,
                is_halved: true,
            }) => Choice::Split {
                plane: halfway(&mut set, middle),
                why: why(Why::Alike),
                children,
            },
            Some(Cut { middle, .. }) => Choice::Split {
                plane: look.best.unwrap_or_else(|| halfway(&mut set, middle)),
                why: Why::Rule,
                children,
            },
        };
        Ok((look, choice))
    }
}

/// The plane between the halves of a set that was just halved along its longest axis.
fn halfway(set: &mut Set<'_>, middle: usize) -> Plane {
    let axis = longest(&set.centers);
    Plane {
        axis,
        at: between(set.refs, axis, middle),
        left: middle as u32,
        cost: None,
    }
}

/// A coordinate between the centres of both parts.
pub(crate) fn between(refs: &[Reference], axis: usize, middle: usize) -> f32 {
    let (left, right) = refs.split_at(middle);
    let along = |r: &Reference| r.center2_along(axis);
    let last = left.iter().map(along).fold(f32::NEG_INFINITY, f32::max);
    let first = right.iter().map(along).fold(f32::INFINITY, f32::min);
    0.25 * last + 0.25 * first
}

/// From doubled centres to centres.
pub(crate) fn halved(doubled: &Aabb) -> Aabb {
    Aabb {
        min: doubled.min.map(|x| 0.5 * x),
        max: doubled.max.map(|x| 0.5 * x),
    }
}

fn range(slots: &Range<u32>) -> Range<usize> {
    slots.start as usize..slots.end as usize
}
