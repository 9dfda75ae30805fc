//! How fast are the answers? `cargo bench --manifest-path bench/trace/Cargo.toml [FILTER]`
//!
//! * `trace/SCENE/STRUCTURE/BUILDER/QUESTION`: every structure and builder of the tables, 4096 rays per step.
//! * `build/SCENE/STRUCTURE/BUILDER`: the same, building.
//! * `traits/SCENE`: `closest_hit` through traits and visitors against one loop by hand over the same nodes; then the ratio
//!   of the fastest of many interleaved runs, which is to stay within 3 %.

use boxwood::prims::Triangles;
use boxwood::structure::{Bvh2, Indexed, by_hand};
use boxwood::{Aabb, BUILDERS, BuildOptions, Query, STRUCTURES};
use boxwood_trace_bench::{cases, rays, scene};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::{Duration, Instant};

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
        let triangles = Triangles::new(case.triangles);
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
