//! Meshes: the primitives of each put together into one triangle list.

use super::Source;
use super::accessor::{Elements, Number};
use super::json::{Primitive, TextureTransform};
use super::material::base_color_texture;
use crate::{Door, LoadError, Material, Mesh};

const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

/// Accessors may be used many times. A file whose meshes take more than this many times the bytes it is made of (and
/// more than [`FREE_BYTES`]) is a bomb.
const MOST_GROWTH: u64 = 64;
const FREE_BYTES: u64 = 32 << 20;
/// Indices and material.
const BYTES_PER_TRIANGLE: usize = 16;
/// Position, normal, texture coordinates.
const BYTES_PER_VERTEX: usize = 32;

/// All meshes in file order, used or not; and the materials, to which a default is added if some primitive has none.
pub(super) fn read(
    source: &Source<'_>,
    materials: Vec<Material>,
    door: &mut Door,
) -> Result<(Vec<Mesh>, Vec<Material>), LoadError> {
    let mut reader = Reader {
        source,
        materials,
        default_material: None,
        triangles: 0,
        bytes: 0,
    };
    let mut meshes = Vec::with_capacity(source.document.meshes.len());
    for (m, mesh) in source.document.meshes.iter().enumerate() {
        let mut made = Mesh {
            name: mesh.name.as_str().to_owned(),
            ..Mesh::default()
        };
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            reader.append(
                &mut made,
                primitive,
                &format!("meshes[{m}].primitives[{p}]"),
                door,
            )?;
        }
        if reader.materials.is_empty() {
            made.material_of = Vec::new();
        }
        meshes.push(made);
    }
    Ok((meshes, reader.materials))
}

struct Reader<'a> {
    source: &'a Source<'a>,
    materials: Vec<Material>,
    default_material: Option<u32>,
    triangles: u64,
    /// Made so far.
    bytes: u64,
}

