//! What a file of tiles says of itself: of which picture, of which scene, by which command.

use std::{
    fs::File,
    io::{self, BufReader, Read},
    path::Path,
};

use boxwood_scene::Camera;
use serde::{Deserialize, Serialize};

use super::{Shard, plain};
use crate::{Crop, Film, MAX_PIXELS, RenderError, ScaleOptions, Shading, View};

/// Everything that decides a picture, and what is needed to finish it. Files go together if [`PartHeader::difference`] finds
/// nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartHeader {
    /// Version of the program: other versions may draw other pixels.
    pub program: String,
    /// [`scene_hash`](super::scene_hash).
    pub scene: String,
    /// As the user named the scene; may differ.
    pub file: String,
    /// Of the view.
    pub camera: Camera,
    /// Of the full picture, in pixels.
    pub size: [u32; 2],
    /// The part of it that is made.
    pub window: Crop,
    /// Its name.
    pub shading: String,
    /// For the scale of the whole picture.
    pub scale: ScaleOptions,
    /// The bits of [`Film::exposure`]: infinity is no number in JSON.
    pub exposure: u32,
    /// All else that decides pixels: name and value of each option, in a fixed order.
    pub settings: Vec<(String, String)>,
    /// Which tiles the file is for.
    pub shard: Shard,
    /// The command line that makes this file, without the program's name and `--shard`; may differ.
    pub command: Vec<String>,
}

/// Where two headers disagree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The option, or in words.
    pub name: String,
    /// The value of the header that was asked.
    pub ours: String,
    /// The other's.
    pub theirs: String,
}

const MAGIC: [u8; 8] = *b"BXWTILES";
/// Of the format.
const VERSION: u32 = 1;
/// Magic, version, length.
const FIXED: usize = 16;
/// Longest JSON, in bytes.
const MAX_LENGTH: usize = 1 << 20;

/// Why there is no header.
pub(super) enum Flaw {
    /// The file ends within it; nothing can follow.
    Torn,
    /// It is no file of tiles, or of another version, or damaged.
    Foreign(String),
    /// The system does not give it.
    Io(io::Error),
}

/// The header of a file of tiles.
///
/// # Errors
/// If the file cannot be read, or is none.
pub fn read_header(path: &Path) -> Result<PartHeader, RenderError> {
    open(path).map(|(header, _, _)| header)
}

/// The header, its length in bytes, and the file behind it.
pub(super) fn open(path: &Path) -> Result<(PartHeader, u64, BufReader<File>), RenderError> {
    let refused = |what: String, remedy: &str| RenderError::File {
        path: path.to_owned(),
        place: None,
        what,
        remedy: remedy.to_owned(),
    };
    // A folder opens on some systems, and a pipe would wait for ever.
    let is_file = path.metadata().map(|found| found.is_file());
    if matches!(is_file, Ok(false)) {
        return Err(refused(
            "is not a plain file".to_owned(),
            "name the files of the shards",
        ));
    }
    let file = File::open(path)
        .map_err(|cause| refused(cause.to_string(), "name files that can be read"))?;
    let mut file = BufReader::new(file);
    match PartHeader::read(&mut file) {
        Ok((header, length)) => Ok((header, length, file)),
        Err(Flaw::Torn) => Err(refused(
            "ends before its first tile".to_owned(),
            "start its shard again",
        )),
        Err(Flaw::Foreign(what)) => Err(refused(plain(&what), "name files that --shard has made")),
        Err(Flaw::Io(cause)) => Err(refused(cause.to_string(), "name files that can be read")),
    }
}

impl PartHeader {
    /// As it stands in the file.
    pub(super) fn bytes(&self) -> Result<Vec<u8>, RenderError> {
        let json = serde_json::to_vec(self).map_err(|cause| RenderError::Encode {
            format: "tile",
            cause: cause.to_string(),
        })?;
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend((json.len() as u32).to_le_bytes());
        bytes.extend(json);
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        Ok(bytes)
    }

    /// With its length in the file.
    pub(super) fn read(file: &mut impl Read) -> Result<(Self, u64), Flaw> {
        let mut bytes = Vec::new();
        take(file, &mut bytes, FIXED)?;
        let word = |bytes: &[u8], at: usize| {
            u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
        };
        let (version, length) = (word(&bytes, 8), word(&bytes, 12) as usize);
        if version != VERSION {
            let what = format!("is a file of tiles of version {version}, not {VERSION}");
            return Err(Flaw::Foreign(what));
        }
        if length > MAX_LENGTH {
            return Err(Flaw::Foreign("its header is damaged".to_owned()));
        }
        let end = FIXED + length;
        take(file, &mut bytes, end + 4)?;
        if crc32fast::hash(&bytes[..end]) != word(&bytes, end) {
            return Err(Flaw::Foreign("its header is damaged".to_owned()));
        }
        let header: Self = serde_json::from_slice(&bytes[FIXED..end])
            .map_err(|cause| Flaw::Foreign(format!("its header is damaged: {cause}")))?;
        header.check().map_err(Flaw::Foreign)?;
        Ok((header, bytes.len() as u64))
    }

