//! The build told set by set. The tree is built as ever; then its sets are split once more by the same parts, one after
//! the other, and each border is shown.

use super::bins::{Binned, Border, Counter, Packed, Table};
use super::partition::partition;
use super::{FEW, Frame, PATIENCE, SMALL, Set, drop_copies, of_fragments, split_fragments};
use crate::build::fragment::{Fragment, Lanes, Scale, box_around, range_of_centers};
use crate::build::input::{Watch, filled};
use crate::build::reinsert::optimize_told;
use crate::build::steps::{BuildStep, BuildWalk, Choice, Plane, SetStep, Why, told};
use crate::build::top_down::{halved, longest};
use crate::build::{BuildInput, BuildOptions, Progress, Topology};
use crate::error::BuildError;
use fearless_simd::{Simd, dispatch};

/// [`super::build`] with its steps, up to `limit` of them.
pub(in crate::build) fn explain(
    input: &BuildInput<'_>,
    options: &BuildOptions,
    limit: usize,
) -> Result<BuildWalk, BuildError> {
    let fragments = split_fragments(input, options.split_budget)?;
    let is_split = fragments.len() > input.boxes.len();
    let watch = Watch::start(&options.progress, fragments.len())?;
    let grown = of_fragments(fragments.clone(), input, options, &watch)?;
    let mut walk = BuildWalk {
        steps: dispatch!(options.instructions.0, simd => {
            tell(simd, fragments, &grown, input, options, limit)
        })?,
        step_count: grown.nodes.len(),
        order: grown.order.clone(),
        ..BuildWalk::default()
    };
    let mut tree = grown;
    if is_split {
        drop_copies(&mut tree);
    }
    let mut moves = Vec::new();
    walk.tree = optimize_told(tree, options, &watch, &mut |step| moves.push(step))?;
    walk.add_moves(moves, limit);
    Ok(walk)
}

/// The steps of a tree that was grown over the fragments.
fn tell<S: Simd>(
    simd: S,
    mut fragments: Vec<Fragment>,
    grown: &Topology,
    input: &BuildInput<'_>,
    options: &BuildOptions,
    limit: usize,
) -> Result<Vec<BuildStep>, BuildError> {
    let count = fragments.len();
    if count == 0 {
        return Ok(Vec::new());
    }
    let silent = Progress::default();
    // The tree is the same with any room for bins.
    let frame = Frame::<_, 32> {
        simd,
        rule: input.leaf_rule(options),
        bins: (options.bins as usize).clamp(2, 32),
        watch: &Watch::start(&silent, count)?,
    };
    let mut binned = Binned::new();
    frame.bin(&fragments, &mut binned);
    let mut teller = Teller {
        frame,
        grown,
        told: told(grown, limit),
        steps: Vec::new(),
    };
    let bounds = box_around(simd, &fragments);
    let set = Set {
        from: &mut fragments,
        to: &mut filled(Lanes::EMPTY, count)?,
        order: &mut filled(0, count)?,
        bounds,
        slot: 0,
        depth: 0,
    };
    teller.tell(0, None, set, &binned);
    Ok(teller.steps)
}

struct Teller<'a, S> {
    frame: Frame<'a, S, 32>,
    grown: &'a Topology,
    told: Vec<bool>,
    steps: Vec<BuildStep>,
}

