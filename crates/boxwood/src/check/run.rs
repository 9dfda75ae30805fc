//! The order of work: right answers first, then one structure after the other.

use super::compare::{self, Reference, in_blocks, on_one_thread};
use super::report::Tally;
use super::variants::ORACLE;
use super::{Options, Progress, Rays, Report, Variant, closed};
use crate::build::BuildOptions;
use crate::error::BuildError;
use crate::geom::Triangle;
use crate::prims::{Geometry, Primitives, Triangles};
use crate::query::{Counts, Query};
use crate::tables::Structure;
use std::ops::Range;

/// Rays whose right answers are kept in memory at a time. The variants are built anew for each round.
const ROUND: usize = 1 << 20;
/// Rays between two reports of progress.
const STRIDE: u64 = 1 << 14;
/// Rays by which the price of a ray is found out.
const PROBES: u64 = 256;
/// Rays that are asked once more on one thread.
const ALONE: u64 = 1 << 13;

/// A check at work.
pub(super) struct Check<'a, 'p> {
    geometry: Geometry,
    rays: Rays<'a>,
    variants: &'a [Variant],
    options: &'a Options,
    progress: &'p mut dyn FnMut(&Progress<'_>),
    oracle: Box<dyn Query>,
    report: Report,
    steps: Steps,
}

/// How far the work is, in rays asked of a structure.
struct Steps {
    done: u64,
    total: u64,
}

