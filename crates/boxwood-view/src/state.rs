//! What a viewer remembers from one time to the next.

use std::{
    fs::{self, File},
    io::{self, Read},
    path::Path,
};

use boxwood_render::{RenderError, View, save_atomically};
use boxwood_scene::Camera;
use serde::{Deserialize, Serialize};

use crate::{Aim, Matter, ViewError, app::MAX_PIXELS};

/// Everything that is restored. Numbers that a file leaves out are as usual.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct State {
    /// Of this format: 1.
    pub version: u32,
    /// As the user named it.
    pub file: Option<String>,
    /// From [`boxwood::STRUCTURES`].
    pub structure: Option<String>,
    /// `sun`, or from [`boxwood_render::SHADINGS`].
    pub look: Option<String>,
    /// View point.
    pub vp: Option<[f32; 3]>,
    /// Point of interest.
    pub vi: Option<[f32; 3]>,
    /// Up.
    pub vu: Option<[f32; 3]>,
    /// Vertical field of view in degrees.
    pub fov: Option<f32>,
    /// Width and height of the window.
    pub size: Option<[u32; 2]>,
    /// Whether costs are coloured by the logarithm.
    pub log: bool,
}

const VERSION: u32 = 1;
/// Longest state file that is read.
const MAX_BYTES: u64 = 1 << 20;

impl State {
    /// Reads a state file; none if there is no such file yet.
    ///
    /// # Errors
    /// If it cannot be read, is no state of this version, or holds a camera or a size that cannot be had.
    pub fn load(path: &Path) -> Result<Option<Self>, ViewError> {
        let refused = |cause: &dyn std::fmt::Display| {
            let error = ViewError::new(Matter::State, format!("{}: {cause}", path.display()));
            error.with_remedy("name another file, or remove it")
        };
        let bytes = match read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(refused(&error)),
        };
        let state: Self = serde_json::from_slice(&bytes).map_err(|error| refused(&error))?;
        state.check().map_err(|cause| refused(&cause))?;
        Ok(Some(state))
    }

    /// What the viewer could not begin with.
    fn check(&self) -> Result<(), String> {
        if self.version != VERSION {
            return Err(format!(
                "version {}, where {VERSION} is known",
                self.version
            ));
        }
        if let Some([width, height]) = self.size
            && u64::from(width) * u64::from(height) > MAX_PIXELS
        {
            return Err(format!(
                "a size of {width} x {height} is more than {MAX_PIXELS} pixels"
            ));
        }
        if let (Some(eye), Some(target), Some(up), Some(fov)) =
            (self.vp, self.vi, self.vu, self.fov)
        {
            let camera = Camera {
                eye,
                target,
                up,
                fov,
            };
            View::new(camera, 2, 2).map_err(|error| error.to_string())?;
        }
        Ok(())
    }

    /// Writes it as JSON: the file is replaced as a whole or not at all.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), ViewError> {
        let state = Self {
            version: VERSION,
            ..self.clone()
        };
        let failed = |cause: String| RenderError::Encode {
            format: "JSON",
            cause,
        };
        save_atomically(path, |out| {
            serde_json::to_writer_pretty(&mut *out, &state)
                .map_err(|error| failed(error.to_string()))?;
            writeln!(out).map_err(|error| failed(error.to_string()))
        })
        .map_err(|error| ViewError::output(path, error))
    }

    /// The camera, as far as it is known.
    pub fn aim(&self) -> Aim {
        Aim {
            eye: self.vp,
            target: self.vi,
            up: self.vu,
            fov: self.fov,
            ..Aim::default()
        }
    }

    /// Remembers the camera.
    pub(crate) fn set_camera(&mut self, camera: &Camera) {
        self.vp = Some(camera.eye);
        self.vi = Some(camera.target);
        self.vu = Some(camera.up);
        self.fov = Some(camera.fov);
    }
}

/// A plain file that is not too long: others may have no end.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::other("is not a regular file"));
    }
    let mut bytes = Vec::new();
    File::open(path)?
        .take(MAX_BYTES + 1)
        .read_to_end(&mut bytes)?;
    match bytes.len() as u64 > MAX_BYTES {
        true => Err(io::Error::other(format!("more than {MAX_BYTES} bytes"))),
        false => Ok(bytes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_comes_back_as_it_was_saved() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("view.json");
        assert_eq!(State::load(&path).unwrap(), None);
        let mut state = State {
            version: VERSION,
            file: Some("builtin:bush".to_owned()),
            look: Some("ao".to_owned()),
            size: Some([640, 360]),
            ..State::default()
        };
        let camera = Camera {
            eye: [1.0, -2.5, 1e-7],
            target: [0.1, 0.2, 0.3],
            up: [0.0, 0.0, 1.0],
            fov: 35.5,
        };
        state.set_camera(&camera);
        state.save(&path).unwrap();
        let loaded = State::load(&path).unwrap().unwrap();
        assert_eq!((loaded.aim(), &loaded), (Aim::at(&camera), &state));
    }

    #[test]
    fn a_state_that_cannot_be_written_leaves_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("view.json");
        State::default().save(&path).unwrap();
        let error = State::default()
            .save(&folder.path().join("no/such.json"))
            .unwrap_err();
        assert_eq!(error.kind, Matter::Output);
        assert!(error.to_string().contains("no/such.json: "), "{error}");
        let names = fs::read_dir(folder.path()).unwrap();
        assert_eq!(names.count(), 1, "nothing is left beside it");
    }

    #[test]
    fn what_is_no_plain_small_file_is_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let large = folder.path().join("large.json");
        fs::write(&large, vec![b' '; MAX_BYTES as usize + 1]).unwrap();
        let error = State::load(&large).unwrap_err();
        assert!(error.cause.contains("more than 1048576 bytes"), "{error}");
        let error = State::load(folder.path()).unwrap_err();
        assert!(error.cause.contains("not a regular file"), "{error}");
        #[cfg(unix)]
        assert!(State::load(Path::new("/dev/zero")).is_err());
    }

    #[test]
    fn damaged_and_future_states_are_refused_with_the_name_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("view.json");
        for text in [
            "",
            "{",
            "{\"version\": 2}",
            "{\"version\": 1, \"colour\": 3}",
            "{\"version\": 1, \"size\": [4000000000, 4000000000]}",
            "{\"version\": 1, \"vp\": [1, 2, 3], \"vi\": [1, 2, 3], \"vu\": [0, 1, 0], \"fov\": 35}",
        ] {
            fs::write(&path, text).unwrap();
            let error = State::load(&path).unwrap_err();
            assert_eq!(error.kind, Matter::State);
            assert!(error.cause.contains("view.json: "), "{error}");
        }
    }
}
