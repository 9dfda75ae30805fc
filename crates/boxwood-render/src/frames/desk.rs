//! One tile of a frame.

use boxwood::{Hit, Ray};
use glam::{Vec3, Vec4};

use super::{FrameRays, Frames, Look, Tracer, light::Light};
use crate::View;

/// Side of a block of pixels whose rays stand together.
pub(super) const SIDE: usize = 8;
/// Blocks of a tile, side by side.
pub(super) const BLOCKS: usize = 4;
/// Of a whole tile; a byte numbers them.
const PIXELS: usize = SIDE * SIDE * BLOCKS;
const _: () = assert!(PIXELS <= 256);

/// Where a thread draws a tile: its rays block by block, its colours row by row. 40 KB.
#[derive(Debug)]
pub(super) struct Desk {
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    seen: Box<Seen>,
    shadow_rays: Vec<Ray>,
    /// By row, block, and column in the block.
    colors: [[Run; BLOCKS]; SIDE],
}

/// A row of a block.
pub(super) type Run = [[u8; 3]; SIDE];

/// The pixels that see the scene: number `i` of each array belongs to the `i`-th of them, so that
/// the compiler makes vector instructions of the arithmetic.
#[derive(Debug)]
struct Seen {
    count: usize,
    /// Of the camera ray.
    number: [u8; PIXELS],
    /// As [`Look::roots`].
    roots: [u32; PIXELS],
    t: [f32; PIXELS],
    dir: [[f32; PIXELS]; 3],
    normal: [[f32; PIXELS]; 3],
    /// Where the shadow ray starts.
    start: [[f32; PIXELS]; 3],
    /// Cosine between normal and sun, not negative.
    facing_sun: [f32; PIXELS],
    /// Cosine between normal and zenith.
    facing_up: [f32; PIXELS],
    /// From the sun.
    occluded: [bool; PIXELS],
    /// Steps of the tone table: red, green, blue.
    tones: [[u32; PIXELS]; 3],
}

impl Default for Desk {
    fn default() -> Self {
        let no_ray = Ray::new([0.0; 3], [0.0; 3]);
        Self {
            rays: vec![no_ray; PIXELS],
            hits: vec![None; PIXELS],
            seen: Box::default(),
            shadow_rays: vec![no_ray; PIXELS],
            colors: Default::default(),
        }
    }
}

impl Default for Seen {
    fn default() -> Self {
        let (numbers, triples) = ([0.0; PIXELS], [[0.0; PIXELS]; 3]);
        Self {
            count: 0,
            number: [0; PIXELS],
            roots: [0; PIXELS],
            t: numbers,
            dir: triples,
            normal: triples,
            start: triples,
            facing_sun: numbers,
            facing_up: numbers,
            occluded: [false; PIXELS],
            tones: [[0; PIXELS]; 3],
        }
    }
}

impl Desk {
    /// The tile with its upper left pixel at `(x, y)`, of which `size` lies in the picture.
    pub(super) fn draw(
        &mut self,
        frames: &Frames,
        tracer: &dyn Tracer,
        plane: &Plane,
        [x, y]: [usize; 2],
        size: [usize; 2],
    ) -> FrameRays {
        self.aim(plane, [x, y]);
        self.hang_backdrop(&frames.light, plane, [x, y]);
        tracer.closest_hits(&self.rays, &mut self.hits);
        self.crop(size);
        self.collect(&frames.looks);
        self.seen.turn(&frames.light, plane);
        let shadow = self.aim_at_sun(&frames.light);
        tracer.occluded_each(
            &self.shadow_rays[..shadow],
            &mut self.seen.occluded[..shadow],
        );
        self.seen.expose(&frames.light);
        self.paint(&frames.light);
        FrameRays {
            camera: (size[0] * size[1]) as u64,
            shadow: shadow as u64,
        }
    }

    /// The camera rays of a whole tile, also where the picture ends within it.
    fn aim(&mut self, plane: &Plane, [x, y]: [usize; 2]) {
        for (run, rays) in self.rays.chunks_exact_mut(SIDE).enumerate() {
            let (block, row) = (run / SIDE, run % SIDE);
            let start = plane.through(x + block * SIDE, y + row);
            for (ray, step) in rays.iter_mut().zip(&plane.steps) {
                let [dir @ .., t_max] = (start + step).to_array();
                *ray = Ray::new(plane.eye, dir).with_range(0.0, t_max);
            }
        }
    }

    /// Forgets the hits beyond the edge of the picture.
    fn crop(&mut self, size: [usize; 2]) {
        if size == [SIDE * BLOCKS, SIDE] {
            return;
        }
        for (number, hit) in self.hits.iter_mut().enumerate() {
            let [row, column] = place(number);
            if row >= size[1] || column >= size[0] {
                *hit = None;
            }
        }
    }

    /// The sky behind the tile: at its size, a colour for each row is enough.
    fn hang_backdrop(&mut self, light: &Light, plane: &Plane, [x, y]: [usize; 2]) {
        let scale = plane.through(x, y).truncate().length().recip();
        for (row, colors) in self.colors.iter_mut().enumerate() {
            let dir = plane.through(x, y + row).truncate();
            *colors = [light.behind(dir * scale); BLOCKS];
        }
    }