impl<'a, 'p> Check<'a, 'p> {
    pub(super) fn new(
        triangles: &'a [Triangle],
        variants: &'a [Variant],
        options: &'a Options,
        progress: &'p mut dyn FnMut(&Progress<'_>),
    ) -> Result<Self, BuildError> {
        let geometry = Geometry::Triangles(Triangles::new(triangles.to_vec()));
        let oracle = Structure::named(ORACLE)?.build(&geometry, &BuildOptions::default())?;
        let is_closed = is_closed(triangles);
        Self::against(oracle, is_closed, triangles, variants, options, progress)
    }

    /// With right answers from elsewhere; the rays are aimed at `triangles`.
    pub(super) fn against(
        oracle: Box<dyn Query>,
        is_closed: bool,
        triangles: &'a [Triangle],
        variants: &'a [Variant],
        options: &'a Options,
        progress: &'p mut dyn FnMut(&Progress<'_>),
    ) -> Result<Self, BuildError> {
        let geometry = Geometry::Triangles(Triangles::new(triangles.to_vec()));
        let mut check = Self {
            rays: Rays::new(triangles, options.aim, options.seed),
            report: Report {
                is_closed,
                rays: options.rays,
                ..Report::default()
            },
            steps: Steps {
                done: 0,
                total: options.rays.saturating_mul(variants.len() as u64 + 1),
            },
            geometry,
            variants,
            options,
            progress,
            oracle,
        };
        check.report.oracle_rays = match variants {
            [] => options.rays,
            _ => check.affordable(&*check.oracle, options.oracle_budget),
        };
        Ok(check)
    }

    pub(super) fn run(mut self) -> Result<Report, BuildError> {
        for start in (0..self.options.rays).step_by(ROUND) {
            self.round(start..self.options.rays.min(start + ROUND as u64))?;
        }
        Ok(self.report)
    }

    /// How many of the first rays may be asked for their closest hit at that price.
    fn affordable(&self, query: &dyn Query, budget: u64) -> u64 {
        let mut counts = Counts::default();
        // A few rays of a long list tell its price.
        let probes = PROBES.min(1 + 50_000_000 / (self.geometry.len() as u64 + 1));
        for index in 0..probes.min(self.options.rays) {
            query.closest_hit_counted(&self.rays.ray(index), &mut counts);
        }
        let rays = u128::from(budget) * u128::from(counts.rays) / u128::from(counts.flops.max(1));
        self.options
            .rays
            .min(rays.max(1).try_into().unwrap_or(u64::MAX))
    }

    fn round(&mut self, range: Range<u64>) -> Result<(), BuildError> {
        let mut reference = Reference::with_capacity((range.end - range.start) as usize);
        let stand_in = self
            .variants
            .first()
            .map(|v| v.build(&self.geometry))
            .transpose()?;
        for part in parts(&range) {
            self.tell("list", part.start);
            self.refer(part, stand_in.as_deref(), &mut reference);
        }
        drop(stand_in);
        let variants = self.variants;
        for (number, variant) in variants.iter().enumerate() {
            self.compare(number, variant, range.clone(), &reference)?;
        }
        Ok(())
    }

    /// Finds the right answers, and the parity of lines, of the next rays.
    fn refer(&mut self, part: Range<u64>, stand_in: Option<&dyn Query>, reference: &mut Reference) {
        let (by_list, oracle) = (self.report.oracle_rays, &*self.oracle);
        let (rays, is_closed) = (&self.rays, self.report.is_closed);
        let blocks = in_blocks(part.clone(), |block| {
            let right = |index| {
                if index < by_list {
                    oracle
                } else {
                    stand_in.unwrap_or(oracle)
                }
            };
            let known = Reference::of(block.clone(), rays, right);
            let parity = compare::parity(block, rays, stand_in.unwrap_or(oracle), is_closed);
            (known, parity)
        });
        for (known, parity) in blocks {
            self.report.add_parity(parity);
            reference.append(known);
        }
        self.report
            .count_hits(part.clone(), reference.last(part.end - part.start));
        self.steps.done += part.end - part.start;
    }

    fn compare(
        &mut self,
        number: usize,
        variant: &Variant,
        range: Range<u64>,
        reference: &Reference,
    ) -> Result<(), BuildError> {
        let query = variant.build(&self.geometry)?;
        if range.start == 0 {
            // Four questions, and `all_hits` now and then, which looks farther than to the closest.
            let rays = self.affordable(&*query, self.options.budget / 5);
            self.report.add_variant(&variant.name, rays);
        }
        let end = range.end.min(self.report.variants[number].rays);
        let mut tally = Tally::default();
        if range.start < end {
            for part in parts(&(range.start..end)) {
                self.tell(&variant.name, part.start);
                let rays = &self.rays;
                let (first, known) = (range.start, reference);
                in_blocks(part.clone(), |block| {
                    compare::block(&*query, block, first, rays, known)
                })
                .into_iter()
                .for_each(|t| tally.add(t));
                self.steps.done += part.end - part.start;
            }
        }
        self.steps.done += range.end - end.max(range.start);
        drop(query);
        if range.start == 0 {
            let rays = &self.rays;
            let alone = on_one_thread(|| -> Result<Tally, BuildError> {
                let query = variant.build(&self.geometry)?;
                Ok(compare::one_slice(
                    &*query,
                    0..end.min(ALONE),
                    rays,
                    reference,
                ))
            })?;
            tally.add(alone);
        }
        self.report.add(number, tally);
        Ok(())
    }

    fn tell(&mut self, structure: &str, ray: u64) {
        let Steps { done, total } = self.steps;
        let differences = self.report.differences;
        (self.progress)(&Progress {
            structure,
            ray,
            done,
            total,
            differences,
        });
    }
}

/// True if those of the triangles that can be hit are a [`closed`] mesh.
pub(super) fn is_closed(triangles: &[Triangle]) -> bool {
    let prims = Triangles::new(triangles.to_vec());
    let active = (0..triangles.len()).filter(|i| prims.is_active(*i));
    closed(&active.map(|i| triangles[i]).collect::<Vec<_>>())
}

fn parts(range: &Range<u64>) -> impl Iterator<Item = Range<u64>> + use<> {
    let end = range.end;
    range
        .clone()
        .step_by(STRIDE as usize)
        .map(move |start| start..end.min(start + STRIDE))
}
