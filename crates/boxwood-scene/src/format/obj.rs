//! Wavefront OBJ: one mesh, triangles in file order.
//!
//! Read: `v vt vn f usemtl mtllib o`. Lines, points and curves are not surfaces, all other words are ignored.
//! Specification: Wavefront, "Advanced Visualizer manual", appendix B1 (as kept by Paul Bourke).

mod vertices;

use std::borrow::Cow;
use std::collections::HashMap;

use glam::Mat4;

use self::vertices::{NONE, Split};
use super::polygon::Triangulator;
use super::text::{Line, Lines, any_number, keyword, number, shown, trimmed, words};
use super::{Format, mtl};
use crate::{Door, Instance, LoadError, Mesh, Model, Place};

pub(crate) const FORMAT: Format = Format {
    name: "obj",
    extensions: &["obj"],
    about: "Wavefront OBJ with MTL materials: polygons, normals, texture coordinates",
    sniff,
    load,
};

/// A material takes much more memory than the line that names it.
const MAX_MATERIALS: u32 = 1 << 16;

fn sniff(bytes: &[u8]) -> bool {
    Lines::new(&bytes[..bytes.len().min(1 << 16)])
        .map(|line| keyword(line.bytes).0)
        .find(|word| !word.is_empty() && !word.starts_with(b"#"))
        .is_some_and(|word| {
            matches!(
                word,
                b"v" | b"vt" | b"vn" | b"f" | b"o" | b"g" | b"s" | b"mtllib" | b"usemtl"
            )
        })
}

fn load(bytes: &[u8], door: &mut Door) -> Result<Model, LoadError> {
    let mut reader = Reader::default();
    let mut lines = Lines::new(bytes);
    while let Some(line) = lines.next() {
        let whole = continued(line, &mut lines);
        reader
            .statement(&whole, door.limits().max_triangles)
            .map_err(|cause| door.error(Some(Place::Line(line.number)), cause))?;
    }
    if reader.statements == 0 && !trimmed(bytes).is_empty() {
        return Err(door
            .error(None, "holds no OBJ statement")
            .with_remedy("is it another format?"));
    }
    reader.finish(door)
}

/// The line with those that a backslash at its end joins to it.
fn continued<'a>(first: Line<'a>, lines: &mut Lines<'a>) -> Cow<'a, [u8]> {
    let mut whole = Cow::Borrowed(first.bytes);
    while let Some(start) = trimmed(&whole).strip_suffix(b"\\") {
        let Some(next) = lines.next() else {
            return Cow::Owned(start.to_vec());
        };
        let end = whole.len()
            - whole
                .iter()
                .rev()
                .position(|&byte| byte == b'\\')
                .map_or(0, |i| i + 1);
        let owned = whole.to_mut();
        owned.truncate(end);
        owned.push(b' ');
        owned.extend_from_slice(next.bytes);
    }
    whole
}

/// What has been read so far.
#[derive(Debug, Default)]
struct Reader {
    name: String,
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// Refer to `positions`, or to `split` once that is there.
    indices: Vec<[u32; 3]>,
    split: Option<Split>,

    material_of: Vec<u32>,
    material: u32,
    material_names: Vec<Vec<u8>>,
    material_ids: HashMap<Vec<u8>, u32>,
    libraries: Vec<Vec<u8>>,

    triangulator: Triangulator,
    corners: Vec<[u32; 3]>,
    polygon: Vec<[f32; 3]>,

    statements: u64,
    not_surfaces: u64,
    flat_faces: u64,
    bad_attributes: u64,
}

impl Reader {
    fn statement(&mut self, line: &[u8], max_triangles: u64) -> Result<(), String> {
        let (word, rest) = keyword(line);
        match word {
            b"v" => {
                let position = coordinates(rest, "vertex")?;
                self.positions.push(position);
            }
            b"vt" => {
                let uv = self.attribute(rest, 1);
                self.uvs.push(uv);
            }
            b"vn" => {
                let normal = self.attribute(rest, 3);
                self.normals.push(normal);
            }
            b"f" | b"fo" => self.face(rest, max_triangles)?,
            b"usemtl" => self.use_material(rest)?,
            b"mtllib" if self.libraries.iter().any(|known| known == rest) => {}
            b"mtllib" if self.libraries.len() == mtl::MAX_LIBRARIES => {
                return Err(format!(
                    "more than {} material libraries",
                    mtl::MAX_LIBRARIES
                ));
            }
            b"mtllib" => self.libraries.push(rest.to_vec()),
            b"o" if self.name.is_empty() => self.name = shown(rest).into_owned(),
            b"p" | b"l" | b"curv" | b"surf" => self.not_surfaces += 1,
            b"o" | b"g" | b"s" => {}
            // An unknown word is no sign of an OBJ file.
            _ => return Ok(()),
        }
        self.statements += 1;
        Ok(())
    }

