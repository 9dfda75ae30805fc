//! LDR-FLIP: the difference that a viewer notices who flips between two pictures.
//!
//! Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild, "FLIP: A Difference Evaluator
//! for Alternating Images", HPG 2020. Names and constants follow the paper. Both filters of the
//! paper are sums of separable ones, and are applied that way: `O(pixels * radius)`.

use glam::{Mat3, Vec3};

/// A screen 0.7 m wide with 3840 pixels, seen from 0.7 m: the paper's setting.
const PIXELS_PER_DEGREE: f32 = 0.7 * (3840.0 / 0.7) * (std::f32::consts::PI / 180.0);

const Q_C: f32 = 0.7;
const P_C: f32 = 0.4;
const P_T: f32 = 0.95;
/// Width of the feature detectors in degrees.
const FEATURE_WIDTH: f32 = 0.082;

/// The error of each pixel, 0 to 1. `reference` and `test` are linear RGB in `0..=1`, rows of
/// `width` pixels, equally long.
pub(crate) fn flip(reference: &[Vec3], test: &[Vec3], width: usize) -> Vec<f32> {
    let opponent = |pixels: &[Vec3]| Plane {
        width,
        pixels: pixels.iter().map(|&p| ycxcz(xyz(p))).collect(),
    };
    let (reference, test) = (opponent(reference), opponent(test));
    let color = color_difference(&perceived(&reference), &perceived(&test));
    let feature = feature_difference(&features(&reference), &features(&test));
    color
        .iter()
        .zip(feature)
        .map(|(&color, feature)| libm::powf(color, 1.0 - feature))
        .collect()
}

/// A picture in some colour space.
struct Plane {
    width: usize,
    pixels: Vec<Vec3>,
}

impl Plane {
    fn map(&self, f: impl Fn(Vec3) -> Vec3) -> Self {
        Self {
            width: self.width,
            pixels: self.pixels.iter().map(|&p| f(p)).collect(),
        }
    }

    /// Convolves along x with one kernel and along y with another, per channel; the border pixels
    /// go on outwards.
    fn convolve(&self, along_x: &[Vec3], along_y: &[Vec3]) -> Self {
        self.convolve_axis(along_x, true)
            .convolve_axis(along_y, false)
    }

    fn convolve_axis(&self, kernel: &[Vec3], horizontal: bool) -> Self {
        let radius = (kernel.len() / 2) as isize;
        let height = self.pixels.len() / self.width.max(1);
        let (length, stride) = if horizontal {
            (self.width, 1)
        } else {
            (height, self.width)
        };
        let mut pixels = Vec::with_capacity(self.pixels.len());
        for index in 0..self.pixels.len() {
            let place = if horizontal {
                index % self.width
            } else {
                index / self.width
            };
            let line = index - place * stride;
            let mut sum = Vec3::ZERO;
            for (offset, &weight) in (-radius..).zip(kernel) {
                let at = place.saturating_add_signed(offset).min(length - 1);
                sum += weight * self.pixels[line + at * stride];
            }
            pixels.push(sum);
        }
        Self {
            width: self.width,
            pixels,
        }
    }
}

/// What is left of the picture after the eye's contrast sensitivity, in Hunt-adjusted L*a*b*.
fn perceived(opponent: &Plane) -> Plane {
    // Achromatic, red-green, blue-yellow: a1, b1, and for blue-yellow a second Gaussian a2, b2.
    let first = Gaussians {
        a: Vec3::new(1.0, 1.0, 34.1),
        b: Vec3::new(0.0047, 0.0053, 0.04),
    };
    let second = Gaussians {
        a: Vec3::new(0.0, 0.0, 13.5),
        b: Vec3::new(1e-5, 1e-5, 0.025),
    };
    let widest = 0.04;
    let spread = (widest / (2.0 * std::f32::consts::PI * std::f32::consts::PI)).sqrt();
    let radius = (3.0 * spread * PIXELS_PER_DEGREE).ceil() as i32;
    let (k1, k2) = (first.kernel(radius), second.kernel(radius));
    // The paper's filter is two-dimensional with sum 1: the sum of the squares of the
    // one-dimensional sums.
    let sum = |kernel: &[Vec3]| kernel.iter().copied().sum::<Vec3>();
    let (s1, s2) = (sum(&k1), sum(&k2));
    let total = first.scale() * s1 * s1 + second.scale() * s2 * s2;
    let (p1, p2) = (opponent.convolve(&k1, &k1), opponent.convolve(&k2, &k2));
    let linear_from_xyz = XYZ_FROM_LINEAR.inverse();
    let pixels = p1.pixels.iter().zip(&p2.pixels);
    let filtered = pixels.map(|(&a, &b)| (first.scale() * a + second.scale() * b) / total);
    Plane {
        width: opponent.width,
        pixels: filtered.collect(),
    }
    .map(|p| {
        let linear = linear_from_xyz
            .mul_vec3(xyz_from_ycxcz(p))
            .clamp(Vec3::ZERO, Vec3::ONE);
        hunt(lab(xyz(linear)))
    })
}

