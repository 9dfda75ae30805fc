//! A camera that moves: key frames in JSON, and what is between them.

use std::{fmt, ops::RangeInclusive, path::Path};

use boxwood_scene::Camera;
use serde::Deserialize;
use serde_json::value::RawValue;

use crate::{RenderError, View};

/// A camera for every frame from the first key to the last.
///
/// Between keys each number goes smoothly along the piecewise cubic of Fritsch and Butland (1984), which SciPy calls
/// `PchipInterpolator`: it has no jumps in speed, keeps the keys' times, and never leaves the range of its two neighbours, so that a
/// camera that rests rests, and none swings through a wall. Or, with `"interpolation": "linear"`, along straight lines.
/// In f64 with plain arithmetic: the same bits on every machine.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    /// Frames per second, for who makes a film of them.
    pub fps: Option<f64>,
    frames: Vec<i32>,
    /// By key: eye, target, up, field of view.
    values: Vec<[f64; CHANNELS]>,
    /// By key: change per frame; none for straight lines.
    slopes: Option<Vec<[f64; CHANNELS]>>,
}

const CHANNELS: usize = 10;
/// Most keys of a path.
const MAX_KEYS: usize = 100_000;
/// As good as any for the remedies.
const EXAMPLE: &str =
    r#"{"frame": 1, "eye": [0, 1, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 45}"#;

/// The file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    #[serde(rename = "boxwood-path")]
    version: u32,
    fps: Option<f64>,
    #[serde(default)]
    interpolation: Interpolation,
    keys: Vec<Key>,
}

#[derive(Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Interpolation {
    #[default]
    Smooth,
    Linear,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Key {
    frame: i32,
    eye: [f32; 3],
    target: [f32; 3],
    /// As in the key before, as is the next.
    up: Option<[f32; 3]>,
    fov: Option<f32>,
}

/// What the first key leaves out.
const UP: [f32; 3] = [0.0, 1.0, 0.0];
const FOV: f32 = 45.0;

impl CameraPath {
    /// From the JSON that docs/farm/README.md describes. `name` is for errors, which have line and column, the number of the key
    /// and a remedy.
    pub fn read(name: &Path, text: &str) -> Result<Self, RenderError> {
        let refused = |place: [usize; 2], what: String, remedy: String| RenderError::File {
            path: name.to_owned(),
            place: Some(place),
            what,
            remedy,
        };
        let remedy = || format!("a key is written as {EXAMPLE}");
        let mut json = serde_json::Deserializer::from_str(text);
        let content: Content = serde_path_to_error::deserialize(&mut json).map_err(|error| {
            let (inner, path) = (error.inner(), error.path().to_string());
            let what = match &*path {
                "." => bare(inner),
                path => format!("{path}: {}", bare(inner)),
            };
            refused([inner.line(), inner.column()], what, remedy())
        })?;
        json.end()
            .map_err(|error| refused([error.line(), error.column()], bare(&error), remedy()))?;
        content.check(&|key, what, remedy| refused(place_of(text, key), what, remedy))?;
        Ok(Self::of(&content))
    }

    fn of(content: &Content) -> Self {
        let frames: Vec<i32> = content.keys.iter().map(|key| key.frame).collect();
        let values: Vec<[f64; CHANNELS]> = content.cameras().map(values_of).collect();
        let slopes =
            (content.interpolation == Interpolation::Smooth).then(|| slopes(&frames, &values));
        Self {
            fps: content.fps,
            frames,
            values,
            slopes,
        }
    }

    /// From the first key's to the last key's.
    pub fn frames(&self) -> RangeInclusive<i32> {
        self.frames[0]..=self.frames[self.frames.len() - 1]
    }

    /// The camera at `frame`; outside of [`CameraPath::frames`] that of the nearest key. Between keys that disagree much it may
    /// be none that [`View::new`] takes.
    pub fn camera(&self, frame: i32) -> Camera {
        let after = self.frames.partition_point(|&key| key <= frame);
        let Some(before) = after.checked_sub(1) else {
            return camera_of(self.values[0]);
        };
        if after == self.frames.len() {
            return camera_of(self.values[before]);
        }
        let [x0, x1] = [before, after].map(|key| f64::from(self.frames[key]));
        let (length, share) = (x1 - x0, (f64::from(frame) - x0) / (x1 - x0));
        let (from, to) = (&self.values[before], &self.values[after]);
        camera_of(std::array::from_fn(|i| match &self.slopes {
            None => from[i] + (to[i] - from[i]) * share,
            Some(slopes) => hermite(
                [from[i], to[i]],
                [slopes[before][i] * length, slopes[after][i] * length],
                share,
            ),
        }))
    }
}