impl<S: Simd> Teller<'_, S> {
    /// Tells of the set of node `at`, then of what is below.
    fn tell(&mut self, at: usize, parent: Option<u32>, set: Set<'_>, binned: &Binned<32>) {
        if !self.told[at] {
            return;
        }
        if set.len() <= SMALL {
            return self.tell_small(at, parent, set);
        }
        let planes = self.planes(&set, &binned.scale, &binned.table);
        let best = binned
            .table
            .best_border(self.frame.simd, &set.bounds, set.len(), self.extra())
            .filter(|_| set.depth < PATIENCE);
        let mut step = self.step(at, parent, &set, planes);
        let children = self.grown.nodes[at].first as usize;
        let mut sides = [Binned::new(), Binned::new()];
        let is_deep = set.depth >= PATIENCE;
        let [left, right] = self.frame.split(set, binned, &mut sides);
        step.choice = match best {
            Some(border) => self.at_border(&border, &binned.scale, children),
            None => self.halves(&left, &right, is_deep, children),
        };
        self.steps.push(BuildStep::Set(step));
        self.tell(children, Some(at as u32), left, &sides[0]);
        self.tell(children + 1, Some(at as u32), right, &sides[1]);
    }

    /// [`Teller::tell`] for a set that gets bins of its own: as [`Frame::grow_small`] goes.
    fn tell_small(&mut self, at: usize, parent: Option<u32>, set: Set<'_>) {
        let (count, is_deep) = (set.len(), set.depth >= PATIENCE);
        let (simd, rule) = (self.frame.simd, self.frame.rule);
        if count <= rule.enough as usize {
            let step = self.step(at, parent, &set, Vec::new());
            return self.steps.push(BuildStep::Set(step));
        }
        let scale = Scale::new(&range_of_centers(simd, set.from), FEW);
        let mut table = Table::<FEW, Packed>::new();
        table.add_all(simd, set.from, &scale.load(simd));
        let planes = self.planes(&set, &scale, &table);
        let best = table
            .best_border(simd, &set.bounds, count, self.extra())
            .filter(|_| !is_deep);
        let mut step = self.step(at, parent, &set, planes);
        let is_dear = best.as_ref().is_some_and(|b| rule.splits(count, b.cost));
        if count <= rule.max as usize && !is_dear {
            step.choice = Choice::Leaf(match best {
                Some(_) => Why::Cheaper,
                None if is_deep => Why::Deep,
                None => Why::Alike,
            });
            return self.steps.push(BuildStep::Set(step));
        }
        let children = self.grown.nodes[at].first as usize;
        let sides = if let Some(border) = best {
            step.choice = self.at_border(&border, &scale, children);
            partition(simd, set.from, set.to, &scale, &border);
            set.moved_parts(&border)
        } else {
            let sides = self.frame.halve(set);
            step.choice = self.halves(&sides[0], &sides[1], is_deep, children);
            sides
        };
        self.steps.push(BuildStep::Set(step));
        for (child, side) in (children..).zip(sides) {
            if self.told[child] {
                self.tell_small(child, Some(at as u32), side);
            }
        }
    }

    /// A leaf, until something else is said.
    fn step(&self, at: usize, parent: Option<u32>, set: &Set<'_>, planes: Vec<Plane>) -> SetStep {
        let centers = range_of_centers(self.frame.simd, set.from).bounds();
        SetStep {
            node: at as u32,
            parent,
            depth: set.depth as u32,
            slots: set.slot..set.slot + set.len() as u32,
            bounds: self.grown.nodes[at].bounds,
            centers: halved(&centers),
            weighed: planes.len() as u32,
            planes,
            leaf_cost: Some(self.frame.rule.cost.of(set.len() as u32)),
            choice: Choice::Leaf(Why::Few),
        }
    }

    fn planes<const N: usize, C: Counter<N>>(
        &self,
        set: &Set<'_>,
        scale: &Scale,
        table: &Table<N, C>,
    ) -> Vec<Plane> {
        let borders = table.borders(self.frame.simd, &set.bounds, set.len(), self.extra());
        borders.iter().map(|b| self.plane(b, scale)).collect()
    }

    fn plane(&self, border: &Border, scale: &Scale) -> Plane {
        let rule = &self.frame.rule;
        Plane {
            axis: border.axis,
            at: 0.5 * scale.border(border.axis, border.bin),
            left: border.left_count as u32,
            // As `LeafRule::splits` weighs it.
            cost: Some(rule.node_cost + rule.cost.per_primitive * border.cost),
        }
    }

    fn at_border(&self, border: &Border, scale: &Scale, children: usize) -> Choice {
        Choice::Split {
            plane: self.plane(border, scale),
            why: Why::Rule,
            children: [children as u32, children as u32 + 1],
        }
    }

    fn extra(&self) -> f32 {
        self.frame.rule.extra()
    }

    /// The choice of [`Frame::halve`].
    fn halves(&self, left: &Set<'_>, right: &Set<'_>, is_deep: bool, children: usize) -> Choice {
        let range = |set: &Set<'_>| range_of_centers(self.frame.simd, set.from).bounds();
        let (before, behind) = (range(left), range(right));
        let axis = longest(&before.union(&behind));
        Choice::Split {
            plane: Plane {
                axis,
                at: 0.25 * before.max[axis] + 0.25 * behind.min[axis],
                left: left.len() as u32,
                cost: None,
            },
            why: if is_deep { Why::Deep } else { Why::Alike },
            children: [children as u32, children as u32 + 1],
        }
    }
}
