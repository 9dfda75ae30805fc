//! A reader's own file, as a model in bytes: what [`Lab::open`](crate::Lab::open) takes.

use boxwood_scene::{Limits, load_bytes};

/// A page has at most 4 GiB.
const LIMITS: Limits = Limits {
    max_file_bytes: 512 << 20,
    max_triangles: 1 << 23,
    max_texture_pixels: 1 << 24,
    max_all_texture_pixels: 1 << 25,
};

/// Reads a file of any format, known by `name` or by its content. Errors are one sentence for the reader.
pub fn read(name: &str, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let model = load_bytes(name, None, bytes, LIMITS).map_err(|error| error.to_string())?;
    if model.triangle_count() == 0 {
        return Err(format!("{name} shows no triangles"));
    }
    postcard::to_allocvec(&model).map_err(|error| format!("{name}: {error}"))
}

#[cfg(target_arch = "wasm32")]
mod door {
    use wasm_bindgen::prelude::*;

    /// [`super::read`] for JavaScript.
    #[wasm_bindgen]
    pub fn read(name: &str, bytes: &[u8]) -> Result<Vec<u8>, JsError> {
        super::read(name, bytes).map_err(|error| JsError::new(&error))
    }
}

#[cfg(all(test, feature = "lab"))]
mod tests {
    use super::*;
    use crate::Lab;

    #[test]
    fn a_file_goes_to_the_lab_with_its_warnings() {
        let triangle = b"mtllib red.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let lab = Lab::open("one.obj", Some(&read("one.obj", triangle).unwrap())).unwrap();
        let seen = lab.seen();
        assert_eq!((seen.name.as_str(), seen.triangles), ("one.obj", 1));
        assert!(seen.warnings[0].contains("red.mtl"), "{:?}", seen.warnings);
    }

    #[test]
    fn colours_places_and_cameras_arrive_whole() {
        for name in ["cornell", "instanced_grove"] {
            let model = boxwood_scene::builtin(name).unwrap();
            let bytes = postcard::to_allocvec(&model).unwrap();
            let arrived: boxwood_scene::Model = postcard::from_bytes(&bytes).unwrap();
            assert_eq!(format!("{arrived:?}"), format!("{model:?}"));
        }
    }

    #[test]
    fn what_cannot_be_shown_is_refused_with_file_and_cause() {
        assert!(read("empty.obj", b"").unwrap_err().contains("no triangles"));
        let broken = read("broken.obj", b"v 0 0 0\nf 1 2 3\n").unwrap_err();
        assert!(broken.starts_with("broken.obj:2:"), "{broken}");
    }
}
