//! Triangles that know their neighbours, so that an edge can be taken out.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use crate::FlatMesh;

/// A mesh in the making: positions in a unit box around zero, so that f64 has room for squares of squares.
pub(super) struct Net {
    positions: Vec<DVec3>,
    /// The vertex of the input that a vertex still stands on; `None` once moved.
    original: Vec<Option<u32>>,
    triangles: Vec<[u32; 3]>,
    /// Index of each triangle in the input.
    source: Vec<u32>,
    material: Vec<u32>,
    is_alive: Vec<bool>,
    alive: usize,
    /// The living triangles around each vertex.
    around: Vec<Vec<u32>>,
    center: DVec3,
    scale: f64,
}

/// The new normal may lean away from the old one by at most this cosine (about 78 degrees).
const LEAST_COSINE: f64 = 0.2;

impl Net {
    /// Welds equal positions; drops triangles that have no three different corners.
    pub(super) fn weld(mesh: &FlatMesh) -> Self {
        let (min, max) = mesh.bounds().unwrap_or(([0.0; 3], [1.0; 3]));
        let [min, max] = [min, max].map(|p| Vec3::from(p).as_dvec3());
        let (center, size) = ((min + max) * 0.5, (max - min).max_element());
        let scale = if size > 0.0 { size } else { 1.0 };

        let mut first_at = HashMap::new();
        let mut original = Vec::new();
        let mut welded = |v: u32| {
            // Minus zero is where zero is.
            let key = mesh.positions[v as usize].map(|x| (x + 0.0).to_bits());
            *first_at.entry(key).or_insert_with(|| {
                original.push(Some(v));
                original.len() as u32 - 1
            })
        };
        let (mut triangles, mut source) = (Vec::new(), Vec::new());
        for (i, triangle) in mesh.indices.iter().enumerate() {
            let [a, b, c] = triangle.map(&mut welded);
            if a != b && b != c && c != a {
                triangles.push([a, b, c]);
                source.push(i as u32);
            }
        }

        let place = |v: &Option<u32>| {
            v.map_or(DVec3::ZERO, |v| {
                Vec3::from(mesh.positions[v as usize]).as_dvec3()
            })
        };
        let positions: Vec<_> = original
            .iter()
            .map(|v| (place(v) - center) / scale)
            .collect();
        let mut around = vec![Vec::new(); positions.len()];
        for (i, triangle) in triangles.iter().enumerate() {
            triangle
                .iter()
                .for_each(|&v| around[v as usize].push(i as u32));
        }
        let material = source.iter().map(|&i| {
            mesh.material_of
                .get(i as usize)
                .copied()
                .unwrap_or(u32::MAX)
        });
        Self {
            material: material.collect(),
            is_alive: vec![true; triangles.len()],
            alive: triangles.len(),
            positions,
            original,
            triangles,
            source,
            around,
            center,
            scale,
        }
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.alive
    }