    /// A normal or texture coordinate with at least `least` numbers; zeros, and a warning later, if it is broken.
    fn attribute<const N: usize>(&mut self, rest: &[u8], least: usize) -> [f32; N] {
        let mut values = [0.0; N];
        let mut count = 0;
        for (value, word) in values.iter_mut().zip(words(rest)) {
            match any_number(word) {
                Some(number) if number.is_finite() => *value = number,
                _ => break,
            }
            count += 1;
        }
        if count < least {
            self.bad_attributes += 1;
            return [0.0; N];
        }
        values
    }

    fn face(&mut self, rest: &[u8], max_triangles: u64) -> Result<(), String> {
        self.corners.clear();
        for word in words(rest) {
            if word.starts_with(b"#") {
                break;
            }
            self.corners.push(self.corner(word)?);
        }
        if self.corners.len() < 3 {
            self.flat_faces += 1;
            return Ok(());
        }
        if self.indices.len() as u64 + self.corners.len() as u64 > max_triangles.saturating_add(2) {
            return Err(format!(
                "more than {max_triangles} triangles, which is the limit"
            ));
        }

        self.polygon.clear();
        self.polygon.extend(
            self.corners
                .iter()
                .map(|corner| self.positions[corner[0] as usize]),
        );
        if self.split.is_none()
            && self
                .corners
                .iter()
                .any(|&[_, vt, vn]| vt != NONE || vn != NONE)
        {
            self.split = Some(Split::of(self.positions.len(), &mut self.indices));
        }
        if let Some(split) = &mut self.split {
            for corner in &mut self.corners {
                corner[0] = split.vertex(*corner)?;
            }
        }
        let (corners, indices) = (&self.corners, &mut self.indices);
        self.triangulator.cut(&self.polygon, |triangle| {
            indices.push(triangle.map(|i| corners[i][0]));
        });
        if !self.material_names.is_empty() {
            self.material_of.resize(self.indices.len(), self.material);
        }
        Ok(())
    }

    /// `7`, `7/1`, `7//2` or `7/1/2`, counted from 1, or from the last one back if negative.
    fn corner(&self, word: &[u8]) -> Result<[u32; 3], String> {
        let mut parts = word.split(|&byte| byte == b'/');
        let mut part = |what: &str, count: usize| match parts.next() {
            None | Some(b"") => Ok(NONE),
            Some(digits) => resolve(digits, count).map_err(|shown| {
                format!(
                    "face refers to {what} {shown} of {count}{}",
                    if count == 0 { "" } else { " so far" }
                )
            }),
        };
        let v = part("vertex", self.positions.len())?;
        let vt = part("texture coordinate", self.uvs.len())?;
        let vn = part("normal", self.normals.len())?;
        if v == NONE || parts.next().is_some() {
            return Err(format!("\"{}\" is no corner of a face", shown(word)));
        }
        Ok([v, vt, vn])
    }

    fn use_material(&mut self, name: &[u8]) -> Result<(), String> {
        if self.material_names.is_empty() && !self.indices.is_empty() {
            // What came before any `usemtl` has the default material, which now needs a number too.
            self.material_names.push(Vec::new());
            self.material_ids.insert(Vec::new(), 0);
            self.material_of = vec![0; self.indices.len()];
        }
        self.material = match self.material_ids.get(name) {
            Some(&id) => id,
            None => {
                let id = self.material_names.len() as u32;
                if id == MAX_MATERIALS {
                    return Err(format!("more than {MAX_MATERIALS} materials"));
                }
                self.material_names.push(name.to_vec());
                self.material_ids.insert(name.to_vec(), id);
                id
            }
        };
        Ok(())
    }

    fn finish(self, door: &mut Door) -> Result<Model, LoadError> {
        self.warn(door);
        let mut model = Model::default();
        mtl::load(&self.libraries, &self.material_names, &mut model, door);

        let mut mesh = Mesh {
            name: self.name,
            indices: self.indices,
            ..Mesh::default()
        };
        mesh.material_of = self.material_of;
        match self.split {
            None => mesh.positions = self.positions,
            Some(split) => split.fill(&self.positions, &self.uvs, &self.normals, &mut mesh),
        }
        if !mesh.positions.is_empty() {
            model.meshes.push(mesh);
            model.instances.push(Instance {
                mesh: 0,
                world_from_mesh: Mat4::IDENTITY,
            });
        }
        Ok(model)
    }

