//! Frame after frame, as fast as the rays allow: one camera ray per pixel, one shadow ray where that
//! hits, flat shading.
//!
//! What a viewer draws while the camera moves, and what the frame rate of a structure is measured
//! with. All that is not a ray is kept small: rays are made tile by tile in the first-level cache
//! (to read them from a table would be slower), a triangle's look is 16 bytes, tones come from
//! tables, buffers are used again, and nothing that grows with the picture is allocated.

mod desk;
mod light;

use std::sync::{Mutex, PoisonError};

use boxwood::{Hit, Ray, Scene};

use self::{
    desk::{BLOCKS, Desk, Plane, SIDE},
    light::Light,
};
use crate::{
    Image, Surfaces, View,
    share::{map_each, share_out},
};

/// Who answers the rays of a frame: a [`Scene`], or another tracer that is to draw the same picture.
pub trait Tracer: Sync {
    /// The closest hit of each ray; `prim` counts the triangles of the [`Surfaces`].
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]);

    /// Whether there is any hit in each ray's range.
    fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]);
}

/// On the calling thread: each thread has tiles of its own.
impl Tracer for Scene {
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.query().closest_hits(rays, hits);
    }

    fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.query().occluded_each(rays, occluded);
    }
}

/// The looks of a scene, made ready for drawing under a sun and a sky.
///
/// Each triangle has one colour (that of its middle) and its flat normal; nothing glows or mirrors.
/// 16 bytes per triangle.
#[derive(Debug)]
pub struct Frames {
    looks: Vec<Look>,
    light: Light,
    /// Buffers of threads that have nothing to draw at the moment.
    desks: Mutex<Vec<Desk>>,
}

/// The rays of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameRays {
    /// One per pixel.
    pub camera: u64,
    /// One per pixel that sees the scene.
    pub shadow: u64,
}

/// A triangle.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
struct Look {
    /// Of the flat triangle, unit, on the side from which its corners run counterclockwise.
    normal: [f32; 3],
    /// Square roots of linear red, green and blue, so that dark colours are told apart: a byte each,
    /// red the lowest.
    roots: u32,
}

impl Frames {
    /// Looks at all triangles of `surfaces`; the sun stands to the left of `view` and behind it, and
    /// stays there.
    pub fn new(surfaces: Surfaces<'_>, view: &View) -> Self {
        let count = surfaces.triangles().len();
        Self {
            looks: map_each(count, |prim| Look::of(surfaces, prim as u32)),
            light: Light::of(view),
            desks: Mutex::default(),
        }
    }

    /// Draws what `view` sees into `image`, on the threads of the caller's rayon pool.
    ///
    /// The picture is the same for any number of threads, and takes on the size of the view.
    ///
    /// # Panics
    /// If `tracer` answers with a triangle that the surfaces do not have.
    pub fn draw(&self, tracer: &dyn Tracer, view: &View, image: &mut Image) -> FrameRays {
        let (width, height) = (view.width() as usize, view.height() as usize);
        (image.width, image.height) = (view.width(), view.height());
        image.rgb.resize(width * height, [0; 3]);
        let bands = image.rgb.chunks_mut(width * SIDE).map(Mutex::new);
        let bands: Vec<Mutex<&mut [[u8; 3]]>> = bands.collect();
        let columns = width.div_ceil(SIDE * BLOCKS);
        let all_rays = Mutex::new(FrameRays::default());
        let plane = Plane::of(view);
        let desk = || AtWork::sits_down(self, &all_rays);
        share_out((bands.len() * columns) as u32, desk, |at, number| {
            // Down the columns: neighbours in time seldom want the same band.
            let (column, row) = (number as usize / bands.len(), number as usize % bands.len());
            let (x, y) = (column * SIDE * BLOCKS, row * SIDE);
            let size = [(width - x).min(SIDE * BLOCKS), (height - y).min(SIDE)];
            let rays = at.desk.draw(self, tracer, &plane, [x, y], size);
            at.rays.camera += rays.camera;
            at.rays.shadow += rays.shadow;
            let mut band = bands[row].lock().unwrap_or_else(PoisonError::into_inner);
            at.desk.lay_down(&mut band, width, x, size[0]);
        });
        drop(bands);
        all_rays
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// A desk in use; goes back to the others in the end, with its thread's share of the rays.
struct AtWork<'a> {
    desk: Desk,
    rays: FrameRays,
    frames: &'a Frames,
    all_rays: &'a Mutex<FrameRays>,
}

impl<'a> AtWork<'a> {
    fn sits_down(frames: &'a Frames, all_rays: &'a Mutex<FrameRays>) -> Self {
        let mut desks = frames.desks.lock().unwrap_or_else(PoisonError::into_inner);
        Self {
            desk: desks.pop().unwrap_or_default(),
            rays: FrameRays::default(),
            frames,
            all_rays,
        }
    }
}

impl Drop for AtWork<'_> {
    fn drop(&mut self) {
        let mut desks = self
            .frames
            .desks
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        desks.push(std::mem::take(&mut self.desk));
        let mut all = self.all_rays.lock().unwrap_or_else(PoisonError::into_inner);
        all.camera += self.rays.camera;
        all.shadow += self.rays.shadow;
    }
}

impl Look {
    fn of(surfaces: Surfaces<'_>, prim: u32) -> Self {
        let third = 1.0 / 3.0;
        let middle = Hit {
            t: 0.0,
            u: third,
            v: third,
            prim,
            geom: 0,
            inst: 0,
        };
        // A ray without a direction sees the front.
        let surface = surfaces.at(&Ray::new([0.0; 3], [0.0; 3]), &middle);
        let root = |linear: f32| (linear.clamp(0.0, 1.0).sqrt() * 255.0 + 0.5) as u8;
        let [r, g, b] = surface.base_color.to_array().map(root);
        Self {
            normal: surface.face_normal.into(),
            roots: u32::from_le_bytes([r, g, b, 0]),
        }
    }
}
