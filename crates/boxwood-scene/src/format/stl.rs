//! STL, binary and ascii: a soup of triangles, welded into a mesh.
//!
//! A file is binary if its length fits the count that its header gives; whether it begins with `solid` says nothing,
//! since many binary files do. Facet normals and attribute bytes are ignored: the corners say the same.
//! Specification: 3D Systems, "StereoLithography Interface Specification", 1989.

use std::collections::HashMap;

use glam::Mat4;

use super::Format;
use super::text::{Lines, keyword, number, shown, trimmed, words};
use crate::{Door, Instance, LoadError, Mesh, Model, Place};

pub(crate) const FORMAT: Format = Format {
    name: "stl",
    extensions: &["stl"],
    about: "STL, ascii and binary: triangles alone, equal corners welded",
    sniff,
    load,
};

const HEADER: usize = 84;
const RECORD: usize = 50;

fn sniff(bytes: &[u8]) -> bool {
    is_binary(bytes) || begins_with_solid(bytes)
}

fn load(bytes: &[u8], door: &mut Door) -> Result<Model, LoadError> {
    let mut weld = Weld::default();
    if is_binary(bytes) {
        read_binary(bytes, &mut weld, door)?;
    } else if begins_with_solid(bytes) && !bytes.contains(&0) {
        read_ascii(bytes, &mut weld, door)?;
    } else {
        return Err(refused(bytes, door));
    }

    let mut model = Model::default();
    if !weld.mesh.indices.is_empty() {
        model.meshes.push(weld.mesh);
        model.instances.push(Instance {
            mesh: 0,
            world_from_mesh: Mat4::IDENTITY,
        });
    }
    Ok(model)
}

/// The number of triangles that the header of a binary file gives.
fn count(bytes: &[u8]) -> Option<u32> {
    bytes
        .get(80..HEADER)?
        .first_chunk()
        .map(|four| u32::from_le_bytes(*four))
}

fn is_binary(bytes: &[u8]) -> bool {
    count(bytes)
        .is_some_and(|count| bytes.len() as u64 == HEADER as u64 + RECORD as u64 * u64::from(count))
}

