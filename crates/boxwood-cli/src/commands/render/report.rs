//! What a render says of what it made.

use std::time::Duration;

use boxwood_render::{Film, View};
use serde::Serialize;

use super::{
    plan::Picture,
    studio::{Studio, milliseconds},
};
use crate::{
    args::camera_flags,
    output::{counted, grouped, short},
};

/// One picture, in the words of the JSON object.
#[derive(Serialize)]
pub(super) struct Report {
    file: String,
    /// The file of tiles, for a shard.
    pub(super) output: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<i32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) shard: Option<String>,
    /// Taken over from an earlier run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) resumed_tiles: Option<usize>,
    triangles: u64,
    shading: &'static str,
    structure: String,
    camera: String,
    width: u32,
    height: u32,
    samples: u32,
    seed: u64,
    pub(super) complete: bool,
    load_ms: f64,
    build_ms: f64,
    render_ms: f64,
    rays: u64,
    mrays_per_second: f64,
    box_tests_per_camera_ray: f64,
    primitive_tests_per_camera_ray: f64,
}

impl Report {
    /// Of a film for which so many `rays` were shot in `time`: other tiles may be taken over.
    pub(super) fn of(
        studio: &Studio<'_>,
        picture: &Picture,
        view: &View,
        (film, rays): (&Film, u64),
        time: Duration,
    ) -> Self {
        let per_ray = |count: u64| count as f64 / film.counts.rays.max(1) as f64;
        let look = &studio.args.look;
        Self {
            file: studio.loaded.name.clone(),
            output: picture.output.clone(),
            frame: picture.frame,
            shard: None,
            resumed_tiles: None,
            triangles: studio.loaded.mesh.triangle_count(),
            shading: look.shading.name,
            structure: studio.args.structure.label(),
            camera: camera_flags(&view.camera()),
            width: film.width(),
            height: film.height(),
            samples: look.spp.unwrap_or(look.shading.samples),
            seed: look.seed,
            complete: film.is_complete(),
            load_ms: milliseconds(studio.loaded.time),
            build_ms: milliseconds(studio.build_time),
            render_ms: milliseconds(time),
            rays,
            mrays_per_second: rays as f64 / time.as_secs_f64().max(1e-9) / 1e6,
            box_tests_per_camera_ray: per_ray(film.counts.boxes),
            primitive_tests_per_camera_ray: per_ray(film.counts.prims),
        }
    }

    /// For people.
    pub(super) fn text(&self) -> String {
        let Self {
            output,
            width,
            height,
            shading,
            samples,
            structure,
            ..
        } = self;
        let share = match &self.shard {
            Some(shard) => format!("shard {shard} of "),
            None => String::new(),
        };
        format!(
            "{output}: {share}{width}x{height}, {shading}, {samples} per pixel; {} in {structure}\n\
             loaded in {} ms, built in {} ms, {} rays in {} ms ({} Mrays/s)\ncamera {}",
            counted(self.triangles as usize, "triangle"),
            short(self.load_ms),
            short(self.build_ms),
            grouped(self.rays),
            short(self.render_ms),
            short(self.mrays_per_second),
            self.camera,
        )
    }

    /// One of many.
    pub(super) fn line(&self) -> String {
        format!(
            "{}: {} rays in {} ms",
            self.output,
            grouped(self.rays),
            short(self.render_ms)
        )
    }
}

/// Many pictures.
#[derive(Serialize)]
pub(super) struct SeriesReport<'a> {
    pub(super) frames: Vec<Report>,
    /// Files that were there.
    pub(super) skipped: &'a [String],
    /// False after an interruption.
    pub(super) complete: bool,
}