    /// A header may claim anything.
    fn check(&self) -> Result<(), String> {
        let [width, height] = self.size;
        let window = self.window;
        let fits = |start: u32, length: u32, all: u32| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= all)
        };
        if !fits(window.x, window.width, width)
            || !fits(window.y, window.height, height)
            || window.area() > MAX_PIXELS
        {
            return Err("its header claims an impossible size".to_owned());
        }
        if !(1..=self.shard.count).contains(&self.shard.number) {
            return Err("its header claims an impossible shard".to_owned());
        }
        let view = View::new(self.camera, width, height).map(|_| ());
        view.and(self.shading().map(|_| ()))
            .map_err(|error| format!("its header does not hold: {error}"))
    }

    /// Of this program's table.
    pub(super) fn shading(&self) -> Result<&'static Shading, RenderError> {
        Shading::named(&self.shading)
    }

    /// A film of this picture, with nothing on it.
    pub(super) fn film(&self) -> Result<Film, RenderError> {
        let exposure = f32::from_bits(self.exposure);
        Film::unexposed(self.window, self.size, self.shading()?.tone, exposure)
    }

    /// What decides the picture differently in the two: its name and both values. None if they are of the same picture. Shards
    /// may differ in their number, not in how many they are.
    pub fn difference(&self, other: &Self) -> Option<Difference> {
        let (ours, theirs) = (self.fields(), other.fields());
        let mut pairs = ours.iter().zip(&theirs);
        let differ = pairs.find(|(ours, theirs)| ours != theirs);
        let of = |name: &str, ours: &str, theirs: &str| Difference {
            name: plain(name),
            ours: plain(ours),
            theirs: plain(theirs),
        };
        match differ {
            Some((("the scene", ours), ("the scene", theirs))) => {
                let [ours, theirs] = shortened([ours, theirs]);
                Some(of("the scene", &ours, &theirs))
            }
            Some(((name, ours), (other, theirs))) if name == other => Some(of(name, ours, theirs)),
            None if ours.len() == theirs.len() => None,
            _ => Some(of("the list of options", "one", "another")),
        }
    }

    /// Name and value of all that decides the picture.
    fn fields(&self) -> Vec<(&str, String)> {
        let Crop {
            x,
            y,
            width,
            height,
        } = self.window;
        let Camera {
            eye,
            target,
            up,
            fov,
        } = self.camera;
        let mut fields = vec![
            ("the version of the program", self.program.clone()),
            ("the scene", self.scene.clone()),
            ("--size", format!("{}x{}", self.size[0], self.size[1])),
            ("--crop", format!("{x},{y},{width},{height}")),
            ("--vp", format!("{eye:?}")),
            ("--vi", format!("{target:?}")),
            ("--vu", format!("{up:?}")),
            ("--fov", format!("{fov:?}")),
            ("--shading", self.shading.clone()),
            ("--top", or_automatic(self.scale.top)),
            ("--log", self.scale.log.to_string()),
        ];
        let settings = self.settings.iter();
        fields.extend(settings.map(|(name, value)| (&**name, value.clone())));
        // At last: it follows from the others.
        fields.push((
            "the exposure",
            format!("{:?}", f32::from_bits(self.exposure)),
        ));
        fields.push(("the number of shards", self.shard.count.to_string()));
        fields
    }
}

/// Two hashes by their first digits, if these tell them apart.
fn shortened(hashes: [&str; 2]) -> [String; 2] {
    let short = hashes.map(|hash| hash.chars().take(16).collect::<String>() + "...");
    match short[0] == short[1] {
        true => hashes.map(str::to_owned),
        false => short,
    }
}

fn or_automatic(number: Option<f32>) -> String {
    number.map_or("automatic".to_owned(), |x| format!("{x:?}"))
}

