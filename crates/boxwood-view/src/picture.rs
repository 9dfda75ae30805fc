//! Pictures of a scene at any resolution, and how they get finer. All of them come from `boxwood-render`.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use boxwood::{Counts, Hit, Ray, Scene};
use boxwood_render::{
    Crop, Film, Image, RenderOptions, Scale, ScaleOptions, Shading, Tracer, View, Watch, render,
};
use boxwood_scene::Camera;
use rayon::prelude::*;

use crate::{
    keys::SUN,
    subject::{Built, Subject},
};

/// What a picture shows, whatever its resolution.
#[derive(Clone, Debug)]
pub(crate) struct Shot {
    pub(crate) subject: Arc<Subject>,
    pub(crate) built: Arc<Built>,
    /// Its costs are shown in the right half.
    pub(crate) beside: Option<Arc<Built>>,
    pub(crate) camera: Camera,
    /// Of the window.
    pub(crate) size: [u32; 2],
    /// [`SUN`], or the name of a shading.
    pub(crate) look: &'static str,
    pub(crate) scale: ScaleOptions,
    /// In stops, once it is known: measuring it takes time.
    pub(crate) exposure: Option<f32>,
}

/// A picture, perhaps smaller than its window.
#[derive(Clone, Debug)]
pub(crate) struct Painted {
    pub(crate) image: Image,
    /// What its colours mean, of costs and depths; the right half's, if there are two.
    pub(crate) scales: Vec<Scale>,
    pub(crate) samples: u32,
    /// In stops.
    pub(crate) exposure: Option<f32>,
}

/// Asked now and then, from any thread: is the picture no longer wanted?
pub(crate) type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// Samples per pixel after which light counts as smooth.
const MOST_SAMPLES: u32 = 256;
/// Side of the pictures that are drawn at twice the size at most.
const MOST_DOUBLED: u32 = 4096;

impl Shot {
    /// In one ray per pixel of a picture whose sides are `share` of the window's; none if it was stopped, or the camera is
    /// impossible.
    pub(crate) fn paint(&self, share: f32, stop: Stop<'_>) -> Option<Painted> {
        let side = |side: u32| ((side as f32 * share).round() as u32).max(1);
        let view = View::new(self.camera, side(self.size[0]), side(self.size[1])).ok()?;
        match &self.beside {
            _ if self.look == SUN => self.draw(&view, stop),
            Some(beside) if view.width() > 1 => self.compare(&view, beside, stop),
            _ => self
                .film(&view, &self.built, 1, 0, None, stop)
                .map(|film| developed(film, 1)),
        }
    }

    /// Ever finer pictures after one at `share`, each handed to `deliver`, until nothing more can be gained.
    pub(crate) fn refine(&self, share: f32, stop: Stop<'_>, mut deliver: impl FnMut(Painted)) {
        let mut share = share;
        while share < 1.0 {
            // Tripled at most, so that slow scenes show something now and then.
            share = if share > 0.34 { 1.0 } else { share * 3.0 };
            let Some(painted) = self.paint(share, stop) else {
                return;
            };
            deliver(painted);
        }
        if self.look == SUN {
            self.smooth(stop).into_iter().for_each(deliver);
        } else {
            self.gather(stop, deliver);
        }
    }

    /// Sun and shadow.
    fn draw(&self, view: &View, stop: Stop<'_>) -> Option<Painted> {
        let mut image = no_image();
        let tracer = Stoppable {
            scene: &self.built.scene,
            stop,
            was_stopped: AtomicBool::new(false),
        };
        self.subject.frames.draw(&tracer, view, &mut image);
        (!tracer.was_stopped.into_inner()).then_some(Painted {
            image,
            scales: Vec::new(),
            samples: 1,
            exposure: self.exposure,
        })
    }

    /// Four samples per pixel of what is drawn frame by frame.
    fn smooth(&self, stop: Stop<'_>) -> Option<Painted> {
        let [width, height] = self.size;
        if width.max(height) > MOST_DOUBLED {
            return None;
        }
        let view = View::new(self.camera, 2 * width, 2 * height).ok()?;
        let large = self.draw(&view, stop)?;
        Some(Painted {
            image: halved(&large.image),
            samples: 4,
            ..large
        })
    }

    /// More and more samples of a shading.
    fn gather(&self, stop: Stop<'_>, mut deliver: impl FnMut(Painted)) {
        let Some(shading) = self.shading().filter(|shading| !shading.is_scale()) else {
            return;
        };
        let Ok(view) = View::new(self.camera, self.size[0], self.size[1]) else {
            return;
        };
        let most = if shading.samples > 4 {
            MOST_SAMPLES
        } else {
            16
        };
        let mut sum: Option<Film> = None;
        // Two and more samples are spread over the pixel, and the passes double.
        let (mut done, mut pass, mut seed) = (0, 2, 1);
        while done < most {
            let Some(film) = self.film(&view, &self.built, pass, seed, None, stop) else {
                return;
            };
            sum = Some(match sum {
                None => film,
                Some(sum) => mixed(sum, done, &film, pass),
            });
            done += pass;
            (pass, seed) = (done, seed + 1);
            sum.clone()
                .map(|film| developed(film, done))
                .into_iter()
                .for_each(&mut deliver);
        }
    }

