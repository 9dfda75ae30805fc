//! `boxwood inspect`: what a file holds, and what a structure makes of it.

use std::collections::BTreeMap;
use std::time::Duration;

use boxwood::{Census, Scene, Stats, Triangle};
use boxwood_scene::{Folded, Model};
use serde::Serialize;

use crate::{
    args::{SceneArgs, StructureArgs, Triangles},
    output::{Exit, Output, coordinate, counted, grouped, short, size},
    warnings,
};

/// Show what a scene holds, and the shape of the structure over it.
///
/// Triangles are counted with every use of a mesh (`triangles`) and as stored (`unique_triangles`). Where meshes repeat so
/// that it pays, the structure holds them once, with instances; then its numbers are those of all structures together, each
/// once.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  boxwood inspect bunny.obj
  boxwood inspect builtin:stadium --structure grid
  boxwood inspect scene.glb --builder sweep --json")]
pub(crate) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    structure: StructureArgs,
}

/// Everything found, in the words of the JSON object.
#[derive(Serialize)]
struct Report {
    file: String,
    /// Every use of a mesh counted.
    triangles: u64,
    /// As stored.
    unique_triangles: u64,
    /// As stored.
    vertices: usize,
    meshes: usize,
    instances: usize,
    materials: usize,
    textures: usize,
    cameras: usize,
    has_normals: bool,
    has_uvs: bool,
    /// Null without triangles.
    bounds: Option<Bounds>,
    load_ms: f64,
    structure: Shape,
    /// Without area: they are kept, and never hit.
    degenerate_triangles: usize,
    /// With a box at least half as large as the scene's.
    huge_triangles: usize,
    /// Too far away to be computed with: never hit.
    skipped_triangles: usize,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Bounds {
    min: [f32; 3],
    max: [f32; 3],
}

/// Of the structure; of a scene of instances, of all structures together, each once.
#[derive(Serialize)]
struct Shape {
    name: &'static str,
    label: String,
    build_ms: f64,
    bytes: usize,
    /// Structures: one, or one around instances and one for each mesh in them.
    structures: usize,
    /// Triangles in them.
    triangles: u64,
    nodes: usize,
    leaves: usize,
    max_depth: u32,
    /// Primitives in leaves, those in several counted several times.
    references: usize,
    /// Null where it says nothing: for grids, instances and scenes without area.
    sah_cost: Option<f64>,
    /// Primitives in a leaf to how many leaves hold so many.
    leaf_sizes: BTreeMap<u32, usize>,
}

/// Loads, builds and prints.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let loaded = args.scene.load_folded_quietly()?;
    let (scene, build_time) = args.structure.build_folded(&loaded.mesh)?;
    let shape = Shape::of(&scene, args.structure.label(), build_time);
    let report = Report::of(
        &loaded.name,
        &loaded.model,
        &loaded.mesh,
        &scene,
        (loaded.time, shape),
    );
    if out.is_json() {
        out.json(&report)?;
    } else {
        out.text(report.text())?;
    }
    Ok(Exit::Ok)
}

impl Shape {
    fn of(scene: &Scene, label: String, build_time: Duration) -> Self {
        let Stats {
            nodes,
            leaves,
            max_depth,
            references,
            leaf_sizes,
            sah_cost,
            ..
        } = all_stats(scene);
        let Census {
            stored,
            scenes,
            bytes,
            ..
        } = scene.census();
        let is_tree =
            boxwood::Structure::named(scene.structure()).is_ok_and(|structure| structure.is_tree);
        Self {
            name: scene.structure(),
            label,
            build_ms: build_time.as_secs_f64() * 1e3,
            bytes,
            structures: scenes,
            triangles: stored,
            nodes,
            leaves,
            max_depth,
            references,
            sah_cost: (is_tree && scene.nesting() == 0 && sah_cost.is_finite()).then_some(sah_cost),
            leaf_sizes,
        }
    }
}

