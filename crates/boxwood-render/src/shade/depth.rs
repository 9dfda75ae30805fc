//! `depth`: the distance from the eye on a colour scale.

use super::{Layer, Paint, Shading};
use crate::{Film, Tone};

pub(super) const SHADING: Shading = Shading {
    name: "depth",
    about: "distance from the eye in the unit of the scene, on a scale with legend; near is bright",
    samples: 1,
    tone: Tone::Clamp,
    lit: false,
    paint: Paint::Layer(Layer {
        title: "distance",
        value: depth,
        near_is_bright: true,
    }),
};

fn depth(film: &Film, pixel: usize) -> Option<f32> {
    let depth = film.depth[pixel];
    depth.is_finite().then_some(depth)
}
