//! `boxwood view`: look at a scene and move through it.

use std::{
    path::PathBuf,
    sync::{Arc, atomic::Ordering},
};

use boxwood::Structure;
use boxwood_render::Shading;
use boxwood_scene::{FlatMesh, Model};
use boxwood_view::{
    Aim, App, MAX_PIXELS, Matter, Options, Report, Script, State, ViewError, Wish, run_headless,
    run_window,
};
use serde::Serialize;

use crate::{
    args::{self, CameraArgs, CameraChoice, SceneArgs, StructureArgs, camera_flags},
    output::{Exit, Output, Table, Trouble, grouped, short},
    page::{Offer, Page, Server},
    progress::interrupted,
    warnings,
};

/// Look at a scene and move through it, at 30 frames a second and more on the processor alone; `h` shows all keys.
///
/// Resolution gives way while the camera moves, and fills in when it stands still. `1` to `6` switch the structure, F9 to
/// F12 show what each pixel costs, `p` and `.` follow a ray through the boxes. A file that changes is read again.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  boxwood view
  boxwood view builtin:stadium --shading heat-tests --structure grid
  boxwood view builtin:cornell --shading path --size 800x800
  boxwood view builtin:bush --headless
  boxwood view --web model.glb

A script has a step per line: orbit FRAMES [DEGREES], rise FRAMES DEGREES, zoom FRAMES FACTOR, fly FRAMES SHARE,
turn FRAMES DEGREES, still FRAMES, wait [SECONDS], key NAME, point X Y (shares of the window), shot FILE.")]
pub(crate) struct Args {
    /// Scene: a file, or builtin:NAME. [default: as in the state file, else builtin:bush]
    #[arg(value_name = "FILE", value_parser = args::file_name)]
    file: Option<String>,
    /// `sun`, or a shading (`boxwood list`). [default: sun]
    #[arg(long, value_name = "NAME", value_parser = look)]
    shading: Option<String>,
    /// Begin as in this file, and write it in the end, also after Ctrl+C.
    #[arg(long, value_name = "FILE")]
    state: Option<PathBuf>,
    /// Follow a script, print how many frames a second that gave, and end.
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    /// Without a window; without a script, twice round the scene.
    #[arg(long)]
    headless: bool,
    /// Open the scene on the page that teaches, in a browser: serves it to this machine alone until Ctrl+C.
    #[arg(long, conflicts_with_all = ["headless", "script", "state"])]
    web: bool,
    /// With --web: the folder of the page, as `cargo xtask web` builds it. [default: the page in this program]
    #[arg(long, value_name = "FOLDER", requires = "web")]
    page: Option<PathBuf>,
    /// With --web: port of 127.0.0.1; 0 is any that is free.
    #[arg(long, value_name = "N", requires = "web", default_value_t = 0)]
    port: u16,
    #[command(flatten)]
    structure: StructureArgs,
    #[command(flatten)]
    camera: CameraArgs,
}

const SUN: &str = "sun";
const DEFAULT_SIZE: [u32; 2] = [1280, 720];

fn look(name: &str) -> Result<String, String> {
    let known = Shading::named(name).map(|shading| shading.name);
    let name = if name == SUN { Ok(SUN) } else { known };
    name.map(str::to_owned).map_err(|error| error.to_string())
}

/// The JSON object.
#[derive(Serialize)]
struct Answer {
    file: String,
    structure: String,
    width: u32,
    height: u32,
    threads: usize,
    #[serde(flatten)]
    report: Report,
}

/// The JSON object of `--web`.
#[derive(Serialize)]
struct Served {
    url: String,
}

/// Serves the page with the scene until the program is ended.
fn serve(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let page = Page::find(args.page.as_deref())?;
    let offer = match &args.file {
        Some(name) => Offer::of(name, out)?,
        None => Offer::default(),
    };
    let server = Server::bind(page, offer.source, args.port).map_err(|error| {
        let cause = format!(
            "port {} of 127.0.0.1 cannot be listened to: {error}",
            args.port
        );
        Trouble::usage(cause, "name another --port, or none")
    })?;
    let url = server.url() + &offer.query;
    match out.is_json() {
        true => out.json(&Served { url })?,
        false => out.text(format!("the page is at {url} until you press Ctrl+C"))?,
    }
    server.run()?;
    Ok(Exit::Ok)
}

/// Opens the window, or follows the script without one.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    if args.web {
        return serve(args, out);
    }
    let script = args.script()?;
    let remembered = match &args.state {
        Some(path) => State::load(path).map_err(refused)?.unwrap_or_default(),
        None => State::default(),
    };
    let options = args.options(remembered)?;
    let mut answer = Answer {
        file: options.file.clone(),
        structure: options.structure.name.to_owned(),
        width: 0,
        height: 0,
        threads: rayon::current_num_threads(),
        report: Report::default(),
    };
    let mut heed = |wish| match wish {
        // Standard output may be closed; the viewer goes on.
        Wish::Print(line) if !out.is_json() => drop(out.text(line)),
        Wish::Print(line) => out.note(line),
        Wish::Warn(line) => out.warn(line),
        Wish::ToggleFullScreen | Wish::Quit => {}
    };
    let is_scripted = args.headless || script.is_some();
    let (state, report) = if args.headless {
        let mut app = App::new(options);
        let report = run_headless(&mut app, script.unwrap_or_default(), &mut heed);
        (app.state(), report.map_err(refused)?)
    } else {
        run_window(options, script, &mut heed).map_err(refused)?
    };
    // As large as it came to be.
    [answer.width, answer.height] = state.size.unwrap_or_default();
    answer.report = report;
    // What was measured is told before anything else can fail; and the state is saved whoever listens.
    let told = match is_scripted {
        true => answer.tell(out),
        false => Ok(()),
    };
    if let Some(path) = &args.state {
        state.save(path).map_err(refused)?;
    }
    told?;
    Ok(match is_scripted && is_interrupted() {
        true => Exit::Interrupted,
        false => Exit::Ok,
    })
}

