//! From meshes and their uses to one world-space triangle list.

use glam::Mat4;

use crate::{Door, FlatMesh, Instance, Limits, LoadError, Mesh, Model, Place};

/// Smallest and largest coordinates.
pub type Bounds = ([f32; 3], [f32; 3]);

/// Most vertices of a flattened scene: three for each of the most triangles. Beyond, `u32` indices would not do.
const MAX_VERTICES: u64 = 3 << 28;

impl Model {
    /// Triangles after multiplying out the instances. Saturates.
    pub fn triangle_count(&self) -> u64 {
        self.uses()
            .map(|(mesh, _)| mesh.indices.len() as u64)
            .fold(0, u64::saturating_add)
    }

    /// Triangles as stored, each mesh once, used or not.
    pub fn unique_triangle_count(&self) -> u64 {
        self.meshes
            .iter()
            .map(|mesh| mesh.indices.len() as u64)
            .sum()
    }

    /// The box around all triangles in world space, with the same bits as the vertices of [`Model::flatten`].
    ///
    /// `None` without triangles. Vertices that no triangle uses don't count. Touches each triangle of each instance.
    pub fn bounds(&self) -> Option<Bounds> {
        let corners = self.uses().flat_map(|(mesh, instance)| {
            let place = Placement::of(&instance.world_from_mesh);
            mesh.indices
                .iter()
                .flatten()
                .filter_map(move |&v| Some(place.point(*mesh.positions.get(v as usize)?)))
        });
        bounds_of(corners)
    }

    /// Multiplies the instances out into one triangle list.
    ///
    /// Triangles come in instance order, within an instance in mesh order. An identity transform keeps every bit.
    /// A mirrored instance (negative determinant) has the last two corners of each triangle swapped, so that front
    /// faces stay front faces. Normals go by the inverse transpose and are unit length, zero where a mesh has none.
    ///
    /// Refused, by the name of the instance where one is to blame: more than 2^28 triangles, coordinates that leave
    /// `f32`, and models whose indices don't fit their arrays. Time and memory are linear in the result.
    pub fn flatten(&self) -> Result<FlatMesh, LoadError> {
        self.check(&Door::without_files("scene", Limits::default()))?;
        self.flatten_of(&self.instances)
    }

    /// Multiplies out a choice of the instances of a model that is [checked](Model::check).
    pub(crate) fn flatten_of(&self, instances: &[Instance]) -> Result<FlatMesh, LoadError> {
        let door = Door::without_files("scene", Limits::default());
        self.check_flat_size(instances, &door)?;

        let used = |has: fn(&Mesh) -> bool| self.uses_in(instances).any(|(mesh, _)| has(mesh));
        let has_normals = used(|mesh| !mesh.normals.is_empty());
        let has_uvs = used(|mesh| !mesh.uvs.is_empty());
        let mut flat = FlatMesh::default();
        for (i, (mesh, instance)) in self.uses_in(instances).enumerate() {
            let place = Placement::of(&instance.world_from_mesh);
            let first = flat.positions.len();
            flat.append(mesh, &place, has_normals, has_uvs);
            if !flat.positions[first..]
                .iter()
                .flatten()
                .all(|x| x.is_finite())
            {
                let path = Place::Path(format!("instance {i}"));
                return Err(door.error(
                    Some(path),
                    format!("moves mesh {} out of the range of f32", instance.mesh),
                ));
            }
        }
        Ok(flat)
    }

    /// Each instance with its mesh. Instances of meshes that don't exist are left out ([`Model::check`] finds them).
    fn uses(&self) -> impl Iterator<Item = (&Mesh, &Instance)> {
        self.uses_in(&self.instances)
    }

    fn uses_in<'a>(
        &'a self,
        instances: &'a [Instance],
    ) -> impl Iterator<Item = (&'a Mesh, &'a Instance)> {
        instances
            .iter()
            .filter_map(|instance| Some((self.meshes.get(instance.mesh as usize)?, instance)))
    }

    fn check_flat_size(&self, instances: &[Instance], door: &Door) -> Result<(), LoadError> {
        let limit = door.limits().max_triangles;
        let triangles = self
            .uses_in(instances)
            .map(|(mesh, _)| mesh.indices.len() as u64)
            .fold(0, u64::saturating_add);
        let vertices = self
            .uses_in(instances)
            .map(|(mesh, _)| mesh.positions.len() as u64)
            .fold(0, u64::saturating_add);
        if triangles > limit {
            let cause = format!(
                "its {} instances multiply out to {triangles} triangles, the limit is {limit}",
                instances.len()
            );
            return Err(door
                .error(None, cause)
                .with_remedy("keep the instances (`Model::fold`), or simplify the meshes"));
        }
        if vertices > MAX_VERTICES {
            let cause = format!(
                "its instances multiply out to {vertices} vertices, the limit is {MAX_VERTICES}"
            );
            return Err(door.error(None, cause));
        }
        Ok(())
    }
}

