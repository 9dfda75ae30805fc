//! How fast are the answers? `cargo bench --manifest-path bench/trace/Cargo.toml [FILTER]`
//!
//! * `trace/SCENE/STRUCTURE/BUILDER/QUESTION`: every structure and builder of the tables, 4096 rays per step.
//! * `build/SCENE/STRUCTURE/BUILDER`: the same, building.
//! * `traits/SCENE`: `closest_hit` through traits and visitors against one loop by hand over the same nodes; then the ratio
//!   of the fastest of many interleaved runs, which is to stay within 3 %.

use boxwood::prims::Triangles;
use boxwood::structure::{Bvh2, Indexed, by_hand};
use boxwood::{Aabb, BUILDERS, BuildOptions, Query, Ray, STRUCTURES, Scene, Triangle};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// A soup to bench on.
struct Case {
    name: &'static str,
    triangles: Vec<Triangle>,
}

/// A linear congruential generator.
struct Random(u64);

impl Random {
    /// In -1..1.
    fn signed(&mut self) -> f32 {
        let Self(state) = self;
        *state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*state >> 40) as f32 / (1u32 << 23) as f32 - 1.0
    }

    fn point(&mut self, scale: f32) -> [f32; 3] {
        [0; 3].map(|_| self.signed() * scale)
    }
}

/// A surface and a cloud: rays end early in one and pass by much in the other.
fn cases() -> [Case; 2] {
    [
        Case {
            name: "waves",
            triangles: waves(96),
        },
        Case {
            name: "soup",
            triangles: soup(20_000),
        },
    ]
}

/// A height field of `2 n n` triangles.
fn waves(n: usize) -> Vec<Triangle> {
    let at = |i: usize, j: usize| {
        let [x, z] = [i, j].map(|k| k as f32 / n as f32 * 2.0 - 1.0);
        [x, 0.2 * (7.0 * x).sin() * (5.0 * z + 1.0).cos(), z]
    };
    let quad = |k: usize| {
        let (i, j) = (k / n, k % n);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [Triangle([a, b, c]), Triangle([a, c, d])]
    };
    (0..n * n).flat_map(quad).collect()
}

/// `n` small triangles anywhere.
fn soup(n: usize) -> Vec<Triangle> {
    let mut random = Random(5);
    let mut triangle = || {
        let corner = random.point(1.0);
        Triangle([0; 3].map(|_| {
            let edge = random.point(0.03);
            [0, 1, 2].map(|k| corner[k] + edge[k])
        }))
    };
    (0..n).map(|_| triangle()).collect()
}

/// 4096 rays from anywhere around to anywhere inside.
fn rays() -> Vec<Ray> {
    let mut random = Random(9);
    (0..4096)
        .map(|_| Ray::between(random.point(1.5), random.point(1.0)))
        .collect()
}

fn scene(case: &Case, structure: &str, options: BuildOptions) -> Scene {
    let positions: Vec<[f32; 3]> = case.triangles.iter().flat_map(|t| t.0).collect();
    let indices: Vec<[u32; 3]> = (0..case.triangles.len() as u32)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    let scene = Scene::builder()
        .mesh(&positions, &indices)
        .structure(structure)
        .options(options);
    scene.build().expect("a soup is a scene")
}

fn trace_and_build(c: &mut Criterion) {
    let rays = rays();
    // Brute force would take minutes.
    for structure in STRUCTURES.iter().filter(|s| s.name != "list") {
        let builders = if structure.is_tree {
            BUILDERS
        } else {
            &BUILDERS[..1]
        };
        for (case, builder) in cases()
            .iter()
            .flat_map(|case| builders.iter().map(move |b| (case, b)))
        {
            let name = format!("{}/{}/{}", case.name, structure.name, builder.name);
            let built = scene(case, structure.name, BuildOptions::with(*builder));
            let query = built.query();
            let mut group = c.benchmark_group(format!("trace/{name}"));
            group.throughput(Throughput::Elements(rays.len() as u64));
            group.bench_function("closest_hit", |b| {
                b.iter(|| {
                    rays.iter()
                        .filter(|ray| query.closest_hit(ray).is_some())
                        .count()
                });
            });
            group.bench_function("occluded", |b| {
                b.iter(|| rays.iter().filter(|ray| query.occluded(ray)).count());
            });
            group.finish();
            c.bench_function(&format!("build/{name}"), |b| {
                b.iter(|| scene(case, structure.name, BuildOptions::with(*builder)));
            });
        }
    }
}

fn traits_and_hand(c: &mut Criterion) {
    let rays = rays();
    for case in cases() {
        let triangles = Triangles(case.triangles);
        let indexed = Indexed::<Bvh2<Aabb>, _>::new(&triangles, &BuildOptions::default())
            .expect("a soup can be built");
        let through_traits = || {
            rays.iter()
                .filter(|ray| indexed.closest_hit(ray).is_some())
                .count()
        };
        let by_hand = || {
            rays.iter()
                .filter(|ray| by_hand::closest_hit(&indexed, ray).is_some())
                .count()
        };
        let mut group = c.benchmark_group(format!("traits/{}", case.name));
        group.bench_function("traits", |b| b.iter(through_traits));
        group.bench_function("by_hand", |b| b.iter(by_hand));
        group.finish();
        let [mut traits, mut hand] = [Duration::MAX; 2];
        for _ in 0..300 {
            traits = traits.min(time(through_traits));
            hand = hand.min(time(by_hand));
        }
        let ratio = traits.as_secs_f64() / hand.as_secs_f64();
        println!(
            "traits/{}: the traits take {ratio:.3} of the time by hand",
            case.name
        );
    }
}

fn time(work: impl Fn() -> usize) -> Duration {
    let start = Instant::now();
    black_box(work());
    start.elapsed()
}

criterion_group! {
    name = all;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    targets = traits_and_hand, trace_and_build
}
criterion_main!(all);
