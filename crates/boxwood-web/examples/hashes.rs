//! What rays hit natively, as hashes: the page's tests compare them with those of the browser.
//!
//! `hashes SCENE RAYS SEED STRUCTURE...` prints one hash a line.

use boxwood_web::{Lab, hits_hash};

fn main() -> Result<(), String> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scene, rays, seed, structures @ ..] = &args[..] else {
        return Err("hashes SCENE RAYS SEED STRUCTURE...".to_owned());
    };
    let number = |text: &str| text.parse().map_err(|_| format!("{text} is no number"));
    let (rays, seed) = (number(rays)?, number(seed)?);
    let mut lab = Lab::open(scene, None)?;
    for structure in structures {
        let built = lab.build(structure, "binned")?;
        println!("{}", hits_hash(lab.scene(built.number)?, rays, seed));
    }
    Ok(())
}
