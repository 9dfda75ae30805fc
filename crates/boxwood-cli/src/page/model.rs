//! The scene that the page is to open, read here first: what is wrong with it is said before a browser is asked.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use boxwood_scene::{Limits, LoadError, Model, load_bytes};

use super::query;
use crate::{
    args::{self, SceneArgs},
    output::Output,
    warnings,
};

/// What errors and the page call the bytes of standard input.
const STDIN: &str = "<stdin>";

/// Where the bytes of the model are that the server sends.
#[derive(Debug)]
pub(crate) enum Source {
    /// Read anew for each request, so that a reload shows what has changed.
    File(PathBuf),
    /// Of standard input.
    Bytes(Arc<[u8]>),
}

/// A scene for the page.
#[derive(Debug, Default)]
pub(crate) struct Offer {
    /// What follows the address of the page.
    pub(crate) query: String,
    /// None where the page has the scene itself.
    pub(crate) source: Option<Source>,
}

impl Offer {
    /// The scene called `name`; its warnings are passed on, and that the page cannot have what lies beside its file.
    pub(crate) fn of(name: &str, out: &Output) -> anyhow::Result<Self> {
        if name == "-" {
            let bytes = args::read_stdin()?;
            let model = load_bytes(STDIN, None, &bytes, Limits::default())?;
            warn(&model, out);
            return Ok(Self {
                query: query(STDIN),
                source: Some(Source::Bytes(bytes.into())),
            });
        }
        let scene = SceneArgs {
            file: name.to_owned(),
        };
        let model = scene.model()?;
        warn(&model, out);
        drop(model);
        let is_file = !name.starts_with("builtin:");
        if is_file && lacks_parts(name, &args::read_file(Path::new(name))?) {
            out.warn(format!(
                "{name}: the page gets this file alone, without the files beside it that it names; export it as one .glb to have them in it"
            ));
        }
        Ok(Self {
            query: query(name),
            source: is_file.then(|| Source::File(name.into())),
        })
    }
}

fn warn(model: &Model, out: &Output) {
    for warning in warnings::shortened(&model.warnings) {
        out.warn(warning);
    }
}

/// Whether a scene that can be read wants more than its own `bytes`, which are all that the page has.
fn lacks_parts(name: &str, bytes: &[u8]) -> bool {
    /// The scene's door, which opens nothing here.
    const CLOSED: &str = "is not at hand";
    match load_bytes(name, None, bytes, Limits::default()) {
        Ok(model) => model.warnings.iter().any(|text| text.contains(CLOSED)),
        Err(LoadError { cause, .. }) => cause.contains(CLOSED),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_names_others_lacks_them_on_the_page() {
        let buffer = |uri: &str| {
            format!(
                r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":36,"uri":"{uri}"}}],
                "bufferViews":[{{"buffer":0,"byteLength":36}}],
                "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
                "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
                "nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}],"scene":0}}"#
            )
        };
        let inside = format!("data:application/octet-stream;base64,{}", "AAAA".repeat(12));
        assert!(lacks_parts("a.gltf", buffer("a.bin").as_bytes()));
        assert!(!lacks_parts("a.gltf", buffer(&inside).as_bytes()));
        let triangle = "v 0 0 0\nv 2 0 0\nv 0 3 0.5\nf 1 2 3\n";
        assert!(!lacks_parts("a.obj", triangle.as_bytes()));
        let dressed = format!("mtllib a.mtl\n{triangle}");
        assert!(lacks_parts("a.obj", dressed.as_bytes()));
    }
}
