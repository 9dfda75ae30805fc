//! The page's race, natively: `race SCENE WIDTHxHEIGHT STRUCTURE...` prints milliseconds per frame, one line each.
//!
//! The page's tests divide its times by these. One thread: `RAYON_NUM_THREADS=1`.

use std::time::{Duration, Instant};

use boxwood_web::Lab;

/// Each structure is timed for so long.
const TIME: Duration = Duration::from_millis(1200);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scene, size, structures @ ..] = &args[..] else {
        return Err("race SCENE WIDTHxHEIGHT STRUCTURE...".into());
    };
    let (width, height) = size.split_once('x').ok_or("WIDTHxHEIGHT")?;
    let (width, height): (u32, u32) = (width.parse()?, height.parse()?);
    let mut lab = Lab::open(scene, None)?;
    lab.look(width, height)?;
    for structure in structures {
        let number = lab.build(structure, "binned")?.number;
        // As on the page: brute force by rows from all over the picture, others by bands.
        let (rows, stride) = if structure == "list" {
            (1, 67)
        } else {
            (30, 30)
        };
        let (start, mut rays) = (Instant::now(), 0);
        let mut y = 0;
        while start.elapsed() < TIME {
            rays += lab.shoot(number, y, rows)?.rays;
            y = (y + stride) % height;
        }
        let frames = rays as f64 / (f64::from(width) * f64::from(height));
        println!("{}", start.elapsed().as_secs_f64() * 1e3 / frames);
    }
    Ok(())
}
