//! Scenes to measure: one that is named, or all of a list.

use crate::rivals::library;
use anyhow::{Context, Result, anyhow, bail};
use boxwood_scene::{Camera, FlatMesh};
use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// A scene to be loaded.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Input {
    /// For tables.
    pub(crate) name: String,
    /// A file, `builtin:NAME`, or `generate:NAME` of a list.
    pub(crate) file: String,
    /// Where primary rays come from; none: from outside.
    pub(crate) camera: Option<Camera>,
}

/// `X,Y,Z,X,Y,Z,DEGREES`: eye, target, vertical field of view.
pub(crate) fn camera(text: &str) -> Result<Camera, String> {
    let numbers: Option<Vec<f32>> = text
        .split(',')
        .map(|part| part.trim().parse().ok().filter(|x: &f32| x.is_finite()))
        .collect();
    match numbers.as_deref() {
        Some(&[a, b, c, d, e, f, fov]) if (0.0..180.0).contains(&fov) && fov > 0.0 => Ok(Camera {
            eye: [a, b, c],
            target: [d, e, f],
            up: [0.0, 1.0, 0.0],
            fov,
        }),
        _ => Err(
            "seven numbers: eye, target and field of view, as in 3,1.5,1.4,-3.9,1.5,-1.7,90"
                .to_owned(),
        ),
    }
}

/// The scenes of a list: lines of name, file and camera (or none), a tab between them, below a line of titles. Files are meant
/// from the list's folder.
pub(crate) fn list(path: &Path) -> Result<Vec<Input>> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("{}: cannot be read", path.display()))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let line = |(number, line): (usize, &str)| {
        let place = || format!("{}:{}", path.display(), number + 1);
        let fields: Vec<&str> = line.split('\t').collect();
        let [name, file, rest @ ..] = &*fields else {
            bail!(
                "{}: is not name, file and camera with tabs between them",
                place()
            );
        };
        let camera = match rest.first().map(|text| text.trim()) {
            None | Some("") => None,
            Some(text) => Some(camera(text).map_err(|cause| anyhow!("{}: {cause}", place()))?),
        };
        let is_path = !file.starts_with("generate:") && !file.starts_with("builtin:");
        let file = if is_path {
            folder.join(file).display().to_string()
        } else {
            (*file).to_owned()
        };
        Ok(Input {
            name: (*name).to_owned(),
            file,
            camera,
        })
    };
    let lines = text
        .lines()
        .enumerate()
        .skip(1)
        .filter(|(_, line)| !line.trim().is_empty());
    lines.map(line).collect()
}

impl Input {
    /// Loads the scene; what is generated comes from the generator beside the list in `folder`.
    pub(crate) fn load(&self, folder: &Path) -> Result<FlatMesh> {
        let file = match self.file.strip_prefix("generate:") {
            Some(name) => generated(name, folder)?.display().to_string(),
            None => self.file.clone(),
        };
        Ok(boxwood_scene::open(&file)?.flatten()?)
    }
}

/// The file of a generated scene, made if it is not there.
fn generated(name: &str, folder: &Path) -> Result<PathBuf> {
    let generator = folder.join("generate/generate.py");
    if !generator.is_file() {
        bail!(
            "generate:{name}: there is no generator {}",
            generator.display()
        );
    }
    let made = library::environment().with_file_name("generated");
    std::fs::create_dir_all(&made)?;
    let path = made.join(format!("{name}.ply"));
    if !path.is_file() {
        let unfinished = path.with_extension("part");
        let python = python_with_numpy().context("the generator wants Python with numpy")?;
        library::run(
            Command::new(python)
                .arg(generator)
                .arg(name)
                .arg(&unfinished),
        )?;
        std::fs::rename(&unfinished, &path)?;
    }
    Ok(path)
}

/// The system's, else one of our own.
fn python_with_numpy() -> Result<PathBuf> {
    let has_numpy = |python: &Path| {
        let output = Command::new(python).args(["-c", "import numpy"]).output();
        output.is_ok_and(|output| output.status.success())
    };
    let (system, own) = (
        PathBuf::from("python3"),
        library::environment().join("bin/python"),
    );
    if let Some(python) = [&system, &own].into_iter().find(|python| has_numpy(python)) {
        return Ok(python.clone());
    }
    if !own.is_file() {
        library::run(
            Command::new("python3")
                .args(["-m", "venv"])
                .arg(library::environment()),
        )?;
    }
    library::run(Command::new(own.with_file_name("pip")).args(["install", "--quiet", "numpy"]))?;
    Ok(own)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_has_scenes_with_and_without_a_camera() {
        let path = std::env::temp_dir().join(format!("boxwood-list-{}.tsv", std::process::id()));
        let text = "name\tfile\tcamera\nbunny\ta/bunny.obj\t\nhall\tb.obj\t1,2,3,4,5,6,70\nhair\tgenerate:hair\n";
        std::fs::write(&path, text).unwrap();
        let scenes = list(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(scenes.len(), 3);
        assert!(scenes[0].file.ends_with("bunny.obj") && scenes[0].camera.is_none());
        let camera = scenes[1].camera.unwrap();
        assert_eq!(
            (camera.eye, camera.target, camera.fov),
            ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], 70.0)
        );
        assert_eq!(scenes[2].file, "generate:hair");
        assert!(
            scenes[2]
                .load(Path::new("/nowhere"))
                .unwrap_err()
                .to_string()
                .contains("no generator")
        );
    }

    #[test]
    fn a_camera_is_seven_numbers() {
        for wrong in [
            "",
            "1,2,3",
            "1,2,3,4,5,6,0",
            "1,2,3,4,5,6,200",
            "1,2,3,4,5,6,x",
        ] {
            assert!(camera(wrong).is_err(), "{wrong}");
        }
    }
}
