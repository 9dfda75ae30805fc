//! Files, and what the triangles of a file look like.

use crate::arrays::table;
use boxwood_host::FloatModes;
use boxwood_scene::{FlatMesh, LoadError, Material, Model, Texture};
use numpy::PyArray2;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Normals, texture coordinates, materials, textures and cameras of a file: all that pictures want to know and rays do not.
#[pyclass(frozen, name = "NativeLooks", module = "boxwood._native")]
pub(crate) struct NativeLooks {
    /// Positions and indices are left out: the scene has them.
    mesh: FlatMesh,
    /// Meshes and instances are left out: they are flattened.
    pub(crate) model: Model,
}

type Stored = (Vec<[f32; 3]>, Vec<[f32; 2]>, Vec<u32>, Model);

/// Positions, triangles, looks and warnings.
type Loaded<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<u32>>,
    NativeLooks,
    Vec<String>,
);

/// A file, its instances multiplied out, and what was tolerated.
#[pyfunction]
pub(crate) fn load<'py>(py: Python<'py>, path: &str) -> PyResult<Loaded<'py>> {
    let (mut model, mut mesh) = py
        .detach(|| {
            let _modes = FloatModes::enter();
            let model = boxwood_scene::open(path)?;
            let mesh = model.flatten()?;
            Ok((model, mesh))
        })
        .map_err(|error: LoadError| PyOSError::new_err(error.to_string()))?;
    let warnings = std::mem::take(&mut model.warnings);
    (model.meshes, model.instances) = (Vec::new(), Vec::new());
    let positions = table(py, std::mem::take(&mut mesh.positions))?;
    let indices = table(py, std::mem::take(&mut mesh.indices))?;
    Ok((positions, indices, NativeLooks { mesh, model }, warnings))
}

#[pymethods]
impl NativeLooks {
    /// From [`NativeLooks::to_bytes`].
    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        let broken = || PyValueError::new_err("these bytes are not the looks of a boxwood scene");
        let (normals, uvs, material_of, model): Stored =
            postcard::from_bytes(bytes).map_err(|_| broken())?;
        let whole = |t: &Texture| t.rgba.len() as u64 == u64::from(t.width) * u64::from(t.height);
        if !model.textures.iter().all(whole) {
            return Err(broken());
        }
        let mesh = FlatMesh {
            normals,
            uvs,
            material_of,
            ..FlatMesh::default()
        };
        Ok(Self { mesh, model })
    }

    /// For pickle.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mesh = &self.mesh;
        let bytes =
            postcard::to_allocvec(&(&mesh.normals, &mesh.uvs, &mesh.material_of, &self.model))
                .map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Py<PyAny>, (Bound<'py, PyBytes>,))> {
        let make = py.get_type::<Self>().getattr("from_bytes")?.unbind();
        Ok((make, (self.to_bytes(py)?,)))
    }
}

/// One mesh of all meshes of a scene, in their order, and what the materials of all are.
#[derive(Default)]
pub(crate) struct Gathered {
    pub(crate) mesh: FlatMesh,
    pub(crate) model: Model,
}

impl Gathered {
    /// Appends a mesh; without looks it is plain grey.
    pub(crate) fn add(
        &mut self,
        positions: Vec<[f32; 3]>,
        indices: &[[u32; 3]],
        looks: Option<&NativeLooks>,
    ) -> PyResult<()> {
        let plain = FlatMesh::default();
        let other = looks.map_or(&plain, |looks| &looks.mesh);
        let mesh = &mut self.mesh;
        let (first, vertices) = (mesh.positions.len(), positions.len());
        let fits = |length: usize, all: usize| length == 0 || length == all;
        if !(fits(other.normals.len(), vertices)
            && fits(other.uvs.len(), vertices)
            && fits(other.material_of.len(), indices.len()))
        {
            return Err(PyValueError::new_err("the looks are those of another mesh"));
        }
        if first + vertices > u32::MAX as usize {
            return Err(PyValueError::new_err("more than 2^32 vertices"));
        }
        mesh.positions.extend(positions);
        append(&mut mesh.normals, &other.normals, first, vertices);
        append(&mut mesh.uvs, &other.uvs, first, vertices);
        let shift = |corners: &[u32; 3]| corners.map(|corner| corner + first as u32);
        mesh.indices.extend(indices.iter().map(shift));
        let material = |&number: &u32| number.saturating_add(self.model.materials.len() as u32);
        mesh.material_of
            .extend(other.material_of.iter().map(material));
        mesh.material_of.resize(mesh.indices.len(), u32::MAX);
        if let Some(looks) = looks {
            self.add_materials(&looks.model);
        }
        Ok(())
    }

    fn add_materials(&mut self, other: &Model) {
        let first = self.model.textures.len() as u32;
        let moved = |material: &Material| Material {
            base_color_texture: material
                .base_color_texture
                .map(|number| number.saturating_add(first)),
            ..material.clone()
        };
        self.model
            .materials
            .extend(other.materials.iter().map(moved));
        self.model.textures.extend_from_slice(&other.textures);
        self.model.cameras.extend_from_slice(&other.cameras);
    }
}

/// Of each vertex, if any mesh has it: zero where one has none.
fn append<const N: usize>(
    all: &mut Vec<[f32; N]>,
    more: &[[f32; N]],
    before: usize,
    vertices: usize,
) {
    if all.is_empty() && more.is_empty() {
        return;
    }
    all.resize(before, [0.0; N]);
    all.extend_from_slice(more);
    all.resize(before + vertices, [0.0; N]);
}
