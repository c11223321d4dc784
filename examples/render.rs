//! Measures a scene and writes the result: `cargo run --release --example render -- SCENE.xml OUT.exr`.

use std::env;
use std::error::Error;

use nephroid::{Budget, Context, Method};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = env::args().skip(1);
    let scene = arguments
        .next()
        .unwrap_or("scenes/glass-ball.xml".to_owned());
    let output = arguments.next().unwrap_or("out/render.exr".to_owned());

    let scene = nephroid::load(scene.as_ref(), &[])?;
    let sensor = &scene.sensors()[0];
    let choice = Method::choose(&scene, sensor)?;
    println!("{}: {}", choice.method.name(), choice.reason);

    let budget = Budget::error(0.01);
    let rendering = choice
        .method
        .run(&scene, sensor, &budget, &Context::default())?;
    for layer in &rendering.estimate.layers {
        println!(
            "{:>8} {:10.4} {}",
            layer.name.to_string(),
            layer.range().mean,
            rendering.estimate.quantity.unit()
        );
    }
    std::fs::create_dir_all("out")?;
    Ok(rendering.write_exr(&scene, output.as_ref())?)
}
