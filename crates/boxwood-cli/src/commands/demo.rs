//! `boxwood demo`, and what `boxwood` does by itself: one scene traced five ways, with the bill.

mod frame;

use std::{
    sync::atomic::Ordering,
    time::{Duration, Instant},
};

use boxwood::{BuildOptions, Builder, STRUCTURES, Scene, lecture::price::Price};
use boxwood_measure::Machine;
use boxwood_render::{
    Film, Image, RenderOptions, Scale, ScaleOptions, Shading, View, Watch, render, write_png,
};
use serde::Serialize;

use self::frame::{Frame, Way};
use crate::{
    args::{self, Loaded, SceneArgs},
    frame_rate::frame_rates,
    output::{Exit, Output, counted, grouped, short},
    progress::interrupted,
    save,
    terminal::{self, Show},
};

/// Trace 40,000 triangles five ways, with the bill; `boxwood` alone does this.
///
/// Writes boxwood.png and boxwood-heat.png into the current folder, and shows them if the terminal can show pictures.
#[derive(Debug, Default, clap::Args)]
#[command(
    after_help = "Examples:\n  boxwood\n  boxwood demo --size 640x360\n  boxwood demo --json"
)]
pub(crate) struct Args {
    /// Size of the frame in pixels. [default: 1280x720, as in the lecture]
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = size)]
    size: Option<[u32; 2]>,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let [width, height] = args::size(text)?;
    let fits = u64::from(width) * u64::from(height) <= MAX_RAYS;
    if fits {
        Ok([width, height])
    } else {
        Err(format!("at most {MAX_RAYS} pixels"))
    }
}

/// All rays of the frame and their hits are held in memory: 1 GB.
const MAX_RAYS: u64 = 1 << 24;
const SCENE: &str = "builtin:bush";
const PICTURE: &str = "boxwood.png";
const HEAT: &str = "boxwood-heat.png";

/// How the frame is traced: name, structure, builder. The first is the oracle, the last the fastest.
const WAYS: [(&str, &str, Builder); 5] = [
    ("list", "list", Builder::BINNED),
    ("grid", "grid", Builder::BINNED),
    ("bounded median", "bounded", Builder::MEDIAN),
    ("bvh2 binned SAH", "bvh2", Builder::BINNED),
    ("wide binned SAH", "wide", Builder::BINNED),
];
/// The fastest, which draws.
const BEST: usize = WAYS.len() - 1;

/// Everything shown, in the words of the JSON object.
#[derive(Serialize)]
struct Report {
    file: &'static str,
    triangles: usize,
    width: u32,
    height: u32,
    threads: usize,
    simd: Vec<String>,
    ways: Vec<Way>,
    brute_force_flops: u64,
    /// Of the fastest.
    drawing: Drawing,
    pictures: [&'static str; 2],
}

/// Whole frames: a camera ray per pixel, a shadow ray where it hits, flat shading; on all threads.
#[derive(Serialize)]
struct Drawing {
    frames_per_second: f64,
    ms_per_frame: f64,
    camera_rays: u64,
    shadow_rays: u64,
    /// Of the threads' time, 0 to 1.
    query_share: f64,
}

/// Traces, prints as it goes, writes the pictures.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let start = Instant::now();
    let [width, height] = args.size.unwrap_or([1280, 720]);
    interrupted();
    say(out, banner)?;
    save::check(Some(PICTURE), out, &["png"])?;
    let file = SCENE.to_owned();
    let loaded = SceneArgs { file }.load(out)?;
    let triangles = loaded.mesh.indices.len();
    let price = Price {
        width: width.into(),
        height: height.into(),
        ..Price::of_720p(triangles as u64)
    };

