//! Clay for the built-in scenes: surfaces of revolution, tubes, plates.

use glam::DVec3;

use crate::Mesh;

/// A mesh in the making. Works in f64 and rounds once.
pub(super) struct Shape {
    mesh: Mesh,
}

impl Shape {
    pub(super) fn new(name: &str) -> Self {
        Self {
            mesh: Mesh {
                name: name.to_owned(),
                ..Mesh::default()
            },
        }
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.mesh.indices.len()
    }

    pub(super) fn vertex(&mut self, p: DVec3) -> u32 {
        self.mesh.positions.push(p.as_vec3().to_array());
        self.mesh.positions.len() as u32 - 1
    }

    /// A vertex with a unit normal. A shape uses either this everywhere, or [`Shape::vertex`].
    pub(super) fn vertex_with_normal(&mut self, p: DVec3, normal: DVec3) -> u32 {
        self.mesh.normals.push(normal.as_vec3().to_array());
        self.vertex(p)
    }

    /// Counter-clockwise as seen from the front. A triangle with two corners in one place is left out, so that poles
    /// and doubled profile points need no special case.
    pub(super) fn triangle(&mut self, corners: [u32; 3], material: u32) {
        let [a, b, c] = corners.map(|v| self.mesh.positions[v as usize]);
        if a != b && b != c && c != a {
            self.mesh.indices.push(corners);
            self.mesh.material_of.push(material);
        }
    }

    pub(super) fn quad(&mut self, [a, b, c, d]: [u32; 4], material: u32) {
        self.triangle([a, b, c], material);
        self.triangle([a, c, d], material);
    }

    /// A quad whose two triangles get the material that `material` finds for their corners.
    pub(super) fn quad_by(&mut self, [a, b, c, d]: [u32; 4], material: impl Fn([DVec3; 3]) -> u32) {
        for corners in [[a, b, c], [a, c, d]] {
            let material = material(corners.map(|v| self.position(v)));
            self.triangle(corners, material);
        }
    }

    /// A quad with vertices of its own, as flat plates need.
    pub(super) fn plate(&mut self, corners: [DVec3; 4], material: u32) {
        let corners = corners.map(|p| self.vertex(p));
        self.quad(corners, material);
    }

    /// A skin over `rings` closed rings of `sides` points each. Seen from the front, a ring runs to the right and the
    /// next ring lies above it.
    pub(super) fn skin(
        &mut self,
        rings: usize,
        sides: usize,
        mut point: impl FnMut(usize, usize) -> DVec3,
        mut material: impl FnMut(usize, usize) -> u32,
    ) {
        let first = self.mesh.positions.len();
        for ring in 0..rings {
            for side in 0..sides {
                self.vertex(point(ring, side));
            }
        }
        let at = |ring: usize, side: usize| (first + ring * sides + side % sides) as u32;
        for ring in 1..rings {
            for side in 0..sides {
                let corners = [
                    at(ring - 1, side),
                    at(ring - 1, side + 1),
                    at(ring, side + 1),
                    at(ring, side),
                ];
                self.quad(corners, material(ring - 1, side));
            }
        }
    }

    /// The surface of revolution of `profile` (x is the radius, y the height, from bottom to top on the outside)
    /// about the y axis. A doubled point makes a crease once [`Shape::smooth`] is applied.
    pub(super) fn lathe(&mut self, profile: &[DVec3], sides: usize, material: u32) {
        let circle = circle(sides);
        let point = |ring: usize, side: usize| {
            let (sin, cos) = circle[side];
            DVec3::new(
                profile[ring].x * cos,
                profile[ring].y,
                -profile[ring].x * sin,
            )
        };
        self.skin(profile.len(), sides, point, |_, _| material);
    }

    /// A tube along `path`, with the radius at each point. Its frame is carried along without twist. Open at the ends.
    pub(super) fn tube(&mut self, path: &[DVec3], radii: &[f64], sides: usize, material: u32) {
        let circle = circle(sides);
        let mut across = DVec3::ZERO;
        let mut frames = Vec::with_capacity(path.len());
        for i in 0..path.len() {
            let along = (path[(i + 1).min(path.len() - 1)] - path[i.saturating_sub(1)])
                .normalize_or(DVec3::Y);
            let carried = across - along * across.dot(along);
            across = carried
                .try_normalize()
                .unwrap_or_else(|| any_orthonormal(along));
            frames.push((across, along.cross(across)));
        }
        let point = |ring: usize, side: usize| {
            let (sin, cos) = circle[side];
            let (x, y) = frames[ring];
            path[ring] + (x * cos + y * sin) * radii[ring]
        };
        self.skin(path.len(), sides, point, |_, _| material);
    }

    fn position(&self, vertex: u32) -> DVec3 {
        glam::Vec3::from(self.mesh.positions[vertex as usize]).as_dvec3()
    }

