//! What a picture shows: the arguments.

use boxwood_render::{Crop, PointLight, RenderOptions, SHADINGS, ScaleOptions, Shading};
use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::args;

/// What the picture shows.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Picture")]
pub(crate) struct LookArgs {
    /// What the colours mean; `boxwood list` says more.
    #[arg(long, value_name = "NAME", default_value = "whitted", value_parser = shadings())]
    pub(crate) shading: &'static Shading,
    /// Samples per pixel. [default: as many as the shading needs]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=i64::from(boxwood_render::MAX_SAMPLES)))]
    pub(crate) spp: Option<u32>,
    /// Another seed gives another noise.
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = args::whole::<u64>)]
    pub(crate) seed: u64,
    /// Only this part, in pixels: left, top, width, height.
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true, value_parser = crop)]
    pub(crate) crop: Option<Crop>,
    /// Most bounces of light.
    #[arg(long, value_name = "N", default_value_t = 8, allow_negative_numbers = true, value_parser = args::whole::<u32>)]
    pub(crate) max_depth: u32,
    /// A lamp: its place, and its power, where 1 (the default) lights the scene's middle like the sun. May be given often.
    #[arg(long = "light", value_name = "X,Y,Z[,POWER]", allow_hyphen_values = true, value_parser = lamp)]
    pub(crate) lights: Vec<Lamp>,
    /// Strength of sun and sky, 0 is night. [default: 1; in rooms with lights of their own 0]
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = not_negative)]
    pub(crate) sky: Option<f32>,
    /// Brightness in stops, 0 is neutral. [default: neutral by daylight, measured in rooms]
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true, value_parser = plain)]
    pub(crate) exposure: Option<f32>,
    /// No floor under the object.
    #[arg(long)]
    pub(crate) no_floor: bool,
    /// Number at the bright end of heat pictures; the same one makes pictures comparable. [default: from the picture]
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = not_negative)]
    pub(crate) top: Option<f32>,
    /// Colour heat pictures by the logarithm.
    #[arg(long)]
    pub(crate) log: bool,
}

/// As typed: place and power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lamp {
    pub(crate) position: [f32; 3],
    pub(crate) power: f32,
}

fn shadings() -> impl TypedValueParser<Value = &'static Shading> {
    PossibleValuesParser::new(SHADINGS.iter().map(|s| s.name)).try_map(|name| Shading::named(&name))
}

fn crop(text: &str) -> Result<Crop, String> {
    let numbers: Option<Vec<u32>> = text
        .split(',')
        .map(|part| part.trim().parse().ok())
        .collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Crop {
            x,
            y,
            width,
            height,
        }),
        _ => Err("left, top, width and height in pixels, as in 320,180,640,360".to_owned()),
    }
}

fn lamp(text: &str) -> Result<Lamp, String> {
    let with_power = |[x, y, z, power]: [f32; 4]| Lamp {
        position: [x, y, z],
        power,
    };
    let without = |[x, y, z]: [f32; 3]| Lamp {
        position: [x, y, z],
        power: 1.0,
    };
    args::numbers(text)
        .map(with_power)
        .or_else(|_| args::numbers(text).map(without))
        .ok()
        .filter(|l| l.power >= 0.0)
        .ok_or_else(|| "a place and a power, as in 2,5,3 or 2,5,3,0.5".to_owned())
}

fn plain(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|x: &f32| x.is_finite())
        .ok_or_else(|| "a plain number".to_owned())
}

fn not_negative(text: &str) -> Result<f32, String> {
    plain(text)
        .ok()
        .filter(|&x| x >= 0.0)
        .ok_or_else(|| "a number, 0 or more".to_owned())
}

impl LookArgs {
    /// For a scene that is built.
    pub(crate) fn options(&self, scene: &boxwood::Scene) -> RenderOptions {
        RenderOptions {
            samples: self.spp,
            seed: self.seed,
            crop: self.crop,
            max_depth: self.max_depth,
            lights: self.lights.iter().map(|lamp| lamp.light(scene)).collect(),
            sky: self.sky,
            floor: !self.no_floor,
            exposure: self.exposure,
            scale: ScaleOptions {
                top: self.top,
                log: self.log,
            },
            ..RenderOptions::new(self.shading)
        }
    }
}

impl Lamp {
    /// Power 1 gives the sun's irradiance at the middle of the scene.
    fn light(&self, scene: &boxwood::Scene) -> PointLight {
        const SUN: f32 = 3.0;
        let bounds = scene.bounds();
        let way: f32 = self
            .position
            .iter()
            .zip(bounds.center())
            .map(|(a, b)| (a - b) * (a - b))
            .sum();
        let radius = (bounds.diagonal() * 0.01) as f32;
        PointLight {
            position: self.position,
            intensity: [self.power * SUN * way; 3],
            radius,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_and_lamps_are_read_or_refused() {
        assert_eq!(
            crop("1, 2,30,40"),
            Ok(Crop {
                x: 1,
                y: 2,
                width: 30,
                height: 40
            })
        );
        assert!(crop("1,2,0,4").is_err() && crop("1,2,3").is_err() && crop("-1,2,3,4").is_err());
        assert_eq!(
            lamp("1,2,-3.5"),
            Ok(Lamp {
                position: [1.0, 2.0, -3.5],
                power: 1.0
            })
        );
        assert_eq!(
            lamp("1,2,3,0.5"),
            Ok(Lamp {
                position: [1.0, 2.0, 3.0],
                power: 0.5
            })
        );
        assert!(lamp("1,2").is_err() && lamp("1,2,3,-1").is_err());
    }
}
