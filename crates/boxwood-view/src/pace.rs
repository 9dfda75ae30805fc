//! How fine the picture is while the camera moves.

use std::time::Duration;

/// A frame is to take no longer: 30 a second, and air for one that costs a fifth more than that before.
const FRAME: Duration = Duration::from_millis(26);
/// What remains for the rays where everything else takes too long already.
const LEAST: Duration = Duration::from_millis(4);
/// The coarsest picture: one ray for 64 x 64 pixels.
const COARSEST: f32 = 1.0 / 64.0;
/// The share of the time that the next frame is to use.
const AIM: f32 = 0.8;
/// Finer by so much a frame at most: one quick frame may be luck.
const FINER: f32 = 1.3;

/// Chooses the resolution of the next frame from the times of those before.
///
/// Rays cost most of a frame, and their number goes with the square of the side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pace {
    /// Of the window's sides, 1 is full resolution.
    share: f32,
    /// What a frame takes besides its rays: text, lines.
    rest: Duration,
    /// Its way to the screen.
    presenting: Duration,
}

impl Default for Pace {
    /// A quarter, whatever it will cost.
    fn default() -> Self {
        Self {
            share: 0.25,
            rest: Duration::from_millis(3),
            presenting: Duration::ZERO,
        }
    }
}

impl Pace {
    /// Of the sides of the window, for the next frame.
    pub(crate) fn share(self) -> f32 {
        self.share
    }

    /// How long the rays of the next frame may take.
    pub(crate) fn budget(self) -> Duration {
        FRAME.saturating_sub(self.rest + self.presenting).max(LEAST)
    }

    /// The rays of a frame took `time`, at the resolution that was asked for.
    pub(crate) fn rays_took(&mut self, time: Duration) {
        let used = (time.as_secs_f32() / self.budget().as_secs_f32()).max(1e-3);
        // Between the two nothing changes, so that the picture keeps its grain.
        if used > 1.0 || used < AIM * AIM && self.share < 1.0 {
            let factor = (AIM / used).sqrt().min(FINER);
            self.share = (self.share * factor).clamp(COARSEST, 1.0);
        }
    }

    /// The rays took far too long, and were given up. False if it cannot be coarser.
    pub(crate) fn gave_up(&mut self) -> bool {
        let was_coarsest = self.share <= COARSEST;
        self.share = (self.share * 0.4).max(COARSEST);
        !was_coarsest
    }

    /// All else of a frame took `time`, but for its way to the screen.
    pub(crate) fn rest_took(&mut self, time: Duration) {
        self.rest = smoothed(self.rest, time);
    }

    /// To bring a frame to the screen took `time`.
    pub(crate) fn presenting_took(&mut self, time: Duration) {
        self.presenting = smoothed(self.presenting, time);
    }
}

/// Screens are irregular.
fn smoothed(before: Duration, now: Duration) -> Duration {
    (before * 3 + now.min(FRAME)) / 4
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: f32 = 1e-3;

    /// Forty frames of a machine that takes `full` seconds for a full one; shares and times of the last ten.
    fn settled(full: f32) -> Vec<(f32, f32)> {
        let mut pace = Pace::default();
        let mut frames = Vec::new();
        for _ in 0..40 {
            let time = full * pace.share() * pace.share();
            frames.push((pace.share(), time));
            pace.rays_took(Duration::from_secs_f32(time));
        }
        frames.split_off(30)
    }

    #[test]
    fn quick_scenes_are_drawn_in_full() {
        assert!(settled(12.0 * MS).iter().all(|&(share, _)| share == 1.0));
    }

    #[test]
    fn slow_scenes_give_way_but_no_more_than_they_must() {
        for full in [50.0, 200.0, 3000.0] {
            for (share, time) in settled(full * MS) {
                assert!(
                    time < 26.0 * MS && time > 13.0 * MS,
                    "{full}: {share}, {time}"
                );
            }
        }
    }

    #[test]
    fn the_resolution_settles_instead_of_swinging() {
        let frames = settled(80.0 * MS);
        assert!(
            frames.iter().all(|&(share, _)| share == frames[0].0),
            "{frames:?}"
        );
    }

    #[test]
    fn a_slow_screen_leaves_less_time_for_rays() {
        let mut pace = Pace::default();
        let before = pace.budget();
        for _ in 0..20 {
            pace.presenting_took(Duration::from_millis(15));
        }
        assert!(pace.budget() < before);
        for _ in 0..20 {
            pace.rest_took(Duration::from_secs(3));
        }
        assert_eq!(pace.budget(), LEAST);
    }

    #[test]
    fn hopeless_frames_end_at_the_coarsest() {
        let mut pace = Pace::default();
        for _ in 0..20 {
            pace.gave_up();
        }
        assert_eq!(pace.share(), COARSEST);
        assert!(!pace.gave_up());
    }
}
