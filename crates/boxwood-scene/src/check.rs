//! What every loaded model keeps, whoever made it.

use crate::{Door, LoadError, Model};

impl Model {
    /// Makes sure that the promises of [`crate::Mesh`], [`crate::Instance`] and [`crate::Material`] hold: finite
    /// positions, array lengths that fit each other, every index in range, no more triangles than allowed.
    ///
    /// Loaders have better errors, with a line or a byte. This is the net below them: linear in the model.
    pub(crate) fn check(&self, door: &Door) -> Result<(), LoadError> {
        let mut triangles = 0;
        for (i, mesh) in self.meshes.iter().enumerate() {
            let wrong = |what: String| Err(door.error(None, format!("mesh {i}: {what}")));
            let count = mesh.positions.len();
            if let Some(v) = mesh
                .positions
                .iter()
                .position(|p| !p.iter().all(|x| x.is_finite()))
            {
                return wrong(format!("vertex {v} is not finite"));
            }
            if !mesh.normals.is_empty() && mesh.normals.len() != count {
                return wrong(format!(
                    "{} normals for {count} vertices",
                    mesh.normals.len()
                ));
            }
            if !mesh.uvs.is_empty() && mesh.uvs.len() != count {
                return wrong(format!(
                    "{} texture coordinates for {count} vertices",
                    mesh.uvs.len()
                ));
            }
            if let Some(t) = mesh
                .indices
                .iter()
                .position(|t| t.iter().any(|&v| v as usize >= count))
            {
                return wrong(format!(
                    "triangle {t} refers to vertices {:?} of {count}",
                    mesh.indices[t]
                ));
            }
            if !mesh.material_of.is_empty() && mesh.material_of.len() != mesh.indices.len() {
                return wrong(format!(
                    "{} materials for {} triangles",
                    mesh.material_of.len(),
                    mesh.indices.len()
                ));
            }
            triangles += mesh.indices.len() as u64;
        }
        if triangles > door.limits().max_triangles {
            return Err(door.error(
                None,
                format!(
                    "has {triangles} triangles, the limit is {}",
                    door.limits().max_triangles
                ),
            ));
        }
        self.check_references(door)
    }

    fn check_references(&self, door: &Door) -> Result<(), LoadError> {
        for (i, instance) in self.instances.iter().enumerate() {
            if instance.mesh as usize >= self.meshes.len() {
                return Err(door.error(None, format!("instance {i} uses mesh {}", instance.mesh)));
            }
            if !instance.world_from_mesh.is_finite() {
                return Err(
                    door.error(None, format!("the transform of instance {i} is not finite"))
                );
            }
        }
        for material in &self.materials {
            if material
                .base_color_texture
                .is_some_and(|t| t as usize >= self.textures.len())
            {
                return Err(door.error(
                    None,
                    format!(
                        "material \"{}\" uses a texture that is not there",
                        material.name
                    ),
                ));
            }
        }
        for texture in &self.textures {
            if u64::from(texture.width) * u64::from(texture.height) != texture.rgba.len() as u64 {
                return Err(door.error(None, format!("texture \"{}\" is not whole", texture.name)));
            }
        }
        Ok(())
    }
}
