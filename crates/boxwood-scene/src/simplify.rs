//! Fewer triangles, nearly the same shape.
//!
//! Garland, Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997: the edge whose removal
//! moves the surface least is collapsed, again and again. Borders and the borders between materials are held by planes
//! that stand on them.

mod mesh;
mod quadric;

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec3;

use crate::FlatMesh;
use mesh::Net;
use quadric::Quadric;

/// Reduces `mesh` to `target_triangles` by collapsing edges.
///
/// The result has exactly the target where the mesh allows it: a closed surface loses two triangles at a time (so an
/// odd target is missed by one, below), no piece goes below the fewest triangles that keep it what it is (four for a
/// closed one), and no triangle may turn over. Compare `indices.len()` with the target to see how near it came.
///
/// Equal positions are welded first and triangles without three different corners are dropped, also where the target
/// asks for no reduction. Materials stay with their triangles; normals and texture coordinates are left out. Vertices
/// that did not move keep their bits. `O(n log n)` time, about 500 bytes a triangle; the same result everywhere.
pub fn simplify(mesh: &FlatMesh, target_triangles: usize) -> FlatMesh {
    let first = Work::reduced(mesh, target_triangles, usize::MAX);
    if first.net.triangle_count() + 1 != target_triangles || first.border_collapses == 0 {
        return first.net.finish(mesh);
    }
    // One too few: the last steps took two triangles each. With one border step (of one triangle) less it comes out.
    let second = Work::reduced(mesh, target_triangles, first.border_collapses - 1);
    let best = if second.net.triangle_count() == target_triangles {
        second
    } else {
        first
    };
    best.net.finish(mesh)
}

/// How much heavier than a triangle the plane on a border is.
const BORDER_WEIGHT: f64 = 10.0;

/// An edge and where its two ends would meet.
struct Collapse {
    cost: f64,
    /// `ends[0]` stays, `ends[1]` goes.
    ends: [u32; 2],
    place: DVec3,
    /// [`Work::version`] of the ends when this was computed; an older one is stale.
    versions: [u32; 2],
}

struct Work {
    net: Net,
    quadrics: Vec<Quadric>,
    /// Counts the moves of each vertex.
    version: Vec<u32>,
    queue: BinaryHeap<Collapse>,
    /// Collapses so far that took one triangle.
    border_collapses: usize,
}

impl Work {
    /// `mesh` with edges collapsed until the target is reached or nothing more may go. At most `border_budget` of the
    /// collapses take place on borders.
    fn reduced(mesh: &FlatMesh, target_triangles: usize, border_budget: usize) -> Self {
        let mut work = Self::new(Net::weld(mesh));
        while work.net.triangle_count() > target_triangles {
            let excess = work.net.triangle_count() - target_triangles;
            let Some(collapse) = work.next_collapse(excess, border_budget) else {
                break;
            };
            work.apply(&collapse);
        }
        work
    }

    fn new(net: Net) -> Self {
        let mut work = Self {
            quadrics: quadrics(&net),
            version: vec![0; net.vertex_count()],
            queue: BinaryHeap::new(),
            border_collapses: 0,
            net,
        };
        for [a, b] in work.net.edges() {
            work.enqueue(a, b);
        }
        work
    }

    /// The cheapest collapse that is allowed. For an `excess` of one, a border edge (which takes one triangle with
    /// it) goes before an inner edge (which takes two).
    fn next_collapse(&mut self, excess: usize, border_budget: usize) -> Option<Collapse> {
        let mut inner = None;
        while let Some(collapse) = self.queue.pop() {
            let current = collapse.ends.map(|v| self.version[v as usize]) == collapse.versions;
            if !current || !self.net.may_collapse(collapse.ends, collapse.place) {
                continue;
            }
            match self.net.triangles_at(collapse.ends) {
                1 if self.border_collapses >= border_budget => {}
                2.. if excess == 1 => _ = inner.get_or_insert(collapse),
                _ => return Some(collapse),
            }
        }
        inner
    }

    fn apply(&mut self, collapse: &Collapse) {
        let [kept, gone] = collapse.ends;
        self.border_collapses += usize::from(self.net.triangles_at(collapse.ends) == 1);
        self.net.collapse(collapse.ends, collapse.place);
        self.quadrics[kept as usize] = self.quadrics[kept as usize] + self.quadrics[gone as usize];
        self.version[kept as usize] += 1;
        self.version[gone as usize] += 1;
        for neighbour in self.net.neighbours(kept) {
            self.enqueue(kept, neighbour);
        }
    }

    fn enqueue(&mut self, a: u32, b: u32) {
        let ends = [a.min(b), a.max(b)];
        let quadric = self.quadrics[a as usize] + self.quadrics[b as usize];
        let [p, q] = ends.map(|v| self.net.position(v));
        let (place, cost) = quadric.best_place(p, q);
        // Among equal costs, as on a plane, the shorter edge goes first: that keeps triangles round.
        let cost = cost + 1e-9 * quadric.weight() * p.distance_squared(q);
        self.queue.push(Collapse {
            cost,
            ends,
            place,
            versions: ends.map(|v| self.version[v as usize]),
        });
    }
}

