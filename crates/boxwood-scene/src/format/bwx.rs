//! Saved scenes of Boxwood: their triangles. The tree is for [`boxwood::Scene::open`]; here it is only checked.

use boxwood::{AlignedBytes, FileError, Scene};
use glam::Mat4;

use super::Format;
use crate::{Door, FlatMesh, Instance, LoadError, Mesh, Model};

pub(crate) const FORMAT: Format = Format {
    name: "bwx",
    extensions: &["bwx"],
    about: "scenes saved by `boxwood build -o`: triangles alone, built again where a structure is asked for",
    sniff,
    load,
};

fn sniff(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89BWX")
}

fn load(bytes: &[u8], door: &mut Door) -> Result<Model, LoadError> {
    let refused = |error: FileError| door.error(None, error.to_string());
    let copy = AlignedBytes::copy(bytes).map_err(refused)?;
    let scene = Scene::open_bytes(copy).map_err(refused)?;
    let (count, limit) = (scene.len() as u64, door.limits().max_triangles);
    if count > limit {
        let cause = format!("has {count} triangles, the limit is {limit}");
        return Err(door.error(None, cause));
    }
    if count == 0 {
        door.warn("a scene without triangles");
    }
    if let Some(origin) = origin(&scene) {
        let [x, y, z] = origin;
        door.warn(format!(
            "its coordinates count from the note `origin`, ({x}, {y}, {z}): add that to what is printed"
        ));
    }
    let mut model = Model::default();
    let mut indexed = Indexed::of(&scene, door);
    for geom in 0.. {
        let Some(len) = scene.mesh_len(geom) else {
            break;
        };
        let mesh = match &mut indexed {
            Some(indexed) => indexed.mesh(&scene, geom, len),
            None => soup(&scene, geom, len),
        };
        let mesh = mesh.ok_or_else(|| {
            door.error(
                None,
                "the notes `vertices` and `indices` are not those of its triangles",
            )
            .with_remedy("save the scene again")
        })?;
        if len > 0 {
            let mesh = (model.meshes.push(mesh), model.meshes.len() as u32 - 1).1;
            let world_from_mesh = Mat4::IDENTITY;
            model.instances.push(Instance {
                mesh,
                world_from_mesh,
            });
        }
    }
    Ok(model)
}

/// The scene with notes of which vertices the triangles of `mesh` share, over which it was built: so that whoever opens its file can
/// blend what vertices carry. 12 bytes a triangle.
pub fn with_vertices(scene: Scene, mesh: &FlatMesh) -> Scene {
    let indices = mesh.indices.as_flattened().iter();
    let indices: Vec<u8> = indices.flat_map(|index| index.to_le_bytes()).collect();
    scene
        .with_note("vertices", (mesh.positions.len() as u64).to_le_bytes())
        .with_note("indices", indices)
}

/// Vertices for each triangle, over all meshes of a scene: most of more have no triangle. A file may say anything, and shall not take more
/// memory than its own length explains.
const MOST_VERTICES: u64 = 15;

/// What Python has taken from the coordinates, which single precision would else have rounded: three numbers of 64 bits.
fn origin(scene: &Scene) -> Option<[f64; 3]> {
    let (numbers, rest) = scene.note("origin")?.as_chunks::<8>();
    let origin: [f64; 3] = <[[u8; 8]; 3]>::try_from(numbers)
        .ok()?
        .map(f64::from_le_bytes);
    (rest.is_empty() && origin != [0.0; 3]).then_some(origin)
}

/// Three vertices for each triangle.
fn soup(scene: &Scene, geom: u32, len: usize) -> Option<Mesh> {
    let triangles = (0..len as u32).map(|prim| scene.triangle(geom, prim));
    let positions: Vec<[f32; 3]> = triangles
        .map(|triangle| Some(triangle?.0))
        .collect::<Option<Vec<_>>>()?
        .into_flattened();
    let indices = (0..len as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    Some(Mesh {
        indices: indices.collect(),
        positions,
        ..Mesh::default()
    })
}

/// What notes say of the vertices that triangles share.
struct Indexed<'a> {
    counts: std::slice::Iter<'a, [u8; 8]>,
    indices: std::slice::Iter<'a, [[u8; 4]; 3]>,
}

impl<'a> Indexed<'a> {
    /// `None` where there are no such notes, or more vertices than are worth it.
    fn of(scene: &'a Scene, door: &mut Door) -> Option<Self> {
        let (indices, _) = scene.note("indices")?.as_chunks::<4>();
        let counts = scene.note("vertices")?.as_chunks::<8>().0.iter();
        let add = |sum: u64, count: &[u8; 8]| sum.saturating_add(u64::from_le_bytes(*count));
        let (vertices, triangles) = (counts.clone().fold(0, add), scene.len() as u64);
        if vertices > MOST_VERTICES * triangles {
            door.warn(format!(
                "{vertices} vertices for {triangles} triangles: each triangle is given three of its own"
            ));
            return None;
        }
        Some(Self {
            counts,
            indices: indices.as_chunks::<3>().0.iter(),
        })
    }