    pub(super) fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    pub(super) fn position(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize]
    }

    pub(super) fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.triangles
            .iter()
            .zip(&self.is_alive)
            .filter_map(|(triangle, alive)| alive.then_some(*triangle))
    }

    /// Every edge once, smaller vertex first.
    pub(super) fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges: Vec<_> = self
            .triangles()
            .flat_map(sides)
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// The edges at which the surface or its material ends, each with the normal of each triangle there.
    pub(super) fn borders(&self) -> Vec<([u32; 2], DVec3)> {
        let mut uses: Vec<_> = self
            .triangles
            .iter()
            .enumerate()
            .flat_map(|(i, &triangle)| sides(triangle).map(|[a, b]| ([a.min(b), a.max(b)], i)))
            .collect();
        uses.sort_unstable();
        let same_edge = uses.chunk_by(|x, y| x.0 == y.0);
        let is_border = |chunk: &&[([u32; 2], usize)]| {
            chunk.len() != 2 || self.material[chunk[0].1] != self.material[chunk[1].1]
        };
        same_edge
            .filter(is_border)
            .flatten()
            .map(|&(edge, i)| (edge, self.normal(self.triangles[i])))
            .collect()
    }

    /// How many triangles have this edge.
    pub(super) fn triangles_at(&self, [a, b]: [u32; 2]) -> usize {
        self.around[a as usize]
            .iter()
            .filter(|&&t| self.triangles[t as usize].contains(&b))
            .count()
    }

    /// The vertices that share an edge with `vertex`, each once, in ascending order.
    pub(super) fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let triangles = self.around[vertex as usize]
            .iter()
            .map(|&t| self.triangles[t as usize]);
        let mut neighbours: Vec<_> = triangles.flatten().filter(|&v| v != vertex).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
    }

    /// Whether the ends of an edge can meet at `place` without tearing, gluing or folding the surface.
    pub(super) fn may_collapse(&self, ends: [u32; 2], place: DVec3) -> bool {
        self.keeps_topology(ends)
            && ends
                .iter()
                .all(|&v| self.turns_nothing_over(v, ends, place))
    }

    /// The link condition of Dey et al. (1998): what is next to both ends must be across the edge, and no two
    /// triangles may fall together. An inner edge between two borders would pinch them.
    fn keeps_topology(&self, ends: [u32; 2]) -> bool {
        let [a, b] = ends;
        let (near_a, near_b) = (self.neighbours(a), self.neighbours(b));
        let shared = near_a
            .iter()
            .filter(|v| near_b.binary_search(v).is_ok())
            .count();
        let across = self.triangles_at(ends);
        if shared != across {
            return false;
        }
        if across == 2 && self.is_on_border(a) && self.is_on_border(b) {
            return false;
        }
        // Only a lone tetrahedron has two triangles that fall together when the link is right.
        let opposite = |v: u32, other: u32| {
            let triangles = self.around[v as usize]
                .iter()
                .map(|&t| self.triangles[t as usize]);
            triangles
                .filter(move |t| !t.contains(&other))
                .map(move |t| others(t, v))
        };
        !opposite(a, b).any(|pair| opposite(b, a).any(|other| other == pair))
    }

    fn is_on_border(&self, vertex: u32) -> bool {
        self.neighbours(vertex)
            .iter()
            .any(|&other| self.triangles_at([vertex, other]) != 2)
    }

    /// Whether the triangles around `vertex` that survive keep their side when it moves to `place`.
    fn turns_nothing_over(&self, vertex: u32, ends: [u32; 2], place: DVec3) -> bool {
        let triangles = self.around[vertex as usize]
            .iter()
            .map(|&t| self.triangles[t as usize]);
        triangles
            .filter(|t| !ends.iter().all(|v| t.contains(v)))
            .all(|triangle| {
                let before = triangle.map(|v| self.position(v));
                let after = triangle.map(|v| if v == vertex { place } else { self.position(v) });
                let [before, after] = [before, after].map(|[a, b, c]| (b - a).cross(c - a));
                // A triangle that had no area has no side to lose.
                before == DVec3::ZERO
                    || before.dot(after) > LEAST_COSINE * before.length() * after.length()
            })
    }

    /// Moves both ends to `place`; the second one is no more.
    pub(super) fn collapse(&mut self, ends: [u32; 2], place: DVec3) {
        let [kept, gone] = ends.map(|v| v as usize);
        if place != self.positions[kept] {
            self.original[kept] = if place == self.positions[gone] {
                self.original[gone]
            } else {
                None
            };
            self.positions[kept] = place;
        }
        for t in std::mem::take(&mut self.around[gone]) {
            let triangle = &mut self.triangles[t as usize];
            if triangle.contains(&ends[0]) {
                let triangle = *triangle;
                self.remove(t, triangle);
            } else {
                triangle
                    .iter_mut()
                    .filter(|v| **v == ends[1])
                    .for_each(|v| *v = ends[0]);
                self.around[kept].push(t);
            }
        }
    }

    fn remove(&mut self, t: u32, triangle: [u32; 3]) {
        self.is_alive[t as usize] = false;
        self.alive -= 1;
        for v in triangle {
            self.around[v as usize].retain(|&other| other != t);
        }
    }

    fn normal(&self, triangle: [u32; 3]) -> DVec3 {
        let [a, b, c] = triangle.map(|v| self.position(v));
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// What is left, in the order of the input, with only the vertices in use.
    pub(super) fn finish(&self, input: &FlatMesh) -> FlatMesh {
        let mut new_index = vec![u32::MAX; self.positions.len()];
        let mut mesh = FlatMesh::default();
        for (i, triangle) in self
            .triangles
            .iter()
            .enumerate()
            .filter(|(i, _)| self.is_alive[*i])
        {
            let corners = triangle.map(|v| {
                let index = &mut new_index[v as usize];
                if *index == u32::MAX {
                    *index = mesh.positions.len() as u32;
                    mesh.positions.push(match self.original[v as usize] {
                        Some(v) => input.positions[v as usize],
                        None => (self.positions[v as usize] * self.scale + self.center)
                            .as_vec3()
                            .to_array(),
                    });
                }
                *index
            });
            mesh.indices.push(corners);
            mesh.material_of.push(
                input
                    .material_of
                    .get(self.source[i] as usize)
                    .copied()
                    .unwrap_or(u32::MAX),
            );
        }
        mesh
    }
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// The two corners that are not `v`, in ascending order.
fn others(triangle: [u32; 3], v: u32) -> [u32; 2] {
    let [a, b, c] = triangle;
    let [x, y] = if a == v {
        [b, c]
    } else if b == v {
        [a, c]
    } else {
        [a, b]
    };
    [x.min(y), x.max(y)]
}

#[cfg(test)]
pub(super) fn area(corners: [[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| Vec3::from(p).as_dvec3());
    (b - a).cross(c - a).length() * 0.5
}