/// One quadric per vertex: the planes of its triangles by area, and the planes that stand on borders.
fn quadrics(net: &Net) -> Vec<Quadric> {
    let mut quadrics = vec![Quadric::default(); net.vertex_count()];
    for triangle in net.triangles() {
        let corners = triangle.map(|v| net.position(v));
        let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let quadric =
            Quadric::of_plane(cross.normalize_or_zero(), corners[0], cross.length() * 0.5);
        for v in triangle {
            quadrics[v as usize] = quadrics[v as usize] + quadric;
        }
    }
    for (edge, normal) in net.borders() {
        let [p, q] = edge.map(|v| net.position(v));
        let upright = (q - p).cross(normal).normalize_or_zero();
        let quadric = Quadric::of_plane(upright, p, BORDER_WEIGHT * p.distance_squared(q));
        for v in edge {
            quadrics[v as usize] = quadrics[v as usize] + quadric;
        }
    }
    quadrics
}

impl Ord for Collapse {
    /// The cheapest is the greatest, since [`BinaryHeap`] gives the greatest first; ties by name, never by luck.
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .cost
            .total_cmp(&self.cost)
            .then_with(|| other.ends.cmp(&self.ends))
    }
}

impl PartialOrd for Collapse {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Collapse {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Collapse {}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::builtin;

    fn flat(spec: &str) -> FlatMesh {
        builtin(spec).unwrap().flatten().unwrap()
    }

    /// Every directed edge once, and its opposite once.
    fn is_closed(mesh: &FlatMesh) -> bool {
        let edges: Vec<_> = mesh
            .indices
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .collect();
        let set: HashSet<_> = edges.iter().copied().collect();
        set.len() == edges.len() && set.iter().all(|&[a, b]| set.contains(&[b, a]))
    }

    #[test]
    fn a_closed_sphere_stays_closed_and_round() {
        let sphere = flat("sphere?n=20000");
        for target in [5000, 400, 60] {
            let small = simplify(&sphere, target);
            assert_eq!(small.indices.len(), target);
            assert!(is_closed(&small));
            let area: f64 = small
                .indices
                .iter()
                .map(|t| mesh::area(t.map(|v| small.positions[v as usize])))
                .sum();
            let expected = 4.0 * std::f64::consts::PI;
            assert!(
                (area / expected - 1.0).abs() < 8.0 / target as f64,
                "{target}: {area} of {expected}"
            );
        }
    }

    #[test]
    fn a_closed_piece_ends_as_a_tetrahedron() {
        let small = simplify(&flat("sphere?n=800"), 0);
        assert_eq!(small.indices.len(), 4);
        assert!(is_closed(&small));
    }

    #[test]
    fn an_odd_target_is_met_where_there_is_a_border() {
        let land = flat("terrain?n=5000");
        for target in [777, 778] {
            assert_eq!(simplify(&land, target).indices.len(), target);
        }
        assert_eq!(simplify(&flat("sphere?n=800"), 101).indices.len(), 100);
    }

    #[test]
    fn the_border_of_a_plane_stays_where_it_is() {
        let land = flat("terrain?n=5000");
        let small = simplify(&land, 200);
        let ((min, max), (small_min, small_max)) =
            (land.bounds().unwrap(), small.bounds().unwrap());
        for axis in [0, 2] {
            assert!(
                (min[axis] - small_min[axis]).abs() < 1.0,
                "axis {axis}: {small_min:?} of {min:?}"
            );
            assert!(
                (max[axis] - small_max[axis]).abs() < 1.0,
                "axis {axis}: {small_max:?} of {max:?}"
            );
        }
    }

    #[test]
    fn a_target_above_the_count_changes_no_bit() {
        let sphere = flat("sphere?n=800");
        let same = simplify(&sphere, 1_000_000);
        let corners = |mesh: &FlatMesh| -> Vec<_> {
            mesh.indices
                .iter()
                .flatten()
                .map(|&v| mesh.positions[v as usize].map(f32::to_bits))
                .collect()
        };
        assert!(corners(&same) == corners(&sphere));
    }

    #[test]
    fn materials_stay_where_they_were() {
        let room = flat("cornell");
        let small = simplify(&room, 28);
        let materials = |mesh: &FlatMesh| mesh.material_of.iter().copied().collect::<HashSet<_>>();
        assert_eq!(materials(&small), materials(&room));
        assert_eq!(small.material_of.len(), small.indices.len());
    }

    #[test]
    fn degenerate_and_empty_input_is_fine() {
        assert_eq!(simplify(&FlatMesh::default(), 5).indices.len(), 0);
        let mut far = flat("sphere?n=200");
        far.positions.iter_mut().flatten().for_each(|x| *x *= 1e30);
        assert_eq!(simplify(&far, 50).indices.len(), 50);
        let same = FlatMesh {
            positions: vec![[3.5; 3]; 9],
            indices: vec![[0, 1, 2]; 7],
            ..FlatMesh::default()
        };
        assert_eq!(simplify(&same, 1).indices.len(), 0);
        let fan = FlatMesh {
            positions: (0..9).map(|i| [i as f32, (i * i) as f32, 0.0]).collect(),
            indices: (2..9).map(|i| [0, 1, i]).collect(),
            ..FlatMesh::default()
        };
        assert!(
            simplify(&fan, 3).indices.len() <= 7,
            "an edge with seven triangles"
        );
    }
}
