//! The table of shadings. A new one is one file here and one line in [`SHADINGS`].

mod ao;
mod depth;
mod eyelight;
mod heat;
mod normal;
mod part;
mod path;
mod prim;
mod uv;
mod whitted;

use boxwood::{Hit, Ray};
use glam::Vec3;

use crate::{
    Film, RenderError, Tone,
    stage::Stage,
    wave::{self, Glances, Wave},
};

/// A way to make a picture of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Shading {
    /// As on the command line.
    pub name: &'static str,
    /// One line for the user.
    pub about: &'static str,
    /// Samples per pixel where the user names no number.
    pub samples: u32,
    /// From linear colours to the screen.
    pub tone: Tone,
    /// Whether the light of the scene is measured and the exposure set by it.
    pub(crate) lit: bool,
    pub(crate) paint: Paint,
}

/// How the colours come about.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Paint {
    /// The average over samples: linear light along a camera ray, from what that ray hits.
    Hit(fn(&Stage<'_>, &Ray, Option<Hit>) -> Vec3),
    /// The same with more rays, by a [`wave`](crate::wave).
    Rays(wave::Open),
    /// A colour scale over a layer of the finished film.
    Layer(Layer),
}

/// A layer of the film as numbers to be coloured.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layer {
    /// Of the legend.
    pub(crate) title: &'static str,
    /// The number of a pixel; none for background.
    pub(crate) value: fn(&Film, usize) -> Option<f32>,
    /// The least number is bright, and the scale begins there; else zero is dark.
    pub(crate) near_is_bright: bool,
}

/// Every shading, in the order in which help lists them.
pub const SHADINGS: &[Shading] = &[
    eyelight::SHADING,
    normal::SHADING,
    uv::SHADING,
    depth::SHADING,
    part::SHADING,
    prim::SHADING,
    heat::TESTS,
    heat::BOXES,
    heat::PRIMS,
    whitted::SHADING,
    ao::SHADING,
    path::SHADING,
];

/// The background of pictures whose colours are data.
pub(crate) const DARK: Vec3 = Vec3::new(0.012, 0.013, 0.016);

impl Shading {
    /// The shading called `name`; the error lists the names that there are.
    pub fn named(name: &str) -> Result<&'static Self, RenderError> {
        SHADINGS
            .iter()
            .find(|shading| shading.name == name)
            .ok_or_else(|| RenderError::Shading {
                name: name.to_owned(),
                known: SHADINGS
                    .iter()
                    .map(|s| s.name)
                    .collect::<Vec<_>>()
                    .join(", "),
            })
    }

    /// Paths of this shading; none for layers.
    pub(crate) fn wave<'s>(&self, stage: &'s Stage<'s>) -> Option<Box<dyn Wave + 's>> {
        match self.paint {
            Paint::Layer(_) => None,
            Paint::Hit(color) => Some(Box::new(Glances { stage, color })),
            Paint::Rays(open) => Some(open(stage)),
        }
    }

    /// True for shadings that colour a layer by a scale: depth and heat.
    pub fn is_scale(&self) -> bool {
        matches!(self.paint, Paint::Layer(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_finds_its_own_shading_and_others_are_told_the_names() {
        for shading in SHADINGS {
            assert_eq!(Shading::named(shading.name).unwrap().about, shading.about);
        }
        let message = Shading::named("heatmap").unwrap_err().to_string();
        assert!(
            message.contains("'heatmap'") && message.contains("heat-boxes"),
            "{message}"
        );
    }
}