impl FlatMesh {
    /// The box around all triangles; `None` without triangles.
    pub fn bounds(&self) -> Option<Bounds> {
        bounds_of(
            self.indices
                .iter()
                .flatten()
                .map(|&v| self.positions[v as usize]),
        )
    }

    pub(crate) fn append(
        &mut self,
        mesh: &Mesh,
        place: &Placement,
        has_normals: bool,
        has_uvs: bool,
    ) {
        // Check_flat_size keeps the count below 3 * 2^28.
        let first = self.positions.len() as u32;
        self.positions
            .extend(mesh.positions.iter().map(|&p| place.point(p)));
        if has_normals {
            self.normals
                .extend(mesh.normals.iter().map(|&n| place.normal(n)));
            self.normals.resize(self.positions.len(), [0.0; 3]);
        }
        if has_uvs {
            self.uvs.extend_from_slice(&mesh.uvs);
            self.uvs.resize(self.positions.len(), [0.0; 2]);
        }
        let mirrored = place.mirrored();
        self.indices.extend(mesh.indices.iter().map(|&[a, b, c]| {
            let [b, c] = if mirrored { [c, b] } else { [b, c] };
            [first + a, first + b, first + c]
        }));
        self.material_of.extend_from_slice(&mesh.material_of);
        self.material_of.resize(self.indices.len(), u32::MAX);
    }
}

/// An affine map, written out in scalar arithmetic so that every machine gives the same bits.
pub(crate) enum Placement {
    /// Keeps even the sign of zero.
    Identity,
    /// Columns x, y, z and the translation; then the cofactors, which carry normals.
    Affine {
        columns: [[f32; 3]; 4],
        cofactors: [[f64; 3]; 3],
        determinant: f64,
    },
}

impl Placement {
    fn of(world_from_mesh: &Mat4) -> Self {
        if *world_from_mesh == Mat4::IDENTITY {
            return Self::Identity;
        }
        let columns = world_from_mesh
            .to_cols_array_2d()
            .map(|[x, y, z, _]| [x, y, z]);
        let [x, y, z] = [0, 1, 2].map(|i| columns[i].map(f64::from));
        // The columns of the cofactor matrix, which is the inverse transpose times the determinant.
        let cofactors = [cross(y, z), cross(z, x), cross(x, y)];
        let determinant = (0..3).map(|i| x[i] * cofactors[0][i]).sum();
        Self::Affine {
            columns,
            cofactors,
            determinant,
        }
    }

    fn mirrored(&self) -> bool {
        matches!(self, Self::Affine { determinant, .. } if *determinant < 0.0)
    }

