//! `boxwood demo`, and what `boxwood` does by itself: one scene traced four ways, with the bill.

use std::{
    hash::{DefaultHasher, Hash, Hasher},
    sync::atomic::Ordering,
    time::{Duration, Instant},
};

use boxwood::{BuildOptions, Builder, Counts, Hit, Ray, STRUCTURES, Scene, lecture::price::Price};
use boxwood_render::{Film, Image, RenderOptions, ScaleOptions, Shading, View, Watch, render, write_png};
use rayon::prelude::*;
use serde::Serialize;

use super::doctor;
use crate::{
    args::{self, Loaded, SceneArgs},
    output::{Exit, Output, grouped, mebibytes, short},
    progress::interrupted,
    save,
    terminal::{self, Show},
};

/// Trace 40,000 triangles four ways, with the bill; `boxwood` alone does this.
///
/// Writes boxwood.png and boxwood-heat.png into the current folder, and shows them if the terminal can show pictures.
#[derive(Debug, Default, clap::Args)]
#[command(after_help = "Examples:\n  boxwood\n  boxwood demo --size 640x360\n  boxwood demo --json")]
pub(crate) struct Args {
    /// Size of the frame in pixels. [default: 1280x720, as in the lecture]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let [width, height] = args::size(text)?;
    let fits = u64::from(width) * u64::from(height) <= MAX_RAYS;
    if fits { Ok([width, height]) } else { Err(format!("at most {MAX_RAYS} pixels")) }
}

/// All rays of the frame and their hits are held in memory: 1 GB.
const MAX_RAYS: u64 = 1 << 24;
const SCENE: &str = "builtin:bush";
const PICTURE: &str = "boxwood.png";
const HEAT: &str = "boxwood-heat.png";

/// How the frame is traced: name, structure, builder. The first is the oracle, the last the fastest.
const WAYS: [(&str, &str, Builder); 4] = [
    ("list", "list", Builder::BINNED),
    ("grid", "grid", Builder::BINNED),
    ("bounded median", "bounded", Builder::MEDIAN),
    ("bvh2 binned SAH", "bvh2", Builder::BINNED),
];

/// Everything shown, in the words of the JSON object.
#[derive(Serialize)]
struct Report {
    file: &'static str,
    triangles: usize,
    width: u32,
    height: u32,
    threads: usize,
    simd: Vec<&'static str>,
    ways: Vec<Way>,
    brute_force_flops: u64,
    pictures: [&'static str; 2],
}

/// One row of the table.
#[derive(Serialize)]
struct Way {
    name: &'static str,
    build_ms: f64,
    bytes: usize,
    /// Rays that were traced; all numbers per frame are scaled up from them.
    rays: usize,
    /// Whether that is not the whole frame.
    estimated: bool,
    /// Cells, for the grid.
    box_tests_per_ray: f64,
    primitive_tests_per_ray: f64,
    flops_per_frame: f64,
    mrays_per_second: f64,
    ms_per_frame: f64,
    times_faster_than_list: f64,
    same_answer: bool,
}

/// Traces, prints as it goes, writes the pictures.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let say = |text: String| if out.is_json() { Ok(()) } else { out.text(text) };
    let start = Instant::now();
    let [width, height] = args.size.unwrap_or([1280, 720]);
    interrupted();
    say(banner())?;
    save::check(Some(PICTURE), out, &["png"])?;
    let loaded = SceneArgs { file: SCENE.to_owned() }.load(out)?;
    let (oracle, _) = args::build(&loaded.mesh, "list", BuildOptions::default())?;
    let view = view(&oracle, &loaded, [width, height])?;
    let frame = Frame::of(&view, oracle);
    let price = Price {
        width: width.into(),
        height: height.into(),
        ..Price::of_720p(loaded.mesh.indices.len() as u64)
    };
    say(format!("{}\n\n{}", frame.text(&price), Way::titles()))?;

