//! Wavefront MTL: the materials of an OBJ file, mapped to metallic-roughness.
//!
//! | MTL | here |
//! |---|---|
//! | `Kd` | base colour |
//! | `map_Kd` | base-colour texture |
//! | `Ke` | emission |
//! | `Pm`, `Pr` | metallic, roughness (the PBR extension of Exocortex and Blender) |
//! | `Ns` with `Ks` not black | roughness `(2 / (Ns + 2))^(1/4)`: equal highlight width, with the usual `alpha = roughness^2` (Walter et al., 2007) |
//! | `illum` 3, 5 or 8 with `Ks` brighter than `Kd` | a mirror: metallic 1, coloured by `Ks`, roughness 0 without `Ns` |
//!
//! Transparency (`d`, `Tr`, `Tf`), ambient colour and all other maps are ignored. A broken line is a warning with its
//! number; the rest of the file counts.

use std::collections::HashMap;

use super::text::{Lines, keyword, number, shown, words};
use crate::texture::decode_or_warn;
use crate::{Door, LoadError, Material, Model};

/// The most libraries of one OBJ file: each line of a hostile one could name a large library.
pub(super) const MAX_LIBRARIES: usize = 64;

/// Adds one material for each of `names` to the model, from the libraries named by the `mtllib` lines.
///
/// What can't be found is the default material (the empty name without a word, others with a warning).
pub(super) fn load(mtllibs: &[Vec<u8>], names: &[Vec<u8>], model: &mut Model, door: &mut Door) {
    let wanted = names
        .iter()
        .enumerate()
        .map(|(id, name)| (name.as_slice(), id))
        .collect();
    let mut found = Found {
        wanted,
        entries: vec![None; names.len()],
    };
    for line in mtllibs {
        for (name, bytes) in libraries(line, door) {
            found.read(&name, &bytes, door);
        }
    }

    let mut textures = HashMap::new();
    for (name, entry) in names.iter().zip(found.entries) {
        if entry.is_none() && !name.is_empty() && !mtllibs.is_empty() {
            door.warn(format!(
                "{}: material \"{}\" is not defined",
                door.name(),
                shown(name)
            ));
        }
        let entry = entry.unwrap_or_default();
        let mut material = entry.material(shown(name).into_owned());
        if let Some(map) = entry.map {
            material.base_color_texture = *textures
                .entry(map)
                .or_insert_with_key(|map| texture(map, model, door));
        }
        model.materials.push(material);
    }
}

/// The files that one `mtllib` line names: usually one, whose name may hold blanks, else several.
fn libraries(line: &[u8], door: &mut Door) -> Vec<(String, Vec<u8>)> {
    let open = |name: &[u8], door: &mut Door| {
        let name = String::from_utf8_lossy(name).into_owned();
        door.beside_named(&name).map(|bytes| (name, bytes))
    };
    let whole: Result<_, LoadError> = open(line, door);
    let error = match whole {
        Ok(library) => return vec![library],
        Err(error) => error,
    };
    let several: Vec<_> = words(line)
        .take(MAX_LIBRARIES)
        .filter_map(|name| {
            if name == line {
                None
            } else {
                open(name, door).ok()
            }
        })
        .collect();
    if several.is_empty() {
        door.warn(format!("{error}; shown without its materials"));
    }
    several
}

/// Reads a texture once; its number, or `None` if it can't be had.
fn texture(map: &[u8], model: &mut Model, door: &mut Door) -> Option<u32> {
    let name = String::from_utf8_lossy(map).into_owned();
    let bytes = door.beside_named(&name);
    let texture = decode_or_warn(&name, bytes, door)?;
    let id = u32::try_from(model.textures.len()).ok()?;
    model.textures.push(texture);
    Some(id)
}

/// What the libraries say about the materials that are used.
struct Found<'a> {
    wanted: HashMap<&'a [u8], usize>,
    entries: Vec<Option<Entry>>,
}

impl Found<'_> {
    fn read(&mut self, file: &str, bytes: &[u8], door: &mut Door) {
        let mut current = None;
        for line in Lines::new(bytes) {
            let (word, rest) = keyword(line.bytes);
            if word == b"newmtl" {
                // The first definition of a name holds, as in other readers.
                current = self
                    .wanted
                    .get(rest)
                    .copied()
                    .filter(|&id| self.entries[id].is_none());
                if let Some(id) = current {
                    self.entries[id] = Some(Entry::default());
                }
                continue;
            }
            let Some(entry) = current.and_then(|id| self.entries[id].as_mut()) else {
                continue;
            };
            if let Err(cause) = entry.statement(word, rest) {
                door.warn(format!("{file}:{}: {cause}", line.number));
            }
        }
    }
}

