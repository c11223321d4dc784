//! Measures a scene and writes the result: `cargo run --release --example render -- SCENE.xml OUT.exr`.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of an example, no results"
)]

use nephroid::{Budget, Context, Method};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let scene = arguments.next();
    let output = arguments.next().unwrap_or("out/render.exr".to_owned());

    let scene = scene.as_deref().unwrap_or("scenes/glass-ball.xml");
    let scene = nephroid::load(scene.as_ref(), &[])?;
    let sensor = &scene.sensors()[0];
    let choice = Method::choose(&scene, sensor)?;
    println!("{}: {}", choice.method.name(), choice.reason);

    let (budget, context) = (Budget::error(0.01), Context::default());
    let rendering = choice.method.run(&scene, sensor, &budget, &context)?;
    let unit = rendering.estimate.quantity.unit();
    for layer in &rendering.estimate.layers {
        let name = layer.name.to_string();
        println!("{name:>8} {:10.4} {unit}", layer.range().mean);
    }
    std::fs::create_dir_all("out")?;
    Ok(rendering.write_exr(&scene, output.as_ref())?)
}