    /// Vertices that no triangle has are zero. `None` if the notes do not fit the triangles.
    fn mesh(&mut self, scene: &Scene, geom: u32, len: usize) -> Option<Mesh> {
        let count = usize::try_from(u64::from_le_bytes(*self.counts.next()?)).ok()?;
        let mut mesh = Mesh::default();
        mesh.positions.try_reserve_exact(count).ok()?;
        mesh.positions.resize(count, [0.0; 3]);
        for prim in 0..len as u32 {
            let corners = self.indices.next()?.map(u32::from_le_bytes);
            for (vertex, position) in corners.into_iter().zip(scene.triangle(geom, prim)?.0) {
                *mesh.positions.get_mut(vertex as usize)? = position;
            }
            mesh.indices.push(corners);
        }
        // Two triangles must not disagree about a vertex.
        let is_same = |prim: u32, corners: &[u32; 3]| {
            let kept = corners.map(|vertex| mesh.positions[vertex as usize].map(f32::to_bits));
            scene
                .triangle(geom, prim)
                .is_some_and(|t| t.0.map(|p| p.map(f32::to_bits)) == kept)
        };
        let all_same = (0_u32..)
            .zip(&mesh.indices)
            .all(|(prim, corners)| is_same(prim, corners));
        all_same.then_some(mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;

    fn bytes(scene: &Scene) -> Vec<u8> {
        let mut bytes = Vec::new();
        scene.save(&mut bytes).unwrap();
        bytes
    }

    fn square() -> ([[f32; 3]; 4], [[u32; 3]; 2]) {
        let positions = [
            [0.0, 0.0, 1.0],
            [2.0, 0.0, 1.5],
            [0.0, 3.0, 1.0],
            [2.5, 3.0, 1.0],
        ];
        (positions, [[0, 1, 2], [1, 3, 2]])
    }

    fn loaded(bytes: &[u8]) -> Result<Model, LoadError> {
        crate::load_bytes("a.bwx", None, bytes, Limits::default())
    }

    #[test]
    fn triangles_come_back_with_the_vertices_that_they_share() {
        let (positions, indices) = square();
        let scene = Scene::new(&positions, &indices).unwrap();
        let model = loaded(&bytes(&scene)).unwrap();
        assert_eq!(model.meshes[0].positions.len(), 6);
        let mesh = FlatMesh {
            positions: positions.to_vec(),
            indices: indices.to_vec(),
            ..FlatMesh::default()
        };
        let noted = with_vertices(scene, &mesh);
        let model = loaded(&bytes(&noted)).unwrap();
        assert_eq!(model.meshes[0].positions, positions);
        assert_eq!(model.meshes[0].indices, indices);
        // Known by its content, too.
        let unnamed = crate::load_bytes("-", None, &bytes(&noted), Limits::default()).unwrap();
        assert_eq!(unnamed.triangle_count(), 2);
    }

    #[test]
    fn meshes_together_have_no_more_vertices_than_the_file_explains() {
        let (positions, indices) = square();
        let many = |count: u64| {
            let one = |builder: boxwood::SceneBuilder, _| builder.mesh(&positions, &indices[..1]);
            let scene = (0..400).fold(Scene::builder(), one).build().unwrap();
            let corners = [0, 1, 2].map(u32::to_le_bytes).as_flattened().repeat(400);
            let noted = scene
                .with_note("vertices", count.to_le_bytes().repeat(400))
                .with_note("indices", corners);
            let model = loaded(&bytes(&noted)).unwrap();
            (model.meshes[399].positions.len(), model.warnings.join(""))
        };
        assert_eq!(many(15), (15, String::new()));
        for over in [16, 4803, u64::MAX] {
            let (vertices, told) = many(over);
            assert_eq!(vertices, 3);
            assert!(told.contains("vertices for 400 triangles"), "{told}");
        }
    }

    #[test]
    fn an_origin_is_told_of() {
        let (positions, indices) = square();
        let warnings = |origin: [f64; 3]| {
            let scene = Scene::new(&positions, &indices).unwrap();
            let noted = scene.with_note("origin", origin.map(f64::to_le_bytes).as_flattened());
            loaded(&bytes(&noted)).unwrap().warnings
        };
        assert_eq!(warnings([0.0; 3]), [""; 0]);
        let told = warnings([691_000.5, 5_336_000.0, 0.0]).join("");
        assert!(told.contains("(691000.5, 5336000, 0)"), "{told}");
    }

    #[test]
    fn notes_that_lie_and_broken_files_are_refused() {
        let (positions, indices) = square();
        for (count, first) in [(3_u64, 0_u32), (4, 9), (4, 3)] {
            let mut lie = indices;
            lie[0][0] = first;
            let lie: Vec<u8> = lie
                .as_flattened()
                .iter()
                .flat_map(|i| i.to_le_bytes())
                .collect();
            let scene = Scene::new(&positions, &indices).unwrap();
            let noted = scene
                .with_note("vertices", count.to_le_bytes())
                .with_note("indices", lie);
            let error = loaded(&bytes(&noted)).unwrap_err().to_string();
            assert!(error.contains("a.bwx: the notes"), "{error}");
        }
        let mut broken = bytes(&Scene::new(&positions, &indices).unwrap());
        broken[500] ^= 1;
        let error = loaded(&broken).unwrap_err().to_string();
        assert!(error.starts_with("a.bwx: the content is not"), "{error}");
    }
}