impl Reader<'_> {
    fn append(
        &mut self,
        mesh: &mut Mesh,
        primitive: &Primitive,
        path: &str,
        door: &mut Door,
    ) -> Result<(), LoadError> {
        let mode = primitive.mode.unwrap_or(TRIANGLES);
        if !(TRIANGLES..=FAN).contains(&mode) {
            let what = if mode == 0 { "points" } else { "lines" };
            door.warn(format!("{}: {path}: {what} are skipped", door.name()));
            return Ok(());
        }
        let Some(position) = primitive.attributes.position else {
            door.warn(format!(
                "{}: {path}: has no positions and is skipped",
                door.name()
            ));
            return Ok(());
        };
        self.refuse_compressed(primitive, position, path)?;
        let positions = self
            .source
            .elements::<f32, 3>(position, path, "positions")?;
        let corners = self.corners(primitive, positions.count(), path)?;
        let count = triangle_count(mode, corners.len());
        if mode == TRIANGLES && corners.len() % 3 != 0 {
            door.warn(format!(
                "{}: {path}: {} corners are no whole triangles",
                door.name(),
                corners.len()
            ));
        }
        self.book(count, &positions, path, door)?;

        let mut triangles: Vec<_> = (0..count).map(|i| triangle(mode, &corners, i)).collect();
        drop(corners);
        let chosen = compact(&mut triangles, positions.count());
        self.vertices(mesh, primitive, &positions, &chosen, path, door)?;
        let first = (mesh.positions.len() - chosen.len()) as u32;
        mesh.indices
            .extend(triangles.iter().map(|triangle| triangle.map(|v| first + v)));
        let material = self.material(primitive, path)?;
        mesh.material_of.resize(mesh.indices.len(), material);
        Ok(())
    }

    /// A compressed primitive without plain data to fall back to would be read as zeros.
    fn refuse_compressed(
        &self,
        primitive: &Primitive,
        position: u32,
        path: &str,
    ) -> Result<(), LoadError> {
        let is_bare = self
            .source
            .document
            .accessors
            .get(position as usize)
            .is_some_and(|a| a.buffer_view.is_none());
        if primitive.extensions.draco.is_some() && is_bare {
            let error = self
                .source
                .fault(path, "is compressed by KHR_draco_mesh_compression");
            return Err(
                error.with_remedy("store it without compression, as by `gltf-transform copy`")
            );
        }
        Ok(())
    }

    /// The vertex of each corner, all below `vertex_count`.
    fn corners(
        &self,
        primitive: &Primitive,
        vertex_count: usize,
        path: &str,
    ) -> Result<Vec<u32>, LoadError> {
        let Some(index) = primitive.indices else {
            return Ok((0..vertex_count as u32).collect());
        };
        let indices = self.source.elements::<u32, 1>(index, path, "indices")?;
        let corners: Vec<_> = indices.iter().map(|[v]| v).collect();
        match corners.iter().position(|&v| v as usize >= vertex_count) {
            Some(i) => Err(self.source.fault(
                format!("accessors[{index}]"),
                format!(
                    "index {i} refers to vertex {} of {vertex_count}",
                    corners[i]
                ),
            )),
            None => Ok(corners),
        }
    }

    /// Makes sure that the limits allow `count` more triangles, at most three vertices each.
    fn book(
        &mut self,
        count: usize,
        positions: &Elements<'_, f32, 3>,
        path: &str,
        door: &Door,
    ) -> Result<(), LoadError> {
        self.triangles += count as u64;
        let limit = door.limits().max_triangles;
        if self.triangles > limit {
            let cause = format!(
                "brings the scene to {} triangles, the limit is {limit}",
                self.triangles
            );
            return Err(self.source.fault(path, cause));
        }
        let vertices = positions.count().min(3 * count) + positions.patch_count();
        self.bytes += (count * BYTES_PER_TRIANGLE + vertices * BYTES_PER_VERTEX) as u64;
        let held = self.source.buffers.byte_count();
        if self.bytes > FREE_BYTES && self.bytes / MOST_GROWTH > held {
            let cause = format!(
                "makes {} bytes out of buffers of {held}: the same data again and again",
                self.bytes
            );
            return Err(self
                .source
                .fault(path, cause)
                .with_remedy("use one mesh in many nodes"));
        }
        Ok(())
    }

    /// Appends the `chosen` vertices.
    fn vertices(
        &mut self,
        mesh: &mut Mesh,
        primitive: &Primitive,
        positions: &Elements<'_, f32, 3>,
        chosen: &Chosen,
        path: &str,
        door: &mut Door,
    ) -> Result<(), LoadError> {
        let before = mesh.positions.len();
        if u32::try_from(before + chosen.len()).is_err() {
            return Err(self
                .source
                .fault(path, "brings the mesh to more than 2^32 vertices"));
        }
        for v in chosen.iter() {
            let p = positions.get(v);
            if !p.iter().all(|x| x.is_finite()) {
                let at = format!(
                    "accessors[{}]",
                    primitive.attributes.position.unwrap_or_default()
                );
                return Err(self
                    .source
                    .fault(at, format!("position {v} is {p:?}, which is not finite")));
            }
            mesh.positions.push(p);
        }
        let after = mesh.positions.len();
        if let Some(index) = primitive.attributes.normal {
            let normals = self.source.elements::<f32, 3>(index, path, "normals")?;
            self.same_count(&normals, positions.count(), index, "normals")?;
            fill(&mut mesh.normals, before, chosen, |v| normals.get(v));
            repair(&mut mesh.normals[before..], index, "normals", door);
        }
        if let Some((index, transform)) = self.uv_accessor(primitive) {
            let uvs = self
                .source
                .elements::<f32, 2>(index, path, "texture coordinates")?;
            self.same_count(&uvs, positions.count(), index, "texture coordinates")?;
            fill(&mut mesh.uvs, before, chosen, |v| {
                transform.apply(uvs.get(v))
            });
            repair(&mut mesh.uvs[before..], index, "texture coordinates", door);
        }
        // What one primitive has and another has not is zero there.
        if !mesh.normals.is_empty() {
            mesh.normals.resize(after, [0.0; 3]);
        }
        if !mesh.uvs.is_empty() {
            mesh.uvs.resize(after, [0.0; 2]);
        }
        Ok(())
    }

    fn same_count<T: Number, const N: usize>(
        &self,
        elements: &Elements<'_, T, N>,
        vertex_count: usize,
        index: u32,
        what: &str,
    ) -> Result<(), LoadError> {
        if elements.count() == vertex_count {
            return Ok(());
        }
        let cause = format!("{} {what} for {vertex_count} positions", elements.count());
        Err(self.source.fault(format!("accessors[{index}]"), cause))
    }

    /// The texture coordinates that the base colour of the primitive's material asks for.
    fn uv_accessor(&self, primitive: &Primitive) -> Option<(u32, UvMap)> {
        let material = primitive
            .material
            .and_then(|m| self.source.document.materials.get(m as usize));
        let info = material.and_then(base_color_texture);
        let transform = info.and_then(|info| info.extensions.transform);
        let set = info.map_or(0, |info| {
            transform
                .and_then(|t| t.tex_coord)
                .unwrap_or(info.tex_coord)
        });
        let index = if set == 1 {
            primitive.attributes.uv_1
        } else {
            primitive.attributes.uv_0
        };
        Some((index?, UvMap::new(transform.unwrap_or_default())))
    }

    fn material(&mut self, primitive: &Primitive, path: &str) -> Result<u32, LoadError> {
        let known = self.source.document.materials.len();
        match primitive.material {
            Some(material) if (material as usize) < known => Ok(material),
            Some(material) => Err(self
                .source
                .fault(path, format!("refers to material {material} of {known}"))),
            // Without any materials, an empty list says the same.
            None if known == 0 => Ok(u32::MAX),
            None => Ok(*self.default_material.get_or_insert_with(|| {
                self.materials.push(Material::default());
                known as u32
            })),
        }
    }
}