impl Report {
    fn of(
        name: &str,
        model: &Model,
        mesh: &Folded,
        scene: &Scene,
        (time, structure): (Duration, Shape),
    ) -> Self {
        let box_of = scene.bounds();
        let diagonal = box_of.diagonal();
        let meshes = mesh.meshes();
        let triangles = || {
            let corners = |mesh: &'_ boxwood_scene::FlatMesh, t: &[u32; 3]| {
                Triangle(t.map(|i| mesh.positions[i as usize]))
            };
            meshes
                .iter()
                .flat_map(move |mesh| mesh.indices.iter().map(move |t| corners(mesh, t)))
        };
        let mut report = Self {
            file: name.to_owned(),
            triangles: model.triangle_count(),
            unique_triangles: model.unique_triangle_count(),
            vertices: model.meshes.iter().map(|mesh| mesh.positions.len()).sum(),
            meshes: model.meshes.len(),
            instances: model.instances.len(),
            materials: model.materials.len(),
            textures: model.textures.len(),
            cameras: model.cameras.len(),
            has_normals: meshes.iter().any(|mesh| !mesh.normals.is_empty()),
            has_uvs: meshes.iter().any(|mesh| !mesh.uvs.is_empty()),
            bounds: model.bounds().map(|(min, max)| Bounds { min, max }),
            load_ms: time.as_secs_f64() * 1e3,
            structure,
            degenerate_triangles: triangles().filter(has_no_area).count(),
            huge_triangles: triangles()
                .filter(|t| boxwood::Aabb::of_triangle(t).diagonal() > 0.5 * diagonal)
                .count(),
            skipped_triangles: skipped(scene),
            warnings: model.warnings.clone(),
        };
        report.warn();
        report
    }

    /// Adds what the numbers mean to the warnings of the loader.
    fn warn(&mut self) {
        let mut warn = |count: usize, text: &str| {
            if count > 0 {
                self.warnings
                    .push(format!("{} triangles {text}", grouped(count as u64)));
            }
        };
        warn(
            self.degenerate_triangles,
            "have no area: they are never hit",
        );
        warn(
            self.skipped_triangles,
            "are too far away to be computed with: they are never hit",
        );
        // A handful of large ones are walls and floors; many spoil every box around them.
        if self.huge_triangles as u64 > 16 && self.huge_triangles as u64 * 50 > self.triangles {
            warn(
                self.huge_triangles,
                "are more than half as large as the scene: boxes around them overlap",
            );
        }
    }

    fn text(&self) -> String {
        let count = |n: usize| grouped(n as u64);
        let mut lines = vec![("file", self.file.clone())];
        let stored = match self.unique_triangles == self.triangles {
            true => String::new(),
            false => format!(" ({} stored)", grouped(self.unique_triangles)),
        };
        let extras = [
            (self.has_normals, ", normals"),
            (self.has_uvs, ", texture coordinates"),
        ];
        let extras: String = extras
            .iter()
            .filter(|(has, _)| *has)
            .map(|(_, name)| *name)
            .collect();
        lines.push(("triangles", format!("{}{stored}", grouped(self.triangles))));
        lines.push(("vertices", format!("{}{extras}", count(self.vertices))));
        lines.push((
            "meshes",
            format!(
                "{}, {} of them",
                count(self.meshes),
                counted(self.instances, "instance")
            ),
        ));
        let (textures, cameras) = (
            counted(self.textures, "texture"),
            counted(self.cameras, "camera"),
        );
        lines.push((
            "materials",
            format!("{}, {textures}, {cameras}", count(self.materials)),
        ));
        lines.push((
            "bounds",
            self.bounds
                .as_ref()
                .map_or("empty".to_owned(), Bounds::text),
        ));
        lines.push(("loaded in", format!("{} ms", short(self.load_ms))));
        lines.push(("structure", self.structure.label.clone()));
        lines.extend(self.structure.lines());
        lines.extend(
            warnings::shortened(&self.warnings)
                .into_iter()
                .map(|warning| ("warning", warning)),
        );
        lines
            .iter()
            .map(|(name, value)| format!("{name:<11} {value}"))
            .collect::<Vec<_>>()
            .join("\n")
    }
}

impl Bounds {
    fn text(&self) -> String {
        let list = |corner: [f32; 3]| corner.map(coordinate).join(" ");
        format!("{} to {}", list(self.min), list(self.max))
    }
}

