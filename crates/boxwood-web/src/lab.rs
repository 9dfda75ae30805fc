//! One scene with the structures built over it, and a camera: what most figures ask.

use boxwood::{
    BUILDERS, BuildOptions, Builder, Counts, InstructionSet, Ray, STRUCTURES, Scene, Structure,
};
use boxwood_render::{Frames, Image, Surfaces, View, auto_camera};
use boxwood_scene::{Camera, FlatMesh, Model, builtin};
use boxwood_trace::BuildTrace;
use serde::Serialize;

use crate::{WalkAnswer, hash_of_hits};

/// A scene from a file or built in, ready for questions. Errors are one sentence for the reader.
pub struct Lab {
    name: String,
    model: Model,
    mesh: FlatMesh,
    /// The first is the default structure, which draws.
    built: Vec<(Built, Scene)>,
    view: View,
    /// Made when first asked for a picture, and again for another view.
    frames: Option<Frames>,
}

/// A structure, in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Built {
    /// For [`Lab::heat`], [`Lab::shoot`] and [`Lab::walk`].
    pub number: usize,
    /// From [`STRUCTURES`].
    pub structure: &'static str,
    /// From [`BUILDERS`]; `None` for what is not a tree.
    pub builder: Option<&'static str>,
    /// Inner nodes and leaves; of a grid, cells that are not empty.
    pub nodes: usize,
    /// With primitives.
    pub leaves: usize,
    /// Of the deepest leaf.
    pub max_depth: u32,
    /// Of a random line that meets the root; `None` where that means nothing.
    pub sah_cost: Option<f64>,
    /// Memory with its copy of the triangles.
    pub bytes: usize,
}

/// The scene as a reader sees it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Seen {
    /// As opened.
    pub name: String,
    /// Instances multiplied out.
    pub triangles: usize,
    /// That can never be hit.
    pub skipped: usize,
    /// What the reader of the file tolerated.
    pub warnings: Vec<String>,
    /// `simd128` or `scalar` on a page.
    pub instructions: &'static str,
    /// In pixels.
    pub size: [u32; 2],
    /// Where the picture is taken from.
    pub camera: CameraSeen,
}

/// As the command line takes it: `--vp --vi --vu --fov`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CameraSeen {
    /// Where the eye is.
    pub eye: [f32; 3],
    /// What it looks at.
    pub target: [f32; 3],
    /// What is up.
    pub up: [f32; 3],
    /// Vertical, in degrees.
    pub fov: f32,
}

/// What the rays of some rows of the picture hit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shot {
    /// One per pixel.
    pub rays: usize,
    /// That hit something.
    pub hits: usize,
    /// Of all bits of the hits.
    pub hash: String,
}

/// The size before [`Lab::look`].
const SIZE: [u32; 2] = [320, 180];

/// Names of all structures, and of all builders.
pub fn structure_names() -> (Vec<&'static str>, Vec<&'static str>) {
    let structures = STRUCTURES.iter().map(|structure| structure.name);
    let builders = BUILDERS.iter().map(|builder| builder.name);
    (structures.collect(), builders.collect())
}

impl Lab {
    /// Opens `name`: built-in (`builtin:bush`) without a `model`, else that which [`read`](crate::read) made of a file.
    ///
    /// Builds the default structure and looks from where the scene says, else from where it is seen well.
    pub fn open(name: &str, model: Option<&[u8]>) -> Result<Self, String> {
        let model: Model = match (model, name.strip_prefix("builtin:")) {
            (Some(bytes), _) => postcard::from_bytes(bytes).map_err(sentence)?,
            (None, Some(spec)) => builtin(spec).map_err(sentence)?,
            (None, None) => return Err(format!("{name} is not built in: drop the file itself")),
        };
        let mesh = model.flatten().map_err(sentence)?;
        if mesh.indices.is_empty() {
            return Err(format!("{name} shows no triangles"));
        }
        let mut lab = Self {
            name: name.to_owned(),
            model,
            mesh,
            built: Vec::new(),
            view: View::new(FROM_ANYWHERE, SIZE[0], SIZE[1]).map_err(sentence)?,
            frames: None,
        };
        lab.build(Structure::DEFAULT, Builder::BINNED.name)?;
        lab.look(SIZE[0], SIZE[1])?;
        Ok(lab)
    }