fn begins_with_solid(bytes: &[u8]) -> bool {
    trimmed(&bytes[..bytes.len().min(256)])
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

fn refused(bytes: &[u8], door: &Door) -> LoadError {
    match count(bytes) {
        Some(count) => door
            .error(
                Some(Place::Byte(80)),
                format!(
                    "the header promises {count} triangles, which need {} bytes; the file has {}",
                    HEADER as u64 + RECORD as u64 * u64::from(count),
                    bytes.len()
                ),
            )
            .with_remedy("the file is cut off, or no STL file"),
        None => door.error(
            None,
            format!("{} bytes are too few for an STL file", bytes.len()),
        ),
    }
}

fn read_binary(bytes: &[u8], weld: &mut Weld, door: &Door) -> Result<(), LoadError> {
    let (records, _) = bytes[HEADER..].as_chunks::<RECORD>();
    weld.mesh.indices.reserve_exact(records.len());
    for (i, record) in records.iter().enumerate() {
        // Twelve bytes of normal, three corners, two bytes of attributes.
        let (floats, _) = record[12..48].as_chunks::<4>();
        let value = |k: usize| f32::from_le_bytes(floats[k]);
        let corners = [0, 3, 6].map(|k| [value(k), value(k + 1), value(k + 2)]);
        if !corners.as_flattened().iter().all(|x| x.is_finite()) {
            let place = Place::Byte((HEADER + i * RECORD) as u64);
            return Err(door.error(
                Some(place),
                format!("triangle {i} has a coordinate that is not finite"),
            ));
        }
        weld.triangle(corners);
    }
    Ok(())
}

fn read_ascii(bytes: &[u8], weld: &mut Weld, door: &mut Door) -> Result<(), LoadError> {
    let mut facet: Vec<[f32; 3]> = Vec::new();
    let mut is_open = false;
    let mut last = 0;
    for line in Lines::new(bytes) {
        let (word, rest) = keyword(line.bytes);
        let at = |cause: String| door.error(Some(Place::Line(line.number)), cause);
        last = line.number;
        match word.to_ascii_lowercase().as_slice() {
            b"vertex" if facet.len() < 3 => facet.push(vertex(rest).map_err(at)?),
            b"vertex" => return Err(at("a facet has more than three corners".to_owned())),
            b"endfacet" => {
                let &[a, b, c] = facet.as_slice() else {
                    return Err(at(format!(
                        "a facet has {} corners instead of three",
                        facet.len()
                    )));
                };
                weld.triangle([a, b, c]);
                facet.clear();
            }
            b"solid" => {
                if weld.mesh.name.is_empty() {
                    weld.mesh.name = shown(rest).into_owned();
                }
                is_open = true;
            }
            b"endsolid" | b"end" => is_open = false,
            b"facet" | b"outer" | b"endloop" | b"" => {}
            word => return Err(at(format!("\"{}\" is no word of STL", shown(word)))),
        }
    }
    if !facet.is_empty() {
        let cause = "the file ends within a facet";
        return Err(door
            .error(Some(Place::Line(last)), cause)
            .with_remedy("the file is cut off"));
    }
    if is_open {
        door.warn(format!(
            "{}: ends without `endsolid`; it may be cut off",
            door.name()
        ));
    }
    Ok(())
}

fn vertex(rest: &[u8]) -> Result<[f32; 3], String> {
    let mut words = words(rest);
    let mut next = || {
        number(
            words
                .next()
                .ok_or("a vertex has fewer than three coordinates")?,
        )
    };
    Ok([next()?, next()?, next()?])
}

/// Gives equal corners one vertex, in the order of their first use. `-0` equals `0`, whichever came first stays.
#[derive(Default)]
struct Weld {
    mesh: Mesh,
    vertex_at: HashMap<[u32; 3], u32>,
}

impl Weld {
    fn triangle(&mut self, corners: [[f32; 3]; 3]) {
        let triangle = corners.map(|corner| self.vertex(corner));
        self.mesh.indices.push(triangle);
    }

    fn vertex(&mut self, corner: [f32; 3]) -> u32 {
        // Adding zero turns -0 into 0 and changes nothing else.
        let key = corner.map(|x| (x + 0.0).to_bits());
        *self.vertex_at.entry(key).or_insert_with(|| {
            self.mesh.positions.push(corner);
            // Three vertices a triangle and fifty bytes a triangle: a file of 70 GB would be needed to wrap.
            (self.mesh.positions.len() - 1) as u32
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Limits, load_bytes};

    fn binary(header: &[u8], triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            bytes.extend([0; 12]);
            bytes.extend(triangle.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
            bytes.extend([7, 7]);
        }
        bytes
    }

    fn load(bytes: &[u8]) -> Result<Model, LoadError> {
        load_bytes("a.stl", None, bytes, Limits::default())
    }

    #[track_caller]
    fn refused(bytes: &[u8], words: &str) {
        let error = load(bytes).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }

    const TWO: [[[f32; 3]; 3]; 2] = [
        [[0.0, 0.0, 1.5], [1.0, 0.0, 1.5], [0.0, 2.0, 1.5]],
        [[1.0, -0.0, 1.5], [1.0, 2.0, 1.5], [0.0, 2.0, 1.5]],
    ];

    #[test]
    fn equal_corners_are_welded_and_triangles_keep_their_order() {
        let mesh = load(&binary(b"", &TWO)).unwrap().meshes.remove(0);
        assert_eq!(mesh.indices, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(mesh.positions.len(), 4);
        assert!(mesh.normals.is_empty());
    }

    #[test]
    fn a_binary_file_may_begin_with_solid() {
        assert_eq!(
            load(&binary(b"solid ascii?", &TWO))
                .unwrap()
                .triangle_count(),
            2
        );
        assert_eq!(load(&binary(b"solid", &[])).unwrap().warnings.len(), 1);
    }

    #[test]
    fn a_count_that_does_not_fit_is_refused() {
        let whole = binary(b"solid", &TWO);
        refused(
            &whole[..whole.len() - 1],
            "promises 2 triangles, which need 184 bytes; the file has 183",
        );
        refused(&[&whole[..], b"!"].concat(), "the file has 185");
        refused(b"", "too few");
        refused(&whole[..83], "too few");
    }

    #[test]
    fn coordinates_that_are_not_finite_are_refused_with_their_place() {
        let mut bad = TWO;
        bad[1][2][0] = f32::NAN;
        refused(&binary(b"", &bad), "byte 134: triangle 1");
        refused(b"solid\nfacet\nvertex 0 0 inf", "a.stl:3: \"inf\"");
    }

    #[test]
    fn ascii_in_any_case_and_with_several_solids() {
        let text = b"solid a b\r\n FACET normal 0 0 1\nOuter Loop\nvertex 0 0 0\nvertex 1 0 0\nVERTEX 0 1.5 0\nendloop\n\
                     endfacet\nendsolid a b\nsolid c\nfacet normal 0 0 0\nouter loop\nvertex 0 1.5 0\nvertex 1 0 0\n\
                     vertex 3 3 3\nendloop\nendfacet\nendsolid";
        let model = load(text).unwrap();
        assert_eq!(
            (&model.meshes[0].name[..], &model.meshes[0].indices[..]),
            ("a b", &[[0, 1, 2], [2, 1, 3]][..])
        );
        assert!(model.warnings.is_empty());
    }

    #[test]
    fn broken_ascii_is_refused_and_a_missing_end_is_noted() {
        let facet =
            "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
        assert_eq!(
            load(format!("solid\n{facet}").as_bytes())
                .unwrap()
                .warnings
                .len(),
            1
        );
        refused(
            format!("solid\n{facet}facet\nvertex 0 0 0").as_bytes(),
            "a.stl:10: the file ends within a facet",
        );
        refused(b"solid\nvertex 0 0", "a.stl:2: a vertex has fewer");
        refused(b"solid\nvertex 0 0 0\nendfacet", "1 corners");
        refused(
            b"solid\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0",
            "more than three",
        );
        refused(b"solid\nhello", "\"hello\"");
    }
}
