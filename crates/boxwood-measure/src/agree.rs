//! Whether two contenders give the same answers: a race between right and wrong says nothing.

use crate::{
    contender::{Contender, Mode},
    rays::{Question, RaySet, sample},
};
use boxwood::{Hit, Ray};
use serde::{Deserialize, Serialize};

/// Rays of a set on which two contenders agree, or how they do not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Agreement {
    /// Compared.
    pub rays: usize,
    /// Hit something, by the first's answer.
    pub hits: usize,
    /// The same in every bit of `t`, `u`, `v` and the number of the primitive.
    pub same_bits: usize,
    /// The same primitive, or another one as far away as that: two that touch or coincide.
    pub same: usize,
    /// Both hit, but not in the same place.
    pub elsewhere: usize,
    /// Only the first hits.
    pub only_first: usize,
    /// Only the second hits.
    pub only_second: usize,
}

/// Two distances that differ by no more than this part are the same: other libraries round differently.
const SAME: f32 = 1e-4;

impl Agreement {
    /// Rays of which the two say different things.
    pub fn differences(&self) -> usize {
        self.rays - self.same
    }

    /// Both sums.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            same_bits: self.same_bits + other.same_bits,
            same: self.same + other.same,
            elsewhere: self.elsewhere + other.elsewhere,
            only_first: self.only_first + other.only_first,
            only_second: self.only_second + other.only_second,
        }
    }

    /// `scale` is the size of the scene: what differs by less than a 10^6th of it is rounding.
    fn add(&mut self, first: Option<Hit>, second: Option<Hit>, scale: f32) {
        self.rays += 1;
        self.hits += usize::from(first.is_some());
        match (first, second) {
            (None, None) => {
                self.same += 1;
                self.same_bits += 1;
            }
            (Some(_), None) => self.only_first += 1,
            (None, Some(_)) => self.only_second += 1,
            (Some(a), Some(b)) => {
                let bits = |hit: Hit| ([hit.t, hit.u, hit.v].map(f32::to_bits), hit.prim);
                self.same_bits += usize::from(bits(a) == bits(b));
                let near = (a.t - b.t).abs() <= SAME * a.t.abs() + 1e-6 * scale;
                self.same += usize::from(near);
                self.elsewhere += usize::from(!near);
            }
        }
    }
}

/// Compares both ways to ask `first` and `second` over about `count` rays of the set, one way at a time. `scale` is the size of
/// the scene in the units of `t`.
pub fn agreement(
    first: (&dyn Contender, Mode),
    second: (&dyn Contender, Mode),
    set: &RaySet,
    count: usize,
    scale: f32,
) -> Agreement {
    let rays = sample(&set.rays, count);
    let [a, b] = [first, second].map(|(who, mode)| answers(who, mode, set.question, &rays));
    let mut agreement = Agreement::default();
    a.into_iter()
        .zip(b)
        .for_each(|(a, b)| agreement.add(a, b, scale));
    agreement
}

/// An occluded ray counts as one hit at 0.
fn answers(who: &dyn Contender, mode: Mode, question: Question, rays: &[Ray]) -> Vec<Option<Hit>> {
    match question {
        Question::Closest => {
            let mut hits = vec![None; rays.len()];
            who.closest_hits(mode, rays, &mut hits);
            hits
        }
        Question::Occluded => {
            let mut occluded = vec![false; rays.len()];
            who.occluded(mode, rays, &mut occluded);
            let somewhere = Hit {
                t: 0.0,
                u: 0.0,
                v: 0.0,
                prim: 0,
                geom: 0,
                inst: 0,
            };
            occluded
                .into_iter()
                .map(|is| is.then_some(somewhere))
                .collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_is_told_apart_from_what_is_rounded() {
        let hit = |t: f32, prim| {
            Some(Hit {
                t,
                u: 0.25,
                v: 0.5,
                prim,
                geom: 0,
                inst: 0,
            })
        };
        let mut all = Agreement::default();
        for (a, b) in [
            (None, None),
            (hit(2.0, 3), hit(2.0, 3)),
            (hit(2.0, 3), hit(2.000_01, 4)),
            (hit(2.0, 3), hit(2.5, 3)),
            (hit(2.0, 3), None),
            (None, hit(2.0, 3)),
        ] {
            all.add(a, b, 1.0);
        }
        let expected = Agreement {
            rays: 6,
            hits: 4,
            same_bits: 2,
            same: 3,
            elsewhere: 1,
            only_first: 1,
            only_second: 1,
        };
        assert_eq!((all, all.differences()), (expected, 3));
        assert_eq!(all.and(all).rays, 12);
    }
}
