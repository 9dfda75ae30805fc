//! What opening a saved scene costs beside building it: `open_or_build MESH.ply`.

use std::time::{Duration, Instant};

use boxwood::check::{Aim, Rays};
use boxwood::{Ray, Scene, Triangle};

/// The shortest of some runs.
fn least<T>(mut run: impl FnMut() -> T) -> (T, Duration) {
    let mut times = Vec::new();
    loop {
        let start = Instant::now();
        let result = run();
        times.push(start.elapsed());
        if times.len() == 7 {
            return (result, times.into_iter().min().unwrap_or_default());
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or("builtin:bush".to_owned());
    let mesh = boxwood_scene::open(&name)?.flatten()?;
    let path = std::env::temp_dir().join(format!("boxwood-{}.bwx", std::process::id()));
    let (built, build) = least(|| Scene::new(&mesh.positions, &mesh.indices));
    let built = built?;
    let (saved, save) = least(|| built.save(&mut std::fs::File::create(&path)?));
    let hash = saved?;
    let (opened, open) = least(|| Scene::open(&path));
    let (read, copy) = least(|| Scene::read(&path));
    let bytes = path.metadata()?.len();
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    println!(
        "{name}: {} triangles, {:.1} MB, {hash}",
        built.len(),
        bytes as f64 / 1e6
    );
    println!(
        "build {:.1} ms, save {:.1} ms, open {:.1} ms, read {:.1} ms",
        ms(build),
        ms(save),
        ms(open),
        ms(copy)
    );

    let triangles: Vec<Triangle> = mesh
        .indices
        .iter()
        .map(|t| Triangle(t.map(|i| mesh.positions[i as usize])))
        .collect();
    let aimed = Rays::new(&triangles, Aim::Random, 5);
    let rays: Vec<Ray> = (0..1 << 19).map(|index| aimed.ray(index)).collect();
    for (name, scene) in [("built", &built), ("opened", &opened?), ("read", &read?)] {
        let mut hits = vec![None; rays.len()];
        let ((), time) = least(|| scene.closest_hits(&rays, &mut hits));
        println!(
            "{name}: {:.2} Mrays/s",
            rays.len() as f64 / 1e6 / time.as_secs_f64()
        );
    }
    std::fs::remove_file(&path)?;
    Ok(())
}
