//! The elements of a PLY file that make a mesh: vertices, polygons, strips.

use glam::Mat4;

use super::header::{Element, Kind};
use super::values::Values;
use crate::format::polygon::Triangulator;
use crate::{Door, Instance, Mesh, Model};

/// How a list of vertex indices makes triangles.
#[derive(Clone, Copy)]
pub(super) enum Faces {
    Polygons,
    Strips,
}

/// The mesh as far as it has been read.
#[derive(Default)]
pub(super) struct Reader {
    mesh: Mesh,
    max_triangles: u64,
    has_vertices: bool,
    triangulator: Triangulator,
    polygon: Vec<[f32; 3]>,
    flat_faces: u64,
    bad_attributes: u64,
}

impl Reader {
    pub(super) fn new(max_triangles: u64) -> Self {
        Self {
            max_triangles,
            ..Self::default()
        }
    }

    /// Reads the element `vertex`.
    pub(super) fn vertices(
        &mut self,
        element: &Element,
        values: &mut impl Values,
    ) -> Result<(), String> {
        if self.has_vertices {
            return Err("a second element \"vertex\"".to_owned());
        }
        self.has_vertices = true;
        let slots = Slots::of(element)?;
        let count = usize::try_from(element.count).map_err(|_| "too many vertices".to_owned())?;
        if count > u32::MAX as usize {
            return Err(format!(
                "{count} vertices, at most {} can be numbered",
                u32::MAX
            ));
        }
        self.mesh.positions.reserve_exact(count);
        self.mesh
            .normals
            .reserve_exact(if slots.has_normals { count } else { 0 });
        self.mesh
            .uvs
            .reserve_exact(if slots.has_uvs { count } else { 0 });

        for _ in 0..count {
            let mut row = [0.0; UNUSED + 1];
            values.begin_row()?;
            for (property, &slot) in element.properties.iter().zip(&slots.of_property) {
                if slot == UNUSED {
                    values.skip_property(property)?;
                } else {
                    // Rounds double to float; what is too large becomes infinite, and is refused below.
                    row[slot] = values.number(property.kind)? as f32;
                }
            }
            self.vertex(&row, &slots)?;
            values.end_row()?;
        }
        Ok(())
    }

    fn vertex(&mut self, row: &[f32; UNUSED + 1], slots: &Slots) -> Result<(), String> {
        let &[x, y, z, nx, ny, nz, u, v, _] = row;
        if ![x, y, z].iter().all(|value| value.is_finite()) {
            let i = self.mesh.positions.len();
            return Err(format!(
                "vertex {i} has a coordinate that is not finite: {x} {y} {z}"
            ));
        }
        self.mesh.positions.push([x, y, z]);
        let is_bad = |values: &[f32]| !values.iter().all(|value| value.is_finite());
        if slots.has_normals {
            let bad = is_bad(&[nx, ny, nz]);
            self.bad_attributes += u64::from(bad);
            self.mesh
                .normals
                .push(if bad { [0.0; 3] } else { [nx, ny, nz] });
        }
        if slots.has_uvs {
            let bad = is_bad(&[u, v]);
            self.bad_attributes += u64::from(bad);
            self.mesh.uvs.push(if bad { [0.0; 2] } else { [u, v] });
        }
        Ok(())
    }

    /// Reads an element that makes triangles.
    pub(super) fn faces(
        &mut self,
        element: &Element,
        values: &mut impl Values,
        faces: Faces,
    ) -> Result<(), String> {
        let list = element.properties.iter().position(|property| {
            property.list_count.is_some()
                && matches!(
                    property.name.as_slice(),
                    b"vertex_indices" | b"vertex_index" | b"vertex_indexes"
                )
        });
        let Some(list) = list else {
            return Err(format!(
                "element \"{}\" has no list \"vertex_indices\"",
                element.shown_name()
            ));
        };
        if !self.has_vertices && element.count > 0 {
            return Err(format!(
                "element \"{}\" stands before \"vertex\"",
                element.shown_name()
            ));
        }
        // A triangle takes at least its length and three indices, so this never asks for what is not there.
        let triangle = 1 + 3 * values.least_size(element.properties[list].kind);
        let likely = (values.bytes_left() / triangle)
            .min(usize::try_from(element.count).unwrap_or(usize::MAX));
        self.mesh.indices.reserve_exact(likely);

        let mut corners: Vec<u32> = Vec::new();
        for _ in 0..element.count {
            values.begin_row()?;
            for (i, property) in element.properties.iter().enumerate() {
                match property.list_count {
                    Some(count) if i == list => {
                        self.corners(count, property.kind, values, &mut corners, faces)?;
                    }
                    _ => values.skip_property(property)?,
                }
            }
            match faces {
                Faces::Polygons => self.face(&corners),
                Faces::Strips => self.strips(&corners),
            }
            if self.mesh.indices.len() as u64 > self.max_triangles {
                return Err(format!(
                    "more than {} triangles, which is the limit",
                    self.max_triangles
                ));
            }
            values.end_row()?;
        }
        Ok(())
    }

