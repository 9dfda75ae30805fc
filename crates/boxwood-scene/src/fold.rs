//! Meshes that are shown again and again, kept once.

use std::sync::Arc;

use boxwood::{BuildError, BuildOptions, Scene, Transform};

use crate::flatten::Placement;
use crate::{Door, FlatMesh, Instance, Limits, LoadError, Model};

/// A [`Model`] made ready for structures that hold instances: the opposite of [`Model::flatten`].
#[derive(Clone, Debug, Default)]
pub struct Folded {
    /// In the world: what is shown once. Everything, if folding does not pay.
    pub once: FlatMesh,
    /// What is shown more than once, each in its own space.
    pub parts: Vec<FlatMesh>,
    /// Where the parts stand, in the model's order; [`Instance::mesh`] counts in `parts`.
    pub instances: Vec<Instance>,
}

impl Folded {
    /// True if there are parts.
    pub fn is_folded(&self) -> bool {
        !self.instances.is_empty()
    }

    /// The scene: of the one mesh, or of instances. Instance `i` is `instances[i]`, and the last one, [`Folded::once`], if there is
    /// anything, stands where it is. Parts and whole get the same structure.
    pub fn build(&self, structure: &str, options: &BuildOptions) -> Result<Scene, BuildError> {
        let builder = || {
            Scene::builder()
                .structure(structure)
                .options(options.clone())
        };
        let of = |mesh: &FlatMesh| builder().mesh(&mesh.positions, &mesh.indices).build();
        if !self.is_folded() {
            return of(&self.once);
        }
        let parts: Vec<_> = self
            .parts
            .iter()
            .map(|part| of(part).map(Arc::new))
            .collect::<Result<_, _>>()?;
        let placed = self.instances.iter().map(|instance| {
            let at = Transform::from_columns(instance.world_from_mesh.to_cols_array_2d());
            boxwood::Instance::new(&parts[instance.mesh as usize], at)
        });
        let mut scene = builder().instances(placed);
        if !self.once.indices.is_empty() {
            scene = scene.instance(&Arc::new(of(&self.once)?), Transform::IDENTITY);
        }
        scene.build()
    }

    /// Triangles with every instance multiplied out.
    pub fn triangle_count(&self) -> u64 {
        let of_parts = self.instances.iter();
        let of_part = |i: &Instance| self.parts[i.mesh as usize].indices.len() as u64;
        self.once.indices.len() as u64 + of_parts.map(of_part).sum::<u64>()
    }
}

impl Model {
    /// True if instances save enough to be worth turning every ray for: half of the triangles or more.
    pub fn repeats(&self) -> bool {
        self.triangle_count() >= self.unique_triangle_count().saturating_mul(2)
            && self.unique_triangle_count() > 0
    }

    /// Keeps meshes that are shown more than once as parts with instances, where the model [repeats](Model::repeats); the
    /// rest is [flattened](Model::flatten) into one mesh.
    ///
    /// Refused is what `flatten` refuses of the rest; a part may be moved wherever its instance says, and is never hit
    /// where numbers end.
    pub fn fold(&self) -> Result<Folded, LoadError> {
        if !self.repeats() {
            return Ok(Folded {
                once: self.flatten()?,
                ..Folded::default()
            });
        }
        self.check(&Door::without_files("scene", Limits::default()))?;
        let mut uses = vec![0_u32; self.meshes.len()];
        for instance in &self.instances {
            uses[instance.mesh as usize] += 1;
        }
        let is_part = |instance: &Instance| uses[instance.mesh as usize] > 1;
        let (of_parts, rest): (Vec<Instance>, Vec<Instance>) =
            self.instances.iter().copied().partition(is_part);
        let once = self.flatten_of(&rest)?;

        let mut folded = Folded {
            once,
            ..Folded::default()
        };
        let mut part_of = vec![u32::MAX; self.meshes.len()];
        for instance in of_parts {
            let part = &mut part_of[instance.mesh as usize];
            if *part == u32::MAX {
                *part = folded.parts.len() as u32;
                let mesh = &self.meshes[instance.mesh as usize];
                let (has_normals, has_uvs) = (!mesh.normals.is_empty(), !mesh.uvs.is_empty());
                let mut flat = FlatMesh::default();
                flat.append(mesh, &Placement::Identity, has_normals, has_uvs);
                folded.parts.push(flat);
            }
            folded.instances.push(Instance {
                mesh: *part,
                ..instance
            });
        }
        Ok(folded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mesh;
    use glam::{Mat4, Vec3};

    fn mesh(triangles: usize) -> Mesh {
        Mesh {
            positions: vec![[1.5, -0.0, 0.25], [3.0, 2.0, 0.5], [-1.0, 4.5, 7.0]],
            indices: vec![[0, 1, 2]; triangles],
            ..Mesh::default()
        }
    }

    fn model(uses: &[u32]) -> Model {
        let place = |(i, &mesh): (usize, &u32)| Instance {
            mesh,
            world_from_mesh: Mat4::from_translation(Vec3::splat(i as f32)),
        };
        Model {
            meshes: vec![mesh(3), mesh(5), mesh(1)],
            instances: uses.iter().enumerate().map(place).collect(),
            ..Model::default()
        }
    }

    #[test]
    fn what_repeats_is_kept_once_and_the_rest_is_flattened() {
        let model = model(&[1, 0, 1, 1, 1]);
        let folded = model.fold().unwrap();
        assert_eq!(folded.once.indices.len(), 3);
        assert_eq!(folded.once.positions[0], [2.5, 1.0, 1.25], "in the world");
        assert_eq!((folded.parts.len(), folded.parts[0].indices.len()), (1, 5));
        assert_eq!(folded.parts[0].positions, mesh(5).positions);
        let steps: Vec<f32> = folded
            .instances
            .iter()
            .map(|i| i.world_from_mesh.w_axis.x)
            .collect();
        assert_eq!(steps, [0.0, 2.0, 3.0, 4.0]);
        assert_eq!(folded.triangle_count(), model.triangle_count());
    }

    #[test]
    fn what_hardly_repeats_is_flattened_as_a_whole() {
        let model = model(&[0, 0, 1, 2]);
        let folded = model.fold().unwrap();
        assert!(!folded.is_folded() && !model.repeats());
        assert_eq!(folded.once.indices, model.flatten().unwrap().indices);
        assert!(!Model::default().fold().unwrap().is_folded());
    }

    #[test]
    fn broken_models_are_errors() {
        let mut model = model(&[0, 0, 0, 0]);
        model.instances[1].mesh = 7;
        assert!(model.fold().is_err());
    }
}
