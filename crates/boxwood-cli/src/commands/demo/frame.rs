//! One frame's rays through one structure after the other: time, work, and whether the answers are the same.

use std::{
    cell::Cell,
    hash::{DefaultHasher, Hash, Hasher},
    hint::black_box,
    time::{Duration, Instant},
};

use boxwood::{Counts, Hit, Ray, Scene};
use boxwood_render::View;
use rayon::prelude::*;
use serde::Serialize;

use crate::{
    contest::camera_rays,
    output::{grouped, mebibytes, short},
};

/// The rays of a frame, and the right answer to a sample of them.
pub(super) struct Frame {
    rays: Vec<Ray>,
    sample: Vec<usize>,
    truth: Vec<Option<Hit>>,
    /// How long brute force took for the sample, on all threads, one ray per call.
    time: Duration,
    /// The hash of the first whole frame, with which the next ones are compared.
    hash: Cell<Option<u64>>,
}

/// How long brute force may take.
const BRUTE_FORCE: Duration = Duration::from_millis(800);

/// Rays from which it is guessed how many that allows.
const FEW: usize = 256;

/// Pixel number `i` of a sample that is spread evenly over all pixels: a prime stride meets each once.
fn sprinkled(i: usize, pixels: usize) -> usize {
    (i as u64 * 569_573 % pixels as u64) as usize
}

impl Frame {
    /// All pixels of `view`, and what brute force says to as many of them as it can do in a moment.
    pub(super) fn of(view: &View, oracle: &Scene) -> Self {
        let rays = camera_rays(view, usize::MAX);
        let sample = |n: usize| -> Vec<usize> {
            (0..n.min(rays.len()))
                .map(|i| sprinkled(i, rays.len()))
                .collect()
        };
        let trace = |sample: &[usize]| -> (Vec<Option<Hit>>, Duration) {
            let start = Instant::now();
            let hits = sample.par_iter().map(|&i| oracle.closest_hit(&rays[i]));
            (hits.collect(), start.elapsed())
        };
        let (_, time) = trace(&sample(FEW));
        let fitting = FEW as f64 * BRUTE_FORCE.as_secs_f64() / time.as_secs_f64().max(1e-6);
        let sample = sample((fitting as usize).clamp(FEW, 20_000));
        let (truth, time) = trace(&sample);
        Self {
            rays,
            sample,
            truth,
            time,
            hash: Cell::new(None),
        }
    }

    /// What the words of the table mean.
    pub(super) fn footnote(&self) -> String {
        let sample = grouped(self.sample.len() as u64);
        format!(
            "est.: from {sample} rays. A grid's boxes are its cells. Answers are compared bit for bit.\n\
             Mrays/s: on all threads, in batches."
        )
    }

    /// All rays: their hits, and how long that took.
    fn trace(&self, scene: &Scene) -> (Vec<Option<Hit>>, Duration) {
        let mut hits = vec![None; self.rays.len()];
        // The first rays find cold caches and a slow clock.
        let warm = self.rays.len() / 20;
        scene.closest_hits(&self.rays[..warm], &mut hits[..warm]);
        let start = Instant::now();
        scene.closest_hits(&self.rays, &mut hits);
        (hits, start.elapsed())
    }

    /// Rays per second, in 10^6, with a call for each, on all threads: of every fourth block of the picture.
    fn trace_singly(&self, scene: &Scene) -> f64 {
        let start = Instant::now();
        let blocks = self.rays.par_chunks(64).step_by(4);
        let rays: usize = blocks
            .map(|rays| {
                for ray in rays {
                    black_box(scene.closest_hit(ray));
                }
                rays.len()
            })
            .sum();
        rays as f64 * 1e-6 / start.elapsed().as_secs_f64().max(1e-9)
    }

    /// The work for a quarter of the rays: enough for means of three digits.
    fn count(&self, scene: &Scene) -> Counts {
        let rays: Vec<Ray> = (0..self.rays.len().div_ceil(4))
            .map(|i| self.rays[sprinkled(i, self.rays.len())])
            .collect();
        scene.closest_hits_counted(&rays, &mut vec![None; rays.len()])
    }

    /// Whether the hits are those of brute force in the sample, and those of the structures before in the whole frame.
    fn agrees(&self, hits: &[Option<Hit>]) -> bool {
        let bits =
            |hit: &Option<Hit>| hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.prim));
        let mut hasher = DefaultHasher::new();
        hits.iter().for_each(|hit| bits(hit).hash(&mut hasher));
        let hash = hasher.finish();
        let same_frame = self
            .hash
            .replace(Some(hash))
            .is_none_or(|before| before == hash);
        same_frame
            && self
                .sample
                .iter()
                .zip(&self.truth)
                .all(|(&i, truth)| bits(&hits[i]) == bits(truth))
    }
}

