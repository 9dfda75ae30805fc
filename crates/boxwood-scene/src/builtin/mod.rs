//! Built-in scenes: made by a few lines of arithmetic, the same bits on every machine.
//!
//! Wherever a file is taken, `builtin:NAME` or `builtin:NAME?n=100000&seed=3` works too. Sines and cosines come from
//! the `libm` crate, because those of the standard library differ between platforms in their last bits; all else is
//! `+ - * /` and square roots in f64, which IEEE 754 fixes.

mod bush;
mod cornell;
mod hairball;
mod instanced_grove;
mod random;
mod shape;
mod soup;
mod sphere;
mod stadium;
mod teapot;
mod terrain;

use crate::{Camera, Instance, LoadError, Material, Mesh, Model};

/// One built-in scene. A new one is a file in `builtin/` and a line in [`BUILTINS`].
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// As in `builtin:NAME`.
    pub name: &'static str,
    /// One line for `boxwood list`.
    pub about: &'static str,
    /// How many triangles it has and whether `n` may say so.
    pub size: Size,
    /// Whether `seed` changes anything.
    pub seeded: bool,
    /// Makes the scene. Linear in `n`; never fails for an `n` that [`Builtin::size`] allows.
    pub build: fn(&Params) -> Model,
}

/// How many triangles a built-in scene has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Always the same; `n` is refused.
    Fixed,
    /// Exactly `n`.
    Exact {
        /// `n` where none is given.
        default: u64,
        /// Smallest `n`.
        least: u64,
    },
    /// The largest count not above `n` that the construction allows.
    AtMost {
        /// `n` where none is given.
        default: u64,
        /// Smallest `n`.
        least: u64,
    },
}

/// What a spec may say about a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Params {
    /// Triangles, as [`Size`] says.
    pub n: u64,
    /// Another seed, another scene of the same kind.
    pub seed: u64,
}

/// Every built-in scene.
pub const BUILTINS: &[Builtin] = &[
    bush::BUILTIN,
    cornell::BUILTIN,
    stadium::BUILTIN,
    terrain::BUILTIN,
    hairball::BUILTIN,
    soup::BUILTIN,
    sphere::BUILTIN,
    instanced_grove::BUILTIN,
];

/// Largest `n`: some gigabytes of memory.
pub const MAX_TRIANGLES: u64 = 50_000_000;

/// Makes the scene that `spec` names: what follows `builtin:`, as in `soup?n=100000&seed=3`.
///
/// Unknown names and parameters are refused with the known ones; so is an `n` out of range.
pub fn builtin(spec: &str) -> Result<Model, LoadError> {
    let refused = |cause: String| LoadError::new(format!("builtin:{spec}"), cause);
    let (name, query) = spec.split_once('?').unwrap_or((spec, ""));
    let Some(builtin) = BUILTINS.iter().find(|builtin| builtin.name == name) else {
        let names: Vec<_> = BUILTINS.iter().map(|builtin| builtin.name).collect();
        return Err(refused(format!("there is no built-in scene \"{name}\""))
            .with_remedy(suggest(name, &names)));
    };
    let params = builtin
        .params(query)
        .map_err(|(cause, remedy)| refused(cause).with_remedy(remedy))?;
    let mut model = (builtin.build)(&params);
    let count = model.unique_triangle_count();
    if builtin.size != Size::Fixed && count != params.n {
        model.warnings.push(format!(
            "builtin:{name} has {count} triangles, the nearest below {}",
            params.n
        ));
    }
    Ok(model)
}

impl Builtin {
    /// `n` where the user gives none; `None` for a scene of fixed size.
    pub fn default_n(&self) -> Option<u64> {
        match self.size {
            Size::Fixed => None,
            Size::Exact { default, .. } | Size::AtMost { default, .. } => Some(default),
        }
    }

    /// Reads `n=1000&seed=3`. The error is cause and remedy.
    fn params(&self, query: &str) -> Result<Params, (String, String)> {
        let mut params = Params {
            n: self.default_n().unwrap_or(0),
            seed: 0,
        };
        for part in query.split('&').filter(|part| !part.is_empty()) {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let known = self.parameters();
            if !known.contains(&key) {
                let remedy = match known[..] {
                    [] => format!("{} has no parameters", self.name),
                    _ => suggest(key, &known),
                };
                return Err((format!("unknown parameter \"{key}\""), remedy));
            }
            if query
                .split('&')
                .filter(|part| part.split('=').next() == Some(key))
                .count()
                > 1
            {
                return Err((
                    format!("{key} is given more than once"),
                    "leave out all but one".to_owned(),
                ));
            }
            let value = number(value).ok_or_else(|| {
                (
                    format!("{key} is \"{value}\""),
                    format!("a whole number, as in {key}=100000"),
                )
            })?;
            match key {
                "n" => params.n = value,
                _ => params.seed = value,
            }
        }
        self.check_n(params)
    }

