//! What a viewer remembers from one time to the next.

use std::{fs, io, path::Path};

use boxwood_scene::Camera;
use serde::{Deserialize, Serialize};

use crate::{Aim, ViewError};

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

impl State {
    /// Reads a state file; none if there is no such file yet.
    ///
    /// # Errors
    /// If it cannot be read, or is no state of this version.
    pub fn load(path: &Path) -> Result<Option<Self>, ViewError> {
        let bytes = match fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(ViewError::file(path, error)),
        };
        let state: Self =
            serde_json::from_slice(&bytes).map_err(|error| ViewError::file(path, error))?;
        if state.version != VERSION {
            let cause = format!("version {}, where {VERSION} is known", state.version);
            return Err(ViewError::file(path, cause));
        }
        Ok(Some(state))
    }

    /// Writes it as JSON.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), ViewError> {
        let state = Self {
            version: VERSION,
            ..self.clone()
        };
        let text =
            serde_json::to_string_pretty(&state).map_err(|error| ViewError::file(path, error))?;
        fs::write(path, text + "\n").map_err(|error| ViewError::file(path, error))
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
    fn damaged_and_future_states_are_refused_with_the_name_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("view.json");
        for text in [
            "",
            "{",
            "{\"version\": 2}",
            "{\"version\": 1, \"colour\": 3}",
        ] {
            fs::write(&path, text).unwrap();
            let message = State::load(&path).unwrap_err().to_string();
            assert!(message.contains("view.json"), "{message}");
        }
    }
}
