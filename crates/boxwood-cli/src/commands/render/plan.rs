//! Which pictures are to be made by this process: frames, names of files, shares.

use std::{collections::HashSet, path::Path};

use boxwood_render::{CameraPath, Shard};
use serde::Serialize;

use super::{
    frames::{FrameList, MAX_FRAMES},
    share::ShardChoice,
    template::Template,
};
use crate::{
    args,
    output::{Output, Trouble},
    save,
};

/// Many pictures, and many processes.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Frames and farms (docs/farm/README.md)")]
pub(super) struct FarmArgs {
    /// Camera path: key frames in JSON. Without --frame or --frames, all its frames.
    #[arg(long, value_name = "FILE", value_parser = args::file_name, conflicts_with_all = ["turntable", "vp", "vi", "vu", "fov", "camera"])]
    path: Option<String>,
    /// Once around the scene in this many frames, from the camera that there would be. Without --frame or --frames, all of them.
    #[arg(long, visible_alias = "orbit", value_name = "FRAMES", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=MAX_FRAMES as i64))]
    pub(super) turntable: Option<u32>,
    /// Only this frame. The output's name may have it: shot.{frame:04}.png, or shot.####.png.
    #[arg(
        long,
        value_name = "N",
        allow_negative_numbers = true,
        conflicts_with = "frames"
    )]
    frame: Option<i32>,
    /// These frames, one after the other: 1-240, 1-240x2, 1,5,7-9.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<FrameList>,
    /// Leave out pictures that are there. Frames are there only when they are complete.
    #[arg(long)]
    skip_existing: bool,
    /// Keep finished tiles beside the output (OUTPUT.tiles) until it is written: the same command goes on after any end.
    #[arg(long)]
    pub(super) resume: bool,
    /// Only this share: of a list every N-th frame, of one picture every N-th tile, kept in OUTPUT.IofN.part for
    /// `boxwood merge`. auto: as Slurm or Kubernetes say.
    #[arg(long, value_name = "I/N|auto", allow_hyphen_values = true)]
    shard: Option<ShardChoice>,
    /// Print what would be made, and make nothing.
    #[arg(long)]
    pub(super) dry_run: bool,
}

/// One file to be made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Picture {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) frame: Option<i32>,
    pub(super) output: String,
}

/// What this process is to do.
#[derive(Debug)]
pub(super) struct Plan {
    /// In this order.
    pub(super) pictures: Vec<Picture>,
    /// Files that are there.
    pub(super) skipped: Vec<String>,
    /// A list of frames, however long.
    pub(super) is_series: bool,
    /// Of the tiles of the one picture.
    pub(super) shard: Option<Shard>,
    /// How the camera moves, if by a file.
    pub(super) path: Option<CameraPath>,
    /// Interrupted pictures are not written: a frame, or what is to be left out when it is there, is whole or not there.
    pub(super) only_whole: bool,
}

impl FarmArgs {
    /// Whether names of files want a place for the frame.
    pub(super) fn has_frames(&self) -> bool {
        self.frame.is_some()
            || self.frames.is_some()
            || self.path.is_some()
            || self.turntable.is_some()
    }

    /// Checks all that can be known before the scene is loaded.
    pub(super) fn plan(&self, output: &str, out: &Output) -> anyhow::Result<Plan> {
        let path = self.path.as_deref().map(read_path).transpose()?;
        let shard = self
            .shard
            .map(|choice| choice.resolve(&|name| std::env::var(name).ok()))
            .transpose()?;
        let list = self.list(path.as_ref())?;
        let is_series = list.is_some();
        let mut pictures = match list {
            Some(frames) => named(output, frames)?,
            None => vec![self.single(output)?],
        };
        if let (true, Some(shard)) = (is_series, shard) {
            let mut index = 0..;
            pictures.retain(|_| index.next().is_some_and(|index| shard.has(index)));
        }
        let (there, pictures) = pictures
            .into_iter()
            .partition(|picture: &Picture| self.skip_existing && is_there(&picture.output));
        let plan = Plan {
            pictures,
            skipped: there.into_iter().map(|picture| picture.output).collect(),
            is_series,
            shard: shard.filter(|_| !is_series),
            path,
            only_whole: self.has_frames() || self.skip_existing,
        };
        self.check(&plan, out)?;
        Ok(plan)
    }

    /// The frames of a list, of the path or of the turn; none for one picture.
    fn list(&self, path: Option<&CameraPath>) -> anyhow::Result<Option<Vec<i32>>> {
        let named = self.frames.as_ref().map(|list| &*list.0);
        if let Some(path) = path {
            on_path(path, self.frame.as_slice())?;
            on_path(path, named.unwrap_or_default())?;
        }
        if self.frame.is_some() {
            return Ok(None);
        }
        let moves = path.is_some() || self.turntable.is_some();
        match (named, path, self.turntable) {
            (Some([_, _, ..]), ..) if !moves => Err(Trouble::usage(
                "nothing moves: all frames would be the same picture",
                "move the camera with --path FILE or --turntable FRAMES, or ask for one --frame",
            )
            .into()),
            (Some(frames), ..) => Ok(Some(frames.to_vec())),
            (None, Some(path), _) => Ok(Some(all_of(path)?)),
            (None, None, Some(frames)) => Ok(Some((1..=frames as i32).collect())),
            (None, None, None) => Ok(None),
        }
    }

