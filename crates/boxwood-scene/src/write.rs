//! Meshes out, for other programs to read.

use std::io::{self, Write};

use crate::FlatMesh;

/// Writes `mesh` as binary little-endian PLY: positions bit by bit, normals and texture coordinates if it has them.
///
/// Materials are left out. Many small writes: hand over a buffered writer.
pub fn write_ply(mesh: &FlatMesh, out: &mut impl Write) -> io::Result<()> {
    let (has_normals, has_uvs) = (!mesh.normals.is_empty(), !mesh.uvs.is_empty());
    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n",
        mesh.positions.len()
    );
    let properties = [("x y z", true), ("nx ny nz", has_normals), ("s t", has_uvs)];
    for name in properties
        .iter()
        .filter(|(_, there)| *there)
        .flat_map(|(names, _)| names.split(' '))
    {
        header += &format!("property float {name}\n");
    }
    header += &format!(
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.indices.len()
    );
    out.write_all(header.as_bytes())?;

    let mut floats = |values: &[f32]| {
        values
            .iter()
            .try_for_each(|x| out.write_all(&x.to_le_bytes()))
    };
    for (i, p) in mesh.positions.iter().enumerate() {
        floats(p)?;
        if has_normals {
            floats(&mesh.normals[i])?;
        }
        if has_uvs {
            floats(&mesh.uvs[i])?;
        }
    }
    for triangle in &mesh.indices {
        out.write_all(&[3])?;
        triangle
            .iter()
            .try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
    }
    Ok(())
}

/// Writes `mesh` as OBJ, with normals and texture coordinates if it has them.
///
/// Each number is the shortest decimal that reads back to the same bits. Materials are left out. Many small writes:
/// hand over a buffered writer.
pub fn write_obj(mesh: &FlatMesh, out: &mut impl Write) -> io::Result<()> {
    for [x, y, z] in &mesh.positions {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for [u, v] in &mesh.uvs {
        writeln!(out, "vt {u} {v}")?;
    }
    for [x, y, z] in &mesh.normals {
        writeln!(out, "vn {x} {y} {z}")?;
    }
    let corner = |v: u32| {
        let v = u64::from(v) + 1;
        match (mesh.uvs.is_empty(), mesh.normals.is_empty()) {
            (true, true) => format!("{v}"),
            (false, true) => format!("{v}/{v}"),
            (true, false) => format!("{v}//{v}"),
            (false, false) => format!("{v}/{v}/{v}"),
        }
    };
    for [a, b, c] in &mesh.indices {
        writeln!(out, "f {} {} {}", corner(*a), corner(*b), corner(*c))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Limits, load_bytes};

    fn mesh(has_normals: bool, has_uvs: bool) -> FlatMesh {
        FlatMesh {
            positions: vec![
                [0.1, -2.5e-30, 3.0],
                [1.0 / 3.0, 16_777_216.0, -1e20],
                [7.0, 0.5, 0.25],
            ],
            normals: if has_normals {
                vec![[0.0, 0.6, -0.8]; 3]
            } else {
                vec![]
            },
            uvs: if has_uvs {
                vec![[0.25, 0.75]; 3]
            } else {
                vec![]
            },
            indices: vec![[0, 1, 2], [2, 1, 0]],
            material_of: vec![u32::MAX; 2],
        }
    }

    #[test]
    fn what_is_written_reads_back_with_the_same_bits() {
        for (normals, uvs) in [(false, false), (true, false), (false, true), (true, true)] {
            let before = mesh(normals, uvs);
            let (mut ply, mut obj) = (Vec::new(), Vec::new());
            write_ply(&before, &mut ply).unwrap();
            write_obj(&before, &mut obj).unwrap();
            for (name, bytes) in [("a.ply", ply), ("a.obj", obj)] {
                let after = load_bytes(name, None, &bytes, Limits::default())
                    .unwrap()
                    .flatten()
                    .unwrap();
                assert_eq!(after.positions, before.positions, "{name}");
                assert_eq!(after.normals, before.normals, "{name}");
                assert_eq!(after.uvs, before.uvs, "{name}");
                assert_eq!(after.indices, before.indices, "{name}");
            }
        }
    }

    #[test]
    fn a_full_disk_is_an_error() {
        let mut short = [0_u8; 100];
        assert!(write_ply(&mesh(true, true), &mut short.as_mut_slice()).is_err());
        assert!(write_obj(&mesh(true, true), &mut short.as_mut_slice()).is_err());
    }
}
