//! How many instructions do the answers take? The same on every run and every busy machine, unlike time:
//! `cargo bench --manifest-path bench/trace/Cargo.toml --features valgrind --bench instructions`
//!
//! Every structure and builder of the tables over the small scenes of the time benchmarks, 4096 rays per count; building is not
//! counted. `-- --nocapture` prints which name each number stands for. valgrind knows instruction sets up to AVX2, so that is the widest kernel that it sees.

use boxwood::{BUILDERS, BuildOptions, Ray, STRUCTURES, Scene};
use boxwood_trace_bench::{cases, rays, scene};
use gungraun::{library_benchmark, library_benchmark_group, main};
use std::hint::black_box;

/// `soup/bvh2/binned`, for each case, structure and builder. Brute force would take minutes.
fn names() -> Vec<String> {
    let structures = STRUCTURES.iter().filter(|s| s.name != "list");
    let builds = structures.flat_map(|structure| {
        let builders = if structure.is_tree {
            BUILDERS
        } else {
            &BUILDERS[..1]
        };
        builders
            .iter()
            .map(move |builder| format!("{}/{}", structure.name, builder.name))
    });
    let builds: Vec<String> = builds.collect();
    let of_case = |case: &'static str| builds.iter().map(move |build| format!("{case}/{build}"));
    ["waves", "soup"].into_iter().flat_map(of_case).collect()
}

/// Builds what the name says.
fn built(name: String) -> (String, Scene, Vec<Ray>) {
    let mut words = name.split('/');
    let mut word = || words.next().unwrap_or_default();
    let (case, structure, builder) = (word(), word(), word());
    let cases = cases();
    let case = cases
        .iter()
        .find(|c| c.name == case)
        .expect("a case of ours");
    let builder = BUILDERS
        .iter()
        .find(|b| b.name == builder)
        .expect("a builder of the table");
    let scene = scene(case, structure, BuildOptions::with(*builder));
    (name, scene, rays())
}

#[library_benchmark(setup = built)]
#[benches::of(iter = names())]
fn closest_hit((_, scene, rays): (String, Scene, Vec<Ray>)) -> usize {
    let query = scene.query();
    black_box(
        rays.iter()
            .filter(|ray| query.closest_hit(ray).is_some())
            .count(),
    )
}

#[library_benchmark(setup = built)]
#[benches::of(iter = names())]
fn closest_hits((_, scene, rays): (String, Scene, Vec<Ray>)) -> usize {
    let mut hits = vec![None; rays.len()];
    scene.query().closest_hits(&rays, &mut hits);
    black_box(hits.iter().flatten().count())
}

#[library_benchmark(setup = built)]
#[benches::of(iter = names())]
fn occluded((_, scene, rays): (String, Scene, Vec<Ray>)) -> usize {
    let query = scene.query();
    black_box(rays.iter().filter(|ray| query.occluded(ray)).count())
}

#[library_benchmark(setup = built)]
#[benches::of(iter = names())]
fn occluded_each((_, scene, rays): (String, Scene, Vec<Ray>)) -> usize {
    let mut occluded = vec![false; rays.len()];
    scene.query().occluded_each(&rays, &mut occluded);
    black_box(occluded.iter().filter(|is| **is).count())
}

/// `of_N` stands for the N-th of the names, as a benchmark's own name must be known when it is compiled.
fn legend() {
    for (number, name) in names().iter().enumerate() {
        println!("of_{number}: {name}");
    }
}

library_benchmark_group!(
    name = answers,
    setup = legend(),
    benchmarks = [closest_hit, closest_hits, occluded, occluded_each]
);
main!(library_benchmark_groups = answers);
