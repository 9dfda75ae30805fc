//! The lecture's BoundedObject, nested by hand, over different volumes: `cargo run --release -p boxwood --example nested_objects`.

use boxwood::{Aabb, BoundedObject, Obb, Object, Ray, Sphere, Triangle};

fn main() {
    // A snowman: three balls in a sphere.
    let ball = |number, y, radius| -> Box<dyn Object> {
        let center = [0.0, y, 10.0];
        Box::new((number, Sphere { center, radius }))
    };
    let snowman = BoundedObject::<Sphere>::new(vec![
        ball(0, 1.0, 1.0),
        ball(1, 2.5, 0.7),
        ball(2, 3.6, 0.5),
    ]);
    // Leaning boards: triangles in an oriented box.
    let board = |number, x| -> Box<dyn Object> {
        let corners = [[x, 0.0, 12.0], [x + 1.0, 0.0, 12.0], [x + 0.5, 4.0, 14.0]];
        Box::new((number, Triangle(corners)))
    };
    let fence = BoundedObject::<Obb>::new((0..8).map(|i| board(10 + i, i as f32 - 4.0)).collect());
    // Both in a box: bounded objects are objects.
    let yard = BoundedObject::<Aabb>::new(vec![Box::new(snowman), Box::new(fence)]);

    for (x, y) in [(0.0, 1.0), (0.1, 3.6), (-3.5, 1.0), (6.0, 1.0)] {
        let hit = yard.closest_hit(&Ray::new([x, y, 0.0], [0.0, 0.0, 1.0]));
        println!("({x}, {y}): {:?}", hit.map(|h| (h.prim, h.t)));
    }
}
