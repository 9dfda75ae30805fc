//! From a mesh to a hit: `cargo run --release -p boxwood --example first_ray`.

use boxwood::{Ray, Scene};

fn main() -> Result<(), boxwood::BuildError> {
    // A square of two triangles at z = 5.
    let positions = [
        [0.0, 0.0, 5.0],
        [4.0, 0.0, 5.0],
        [4.0, 4.0, 5.0],
        [0.0, 4.0, 5.0],
    ];
    let scene = Scene::new(&positions, &[[0, 1, 2], [0, 2, 3]])?;

    // Straight at the diagonal that both triangles share: exactly one of them is hit.
    let ray = Ray::new([2.0, 2.0, 0.0], [0.0, 0.0, 1.0]);
    println!("closest: {:?}", scene.closest_hit(&ray));
    println!("all:     {:?}", scene.all_hits(&ray));
    println!(
        "shadow:  {}",
        scene.occluded(&Ray::between([2.0, 2.0, 0.0], [2.0, 2.0, 9.0]))
    );
    Ok(())
}
