//! Scenes that change: a new scene out of an old one, which stays as it is for whoever is asking it.

use super::{Scene, gather_mesh};
use crate::error::BuildError;
use crate::geom::Triangle;
use crate::prims::{Geometry, Triangles};
use crate::stats::Stats;

/// How much dearer a structure may become, by its SAH cost, before it is built anew.
const WORN_OUT: f64 = 1.3;

impl Scene {
    /// The same scene with mesh `geom` at other positions: as many triangles as it had, any vertices.
    ///
    /// This scene stays as it is, and whoever asks it gets its answers. Where the structure can (`bvh2`), it is not built anew
    /// but refitted: the tree stays, its volumes are taken anew. Over boxes that is some five times faster; fitting spheres
    /// and oriented boxes is most of their build. Trees wear out by it: as soon as the SAH cost
    /// ([`Stats::sah_cost`](crate::Stats::sah_cost)) has grown by more than 30 % since the last build, or other triangles than
    /// before can be hit, the scene is built again ([`Scene::is_refitted`] tells). Answers are the same either way.
    ///
    /// The cost is that of all meshes of this scene. A mesh that moves often is better a scene of its own, with an
    /// [`Instance`](crate::Instance) in the scene around.
    ///
    /// # Errors
    /// If there is no such mesh, another number of triangles, or an index is not below `positions.len()`.
    pub fn with_mesh(
        &self,
        geom: u32,
        positions: &[[f32; 3]],
        indices: &[[u32; 3]],
    ) -> Result<Self, BuildError> {
        let Geometry::Triangles(old) = &self.geometry else {
            return Err(BuildError::NoSuchMesh { geom, meshes: 0 });
        };
        let old = old.as_slice();
        let range = self.range(geom).ok_or(BuildError::NoSuchMesh {
            geom,
            meshes: self.starts.len(),
        })?;
        if range.len() != indices.len() {
            return Err(BuildError::WrongCount {
                what: "triangles",
                expected: range.len(),
                found: indices.len(),
            });
        }
        let mut triangles: Vec<Triangle> = Vec::with_capacity(old.len());
        triangles.extend_from_slice(&old[..range.start]);
        gather_mesh(geom as usize, positions, indices, &mut triangles)?;
        triangles.extend_from_slice(&old[range.end..]);
        self.with_geometry(Geometry::Triangles(Triangles::new(triangles)))
    }

    /// True if the structure was made by [`Scene::with_mesh`] from an older one's.
    pub fn is_refitted(&self) -> bool {
        self.is_refitted
    }

    /// Refits, or builds where that does not do.
    fn with_geometry(&self, geometry: Geometry) -> Result<Self, BuildError> {
        let refitted = self.query.refitted(&geometry).filter(|query| {
            let cost = Stats::of(&**query).sah_cost;
            // Not a number: a scene without area, which is soon built.
            cost <= WORN_OUT * self.built_cost()
        });
        let built_cost = self.built_cost.clone();
        let is_refitted = refitted.is_some();
        let new = Self::of(
            geometry,
            self.starts.clone(),
            self.structure,
            &self.options,
            refitted,
        )?;
        Ok(match is_refitted {
            true => Self {
                built_cost,
                is_refitted,
                ..new
            },
            false => new,
        })
    }

    /// The SAH cost as it was when the structure was built.
    fn built_cost(&self) -> f64 {
        *self.built_cost.get_or_init(|| self.stats().sah_cost)
    }
}