    fn point(&self, p: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Identity => p,
            Self::Affine {
                columns: [x, y, z, origin],
                ..
            } => [0, 1, 2].map(|i| x[i] * p[0] + y[i] * p[1] + z[i] * p[2] + origin[i]),
        }
    }

    /// Zero if `n` or the map is degenerate.
    fn normal(&self, n: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Identity => n,
            Self::Affine {
                cofactors: [x, y, z],
                determinant,
                ..
            } => {
                let n = n.map(f64::from);
                let turned = [0, 1, 2]
                    .map(|i| (x[i] * n[0] + y[i] * n[1] + z[i] * n[2]) * determinant.signum());
                let length = turned.iter().map(|c| c * c).sum::<f64>().sqrt();
                // At most 1 in size: only precision is lost.
                let unit = turned.map(|c| (c / length) as f32);
                if unit.iter().all(|c| c.is_finite()) {
                    unit
                } else {
                    [0.0; 3]
                }
            }
        }
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn bounds_of(points: impl Iterator<Item = [f32; 3]>) -> Option<Bounds> {
    points.fold(None, |bounds, p| {
        let (min, max) = bounds.unwrap_or((p, p));
        Some((
            [0, 1, 2].map(|i| min[i].min(p[i])),
            [0, 1, 2].map(|i| max[i].max(p[i])),
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};

    fn one_triangle() -> Mesh {
        Mesh {
            positions: vec![[1.5, -0.0, 0.25], [3.0, 2.0, 0.5], [-1.0, 4.5, 7.0]],
            normals: vec![[0.0, 0.6, 0.8]; 3],
            indices: vec![[0, 1, 2]],
            ..Mesh::default()
        }
    }

    fn placed(transforms: &[Mat4]) -> Model {
        Model {
            meshes: vec![one_triangle()],
            instances: transforms
                .iter()
                .map(|&world_from_mesh| Instance {
                    mesh: 0,
                    world_from_mesh,
                })
                .collect(),
            ..Model::default()
        }
    }

    fn face_normal(flat: &FlatMesh, triangle: usize) -> Vec3 {
        let [a, b, c] = flat.indices[triangle].map(|v| Vec3::from(flat.positions[v as usize]));
        (b - a).cross(c - a).normalize()
    }

    #[test]
    fn identity_keeps_every_bit_even_of_minus_zero() {
        let flat = placed(&[Mat4::IDENTITY]).flatten().unwrap();
        let bits = |mesh: &[[f32; 3]]| {
            mesh.iter()
                .flatten()
                .map(|x| x.to_bits())
                .collect::<Vec<_>>()
        };
        assert_eq!(bits(&flat.positions), bits(&one_triangle().positions));
        assert_eq!(flat.material_of, [u32::MAX]);
    }

    #[test]
    fn mirrored_instance_shows_the_same_side() {
        let plain = Mat4::from_rotation_y(0.7);
        let mirrored = Mat4::from_scale(Vec3::new(-2.0, 1.0, 1.0)) * plain;
        let mut model = placed(&[plain, mirrored]);
        let front = face_normal(&placed(&[Mat4::IDENTITY]).flatten().unwrap(), 0);
        model.meshes[0].normals = vec![front.to_array(); 3];
        let flat = model.flatten().unwrap();
        for triangle in 0..2 {
            let side = face_normal(&flat, triangle).dot(Vec3::from(flat.normals[3 * triangle]));
            assert!(side > 0.999, "triangle {triangle}: {side}");
        }
        assert_eq!(flat.indices[1], [3, 5, 4]);
    }

    #[test]
    fn normals_stay_square_to_their_plane_under_uneven_scale() {
        let mut model = placed(&[Mat4::from_scale_rotation_translation(
            Vec3::new(1.0, 3.0, -0.5),
            Quat::from_rotation_z(1.1),
            Vec3::new(5.0, 6.0, 7.0),
        )]);
        let flat = placed(&[Mat4::IDENTITY]).flatten().unwrap();
        model.meshes[0].normals = vec![face_normal(&flat, 0).to_array(); 3];
        let flat = model.flatten().unwrap();
        assert!((Vec3::from(flat.normals[2]) - face_normal(&flat, 0)).length() < 1e-6);
    }

    #[test]
    fn bounds_and_counts_agree_with_the_flattened_mesh() {
        let model = placed(&[
            Mat4::from_rotation_x(0.3),
            Mat4::from_translation(Vec3::splat(9.0)),
        ]);
        let flat = model.flatten().unwrap();
        assert_eq!(model.bounds(), flat.bounds());
        assert_eq!(
            (model.triangle_count(), model.unique_triangle_count()),
            (2, 1)
        );
        assert_eq!(Model::default().bounds(), None);
    }

    #[test]
    fn a_vertex_without_triangle_is_outside_of_the_bounds() {
        let mut model = placed(&[Mat4::IDENTITY]);
        model.meshes[0].normals.clear();
        model.meshes[0].positions.push([1e9; 3]);
        assert_eq!(model.bounds().unwrap().1, [3.0, 4.5, 7.0]);
    }

    #[test]
    fn meshes_without_normals_get_zeros_beside_those_with() {
        let mut model = placed(&[Mat4::IDENTITY; 2]);
        model.meshes.push(Mesh {
            normals: vec![],
            ..one_triangle()
        });
        model.instances[0].mesh = 1;
        let flat = model.flatten().unwrap();
        assert_eq!(flat.normals[0], [0.0; 3]);
        assert_eq!(flat.normals[3], [0.0, 0.6, 0.8]);
    }

    #[test]
    fn too_many_flattened_triangles_are_refused_before_they_are_made() {
        let mut model = placed(&vec![Mat4::IDENTITY; 1 << 16]);
        model.meshes[0].indices = vec![[0, 1, 2]; (1 << 12) + 1];
        let error = model.flatten().unwrap_err().to_string();
        assert!(
            error.contains("268500992 triangles, the limit is 268435456"),
            "{error}"
        );
    }

    #[test]
    fn a_transform_that_overflows_is_refused_by_name() {
        let error = placed(&[Mat4::IDENTITY, Mat4::from_scale(Vec3::splat(1e38))])
            .flatten()
            .unwrap_err();
        assert_eq!(
            error.to_string(),
            "scene: instance 1: moves mesh 0 out of the range of f32"
        );
    }

    #[test]
    fn broken_models_are_errors() {
        let mut model = placed(&[Mat4::IDENTITY]);
        model.instances[0].mesh = 7;
        assert!(model.flatten().is_err());
        assert_eq!(model.triangle_count(), 0);
    }
}
