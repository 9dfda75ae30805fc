//! Pictures whose tiles are kept as they get done: of shards, and of what is to survive any end.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use boxwood_render::{
    Film, PartHeader, RenderOptions, Resumed, ScaleOptions, Shard, TileLog, View, followed,
};

use super::{
    Args,
    plan::Picture,
    report::Report,
    studio::{Made, Studio, expose},
    write::write,
};
use crate::{
    args::{StructureArgs, camera_flags},
    output::{Output, counted, size},
};

/// Where the tiles of a picture go.
struct Places {
    /// While they are being made.
    growing: PathBuf,
    /// When the shard is whole; a picture that is whole needs no tiles any more.
    whole: Option<PathBuf>,
}

impl Places {
    /// Beside the output, after links: `shot.png.tiles`, or `shot.png.02of16.tiles` and `.part`.
    fn of(output: &str, shard: Option<Shard>) -> anyhow::Result<Self> {
        let output = followed(Path::new(output))?;
        let beside = |ending: String| {
            let mut name = output.clone().into_os_string();
            name.push(ending);
            PathBuf::from(name)
        };
        Ok(match shard {
            None => Self {
                growing: beside(".tiles".to_owned()),
                whole: None,
            },
            Some(Shard { number, count }) => {
                let digits = count.to_string().len();
                let stem = format!(".{number:0digits$}of{count}");
                Self {
                    growing: beside(format!("{stem}.tiles")),
                    whole: Some(beside(format!("{stem}.part"))),
                }
            }
        })
    }

    /// The whole one if it is there: it turns out whether it is.
    fn found(&self) -> &Path {
        let whole = self.whole.as_deref().filter(|whole| whole.exists());
        whole.unwrap_or(&self.growing)
    }
}

/// Exposes the tiles of `shard`, or all, that are not kept yet; then writes the picture, or the shard's file.
pub(super) fn make(
    studio: &Studio<'_>,
    picture: &Picture,
    shard: Option<Shard>,
    out: &Output,
) -> anyhow::Result<Made> {
    let (view, options) = studio.prepare(picture, true)?;
    let places = Places::of(&picture.output, shard)?;
    let start = Instant::now();
    let session = studio.session(&view, &options)?;
    let mut film = session.film()?;
    let header = header(studio, &view, &options, &film, shard);
    let (log, resumed) = TileLog::open(places.found(), &header, &mut film)?;
    let rays_before = film.rays;
    tell(&resumed, places.found(), out);
    let mine: Vec<u32> = (0..film.finished.len() as u32)
        .filter(|&tile| header.shard.has(tile as usize))
        .collect();
    let left = unfinished(&mine, &film);
    let film = expose(&session, film, &left, &|film, tile| log.keep(film, tile))?;
    let left = unfinished(&mine, &film).len();
    if left > 0 {
        let part = 100 * (mine.len() - left) / mine.len();
        return Ok(Made::nothing(format!(
            "interrupted: {part} % of the tiles are kept in {}; the same command goes on from there",
            places.found().display()
        )));
    }
    let mut report = {
        let rays = film.rays.saturating_sub(rays_before);
        Report::of(studio, picture, &view, (&film, rays), start.elapsed())
    };
    report.resumed_tiles = Some(resumed.tiles);
    let Some(whole) = &places.whole else {
        return develop(picture, film, log, (&view, &options), report);
    };
    log.finish(whole)?;
    report.complete = true;
    report.output = whole.display().to_string();
    report.shard = shard.map(|shard| shard.to_string());
    Ok(Made {
        report: Some(report),
        film: None,
        interrupted: None,
    })
}

fn unfinished(tiles: &[u32], film: &Film) -> Vec<u32> {
    let left = tiles.iter().copied();
    left.filter(|&tile| !film.finished[tile as usize]).collect()
}

/// All tiles are there: writes the picture, after which they are no longer needed.
fn develop(
    picture: &Picture,
    mut film: Film,
    log: TileLog,
    (view, options): (&View, &RenderOptions),
    report: Report,
) -> anyhow::Result<Made> {
    film.develop(options.shading, options.scale);
    write(&picture.output, &film, &view.camera(), options.shading.name)?;
    log.remove()?;
    Ok(Made {
        report: Some(report),
        film: Some(film),
        interrupted: None,
    })
}