    fn parameters(&self) -> Vec<&'static str> {
        let n = (self.size != Size::Fixed).then_some("n");
        n.into_iter().chain(self.seeded.then_some("seed")).collect()
    }

    fn check_n(&self, params: Params) -> Result<Params, (String, String)> {
        match self.size {
            Size::Exact { least, .. } | Size::AtMost { least, .. }
                if !(least..=MAX_TRIANGLES).contains(&params.n) =>
            {
                Err((
                    format!("n is {}", params.n),
                    format!(
                        "{} can have {least} to {MAX_TRIANGLES} triangles",
                        self.name
                    ),
                ))
            }
            _ => Ok(params),
        }
    }
}

/// Decimal digits, with `_` between them as in Rust.
fn number(text: &str) -> Option<u64> {
    text.replace('_', "").parse().ok()
}

/// `did you mean bush? known: bush, cornell, ...`
fn suggest(wrong: &str, known: &[&str]) -> String {
    let list = format!("known: {}", known.join(", "));
    let closest = known
        .iter()
        .map(|name| (strsim::jaro_winkler(wrong, name), name))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match closest {
        Some((likeness, name)) if likeness > 0.7 => format!("did you mean {name}? {list}"),
        _ => list,
    }
}

/// A model that shows each mesh once, where it was made.
fn assemble(meshes: Vec<Mesh>, materials: Vec<Material>, camera: Camera) -> Model {
    let instances = (0..meshes.len() as u32)
        .map(|mesh| Instance {
            mesh,
            world_from_mesh: glam::Mat4::IDENTITY,
        })
        .collect();
    Model {
        meshes,
        instances,
        materials,
        cameras: vec![camera],
        ..Model::default()
    }
}

/// A matte material.
fn matte(name: &str, base_color: [f32; 3]) -> Material {
    Material {
        name: name.to_owned(),
        base_color,
        ..Material::default()
    }
}

#[cfg(test)]
mod tests {
    use super::builtin as build;
    use super::*;

