//! What tells one scene from another: a hash of all that a picture of it depends on.

use boxwood_scene::{FlatMesh, Instance, Material, Texture};

use crate::Surfaces;

/// BLAKE3 of the triangles, normals, texture coordinates, materials, textures and places of `surfaces`, as 64 hexadecimal digits.
///
/// The same for the same scene from another file or on another machine; names do not count. About a second for a gigabyte.
pub fn scene_hash(surfaces: &Surfaces<'_>) -> String {
    let mut sum = Sum::default();
    sum.number(surfaces.stored().count() as u64);
    for mesh in surfaces.stored() {
        sum.mesh(mesh);
    }
    sum.all(surfaces.instances(), Sum::instance);
    sum.all(surfaces.materials(), Sum::material);
    sum.all(surfaces.textures(), Sum::texture);
    sum.flush();
    sum.hasher.finalize().to_hex().to_string()
}

/// Bytes enough for the hasher's widest step.
const CHUNK: usize = 1 << 16;

#[derive(Default)]
struct Sum {
    hasher: blake3::Hasher,
    waiting: Vec<u8>,
}

impl Sum {
    fn flush(&mut self) {
        self.hasher.update(&self.waiting);
        self.waiting.clear();
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.waiting.extend_from_slice(bytes);
        if self.waiting.len() >= CHUNK {
            self.flush();
        }
    }

    fn number(&mut self, number: u64) {
        self.bytes(&number.to_le_bytes());
    }

    /// By their bits: even the sign of zero counts.
    fn floats<const N: usize>(&mut self, floats: &[f32; N]) {
        for x in floats {
            self.bytes(&x.to_le_bytes());
        }
    }

    /// Their number goes before them, so that no two lists run together.
    fn all<T>(&mut self, list: &[T], each: fn(&mut Self, &T)) {
        self.number(list.len() as u64);
        for item in list {
            each(self, item);
        }
    }

    fn mesh(&mut self, mesh: &FlatMesh) {
        self.all(&mesh.positions, Self::floats);
        self.all(&mesh.normals, Self::floats);
        self.all(&mesh.uvs, Self::floats);
        self.all(&mesh.indices, |sum, corners| {
            for index in corners {
                sum.bytes(&index.to_le_bytes());
            }
        });
        self.all(&mesh.material_of, |sum, index| {
            sum.bytes(&index.to_le_bytes());
        });
    }

    fn instance(&mut self, instance: &Instance) {
        self.number(instance.mesh.into());
        self.floats(&instance.world_from_mesh.to_cols_array());
    }

    fn material(&mut self, material: &Material) {
        let Material {
            name: _,
            base_color,
            base_color_texture,
            emission,
            metallic,
            roughness,
        } = material;
        self.floats(base_color);
        self.number(base_color_texture.map_or(u64::MAX, u64::from));
        self.floats(emission);
        self.floats(&[*metallic, *roughness]);
    }

    fn texture(&mut self, texture: &Texture) {
        self.number(texture.width.into());
        self.number(texture.height.into());
        self.bytes(texture.rgba.as_flattened());
    }
}

#[cfg(test)]
mod tests {
    use boxwood_scene::{Model, builtin};

    use super::*;

    fn hash(model: &Model) -> String {
        let folded = model.fold().unwrap();
        scene_hash(&Surfaces::of_folded(&folded, model))
    }

    #[test]
    fn whatever_is_seen_changes_the_hash_and_names_do_not() {
        let model = builtin("cornell").unwrap();
        let before = hash(&model);
        assert_eq!(before.len(), 64);
        type Change = fn(&mut Model);
        let changes: [(&str, Change); 6] = [
            ("a corner", |m| m.meshes[0].positions[0][1] += 0.25),
            ("a sign", |m| {
                let x = &mut m.meshes[0].positions[0][0];
                *x = if *x == 0.0 { -*x } else { -x.abs() - 1.0 };
            }),
            ("an order", |m| m.meshes[0].indices[0].rotate_left(1)),
            ("a colour", |m| m.materials[0].base_color[2] += 0.25),
            ("a surface", |m| m.materials[0].roughness += 0.25),
            ("a place", |m| {
                m.instances[0].world_from_mesh.w_axis.x += 1.0;
            }),
        ];
        for (what, change) in changes {
            let mut changed = model.clone();
            change(&mut changed);
            assert_ne!(hash(&changed), before, "{what}");
        }
        let mut renamed = model.clone();
        renamed.materials[0].name = "other".to_owned();
        renamed.meshes[0].name = "other".to_owned();
        assert_eq!(hash(&renamed), before);
    }
}
