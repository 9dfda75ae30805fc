//! What the triangles of a scene look like: normals, texture coordinates, materials, lights.

use boxwood::{Affine, Hit, Ray, Transform};
use boxwood_scene::{FlatMesh, Folded, Instance, Material, Model, Texture};
use glam::{DVec3, Vec2, Vec3};

use crate::tone::srgb_to_linear;

/// The looks of a scene. Borrows the flattened triangles (in the order in which the core scene was
/// built from them) and the materials of the model that they came from.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces<'a> {
    mesh: &'a FlatMesh,
    /// Meshes that stand in several places, and where: the numbers of instances below those of `mesh`.
    parts: &'a [FlatMesh],
    instances: &'a [Instance],
    materials: &'a [Material],
    textures: &'a [Texture],
}

/// What a ray sees where it hits.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// World space, from the corner positions, more exact than `origin + t dir`.
    pub position: Vec3,
    /// Of the flat triangle, unit, on the side that the ray came from.
    pub face_normal: Vec3,
    /// Interpolated where the mesh has normals, unit, on the same side as `face_normal`.
    pub normal: Vec3,
    /// The ray came from behind: the triangle's corners run clockwise as seen from the ray's
    /// origin.
    pub back: bool,
    /// Zero where the mesh has none.
    pub uv: Vec2,
    /// Linear, texture applied.
    pub base_color: Vec3,
    /// Linear radiance, the same on both sides.
    pub emission: Vec3,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// 0 mirror, 1 matte.
    pub roughness: f32,
    /// How far it has dissolved into the background, 0 to 1: only the renderer's own floor does.
    pub fade: f32,
}

/// The look of triangles without a material: light grey, matte.
const DEFAULT_COLOR: f32 = 0.8;

impl<'a> Surfaces<'a> {
    /// `mesh` is `model.flatten()`.
    pub fn new(mesh: &'a FlatMesh, model: &'a Model) -> Self {
        Self {
            mesh,
            parts: &[],
            instances: &[],
            materials: &model.materials,
            textures: &model.textures,
        }
    }

    /// `folded` is `model.fold()`, and the core scene is [`Folded::build`]'s.
    pub fn of_folded(folded: &'a Folded, model: &'a Model) -> Self {
        Self {
            parts: &folded.parts,
            instances: &folded.instances,
            ..Self::new(&folded.once, model)
        }
    }

    /// How many triangles are shown, every instance multiplied out.
    pub fn triangle_count(&self) -> u64 {
        let of_part = |instance: &Instance| self.parts[instance.mesh as usize].indices.len();
        let of_parts = self.instances.iter().map(of_part);
        of_parts
            .chain([self.mesh.indices.len()])
            .map(|n| n as u64)
            .sum()
    }

