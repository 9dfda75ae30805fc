//! A loaded scene, and pictures of it one after the other.

use std::{
    cell::OnceCell,
    time::{Duration, Instant},
};

use anyhow::Context;
use boxwood::Scene;
use boxwood_render::{
    CameraPath, Film, RenderOptions, Session, TileWork, Turntable, View, Watch, scene_hash,
};
use boxwood_scene::Folded;

use super::{Args, plan::Picture, report::Report, write::write};
use crate::{
    args::{CameraChoice, Loaded},
    output::{Output, Trouble, short},
    progress::{Progress, interrupted},
    save,
};

/// All that the pictures of one run share.
pub(super) struct Studio<'a> {
    pub(super) args: &'a Args,
    pub(super) loaded: Loaded<Folded>,
    pub(super) build_time: Duration,
    scene: Scene,
    motion: Motion,
    /// Made when it is asked for.
    hash: OnceCell<String>,
}

/// How the camera gets from frame to frame.
enum Motion {
    Still(View),
    Path(CameraPath),
    Turn(Turntable),
}

/// What became of a picture.
pub(super) struct Made {
    /// None: interrupted, and nothing to show for it.
    pub(super) report: Option<Report>,
    /// Of a picture that is whole.
    pub(super) film: Option<Film>,
    /// If it was interrupted: what is left of it.
    pub(super) interrupted: Option<String>,
}

impl<'a> Studio<'a> {
    /// Loads and builds.
    pub(super) fn open(
        args: &'a Args,
        path: Option<CameraPath>,
        out: &Output,
    ) -> anyhow::Result<Self> {
        let loaded = args.scene.load_folded(out)?;
        if loaded.mesh.triangle_count() == 0 {
            let cause = format!("{}: the scene has no triangles", loaded.name);
            return Err(Trouble::input(cause, "give one that has some").into());
        }
        let (scene, build_time) = args.structure.build_folded(&loaded.mesh)?;
        let motion = Motion::of(args, path, &scene, &loaded)?;
        Ok(Self {
            args,
            loaded,
            build_time,
            scene,
            motion,
            hash: OnceCell::new(),
        })
    }

    /// From where, and what: at a frame. The counts are for EXR layers, for the numbers of the JSON object, and for tiles that may
    /// become an EXR; a PNG has no use for them.
    pub(super) fn prepare(
        &self,
        picture: &Picture,
        counts: bool,
    ) -> anyhow::Result<(View, RenderOptions)> {
        let view = self.view(picture.frame)?;
        let options = RenderOptions {
            counts: counts || save::extension(&picture.output) == "exr",
            light_from: self.light_from()?,
            ..self.args.look.options(&self.scene)
        };
        Ok((view, options))
    }

    /// Between keys that disagree much there may be no camera: better known before the first frame is made.
    pub(super) fn check_cameras(&self, pictures: &[Picture]) -> anyhow::Result<()> {
        let mut frames = pictures.iter().map(|picture| picture.frame);
        frames.try_for_each(|frame| self.view(frame).map(drop))
    }

    fn view(&self, frame: Option<i32>) -> anyhow::Result<View> {
        let frame = frame.unwrap_or(1);
        let camera = match &self.motion {
            Motion::Still(view) => return Ok(*view),
            Motion::Path(path) => path.camera(frame),
            Motion::Turn(turn) => turn.camera(frame),
        };
        let [width, height] = self.args.camera.size;
        View::new(camera, width, height).with_context(|| format!("frame {frame}"))
    }

    /// The light of a flight stays where it is; around a turntable it goes with the camera, as if the scene turned.
    fn light_from(&self) -> anyhow::Result<Option<View>> {
        let first = match &self.motion {
            Motion::Still(_) => return Ok(None),
            Motion::Path(path) => *path.frames().start(),
            Motion::Turn(turn) if turn.is_on_the_spot() => 1,
            Motion::Turn(_) => return Ok(None),
        };
        self.view(Some(first)).map(Some)
    }