    /// The pixels whose rays hit something, and what.
    fn collect(&mut self, looks: &[Look]) {
        let seen = &mut *self.seen;
        let mut count = 0;
        for (number, (ray, hit)) in self.rays.iter().zip(&self.hits).enumerate() {
            let Some(hit) = hit else { continue };
            let Look { normal, roots } = looks[hit.prim as usize];
            let i = count % PIXELS;
            seen.number[i] = number as u8;
            seen.roots[i] = roots;
            seen.t[i] = hit.t;
            for axis in 0..3 {
                seen.dir[axis][i] = ray.dir[axis];
                seen.normal[axis][i] = normal[axis];
            }
            count += 1;
        }
        seen.count = count;
    }

    /// The shadow rays; how many they are.
    fn aim_at_sun(&mut self, light: &Light) -> usize {
        let [x, y, z] = &self.seen.start;
        let starts = x.iter().zip(y).zip(z).take(self.seen.count);
        for (ray, ((&x, &y), &z)) in self.shadow_rays.iter_mut().zip(starts) {
            *ray = Ray::new([x, y, z], light.sun.into());
        }
        self.seen.count
    }

    fn paint(&mut self, light: &Light) {
        let (seen, colors) = (&*self.seen, &mut self.colors);
        for i in 0..seen.count.min(PIXELS) {
            let [row, column] = place(seen.number[i].into());
            let [r, g, b] = [seen.tones[0][i], seen.tones[1][i], seen.tones[2][i]];
            colors[row][column / SIDE][column % SIDE] = [r, g, b].map(|tone| light.code(tone));
        }
    }

    /// Onto the band of the picture in which the tile lies, `x` pixels from its left.
    pub(super) fn lay_down(&self, band: &mut [[u8; 3]], band_width: usize, x: usize, width: usize) {
        for (line, colors) in band.chunks_mut(band_width).zip(&self.colors) {
            line[x..][..width].copy_from_slice(&colors.as_flattened()[..width]);
        }
    }
}

impl Seen {
    /// Normals to the side of the eye, their cosines, and where the shadow rays start.
    fn turn(&mut self, light: &Light, plane: &Plane) {
        let (sun, up, eye) = (light.sun.to_array(), light.sky.up.to_array(), plane.eye);
        for i in 0..self.count.min(PIXELS) {
            let dir = [self.dir[0][i], self.dir[1][i], self.dir[2][i]];
            let normal = [self.normal[0][i], self.normal[1][i], self.normal[2][i]];
            let side = -1f32.copysign(dot(normal, dir));
            self.facing_sun[i] = larger(side * dot(normal, sun), 0.0);
            self.facing_up[i] = side * dot(normal, up);
            // Beyond the rounding errors of the hit point, which grow with the way there.
            let away = side * (plane.near_error + plane.far_error * self.t[i]);
            for axis in 0..3 {
                self.start[axis][i] = eye[axis] + dir[axis] * self.t[i] + normal[axis] * away;
            }
        }
    }

    /// The brightness of each pixel as a step of the tone table.
    fn expose(&mut self, light: &Light) {
        let count = self.count.min(PIXELS);
        for i in 0..count {
            self.facing_sun[i] *= if self.occluded[i] { 0.0 } else { 1.0 };
        }
        for channel in 0..3 {
            for i in 0..count {
                let root = ((self.roots[i] >> (8 * channel)) & 0xff) as i32 as f32;
                let shine = light.shine(channel, self.facing_sun[i], self.facing_up[i]);
                self.tones[channel][i] = light.tone(root * root * shine);
            }
        }
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// One instruction, unlike `f32::max`, which has a rule for NaN.
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Row and column in the tile of the pixel with this number: 8 x 8 of a block one after the other.
fn place(number: usize) -> [usize; 2] {
    let (block, row, column) = (number / (SIDE * SIDE), number / SIDE % SIDE, number % SIDE);
    [row, block % BLOCKS * SIDE + column]
}

/// The picture plane, and how far shadow rays start from the surfaces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    eye: [f32; 3],
    /// Through the centre of the first pixel. Infinite in the fourth component, as rays reach.
    corner: Vec4,
    right: Vec4,
    down: Vec4,
    /// To the right, to each column of a block.
    steps: [Vec4; SIDE],
    near_error: f32,
    far_error: f32,
}

impl Plane {
    pub(super) fn of(view: &View) -> Self {
        /// 32 times the rounding error of a sum.
        const ERROR: f32 = 1.0 / (1 << 18) as f32;
        let [corner, right, down] = view.plane();
        let eye = Vec3::from(view.camera().eye);
        Self {
            eye: eye.into(),
            corner: (corner + (right + down) * 0.5).extend(f32::INFINITY),
            right: right.extend(0.0),
            down: down.extend(0.0),
            steps: std::array::from_fn(|column| (right * column as f32).extend(0.0)),
            near_error: eye.abs().max_element() * ERROR,
            far_error: corner.length() * ERROR,
        }
    }

    /// From the eye through the centre of pixel `(x, y)`.
    fn through(&self, x: usize, y: usize) -> Vec4 {
        self.corner + self.right * x as f32 + self.down * y as f32
    }
}