    /// The only picture; its name has the frame in it if there is a frame and a place for it.
    fn single(&self, output: &str) -> anyhow::Result<Picture> {
        let Some(frame) = self.frame else {
            if output.contains("{frame") {
                let cause = format!("{output}: which frame?");
                return Err(Trouble::usage(cause, "say --frame 7 or --frames 1-240").into());
            }
            return Ok(Picture {
                frame: None,
                output: output.to_owned(),
            });
        };
        Ok(Picture {
            frame: Some(frame),
            output: template(output)?.name(frame),
        })
    }

    /// Whether the plan can be carried out.
    fn check(&self, plan: &Plan, out: &Output) -> anyhow::Result<()> {
        let extensions = ["png", "exr"];
        let Some(first) = plan.pictures.first().map(|picture| &*picture.output) else {
            return Ok(());
        };
        save::check(Some(first), out, &extensions)?;
        // The frame may be in a folder's name too.
        let mut folders = HashSet::from([Path::new(first).parent()]);
        for Picture { output, .. } in &plan.pictures {
            if folders.insert(Path::new(output).parent()) {
                save::check(Some(output), out, &extensions)?;
            }
        }
        let keeps = self.resume || plan.shard.is_some();
        if first == "-" && (keeps || self.skip_existing || plan.is_series) {
            return Err(Trouble::usage(
                "frames, shards and what is to be resumed need files",
                "name one with -o",
            )
            .into());
        }
        Ok(())
    }
}

/// A name for each frame.
fn named(output: &str, frames: Vec<i32>) -> anyhow::Result<Vec<Picture>> {
    let template = template(output)?;
    if frames.len() > 1 && !template.has_frame() && output != "-" {
        let cause = format!(
            "{output}: {} frames cannot all be this one file",
            frames.len()
        );
        let help = "put the frame into its name, as in shot.{frame:04}.png or shot.####.png";
        return Err(Trouble::usage(cause, help).into());
    }
    let picture = |frame| Picture {
        frame: Some(frame),
        output: template.name(frame),
    };
    Ok(frames.into_iter().map(picture).collect())
}

fn template(output: &str) -> Result<Template, Trouble> {
    Template::parse(output)
        .map_err(|error| Trouble::usage(format!("{output}: {error}"), "as in shot.{frame:04}.png"))
}

fn read_path(name: &str) -> anyhow::Result<CameraPath> {
    let path = Path::new(name);
    let text = String::from_utf8(args::read_file(path)?).map_err(|_| {
        Trouble::input(format!("{name}: is not text"), "name a camera path in JSON")
    })?;
    Ok(CameraPath::read(path, &text)?)
}

/// There are no cameras beyond its ends.
fn on_path(path: &CameraPath, frames: &[i32]) -> Result<(), Trouble> {
    let (first, last) = path.frames().into_inner();
    match frames.iter().find(|frame| !(first..=last).contains(*frame)) {
        None => Ok(()),
        Some(frame) => Err(Trouble::usage(
            format!("frame {frame} is not on the path, which goes from frame {first} to {last}"),
            "ask for frames between, or add a key to the path",
        )),
    }
}

fn all_of(path: &CameraPath) -> Result<Vec<i32>, Trouble> {
    let frames = path.frames();
    let count = i64::from(*frames.end()) - i64::from(*frames.start()) + 1;
    if count > MAX_FRAMES as i64 {
        return Err(Trouble::usage(
            format!("the path has {count} frames, more than {MAX_FRAMES}"),
            "choose some with --frames",
        ));
    }
    Ok(frames.collect())
}

/// Empty files are what farms leave to claim a frame.
fn is_there(output: &str) -> bool {
    Path::new(output)
        .metadata()
        .is_ok_and(|found| found.is_file() && found.len() > 0)
}

impl Plan {
    /// Says what would be made.
    pub(super) fn print(&self, out: &Output) -> anyhow::Result<()> {
        if out.is_json() {
            return out.json(&serde_json::json!({
                "dry_run": true,
                "pictures": self.pictures,
                "skipped": self.skipped,
                "shard": self.shard.map(|shard| shard.to_string()),
            }));
        }
        for output in &self.skipped {
            out.text(format_args!("{output} is there"))?;
        }
        for picture in &self.pictures {
            let frame = picture
                .frame
                .map_or(String::new(), |frame| format!(", frame {frame}"));
            let shard = self
                .shard
                .map_or(String::new(), |shard| format!(", shard {shard}"));
            out.text(format_args!(
                "{}{frame}{shard} would be made",
                picture.output
            ))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::{Cli, commands::Command};

    fn plan(words: &str) -> Result<Plan, String> {
        let words = ["boxwood", "render", "builtin:bush"]
            .into_iter()
            .chain(words.split(' '));
        let Some(Command::Render(args)) = Cli::try_parse_from(words).unwrap().command else {
            panic!("another command")
        };
        let output = args.output.unwrap_or("a.png".to_owned());
        let out = Output::new("render", false);
        args.farm
            .plan(&output, &out)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn frames_are_written_only_when_they_are_whole() {
        for words in ["--frame 5", "--turntable 8 --frame 5", "--skip-existing"] {
            assert!(plan(words).unwrap().only_whole, "{words}");
        }
        assert!(!plan("--seed 1").unwrap().only_whole);
    }

    #[test]
    fn the_folders_of_all_frames_are_there_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("1")).unwrap();
        let words = |list: &str| {
            let place = folder.path().display();
            format!("--turntable 9 --frames {list} -o {place}/{{frame}}/a.png")
        };
        plan(&words("1")).unwrap();
        let error = plan(&words("1-3")).unwrap_err();
        assert!(error.contains("there is no folder"), "{error}");
    }
}
