//! glTF 2.0, as `.gltf` and `.glb`.
//!
//! Geometry, node transforms, instances, perspective cameras, and of the materials what [`crate::Material`] holds.
//! Extensions: `KHR_mesh_quantization`, `EXT_mesh_gpu_instancing`, `KHR_texture_transform`,
//! `KHR_materials_emissive_strength`, `KHR_materials_pbrSpecularGlossiness` (the diffuse part). Skins and morph
//! targets stay in their rest pose. Points and lines are skipped with a warning.
//!
//! The parser is our own on top of `serde_json`, because every count has to be checked against the bytes before memory
//! is asked for, and every error has to name its place (`accessors[3]`).

mod accessor;
mod buffers;
mod container;
mod json;
mod material;
mod mesh;
mod node;

use super::Format;
use crate::{Door, LoadError, Model, Place};
use buffers::Buffers;
use json::Document;

pub(crate) const FORMAT: Format = Format {
    name: "gltf",
    extensions: &["gltf", "glb"],
    about: "glTF 2.0, text or binary: meshes, instances, materials, textures, cameras",
    sniff,
    load,
};

fn sniff(bytes: &[u8]) -> bool {
    let text = bytes.trim_ascii_start();
    bytes.starts_with(b"glTF")
        || (text.starts_with(b"{") && text.windows(7).any(|word| word == b"\"asset\""))
}

/// Time and memory are linear in the file and what it names; instances are not multiplied out.
fn load(bytes: &[u8], door: &mut Door) -> Result<Model, LoadError> {
    let container = container::open(bytes, door)?;
    let document: Document<'_> = serde_json::from_slice(container.json)
        .map_err(|error| door.error(None, format!("its JSON cannot be read: {error}")))?;
    check_version(&document, door)?;
    check_extensions(&document, door)?;

    let buffers = Buffers::open(&document, container.binary, door)?;
    let source = Source {
        name: door.name().to_owned(),
        document,
        buffers,
    };
    let (materials, textures) = material::read(&source, door)?;
    let (meshes, materials) = mesh::read(&source, materials, door)?;
    let (instances, cameras) = node::read(&source, door)?;
    Ok(Model {
        meshes,
        instances,
        materials,
        textures,
        cameras,
        warnings: Vec::new(),
    })
}

/// What the parts of the loader read from.
struct Source<'a> {
    /// What errors call the file.
    name: String,
    document: Document<'a>,
    buffers: Buffers<'a>,
}

impl Source<'_> {
    /// An error at a place such as `meshes[3].primitives[0]`.
    fn fault(&self, path: impl Into<String>, cause: impl Into<String>) -> LoadError {
        LoadError {
            place: Some(Place::Path(path.into())),
            ..LoadError::new(&self.name, cause)
        }
    }
}

fn check_version(document: &Document<'_>, door: &Door) -> Result<(), LoadError> {
    match document.asset.as_ref().map(|asset| asset.version.as_str()) {
        Some(version) if version.starts_with("2.") => Ok(()),
        Some(version) => {
            let error = door.error(
                Some(Place::Path("asset".into())),
                format!("version \"{version}\" is not 2.0"),
            );
            Err(error.with_remedy("convert it to glTF 2.0"))
        }
        None => Err(door.error(None, "has no \"asset\": this is not a glTF file")),
    }
}

/// Extensions that change the geometry or how it is stored, and that are read.
const READ: &[&str] = &["KHR_mesh_quantization", "EXT_mesh_gpu_instancing"];

/// Extensions that only change looks. Without them the picture is plainer, the geometry the same.
const LOOKS: &[&str] = &[
    "KHR_materials_",
    "EXT_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "KHR_lights_",
];

const COMPRESSED: &[&str] = &[
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
];

fn check_extensions(document: &Document<'_>, door: &mut Door) -> Result<(), LoadError> {
    for extension in document.extensions_required.iter().map(json::Text::as_str) {
        if READ.contains(&extension) {
            continue;
        }
        if LOOKS.iter().any(|family| extension.starts_with(family)) {
            if !material::READ.contains(&extension) {
                door.warn(format!(
                    "{}: the extension {extension} is not read, looks may differ",
                    door.name()
                ));
            }
            continue;
        }
        let error = door.error(
            Some(Place::Path("extensionsRequired".into())),
            format!("the extension {extension} is required and not known"),
        );
        let remedy = if COMPRESSED.contains(&extension) {
            "store it without compression, as by `gltf-transform copy`"
        } else {
            "export it without this extension"
        };
        return Err(error.with_remedy(remedy));
    }
    Ok(())
}