impl Content {
    /// Of each key, what it leaves out filled in.
    fn cameras(&self) -> impl Iterator<Item = Camera> + '_ {
        self.keys.iter().scan((UP, FOV), |(up, fov), key| {
            (*up, *fov) = (key.up.unwrap_or(*up), key.fov.unwrap_or(*fov));
            Some(Camera {
                eye: key.eye,
                target: key.target,
                up: *up,
                fov: *fov,
            })
        })
    }

    /// `refused` makes an error of the number of a key, what is wrong with it, and a remedy.
    fn check(
        &self,
        refused: &dyn Fn(Option<usize>, String, String) -> RenderError,
    ) -> Result<(), RenderError> {
        let whole = |what: String, remedy: &str| Err(refused(None, what, remedy.to_owned()));
        if self.version != 1 {
            let what = format!("boxwood-path: version {} is not known", self.version);
            return whole(what, "this program reads version 1");
        }
        if let Some(fps) = self.fps.filter(|fps| !(*fps > 0.0 && fps.is_finite())) {
            return whole(format!("fps: {fps} frames per second"), "give more than 0");
        }
        if self.keys.is_empty() || self.keys.len() > MAX_KEYS {
            let what = format!("keys: there are {}", self.keys.len());
            return whole(what, "a path has 1 to 100000 keys");
        }
        for ((i, key), camera) in self.keys.iter().enumerate().zip(self.cameras()) {
            if i > 0 && key.frame <= self.keys[i - 1].frame {
                let what = format!(
                    "keys[{i}]: frame {} comes after frame {}",
                    key.frame,
                    self.keys[i - 1].frame
                );
                let remedy = "put the keys in the order of their frames, each frame once";
                return Err(refused(Some(i), what, remedy.to_owned()));
            }
            if let Err(RenderError::Camera { what, remedy }) = View::new(camera, 16, 9) {
                return Err(refused(
                    Some(i),
                    format!("keys[{i}]: {what}"),
                    remedy_in_json(remedy),
                ));
            }
        }
        Ok(())
    }
}

/// A camera's remedies speak of flags.
fn remedy_in_json(remedy: &str) -> String {
    let names = [
        ("--vp", "eye"),
        ("--vi", "target"),
        ("--vu", "up"),
        ("--fov", "fov"),
    ];
    names.iter().fold(remedy.to_owned(), |text, (flag, name)| {
        text.replace(flag, name)
    })
}

fn values_of(camera: Camera) -> [f64; CHANNELS] {
    let all = [camera.eye, camera.target, camera.up].concat();
    std::array::from_fn(|i| all.get(i).copied().unwrap_or(camera.fov).into())
}

fn camera_of(values: [f64; CHANNELS]) -> Camera {
    let v = values.map(|x| x as f32);
    Camera {
        eye: [v[0], v[1], v[2]],
        target: [v[3], v[4], v[5]],
        up: [v[6], v[7], v[8]],
        fov: v[9],
    }
}

/// The cubic from `y[0]` to `y[1]` that begins and ends with `slope`, at `share` 0 to 1 of the way.
fn hermite(y: [f64; 2], slope: [f64; 2], share: f64) -> f64 {
    let rest = 1.0 - share;
    let (a, b) = (
        rest * rest * (1.0 + 2.0 * share),
        share * share * (3.0 - 2.0 * share),
    );
    a * y[0] + b * y[1] + share * rest * (rest * slope[0] - share * slope[1])
}