    let Some((scenes, ways)) = trace(&loaded, &price, out)? else {
        return Ok(stopped(out));
    };
    let drawing = draw(&scenes[BEST], &loaded, [width, height])?;
    say(out, || drawing.text(&ways[BEST], [width, height]))?;
    let images = [
        picture(&scenes[BEST], &loaded, [width, height])?,
        heat(&scenes[1], &scenes[BEST], &loaded, [width, height])?,
    ];
    if interrupted().load(Ordering::Relaxed) {
        return Ok(stopped(out));
    }
    for (image, name) in images.iter().zip([PICTURE, HEAT]) {
        write(image, name, out)?;
    }
    say(out, || ending(start.elapsed()))?;
    let same = ways.iter().all(|way| way.same_answer);
    if out.is_json() {
        out.json(&Report {
            file: SCENE,
            triangles,
            width,
            height,
            threads: rayon::current_num_threads(),
            simd: Machine::seen().simd,
            ways,
            brute_force_flops: price.flops(),
            drawing,
            pictures: [PICTURE, HEAT],
        })?;
    }
    Ok(Exit::from_difference(!same))
}

/// To people only.
fn say(out: &Output, text: impl FnOnce() -> String) -> anyhow::Result<()> {
    if out.is_json() {
        Ok(())
    } else {
        out.text(text())
    }
}

fn stopped(out: &Output) -> Exit {
    out.warn("interrupted; no picture is written");
    Exit::Interrupted
}

/// Traces the frame each way, a row for each; none if the user stops it.
fn trace(
    loaded: &Loaded,
    price: &Price,
    out: &Output,
) -> anyhow::Result<Option<([Scene; WAYS.len()], Vec<Way>)>> {
    let (oracle, _) = args::build(&loaded.mesh, "list", BuildOptions::default())?;
    let view = view(&oracle, loaded, [price.width as u32, price.height as u32])?;
    let frame = Frame::of(&view, &oracle);
    say(out, || {
        let (triangles, rays) = (grouped(price.triangles), grouped(price.pixels()));
        let (width, height, titles) = (price.width, price.height, Way::titles());
        format!("{SCENE}: {triangles} triangles; {width} x {height} = {rays} rays\n\n{titles}")
    })?;

    let mut ways: Vec<Way> = Vec::new();
    let mut scenes = Vec::new();
    for (name, structure, builder) in WAYS {
        let options = BuildOptions::with(builder);
        let (scene, build_time) = args::build(&loaded.mesh, structure, options)?;
        let way = Way::measured(name, &frame, &scene, build_time, ways.first());
        if interrupted().load(Ordering::Relaxed) {
            return Ok(None);
        }
        say(out, || way.row())?;
        ways.push(way);
        scenes.push(scene);
    }
    let bill = bill(price, &ways[BEST]);
    say(out, || format!("{}\n\n{bill}", frame.footnote()))?;
    Ok(scenes.try_into().ok().map(|scenes| (scenes, ways)))
}

/// Into the file called `name`, and onto the terminal if it can show pictures.
fn write(image: &Image, name: &str, out: &Output) -> anyhow::Result<()> {
    save::save(name, |file| {
        write_png(image, &[("Software", "boxwood")], file)
    })?;
    if let (Some(way), false) = (Show::of_stdout(), out.is_json()) {
        // The table, some 25 lines with all around it, is to stay in sight.
        let lines = (terminal::lines().saturating_sub(25) / 2).clamp(10, 30);
        out.text(way.draw(image, terminal::columns_for(image, lines))?)?;
    }
    Ok(())
}

fn banner() -> String {
    let names: Vec<&str> = STRUCTURES.iter().map(|structure| structure.name).collect();
    let threads = rayon::current_num_threads();
    format!(
        "Boxwood {}: what does this ray hit?\n{threads} thread{}, kernels for {}, structures {}",
        env!("CARGO_PKG_VERSION"),
        if threads == 1 { "" } else { "s" },
        boxwood::InstructionSet::best().name(),
        names.join(" "),
    )
}

