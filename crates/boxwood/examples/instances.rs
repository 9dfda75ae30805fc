//! One mesh in many places, and a change: `cargo run --release -p boxwood --example instances`.

use boxwood::{Ray, Scene, Transform};
use std::sync::Arc;

fn main() -> Result<(), boxwood::BuildError> {
    // A tent of four triangles, and a street of a thousand tents.
    let corners = [
        [-1.0, 0.0, -1.0],
        [1.0, 0.0, -1.0],
        [1.0, 0.0, 1.0],
        [-1.0, 0.0, 1.0],
        [0.0, 2.0, 0.0],
    ];
    let sides = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
    let tent = Arc::new(Scene::new(&corners, &sides)?);
    let place = |i: u32| Transform::translation([0.0, 0.0, 3.0 * i as f32]);
    let street = (0..1000).fold(Scene::builder(), |s, i| s.instance(&tent, place(i)));
    let street = street.build()?;
    println!("{:?}", street.census());

    let ray = Ray::new([0.25, 1.0, -10.0], [0.0, 0.0, 1.0]);
    println!("before: {:?}", street.closest_hit(&ray));

    // The first tent is struck. The street as it was goes on answering.
    let mut places: Vec<Transform> = (0..1000).map(place).collect();
    places[0] = Transform::translation([500.0, 0.0, 0.0]);
    let after = street.with_transforms(&places)?;
    println!("after:  {:?}", after.closest_hit(&ray));
    Ok(())
}