    fn shading(&self) -> Option<&'static Shading> {
        Shading::named(self.look).ok()
    }

    /// Exposes a film of the whole view, or a part of it.
    fn film(
        &self,
        view: &View,
        built: &Built,
        samples: u32,
        seed: u64,
        crop: Option<Crop>,
        stop: Stop<'_>,
    ) -> Option<Film> {
        let options = RenderOptions {
            samples: Some(samples),
            seed,
            crop,
            exposure: self.exposure,
            scale: self.scale,
            counts: false,
            ..RenderOptions::new(self.shading()?)
        };
        let cancel = AtomicBool::new(false);
        let watch = Watch {
            cancel: Some(&cancel),
            report: Some(&|_| {
                if stop() {
                    cancel.store(true, Ordering::Relaxed);
                }
            }),
        };
        let surfaces = self.subject.surfaces();
        let film = render(&built.scene, surfaces, view, &options, watch).ok()?;
        film.is_complete().then_some(film)
    }

    /// The left half in the shot's own structure and the right half in another, in the colours of one scale.
    fn compare(&self, view: &View, beside: &Built, stop: Stop<'_>) -> Option<Painted> {
        let middle = view.width() / 2;
        let expose = |shot: &Self| {
            let half = |x, width| {
                let (y, height) = (0, view.height());
                Some(Crop {
                    x,
                    y,
                    width,
                    height,
                })
            };
            let left = shot.film(view, &self.built, 1, 0, half(0, middle), stop)?;
            let right = half(middle, view.width() - middle);
            Some([left, shot.film(view, beside, 1, 0, right, stop)?])
        };
        let mut films = expose(self)?;
        let highs = films.iter().filter_map(|film| Some(film.scale?.high));
        if let (None, Some(high)) = (self.scale.top, highs.reduce(f32::max)) {
            let mut same = self.clone();
            same.scale.top = Some(high);
            films = expose(&same)?;
        }
        let [left, right] = films.map(|film| developed(film, 1));
        Some(Painted {
            image: side_by_side(&left.image, &right.image),
            scales: [left.scales, right.scales].concat(),
            ..left
        })
    }
}

/// The picture of a film, without the legend, which is drawn on top in the size of the window.
fn developed(mut film: Film, samples: u32) -> Painted {
    let scales = film.scale.take().into_iter().collect();
    Painted {
        exposure: (film.exposure > 0.0).then(|| film.exposure.log2()),
        image: film.to_image(),
        scales,
        samples,
    }
}

/// The mean of two films, weighted by their samples.
fn mixed(mut a: Film, of_a: u32, b: &Film, of_b: u32) -> Film {
    let share = of_b as f32 / (of_a + of_b) as f32;
    for (a, b) in a.color.iter_mut().zip(&b.color) {
        for (a, b) in a.iter_mut().zip(b) {
            *a += (b - *a) * share;
        }
    }
    a
}

fn side_by_side(left: &Image, right: &Image) -> Image {
    let rows = |image: &Image| image.width as usize;
    let pairs = left
        .rgb
        .chunks(rows(left))
        .zip(right.rgb.chunks(rows(right)));
    Image {
        width: left.width + right.width,
        height: left.height,
        rgb: pairs.flat_map(|(a, b)| [a, b].concat()).collect(),
    }
}

/// A scene that answers nothing once it is to stop.
struct Stoppable<'a> {
    scene: &'a Scene,
    stop: Stop<'a>,
    was_stopped: AtomicBool,
}

impl Stoppable<'_> {
    fn goes_on(&self) -> bool {
        if !self.was_stopped.load(Ordering::Relaxed) && (self.stop)() {
            self.was_stopped.store(true, Ordering::Relaxed);
        }
        !self.was_stopped.load(Ordering::Relaxed)
    }
}

impl Tracer for Stoppable<'_> {
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        hits.fill(None);
        if self.goes_on() {
            Tracer::closest_hits(self.scene, rays, hits);
        }
    }

    fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
        occluded.fill(false);
        if self.goes_on() {
            Tracer::occluded_each(self.scene, rays, occluded);
        }
    }
}

/// A picture without pixels.
pub(crate) fn no_image() -> Image {
    Image {
        width: 0,
        height: 0,
        rgb: Vec::new(),
    }
}

/// The mean of each four pixels.
fn halved(large: &Image) -> Image {
    let (width, height) = (large.width as usize / 2, large.height as usize / 2);
    let mut rgb = vec![[0; 3]; width * height];
    let rows = rgb.par_chunks_mut(width.max(1)).enumerate();
    rows.for_each(|(y, row)| {
        let [above, below] = [2 * y, 2 * y + 1].map(|y| &large.rgb[y * 2 * width..][..2 * width]);
        let pairs = above.chunks_exact(2).zip(below.chunks_exact(2));
        for (pixel, (a, b)) in row.iter_mut().zip(pairs) {
            let sum = |k: usize| {
                [a[0], a[1], b[0], b[1]]
                    .map(|p| u16::from(p[k]))
                    .iter()
                    .sum::<u16>()
            };
            *pixel = [0, 1, 2].map(|k| ((sum(k) + 2) / 4) as u8);
        }
    });
    Image {
        width: width as u32,
        height: height as u32,
        rgb,
    }
}

