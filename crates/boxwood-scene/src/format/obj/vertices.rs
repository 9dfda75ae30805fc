//! OBJ's corners, which number position, texture coordinate and normal apart, as vertices.

use crate::Mesh;

/// Stands for "no texture coordinate" and "no normal".
pub(super) const NONE: u32 = u32::MAX;

/// Vertices made of a position, a texture coordinate and a normal, each combination once.
///
/// The vertices at one position form a chain. A chain is searched for [`Split::LONGEST`] steps only, then a twin is
/// made: that keeps the time linear for any file, and a twin does no harm.
#[derive(Debug)]
pub(super) struct Split {
    first: Vec<u32>,
    vertices: Vec<[u32; 3]>,
    next: Vec<u32>,
}

impl Split {
    const LONGEST: usize = 32;

    /// Turns the position indices of `triangles` into vertices without texture coordinate and normal.
    pub(super) fn of(positions: usize, triangles: &mut [[u32; 3]]) -> Self {
        let mut split = Self {
            first: vec![NONE; positions],
            vertices: Vec::new(),
            next: Vec::new(),
        };
        for index in triangles.iter_mut().flatten() {
            *index = split.find_or_add([*index, NONE, NONE]);
        }
        split
    }

    pub(super) fn vertex(&mut self, corner: [u32; 3]) -> Result<u32, String> {
        if self.vertices.len() >= NONE as usize {
            return Err(format!("more than {NONE} different vertices"));
        }
        Ok(self.find_or_add(corner))
    }

    fn find_or_add(&mut self, corner: [u32; 3]) -> u32 {
        let position = corner[0] as usize;
        if position >= self.first.len() {
            self.first.resize(position + 1, NONE);
        }
        let mut vertex = self.first[position];
        for _ in 0..Self::LONGEST {
            if vertex == NONE {
                break;
            }
            if self.vertices[vertex as usize] == corner {
                return vertex;
            }
            vertex = self.next[vertex as usize];
        }
        let new = self.vertices.len() as u32;
        self.vertices.push(corner);
        self.next.push(self.first[position]);
        self.first[position] = new;
        new
    }

    /// Writes the vertices out. Where one has no normal (texture coordinate) but others have, it is zero.
    pub(super) fn fill(
        self,
        positions: &[[f32; 3]],
        uvs: &[[f32; 2]],
        normals: &[[f32; 3]],
        mesh: &mut Mesh,
    ) {
        drop((self.first, self.next));
        let vertices = &self.vertices;
        mesh.positions = vertices.iter().map(|v| positions[v[0] as usize]).collect();
        if vertices.iter().any(|v| v[1] != NONE) {
            mesh.uvs = vertices
                .iter()
                .map(|v| uvs.get(v[1] as usize).copied().unwrap_or_default())
                .collect();
        }
        if vertices.iter().any(|v| v[2] != NONE) {
            mesh.normals = vertices
                .iter()
                .map(|v| normals.get(v[2] as usize).copied().unwrap_or_default())
                .collect();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_corners_share_a_vertex() {
        let mut triangles = [[0, 1, 0]];
        let mut split = Split::of(2, &mut triangles);
        assert_eq!(triangles, [[0, 1, 0]]);
        assert_eq!(split.vertex([0, 5, NONE]), Ok(2));
        assert_eq!(split.vertex([0, NONE, NONE]), Ok(0));
        assert_eq!(split.vertex([0, 5, NONE]), Ok(2));
        assert_eq!(split.vertex([7, 5, 1]), Ok(3));
    }

    #[test]
    fn time_is_linear_where_one_position_has_many_normals() {
        let mut split = Split::of(1, &mut []);
        for normal in 0..1_000_000 {
            assert!(split.vertex([0, NONE, normal]).is_ok());
        }
        // A twin, since the first one is deep in the chain by now.
        assert_eq!(split.vertex([0, NONE, 0]), Ok(1_000_000));
    }
}