    /// The scene and the camera in words and numbers.
    pub fn seen(&self) -> Seen {
        let Camera {
            eye,
            target,
            up,
            fov,
        } = self.view.camera();
        Seen {
            name: self.name.clone(),
            triangles: self.mesh.indices.len(),
            skipped: self.built[0].1.skipped(),
            warnings: self.model.warnings.clone(),
            instructions: InstructionSet::best().name(),
            size: [self.view.width(), self.view.height()],
            camera: CameraSeen {
                eye,
                target,
                up,
                fov,
            },
        }
    }

    /// Builds a structure, or finds it built. The builder does not matter to what is not a tree.
    pub fn build(&mut self, structure: &str, builder: &str) -> Result<Built, String> {
        let structure = Structure::named(structure).map_err(sentence)?;
        let builder = Builder::named(builder)
            .ok_or_else(|| format!("there is no builder called {builder}"))?;
        let of_tree = structure.is_tree.then_some(builder.name);
        let is_it = |built: &Built| built.structure == structure.name && built.builder == of_tree;
        if let Some((built, _)) = self.built.iter().find(|(built, _)| is_it(built)) {
            return Ok(built.clone());
        }
        let scene = self.scene_in(structure.name, builder)?;
        let stats = scene.stats();
        let built = Built {
            number: self.built.len(),
            structure: structure.name,
            builder: of_tree,
            nodes: stats.nodes,
            leaves: stats.leaves,
            max_depth: stats.max_depth,
            sah_cost: of_tree.and(stats.sah_cost.is_finite().then_some(stats.sah_cost)),
            bytes: stats.bytes,
        };
        self.built.push((built.clone(), scene));
        Ok(built)
    }

    /// Builds a structure once more, for the clock of who calls: the first is built before there is anyone to look at it.
    pub fn rebuild(&mut self, number: usize) -> Result<(), String> {
        let (built, _) = self.built.get(number).ok_or("it is not built yet")?;
        let builder = built.builder.and_then(Builder::named);
        let scene = self.scene_in(built.structure, builder.unwrap_or(Builder::BINNED))?;
        self.built[number].1 = scene;
        Ok(())
    }

    fn scene_in(&self, structure: &str, builder: Builder) -> Result<Scene, String> {
        Scene::builder()
            .mesh(&self.mesh.positions, &self.mesh.indices)
            .structure(structure)
            .options(BuildOptions::with(builder))
            .build()
            .map_err(sentence)
    }

    /// A structure by its [`Built::number`].
    pub fn scene(&self, number: usize) -> Result<&Scene, String> {
        let built = self.built.get(number).map(|(_, scene)| scene);
        built.ok_or_else(|| format!("structure {number} is not built yet"))
    }

    /// The nodes that stand `depth` below the root, and the leaves above that: seven numbers each, smallest corner, largest corner,
    /// and the triangles of a leaf or 0.
    pub fn nodes(&self, number: usize, depth: u32) -> Result<Vec<f32>, String> {
        let mut numbers = Vec::new();
        self.scene(number)?.query().for_each_node(&mut |node| {
            if node.depth == depth || node.depth < depth && node.prims.is_some() {
                numbers.extend(node.bounds.min.into_iter().chain(node.bounds.max));
                numbers.push(node.prims.unwrap_or(0) as f32);
            }
        });
        Ok(numbers)
    }