/// Stretches `small` over all of `large`, whose size is given and stays.
pub(crate) fn stretch(small: &Image, large: &mut Image) {
    if [small.width, small.height] == [large.width, large.height] {
        large.rgb.copy_from_slice(&small.rgb);
        return;
    }
    if small.rgb.is_empty() || large.rgb.is_empty() {
        return;
    }
    let columns = taps(small.width, large.width);
    let rows = taps(small.height, large.height);
    let (width, small_width) = (large.width as usize, small.width as usize);
    large
        .rgb
        .par_chunks_mut(width)
        .zip(rows)
        .for_each(|(out, row)| {
            let [above, below] =
                [row.low, row.high].map(|y| &small.rgb[y * small_width..][..small_width]);
            for (pixel, column) in out.iter_mut().zip(&columns) {
                *pixel = [0, 1, 2].map(|k| {
                    let mix = |a: u8, b: u8, share: u32| {
                        u32::from(a) * (64 - share) + u32::from(b) * share
                    };
                    let a = mix(above[column.low][k], above[column.high][k], column.share);
                    let b = mix(below[column.low][k], below[column.high][k], column.share);
                    ((a * (64 - row.share) + b * row.share + 2048) >> 12) as u8
                });
            }
        });
}

/// Between which two pixels of a row or column one lies.
#[derive(Clone, Copy)]
struct Tap {
    low: usize,
    high: usize,
    /// How far from `low` to `high`, of 64.
    share: u32,
}

fn taps(small: u32, large: u32) -> Vec<Tap> {
    let tap = |i: u32| {
        let place = (i as f32 + 0.5) * small as f32 / large as f32 - 0.5;
        let place = place.clamp(0.0, (small - 1) as f32);
        let low = place as usize;
        Tap {
            low,
            high: (low + 1).min(small as usize - 1),
            share: (place.fract() * 64.0) as u32,
        }
    };
    (0..large).map(tap).collect()
}

/// The work of a camera ray on average, over an even grid of pixels; how many rays it is from.
pub(crate) fn tests_per_ray(shot: &Shot, stop: Stop<'_>) -> Option<(Counts, u32)> {
    const GRID: [u32; 2] = [64, 36];
    const PATIENCE: Duration = Duration::from_millis(300);
    let view = View::new(shot.camera, GRID[0], GRID[1]).ok()?;
    let (start, mut counts, mut rays) = (Instant::now(), Counts::default(), 0);
    // Spread over the picture also when it takes too long: the step has no divisor in common with the number.
    for i in (0..GRID[0] * GRID[1]).map(|i| i * 1009 % (GRID[0] * GRID[1])) {
        if stop() {
            return None;
        }
        if start.elapsed() > PATIENCE {
            break;
        }
        let ray = view.pixel_ray(i % GRID[0], i / GRID[0]);
        shot.built.scene.closest_hit_counted(&ray, &mut counts);
        rays += 1;
    }
    Some((counts, rays))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32, level: impl Fn(u32, u32) -> u8) -> Image {
        let pixels = (0..width * height).map(|i| [level(i % width, i / width); 3]);
        Image {
            width,
            height,
            rgb: pixels.collect(),
        }
    }

    #[test]
    fn stretching_keeps_flat_pictures_and_runs_smoothly_between_pixels() {
        let mut large = grey(50, 30, |_, _| 0);
        stretch(&grey(7, 4, |_, _| 93), &mut large);
        assert!(large.rgb.iter().all(|pixel| *pixel == [93; 3]));
        stretch(&grey(2, 1, |x, _| x as u8 * 200), &mut large);
        let row: Vec<u8> = large.rgb[..50].iter().map(|p| p[0]).collect();
        assert!(row.is_sorted() && row[0] == 0 && row[49] == 200);
        assert!(row.windows(2).all(|pair| pair[1] - pair[0] < 12), "{row:?}");
        stretch(&grey(50, 30, |x, y| (x + y) as u8), &mut large);
        assert_eq!(large, grey(50, 30, |x, y| (x + y) as u8));
    }

    #[test]
    fn halving_takes_the_mean_of_four() {
        let large = grey(4, 2, |x, y| (10 * x + 4 * y) as u8);
        assert_eq!(halved(&large).rgb, [[7; 3], [27; 3]]);
    }

    #[test]
    fn two_halves_stand_side_by_side() {
        let both = side_by_side(&grey(3, 2, |_, _| 1), &grey(2, 2, |_, _| 2));
        let row = [[1; 3], [1; 3], [1; 3], [2; 3], [2; 3]];
        assert_eq!((both.width, both.height), (5, 2));
        assert_eq!(both.rgb, [row, row].concat());
    }
}