/// `a * sqrt(pi / b) * exp(-pi^2 x^2 / b)` per channel, `x` in degrees.
struct Gaussians {
    a: Vec3,
    b: Vec3,
}

impl Gaussians {
    fn scale(&self) -> Vec3 {
        self.a * Vec3::from(self.b.to_array().map(|b| (std::f32::consts::PI / b).sqrt()))
    }

    fn kernel(&self, radius: i32) -> Vec<Vec3> {
        (-radius..=radius)
            .map(|i| {
                let x = std::f32::consts::PI * i as f32 / PIXELS_PER_DEGREE;
                Vec3::from(self.b.to_array().map(|b| libm::expf(-x * x / b)))
            })
            .collect()
    }
}

/// HyAB distance, compressed and mapped so that large differences do not drown small ones.
fn color_difference(reference: &Plane, test: &Plane) -> Vec<f32> {
    let green = hunt(lab(xyz(Vec3::Y)));
    let blue = hunt(lab(xyz(Vec3::Z)));
    let most = libm::powf(hyab(green, blue), Q_C);
    let knee = P_C * most;
    let map = |(&a, &b): (&Vec3, &Vec3)| {
        let error = libm::powf(hyab(a, b), Q_C);
        let mapped = if error < knee {
            error * (P_T / knee)
        } else {
            P_T + (error - knee) / (most - knee) * (1.0 - P_T)
        };
        mapped.clamp(0.0, 1.0)
    };
    reference.pixels.iter().zip(&test.pixels).map(map).collect()
}

fn hyab(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    d.x.abs() + (d.y * d.y + d.z * d.z).sqrt()
}

/// Strength of edges and of points at each pixel.
struct Features {
    edge: Vec<f32>,
    point: Vec<f32>,
}

fn features(opponent: &Plane) -> Features {
    // Only the achromatic channel, brought to 0..=1; the three channels carry smooth, edge and
    // point filters.
    let achromatic = opponent.map(|p| Vec3::splat((p.x + 16.0) / 116.0));
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let at = |i: i32| {
        let x = i as f32 / deviation;
        let g = libm::expf(-0.5 * x * x);
        Vec3::new(g, -x * g, (x * x - 1.0) * g)
    };
    let kernel: Vec<Vec3> = (-radius..=radius).map(at).collect();
    let positive = kernel.iter().map(|k| k.max(Vec3::ZERO)).sum::<Vec3>();
    let negative = kernel.iter().map(|k| (-*k).max(Vec3::ZERO)).sum::<Vec3>();
    // Positive weights sum to 1, negative ones to -1.
    let normal = |x: f32, p: f32, n: f32| {
        if x > 0.0 {
            x / p
        } else {
            x / n.max(f32::MIN_POSITIVE)
        }
    };
    let detect: Vec<Vec3> = kernel
        .iter()
        .map(|k| {
            let edge = normal(k.y, positive.y, negative.y);
            let point = normal(k.z, positive.z, negative.z);
            Vec3::new(edge, point, 0.0)
        })
        .collect();
    let smooth: Vec<Vec3> = kernel
        .iter()
        .map(|k| Vec3::splat(k.x / positive.x))
        .collect();
    let (dx, dy) = (
        achromatic.convolve(&detect, &smooth),
        achromatic.convolve(&smooth, &detect),
    );
    let length = |pick: fn(Vec3) -> f32| {
        let both = dx.pixels.iter().zip(&dy.pixels);
        both.map(|(&x, &y)| (pick(x) * pick(x) + pick(y) * pick(y)).sqrt())
            .collect()
    };
    Features {
        edge: length(|p| p.x),
        point: length(|p| p.y),
    }
}

fn feature_difference(a: &Features, b: &Features) -> Vec<f32> {
    let edge = a.edge.iter().zip(&b.edge).map(|(a, b)| (a - b).abs());
    let point = a.point.iter().zip(&b.point).map(|(a, b)| (a - b).abs());
    edge.zip(point)
        .map(|(edge, point)| {
            (edge.max(point) * std::f32::consts::FRAC_1_SQRT_2)
                .sqrt()
                .min(1.0)
        })
        .collect()
}

