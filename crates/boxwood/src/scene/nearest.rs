//! Distances: where a surface is nearest to a point, and on which side of it the point is.

mod curve;

use super::{Scene, for_pieces};
use crate::geom::{Nearest, Ray};
use curve::along_curve;

/// Where rays that count surfaces go: not along anything that is built along axes.
const OUT: [f32; 3] = [0.577_215_7, 0.261_497_2, 0.774_596_7];

/// Points that one task answers, at most: the more, the closer are neighbours.
const PIECE: usize = 1 << 16;

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

    /// [`Scene::closest_point`] for each point, on the threads of the caller's rayon pool. Many points are quicker than as many calls:
    /// neighbours are answered one after the other.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_points(&self, points: &[[f32; 3]], nearest: &mut [Option<Nearest>]) {
        assert_eq!(points.len(), nearest.len(), "one answer per point");
        for_pieces(PIECE, points, nearest, |points, nearest| {
            along_curve(points, nearest, |points, nearest| {
                self.query.nearest_each(points, nearest);
                if self.starts.len() > 1 {
                    for place in nearest.iter_mut().flatten() {
                        *place = self.locate_nearest(*place);
                    }
                }
            });
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
        for_pieces(PIECE, points, distances, |points, distances| {
            along_curve(points, distances, |points, distances| {
                let mut nearest = vec![None; points.len()];
                self.query.nearest_each(points, &mut nearest);
                let inside = self.counts_odd(points);
                for ((place, inside), answer) in nearest.iter().zip(inside).zip(distances) {
                    let side = if inside { -1.0 } else { 1.0 };
                    *answer = place.map_or(f32::NAN, |place| side * place.distance);
                }
            });
        });
    }

    /// True for each point that is inside, as [`Scene::signed_distances`] has it.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn is_inside_each(&self, points: &[[f32; 3]], inside: &mut [bool]) {
        assert_eq!(points.len(), inside.len(), "one answer per point");
        for_pieces(PIECE, points, inside, |points, inside| {
            along_curve(points, inside, |points, inside| {
                inside.copy_from_slice(&self.counts_odd(points));
            });
        });
    }

    /// Whether the ray outward meets an odd number of surfaces, for each point.
    fn counts_odd(&self, points: &[[f32; 3]]) -> Vec<bool> {
        let bounds = &self.bounds;
        let is_in_box = |point: &[f32; 3]| {
            (0..3).all(|k| bounds.min[k] <= point[k] && point[k] <= bounds.max[k])
        };
        let asked: Vec<_> = (0..points.len())
            .filter(|&place| is_in_box(&points[place]))
            .collect();
        let ray = |&place: &usize| Ray::new(points[place], OUT);
        let rays: Vec<_> = asked.iter().map(ray).collect();
        let mut counts = vec![0; rays.len()];
        self.query.count_each(&rays, &mut counts);
        let mut odd = vec![false; points.len()];
        for (place, count) in asked.into_iter().zip(counts) {
            odd[place] = count % 2 == 1;
        }
        odd
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
