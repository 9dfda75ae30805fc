//! Distances: where a surface is nearest to a point, and on which side of it the point is.

use super::{Scene, for_chunks};
use crate::geom::{Hit, Nearest, Ray};

/// Where rays that count surfaces go: not along anything that is built along axes.
const OUT: [f32; 3] = [0.577_215_7, 0.261_497_2, 0.774_596_7];

impl Scene {
    /// The place of the surface that is nearest to a point: of equally near ones that of the smallest (geometry, primitive).
    ///
    /// `None` for a point that is not finite, and in a scene without triangles. Distances are computed in double precision, so
    /// that every structure and instruction set gives the same bits.
    pub fn closest_point(&self, point: [f32; 3]) -> Option<Nearest> {
        let mut nearest = [None];
        self.query.nearest_each(&[point], &mut nearest);
        nearest[0].map(|nearest| self.locate_nearest(nearest))
    }

    /// [`Scene::closest_point`] for each point, on the threads of the caller's rayon pool. Points in rows or clouds are quicker
    /// than points at random.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_points(&self, points: &[[f32; 3]], nearest: &mut [Option<Nearest>]) {
        assert_eq!(points.len(), nearest.len(), "one answer per point");
        for_chunks(points, nearest, |points, nearest| {
            self.query.nearest_each(points, nearest);
            for place in nearest.iter_mut().flatten() {
                *place = self.locate_nearest(*place);
            }
        });
    }

    /// Distance to the surface, negative inside, for each point; NaN where [`Scene::closest_point`] has no answer.
    ///
    /// Inside is where a ray to the outside meets an odd number of surfaces. On a closed mesh the sign is exact, since every edge
    /// is met exactly once; on an open one it is that of this rule, for one direction, the same for all points. Outside the box
    /// around the scene nothing is inside.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn signed_distances(&self, points: &[[f32; 3]], distances: &mut [f32]) {
        assert_eq!(points.len(), distances.len(), "one answer per point");
        for_chunks(points, distances, |points, distances| {
            let mut nearest = vec![None; points.len()];
            self.query.nearest_each(points, &mut nearest);
            let mut hits = Vec::new();
            for ((point, place), answer) in points.iter().zip(nearest).zip(distances) {
                let side = |inside: bool| if inside { -1.0 } else { 1.0 };
                *answer = place.map_or(f32::NAN, |place| {
                    side(self.counts_odd(*point, &mut hits)) * place.distance
                });
            }
        });
    }

    /// True for each point that is inside, as [`Scene::signed_distances`] has it.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn is_inside_each(&self, points: &[[f32; 3]], inside: &mut [bool]) {
        assert_eq!(points.len(), inside.len(), "one answer per point");
        for_chunks(points, inside, |points, inside| {
            let mut hits = Vec::new();
            for (point, answer) in points.iter().zip(inside) {
                *answer = self.counts_odd(*point, &mut hits);
            }
        });
    }

    /// Whether the ray outward meets an odd number of surfaces.
    fn counts_odd(&self, point: [f32; 3], hits: &mut Vec<Hit>) -> bool {
        let is_apart =
            |k: usize| !(self.bounds.min[k] <= point[k] && point[k] <= self.bounds.max[k]);
        if (0..3).any(is_apart) {
            return false;
        }
        self.query.all_hits(&Ray::new(point, OUT), hits);
        hits.len() % 2 == 1
    }

    /// As [`Scene::locate`].
    fn locate_nearest(&self, nearest: Nearest) -> Nearest {
        let [geom, prim] = self.mesh_of(nearest.prim);
        Nearest {
            geom,
            prim,
            ..nearest
        }
    }
}