fn triangle_count(mode: u32, corner_count: usize) -> usize {
    if mode == TRIANGLES {
        corner_count / 3
    } else {
        corner_count.saturating_sub(2)
    }
}

/// Triangle `i` of a list, a strip (whose every other triangle runs backwards) or a fan.
fn triangle(mode: u32, corners: &[u32], i: usize) -> [u32; 3] {
    match mode {
        STRIP if i.is_multiple_of(2) => [corners[i], corners[i + 1], corners[i + 2]],
        STRIP => [corners[i], corners[i + 2], corners[i + 1]],
        FAN => [corners[i + 1], corners[i + 2], corners[0]],
        _ => [corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]],
    }
}

/// The vertices of an accessor that a primitive takes.
enum Chosen {
    All(usize),
    Some(Vec<u32>),
}

impl Chosen {
    fn len(&self) -> usize {
        match self {
            Self::All(count) => *count,
            Self::Some(vertices) => vertices.len(),
        }
    }

    fn iter(&self) -> impl Iterator<Item = u32> {
        (0..self.len()).map(|i| match self {
            Self::All(_) => i as u32,
            Self::Some(vertices) => vertices[i],
        })
    }
}

/// Leaves out the vertices that no triangle uses, if they are many: some exporters let all meshes share one long
/// accessor, and copying that for each of them would be quadratic.
fn compact(triangles: &mut [[u32; 3]], vertex_count: usize) -> Chosen {
    if vertex_count <= 3 * triangles.len() {
        return Chosen::All(vertex_count);
    }
    let mut vertices: Vec<_> = triangles.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    for v in triangles.iter_mut().flatten() {
        *v = vertices.binary_search(v).unwrap_or_default() as u32;
    }
    Chosen::Some(vertices)
}

/// Brings `list` to `before` entries and appends one for each chosen vertex.
fn fill<T: Copy + Default>(
    list: &mut Vec<T>,
    before: usize,
    chosen: &Chosen,
    get: impl Fn(u32) -> T,
) {
    list.resize(before, T::default());
    list.extend(chosen.iter().map(get));
}

/// Sets what is not finite to zero: it is only looks.
fn repair<const N: usize>(values: &mut [[f32; N]], index: u32, what: &str, door: &mut Door) {
    let mut broken = 0;
    for value in values
        .iter_mut()
        .filter(|value| !value.iter().all(|x| x.is_finite()))
    {
        *value = [0.0; N];
        broken += 1;
    }
    if broken > 0 {
        door.warn(format!(
            "{}: accessors[{index}]: {broken} {what} are not finite and taken as zero",
            door.name()
        ));
    }
}

/// `KHR_texture_transform`, and then from glTF's v down to our v up.
struct UvMap {
    transform: TextureTransform,
    sin: f32,
    cos: f32,
}

impl UvMap {
    fn new(transform: TextureTransform) -> Self {
        let (sin, cos) = libm::sincos(transform.rotation);
        Self {
            transform,
            sin: sin as f32,
            cos: cos as f32,
        }
    }

    fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let [u, v] = [u * self.transform.scale[0], v * self.transform.scale[1]];
        let [du, dv] = self.transform.offset;
        [
            u * self.cos + v * self.sin + du,
            1.0 - (v * self.cos - u * self.sin + dv),
        ]
    }
}
