//! `heat-tests`, `heat-boxes` and `heat-prims`: what each pixel's camera ray cost, on one scale with legend.

use super::{Layer, Paint, Shading};
use crate::{Film, Tone};

pub(super) const TESTS: Shading = Shading {
    name: "heat-tests",
    about: "all tests of the ray through each pixel's centre, of boxes (or cells) and primitives",
    samples: 1,
    tone: Tone::Clamp,
    lit: false,
    paint: Paint::Layer(Layer {
        title: "tests per ray",
        value: tests,
        near_is_bright: false,
    }),
};

pub(super) const BOXES: Shading = Shading {
    name: "heat-boxes",
    about: "box tests of the ray through each pixel's centre (in a grid: cells), on a scale with legend",
    samples: 1,
    tone: Tone::Clamp,
    lit: false,
    paint: Paint::Layer(Layer {
        title: "box tests per ray",
        value: boxes,
        near_is_bright: false,
    }),
};

pub(super) const PRIMS: Shading = Shading {
    name: "heat-prims",
    about: "primitive tests of the ray through each pixel's centre, on a scale with legend",
    samples: 1,
    tone: Tone::Clamp,
    lit: false,
    paint: Paint::Layer(Layer {
        title: "primitive tests per ray",
        value: prims,
        near_is_bright: false,
    }),
};

fn tests(film: &Film, pixel: usize) -> Option<f32> {
    Some(film.box_tests[pixel] as f32 + film.prim_tests[pixel] as f32)
}

fn boxes(film: &Film, pixel: usize) -> Option<f32> {
    Some(film.box_tests[pixel] as f32)
}

fn prims(film: &Film, pixel: usize) -> Option<f32> {
    Some(film.prim_tests[pixel] as f32)
}