    /// The corners of every triangle shown, in the world, by number of instance and triangle.
    pub fn shown(&self) -> impl Iterator<Item = (u32, u32, [Vec3; 3])> + '_ {
        (0..=self.instances.len() as u32).flat_map(move |inst| {
            let seen = self.seen(inst);
            let prims = 0..seen.mesh.indices.len() as u32;
            prims.map(move |prim| (inst, prim, seen.corners(prim)))
        })
    }

    /// The mesh of an instance, and where it stands. There is one more than instances: what is shown once.
    fn seen(&self, inst: u32) -> Seen<'a> {
        match self.instances.get(inst as usize) {
            Some(instance) => Seen {
                mesh: &self.parts[instance.mesh as usize],
                place: Some(Affine::of(&Transform::from_columns(
                    instance.world_from_mesh.to_cols_array_2d(),
                ))),
            },
            None => Seen {
                mesh: self.mesh,
                place: None,
            },
        }
    }

    /// Every mesh that is stored: those that stand in several places, then what is shown once.
    #[cfg(feature = "farm")]
    pub(crate) fn stored(&self) -> impl Iterator<Item = &'a FlatMesh> {
        self.parts.iter().chain([self.mesh])
    }

    #[cfg(feature = "farm")]
    pub(crate) fn instances(&self) -> &'a [Instance] {
        self.instances
    }

    #[cfg(feature = "farm")]
    pub(crate) fn materials(&self) -> &'a [Material] {
        self.materials
    }

    #[cfg(feature = "farm")]
    pub(crate) fn textures(&self) -> &'a [Texture] {
        self.textures
    }

    /// World-space corner positions of what is shown once; [`Surfaces::triangles`] index them.
    pub fn positions(&self) -> &'a [[f32; 3]] {
        &self.mesh.positions
    }

    /// One per primitive number of what is shown once.
    pub fn triangles(&self) -> &'a [[u32; 3]] {
        &self.mesh.indices
    }

    /// Index of the material of triangle `prim` of instance `inst`, `u32::MAX` for the default material.
    pub fn material_index(&self, inst: u32, prim: u32) -> u32 {
        let materials = &self.seen(inst).mesh.material_of;
        materials.get(prim as usize).copied().unwrap_or(u32::MAX)
    }

    /// The material of a triangle, if it has one.
    pub fn material(&self, inst: u32, prim: u32) -> Option<&'a Material> {
        self.materials.get(self.material_index(inst, prim) as usize)
    }

    /// True if any material glows.
    pub fn has_lights(&self) -> bool {
        self.materials.iter().any(|m| m.emission != [0.0; 3])
    }

    /// Whether [`Surface::uv`] says something.
    pub fn has_uvs(&self) -> bool {
        let mut meshes = self.parts.iter().chain([self.mesh]);
        meshes.any(|mesh| !mesh.uvs.is_empty())
    }

    /// The corners of a triangle of what is shown once.
    ///
    /// # Panics
    /// If `prim` is not below the number of triangles.
    pub fn corners(&self, prim: u32) -> [Vec3; 3] {
        self.mesh.indices[prim as usize].map(|i| self.mesh.positions[i as usize].into())
    }

    /// What `ray` sees at `hit`.
    ///
    /// # Panics
    /// If `hit.prim` is not below the number of triangles.
    pub fn at(&self, ray: &Ray, hit: &Hit) -> Surface {
        let seen = self.seen(hit.inst);
        let corners = seen.corners(hit.prim);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let dir = Vec3::from(ray.dir);
        let outward = seen.outward(hit.prim);
        let back = outward.dot(dir) > 0.0;
        let face_normal = if outward == Vec3::ZERO {
            -dir.normalize_or_zero()
        } else {
            outward * side(!back)
        };
        let uv = seen.uv(hit.prim, weights);
        let base = Surface {
            position: mix(corners, weights),
            face_normal,
            normal: seen.shading_normal(hit.prim, weights, face_normal),
            back,
            uv,
            base_color: Vec3::splat(DEFAULT_COLOR),
            emission: Vec3::ZERO,
            metallic: 0.0,
            roughness: 1.0,
            fade: 0.0,
        };
        self.material(hit.inst, hit.prim)
            .map_or(base, |material| Surface {
                base_color: Vec3::from(material.base_color) * self.texel(material, uv),
                emission: material.emission.into(),
                metallic: material.metallic.clamp(0.0, 1.0),
                roughness: material.roughness.clamp(0.0, 1.0),
                ..base
            })
    }

    /// The texture's linear colour at `uv`, repeated and bilinear; white without a texture.
    fn texel(&self, material: &Material, uv: Vec2) -> Vec3 {
        let texture = material
            .base_color_texture
            .and_then(|index| self.textures.get(index as usize));
        texture
            .filter(|t| !t.rgba.is_empty())
            .map_or(Vec3::ONE, |texture| bilinear(texture, uv))
    }
}

/// A mesh as it is seen in one place.
#[derive(Clone, Copy)]
struct Seen<'a> {
    mesh: &'a FlatMesh,
    /// None: it lies in the world already.
    place: Option<Affine>,
}

impl Seen<'_> {
    fn corners_in_mesh(&self, prim: u32) -> [Vec3; 3] {
        self.mesh.indices[prim as usize].map(|i| self.mesh.positions[i as usize].into())
    }

    /// In the world.
    fn corners(&self, prim: u32) -> [Vec3; 3] {
        let corners = self.corners_in_mesh(prim);
        match &self.place {
            None => corners,
            Some(place) => corners.map(|p| {
                let [x, y, z] = place.point(p.as_dvec3().to_array());
                Vec3::new(x as f32, y as f32, z as f32)
            }),
        }
    }

    /// The unit face normal on the side from which the corners run counter-clockwise in the mesh's own space: mirrored,
    /// the outside stays the outside.
    fn outward(&self, prim: u32) -> Vec3 {
        self.turned(unit_face_normal(self.corners_in_mesh(prim)))
    }

    /// A normal as it stands in the world, of any length.
    fn turned(&self, normal: Vec3) -> Vec3 {
        match &self.place {
            None => normal,
            Some(place) => {
                let turned = place.normal(normal.as_dvec3().to_array());
                DVec3::from(turned).normalize_or_zero().as_vec3()
            }
        }
    }

    /// The interpolated normal, turned to the side of the face normal; the face normal where there
    /// is none.
    fn shading_normal(&self, prim: u32, weights: [f32; 3], face_normal: Vec3) -> Vec3 {
        if self.mesh.normals.is_empty() {
            return face_normal;
        }
        let corner =
            self.mesh.indices[prim as usize].map(|i| Vec3::from(self.mesh.normals[i as usize]));
        let normal = self.turned(mix(corner, weights)).normalize_or_zero();
        if normal == Vec3::ZERO || !normal.is_finite() {
            return face_normal;
        }
        normal * side(normal.dot(face_normal) >= 0.0)
    }

    fn uv(&self, prim: u32, weights: [f32; 3]) -> Vec2 {
        if self.mesh.uvs.is_empty() {
            return Vec2::ZERO;
        }
        let [a, b, c] =
            self.mesh.indices[prim as usize].map(|i| Vec2::from(self.mesh.uvs[i as usize]));
        let uv = a * weights[0] + b * weights[1] + c * weights[2];
        if uv.is_finite() { uv } else { Vec2::ZERO }
    }
}