/// Ctrl+C and its like end the viewer as its key does.
fn is_interrupted() -> bool {
    interrupted().load(Ordering::Relaxed)
}

/// What failed, and what to do instead.
fn refused(error: ViewError) -> anyhow::Error {
    let ViewError {
        kind,
        cause,
        remedy,
    } = error;
    let remedy = remedy.unwrap_or_else(|| "name another file".to_owned());
    let trouble = match kind {
        Matter::Scene | Matter::State => Trouble::input(cause, remedy),
        Matter::Window => Trouble::usage(
            cause,
            "without a screen, `boxwood render` makes pictures, and --headless follows scripts",
        ),
        Matter::Camera | Matter::Script | Matter::Output => Trouble::usage(cause, remedy),
    };
    trouble.into()
}

impl Args {
    fn script(&self) -> anyhow::Result<Option<Script>> {
        let Some(path) = &self.script else {
            return Ok(None);
        };
        let text = String::from_utf8_lossy(&args::read_file(path)?).into_owned();
        let script = Script::parse(&path.display().to_string(), &text).map_err(refused)?;
        Ok(Some(script))
    }

    /// What was typed, over what is remembered, over what is usual.
    fn options(&self, remembered: State) -> anyhow::Result<Options> {
        let file = self.file.clone().or_else(|| remembered.file.clone());
        // Another scene wants another camera.
        let aim = match self.file.is_none() || self.file == remembered.file {
            true => remembered.aim(),
            false => Aim::default(),
        };
        let typed = &self.camera;
        let aim = Aim {
            auto: typed.camera == Some(CameraChoice::Auto),
            number: match typed.camera {
                Some(CameraChoice::Number(number)) => Some(number),
                _ => None,
            },
            eye: typed.vp.or(aim.eye),
            target: typed.vi.or(aim.target),
            up: typed.vu.or(aim.up),
            fov: typed.fov.or(aim.fov),
        };
        let structure = remembered
            .structure
            .as_deref()
            .and_then(|name| Structure::named(name).ok());
        let is_usual = self.structure.structure.name == Structure::DEFAULT;
        let look = self.shading.clone().or_else(|| remembered.look.clone());
        Ok(Options {
            file: file.unwrap_or_else(|| "builtin:bush".to_owned()),
            open: Arc::new(open),
            structure: structure
                .filter(|_| is_usual)
                .unwrap_or(self.structure.structure),
            build: self.structure.options(),
            aim,
            look: look.unwrap_or_else(|| SUN.to_owned()),
            log: remembered.log,
            size: match remembered.size {
                Some(size) if typed.size == DEFAULT_SIZE => size,
                _ => held(typed.size)?,
            },
            remembered,
            folder: PathBuf::from("."),
            camera_flags,
            wake: Arc::new(|| {}),
            stop: is_interrupted,
        })
    }
}

/// A size that the viewer can have.
fn held(size: [u32; 2]) -> anyhow::Result<[u32; 2]> {
    let [width, height] = size;
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        let most = grouped(MAX_PIXELS);
        let cause = format!("--size {width}x{height} is more than {most} pixels");
        return Err(Trouble::usage(cause, "choose a smaller --size").into());
    }
    Ok(size)
}

/// As all commands read scenes, within the memory that there is.
fn open(name: &str) -> Result<(Model, FlatMesh), String> {
    let scene = SceneArgs {
        file: name.to_owned(),
    };
    let mut loaded = scene.load_quietly().map_err(|error| error.to_string())?;
    loaded.model.warnings = warnings::shortened(&loaded.model.warnings);
    Ok((loaded.model, loaded.mesh))
}

impl Answer {
    fn tell(&self, out: &Output) -> anyhow::Result<()> {
        match out.is_json() {
            true => out.json(self),
            false => out.text(self.text()),
        }
    }

    fn text(&self) -> String {
        let Self {
            file,
            structure,
            width,
            height,
            threads,
            report,
        } = self;
        let mut table = Table::new(["", "frames", "per second", "worst 1 %", "pixels"]);
        for row in &report.rows {
            table.row([
                row.what.clone(),
                row.frames.to_string(),
                short(row.mean_per_second),
                short(row.worst_per_second),
                format!("{:.0} %", row.pixels * 100.0),
            ]);
        }
        format!(
            "{file}: {structure}, {width} x {height}, {threads} threads; first picture after {} ms\n\n{table}",
            short(report.first_picture_ms)
        )
    }
}
