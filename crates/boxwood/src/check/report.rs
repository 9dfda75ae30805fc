//! What a check has found.

use super::bits::digest;
use super::rays::mix;
use crate::geom::{Hit, Ray};
use std::fmt;
use std::ops::Range;

/// Failures kept per structure; the others are counted.
pub(super) const KEPT: usize = 8;

/// The result of a check.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Rays shot.
    pub rays: u64,
    /// Rays that hit something.
    pub hits: u64,
    /// The first so many rays were answered by brute force.
    pub oracle_rays: u64,
    /// Rays and structures whose answer differs from the right one in at least one bit: once per ray and structure.
    pub differences: u64,
    /// Those of the differences where a hit was lost.
    pub misses: u64,
    /// True if every edge of the mesh is used an even number of times.
    pub is_closed: bool,
    /// Lines tested for parity: every valid ray if the mesh is closed, else none.
    pub parity_rays: u64,
    /// Lines that meet a closed mesh an odd number of times.
    pub parity_errors: u64,
    /// Of the closest hits of all rays, in every bit: the same on every machine and for any number of threads.
    pub digest: u64,
    /// Structure by structure.
    pub variants: Vec<VariantReport>,
    /// The first failures of each structure.
    pub failures: Vec<Failure>,
}

/// One structure in a [`Report`].
#[derive(Clone, Debug, PartialEq)]
pub struct VariantReport {
    /// As [`Variant::name`](super::Variant::name).
    pub name: String,
    /// It was asked about the first so many rays.
    pub rays: u64,
    /// See [`Report::differences`].
    pub differences: u64,
    /// See [`Report::misses`].
    pub misses: u64,
}

/// How far a check is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress<'a> {
    /// At work.
    pub structure: &'a str,
    /// The ray it has come to.
    pub ray: u64,
    /// Rays times structures done.
    pub done: u64,
    /// Rays times structures to do.
    pub total: u64,
    /// Found so far.
    pub differences: u64,
}

/// A wrong answer. It prints with the ray as code that can be pasted into a test.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// Which structure.
    pub variant: String,
    /// The first question that was answered wrong.
    pub question: Question,
    /// Number of the ray.
    pub index: u64,
    /// The ray.
    pub ray: Ray,
    /// The right closest hit; for parity, what is right.
    pub expected: String,
    /// What came instead.
    pub found: String,
}

/// How a ray was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// A single ray.
    ClosestHit,
    /// A slice of rays, many threads at it.
    ClosestHits,
    /// A slice of rays on one thread, by a structure built on one thread.
    OneThread,
    /// A single ray.
    Occluded,
    /// A slice of rays.
    OccludedEach,
    /// All hits: other ones, or in another order, or the first of them is not the closest.
    AllHits,
    /// A slice of rays: lists of all hits, and how many there are.
    Lists,
    /// The number of hits of the whole line is odd, though the mesh is closed.
    Parity,
}

/// What comparing has found.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) differences: u64,
    pub(super) misses: u64,
    pub(super) failures: Vec<Failure>,
}

impl Tally {
    pub(super) fn add(&mut self, other: Self) {
        self.differences += other.differences;
        self.misses += other.misses;
        let free = KEPT.saturating_sub(self.failures.len());
        self.failures.extend(other.failures.into_iter().take(free));
    }

    /// Books one ray: what was wrong with it, if anything. A ray counts once, however many questions fail.
    pub(super) fn book(
        &mut self,
        index: u64,
        ray: &Ray,
        right: Option<&Hit>,
        wrong: &[(Question, String)],
    ) {
        let Some((question, found)) = wrong.first() else {
            return;
        };
        self.differences += 1;
        if self.failures.len() < KEPT {
            let (expected, found) = (format!("{right:?}"), found.clone());
            let variant = String::new();
            self.failures.push(Failure {
                variant,
                question: *question,
                index,
                ray: *ray,
                expected,
                found,
            });
        }
    }
}

/// Lines tested for parity, and those that meet a closed mesh an odd number of times.
#[derive(Default)]
pub(super) struct Parity {
    pub(super) lines: u64,
    pub(super) odd: Vec<(u64, Ray, usize)>,
}

impl Report {
    /// True if nothing is wrong.
    pub fn is_clean(&self) -> bool {
        self.differences == 0 && self.parity_errors == 0
    }

    pub(super) fn add_variant(&mut self, name: &str, rays: u64) {
        self.variants.push(VariantReport {
            name: name.to_owned(),
            rays,
            differences: 0,
            misses: 0,
        });
    }

    pub(super) fn add(&mut self, number: usize, tally: Tally) {
        let variant = &mut self.variants[number];
        let free = KEPT.saturating_sub(variant.differences.try_into().unwrap_or(KEPT));
        variant.differences += tally.differences;
        variant.misses += tally.misses;
        self.differences += tally.differences;
        self.misses += tally.misses;
        let failures = tally.failures.into_iter().take(free);
        self.failures.extend(failures.map(|f| Failure {
            variant: variant.name.clone(),
            ..f
        }));
    }

    pub(super) fn add_parity(&mut self, parity: Parity) {
        let free = KEPT.saturating_sub(self.parity_errors.try_into().unwrap_or(KEPT));
        self.parity_rays += parity.lines;
        self.parity_errors += parity.odd.len() as u64;
        self.failures.extend(
            parity
                .odd
                .into_iter()
                .take(free)
                .map(|(index, ray, hits)| Failure {
                    variant: "the exact test".to_owned(),
                    question: Question::Parity,
                    index,
                    ray,
                    expected: "an even number of hits on the whole line".to_owned(),
                    found: format!("{hits}"),
                }),
        );
    }

    pub(super) fn count_hits(&mut self, range: Range<u64>, answers: &[Option<Hit>]) {
        for (index, answer) in range.zip(answers) {
            self.hits += u64::from(answer.is_some());
            // A sum, so that the order of threads does not matter.
            self.digest = self.digest.wrapping_add(mix(digest(answer) ^ mix(index)));
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            variant,
            question,
            index,
            ray,
            expected,
            found,
        } = self;
        writeln!(
            f,
            "{variant}, ray {index}, {question:?}: {found} where {expected} is right"
        )?;
        write!(f, "    {}", code(ray))
    }
}

/// The ray as Rust.
fn code(ray: &Ray) -> String {
    let number = |x: f32| match x {
        x if x.is_nan() => "f32::NAN".to_owned(),
        f32::INFINITY => "f32::INFINITY".to_owned(),
        f32::NEG_INFINITY => "f32::NEG_INFINITY".to_owned(),
        // The shortest digits that give the same bits.
        x => format!("{x:?}"),
    };
    let point = |p: [f32; 3]| p.map(number).join(", ");
    let Ray {
        origin,
        t_min,
        dir,
        t_max,
    } = *ray;
    let (origin, dir) = (point(origin), point(dir));
    format!(
        "Ray {{ origin: [{origin}], t_min: {}, dir: [{dir}], t_max: {} }}",
        number(t_min),
        number(t_max)
    )
}