    /// Reads one list of vertex indices. In strips, [`RESTART`] stands for -1.
    fn corners(
        &self,
        count: Kind,
        kind: Kind,
        values: &mut impl Values,
        corners: &mut Vec<u32>,
        faces: Faces,
    ) -> Result<(), String> {
        let vertices = self.mesh.positions.len();
        corners.clear();
        for _ in 0..values.length(count)? {
            let value = values.number(kind)?;
            let is_restart = value == -1.0 && matches!(faces, Faces::Strips);
            if is_restart {
                corners.push(RESTART);
            } else if value >= 0.0 && value < vertices as f64 && value.fract() == 0.0 {
                corners.push(value as u32);
            } else {
                return Err(format!("face refers to vertex {value} of {vertices}"));
            }
        }
        Ok(())
    }

    fn face(&mut self, corners: &[u32]) {
        if let &[a, b, c] = corners {
            self.mesh.indices.push([a, b, c]);
            return;
        }
        if corners.len() < 3 {
            self.flat_faces += 1;
            return;
        }
        let mesh = &mut self.mesh;
        self.polygon.clear();
        self.polygon.extend(
            corners
                .iter()
                .map(|&corner| mesh.positions[corner as usize]),
        );
        self.triangulator.cut(&self.polygon, |triangle| {
            mesh.indices.push(triangle.map(|i| corners[i]));
        });
    }

    /// Every second triangle of a strip turns the other way, so that all face the same side.
    fn strips(&mut self, corners: &[u32]) {
        for strip in corners.split(|&corner| corner == RESTART) {
            let triangles = strip.windows(3).enumerate();
            self.mesh.indices.extend(triangles.map(|(i, w)| {
                if i % 2 == 0 {
                    [w[0], w[1], w[2]]
                } else {
                    [w[1], w[0], w[2]]
                }
            }));
        }
    }

    /// The model, with what was tolerated noted at the door.
    pub(super) fn finish(self, door: &mut Door) -> Model {
        let name = door.name().to_owned();
        if self.flat_faces > 0 {
            door.warn(format!(
                "{name}: left out {} faces with fewer than three corners",
                self.flat_faces
            ));
        }
        if self.bad_attributes > 0 {
            door.warn(format!(
                "{name}: {} normals or texture coordinates are not finite, set to zero",
                self.bad_attributes
            ));
        }
        if self.triangulator.gave_up() {
            door.warn(format!(
                "{name}: the concave polygons are too large, some were cut as if they were convex"
            ));
        }
        let mut model = Model::default();
        if !self.mesh.positions.is_empty() {
            model.meshes.push(self.mesh);
            model.instances.push(Instance {
                mesh: 0,
                world_from_mesh: Mat4::IDENTITY,
            });
        }
        model
    }
}

/// Ends a strip. No vertex has this number: there are at most that many, counted from 0.
const RESTART: u32 = u32::MAX;

/// The slot of a property that is stepped over.
const UNUSED: usize = 8;

/// Which property goes where: 0 to 2 position, 3 to 5 normal, 6 and 7 texture coordinate.
struct Slots {
    of_property: Vec<usize>,
    has_normals: bool,
    has_uvs: bool,
}

impl Slots {
    fn of(element: &Element) -> Result<Self, String> {
        let mut taken = [false; UNUSED];
        let of_property: Vec<usize> = element
            .properties
            .iter()
            .map(|property| {
                let slot = match property.name.as_slice() {
                    b"x" => 0,
                    b"y" => 1,
                    b"z" => 2,
                    b"nx" => 3,
                    b"ny" => 4,
                    b"nz" => 5,
                    b"s" | b"u" | b"texture_u" | b"texture_s" | b"texcoord_u" => 6,
                    b"t" | b"v" | b"texture_v" | b"texture_t" | b"texcoord_v" => 7,
                    _ => UNUSED,
                };
                // Of two properties for one slot the first counts.
                if slot == UNUSED || property.list_count.is_some() || taken[slot] {
                    return UNUSED;
                }
                taken[slot] = true;
                slot
            })
            .collect();
        if !taken[..3].iter().all(|&t| t) {
            return Err("element \"vertex\" lacks x, y or z".to_owned());
        }
        Ok(Self {
            of_property,
            has_normals: taken[3..6].iter().all(|&t| t),
            has_uvs: taken[6..].iter().all(|&t| t),
        })
    }
}
