//! What is aimed at, as data: a line per goal.

use crate::measure::{Measured, Peer};
use boxwood_measure::{Mode, geometric_mean};

/// A goal.
pub(crate) struct Goal {
    /// In full.
    pub(crate) what: &'static str,
    /// As the title of a column.
    pub(crate) short: &'static str,
    /// The geometric mean over scenes and sets of rays is to be this.
    pub(crate) mean: f64,
    /// And no single value worse than this.
    pub(crate) worst: f64,
    /// True for speeds, false for times and sizes.
    higher_is_better: bool,
    /// The ratios of a scene, each with the name of its set; none if it was not measured.
    of: fn(&Measured) -> Vec<(String, f64)>,
}

/// A ratio and where it is from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Value {
    pub(crate) ratio: f64,
    /// `kitchen, shadow`.
    pub(crate) place: String,
}

/// The goals of the project's speed, in order.
pub(crate) const GOALS: &[Goal] = &[
    Goal {
        what: "single rays, against rtcIntersect1/rtcOccluded1 of the medium build",
        short: "single",
        mean: 1.3,
        worst: 1.0,
        higher_is_better: true,
        of: |scene| by_set(peer(scene, "boxwood").and_then(|peer| peer.vs_embree_single.as_ref())),
    },
    Goal {
        what: "batches, against the fastest of Embree's single rays and 16-packets, medium and high, on each set; our Default or High build, \
               the same for all sets of a scene",
        short: "batch",
        mean: 1.8,
        worst: 1.2,
        higher_is_better: true,
        of: |scene| by_set(better_build(scene).and_then(|peer| peer.vs_embree_best.as_ref())),
    },
    Goal {
        what: "build time of Default, against Embree medium",
        short: "build",
        mean: 0.7,
        worst: 1.0,
        higher_is_better: false,
        of: |scene| build(scene, "boxwood", "embree"),
    },
    Goal {
        what: "build time of Fast, against Embree low",
        short: "build fast",
        mean: 1.0,
        worst: 1.5,
        higher_is_better: false,
        of: |scene| build(scene, "boxwood-fast", "embree-low"),
    },
    Goal {
        what: "build time of High, against Embree high",
        short: "build high",
        mean: 1.0,
        worst: 1.5,
        higher_is_better: false,
        of: |scene| build(scene, "boxwood-high", "embree-high"),
    },
    Goal {
        what: "bytes per triangle, default form, against Embree's default",
        short: "bytes",
        mean: 0.75,
        worst: 0.9,
        higher_is_better: false,
        of: |scene| bytes(scene, "boxwood"),
    },
    Goal {
        what: "bytes per triangle, compact form, against Embree's default",
        short: "bytes compact",
        mean: 0.5,
        worst: 0.6,
        higher_is_better: false,
        of: |scene| bytes(scene, "boxwood-compact"),
    },
    Goal {
        what: "two threads against one, batches",
        short: "2 threads",
        mean: 1.95,
        worst: 1.9,
        higher_is_better: true,
        of: two_threads,
    },
    Goal {
        what: "two threads against one, build",
        short: "2 threads, build",
        mean: 1.8,
        worst: 1.6,
        higher_is_better: true,
        of: |scene| {
            let row = peer(scene, "boxwood")
                .filter(|_| scene.report.threads == 2)
                .map(|peer| &peer.row);
            let ratio = row.and_then(|row| Some(row.build_ms / row.build_ms_all?));
            ratio
                .map(|ratio| ("build".to_owned(), ratio))
                .into_iter()
                .collect()
        },
    },
    Goal {
        what: "SSE2-only kernels, against AVX2 kernels",
        short: "SSE2",
        mean: 0.6,
        worst: 0.45,
        higher_is_better: true,
        of: |scene| rates(scene, "boxwood-sse2", "boxwood-avx2"),
    },
];

impl Goal {
    /// Over all scenes.
    pub(crate) fn values(&self, scenes: &[Measured]) -> Vec<Value> {
        let of_scene = |scene: &Measured| {
            let name = scene.report.scene.name.clone();
            let values = (self.of)(scene).into_iter();
            values.map(move |(set, ratio)| Value {
                ratio,
                place: format!("{name}, {set}"),
            })
        };
        scenes.iter().flat_map(of_scene).collect()
    }

    /// A scene in a few words: `1.31, 1.05 shadow`.
    pub(crate) fn of_scene(&self, scene: &Measured) -> String {
        let values = (self.of)(scene);
        let mean = geometric_mean(values.iter().map(|value| value.1));
        match (
            values.len(),
            self.extreme(values.into_iter(), |value| value.1),
        ) {
            (0, _) | (_, None) => "-".to_owned(),
            (1, _) => format!("{mean:.2}"),
            (_, Some((set, worst))) => format!("{mean:.2}, {worst:.2} {set}"),
        }
    }