    /// Looks at the scene in pictures of another size.
    pub fn look(&mut self, width: u32, height: u32) -> Result<(), String> {
        let surfaces = Surfaces::new(&self.mesh, &self.model);
        let camera = match self.model.cameras.first() {
            Some(camera) => *camera,
            None => auto_camera(self.scene(0)?, surfaces, width, height),
        };
        self.view = View::new(camera, width, height).map_err(sentence)?;
        self.frames = None;
        Ok(())
    }

    /// How a structure came to be, up to `limit` steps: those of `boxwood build --trace`.
    pub fn steps(&self, number: usize, limit: usize) -> Result<BuildTrace, String> {
        boxwood_trace::build(self.scene(number)?, limit).map_err(sentence)
    }

    /// The picture in any size, RGBA, shaded with sun and shadows. [`Lab::look`] chooses the camera, this only how fine it is.
    pub fn picture(&mut self, width: u32, height: u32) -> Result<Vec<u8>, String> {
        let surfaces = Surfaces::new(&self.mesh, &self.model);
        let view = View::new(self.view.camera(), width, height).map_err(sentence)?;
        let frames = self
            .frames
            .get_or_insert_with(|| Frames::new(surfaces, &view));
        let mut image = Image {
            width: 0,
            height: 0,
            rgb: Vec::new(),
        };
        let (_, scene) = self.built.first().ok_or("nothing is built yet")?;
        frames.draw(scene, &view, &mut image);
        let rgba = image.rgb.iter().flat_map(|&[r, g, b]| [r, g, b, 255]);
        Ok(rgba.collect())
    }

    /// Three numbers for each pixel of the rows from `y` on: box tests (in a grid cells, if they are more), triangle tests, operations.
    pub fn heat(&self, number: usize, y: u32, rows: u32) -> Result<Vec<u32>, String> {
        let scene = self.scene(number)?;
        let mut numbers = Vec::new();
        for ray in self.rays(y, rows) {
            let mut counts = Counts::default();
            scene.closest_hit_counted(&ray, &mut counts);
            let three = [counts.boxes.max(counts.nodes), counts.prims, counts.flops];
            numbers.extend(three.map(|count| u32::try_from(count).unwrap_or(u32::MAX)));
        }
        Ok(numbers)
    }

    /// Shoots the rays of the rows from `y` on, without counting: for the clock of who calls.
    pub fn shoot(&self, number: usize, y: u32, rows: u32) -> Result<Shot, String> {
        let scene = self.scene(number)?;
        let rays: Vec<Ray> = self.rays(y, rows).collect();
        let mut hits = vec![None; rays.len()];
        scene.closest_hits(&rays, &mut hits);
        Ok(Shot {
            rays: rays.len(),
            hits: hits.iter().flatten().count(),
            hash: hash_of_hits(&hits),
        })
    }

    /// How the ray through the centre of a pixel finds its answer.
    pub fn walk(&self, number: usize, x: u32, y: u32) -> Result<WalkAnswer, String> {
        let (width, height) = (self.view.width(), self.view.height());
        if x >= width || y >= height {
            return Err(format!(
                "pixel {x},{y} is outside a picture of {width}x{height}"
            ));
        }
        Ok(WalkAnswer::of(
            self.scene(number)?,
            &self.view.pixel_ray(x, y),
        ))
    }

    /// Row by row; rows beyond the picture are left out.
    fn rays(&self, y: u32, rows: u32) -> impl Iterator<Item = Ray> + '_ {
        let end = y.saturating_add(rows).min(self.view.height());
        let row = move |y| (0..self.view.width()).map(move |x| self.view.pixel_ray(x, y));
        (y..end).flat_map(row)
    }
}

/// Until the scene is there to be looked at.
const FROM_ANYWHERE: Camera = Camera {
    eye: [0.0, 0.0, 1.0],
    target: [0.0; 3],
    up: [0.0, 1.0, 0.0],
    fov: 35.0,
};

