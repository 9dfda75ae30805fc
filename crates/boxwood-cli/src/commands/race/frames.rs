//! `boxwood race --frames`: who draws the most frames a second.

use std::time::Duration;

use boxwood::Scene;
use boxwood_render::View;
use serde::Serialize;

use crate::{
    args::Loaded,
    contest::Built,
    frame_rate::{FrameRate, frame_rates},
    output::{Table, counted, grouped, mebibytes, short},
};

/// The JSON object.
#[derive(Serialize)]
pub(super) struct Answer {
    file: String,
    triangles: usize,
    width: u32,
    height: u32,
    threads: usize,
    /// Of each frame.
    camera_rays: u64,
    shadow_rays: u64,
    /// In every byte.
    pub(super) same_picture: bool,
    structures: Vec<Row>,
}

/// One structure.
#[derive(Serialize)]
struct Row {
    name: String,
    build_ms: f64,
    bytes: usize,
    ms_per_frame: f64,
    frames_per_second: f64,
    /// Camera and shadow rays, shading included.
    mrays_per_second: f64,
    /// Of the threads' time, 0 to 1.
    query_share: f64,
    /// As the first one's.
    same_picture: bool,
}

/// For all structures together.
const PATIENCE: Duration = Duration::from_secs(4);

/// Draws in turns with all that were built.
pub(super) fn race(loaded: &Loaded, built: &[&Built], view: &View) -> Answer {
    let scenes: Vec<&Scene> = built.iter().map(|built| &built.scene).collect();
    let rates = frame_rates(&scenes, loaded.surfaces(), view, PATIENCE);
    let structures: Vec<Row> = built
        .iter()
        .zip(&rates)
        .map(|(built, rate)| row(built, rate, &rates[0]))
        .collect();
    let rays = rates.first().map(|rate| rate.rays).unwrap_or_default();
    Answer {
        file: loaded.name.clone(),
        triangles: loaded.mesh.indices.len(),
        width: view.width(),
        height: view.height(),
        threads: rayon::current_num_threads(),
        camera_rays: rays.camera,
        shadow_rays: rays.shadow,
        same_picture: structures.iter().all(|row| row.same_picture),
        structures,
    }
}

fn row(built: &Built, rate: &FrameRate, first: &FrameRate) -> Row {
    Row {
        name: built.name.clone(),
        build_ms: built.time.as_secs_f64() * 1e3,
        bytes: built.scene.stats().bytes,
        ms_per_frame: rate.frame.as_secs_f64() * 1e3,
        frames_per_second: rate.per_second(),
        mrays_per_second: rate.mrays_per_second(),
        query_share: rate.query_share,
        same_picture: rate.picture == first.picture,
    }
}

/// For people.
pub(super) fn text(answer: &Answer) -> String {
    let mut table = Table::new([
        "structure",
        "build ms",
        "MiB",
        "ms/frame",
        "frames/s",
        "Mrays/s",
        "in queries",
        "same picture",
    ]);
    for row in &answer.structures {
        table.row([
            row.name.clone(),
            short(row.build_ms),
            mebibytes(row.bytes),
            short(row.ms_per_frame),
            short(row.frames_per_second),
            short(row.mrays_per_second),
            format!("{:.0} %", row.query_share * 100.0),
            if row.same_picture { "yes" } else { "NO" }.to_owned(),
        ]);
    }
    format!(
        "{}: {}; frames of {}x{}: {} camera rays, {} shadow rays, flat shading; {}\n\n{table}",
        answer.file,
        counted(answer.triangles, "triangle"),
        answer.width,
        answer.height,
        grouped(answer.camera_rays),
        grouped(answer.shadow_rays),
        counted(answer.threads, "thread"),
    )
}