/// One `newmtl` as written.
#[derive(Clone, Debug, Default)]
struct Entry {
    kd: Option<[f32; 3]>,
    ks: [f32; 3],
    ke: [f32; 3],
    ns: Option<f32>,
    pm: Option<f32>,
    pr: Option<f32>,
    illum: f32,
    map: Option<Vec<u8>>,
}

impl Entry {
    fn statement(&mut self, word: &[u8], rest: &[u8]) -> Result<(), String> {
        match word {
            b"Kd" => self.kd = Some(color(rest)?.map(|c| c.clamp(0.0, 1.0))),
            b"Ks" => self.ks = color(rest)?.map(|c| c.clamp(0.0, 1.0)),
            b"Ke" => self.ke = color(rest)?.map(|c| c.max(0.0)),
            b"Ns" => self.ns = Some(first_number(rest)?.max(0.0)),
            b"Pm" => self.pm = Some(first_number(rest)?.clamp(0.0, 1.0)),
            b"Pr" => self.pr = Some(first_number(rest)?.clamp(0.0, 1.0)),
            b"illum" => self.illum = first_number(rest)?,
            b"map_Kd" => self.map = map_name(rest).map(<[u8]>::to_vec),
            _ => {}
        }
        Ok(())
    }

    fn material(&self, name: String) -> Material {
        let default = Material::default();
        let brightest = |color: [f32; 3]| color.into_iter().fold(0.0, f32::max);
        let kd = self.kd.unwrap_or(default.base_color);
        let is_mirror = matches!(self.illum, 3.0 | 5.0 | 8.0)
            && brightest(self.ks) > brightest(self.kd.unwrap_or_default());
        let roughness = match (self.pr, self.ns) {
            (Some(pr), _) => pr,
            (None, Some(ns)) if brightest(self.ks) > 0.0 => (2.0 / (ns + 2.0)).sqrt().sqrt(),
            _ if is_mirror => 0.0,
            _ => default.roughness,
        };
        Material {
            name,
            base_color: if is_mirror { self.ks } else { kd },
            base_color_texture: None,
            emission: self.ke,
            metallic: self.pm.unwrap_or(if is_mirror { 1.0 } else { 0.0 }),
            roughness,
        }
    }
}

/// Three numbers, or one for all three channels. `spectral` and `xyz` colours are not read.
fn color(rest: &[u8]) -> Result<[f32; 3], String> {
    let values = words(rest)
        .take(3)
        .map(number)
        .collect::<Result<Vec<_>, _>>()?;
    match values[..] {
        [r, g, b] => Ok([r, g, b]),
        [grey] => Ok([grey; 3]),
        _ => Err(format!(
            "a colour needs one number or three, not {}",
            values.len()
        )),
    }
}

fn first_number(rest: &[u8]) -> Result<f32, String> {
    number(words(rest).next().unwrap_or_default())
}

