//! Materials and their base-colour textures.

use std::collections::HashMap;

use super::Source;
use super::buffers::resolve;
use super::json;
use crate::texture::decode_or_warn;
use crate::{Door, LoadError, Material, Texture};

/// Extensions that change looks and are read.
pub(super) const READ: &[&str] = &[
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_texture_transform",
];

/// All materials in file order, and the textures they use, each decoded once.
///
/// Metalness and roughness maps are not read: such a surface counts as a dielectric of the stated roughness, which is
/// nearer to most of them than the factor of one that stands beside the map. Likewise an emission map is taken as
/// dark, since its factor alone would make all of the surface a lamp.
pub(super) fn read(
    source: &Source<'_>,
    door: &mut Door,
) -> Result<(Vec<Material>, Vec<Texture>), LoadError> {
    let mut shelf = Shelf::default();
    let mut materials = Vec::with_capacity(source.document.materials.len());
    for (i, material) in source.document.materials.iter().enumerate() {
        let texture = match base_color_texture(material) {
            Some(info) => shelf.texture(source, info.index, &format!("materials[{i}]"), door)?,
            None => None,
        };
        if material.emissive_texture.is_some() && material.emissive_factor != [0.0; 3] {
            door.warn(format!(
                "{}: materials[{i}]: its emission map is not read and taken as dark",
                door.name()
            ));
        }
        materials.push(Material {
            base_color_texture: texture,
            ..plain(material)
        });
    }
    Ok((materials, shelf.textures))
}

/// What says where the base colour comes from, of either material model.
pub(super) fn base_color_texture<'a>(
    material: &'a json::Material<'_>,
) -> Option<&'a json::TextureInfo> {
    match &material.extensions.specular_glossiness {
        Some(old) => old.diffuse_texture.as_ref(),
        None => material.pbr_metallic_roughness.base_color_texture.as_ref(),
    }
}

/// The material without its texture; every number forced into its range.
fn plain(material: &json::Material<'_>) -> Material {
    let unit = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
    let pbr = &material.pbr_metallic_roughness;
    let (color, metallic, roughness) = match &material.extensions.specular_glossiness {
        Some(old) => (old.diffuse_factor, 0.0, 1.0 - unit(old.glossiness_factor)),
        None if pbr.metallic_roughness_texture.is_some() => {
            (pbr.base_color_factor, 0.0, pbr.roughness_factor)
        }
        None => (
            pbr.base_color_factor,
            pbr.metallic_factor,
            pbr.roughness_factor,
        ),
    };
    let strength = match &material.extensions.emissive_strength {
        Some(extension) => extension.emissive_strength,
        None => 1.0,
    };
    let is_lamp = material.emissive_texture.is_none();
    let emission = material.emissive_factor.map(|x| x * strength);
    let [red, green, blue, _] = color.map(unit);
    Material {
        name: material.name.as_str().to_owned(),
        base_color: [red, green, blue],
        base_color_texture: None,
        emission: emission.map(|x| {
            if is_lamp && x.is_finite() {
                x.max(0.0)
            } else {
                0.0
            }
        }),
        metallic: unit(metallic),
        roughness: unit(roughness),
    }
}

/// The textures so far.
#[derive(Default)]
struct Shelf {
    textures: Vec<Texture>,
    /// By the bytes they come from, so that nothing is decoded twice; `None` for what could not be decoded.
    known: HashMap<Bytes, Option<u32>>,
}

#[derive(Clone, PartialEq, Eq, Hash)]
enum Bytes {
    Uri(String),
    View(u32),
}

impl Shelf {
    /// The texture `index`, which the material at `user` (a path) refers to. A picture that is missing or broken is a
    /// warning, a reference to nowhere an error.
    fn texture(
        &mut self,
        source: &Source<'_>,
        index: u32,
        user: &str,
        door: &mut Door,
    ) -> Result<Option<u32>, LoadError> {
        let textures = &source.document.textures;
        let Some(texture) = textures.get(index as usize) else {
            return Err(source.fault(
                user,
                format!("refers to texture {index} of {}", textures.len()),
            ));
        };
        // Without a source the picture is in a format that only an extension knows.
        let Some(image_index) = texture.source else {
            door.warn(format!(
                "{}: textures[{index}]: neither PNG nor JPEG; drawn without it",
                door.name()
            ));
            return Ok(None);
        };
        let images = &source.document.images;
        let Some(image) = images.get(image_index as usize) else {
            return Err(source.fault(
                user,
                format!("refers to image {image_index} of {}", images.len()),
            ));
        };
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => Bytes::Uri(uri.as_str().to_owned()),
            (None, Some(view)) => Bytes::View(view),
            (None, None) => return Ok(None),
        };
        if let Some(known) = self.known.get(&bytes) {
            return Ok(*known);
        }
        let path = format!("images[{image_index}]");
        let (name, content) = match &bytes {
            Bytes::Uri(uri) if uri.len() < 200 => (uri.clone(), resolve(uri, door)),
            Bytes::Uri(uri) => (path, resolve(uri, door)),
            Bytes::View(view) => {
                let content = source.view(*view, &path)?.bytes.to_vec();
                (path, Ok(content))
            }
        };
        let decoded = decode_or_warn(&name, content, door).map(|texture| {
            self.textures.push(texture);
            self.textures.len() as u32 - 1
        });
        self.known.insert(bytes, decoded);
        Ok(decoded)
    }
}