fn sentence(error: impl std::fmt::Display) -> String {
    error.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_frame_counts_as_row_by_row_and_as_each_walk() {
        let mut lab = Lab::open("builtin:sphere?n=2000", None).unwrap();
        lab.look(40, 24).unwrap();
        let bvh = lab.build("bvh2", "binned").unwrap().number;
        let whole = lab.heat(bvh, 0, 24).unwrap();
        assert_eq!(whole.len(), 3 * 40 * 24);
        let rows = (0..24).flat_map(|y| lab.heat(bvh, y, 1).unwrap());
        assert!(whole.iter().copied().eq(rows));
        let walk = lab.walk(bvh, 20, 12).unwrap();
        let pixel = 3 * (12 * 40 + 20);
        assert_eq!(walk.trace.counts.box_tests, u64::from(whole[pixel]));
        assert_eq!(
            walk.trace.counts.primitive_tests,
            u64::from(whole[pixel + 1])
        );
        assert_eq!(walk.trace.counts.flops, u64::from(whole[pixel + 2]));
    }

    #[test]
    fn each_depth_of_the_tree_holds_all_triangles() {
        let mut lab = Lab::open("builtin:sphere?n=300", None).unwrap();
        let built = lab.build("bvh2", "median").unwrap();
        assert_eq!(lab.nodes(built.number, 0).unwrap().len(), 7);
        let deepest = lab.nodes(built.number, built.max_depth).unwrap();
        assert_eq!(deepest.len(), 7 * built.leaves);
        let triangles: f32 = deepest.chunks(7).map(|node| node[6]).sum();
        assert_eq!(triangles as usize, lab.seen().triangles);
    }

    #[test]
    fn the_steps_of_a_build_end_in_its_tree() {
        let mut lab = Lab::open("builtin:cornell", None).unwrap();
        let built = lab.build("bvh2", "sweep").unwrap();
        let whole = lab.steps(built.number, usize::MAX).unwrap();
        assert_eq!(whole.steps.len(), whole.steps_total);
        assert_eq!(whole.stats.leaves, built.leaves);
        let some = lab.steps(built.number, 5).unwrap();
        assert_eq!(some.steps.len(), 5);
        assert_eq!(some.steps[0], whole.steps[0]);
        assert!(lab.steps(7, 5).is_err());
    }

    #[test]
    fn every_structure_hits_the_same() {
        let mut lab = Lab::open("builtin:cornell", None).unwrap();
        lab.look(32, 18).unwrap();
        let shots = ["list", "grid", "bvh2", "wide"].map(|structure| {
            let number = lab.build(structure, "binned").unwrap().number;
            lab.shoot(number, 0, 18).unwrap()
        });
        assert!(shots.iter().all(|shot| *shot == shots[0]), "{shots:?}");
        assert!(shots[0].hits > 100);
    }

    #[test]
    fn a_structure_is_built_once_and_a_picture_has_four_bytes_a_pixel() {
        let mut lab = Lab::open("builtin:sphere?n=200", None).unwrap();
        let first = lab.build("bvh2", "median").unwrap();
        assert_eq!(lab.build("bvh2", "median").unwrap(), first);
        assert_ne!(lab.build("bvh2", "sweep").unwrap().number, first.number);
        assert_eq!(lab.build("grid", "median").unwrap().builder, None);
        assert_eq!(lab.picture(64, 36).unwrap().len(), 4 * 64 * 36);
    }

    #[test]
    fn what_cannot_be_shown_is_refused_with_file_and_cause() {
        let refusal = |name: &str, model: Option<&[u8]>| Lab::open(name, model).err().unwrap();
        assert!(refusal("builtin:busch", None).contains("did you mean bush"));
        assert!(refusal("bunny.obj", None).contains("drop the file"));
        assert!(Lab::open("bunny.obj", Some(b"not a model")).is_err());
        let lab = Lab::open("builtin:cornell", None).unwrap();
        assert!(lab.walk(9, 0, 0).is_err() && lab.walk(0, 320, 0).is_err());
    }
}