/// Linear sRGB to XYZ (D65), in the fractions that FLIP uses.
const XYZ_FROM_LINEAR: Mat3 = Mat3::from_cols(
    Vec3::new(
        10_135_552.0 / 24_577_794.0,
        2_613_072.0 / 12_288_897.0,
        1_425_312.0 / 73_733_382.0,
    ),
    Vec3::new(
        8_788_810.0 / 24_577_794.0,
        8_788_810.0 / 12_288_897.0,
        8_788_810.0 / 73_733_382.0,
    ),
    Vec3::new(
        4_435_075.0 / 24_577_794.0,
        887_015.0 / 12_288_897.0,
        70_074_185.0 / 73_733_382.0,
    ),
);
fn xyz(linear: Vec3) -> Vec3 {
    XYZ_FROM_LINEAR.mul_vec3(linear)
}

fn white() -> Vec3 {
    xyz(Vec3::ONE)
}

fn ycxcz(xyz: Vec3) -> Vec3 {
    let n = xyz / white();
    Vec3::new(116.0 * n.y - 16.0, 500.0 * (n.x - n.y), 200.0 * (n.y - n.z))
}

fn xyz_from_ycxcz(p: Vec3) -> Vec3 {
    let y = (p.x + 16.0) / 116.0;
    Vec3::new(y + p.y / 500.0, y, y - p.z / 200.0) * white()
}

fn lab(xyz: Vec3) -> Vec3 {
    let f = |t: f32| {
        const DELTA: f32 = 6.0 / 29.0;
        if t > DELTA * DELTA * DELTA {
            libm::cbrtf(t)
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let [x, y, z] = (xyz / white()).to_array().map(f);
    Vec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// Colours look paler where it is dark.
fn hunt(lab: Vec3) -> Vec3 {
    let pale = 0.01 * lab.x;
    Vec3::new(lab.x, pale * lab.y, pale * lab.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 48;
    const HEIGHT: usize = 32;

    /// A busy picture, and another for each `k`.
    fn picture(k: i32) -> Vec<Vec3> {
        let pixel = |i: usize| {
            let (x, y) = ((i % WIDTH) as i32, (i / WIDTH) as i32);
            Vec3::new(
                ((x * 5 + y * 3) % 64) as f32 / 63.0,
                ((x * y + k * 7) % 32) as f32 / 31.0,
                (((x - 20).abs() + (y - 11).abs() * k) % 48) as f32 / 47.0,
            )
        };
        (0..WIDTH * HEIGHT).map(pixel).collect()
    }

    fn mean(map: &[f32]) -> f64 {
        map.iter().map(|&x| f64::from(x)).sum::<f64>() / map.len() as f64
    }

    #[test]
    fn the_errors_are_those_of_the_authors_own_program() {
        // From flip-evaluator 1.7: mean, and the pixels (7, 5), (24, 16) and (47, 31).
        let faded: Vec<Vec3> = picture(1).iter().map(|&p| p * 0.5 + 0.3).collect();
        let mut patched = picture(1);
        for (i, pixel) in patched.iter_mut().enumerate() {
            if (10..20).contains(&(i / WIDTH)) && (10..30).contains(&(i % WIDTH)) {
                *pixel = Vec3::X;
            }
        }
        let known = [
            (picture(2), [0.480_017, 0.433_103, 0.352_427, 0.774_587]),
            (faded, [0.401_866, 0.380_129, 0.473_637, 0.419_886]),
            (patched, [0.179_917, 0.009_765, 0.968_863, 0.0]),
        ];
        for (number, (test, expected)) in known.into_iter().enumerate() {
            let map = flip(&picture(1), &test, WIDTH);
            let at = |x: usize, y: usize| f64::from(map[y * WIDTH + x]);
            let got = [mean(&map), at(7, 5), at(24, 16), at(47, 31)];
            for (got, expected) in got.iter().zip(expected) {
                assert!(
                    (got - expected).abs() < 2e-3,
                    "picture {number}: {got} instead of {expected}"
                );
            }
        }
    }

    #[test]
    fn the_error_is_zero_for_equals_symmetric_and_grows_with_the_difference() {
        let a = picture(1);
        assert!(flip(&a, &a, WIDTH).iter().all(|&x| x < 1e-6));
        let (ab, ba) = (flip(&a, &picture(2), WIDTH), flip(&picture(2), &a, WIDTH));
        assert!(ab.iter().zip(&ba).all(|(x, y)| (x - y).abs() < 1e-5));
        let mut last = 0.0;
        for step in 1..6 {
            let darker: Vec<Vec3> = a.iter().map(|&p| p * (1.0 - 0.15 * step as f32)).collect();
            let error = mean(&flip(&a, &darker, WIDTH));
            assert!(error > last, "step {step}");
            last = error;
        }
    }
}