/// At each key, by channel.
fn slopes(frames: &[i32], values: &[[f64; CHANNELS]]) -> Vec<[f64; CHANNELS]> {
    let last = frames.len() - 1;
    let length = |k: usize| f64::from(frames[k + 1]) - f64::from(frames[k]);
    let chord = |k: usize, i: usize| (values[k + 1][i] - values[k][i]) / length(k);
    let slope = |k: usize, i: usize| match k {
        _ if last == 0 => 0.0,
        0 if last == 1 => chord(0, i),
        1 if last == 1 => chord(0, i),
        0 => slope_at_end([length(0), length(1)], [chord(0, i), chord(1, i)]),
        k if k == last => slope_at_end(
            [length(k - 1), length(k - 2)],
            [chord(k - 1, i), chord(k - 2, i)],
        ),
        k => slope_between([length(k - 1), length(k)], [chord(k - 1, i), chord(k, i)]),
    };
    (0..=last)
        .map(|k| std::array::from_fn(|i| slope(k, i)))
        .collect()
}

/// The weighted harmonic mean of two chords that agree in sign, else zero.
fn slope_between(length: [f64; 2], chord: [f64; 2]) -> f64 {
    if chord[0] * chord[1] <= 0.0 {
        return 0.0;
    }
    let weights = [2.0 * length[1] + length[0], length[1] + 2.0 * length[0]];
    (weights[0] + weights[1]) / (weights[0] / chord[0] + weights[1] / chord[1])
}

/// From three points, the nearest first; cut such that the cubic does not overshoot (Moler, "Numerical Computing with MATLAB", 3.6).
fn slope_at_end(length: [f64; 2], chord: [f64; 2]) -> f64 {
    let slope =
        ((2.0 * length[0] + length[1]) * chord[0] - length[0] * chord[1]) / (length[0] + length[1]);
    if slope * chord[0] <= 0.0 {
        0.0
    } else if chord[0] * chord[1] <= 0.0 && slope.abs() > 3.0 * chord[0].abs() {
        3.0 * chord[0]
    } else {
        slope
    }
}

/// Without the place, which stands elsewhere.
fn bare(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.rfind(" at line ") {
        Some(end) => text[..end].to_owned(),
        None => text,
    }
}

/// Line and column where a key begins; of the file's beginning where none is to blame.
fn place_of(text: &str, key: Option<usize>) -> [usize; 2] {
    #[derive(Deserialize)]
    struct Places<'a> {
        #[serde(borrow)]
        keys: Vec<&'a RawValue>,
    }
    let offset = key.and_then(|key| {
        let places: Places<'_> = serde_json::from_str(text).ok()?;
        let start = places.keys.get(key)?.get().as_ptr() as usize;
        start.checked_sub(text.as_ptr() as usize)
    });
    let before = text.get(..offset.unwrap_or(0)).unwrap_or("");
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    [line, column]
}

