//! The scene as loaded: plain data with public fields, the same for every format.

use glam::Mat4;

/// Everything one file (or one built-in scene) describes.
///
/// A mesh is stored once however often it is shown: [`Model::instances`] place meshes in the world, and
/// [`Model::flatten`] multiplies them out into one triangle list for the structures of the core crate.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Model {
    /// The stored geometry.
    pub meshes: Vec<Mesh>,
    /// Where each mesh stands, in file order. A format without instances has one per mesh.
    pub instances: Vec<Instance>,
    /// Referred to by [`Mesh::material_of`]; may be empty.
    pub materials: Vec<Material>,
    /// Referred to by [`Material::base_color_texture`].
    pub textures: Vec<Texture>,
    /// Cameras that the file carries; the renderer finds one of its own where there is none.
    pub cameras: Vec<Camera>,
    /// What was tolerated on the way in (a missing texture, a dropped line), for the user to read.
    pub warnings: Vec<String>,
}

/// Indexed triangles. `normals` and `uvs` are empty or as long as `positions`.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mesh {
    /// As the file says, possibly empty.
    pub name: String,
    /// Finite, in the mesh's own space.
    pub positions: Vec<[f32; 3]>,
    /// Unit length where the file is sane; empty: use the face normal.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, v up (OBJ's convention; the glTF loader flips).
    pub uvs: Vec<[f32; 2]>,
    /// Every index is below `positions.len()`.
    pub indices: Vec<[u32; 3]>,
    /// Material of each triangle, as an index into [`Model::materials`]. Empty: the default material.
    pub material_of: Vec<u32>,
}

/// One use of a mesh.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Instance {
    /// Index into [`Model::meshes`].
    pub mesh: u32,
    /// Affine, all entries finite.
    pub world_from_mesh: Mat4,
}

/// The metallic-roughness model of glTF 2.0, which OBJ materials are mapped to.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// As the file says, possibly empty.
    pub name: String,
    /// Linear RGB in 0..=1.
    pub base_color: [f32; 3],
    /// Index into [`Model::textures`], multiplied with `base_color`.
    pub base_color_texture: Option<u32>,
    /// Linear radiance; not black: the surface is a light.
    pub emission: [f32; 3],
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// 0 mirror, 1 matte.
    pub roughness: f32,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [0.8; 3],
            base_color_texture: None,
            emission: [0.0; 3],
            metallic: 0.0,
            roughness: 1.0,
        }
    }
}

/// A decoded picture, sRGB-coded, row 0 on top.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Texture {
    /// Where it came from.
    pub name: String,
    /// In texels.
    pub width: u32,
    /// In texels.
    pub height: u32,
    /// `width * height` texels, RGBA.
    pub rgba: Vec<[u8; 4]>,
}

/// A pinhole camera in Embree's viewer terms (`--vp --vi --vu --fov`).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Camera {
    /// View point.
    pub eye: [f32; 3],
    /// Point of interest.
    pub target: [f32; 3],
    /// Roughly up; not parallel to the view direction.
    pub up: [f32; 3],
    /// Vertical field of view in degrees, in 0..180 exclusive.
    pub fov: f32,
}

/// One world-space triangle list, multiplied out of a [`Model`].
#[derive(Clone, Debug, Default)]
pub struct FlatMesh {
    /// World space.
    pub positions: Vec<[f32; 3]>,
    /// World space, unit; empty if no mesh has any, else zero where a mesh has none.
    pub normals: Vec<[f32; 3]>,
    /// Empty if no mesh has any.
    pub uvs: Vec<[f32; 2]>,
    /// In instance order, then file order.
    pub indices: Vec<[u32; 3]>,
    /// Per triangle, `u32::MAX` for the default material.
    pub material_of: Vec<u32>,
}
