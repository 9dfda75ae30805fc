//! What does a ray cost in each structure? `cargo run --release -p boxwood --example count_nodes`.

use boxwood::{Counts, Ray, STRUCTURES, Scene};

fn main() -> Result<(), boxwood::BuildError> {
    // A bumpy sheet of 20,000 triangles.
    let side = 101;
    let height = |x: u32, y: u32| (x as f32 * 0.3).sin() * (y as f32 * 0.2).cos();
    let positions: Vec<[f32; 3]> = (0..side * side)
        .map(|i| {
            [
                (i % side) as f32,
                height(i % side, i / side),
                (i / side) as f32,
            ]
        })
        .collect();
    let corner = |x: u32, y: u32| y * side + x;
    let squares = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| (x, y)));
    let indices: Vec<[u32; 3]> = squares
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [
                corner(x, y),
                corner(x + 1, y),
                corner(x + 1, y + 1),
                corner(x, y + 1),
            ];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    for structure in STRUCTURES {
        let scene = Scene::builder()
            .mesh(&positions, &indices)
            .structure(structure.name)
            .build()?;
        let mut counts = Counts::default();
        let mut hits = 0;
        for i in 0..1000 {
            let ray = Ray::between(
                [50.0, 30.0, -40.0],
                [(i % 40) as f32 * 2.5, 0.0, (i / 40) as f32 * 4.0],
            );
            hits += u32::from(
                scene
                    .closest_hit_counted(&ray.with_range(0.0, 9.0), &mut counts)
                    .is_some(),
            );
        }
        println!("{:8} {hits} hits: {counts:?}", structure.name);
    }
    Ok(())
}