/// Reads on until `bytes` are `length` long. Bytes that no file of tiles begins with are foreign however few they are.
fn take(file: &mut impl Read, bytes: &mut Vec<u8>, length: usize) -> Result<(), Flaw> {
    let missing = (length - bytes.len()) as u64;
    file.by_ref()
        .take(missing)
        .read_to_end(bytes)
        .map_err(Flaw::Io)?;
    let known = bytes.len().min(MAGIC.len());
    if bytes[..known] != MAGIC[..known] {
        return Err(Flaw::Foreign("is not a file of tiles".to_owned()));
    }
    match bytes.len() < length {
        true => Err(Flaw::Torn),
        false => Ok(()),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    type Change = fn(&mut PartHeader);

    pub(in crate::farm) fn header() -> PartHeader {
        PartHeader {
            program: "1.2.3".to_owned(),
            scene: "0123".repeat(16),
            file: "a.ply".to_owned(),
            camera: Camera {
                eye: [0.1, 2.0, 3e-7],
                target: [0.0; 3],
                up: [0.0, 0.0, 1.0],
                fov: 33.3,
            },
            size: [40, 30],
            window: Crop {
                x: 3,
                y: 5,
                width: 37,
                height: 25,
            },
            shading: "ao".to_owned(),
            scale: ScaleOptions::default(),
            exposure: f32::INFINITY.to_bits(),
            settings: vec![("--seed".to_owned(), "7".to_owned())],
            shard: Shard {
                number: 2,
                count: 4,
            },
            command: vec!["render".to_owned()],
        }
    }

    fn read(bytes: &[u8]) -> Result<PartHeader, String> {
        PartHeader::read(&mut &*bytes)
            .map(|(header, _)| header)
            .map_err(|flaw| match flaw {
                Flaw::Torn => "torn".to_owned(),
                Flaw::Foreign(what) => what,
                Flaw::Io(cause) => cause.to_string(),
            })
    }

    #[test]
    fn a_header_comes_back_and_what_is_cut_or_changed_does_not() {
        let bytes = header().bytes().unwrap();
        assert_eq!(read(&bytes), Ok(header()));
        for cut in 0..bytes.len() {
            assert_eq!(read(&bytes[..cut]), Err("torn".to_owned()), "cut at {cut}");
        }
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 1;
            assert!(read(&changed).is_err(), "byte {at}");
        }
        assert_eq!(read(b"P6"), Err("is not a file of tiles".to_owned()));
    }

    #[test]
    fn headers_that_claim_the_impossible_are_refused() {
        let claims: [(Change, &str); 8] = [
            (|h| h.window.width = 0, "size"),
            (|h| h.window.x = u32::MAX, "size"),
            (|h| h.window.width = 41, "size"),
            (|h| h.size = [70_000, 70_000], "65535"),
            (|h| h.shard.number = 0, "shard"),
            (|h| h.shard.number = 5, "shard"),
            (|h| h.shading = "none".to_owned(), "no shading 'none'"),
            (|h| h.camera.fov = 0.0, "field of view"),
        ];
        for (claim, what) in claims {
            let mut header = header();
            claim(&mut header);
            let error = read(&header.bytes().unwrap()).unwrap_err();
            assert!(error.contains(what), "{error}");
        }
    }

    #[test]
    fn what_differs_is_named_with_both_values() {
        let changes: [(Change, &str, &str, &str); 6] = [
            (
                |h| h.program = "2".to_owned(),
                "the version of the program",
                "1.2.3",
                "2",
            ),
            (|h| h.camera.fov = 30.0, "--fov", "33.3", "30.0"),
            (|h| h.scale.top = Some(9.0), "--top", "automatic", "9.0"),
            (|h| h.settings[0].1 = "8".to_owned(), "--seed", "7", "8"),
            (|h| h.exposure = 0, "the exposure", "inf", "0.0"),
            (|h| h.shard.count = 5, "the number of shards", "4", "5"),
        ];
        for (change, name, ours, theirs) in changes {
            let mut other = header();
            change(&mut other);
            let found = header().difference(&other).unwrap();
            let Difference {
                name: n,
                ours: o,
                theirs: t,
            } = &found;
            assert_eq!((&**n, &**o, &**t), (name, ours, theirs));
        }
        let (mut a, mut b) = (header(), header());
        a.scene.replace_range(..1, "f");
        let found = header().difference(&a).unwrap();
        assert_eq!(found.theirs, "f123012301230123...");
        b.scene.replace_range(63.., "0");
        let found = header().difference(&b).unwrap();
        assert_eq!((found.ours, found.theirs), (header().scene, b.scene));
        let mut hostile = header();
        hostile.settings[0].1 = "\u{1b}[2J".to_owned();
        let found = header().difference(&hostile).unwrap();
        assert_eq!(found.theirs, "\u{fffd}[2J");
        let mut same = header();
        same.file = "b.ply".to_owned();
        same.shard.number = 3;
        same.command.clear();
        assert_eq!(header().difference(&same), None);
    }
}