    let mut ways: Vec<Way> = Vec::new();
    let mut scenes = Vec::new();
    for (name, structure, builder) in WAYS {
        let (scene, build_time) = args::build(&loaded.mesh, structure, BuildOptions::with(builder))?;
        let way = Way::measured(name, &frame, &scene, build_time, ways.first());
        if interrupted().load(Ordering::Relaxed) {
            out.warn("interrupted; no picture is written");
            return Ok(Exit::Interrupted);
        }
        say(way.row())?;
        ways.push(way);
        scenes.push(scene);
    }
    let Some(fastest) = ways.last() else { return Ok(Exit::Ok) };
    say(format!("{}\n\n{}\n", frame.footnote(), bill(&price, fastest)))?;

    let half = [width * 5 / 8, height * 5 / 8].map(|side| side.max(1));
    let images = [picture(&scenes[3], &loaded, &view)?, heat(&scenes[1], &scenes[3], &loaded, half)?];
    if interrupted().load(Ordering::Relaxed) {
        out.warn("interrupted; no picture is written");
        return Ok(Exit::Interrupted);
    }
    // The table, some 25 lines with all around it, is to stay in sight.
    let lines_for_pictures = (terminal::lines().saturating_sub(25) / 2).clamp(10, 30);
    for (image, name) in images.iter().zip([PICTURE, HEAT]) {
        save::save(name, |file| write_png(image, &[("Software", "boxwood")], file))?;
        if let (Some(way), false) = (Show::of_stdout(), out.is_json()) {
            out.text(way.draw(image, terminal::columns_for(image, lines_for_pictures))?)?;
        }
    }
    let same = ways.iter().all(|way| way.same_answer);
    if out.is_json() {
        out.json(&Report {
            file: SCENE,
            triangles: loaded.mesh.indices.len(),
            width,
            height,
            threads: rayon::current_num_threads(),
            simd: doctor::simd(),
            ways,
            brute_force_flops: price.flops(),
            pictures: [PICTURE, HEAT],
        })?;
    }
    say(ending(start.elapsed()))?;
    Ok(Exit::from_difference(!same))
}

fn banner() -> String {
    let names: Vec<&str> = STRUCTURES.iter().map(|structure| structure.name).collect();
    let (threads, simd) = (rayon::current_num_threads(), doctor::simd());
    format!(
        "Boxwood {}: what does this ray hit?\n{threads} thread{}, {} (this version's kernels are scalar), structures {}",
        env!("CARGO_PKG_VERSION"),
        if threads == 1 { "" } else { "s" },
        simd.last().unwrap_or(&"no SIMD"),
        names.join(" "),
    )
}

fn ending(time: Duration) -> String {
    format!(
        "wrote {PICTURE} and {HEAT} (left grid, right bvh2); {:.1} s in all\n\
         next: boxwood render builtin:cornell --shading path --show    light, bounced about\n      \
         boxwood race YOUR.obj                                   every structure on your scene\n      \
         boxwood explain builtin:bush --pixel 640,360            one ray, step by step",
        time.as_secs_f64(),
    )
}

/// The lecture's arithmetic, and what was really done.
fn bill(price: &Price, fastest: &Way) -> String {
    format!(
        "{} x {} x {} x {} = {} flop per frame by brute force;\n\
         {} needed {} million ({} times fewer) and {} ms.",
        price.width,
        price.height,
        grouped(price.triangles),
        price.flops_per_test,
        grouped(price.flops()),
        fastest.name,
        short(fastest.flops_per_frame / 1e6),
        short(price.flops() as f64 / fastest.flops_per_frame.max(1.0)),
        short(fastest.ms_per_frame),
    )
}

fn view(scene: &Scene, loaded: &Loaded, [width, height]: [u32; 2]) -> anyhow::Result<View> {
    let auto = || boxwood_render::auto_camera(scene, loaded.surfaces(), width, height);
    let camera = loaded.model.cameras.first().copied().unwrap_or_else(auto);
    Ok(View::new(camera, width, height)?)
}