impl Way {
    /// Traces the frame. `list` is the row of brute force; without it, this is that row.
    pub(super) fn measured(
        name: &'static str,
        frame: &Frame,
        scene: &Scene,
        build_time: Duration,
        list: Option<&Self>,
    ) -> Self {
        let (counts, rays, time, same_answer) = match list {
            // Brute force has been measured with the sample; its work is known without counting.
            None => {
                let ray = frame
                    .sample
                    .first()
                    .map_or(frame.rays[0], |&i| frame.rays[i]);
                let mut counts = Counts::default();
                scene.closest_hit_counted(&ray, &mut counts);
                (counts, frame.sample.len(), frame.time, true)
            }
            Some(_) => {
                let (hits, time) = frame.trace(scene);
                (
                    frame.count(scene),
                    frame.rays.len(),
                    time,
                    frame.agrees(&hits),
                )
            }
        };
        let per_ray = |count: u64| count as f64 / counts.rays.max(1) as f64;
        let seconds_per_ray = time.as_secs_f64() / rays.max(1) as f64;
        let ms_per_frame = seconds_per_ray * frame.rays.len() as f64 * 1e3;
        let mrays_per_second = 1e-6 / seconds_per_ray;
        Self {
            name,
            build_ms: build_time.as_secs_f64() * 1e3,
            bytes: scene.stats().bytes,
            rays,
            estimated: rays < frame.rays.len(),
            box_tests_per_ray: per_ray(counts.boxes.max(counts.nodes)),
            primitive_tests_per_ray: per_ray(counts.prims),
            flops_per_frame: per_ray(counts.flops) * frame.rays.len() as f64,
            mrays_per_second,
            // Brute force has been measured so.
            single_mrays_per_second: list.map_or(mrays_per_second, |_| frame.trace_singly(scene)),
            ms_per_frame,
            times_faster_than_list: list.map_or(1.0, |list| list.ms_per_frame / ms_per_frame),
            same_answer,
        }
    }

    fn line(cells: [&str; 9]) -> String {
        let [name, numbers @ ..] = cells;
        let widths = [7, 6, 8, 10, 9, 11, 7, 7];
        let numbers = numbers
            .iter()
            .zip(widths)
            .map(|(cell, width)| format!("{cell:>width$}"));
        format!("{name:<15}{}", numbers.collect::<String>())
    }

    /// The titles of the rows.
    pub(super) fn titles() -> String {
        let over = Self::line([
            "",
            "build",
            "",
            "boxes",
            "triangles",
            "",
            "",
            "times",
            "same",
        ]);
        let titles = [
            "structure",
            "ms",
            "MiB",
            "per ray",
            "per ray",
            "Mrays/s",
            "ms/frame",
            "faster",
            "answer",
        ];
        format!(
            "{}\n{}\n{}",
            over.trim_end(),
            Self::line(titles),
            "-".repeat(80)
        )
    }

    /// As a line of the table.
    pub(super) fn row(&self) -> String {
        Self::line([
            self.name,
            &short(self.build_ms),
            &mebibytes(self.bytes),
            &short(self.box_tests_per_ray),
            &short(self.primitive_tests_per_ray),
            &short(self.mrays_per_second),
            &short(self.ms_per_frame),
            &short(self.times_faster_than_list),
            match (self.estimated, self.same_answer) {
                (true, _) => "est.",
                (false, true) => "yes",
                (false, false) => "NO",
            },
        ])
    }
}

/// One row of the table.
#[derive(Serialize)]
pub(super) struct Way {
    /// For people.
    pub(super) name: &'static str,
    build_ms: f64,
    bytes: usize,
    /// Rays that were traced; all numbers per frame are scaled up from them.
    rays: usize,
    /// Whether that is not the whole frame.
    estimated: bool,
    /// Cells, for the grid.
    box_tests_per_ray: f64,
    primitive_tests_per_ray: f64,
    /// Executed, by the library's own count.
    pub(super) flops_per_frame: f64,
    /// On all threads, in batches; of brute force, one ray per call.
    pub(super) mrays_per_second: f64,
    /// On all threads, one ray per call.
    pub(super) single_mrays_per_second: f64,
    /// On all threads.
    pub(super) ms_per_frame: f64,
    times_faster_than_list: f64,
    /// Bit for bit: as brute force in the sample, and as the other structures in the whole frame.
    pub(super) same_answer: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_stands_under_its_titles() {
        let titles = Way::titles();
        let widths: Vec<usize> = titles.lines().map(|line| line.chars().count()).collect();
        assert_eq!(widths[1], widths[2], "{titles}");
    }

    #[test]
    fn a_sprinkled_sample_meets_each_pixel_once() {
        for pixels in [1, 48 * 27, 1280 * 720] {
            let mut met: Vec<usize> = (0..pixels).map(|i| sprinkled(i, pixels)).collect();
            met.sort_unstable();
            assert!(
                met.iter().enumerate().all(|(i, &pixel)| i == pixel),
                "{pixels}"
            );
        }
    }
}
