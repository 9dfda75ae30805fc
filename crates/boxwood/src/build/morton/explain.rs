//! The build told merge by merge. The tree is built as ever; then the curve is reduced once more by the same parts, one
//! block after the other.

use super::merge::{Clusters, Merges, scale_of};
use super::sort::{codes, places_along_curve};
use super::{BLOCK, PATIENCE, REDUCED, build};
use crate::build::fragment::{Fragment, box_around, fragments};
use crate::build::input::LeafRule;
use crate::build::steps::{BuildStep, BuildWalk, CurvePlace, MergeStep};
use crate::build::{BuildInput, BuildOptions, Topology};
use crate::error::BuildError;
use crate::geom::Aabb;
use fearless_simd::{Simd, dispatch};

/// [`super::build`] with its steps, up to `limit` of them.
pub(in crate::build) fn explain(
    input: &BuildInput<'_>,
    options: &BuildOptions,
    limit: usize,
) -> Result<BuildWalk, BuildError> {
    let tree = build(input, options)?;
    let fragments = fragments(input)?;
    if fragments.is_empty() {
        return Ok(BuildWalk::default());
    }
    let rule = input.leaf_rule(options);
    dispatch!(options.instructions.0, simd => tell(simd, tree, &fragments, rule, limit))
}

fn tell<S: Simd>(
    simd: S,
    tree: Topology,
    fragments: &[Fragment],
    rule: LeafRule,
    limit: usize,
) -> Result<BuildWalk, BuildError> {
    let places = places_along_curve(simd, fragments)?;
    let codes = codes(simd, fragments)?;
    let teller = Teller {
        simd,
        fragments,
        places: &places,
        rule,
        merges: Merges::new(fragments.len())?,
    };
    let place = |&place: &u64| CurvePlace {
        prim: fragments[place as usize].number(),
        code: codes[place as usize],
    };
    let steps = teller.steps(&tree)?;
    Ok(BuildWalk {
        step_count: steps.len(),
        steps: steps
            .into_iter()
            .take(limit)
            .map(BuildStep::Merge)
            .collect(),
        order: tree.order.clone(),
        curve: places.iter().take(limit).map(place).collect(),
        tree,
    })
}

struct Teller<'a, S> {
    simd: S,
    fragments: &'a [Fragment],
    places: &'a [u64],
    rule: LeafRule,
    merges: Merges,
}

impl<S: Simd> Teller<'_, S> {
    fn steps(&self, tree: &Topology) -> Result<Vec<MergeStep>, BuildError> {
        // The round in which each merge was made, in their order.
        let mut rounds = Vec::new();
        let mut clusters = self.reduced(0..self.places.len(), &mut rounds)?;
        self.reduce(&mut clusters, 1, &mut rounds);
        let nodes = self.nodes(clusters.root(), tree);
        let mut boxes: Vec<(Aabb, u32)> =
            self.places.iter().map(|&p| (self.bounds(p), 1)).collect();
        let mut steps = Vec::new();
        for (cluster, round) in (self.places.len()..).zip(rounds) {
            let Some((parts, is_leaf)) = self.merges.children(cluster as u32) else {
                break;
            };
            let [a, b] = parts.map(|part| boxes[part as usize]);
            let (bounds, count) = (a.0.union(&b.0), a.1 + b.1);
            boxes.push((bounds, count));
            steps.push(MergeStep {
                round,
                cluster: cluster as u32,
                parts,
                bounds,
                count,
                is_leaf,
                node: nodes[cluster],
            });
        }
        Ok(steps)
    }

    fn bounds(&self, place: u64) -> Aabb {
        self.fragments[place as usize].bounds()
    }

    /// As `Frame::reduced` goes, one block after the other.
    fn reduced(
        &self,
        part: std::ops::Range<usize>,
        rounds: &mut Vec<u32>,
    ) -> Result<Clusters, BuildError> {
        let mut clusters = if part.len() <= BLOCK {
            let all = box_around(self.simd, self.fragments);
            let first = part.start as u32;
            let places = &self.places[part];
            Clusters::new(self.fragments, places, scale_of(&all), &self.rule, first)?
        } else {
            let middle = part.start + (part.len() / 2).next_multiple_of(BLOCK);
            let left = self.reduced(part.start..middle, rounds)?;
            let right = self.reduced(middle..part.end, rounds)?;
            Clusters::joined([left, right])?
        };
        if clusters.len() > BLOCK / 2 {
            self.reduce(&mut clusters, REDUCED, rounds);
        }
        Ok(clusters)
    }

    /// Merges until at most `target` clusters are left.
    fn reduce(&self, clusters: &mut Clusters, target: usize, rounds: &mut Vec<u32>) {
        while clusters.len() > target {
            let round = rounds.last().map_or(0, |last| last + 1);
            clusters.reduce_once(self.simd, &self.rule, &self.merges);
            rounds.resize(self.merges.made(), round);
        }
    }

    /// The number in the tree of each cluster that is a node there.
    fn nodes(&self, root: u32, tree: &Topology) -> Vec<Option<u32>> {
        let mut nodes = vec![None; 2 * self.places.len()];
        let mut waiting = vec![(root, 0, 0)];
        while let Some((cluster, node, depth)) = waiting.pop() {
            nodes[cluster as usize] = Some(node);
            let at = &tree.nodes[node as usize];
            // Deeper down the tree is halved instead, and nothing corresponds.
            match self.merges.children(cluster) {
                Some(([a, b], false)) if depth < PATIENCE => {
                    waiting.extend([(a, at.first, depth + 1), (b, at.first + 1, depth + 1)]);
                }
                _ => {}
            }
        }
        nodes
    }
}
