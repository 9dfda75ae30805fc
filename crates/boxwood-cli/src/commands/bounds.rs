//! `boxwood bounds`: the lecture's "is this worth it?" about each bounding volume.

use std::{
    hint::black_box,
    time::{Duration, Instant},
};

use boxwood::{BuildOptions, Ray, Scene, VOLUMES, Volume, geom::PreparedRay, volume::FittedVolume};
use serde::Serialize;

use crate::{
    args::{self, CameraArgs, Loaded, SceneArgs},
    contest::{camera_rays, random_rays},
    measure::{Clock, Task, interleaved, nanoseconds, on_one_thread},
    output::{Exit, Output, Table, grouped, short},
};

/// Is a bounding volume worth it? With numbers, for each volume.
///
/// Each volume is fitted around the whole object. A volume costs its test for every ray, and saves the object's test for
/// the rays that miss it: it pays if  price of the volume < share of rays that miss it x price of the object for those.
/// All three are measured, for rays of the camera and for random lines, the object being a list of its triangles (the
/// lecture's question) or a hierarchy over them (which begins with a box of its own).
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  boxwood bounds builtin:bush
  boxwood bounds builtin:hairball?n=20000 --json")]
pub(crate) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// How many rays, of each kind, up to 10 million.
    #[arg(long, value_name = "N", default_value_t = 100_000, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    rays: u32,
    #[command(flatten)]
    camera: CameraArgs,
}

/// Turns of the clock; each has rays of its own.
const ROUNDS: usize = 25;
/// Most rays of one turn.
const TURN: usize = 4096;
/// Most triangle tests of one turn of brute force.
const LIST_TESTS: usize = 500_000;

/// The JSON object.
#[derive(Serialize)]
struct Answer {
    file: String,
    triangles: usize,
    rays_of_each_kind: usize,
    /// Making a ray ready for exact tests, which is needed in any case and is in none of the other times.
    ns_to_prepare_a_ray: f64,
    volumes: Vec<Fit>,
    kinds: Vec<Kind>,
}

/// A volume around the object.
#[derive(Serialize)]
struct Fit {
    name: &'static str,
    fit_ms: f64,
    volume: f64,
    surface_area: f64,
    /// Relative to the axis-aligned box.
    volume_to_aabb: Option<f64>,
    area_to_aabb: Option<f64>,
    flops_per_test: u32,
    /// Measured on camera rays and random lines together.
    ns_per_test: f64,
}

/// One kind of rays.
#[derive(Serialize)]
struct Kind {
    rays: &'static str,
    count: usize,
    hit_object: f64,
    volumes: Vec<Use>,
}

/// One volume for one kind of rays.
#[derive(Serialize)]
struct Use {
    name: &'static str,
    /// Share of the rays.
    hit_volume: f64,
    /// Of the rays that hit the volume, the share that misses the object.
    hit_volume_but_miss_object: Option<f64>,
    /// The object as a list of triangles.
    list: Bargain,
    /// The object as a hierarchy.
    bvh2: Bargain,
    /// A list of so many triangles or more is worth the volume; none if no ray misses the volume.
    pays_from_triangles: Option<f64>,
}

/// Nanoseconds per ray without and with the volume, those to make the ray ready left out.
#[derive(Clone, Copy, Serialize)]
struct Bargain {
    bare_ns: f64,
    with_volume_ns: f64,
    is_worth_it: bool,
}

/// Fits, shoots and calculates.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let loaded = args.scene.load(out)?;
    let answer = on_one_thread(|| answer(args, &loaded))??;
    if out.is_json() {
        out.json(&answer)?;
    } else {
        out.text(text(&answer))?;
    }
    Ok(Exit::Ok)
}

/// The volumes and the object, ready to be tested.
struct Bench {
    volumes: Vec<Fitted>,
    list: Scene,
    bvh2: Scene,
}

/// A volume of the table around the object.
struct Fitted {
    entry: Volume,
    volume: Box<dyn FittedVolume>,
    time: Duration,
}

fn answer(args: &Args, loaded: &Loaded) -> anyhow::Result<Answer> {
    let mesh = &loaded.mesh;
    let build =
        |structure| args::build(mesh, structure, BuildOptions::default()).map(|(scene, _)| scene);
    let points: Vec<[f32; 3]> = mesh
        .indices
        .iter()
        .flatten()
        .map(|&i| mesh.positions[i as usize])
        .collect();
    let fit = |entry: &Volume| {
        let start = Instant::now();
        let volume = entry.fit(&points);
        Fitted {
            entry: *entry,
            volume,
            time: start.elapsed(),
        }
    };
    let bench = Bench {
        volumes: VOLUMES.iter().map(fit).collect(),
        list: build("list")?,
        bvh2: build("bvh2")?,
    };
    let view = args.camera.view(&bench.bvh2, loaded)?;
    let count = args.rays as usize;
    let kinds = [
        ("camera", camera_rays(&view, count)),
        ("random", random_rays(&bench.bvh2, count)),
    ];
    let both: Vec<Ray> = kinds[0]
        .1
        .iter()
        .zip(&kinds[1].1)
        .flat_map(|(a, b)| [*a, *b])
        .collect();
    let (prepare_ns, volume_ns) = bench.prices(&both);
    Ok(Answer {
        file: loaded.name.clone(),
        triangles: mesh.indices.len(),
        rays_of_each_kind: count,
        ns_to_prepare_a_ray: prepare_ns,
        volumes: bench.fits(&volume_ns),
        kinds: kinds
            .iter()
            .map(|(name, rays)| bench.kind(name, rays, prepare_ns, &volume_ns))
            .collect(),
    })
}