    /// Where tiles start.
    pub(super) fn session<'s>(
        &'s self,
        view: &View,
        options: &'s RenderOptions,
    ) -> anyhow::Result<Session<'s>> {
        let surfaces = self.loaded.surfaces();
        Ok(Session::new(&self.scene, surfaces, view, options)?)
    }

    /// Of the scene.
    pub(super) fn hash(&self) -> &str {
        self.hash
            .get_or_init(|| scene_hash(&self.loaded.surfaces()))
    }

    /// At one go. If it is interrupted, what there is of it is written, unless `only_whole`.
    pub(super) fn make(
        &self,
        picture: &Picture,
        only_whole: bool,
        counts: bool,
    ) -> anyhow::Result<Made> {
        let (view, options) = self.prepare(picture, counts)?;
        let start = Instant::now();
        let session = self.session(&view, &options)?;
        let film = session.film()?;
        let tiles: Vec<u32> = (0..film.finished.len() as u32).collect();
        let mut film = expose(&session, film, &tiles, &|_, _| Ok(()))?;
        film.develop(options.shading, options.scale);
        let time = start.elapsed();
        let output = &picture.output;
        let share = film.finished_share();
        if share == 0.0 || (share < 1.0 && only_whole) {
            let before = if share == 0.0 {
                "before the first tile was done"
            } else {
                "on the way"
            };
            return Ok(Made::nothing(format!(
                "interrupted {before}; {output} is not written"
            )));
        }
        write(output, &film, &view.camera(), options.shading.name)?;
        let report = Report::of(self, picture, &view, (&film, film.rays), time);
        Ok(Made {
            interrupted: (share < 1.0).then(|| {
                format!(
                    "interrupted: {output} holds the {:.0} % that were done",
                    share * 100.0
                )
            }),
            report: Some(report),
            film: Some(film),
        })
    }
}

impl Motion {
    fn of(
        args: &Args,
        path: Option<CameraPath>,
        scene: &Scene,
        loaded: &Loaded<Folded>,
    ) -> anyhow::Result<Self> {
        if let Some(path) = path {
            return Ok(Self::Path(path));
        }
        let view = args.camera.view(scene, loaded)?;
        let Some(frames) = args.farm.turntable else {
            return Ok(Self::Still(view));
        };
        let turn = Turntable::new(scene, view.camera(), frames);
        let camera = &args.camera;
        let is_found = match camera.camera {
            Some(CameraChoice::Auto) => true,
            Some(CameraChoice::Number(_)) => false,
            None => loaded.model.cameras.is_empty(),
        };
        let fits = is_found && camera.vp.is_none() && camera.vi.is_none() && camera.fov.is_none();
        Ok(Self::Turn(match fits {
            true => turn.fitted(&loaded.surfaces(), view.width(), view.height()),
            false => turn,
        }))
    }
}

impl Made {
    pub(super) fn nothing(interrupted: String) -> Self {
        Self {
            report: None,
            film: None,
            interrupted: Some(interrupted),
        }
    }
}

/// With progress on stderr; Ctrl-C stops it.
pub(super) fn expose(
    session: &Session<'_>,
    film: Film,
    tiles: &[u32],
    keep: &(dyn Fn(&Film, &TileWork) -> Result<(), boxwood_render::RenderError> + Sync),
) -> anyhow::Result<Film> {
    let progress = Progress::new(u64::from(film.width()) * u64::from(film.height()), "pixels");
    let start = Instant::now();
    let report = |done: boxwood_render::Progress| {
        progress.limit(done.all_pixels);
        progress.set(done.pixels);
        progress.say(format!(
            "{} Mrays/s",
            short(done.rays as f64 / start.elapsed().as_secs_f64() / 1e6)
        ));
    };
    let watch = Watch {
        cancel: Some(interrupted()),
        report: Some(&report),
    };
    Ok(session.expose(film, tiles, watch, keep)?)
}

pub(super) fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}