    /// Applies `place` to each vertex. For shapes without normals.
    pub(super) fn place(&mut self, place: impl Fn(DVec3) -> DVec3) {
        for p in &mut self.mesh.positions {
            *p = place(glam::Vec3::from(*p).as_dvec3()).as_vec3().to_array();
        }
    }

    /// The mesh as made: with the normals of [`Shape::vertex_with_normal`], or with none, each triangle flat.
    pub(super) fn finish(self) -> Mesh {
        self.mesh
    }

    /// The mesh with vertex normals: the mean of the triangles around, by area.
    pub(super) fn smooth(mut self) -> Mesh {
        let mut sums = vec![DVec3::ZERO; self.mesh.positions.len()];
        for triangle in &self.mesh.indices {
            let [a, b, c] = triangle.map(|v| self.position(v));
            for &v in triangle {
                sums[v as usize] += (b - a).cross(c - a);
            }
        }
        // Vertices that no triangle uses (at poles and creases) get an arbitrary unit normal.
        self.mesh.normals = sums
            .iter()
            .map(|sum| sum.normalize_or(DVec3::Y).as_vec3().to_array())
            .collect();
        self.mesh
    }
}

/// Sine and cosine of `sides` equal steps around the circle.
pub(super) fn circle(sides: usize) -> Vec<(f64, f64)> {
    (0..sides)
        .map(|side| libm::sincos(side as f64 * std::f64::consts::TAU / sides as f64))
        .collect()
}

/// The profile of the unit ball from pole to pole, for [`Shape::lathe`]; the poles lie exactly on the axis.
pub(super) fn ball_profile(steps: usize) -> impl Iterator<Item = DVec3> {
    (0..=steps).map(move |step| {
        let (sin, cos) = libm::sincos(step as f64 * std::f64::consts::PI / steps as f64);
        let radius = if step == 0 || step == steps { 0.0 } else { sin };
        DVec3::new(radius, -cos, 0.0)
    })
}

/// A unit vector at a right angle to the unit vector `n`.
pub(super) fn any_orthonormal(n: DVec3) -> DVec3 {
    let helper = if n.x.abs() < 0.6 { DVec3::X } else { DVec3::Z };
    n.cross(helper).normalize()
}

/// A smooth curve through `points`, `steps` points for each piece between two of them, and the last point.
///
/// Catmull, Rom, "A class of local interpolating splines", 1974; uniform, the ends doubled.
pub(super) fn smooth_curve(points: &[DVec3], steps: usize) -> Vec<DVec3> {
    let last = points.len() - 1;
    let mut curve = Vec::with_capacity(last * steps + 1);
    for i in 0..last {
        let [a, b, c, d] = [
            points[i.saturating_sub(1)],
            points[i],
            points[i + 1],
            points[(i + 2).min(last)],
        ];
        for step in 0..steps {
            let t = step as f64 / steps as f64;
            curve.push(
                b + ((c - a)
                    + ((a * 2.0 - b * 5.0 + c * 4.0 - d) + (b * 3.0 - a - c * 3.0 + d) * t) * t)
                    * (0.5 * t),
            );
        }
    }
    curve.push(points[last]);
    curve
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lathe_shows_its_outside() {
        let mut shape = Shape::new("ball");
        let profile: Vec<_> = ball_profile(8).collect();
        shape.lathe(&profile, 12, 0);
        let mesh = shape.smooth();
        for (p, n) in mesh
            .positions
            .iter()
            .zip(&mesh.normals)
            .skip(12)
            .take(12 * 7)
        {
            assert!(p.iter().zip(n).map(|(p, n)| p * n).sum::<f32>() > 0.9);
        }
        assert_eq!(
            mesh.indices.len(),
            12 * 2 * 7,
            "the poles have one triangle a side"
        );
    }

    #[test]
    fn a_tube_shows_its_outside_and_keeps_its_radius() {
        let path: Vec<_> = (0..9)
            .map(|i| DVec3::new(f64::from(i), f64::from(i * i) * 0.1, 0.0))
            .collect();
        let mut shape = Shape::new("tube");
        shape.tube(&path, &[0.5; 9], 7, 0);
        let mesh = shape.smooth();
        for (i, (p, n)) in mesh.positions.iter().zip(&mesh.normals).enumerate() {
            let out = glam::Vec3::from(*p).as_dvec3() - path[i / 7];
            assert!((out.length() - 0.5).abs() < 1e-6);
            assert!(out.normalize().dot(glam::Vec3::from(*n).as_dvec3()) > 0.8);
        }
    }

    #[test]
    fn a_smooth_curve_goes_through_its_points() {
        let points = [
            DVec3::ZERO,
            DVec3::new(1.0, 2.0, 0.0),
            DVec3::new(3.0, 2.5, 1.0),
        ];
        let curve = smooth_curve(&points, 4);
        assert_eq!([curve[0], curve[4], curve[8]], points);
    }
}