    /// FNV-1a over all that a picture can depend on.
    fn hash(model: &Model) -> u64 {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut eat = |word: u32| {
            for byte in word.to_le_bytes() {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        };
        for mesh in &model.meshes {
            mesh.positions
                .iter()
                .flatten()
                .for_each(|x| eat(x.to_bits()));
            mesh.normals.iter().flatten().for_each(|x| eat(x.to_bits()));
            mesh.indices.iter().flatten().for_each(|&i| eat(i));
            mesh.material_of.iter().for_each(|&m| eat(m));
        }
        for instance in &model.instances {
            let matrix = instance.world_from_mesh;
            if matrix != glam::Mat4::IDENTITY {
                eat(instance.mesh);
                for x in matrix.to_cols_array() {
                    eat(x.to_bits());
                }
            }
        }
        for camera in &model.cameras {
            [camera.eye, camera.target]
                .iter()
                .flatten()
                .for_each(|x| eat(x.to_bits()));
        }
        hash
    }

    fn refusal(spec: &str) -> String {
        build(spec).expect_err(spec).to_string()
    }

    #[test]
    fn every_scene_has_the_count_it_promises() {
        for builtin in BUILTINS {
            for n in [None, Some(40_001), Some(100_000)] {
                let (Some(n), false) = (n.or(builtin.default_n()), builtin.size == Size::Fixed)
                else {
                    continue;
                };
                let model = build(&format!("{}?n={n}", builtin.name)).unwrap();
                let count = model.triangle_count();
                match builtin.size {
                    Size::Exact { .. } => assert_eq!(count, n, "{}", builtin.name),
                    _ => assert!(
                        count <= n && count > n - n / 20,
                        "{}: {count} of {n}",
                        builtin.name
                    ),
                }
                assert_eq!(model.warnings.is_empty(), count == n, "{}", builtin.name);
            }
        }
    }

    #[test]
    fn the_smallest_scenes_hold_their_promises_too() {
        for builtin in BUILTINS {
            if let Size::Exact { least, .. } | Size::AtMost { least, .. } = builtin.size {
                let model = build(&format!("{}?n={least}", builtin.name)).unwrap();
                assert_eq!(model.triangle_count(), least, "{}", builtin.name);
                assert!(
                    refusal(&format!("{}?n={}", builtin.name, least - 1))
                        .contains(" to 50000000 triangles")
                );
            }
        }
    }

    #[test]
    fn the_bush_has_the_forty_thousand_triangles_of_the_lecture() {
        assert_eq!(build("bush").unwrap().triangle_count(), 40_000);
    }

    #[test]
    fn every_scene_is_sound_and_has_a_camera_outside_of_nothing() {
        for builtin in BUILTINS {
            let model = build(builtin.name).unwrap();
            let flat = model.flatten().unwrap();
            assert!(
                flat.material_of
                    .iter()
                    .all(|&m| (m as usize) < model.materials.len()),
                "{}",
                builtin.name
            );
            for [a, b, c] in &flat.indices {
                assert!(a != b && b != c && c != a, "{}", builtin.name);
            }
            let camera = model.cameras[0];
            assert!(camera.eye != camera.target && camera.fov > 0.0 && camera.fov < 180.0);
            for normal in model.meshes.iter().flat_map(|mesh| &mesh.normals) {
                let length = normal.iter().map(|x| x * x).sum::<f32>();
                assert!((length - 1.0).abs() < 1e-5, "{}: {normal:?}", builtin.name);
            }
        }
    }

    #[test]
    fn every_scene_has_the_same_bits_on_every_machine() {
        let found: Vec<_> = BUILTINS
            .iter()
            .map(|b| (b.name, hash(&build(b.name).unwrap())))
            .collect();
        assert_eq!(found, GOLDEN);
    }

    const GOLDEN: &[(&str, u64)] = &[
        ("bush", 0xd185_2908_be26_a4b8),
        ("cornell", 0xa9af_e5ce_8ddd_5b2c),
        ("stadium", 0x9924_183b_3d0c_2f7a),
        ("terrain", 0xc6a9_bc49_ec46_f901),
        ("hairball", 0x25cd_ef4e_e92d_972b),
        ("soup", 0x72dc_dd73_2792_fadc),
        ("sphere", 0x8fd4_dcc2_338b_0869),
        ("instanced_grove", 0x5d04_0857_b232_41cb),
    ];

    #[test]
    fn another_seed_makes_another_scene_of_the_same_size() {
        for builtin in BUILTINS.iter().filter(|builtin| builtin.seeded) {
            let [first, again, other] =
                [1, 1, 2].map(|seed| build(&format!("{}?seed={seed}", builtin.name)).unwrap());
            assert_eq!(hash(&first), hash(&again), "{}", builtin.name);
            assert_ne!(hash(&first), hash(&other), "{}", builtin.name);
            assert_eq!(
                first.triangle_count(),
                other.triangle_count(),
                "{}",
                builtin.name
            );
        }
    }

    #[test]
    fn wrong_specs_are_refused_with_the_nearest_right_one() {
        assert_eq!(
            refusal("bsh"),
            "builtin:bsh: there is no built-in scene \"bsh\" (did you mean bush? known: bush, cornell, stadium, \
             terrain, hairball, soup, sphere, instanced_grove)"
        );
        assert!(refusal("").contains("known: bush"));
        assert!(
            refusal("soup?sed=3")
                .ends_with("unknown parameter \"sed\" (did you mean seed? known: n, seed)")
        );
        assert!(
            refusal("cornell?n=3").ends_with("unknown parameter \"n\" (cornell has no parameters)")
        );
        assert!(refusal("soup?n=10&seed=1&n=20").contains("n is given more than once"));
        assert!(refusal("soup?n=-3").contains("n is \"-3\""));
        assert!(refusal("soup?n").contains("n is \"\""));
        assert!(refusal("soup?n=50000001").contains("soup can have 1 to 50000000 triangles"));
        assert!(refusal("soup?n=99999999999999999999").contains("a whole number"));
        assert_eq!(
            build("soup?n=1_000&&seed=3").unwrap().triangle_count(),
            1000
        );
    }
}