impl Shape {
    fn lines(&self) -> Vec<(&'static str, String)> {
        let count = |n: usize| grouped(n as u64);
        let mut lines = vec![
            ("built in", format!("{} ms", short(self.build_ms))),
            ("memory", self.memory()),
            (
                "nodes",
                format!(
                    "{}, {} of them leaves, deepest at {}",
                    count(self.nodes),
                    count(self.leaves),
                    self.max_depth
                ),
            ),
            ("references", count(self.references)),
        ];
        if let Some(cost) = self.sah_cost {
            lines.push(("SAH cost", short(cost)));
        }
        lines.extend(self.histogram());
        lines
    }

    fn memory(&self) -> String {
        let all = format!("{} with the triangles", size(self.bytes));
        match self.structures {
            1 => all,
            n => format!(
                "{all}, {} stored in {n} structures",
                grouped(self.triangles)
            ),
        }
    }

    /// One line per leaf size, or per range of them where there are many.
    fn histogram(&self) -> Vec<(&'static str, String)> {
        const LINES: usize = 10;
        let end = self
            .leaf_sizes
            .keys()
            .last()
            .map_or(0, |&most| most as usize + 1);
        let step = end.div_ceil(LINES).max(1);
        let mut bins = vec![0; end.div_ceil(step)];
        for (&size, &leaves) in &self.leaf_sizes {
            bins[size as usize / step] += leaves;
        }
        let most = bins.iter().copied().max().unwrap_or(0).max(1);
        let line = |(bin, &leaves): (usize, &usize)| {
            let (first, last) = (bin * step, (bin * step + step).min(end) - 1);
            let sizes = if first == last {
                first.to_string()
            } else {
                format!("{first}-{last}")
            };
            let bar = "#".repeat((leaves * 40).div_ceil(most));
            (
                "",
                format!("{sizes:>7} in a leaf {:>11} {bar}", grouped(leaves as u64))
                    .trim_end()
                    .to_owned(),
            )
        };
        bins.iter()
            .enumerate()
            .filter(|(_, leaves)| **leaves > 0)
            .map(line)
            .collect()
    }
}

/// Every different scene in `scene`, and itself, once.
fn scenes_in(scene: &Scene) -> Vec<&Scene> {
    let mut all = vec![scene];
    let mut next = 0;
    while let Some(scene) = all.get(next).copied() {
        for inner in scene.instances().iter().map(|instance| &*instance.scene) {
            if !all.iter().any(|known| std::ptr::eq(*known, inner)) {
                all.push(inner);
            }
        }
        next += 1;
    }
    all
}

/// The numbers of all structures added up; leaf sizes and references of those that hold triangles, and the first SAH cost.
fn all_stats(scene: &Scene) -> Stats {
    let mut sum = scene.stats();
    if scene.nesting() > 0 {
        (sum.references, sum.leaf_sizes) = (0, BTreeMap::new());
    }
    for inner in &scenes_in(scene)[1..] {
        let stats = inner.stats();
        sum.nodes += stats.nodes;
        sum.leaves += stats.leaves;
        sum.max_depth = sum.max_depth.max(stats.max_depth);
        if inner.nesting() == 0 {
            sum.references += stats.references;
            for (size, count) in stats.leaf_sizes {
                *sum.leaf_sizes.entry(size).or_default() += count;
            }
        }
    }
    sum
}

/// Triangles as stored that can never be hit.
fn skipped(scene: &Scene) -> usize {
    let of_triangles = scenes_in(scene).into_iter().filter(|s| s.nesting() == 0);
    of_triangles.map(Scene::skipped).sum()
}

/// In f64: the exact answer for all but extreme coordinates.
fn has_no_area(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.0.map(|corner| corner.map(f64::from));
    let edge = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    let (u, v) = (edge(b), edge(c));
    let cross = [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    cross == [0.0; 3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn collinear_corners_have_no_area() {
        let of = |c: [f32; 3]| Triangle([[1.0, 2.0, 3.5], [2.0, 4.0, 7.0], c]);
        assert!(has_no_area(&of([4.0, 8.0, 14.0])));
        assert!(has_no_area(&of([1.0, 2.0, 3.5])));
        assert!(!has_no_area(&of([4.0, 8.0, 14.000_001])));
    }
}
