//! From a mesh file to hits, one ray at a time and a million at once:
//! `cargo run --release -p boxwood-scene --example mesh_to_hits -- bunny.obj`.

use boxwood::{Ray, Scene};
use std::{env, error::Error};

fn main() -> Result<(), Box<dyn Error>> {
    let file = env::args().nth(1).ok_or("give a mesh file")?;
    let mesh = boxwood_scene::open(&file)?.flatten()?;
    let scene = Scene::new(&mesh.positions, &mesh.indices)?;

    // From the corner of the scene's box to its centre.
    let bounds = scene.bounds();
    let ray = Ray::between(bounds.min, bounds.center());
    match scene.closest_hit(&ray) {
        Some(hit) => println!("triangle {} at t = {}", hit.prim, hit.t),
        None => println!("nothing on the way"),
    }

    // Through the face x = min of the box, a thousand by a thousand, on all cores.
    let at = |k: usize, axis: usize| bounds.min[axis] + bounds.extent()[axis] * k as f32 / 999.0;
    let rays: Vec<Ray> = (0..1_000_000)
        .map(|k| {
            Ray::new(
                [bounds.min[0], at(k % 1000, 1), at(k / 1000, 2)],
                [1.0, 0.0, 0.0],
            )
        })
        .collect();
    let mut hits = vec![None; rays.len()];
    scene.closest_hits(&rays, &mut hits);
    println!("{} of {} hit", hits.iter().flatten().count(), rays.len());
    Ok(())
}