impl Bench {
    fn fits(&self, ns: &[f64]) -> Vec<Fit> {
        let aabb = self.volumes.iter().find(|v| v.entry.name == "aabb");
        let to_aabb = |part: f64, whole: fn(&dyn FittedVolume) -> f64| {
            aabb.map(|aabb| part / whole(&*aabb.volume))
                .filter(|ratio| ratio.is_finite())
        };
        let fit = |(fitted, ns): (&Fitted, &f64)| {
            let Fitted {
                entry,
                volume,
                time,
            } = fitted;
            Fit {
                name: entry.name,
                fit_ms: time.as_secs_f64() * 1e3,
                volume: volume.volume(),
                surface_area: volume.surface_area(),
                volume_to_aabb: to_aabb(volume.volume(), |v| v.volume()),
                area_to_aabb: to_aabb(volume.surface_area(), |v| v.surface_area()),
                flops_per_test: entry.flops,
                ns_per_test: *ns,
            }
        };
        self.volumes.iter().zip(ns).map(fit).collect()
    }

    /// Nanoseconds to make a ray ready, and those of one test of each volume beyond that.
    fn prices(&self, rays: &[Ray]) -> (f64, Vec<f64>) {
        let (turn, rays_of) = turns(rays, TURN);
        let mut tasks: Vec<Task<'_>> = vec![Box::new(|round| {
            for ray in rays_of(round) {
                black_box(PreparedRay::new(ray));
            }
        })];
        for Fitted { volume, .. } in &self.volumes {
            tasks.push(Box::new(|round| {
                black_box(volume.count_hits(rays_of(round)));
            }));
        }
        let times = interleaved(Clock::Thread, ROUNDS, &mut tasks);
        let ns: Vec<f64> = times
            .into_iter()
            .map(|time| nanoseconds(time, turn))
            .collect();
        // A clock is not perfect: no test is free.
        (
            ns[0],
            ns[1..]
                .iter()
                .map(|ns_with_ray| (ns_with_ray - ns[0]).max(0.1))
                .collect(),
        )
    }

    /// All prices are those beyond `prepare_ns`, which making a ray ready takes in any case.
    fn kind(&self, name: &'static str, rays: &[Ray], prepare_ns: f64, volume_ns: &[f64]) -> Kind {
        let beyond = |ns: f64| (ns - prepare_ns).max(0.0);
        let mut object = vec![false; rays.len()];
        self.bvh2.occluded_each(rays, &mut object);
        let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
        let list_ns = beyond(self.list_ns(rays));
        let volumes = self.volumes.iter().zip(volume_ns).map(|(fitted, &ns)| {
            let hits = fitted.volume.hits(rays);
            let [inside, outside] =
                [true, false].map(|side| -> Vec<Ray> { select(rays, &hits, |hit| hit == side) });
            let misses = hits
                .iter()
                .zip(&object)
                .filter(|(volume, object)| **volume && !**object)
                .count();
            let hit_volume = share(inside.len(), rays.len());
            let [hit_ns, miss_ns] =
                [&inside, &outside].map(|rays| beyond(closest_hit_ns(&self.bvh2, rays, TURN)));
            let triangle_ns = list_ns / self.list.len().max(1) as f64;
            Use {
                name: fitted.entry.name,
                hit_volume,
                hit_volume_but_miss_object: (!inside.is_empty())
                    .then(|| share(misses, inside.len())),
                list: Bargain::new(ns, hit_volume, list_ns, list_ns),
                bvh2: Bargain::new(ns, hit_volume, hit_ns, miss_ns),
                pays_from_triangles: (hit_volume < 1.0)
                    .then(|| ns / ((1.0 - hit_volume) * triangle_ns))
                    .filter(|count| count.is_finite()),
            }
        });
        let volumes = volumes.collect();
        let hits = object.iter().filter(|hit| **hit).count();
        Kind {
            rays: name,
            count: rays.len(),
            hit_object: share(hits, rays.len()),
            volumes,
        }
    }

    /// Brute force asks every triangle about every ray, so each ray costs the same.
    fn list_ns(&self, rays: &[Ray]) -> f64 {
        closest_hit_ns(&self.list, rays, LIST_TESTS / self.list.len().max(1))
    }
}