/// The file name behind the options of a `map_` line: `-s 2 2 1 -clamp on red brick.png`.
fn map_name(mut rest: &[u8]) -> Option<&[u8]> {
    while rest.starts_with(b"-") {
        let (option, mut tail) = keyword(rest);
        // Numbers follow: up to three for -o -s -t, exactly as many as there are for the others. A word follows -clamp etc.
        let values = match option {
            b"-o" | b"-s" | b"-t" => 3,
            b"-mm" => 2,
            b"-blendu" | b"-blendv" | b"-cc" | b"-clamp" | b"-imfchan" | b"-type" | b"-texres"
            | b"-bm" | b"-boost" => 1,
            // A file name may begin with a dash.
            _ => break,
        };
        for _ in 0..values {
            let (word, after) = keyword(tail);
            if values > 1 && number(word).is_err() {
                break;
            }
            tail = after;
        }
        rest = tail;
    }
    (!rest.is_empty()).then_some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;
    use crate::mutate::{Random, mutate};

    /// The material `m` of a library, and the warnings on the way.
    fn read(text: &[u8]) -> (Entry, Vec<String>) {
        let mut door = Door::without_files("a.obj", Limits::default());
        let mut found = Found {
            wanted: HashMap::from([(&b"m"[..], 0)]),
            entries: vec![None],
        };
        found.read("a.mtl", text, &mut door);
        (
            found.entries.remove(0).unwrap_or_default(),
            door.into_warnings(),
        )
    }

    fn material(text: &str) -> Material {
        let (entry, warnings) = read(text.as_bytes());
        assert!(warnings.is_empty(), "{warnings:?}");
        entry.material("m".to_owned())
    }

    #[test]
    fn colours_and_numbers_are_mapped() {
        let m = material("newmtl m\nKd 0.1 0.2 1.5\nKe 4 3 2\nPm 0.5\nPr 0.25\nKa 1 1 1\nd 0.5\n");
        assert_eq!(
            (m.base_color, m.emission, m.metallic, m.roughness),
            ([0.1, 0.2, 1.0], [4.0, 3.0, 2.0], 0.5, 0.25)
        );
        assert_eq!(material("newmtl m\r\n\tKd 0.5\r\n").base_color, [0.5; 3]);
        assert_eq!(
            material("newmtl m").base_color,
            Material::default().base_color
        );
    }

    #[test]
    fn a_highlight_becomes_roughness_and_a_mirror_metal() {
        assert_eq!(material("newmtl m\nNs 30\nKs 0 0 0").roughness, 1.0);
        assert_eq!(material("newmtl m\nNs 30\nKs 1 1 1").roughness, 0.5);
        let mirror = material("newmtl m\nKd 0 0 0\nKs 0.9 0.8 0.7\nillum 3");
        assert_eq!(
            (mirror.metallic, mirror.roughness, mirror.base_color),
            (1.0, 0.0, [0.9, 0.8, 0.7])
        );
        assert_eq!(
            material("newmtl m\nKd 1 1 1\nKs 0.9 0.8 0.7\nillum 3").metallic,
            0.0
        );
    }

    #[test]
    fn a_broken_line_is_a_warning_with_its_number_and_the_rest_counts() {
        let (entry, warnings) = read(b"newmtl m\nKd 1 2\nKe nan 0 0\nNs\nPr 0.5\n");
        assert_eq!((entry.kd, entry.pr), (None, Some(0.5)));
        let starts: Vec<_> = warnings.iter().map(|w| &w[..8]).collect();
        assert_eq!(starts, ["a.mtl:2:", "a.mtl:3:", "a.mtl:4:"]);
    }

    #[test]
    fn the_first_definition_holds_and_others_are_not_touched() {
        let (entry, _) =
            read(b"Kd 1 0 0\nnewmtl x\nKd 1 1 0\nnewmtl m\nPr 0.5\nnewmtl m\nPr 1\nKd 0 0 1\n");
        assert_eq!((entry.kd, entry.pr), (None, Some(0.5)));
    }

    #[test]
    fn options_of_a_map_are_stepped_over() {
        for (line, name) in [
            ("map_Kd red brick.png", "red brick.png"),
            ("map_Kd -s 2 2 1 -clamp on a.png", "a.png"),
            ("map_Kd -o 0.5 -t 1 2 a.png", "a.png"),
            ("map_Kd -mm 0 1 -bm 0.3 sub\\a.png", "sub\\a.png"),
            ("map_Kd -a.png", "-a.png"),
        ] {
            assert_eq!(
                map_name(keyword(line.as_bytes()).1),
                Some(name.as_bytes()),
                "{line}"
            );
        }
        assert_eq!(map_name(b"-clamp on"), None);
        assert_eq!(map_name(b""), None);
    }

    #[test]
    fn mutated_libraries_never_panic_and_give_sane_materials() {
        let seed = b"newmtl m\nKd 0.1 0.2 0.3\nKs 1 1 1\nKe 4 3 2\nNs 30\nPm 0.5\nPr 0.25\nillum 3\nmap_Kd -s 1 1 1 a.png\n";
        let mut random = Random(7);
        for _ in 0..20_000 {
            let mut bytes = seed.to_vec();
            mutate(&mut bytes, &mut random);
            let m = read(&bytes).0.material(String::new());
            assert!(
                m.base_color
                    .iter()
                    .chain([&m.metallic, &m.roughness])
                    .all(|x| (0.0..=1.0).contains(x)),
                "{m:?}"
            );
            assert!(
                m.emission.iter().all(|x| (0.0..f32::INFINITY).contains(x)),
                "{m:?}"
            );
        }
    }
}
