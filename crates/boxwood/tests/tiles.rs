//! Rays that go nearly the same way are traced together: as exact as alone, on every scene.

mod common;

use boxwood::check::{Aim, Rays};
use boxwood::{BuildOptions, Builder, Hit, InstructionSet, Ray};
use common::{built, code, scenes, triangles};

const TILE: usize = 64;
const TILES: u64 = 120;

fn same(a: Option<Hit>, b: Option<Hit>) -> bool {
    // -0 is not 0 here.
    format!("{a:?}") == format!("{b:?}")
}

#[test]
fn coherent_tiles_agree_with_the_list_on_every_scene() {
    let mut hits = 0;
    for (name, mesh) in scenes() {
        let shapes = triangles(&mesh);
        let aimed = Rays::new(&shapes, Aim::Tiles, 3);
        let rays: Vec<Ray> = (0..TILES * TILE as u64).map(|k| aimed.ray(k)).collect();
        let build = |structure, options| built(&mesh, structure, options);
        let list = build("list", BuildOptions::default());
        let expected: Vec<_> = rays.iter().map(|ray| list.closest_hit(ray)).collect();
        hits += expected.iter().flatten().count();
        for structure in ["wide", "compact"] {
            for instructions in InstructionSet::available() {
                for builder in [Builder::BINNED, Builder::MIDPOINT] {
                    let options = BuildOptions {
                        instructions,
                        ..BuildOptions::with(builder)
                    };
                    let scene = build(structure, options);
                    let (mut closest, mut occluded) = ([None; TILE], [false; TILE]);
                    for (tile, expected) in rays.chunks(TILE).zip(expected.chunks(TILE)) {
                        // One tile a call: nothing is learnt from the tiles before.
                        scene.closest_hits(tile, &mut closest);
                        scene.occluded_each(tile, &mut occluded);
                        for (k, ray) in tile.iter().enumerate() {
                            let place = || {
                                format!(
                                    "{name}, {structure}, {}, {}",
                                    instructions.name(),
                                    code(ray)
                                )
                            };
                            assert!(
                                same(closest[k], expected[k]),
                                "{:?}, {}",
                                closest[k],
                                place()
                            );
                            assert_eq!(occluded[k], expected[k].is_some(), "{}", place());
                        }
                    }
                }
            }
        }
    }
    assert!(hits > 20_000, "{hits}");
}
