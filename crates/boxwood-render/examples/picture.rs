//! A picture of a scene file: `cargo run --release --example picture -- bunny.obj path bunny.png
//! 640 480`.

use std::{env, error::Error, path::Path};

use boxwood_render::{RenderOptions, Shading, Surfaces, View, Watch};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [file, shading, output, width, height, ..] = arguments.as_slice() else {
        return Err("give FILE SHADING OUTPUT.png WIDTH HEIGHT [SAMPLES]".into());
    };
    let model = boxwood_scene::open(file)?;
    let mesh = model.flatten()?;
    let scene = boxwood::Scene::new(&mesh.positions, &mesh.indices)?;
    let surfaces = Surfaces::new(&mesh, &model);

    let (width, height) = (width.parse()?, height.parse()?);
    let own_camera = model.cameras.first().copied();
    let camera =
        own_camera.unwrap_or_else(|| boxwood_render::auto_camera(&scene, surfaces, width, height));
    let view = View::new(camera, width, height)?;

    let mut options = RenderOptions::new(Shading::named(shading)?);
    options.samples = arguments
        .get(5)
        .map(|samples| samples.parse())
        .transpose()?;
    let film = boxwood_render::render(&scene, surfaces, &view, &options, Watch::default())?;
    let image = film.to_image();
    boxwood_render::save_atomically(Path::new(output), |out| {
        boxwood_render::write_png(&image, &[], out)
    })?;
    println!("{} rays, camera {camera:?}", film.rays);
    Ok(())
}