impl fmt::Display for CameraPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let frames = self.frames();
        write!(
            f,
            "{} keys, frames {} to {}",
            self.frames.len(),
            frames.start(),
            frames.end()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<CameraPath, String> {
        CameraPath::read(Path::new("cam.json"), text).map_err(|error| error.to_string())
    }

    fn with_keys(head: &str, x: &[(i32, f32)]) -> String {
        let key = |(frame, x): &(i32, f32)| {
            format!(r#"{{"frame": {frame}, "eye": [{x}, 1, 50], "target": [0, 0, 0]}}"#)
        };
        let keys: Vec<String> = x.iter().map(key).collect();
        format!(
            "{{\"boxwood-path\": 1, {head} \"keys\": [\n{}\n]}}",
            keys.join(",\n")
        )
    }

    #[test]
    fn a_smooth_path_has_the_numbers_of_scipys_pchip() {
        let keys = [(1, 0.25), (5, 2.0), (6, 1.5), (14, 9.0)];
        let path = read(&with_keys(r#""fps": 24,"#, &keys)).unwrap();
        assert_eq!((path.frames(), path.fps), (1..=14, Some(24.0)));
        // scipy.interpolate.PchipInterpolator([1, 5, 6, 14], [0.25, 2, 1.5, 9])
        let scipy = [
            (2, 1.191_406),
            (3, 1.718_75),
            (4, 1.949_219),
            (7, 1.579_97),
            (10, 3.034_722),
            (13, 6.981_662),
        ];
        for (frame, x) in scipy.into_iter().chain(keys) {
            let found = path.camera(frame).eye[0];
            assert!((found - x).abs() < 2e-6, "frame {frame}: {found}");
        }
        for (beyond, nearest) in [(-3, 1), (99, 14)] {
            assert_eq!(path.camera(beyond), path.camera(nearest));
        }
    }

    #[test]
    fn a_smooth_path_rests_where_keys_agree_and_never_overshoots() {
        let path = read(&with_keys(
            "",
            &[(0, 0.0), (10, 5.0), (20, 5.0), (30, -1.0)],
        ))
        .unwrap();
        for frame in 0..=30 {
            let x = path.camera(frame).eye[0];
            assert!((-1.0..=5.0).contains(&x), "frame {frame}: {x}");
            assert!(
                !(10..=20).contains(&frame) || x == 5.0,
                "frame {frame}: {x}"
            );
        }
    }

    #[test]
    fn a_linear_path_and_one_of_few_keys_go_straight() {
        let keys = [(0, 0.0), (10, 5.0), (20, -5.0)];
        let path = read(&with_keys(r#""interpolation": "linear","#, &keys)).unwrap();
        assert_eq!([2, 10, 15].map(|f| path.camera(f).eye[0]), [1.0, 5.0, 0.0]);
        let two = read(&with_keys("", &keys[..2])).unwrap();
        assert_eq!([2, 9].map(|f| two.camera(f).eye[0]), [1.0, 4.5]);
        let one = read(&with_keys("", &keys[..1])).unwrap();
        assert_eq!((one.frames(), one.camera(0).fov), (0..=0, 45.0));
    }

    #[test]
    fn what_a_key_leaves_out_is_as_in_the_key_before() {
        let text = with_keys("", &[(1, 0.0), (2, 1.0), (3, 2.0)]);
        let path = read(&text.replacen("50]", "50], \"fov\": 30, \"up\": [0, 0, 1]", 1)).unwrap();
        let last = path.camera(3);
        assert_eq!((last.fov, last.up), (30.0, [0.0, 0.0, 1.0]));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place_and_a_remedy() {
        let good = with_keys("", &[(1, 0.0), (5, 1.0)]);
        let cases = [
            ("", "cam.json:1:0: EOF"),
            ("{}", "missing field `boxwood-path`"),
            (
                r#"{"boxwood-path": 2, "keys": []}"#,
                "version 2 is not known",
            ),
            (r#"{"boxwood-path": 1, "keys": []}"#, "there are 0"),
            (r#"{"boxwood-path": 1, "fps": -1, "keys": []}"#, "fps: -1"),
            (
                r#"{"boxwood-path": 1, "interpolation": "spline", "keys": []}"#,
                "interpolation: unknown variant `spline`",
            ),
            (
                &good.replacen("\"eye\"", "\"from\"", 1),
                "cam.json:2:19: keys[0].from: unknown field `from`",
            ),
            (
                &good.replacen("[1, 1, 50]", "[1, 50]", 1),
                "keys[1].eye: invalid length 2",
            ),
            (
                &good.replacen("[1, 1, 50]", "[0, 0, 0]", 1),
                "cam.json:3:1: keys[1]: eye and target are both",
            ),
            (
                &good.replacen("[1, 1, 50]", "[0, 1, 0]", 1),
                "cam.json:3:1: keys[1]: up [0.0, 1.0, 0.0] is zero or parallel",
            ),
            // Refused by the reader or by us, as serde_json's features, which other crates choose, have it.
            (&good.replacen("[1, 1, 50]", "[1e99, 1, 50]", 1), "keys[1]"),
            (
                &good.replacen("\"frame\": 5", "\"frame\": 1", 1),
                "cam.json:3:1: keys[1]: frame 1 comes after frame 1",
            ),
            (
                &good.replacen("\"frame\": 5", "\"frame\": 1.5", 1),
                "keys[1].frame: invalid type",
            ),
            (
                &good.replacen("50]", "50], \"fov\": 180", 1),
                "cam.json:2:1: keys[0]: a field of view of 180",
            ),
            (&format!("{good}x"), "trailing characters"),
        ];
        for (text, what) in cases {
            let error = read(text).unwrap_err();
            assert!(
                error.contains(what) && error.contains("; "),
                "{what}\n{error}"
            );
        }
    }
}