/// The rays of a frame, and the right answer to a sample of them.
struct Frame {
    rays: Vec<Ray>,
    sample: Vec<usize>,
    truth: Vec<Option<Hit>>,
    /// How long brute force took for the sample.
    time: Duration,
    /// The hash of the first whole frame, with which the next ones are compared.
    hash: std::cell::Cell<Option<u64>>,
}

/// How long brute force may take.
const BRUTE_FORCE: Duration = Duration::from_millis(800);

/// Pixel number `i` of a sample that is spread evenly over all pixels: a prime stride meets each once.
fn sprinkled(i: usize, pixels: usize) -> usize {
    (i as u64 * 569_573 % pixels as u64) as usize
}

impl Frame {
    fn of(view: &View, oracle: Scene) -> Self {
        let (width, height) = (view.width(), view.height());
        let rays: Vec<Ray> = (0..width * height).map(|i| view.pixel_ray(i % width, i / width)).collect();
        let pixel = |i: usize| sprinkled(i, rays.len());
        let trace = |sample: &[usize]| -> (Vec<Option<Hit>>, Duration) {
            let start = Instant::now();
            (sample.par_iter().map(|&i| oracle.closest_hit(&rays[i])).collect(), start.elapsed())
        };
        let probe: Vec<usize> = (0..256).map(pixel).collect();
        let (_, time) = trace(&probe);
        let fitting = 256.0 * BRUTE_FORCE.as_secs_f64() / time.as_secs_f64().max(1e-6);
        let sample: Vec<usize> = (0..(fitting as usize).clamp(256, 20_000).min(rays.len())).map(pixel).collect();
        let (truth, time) = trace(&sample);
        Self { rays, sample, truth, time, hash: std::cell::Cell::new(None) }
    }

    fn text(&self, price: &Price) -> String {
        let (triangles, rays) = (grouped(price.triangles), grouped(price.pixels()));
        format!("{SCENE}: {triangles} triangles; {} x {} = {rays} rays", price.width, price.height)
    }

    fn footnote(&self) -> String {
        let sample = grouped(self.sample.len() as u64);
        format!("est.: from {sample} rays. A grid's boxes are its cells. Answers are compared bit for bit.")
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

    /// The work for a quarter of the rays: enough for means of three digits.
    fn count(&self, scene: &Scene) -> Counts {
        let rays: Vec<Ray> = (0..self.rays.len().div_ceil(4)).map(|i| self.rays[sprinkled(i, self.rays.len())]).collect();
        scene.closest_hits_counted(&rays, &mut vec![None; rays.len()])
    }

    /// Whether the hits are those of brute force in the sample, and those of the structures before in the whole frame.
    fn agrees(&self, hits: &[Option<Hit>]) -> bool {
        let bits = |hit: &Option<Hit>| hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.prim));
        let mut hasher = DefaultHasher::new();
        hits.iter().for_each(|hit| bits(hit).hash(&mut hasher));
        let hash = hasher.finish();
        let same_frame = self.hash.replace(Some(hash)).is_none_or(|before| before == hash);
        same_frame && self.sample.iter().zip(&self.truth).all(|(&i, truth)| bits(&hits[i]) == bits(truth))
    }
}

impl Way {
    fn measured(name: &'static str, frame: &Frame, scene: &Scene, build_time: Duration, list: Option<&Self>) -> Self {
        let (counts, rays, time, same_answer) = match list {
            // Brute force has been measured with the sample; its work is known without counting.
            None => {
                let ray = frame.sample.first().map_or(frame.rays[0], |&i| frame.rays[i]);
                let mut counts = Counts::default();
                scene.closest_hit_counted(&ray, &mut counts);
                (counts, frame.sample.len(), frame.time, true)
            }
            Some(_) => {
                let (hits, time) = frame.trace(scene);
                (frame.count(scene), frame.rays.len(), time, frame.agrees(&hits))
            }
        };
        let per_ray = |count: u64| count as f64 / counts.rays.max(1) as f64;
        let seconds_per_ray = time.as_secs_f64() / rays.max(1) as f64;
        let ms_per_frame = seconds_per_ray * frame.rays.len() as f64 * 1e3;
        Self {
            name,
            build_ms: build_time.as_secs_f64() * 1e3,
            bytes: scene.stats().bytes,
            rays,
            estimated: rays < frame.rays.len(),
            box_tests_per_ray: per_ray(if counts.boxes > 0 { counts.boxes } else { counts.nodes }),
            primitive_tests_per_ray: per_ray(counts.prims),
            flops_per_frame: per_ray(counts.flops) * frame.rays.len() as f64,
            mrays_per_second: 1e-6 / seconds_per_ray,
            ms_per_frame,
            times_faster_than_list: list.map_or(1.0, |list| list.ms_per_frame / ms_per_frame),
            same_answer,
        }
    }

