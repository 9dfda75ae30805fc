//! Is a mesh closed?

use crate::geom::Triangle;
use std::collections::HashMap;

/// True if every edge is used an even number of times, vertices being the same if their coordinates are.
///
/// This is just what makes every line that touches no edge meet the mesh an even number of times (it is a cycle modulo 2),
/// and by the tie rule of the exact test every other line too. The direction of edges does not matter, several closed
/// parts may cross, and triangles with two equal corners change nothing. No triangles: closed. Expected linear time.
pub fn closed(triangles: &[Triangle]) -> bool {
    let mut vertices: HashMap<[u32; 3], u32> = HashMap::new();
    let mut odd: HashMap<(u32, u32), bool> = HashMap::new();
    for Triangle(corners) in triangles {
        // 0 and -0 are one coordinate.
        let ids = corners.map(|corner| {
            let next = vertices.len() as u32;
            *vertices
                .entry(corner.map(|x| (x + 0.0).to_bits()))
                .or_insert(next)
        });
        for (a, b) in [(ids[0], ids[1]), (ids[1], ids[2]), (ids[2], ids[0])] {
            if a != b {
                *odd.entry((a.min(b), a.max(b))).or_default() ^= true;
            }
        }
    }
    odd.into_values().all(|is_odd| !is_odd)
}

#[cfg(test)]
mod tests {
    use super::*;

    const P: [[f32; 3]; 4] = [
        [0.0, 0.0, 0.0],
        [3.0, 0.5, 0.0],
        [0.0, 2.0, 1.0],
        [1.0, 1.0, 4.0],
    ];

    fn tetrahedron() -> Vec<Triangle> {
        [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]
            .map(|t| Triangle(t.map(|i: usize| P[i])))
            .to_vec()
    }

    #[test]
    fn a_tetrahedron_is_closed_and_no_part_of_it_is() {
        let whole = tetrahedron();
        assert!(closed(&whole));
        for left_out in 0..4 {
            let part: Vec<Triangle> = (0..4)
                .filter(|i| *i != left_out)
                .map(|i| whole[i])
                .collect();
            assert!(!closed(&part));
        }
    }

    #[test]
    fn signs_of_zero_turned_and_degenerate_triangles_do_not_open_a_mesh() {
        let mut mesh = tetrahedron();
        mesh[1].0[0] = [-0.0, 0.0, -0.0];
        mesh[2].0.swap(0, 1);
        mesh.push(Triangle([P[0], P[1], P[1]]));
        assert!(closed(&mesh));
    }

    #[test]
    fn a_vertex_moved_by_one_ulp_in_one_triangle_opens_a_mesh() {
        let mut mesh = tetrahedron();
        mesh[2].0[1][2] = mesh[2].0[1][2].next_up();
        assert!(!closed(&mesh));
    }
}