    fn warn(&self, door: &mut Door) {
        let name = door.name().to_owned();
        if self.indices.is_empty() && self.not_surfaces > 0 {
            door.warn(format!(
                "{name}: holds {} lines, points or curves, which no ray hits",
                self.not_surfaces
            ));
        }
        if self.flat_faces > 0 {
            door.warn(format!(
                "{name}: left out {} faces with fewer than three corners",
                self.flat_faces
            ));
        }
        if self.bad_attributes > 0 {
            door.warn(format!(
                "{name}: {} normals or texture coordinates are broken, set to zero",
                self.bad_attributes
            ));
        }
        if self.triangulator.gave_up() {
            door.warn(format!(
                "{name}: the concave polygons are too large, some were cut as if they were convex"
            ));
        }
    }
}

/// The first three numbers of a vertex; weight and colour may follow.
fn coordinates(rest: &[u8], what: &str) -> Result<[f32; 3], String> {
    let mut words = words(rest);
    let mut next = || {
        number(
            words
                .next()
                .ok_or_else(|| format!("{what} has fewer than three coordinates"))?,
        )
    };
    Ok([next()?, next()?, next()?])
}

/// An OBJ index as an index into `count` things; the number as written if it is none.
fn resolve(digits: &[u8], count: usize) -> Result<u32, String> {
    let as_written = || shown(digits).into_owned();
    let index: i64 = std::str::from_utf8(digits)
        .ok()
        .and_then(|s| s.parse().ok())
        .ok_or_else(as_written)?;
    let zero_based = if index > 0 {
        index - 1
    } else {
        index.saturating_add(count as i64)
    };
    match u32::try_from(zero_based) {
        Ok(i) if index != 0 && (i as usize) < count && i != NONE => Ok(i),
        _ => Err(as_written()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Limits, load_bytes};

    fn model(text: &[u8]) -> Model {
        load_bytes("a.obj", None, text, Limits::default()).unwrap()
    }

    fn triangles(text: &str) -> Vec<[u32; 3]> {
        model(text.as_bytes()).meshes.remove(0).indices
    }

    #[track_caller]
    fn refused(text: &str, words: &str) {
        let error = load_bytes("a.obj", None, text.as_bytes(), Limits::default())
            .unwrap_err()
            .to_string();
        assert!(error.contains(words), "{error}");
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn all_forms_of_a_corner_are_read() {
        let attributes = "vt 0.25 0.5\nvt 1\nvn 0 0 1\n";
        for (face, has_uvs, has_normals) in [
            ("f 1 2 3 4", false, false),
            ("f 1/1 2/2 3/1 4/2", true, false),
            ("f 1//1 2//1 3//1 4//1", false, true),
            ("f 1/1/1 2/2/1 3/1/1 4/2/1", true, true),
            ("f 1/ 2/ 3// 4/", false, false),
        ] {
            let mesh = model(format!("{SQUARE}{attributes}{face}").as_bytes())
                .meshes
                .remove(0);
            assert_eq!(mesh.indices, [[0, 1, 2], [0, 2, 3]], "{face}");
            assert_eq!(mesh.positions[2], [1.0, 1.0, 0.0]);
            assert_eq!(
                mesh.uvs,
                if has_uvs {
                    vec![[0.25, 0.5], [1.0, 0.0], [0.25, 0.5], [1.0, 0.0]]
                } else {
                    vec![]
                }
            );
            assert_eq!(
                mesh.normals,
                if has_normals {
                    vec![[0.0, 0.0, 1.0]; 4]
                } else {
                    vec![]
                }
            );
        }
    }

    #[test]
    fn negative_indices_count_back_from_the_last_vertex() {
        assert_eq!(
            triangles(&format!("{SQUARE}f -4 -3 -2\nv 5 5 5\nf -1 -2 1")),
            [[0, 1, 2], [4, 3, 0]]
        );
    }

    #[test]
    fn one_position_with_two_normals_becomes_two_vertices_with_the_same_bits() {
        let text =
            format!("{SQUARE}f 1 2 3\nvn 0 0 1\nvn 0 1 0\nf 1//1 3//1 4//1\nf 1//2 2//2 3//1");
        let mesh = model(text.as_bytes()).meshes.remove(0);
        assert_eq!(mesh.indices, [[0, 1, 2], [3, 4, 5], [6, 7, 4]]);
        assert_eq!(
            mesh.positions[6].map(f32::to_bits),
            mesh.positions[0].map(f32::to_bits)
        );
        assert_eq!(
            (mesh.normals[0], mesh.normals[3], mesh.normals[6]),
            ([0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0])
        );
    }

    #[test]
    fn without_normals_the_vertex_list_stays_as_it_is() {
        let mesh = model(format!("v 9 9 9\n{SQUARE}f 2 3 4").as_bytes())
            .meshes
            .remove(0);
        assert_eq!(mesh.positions.len(), 5);
        assert_eq!(mesh.indices, [[1, 2, 3]]);
    }

    #[test]
    fn lines_may_end_with_a_backslash_or_lack_their_end() {
        assert_eq!(
            triangles(&format!("{SQUARE}f 1 \\\r\n 2 \\\n3")),
            [[0, 1, 2]]
        );
        assert_eq!(triangles(&format!("{SQUARE}f 1 2 3 \\")), [[0, 1, 2]]);
        assert_eq!(
            triangles(
                &SQUARE
                    .replace('\n', "\r\n")
                    .replace("v 0 1 0", "\tv\t0 1 0 \nf 1 2 4")
            ),
            [[0, 1, 3]]
        );
        refused(
            "v 1 1 1\nv 1 1\\\n\\\n\nf 1 1 1",
            "a.obj:2: vertex has fewer",
        );
    }

    #[test]
    fn weights_colours_comments_and_unknown_words_do_no_harm() {
        let text = "# c\nv 1 2 3.5 1 # w\nv 0 0 0 0.1 0.2 0.3\nvp 1 2\nshadow_obj x\ng a b\ns off\nv 1 0 0\nf 1 2 3 # 4\n";
        assert_eq!(triangles(text), [[0, 1, 2]]);
    }

    #[test]
    fn bad_indices_and_numbers_are_refused_with_their_line() {
        refused(
            &format!("{SQUARE}f 1 2 9"),
            "a.obj:5: face refers to vertex 9 of 4",
        );
        refused(
            &format!("{SQUARE}f 1 2 -5"),
            "face refers to vertex -5 of 4",
        );
        refused(&format!("{SQUARE}f 0 1 2"), "face refers to vertex 0 of 4");
        refused(
            &format!("{SQUARE}f 1 2 99999999999999999999"),
            "99999999999999999999",
        );
        refused(
            &format!("{SQUARE}f -9223372036854775808 1 2"),
            "-9223372036854775808",
        );
        refused(
            &format!("{SQUARE}f 1//1 2//1 3//1"),
            "face refers to normal 1 of 0",
        );
        refused(
            &format!("{SQUARE}f 1/2 2 3"),
            "face refers to texture coordinate 2 of 0",
        );
        refused(&format!("{SQUARE}f 1////1 2 3"), "no corner");
        refused(&format!("{SQUARE}f / 2 3"), "no corner");
        refused("v 1 2\nf 1 1 1", "a.obj:1: vertex has fewer than three");
        for bad in ["nan", "-inf", "1e39", "one", "1,5"] {
            refused(&format!("v 1 {bad} 2"), bad);
        }
    }

    #[test]
    fn short_faces_lines_and_points_are_noted() {
        let warnings = model(format!("{SQUARE}f 1 2\nl 1 2 3\np 1").as_bytes())
            .warnings
            .join("\n");
        assert!(
            warnings.contains("1 faces with fewer than three corners"),
            "{warnings}"
        );
        assert!(warnings.contains("2 lines, points or curves"), "{warnings}");
        assert!(warnings.contains("shows no triangles"), "{warnings}");
    }

    #[test]
    fn a_broken_normal_becomes_zero_with_a_warning() {
        let model = model(format!("{SQUARE}vn nan 0 1\nvn 0 0 1\nf 1//1 2//2 3//2").as_bytes());
        assert_eq!(
            model.meshes[0].normals,
            [[0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]
        );
        assert!(
            model.warnings[0].contains("1 normals"),
            "{:?}",
            model.warnings
        );
    }

    #[test]
    fn empty_files_are_empty_scenes_and_foreign_files_are_refused() {
        for text in ["", "\n \n", "# nothing\no a\n"] {
            let model = model(text.as_bytes());
            assert_eq!(
                (model.triangle_count(), model.warnings.len()),
                (0, 1),
                "{text:?}"
            );
        }
        refused("<html>\n", "no OBJ statement");
    }

    #[test]
    fn faces_before_the_first_material_have_the_default_one() {
        let text = format!(
            "{SQUARE}f 1 2 3\nusemtl red brick\nf 1 2 3 4\nusemtl \u{e4}\nf 1 2 3\nusemtl red brick\nf 2 3 4"
        );
        let model = model(text.as_bytes());
        assert_eq!(model.meshes[0].material_of, [0, 1, 1, 2, 1]);
        let names: Vec<_> = model
            .materials
            .iter()
            .map(|material| material.name.as_str())
            .collect();
        assert_eq!(names, ["", "red brick", "\u{e4}"]);
    }

    #[test]
    fn more_triangles_than_allowed_are_refused() {
        let limits = Limits {
            max_triangles: 3,
            ..Limits::default()
        };
        let text = |n: usize| format!("{SQUARE}f{}", " 1".repeat(n));
        assert!(load_bytes("a.obj", None, text(5).as_bytes(), limits).is_ok());
        assert!(
            load_bytes("a.obj", None, text(6).as_bytes(), limits)
                .unwrap_err()
                .to_string()
                .contains("limit")
        );
    }
}
