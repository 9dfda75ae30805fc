//! Boxwood itself as a contender.

use crate::{
    contender::{Contender, Mode, in_pieces},
    floor::Work,
    rays::Question,
};
use boxwood::{Counts, Hit, Ray, Scene};

/// A scene that is asked ray by ray, or by slices.
#[derive(Debug)]
pub struct Asked {
    name: String,
    scene: Scene,
    /// Primitives of a leaf, on average.
    leaf_size: f64,
}

impl Asked {
    /// Looks at every node once.
    pub fn new(name: impl Into<String>, scene: Scene) -> Self {
        let stats = scene.stats();
        let leaf_size = if stats.leaves == 0 {
            1.0
        } else {
            stats.references as f64 / stats.leaves as f64
        };
        Self {
            name: name.into(),
            scene,
            leaf_size,
        }
    }

    /// What is asked.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }
}

impl Contender for Asked {
    fn name(&self) -> &str {
        &self.name
    }

    fn has(&self, _: Mode) -> bool {
        true
    }

    fn closest_hits(&self, mode: Mode, rays: &[Ray], hits: &mut [Option<Hit>]) {
        match mode {
            Mode::Single => {
                let query = self.scene.query();
                rays.iter()
                    .zip(hits)
                    .for_each(|(ray, hit)| *hit = query.closest_hit(ray));
            }
            Mode::Batch => self.scene.query().closest_hits(rays, hits),
        }
    }

    fn occluded(&self, mode: Mode, rays: &[Ray], occluded: &mut [bool]) {
        match mode {
            Mode::Single => {
                let query = self.scene.query();
                rays.iter()
                    .zip(occluded)
                    .for_each(|(ray, is)| *is = query.occluded(ray));
            }
            Mode::Batch => self.scene.query().occluded_each(rays, occluded),
        }
    }

    fn closest_hits_on_all(&self, mode: Mode, rays: &[Ray], hits: &mut [Option<Hit>]) {
        match mode {
            Mode::Single => in_pieces(rays, hits, |rays, hits| self.closest_hits(mode, rays, hits)),
            Mode::Batch => self.scene.closest_hits(rays, hits),
        }
    }

    fn occluded_on_all(&self, mode: Mode, rays: &[Ray], occluded: &mut [bool]) {
        match mode {
            Mode::Single => in_pieces(rays, occluded, |rays, is| self.occluded(mode, rays, is)),
            Mode::Batch => self.scene.occluded_each(rays, occluded),
        }
    }

    fn work(&self, question: Question, rays: &[Ray]) -> Option<Work> {
        let mut counts = Counts::default();
        for ray in rays {
            match question {
                Question::Closest => {
                    self.scene.closest_hit_counted(ray, &mut counts);
                }
                Question::Occluded => {
                    self.scene.occluded_counted(ray, &mut counts);
                }
            }
        }
        Some(Work::of(&counts, self.leaf_size))
    }
}
