//! Pictures with Boxwood: cameras, shadings, heat maps, PNG and EXR, and how far two pictures are
//! apart.
//!
//! The way of the data: a [`View`] (a checked camera with a size) and [`Surfaces`] (the looks of
//! the triangles) go with a scene into [`render()`], which gives a [`Film`]; that becomes an
//! [`Image`] for [`write_png`], or goes to [`write_exr`] with all its layers. [`SHADINGS`] is the
//! table of what a picture can show.
//!
//! Pictures are the same, bit for bit, for any number of threads and on every machine:
//! transcendental functions come from pure Rust, and nothing is fused.
#![forbid(unsafe_code)]

mod auto_camera;
mod bsdf;
mod compare;
mod error;
mod exposure;
#[cfg(feature = "farm")]
mod farm;
mod film;
mod flip;
mod floor;
mod frames;
mod image;
mod legend;
mod light;
mod output;
mod probe;
mod render;
mod sampler;
mod sampling;
mod scale;
mod shade;
mod share;
mod stage;
mod surfaces;
mod tiles;
mod tone;
mod turntable;
mod view;
mod wave;

pub use auto_camera::auto_camera;
pub use compare::{Comparison, compare};
pub use error::RenderError;
#[cfg(feature = "farm")]
pub use farm::{
    CameraPath, Difference, Merged, PartHeader, Resumed, Shard, TileLog, merge, read_header,
    scene_hash,
};
pub use film::{Film, TILE};
pub use frames::{FrameRays, Frames, Tracer};
pub use image::Image;
pub use light::PointLight;
pub use output::{
    Picture, followed, read_picture, save_atomically, save_atomically_telling, write_exr, write_png,
};
pub use render::{
    Crop, Keep, MAX_PIXELS, MAX_SAMPLES, Progress, RenderOptions, Session, TileWork, Watch, render,
};
pub use scale::{Scale, ScaleOptions};
pub use shade::{SHADINGS, Shading};
pub use surfaces::{Surface, Surfaces};
pub use tone::{Tone, linear_to_srgb8, neutral};
pub use turntable::Turntable;
pub use view::{MAX_SIDE, View};