/// Nanoseconds per ray, for turns of at most so many rays; 0 without rays.
fn closest_hit_ns(scene: &Scene, rays: &[Ray], most: usize) -> f64 {
    let (turn, rays_of) = turns(rays, most);
    let mut hits = vec![None; turn];
    nanoseconds(
        interleaved(
            Clock::Thread,
            ROUNDS,
            &mut [Box::new(|round| {
                scene.closest_hits(rays_of(round), &mut hits);
            })],
        )[0],
        turn,
    )
}

/// How many rays a turn has, at most `most`, and which.
fn turns<'r>(rays: &'r [Ray], most: usize) -> (usize, impl Fn(usize) -> &'r [Ray] + Copy) {
    let turn = (rays.len() / ROUNDS).clamp(1, most.max(1)).min(rays.len());
    (turn, move |round| {
        rays.get(round * turn..(round + 1) * turn)
            .unwrap_or(&rays[..turn])
    })
}

fn select(rays: &[Ray], hits: &[bool], wanted: impl Fn(bool) -> bool) -> Vec<Ray> {
    rays.iter()
        .zip(hits)
        .filter(|(_, hit)| wanted(**hit))
        .map(|(ray, _)| *ray)
        .collect()
}

impl Bargain {
    /// With the volume's price, the share of rays that hit it, and the object's price for those and for the others.
    fn new(volume_ns: f64, hit_share: f64, hit_ns: f64, miss_ns: f64) -> Self {
        let for_hits = hit_share * hit_ns;
        let bare_ns = for_hits + (1.0 - hit_share) * miss_ns;
        let with_volume_ns = volume_ns + for_hits;
        Self {
            bare_ns,
            with_volume_ns,
            is_worth_it: with_volume_ns < bare_ns,
        }
    }

    fn verdict(self) -> String {
        let Self {
            bare_ns,
            with_volume_ns,
            is_worth_it,
        } = self;
        let prices = format!(
            "{} ns bare, {} ns with it",
            short(bare_ns),
            short(with_volume_ns)
        );
        let ratio = bare_ns / with_volume_ns;
        match is_worth_it {
            _ if (0.98..1.02).contains(&ratio) => format!("makes no difference ({prices})"),
            true => format!("worth it, {} times faster ({prices})", short(ratio)),
            false => format!(
                "not worth it, {} times slower ({prices})",
                short(1.0 / ratio)
            ),
        }
    }
}

fn text(answer: &Answer) -> String {
    let mut table = Table::new([
        "volume",
        "fit ms",
        "volume",
        "to aabb",
        "area",
        "to aabb",
        "flop/test",
        "ns/test",
    ]);
    let ratio = |ratio: Option<f64>| ratio.map_or_else(|| "-".to_owned(), short);
    for fit in &answer.volumes {
        table.row([
            fit.name.to_owned(),
            short(fit.fit_ms),
            short(fit.volume),
            ratio(fit.volume_to_aabb),
            short(fit.surface_area),
            ratio(fit.area_to_aabb),
            fit.flops_per_test.to_string(),
            short(fit.ns_per_test),
        ]);
    }
    let mut lines = vec![
        format!(
            "{}: is a bounding volume around its {} triangles worth it?",
            answer.file,
            grouped(answer.triangles as u64)
        ),
        String::new(),
        table.to_string(),
        format!(
            "\n(on one thread; making a ray ready, which is needed in any case, takes {} ns more, here and below)",
            short(answer.ns_to_prepare_a_ray)
        ),
    ];
    lines.extend(answer.kinds.iter().map(kind_text));
    lines.join("\n")
}

fn kind_text(kind: &Kind) -> String {
    let mut lines = vec![format!(
        "\n{} {} rays, {} % of which hit the object:",
        grouped(kind.count as u64),
        kind.rays,
        short(kind.hit_object * 100.0)
    )];
    for volume in &kind.volumes {
        let but_miss = volume.hit_volume_but_miss_object.map_or_else(
            || "no ray hits it".to_owned(),
            |share| format!("{} % of those miss the object", short(share * 100.0)),
        );
        let pays = volume.pays_from_triangles.map_or_else(
            || "never pays".to_owned(),
            |from| {
                format!(
                    "pays from {} triangles on",
                    grouped(from.max(1.0).ceil() as u64)
                )
            },
        );
        lines.push(format!(
            "  {:<7} {} % of the rays hit it, {but_miss}",
            volume.name,
            short(volume.hit_volume * 100.0)
        ));
        lines.push(format!(
            "          around a list of triangles: {}; {pays}",
            volume.list.verdict()
        ));
        lines.push(format!(
            "          around a bvh2: {}",
            volume.bvh2.verdict()
        ));
    }
    lines.join("\n")
}