fn mix(corners: [Vec3; 3], weights: [f32; 3]) -> Vec3 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

/// In f64, so that slivers and tiny triangles keep their direction; zero for a triangle without an
/// area.
fn unit_face_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    let a = a.as_dvec3();
    (b.as_dvec3() - a)
        .cross(c.as_dvec3() - a)
        .normalize_or_zero()
        .as_vec3()
}

fn side(positive: bool) -> f32 {
    if positive { 1.0 } else { -1.0 }
}

fn bilinear(texture: &Texture, uv: Vec2) -> Vec3 {
    let (width, height) = (texture.width as f32, texture.height as f32);
    // v points up, rows run down; texel centres lie at halves.
    let x = (uv.x - uv.x.floor()) * width - 0.5;
    let y = (1.0 - (uv.y - uv.y.floor())) * height - 0.5;
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    let at = |x: f32, y: f32| {
        let column = (x as i64).rem_euclid(i64::from(texture.width)) as usize;
        let row = (y as i64).rem_euclid(i64::from(texture.height)) as usize;
        let [r, g, b, _] = texture.rgba[row * texture.width as usize + column];
        Vec3::new(srgb_to_linear(r), srgb_to_linear(g), srgb_to_linear(b))
    };
    let upper = at(x0, y0) * (1.0 - fx) + at(x0 + 1.0, y0) * fx;
    let lower = at(x0, y0 + 1.0) * (1.0 - fx) + at(x0 + 1.0, y0 + 1.0) * fx;
    upper * (1.0 - fy) + lower * fy
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> (FlatMesh, Model) {
        let mesh = FlatMesh {
            positions: vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]],
            normals: vec![[0.6, 0.0, 0.8]; 3],
            uvs: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            indices: vec![[0, 1, 2]],
            material_of: vec![0],
        };
        let red_over_blue = Texture {
            name: String::new(),
            width: 1,
            height: 2,
            rgba: vec![[255, 0, 0, 255], [0, 0, 255, 255]],
        };
        let material = Material {
            base_color: [0.5; 3],
            base_color_texture: Some(0),
            ..Material::default()
        };
        let model = Model {
            materials: vec![material],
            textures: vec![red_over_blue],
            ..Model::default()
        };
        (mesh, model)
    }

    fn seen(dir: [f32; 3], u: f32, v: f32) -> Surface {
        let (mesh, model) = model();
        let hit = Hit {
            t: 1.0,
            u,
            v,
            prim: 0,
            geom: 0,
            inst: 0,
        };
        Surfaces::new(&mesh, &model).at(&Ray::new([0.0; 3], dir), &hit)
    }

    #[test]
    fn both_normals_face_the_ray_from_either_side() {
        let front = seen([0.0, 0.0, -1.0], 0.25, 0.5);
        assert!(!front.back);
        assert_eq!(front.face_normal, Vec3::Z);
        assert!((front.normal - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-6);
        let back = seen([0.0, 0.0, 1.0], 0.25, 0.5);
        assert!(back.back);
        assert_eq!(back.face_normal, Vec3::NEG_Z);
        assert!((back.normal + front.normal).length() < 1e-6);
    }

    #[test]
    fn position_and_uv_follow_the_barycentric_coordinates() {
        let surface = seen([0.0, 0.0, -1.0], 0.25, 0.5);
        assert_eq!(surface.position, Vec3::new(0.5, 1.5, 0.0));
        assert_eq!(surface.uv, Vec2::new(0.25, 0.5));
    }

    #[test]
    fn the_upper_row_of_a_texture_is_at_v_one() {
        assert_eq!(
            seen([0.0, 0.0, -1.0], 0.1, 0.75).base_color,
            Vec3::new(0.5, 0.0, 0.0)
        );
        assert_eq!(
            seen([0.0, 0.0, -1.0], 0.1, 0.25).base_color,
            Vec3::new(0.0, 0.0, 0.5)
        );
    }

    #[test]
    fn a_triangle_without_an_area_faces_the_ray() {
        let (mut mesh, model) = model();
        mesh.positions[2] = [4.0, 0.0, 0.0];
        mesh.normals.clear();
        let hit = Hit {
            t: 1.0,
            u: 0.25,
            v: 0.5,
            prim: 0,
            geom: 0,
            inst: 0,
        };
        let surface = Surfaces::new(&mesh, &model).at(&Ray::new([0.0; 3], [0.0, -2.0, 0.0]), &hit);
        assert_eq!((surface.face_normal, surface.normal), (Vec3::Y, Vec3::Y));
    }
}
