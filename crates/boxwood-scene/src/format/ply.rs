//! Stanford PLY: ascii, little endian and big endian; one mesh, triangles in file order.
//!
//! Read: `x y z`, `nx ny nz` and texture coordinates of the element `vertex`; the list `vertex_indices` (or
//! `vertex_index`) of the elements `face` (polygons) and `tristrips` (strips, -1 begins a new one). All other elements
//! and properties are stepped over, whatever their types and order.
//! Specification: Turk, "The PLY Polygon File Format", 1994.

mod header;
mod mesh;
mod values;

use self::header::{Element, Encoding, Header};
use self::mesh::{Faces, Reader};
use self::values::{Ascii, Binary, Values};
use super::Format;
use super::text::trimmed;
use crate::{Door, LoadError, Model};

pub(crate) const FORMAT: Format = Format {
    name: "ply",
    extensions: &["ply"],
    about: "Stanford PLY, ascii and binary: polygons, strips, normals, texture coordinates",
    sniff: |bytes| bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r"),
    load,
};

fn load(bytes: &[u8], door: &mut Door) -> Result<Model, LoadError> {
    let header = Header::read(bytes).map_err(|(place, cause)| door.error(Some(place), cause))?;
    let body = &bytes[header.length..];
    match header.encoding {
        Encoding::Ascii => read(&header, Ascii::new(body, header.lines), door),
        Encoding::LittleEndian => read(&header, Binary::<false>::new(body, header.length), door),
        Encoding::BigEndian => read(&header, Binary::<true>::new(body, header.length), door),
    }
}

/// Reads the elements in the order of the header.
fn read(header: &Header, mut values: impl Values, door: &mut Door) -> Result<Model, LoadError> {
    let mut reader = Reader::new(door.limits().max_triangles);
    for element in &header.elements {
        let result =
            check_count(element, values.bytes_left(), values.least_row(element)).and_then(|()| {
                match element.name.as_slice() {
                    b"vertex" => reader.vertices(element, &mut values),
                    b"face" => reader.faces(element, &mut values, Faces::Polygons),
                    b"tristrips" => reader.faces(element, &mut values, Faces::Strips),
                    _ => skip(element, &mut values),
                }
            });
        result.map_err(|cause| door.error(Some(values.place()), cause))?;
    }
    if !trimmed(values.rest()).is_empty() {
        door.warn(format!(
            "{}: {} bytes after the last element are ignored",
            door.name(),
            values.rest().len()
        ));
    }
    Ok(reader.finish(door))
}

/// Refuses a count that the bytes can't hold, before anything is done with it.
fn check_count(element: &Element, bytes_left: usize, least_row: usize) -> Result<(), String> {
    let needed = element.count.saturating_mul(least_row as u64);
    // The last line of an ascii file may lack its end.
    if needed > bytes_left as u64 + 1 {
        return Err(format!(
            "the header promises {} rows of \"{}\", which need {needed} bytes or more; {bytes_left} are left",
            element.count,
            element.shown_name()
        ));
    }
    Ok(())
}