fn tell(resumed: &Resumed, place: &Path, out: &Output) {
    let place = place.display();
    if resumed.tiles > 0 {
        out.note(format!(
            "{} taken over from {place}",
            counted(resumed.tiles, "tile")
        ));
    }
    if let Some(cause) = &resumed.lock_error {
        out.warn(format!(
            "{place}: cannot be locked ({cause}); let no other process make the same tiles"
        ));
    }
    if resumed.dropped_bytes > 0 {
        let bytes = size(resumed.dropped_bytes as usize);
        out.note(format!("{place}: {bytes} of a torn tail are dropped"));
    }
    if resumed.damaged > 0 {
        let damaged = counted(resumed.damaged, "damaged tile");
        out.warn(format!("{place}: {damaged} passed over, to be made again"));
    }
}

fn header(
    studio: &Studio<'_>,
    view: &View,
    options: &RenderOptions,
    film: &Film,
    shard: Option<Shard>,
) -> PartHeader {
    let args = studio.args;
    PartHeader {
        program: env!("CARGO_PKG_VERSION").to_owned(),
        scene: studio.hash().to_owned(),
        file: studio.loaded.name.clone(),
        camera: view.camera(),
        size: film.full_size,
        window: film.window,
        shading: options.shading.name.to_owned(),
        scale: ScaleOptions { ..options.scale },
        exposure: film.exposure.to_bits(),
        settings: settings(args, options),
        shard: shard.unwrap_or(Shard::WHOLE),
        command: without_shard(std::env::args().skip(1)),
    }
}

/// All that decides pixels besides what the header has by itself, by the names of the options.
fn settings(args: &Args, options: &RenderOptions) -> Vec<(String, String)> {
    let look = &args.look;
    let samples = options.samples.unwrap_or(options.shading.samples);
    let lamps: Vec<String> = look
        .lights
        .iter()
        .map(|lamp| format!("{:?} {:?}", lamp.position, lamp.power))
        .collect();
    let light_from = options.light_from.map(|view| camera_flags(&view.camera()));
    let list = [
        ("--spp", samples.to_string()),
        ("--seed", options.seed.to_string()),
        ("--max-depth", options.max_depth.to_string()),
        ("--light", format!("[{}]", lamps.join(", "))),
        ("--sky", or_automatic(options.sky)),
        ("--exposure", or_automatic(options.exposure)),
        ("--no-floor", look.no_floor.to_string()),
        ("the path's first camera", format!("{light_from:?}")),
    ];
    list.into_iter()
        .chain(tree(&args.structure))
        .map(|(name, value)| (name.to_owned(), value))
        .collect()
}

/// Counts and heat depend on the tree; what machine builds it does not matter.
fn tree(args: &StructureArgs) -> [(&'static str, String); 8] {
    let options = args.options();
    [
        ("--structure", args.structure.name.to_owned()),
        ("--preset", args.preset.name.to_owned()),
        ("--builder", options.builder.name.to_owned()),
        ("--volume", options.volume.to_owned()),
        ("--axis", format!("{:?}", options.axis)),
        ("--max-leaf", options.max_leaf.to_string()),
        ("--bins", options.bins.to_string()),
        ("--density", format!("{:?}", options.grid_density)),
    ]
}

fn or_automatic(number: Option<f32>) -> String {
    number.map_or("automatic".to_owned(), |x| format!("{x:?}"))
}

/// The command line for any shard.
fn without_shard(words: impl Iterator<Item = String>) -> Vec<String> {
    let mut words = words;
    let mut kept = Vec::new();
    while let Some(word) = words.next() {
        match &*word {
            "--shard" => drop(words.next()),
            word if word.starts_with("--shard=") => {}
            _ => kept.push(word),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_tiles_stand_beside_the_output_and_sort_by_number() {
        let shard = |number, count| Some(Shard { number, count });
        let whole = |shard| Places::of("a/shot.png", shard).unwrap().whole.unwrap();
        assert_eq!(whole(shard(2, 4)), Path::new("a/shot.png.2of4.part"));
        assert_eq!(whole(shard(2, 16)), Path::new("a/shot.png.02of16.part"));
        let single = Places::of("a/shot.png", None).unwrap();
        assert_eq!(single.found(), Path::new("a/shot.png.tiles"));
    }

    #[test]
    fn the_command_is_kept_without_its_shard() {
        let kept = |line: &str| without_shard(line.split(' ').map(str::to_owned)).join(" ");
        assert_eq!(
            kept("render a.obj --shard 2/4 --spp 8"),
            "render a.obj --spp 8"
        );
        assert_eq!(kept("render --shard=auto a.obj"), "render a.obj");
    }
}
