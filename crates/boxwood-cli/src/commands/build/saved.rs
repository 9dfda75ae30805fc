//! `boxwood build -o`: the scene as a file.

use std::time::{Duration, Instant};

use boxwood::{AlignedBytes, FileCause, FileError, Scene};
use boxwood_render::RenderError;
use boxwood_scene::{FlatMesh, with_vertices};
use serde::Serialize;

use crate::output::{Trouble, short, size};
use crate::save;

/// What was saved.
#[derive(Serialize)]
pub(super) struct Saved {
    file: String,
    bytes: usize,
    hash: String,
    save_ms: f64,
    open_ms: f64,
}

/// Saves the scene of `mesh` to the file called `name`, once the bytes have been opened again.
pub(super) fn save(scene: Scene, mesh: &FlatMesh, name: &str) -> anyhow::Result<Saved> {
    let scene = with_vertices(scene, mesh);
    let start = Instant::now();
    let mut bytes = Vec::new();
    let hash = scene.save(&mut bytes).map_err(refused)?;
    let written = start.elapsed();
    // Before a file that is good gives way to them.
    let start = Instant::now();
    Scene::open_bytes(AlignedBytes::copy(&bytes)?)?;
    let opened = start.elapsed();
    let start = Instant::now();
    save::save(name, |to| {
        to.write_all(&bytes).map_err(|error| RenderError::Encode {
            format: "BWX",
            cause: error.to_string(),
        })
    })?;
    let in_ms = |time: Duration| time.as_secs_f64() * 1e3;
    Ok(Saved {
        file: name.to_owned(),
        bytes: bytes.len(),
        hash: hash.to_string(),
        save_ms: in_ms(written + start.elapsed()),
        open_ms: in_ms(opened),
    })
}

/// What cannot be saved was asked for by the command line.
fn refused(error: FileError) -> anyhow::Error {
    match &error.cause {
        FileCause::NotSaved { what } => Trouble::usage(
            format!("a scene of {what} is not saved"),
            "leave --structure out: `wide` is saved",
        )
        .into(),
        _ => error.into(),
    }
}

impl Saved {
    pub(super) fn text(&self) -> String {
        let [save, open] = [self.save_ms, self.open_ms].map(short);
        let (file, bytes) = (&self.file, size(self.bytes));
        format!(
            "{file}: {bytes}, saved in {save} ms, opened again in {open} ms\n{}",
            self.hash
        )
    }
}