fn skip(element: &Element, values: &mut impl Values) -> Result<(), String> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        values.begin_row()?;
        for property in &element.properties {
            values.skip_property(property)?;
        }
        values.end_row()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Limits, load_bytes};

    fn load(bytes: &[u8]) -> Result<Model, LoadError> {
        load_bytes("a.ply", None, bytes, Limits::default())
    }

    #[track_caller]
    fn refused(bytes: &[u8], words: &str) {
        let error = load(bytes).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }

    fn header(format: &str, elements: &str) -> String {
        format!("ply\nformat {format} 1.0\ncomment made by hand\n{elements}end_header\n")
    }

    const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";
    const LIST: &str = "property list uchar int vertex_indices\n";

    /// Four vertices and the elements `more`.
    fn ascii(more: &str, rows: &str) -> Vec<u8> {
        let header = header("ascii", &format!("element vertex 4\n{XYZ}{more}"));
        format!("{header}0 0 0\n1 0 0\n1 1 0\n0 1 0\n{rows}").into_bytes()
    }

    fn indices(bytes: &[u8]) -> Vec<[u32; 3]> {
        load(bytes).unwrap().meshes.remove(0).indices
    }

    #[test]
    fn polygons_of_any_size_are_read_in_order() {
        let bytes = ascii(
            &format!("element face 4\n{LIST}"),
            "4 0 1 2 3\n3 2 1 0 \n\n2 0 1\n0\n",
        );
        assert_eq!(indices(&bytes), [[0, 1, 2], [0, 2, 3], [2, 1, 0]]);
        assert!(load(&bytes).unwrap().warnings[0].contains("2 faces"));
    }

    #[test]
    fn strips_turn_every_second_triangle_and_begin_anew_at_minus_one() {
        let bytes = ascii(
            &format!("element tristrips 1\n{LIST}"),
            "9 0 1 2 3 -1 3 2 1 -1\n",
        );
        assert_eq!(indices(&bytes), [[0, 1, 2], [2, 1, 3], [3, 2, 1]]);
        refused(
            &ascii(&format!("element face 1\n{LIST}"), "3 0 1 -1\n"),
            "vertex -1 of 4",
        );
    }

    /// Odd types, other elements before, between and behind, lists everywhere; in each coding.
    #[test]
    fn what_is_unknown_is_stepped_over_in_every_coding() {
        let elements = "element camera 1\nproperty list int double pose\nproperty uchar id\nelement empty 4000000000\n\
            element vertex 3\nproperty uchar red\nproperty double z\nproperty list uchar short extra\nproperty short y\n\
            property float x\nproperty double nx\nproperty double ny\nproperty double nz\nproperty float t\nproperty float s\n\
            element face 1\nproperty list uchar float texcoord\nproperty list ushort uint vertex_index\nproperty int flag\n\
            element edge 2\nproperty int a\n";
        // Each number with its size; negative sizes are floats.
        let numbers: Vec<(f64, i32)> = [
            vec![(2.0, 4), (0.5, -8), (0.25, -8), (7.0, 1)],
            (0..3)
                .flat_map(|i| {
                    let i = f64::from(i);
                    vec![
                        (200.0, 1),
                        (i + 0.5, -8),
                        (1.0, 1),
                        (-5.0, 2),
                        (-300.0 * i, 2),
                        (i, -4),
                        (0.0, -8),
                        (0.0, -8),
                        (1.0, -8),
                        (0.25, -4),
                        (0.75, -4),
                    ]
                })
                .collect(),
            vec![
                (1.0, 1),
                (0.5, -4),
                (3.0, 2),
                (2.0, 4),
                (1.0, 4),
                (0.0, 4),
                (-9.0, 4),
                (1.0, 4),
                (2.0, 4),
            ],
        ]
        .concat();
        let breaks = [4, 15, 26, 37, 44, 45];
        let mut text = header("ascii", elements);
        let mut little = header("binary_little_endian", elements).into_bytes();
        let mut big = header("binary_big_endian", elements).into_bytes();
        for (i, &(number, size)) in numbers.iter().enumerate() {
            let blank = if breaks.contains(&(i + 1)) {
                "\r\n"
            } else {
                " "
            };
            text += &format!("{number}{blank}");
            let bytes = match size {
                1 => vec![number as u8],
                2 => (number as i16).to_le_bytes().to_vec(),
                4 => (number as i32).to_le_bytes().to_vec(),
                -4 => (number as f32).to_le_bytes().to_vec(),
                _ => number.to_le_bytes().to_vec(),
            };
            little.extend(&bytes);
            big.extend(bytes.iter().rev());
        }
        for bytes in [text.into_bytes(), little, big] {
            let mut model = load(&bytes).unwrap();
            assert!(model.warnings.is_empty(), "{:?}", model.warnings);
            let mesh = model.meshes.remove(0);
            assert_eq!(
                mesh.positions,
                [[0.0, 0.0, 0.5], [1.0, -300.0, 1.5], [2.0, -600.0, 2.5]]
            );
            assert_eq!(mesh.indices, [[2, 1, 0]]);
            assert_eq!(
                (mesh.normals[2], mesh.uvs[1]),
                ([0.0, 0.0, 1.0], [0.75, 0.25])
            );
        }
    }

    #[test]
    fn lying_headers_are_refused_at_once() {
        let face = |count: u64| ascii(&format!("element face {count}\n{LIST}"), "3 0 1 2\n");
        assert_eq!(indices(&face(1)).len(), 1);
        refused(&face(2), "the file ends before");
        for count in [4_294_967_295, u64::MAX] {
            refused(&face(count), &count.to_string());
        }
        let binary = header(
            "binary_little_endian",
            &format!("element vertex 3000000000\n{XYZ}"),
        );
        refused(
            binary.as_bytes(),
            "3000000000 rows of \"vertex\", which need 36000000000 bytes or more; 0 are left",
        );
        let list = header(
            "binary_little_endian",
            "element x 1\nproperty list uint double x\n",
        ) + "\u{7f}\u{7f}\u{7f}\u{7f}";
        refused(list.as_bytes(), "ends within the data");
    }

    #[test]
    fn broken_rows_are_refused_with_their_line() {
        let face = format!("element face 1\n{LIST}");
        refused(
            &ascii(&face, "3 0 1 4\n"),
            "a.ply:15: face refers to vertex 4 of 4",
        );
        refused(&ascii(&face, "3 0 1 1.5\n"), "vertex 1.5 of 4");
        refused(&ascii(&face, "3 0 1 nan\n"), "vertex NaN of 4");
        refused(
            &ascii(&face, "3 0 1\n"),
            "a.ply:15: the row has fewer numbers",
        );
        refused(&ascii(&face, "3 0 1 2 3\n"), "the row has more numbers");
        refused(&ascii(&face, "-1 0 1 2\n"), "the length -1");
        refused(&ascii(&face, "3 0 one 2\n"), "\"one\" is not a number");
        for bad in ["nan", "inf", "1e39"] {
            let text =
                header("ascii", &format!("element vertex 1\n{XYZ}")) + &format!("0 {bad} 0\n");
            refused(
                text.as_bytes(),
                "a.ply:9: vertex 0 has a coordinate that is not finite",
            );
        }
    }

    #[test]
    fn broken_headers_are_refused_with_their_line() {
        refused(b"", "a.ply:1");
        refused(b"plyx\n", "begins with");
        refused(b"ply\nformat ascii 1.0\n", "a.ply:2: the header has no");
        refused(b"ply\nend_header\n", "no line \"format\"");
        refused(b"ply\nformat utf8 1.0\n", "unknown format \"utf8\"");
        refused(b"ply\nproperty float x\n", "before the first element");
        refused(b"ply\nelement vertex -1\n", "no count but \"-1\"");
        refused(
            b"ply\nelement vertex 1\nproperty quad x\n",
            "a.ply:3: \"quad\" is no type",
        );
        refused(b"ply\nelement vertex 1\nproperty float\n", "no name");
        refused(b"ply\nhello\n", "\"hello\"");
        refused(
            header("ascii", "element vertex 0\nproperty float x\n").as_bytes(),
            "lacks x, y or z",
        );
        refused(
            header("ascii", "element vertex 0\nproperty list uchar float x\n").as_bytes(),
            "lacks x, y or z",
        );
        refused(
            header("ascii", "element face 0\nproperty int x\n").as_bytes(),
            "no list \"vertex_indices\"",
        );
        let early = header(
            "ascii",
            &format!("element face 1\n{LIST}element vertex 1\n{XYZ}"),
        ) + "3 0 0 0\n0 0 0\n";
        refused(early.as_bytes(), "stands before \"vertex\"");
    }

    #[test]
    fn bytes_behind_the_data_are_noted() {
        let model = load(&ascii("", "0 0 0\n")).unwrap();
        assert!(
            model.warnings[0].contains("6 bytes after"),
            "{:?}",
            model.warnings
        );
    }
}
