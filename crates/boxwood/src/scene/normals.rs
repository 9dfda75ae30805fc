//! Unit normals of many hits.

use super::{Geometry, Scene};
use crate::geom::{Hit, Ray, Triangle};
use crate::simd::fetch_ends;

/// Normals that are asked for together: enough to wait for memory once instead of for each.
const FEW: usize = 256;

impl Scene {
    /// [`Scene::closest_hits`] for whoever asks for [`Scene::unit_normals`] next: the triangles that are hit are brought into the
    /// cache while other rays are on their way.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_hits_fetching(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        let triangles = match &self.geometry {
            Geometry::Triangles(triangles) => triangles.as_slice(),
            _ => &[],
        };
        self.closest_hits_as(rays, hits, |rays, hits| {
            self.query.closest_hits_fetching(rays, hits, triangles);
        });
    }

    /// The unit normals of the triangles with these numbers, as hits and nearest places have them: the face's own, by the order
    /// of its corners. Zero for a triangle without area, and where there is no such triangle, so that `u32::MAX` can stand for no
    /// hit; so zero for all in a scene of instances, whose hits [`Scene::normal`] is for. Computed in double precision, since
    /// squares of lengths may be beyond single precision.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn unit_normals(&self, geoms: &[u32], prims: &[u32], normals: &mut [[f32; 3]]) {
        assert_eq!(prims.len(), normals.len(), "one normal per number");
        assert_eq!(geoms.len(), normals.len(), "one normal per number");
        normals.fill([0.0; 3]);
        let Geometry::Triangles(triangles) = &self.geometry else {
            return;
        };
        let pieces = geoms.chunks(FEW).zip(prims.chunks(FEW));
        for ((geoms, prims), normals) in pieces.zip(normals.chunks_mut(FEW)) {
            self.few_normals(triangles.as_slice(), geoms, prims, normals);
        }
    }

    /// Triangles lie scattered in memory: all are asked for before the first is read.
    fn few_normals(
        &self,
        triangles: &[Triangle],
        geoms: &[u32],
        prims: &[u32],
        normals: &mut [[f32; 3]],
    ) {
        let (mut rows, mut count) = ([0; FEW], 0);
        for (row, &prim) in prims.iter().enumerate() {
            // Whether a ray hits cannot be guessed: not a branch.
            rows[count] = row;
            count += usize::from(prim != u32::MAX);
        }
        let mut found = [None; FEW];
        for (found, &row) in found.iter_mut().zip(&rows[..count]) {
            let number = self
                .range(geoms[row])
                .and_then(|range| range.clone().nth(prims[row] as usize));
            *found = number.and_then(|number| triangles.get(number));
            if let Some(triangle) = found {
                fetch_ends(*triangle);
            }
        }
        for (triangle, &row) in found.iter().zip(&rows[..count]) {
            if let Some(triangle) = triangle {
                normals[row] = unit_normal(triangle);
            }
        }
    }
}

/// Written out, as `map` over arrays is called, not inlined, which took longer than the arithmetic.
#[inline]
fn unit_normal(Triangle([a, b, c]): &Triangle) -> [f32; 3] {
    let (ax, ay, az) = (f64::from(a[0]), f64::from(a[1]), f64::from(a[2]));
    let (bx, by, bz) = (
        f64::from(b[0]) - ax,
        f64::from(b[1]) - ay,
        f64::from(b[2]) - az,
    );
    let (cx, cy, cz) = (
        f64::from(c[0]) - ax,
        f64::from(c[1]) - ay,
        f64::from(c[2]) - az,
    );
    let (x, y, z) = (by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx);
    let length = (x * x + y * y + z * z).sqrt();
    let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
    [(x * scale) as f32, (y * scale) as f32, (z * scale) as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_triangle_has_its_normal_and_what_is_none_has_zero() {
        let flat = [
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [0.0, 3.0, 0.0],
            [1.0, 0.0, 0.0],
        ];
        let huge = flat.map(|corner| corner.map(|x| x * 1e30));
        let scene = Scene::builder()
            .mesh(&flat, &[[0, 1, 2], [0, 2, 1], [0, 1, 3]])
            .mesh(&huge, &[[0, 1, 2]])
            .build()
            .unwrap();
        let wanted = [
            ((0, 0), [0.0, 0.0, 1.0]),
            ((u32::MAX, u32::MAX), [0.0; 3]),
            ((0, 1), [0.0, 0.0, -1.0]),
            ((0, 2), [0.0; 3]),
            ((0, 3), [0.0; 3]),
            ((1, 0), [0.0, 0.0, 1.0]),
            ((1, u32::MAX), [0.0; 3]),
            ((2, 0), [0.0; 3]),
        ];
        let many = wanted.iter().cycle().take(3 * FEW + 5);
        let (numbers, wanted): (Vec<_>, Vec<_>) = many.copied().unzip();
        let (geoms, prims): (Vec<u32>, Vec<u32>) = numbers.into_iter().unzip();
        let mut normals = vec![[f32::NAN; 3]; wanted.len()];
        scene.unit_normals(&geoms, &prims, &mut normals);
        assert_eq!(normals, wanted);
    }

    #[test]
    fn who_fetches_triangles_gets_the_same_hits_over_whatever_was_there() {
        let square = |z| [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
        let two = [[0, 1, 2], [0, 2, 3]];
        let down = |x| Ray::new([x, 0.3, 9.0], [0.0, 0.0, -1.0]);
        let rays: Vec<Ray> = (0..2000)
            .map(|i| {
                down(if i % 7 == 0 {
                    f32::NAN
                } else {
                    i as f32 * 0.001 - 0.5
                })
            })
            .collect();
        let mut found = vec![None; rays.len()];
        for structure in ["list", "wide", "bvh2"] {
            let scenes = [
                Scene::builder()
                    .mesh(&square(0.0), &two)
                    .mesh(&square(1.0), &two),
                Scene::builder(),
            ];
            for builder in scenes {
                let scene = builder.structure(structure).build().unwrap();
                let mut wanted = vec![None; rays.len()];
                scene.closest_hits(&rays, &mut wanted);
                scene.closest_hits_fetching(&rays, &mut found);
                assert_eq!(found, wanted, "{structure}");
                assert_eq!(wanted.iter().any(Option::is_some), !scene.is_empty());
            }
        }
    }
}