fn ending(time: Duration) -> String {
    format!(
        "wrote {PICTURE} and {HEAT} (left grid, right wide); {:.1} s in all\n\
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

fn draw(scene: &Scene, loaded: &Loaded, size: [u32; 2]) -> anyhow::Result<Drawing> {
    let view = view(scene, loaded, size)?;
    let rate = frame_rates(&[scene], loaded.surfaces(), &view, Duration::from_secs(1))[0];
    Ok(Drawing {
        frames_per_second: rate.per_second(),
        ms_per_frame: rate.frame.as_secs_f64() * 1e3,
        camera_rays: rate.rays.camera,
        shadow_rays: rate.rays.shadow,
        query_share: rate.query_share,
    })
}

impl Drawing {
    fn text(&self, way: &Way, [width, height]: [u32; 2]) -> String {
        let threads = rayon::current_num_threads();
        format!(
            "One ray per call it does {} Mrays/s. With a shadow ray from each hit and shading it draws\n\
             {} frames per second ({width} x {height}, {}, {:.0} % of the time in queries).\n",
            short(way.single_mrays_per_second),
            short(self.frames_per_second),
            counted(threads, "thread"),
            self.query_share * 100.0,
        )
    }
}

fn view(scene: &Scene, loaded: &Loaded, [width, height]: [u32; 2]) -> anyhow::Result<View> {
    let auto = || boxwood_render::auto_camera(scene, loaded.surfaces(), width, height);
    let camera = loaded.model.cameras.first().copied().unwrap_or_else(auto);
    Ok(View::new(camera, width, height)?)
}

/// The scene by sunlight.
fn picture(scene: &Scene, loaded: &Loaded, size: [u32; 2]) -> anyhow::Result<Image> {
    let usual = RenderOptions::new(Shading::named("whitted")?);
    let options = RenderOptions {
        samples: Some(4),
        counts: false,
        ..usual
    };
    Ok(film(scene, loaded, size, &options)?.to_image())
}

/// Triangle tests per pixel in a grid and in a tree, side by side on one scale; each half has 5/8 of the frame's sides.
fn heat(grid: &Scene, tree: &Scene, loaded: &Loaded, size: [u32; 2]) -> anyhow::Result<Image> {
    let size = size.map(|side| (side * 5 / 8).max(1));
    let usual = RenderOptions::new(Shading::named("heat-prims")?);
    let film = |scene: &Scene, top| {
        let scale = ScaleOptions { top, log: true };
        film(
            scene,
            loaded,
            size,
            &RenderOptions {
                scale,
                ..usual.clone()
            },
        )
    };
    // Up to the largest number of all: nothing is cut off at the bright end.
    let most = |film: &Film| film.scale.map_or(0.0, |scale| scale.max);
    let top = most(&film(grid, None)?).max(most(&film(tree, None)?));
    let image = |scene: &Scene, title| -> anyhow::Result<Image> {
        let mut film = film(scene, Some(top))?;
        film.scale = film.scale.map(|scale| Scale { title, ..scale });
        Ok(film.to_image())
    };
    Ok(side_by_side(
        &image(grid, "grid: triangle tests")?,
        &image(tree, "wide: triangle tests")?,
    ))
}

/// Empty if the user stops it.
fn film(
    scene: &Scene,
    loaded: &Loaded,
    size: [u32; 2],
    options: &RenderOptions,
) -> anyhow::Result<Film> {
    let watch = Watch {
        cancel: Some(interrupted()),
        report: None,
    };
    Ok(render(
        scene,
        loaded.surfaces(),
        &view(scene, loaded, size)?,
        options,
        watch,
    )?)
}

/// Of equal height.
fn side_by_side(left: &Image, right: &Image) -> Image {
    let rows = left
        .rgb
        .chunks(left.width as usize)
        .zip(right.rgb.chunks(right.width as usize));
    let rgb = rows
        .flat_map(|(left, right)| left.iter().chain(right))
        .copied()
        .collect();
    Image {
        width: left.width + right.width,
        height: left.height,
        rgb,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_side_by_side() {
        let left = Image {
            width: 2,
            height: 2,
            rgb: vec![[1; 3]; 4],
        };
        let right = Image {
            width: 1,
            height: 2,
            rgb: vec![[7; 3]; 2],
        };
        let both = side_by_side(&left, &right);
        assert_eq!((both.width, both.height), (3, 2));
        assert_eq!(both.rgb, [[1; 3], [1; 3], [7; 3], [1; 3], [1; 3], [7; 3]]);
    }
}