    /// The geometric mean.
    pub(crate) fn mean(&self, values: &[Value]) -> Option<f64> {
        (!values.is_empty()).then(|| geometric_mean(values.iter().map(|value| value.ratio)))
    }

    /// The value farthest on the wrong side.
    pub(crate) fn worst(&self, values: &[Value]) -> Option<Value> {
        self.extreme(values.iter().cloned(), |value| value.ratio)
    }

    /// Whether both numbers are on the right side.
    pub(crate) fn is_reached(&self, mean: f64, worst: f64) -> bool {
        match self.higher_is_better {
            true => mean >= self.mean && worst >= self.worst,
            false => mean <= self.mean && worst <= self.worst,
        }
    }

    fn extreme<T>(&self, values: impl Iterator<Item = T>, ratio: fn(&T) -> f64) -> Option<T> {
        let sign = if self.higher_is_better { 1.0 } else { -1.0 };
        values.min_by(|a, b| (sign * ratio(a)).total_cmp(&(sign * ratio(b))))
    }
}

fn peer<'a>(scene: &'a Measured, name: &str) -> Option<&'a Peer> {
    scene.peers.iter().find(|peer| peer.row.name == name)
}

/// The one of Default and High with the better batches.
pub(crate) fn better_build(scene: &Measured) -> Option<&Peer> {
    let mean = |peer: &Peer| {
        peer.vs_embree_best
            .as_ref()
            .map_or(0.0, |standing| standing.geomean)
    };
    let builds = ["boxwood", "boxwood-high"]
        .into_iter()
        .filter_map(|name| peer(scene, name));
    builds.max_by(|a, b| mean(a).total_cmp(&mean(b)))
}

fn by_set(standing: Option<&crate::standing::Standing>) -> Vec<(String, f64)> {
    standing.map_or(Vec::new(), |standing| {
        standing.by_set.clone().into_iter().collect()
    })
}

fn build(scene: &Measured, ours: &str, theirs: &str) -> Vec<(String, f64)> {
    let ratio = || Some(peer(scene, ours)?.row.build_ms / peer(scene, theirs)?.row.build_ms);
    ratio()
        .map(|ratio| ("build".to_owned(), ratio))
        .into_iter()
        .collect()
}

fn bytes(scene: &Measured, ours: &str) -> Vec<(String, f64)> {
    let ratio = || {
        Some(
            peer(scene, ours)?.row.bytes_per_triangle?
                / peer(scene, "embree")?.row.bytes_per_triangle?,
        )
    };
    ratio()
        .map(|ratio| ("bytes".to_owned(), ratio))
        .into_iter()
        .collect()
}

fn two_threads(scene: &Measured) -> Vec<(String, f64)> {
    let Some(peer) = peer(scene, "boxwood").filter(|_| scene.report.threads == 2) else {
        return Vec::new();
    };
    let ratio = |set: &String| {
        let rate = |threads| Some(peer.row.cell(set, Mode::Batch, threads)?.mrays);
        Some((set.clone(), rate(2)? / rate(1)?))
    };
    scene.report.scene.sets.iter().filter_map(ratio).collect()
}

/// Single rays and batches.
fn rates(scene: &Measured, ours: &str, theirs: &str) -> Vec<(String, f64)> {
    let (Some(ours), Some(theirs)) = (peer(scene, ours), peer(scene, theirs)) else {
        return Vec::new();
    };
    let ratio = |(set, mode): (&String, Mode)| {
        let [a, b] = [ours, theirs].map(|peer| Some(peer.row.cell(set, mode, 1)?.mrays));
        Some((format!("{set} {}", mode.name()), a? / b?))
    };
    let cells = scene
        .report
        .scene
        .sets
        .iter()
        .flat_map(|set| Mode::ALL.map(|mode| (set, mode)));
    cells.filter_map(ratio).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_goal_is_reached_if_mean_and_worst_are_on_the_right_side() {
        let (speed, size) = (&GOALS[0], &GOALS[5]);
        assert!(
            speed.is_reached(1.4, 1.0)
                && !speed.is_reached(1.4, 0.99)
                && !speed.is_reached(1.2, 1.1)
        );
        assert!(size.is_reached(0.7, 0.9) && !size.is_reached(0.8, 0.85));
        let values = [("a", 0.5), ("b", 2.0)].map(|(place, ratio)| Value {
            ratio,
            place: place.to_owned(),
        });
        assert_eq!(speed.worst(&values).unwrap().place, "a");
        assert_eq!(size.worst(&values).unwrap().place, "b");
        assert!((speed.mean(&values).unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(speed.mean(&[]), None);
    }
}