    fn line(cells: [&str; 9]) -> String {
        let [name, numbers @ ..] = cells;
        let widths = [7, 6, 8, 10, 9, 11, 7, 7];
        let numbers = numbers.iter().zip(widths).map(|(cell, width)| format!("{cell:>width$}"));
        format!("{name:<15}{}", numbers.collect::<String>())
    }

    fn titles() -> String {
        let over = Self::line(["", "build", "", "boxes", "triangles", "", "", "times", "same"]);
        let titles = ["structure", "ms", "MiB", "per ray", "per ray", "Mrays/s", "ms/frame", "faster", "answer"];
        format!("{}\n{}\n{}", over.trim_end(), Self::line(titles), "-".repeat(80))
    }

    fn row(&self) -> String {
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

/// The scene by sunlight.
fn picture(scene: &Scene, loaded: &Loaded, view: &View) -> anyhow::Result<Image> {
    let options = RenderOptions { samples: Some(4), ..RenderOptions::new(Shading::named("whitted")?) };
    let film = render(scene, loaded.surfaces(), view, &options, Watch { cancel: Some(interrupted()), report: None })?;
    Ok(film.to_image())
}

/// Triangle tests per pixel in two structures, side by side on one scale.
fn heat(left: &Scene, right: &Scene, loaded: &Loaded, size: [u32; 2]) -> anyhow::Result<Image> {
    let view = view(left, loaded, size)?;
    let shading = Shading::named("heat-prims")?;
    let film = |scene: &Scene, top: Option<f32>| {
        let options = RenderOptions { scale: ScaleOptions { top, log: true }, ..RenderOptions::new(shading) };
        let watch = Watch { cancel: Some(interrupted()), report: None };
        render(scene, loaded.surfaces(), &view, &options, watch)
    };
    let high = |film: &Film| film.scale.map_or(0.0, |scale| scale.high);
    let top = high(&film(left, None)?).max(high(&film(right, None)?));
    let image = |scene: &Scene, title| -> anyhow::Result<Image> {
        let mut film = film(scene, Some(top))?;
        if let Some(scale) = &mut film.scale {
            scale.title = title;
        }
        Ok(film.to_image())
    };
    Ok(side_by_side(&image(left, "grid: triangle tests")?, &image(right, "bvh2: triangle tests")?))
}

/// Of equal height.
fn side_by_side(left: &Image, right: &Image) -> Image {
    let rows = left.rgb.chunks(left.width as usize).zip(right.rgb.chunks(right.width as usize));
    let rgb = rows.flat_map(|(left, right)| left.iter().chain(right)).copied().collect();
    Image { width: left.width + right.width, height: left.height, rgb }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_side_by_side() {
        let left = Image { width: 2, height: 2, rgb: vec![[1; 3]; 4] };
        let right = Image { width: 1, height: 2, rgb: vec![[7; 3]; 2] };
        let both = side_by_side(&left, &right);
        assert_eq!((both.width, both.height), (3, 2));
        assert_eq!(both.rgb, [[1; 3], [1; 3], [7; 3], [1; 3], [1; 3], [7; 3]]);
    }

    #[test]
    fn a_row_stands_under_its_titles() {
        let titles = Way::titles();
        let widths: Vec<usize> = titles.lines().map(|line| line.chars().count()).collect();
        assert_eq!(widths[1], widths[2], "{titles}");
    }
}
