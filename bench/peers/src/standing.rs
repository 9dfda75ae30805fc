//! Where a contender stands against Embree.

use boxwood_measure::{Contender, Heat, Mode, RaySet, geometric_mean};
use serde::Serialize;
use std::collections::BTreeMap;

/// Ratios over the sets of rays; above 1: faster than Embree.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Standing {
    /// Geometric mean.
    pub(crate) geomean: f64,
    /// The smallest.
    pub(crate) worst: f64,
    /// And where that is.
    pub(crate) worst_set: String,
    /// All of them.
    pub(crate) by_set: BTreeMap<String, f64>,
}

/// With whom Embree runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Against {
    /// Single rays through its default build.
    Single,
    /// The fastest on each set of single rays and packets, through its default and its high build.
    Best,
}

impl Standing {
    /// Of `contender` asked in one way, on one thread; `None` if it or Embree did not run.
    pub(crate) fn of(
        contenders: &[Box<dyn Contender>],
        heats: &[Heat],
        sets: &[RaySet],
        (contender, mode): (usize, Mode),
        against: Against,
    ) -> Option<Self> {
        let ratio = |heat: &Heat| {
            let rivals = rivals(contenders, heat, against);
            let fastest = rivals
                .into_iter()
                .max_by(|a, b| heat.mrays(*a).total_cmp(&heat.mrays(*b)))?;
            let ratio = heat.speed_against(heat.lane(contender, mode)?, fastest);
            Some((sets[heat.set].name.to_owned(), ratio))
        };
        let heats = heats.iter().filter(|heat| heat.threads == 1);
        Self::over(heats.filter_map(ratio).collect())
    }

    /// Over ratios by set; `None` without any.
    pub(crate) fn over(by_set: BTreeMap<String, f64>) -> Option<Self> {
        let (worst_set, worst) = by_set.iter().min_by(|a, b| a.1.total_cmp(b.1))?;
        Some(Self {
            geomean: geometric_mean(by_set.values().copied()),
            worst: *worst,
            worst_set: worst_set.clone(),
            by_set: by_set.clone(),
        })
    }
}

/// Lanes of Embree's.
fn rivals(contenders: &[Box<dyn Contender>], heat: &Heat, against: Against) -> Vec<usize> {
    let is_rival = |lane: &boxwood_measure::Lane| match (contenders[lane.contender].name(), against)
    {
        ("embree", Against::Single) => lane.mode == Mode::Single,
        ("embree" | "embree-high", Against::Best) => true,
        _ => false,
    };
    let lanes = heat.lanes.iter().enumerate();
    lanes
        .filter(|(_, lane)| is_rival(lane))
        .map(|(number, _)| number)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standing_is_the_mean_and_the_worst_of_the_sets() {
        let by_set =
            [("primary", 0.5), ("random", 2.0)].map(|(set, ratio)| (set.to_owned(), ratio));
        let standing = Standing::over(by_set.into()).unwrap();
        assert!((standing.geomean - 1.0).abs() < 1e-12);
        assert_eq!((standing.worst, &*standing.worst_set), (0.5, "primary"));
        assert_eq!(Standing::over(BTreeMap::new()), None);
    }
}
