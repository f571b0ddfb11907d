//! Writes the bundled scenarios: `cargo run --example make-scenarios`.
//!
//! The files land in `scenarios/` and are the same at every run. Each line of output says how near
//! the ego comes to any obstacle, which is what to look at while changing a scenario.

#[path = "mod.rs"]
mod make;

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use nearmiss::formats::{commonroad, read_ego};
use nearmiss::metrics::{Headline, Nearest, Thresholds};
use nearmiss::scenario::Scene;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    for made in make::all()? {
        let recording = format!("{}.ego_trajectory.csv", made.name);
        std::fs::write(folder.join(format!("{}.xml", made.name)), &made.xml)?;
        std::fs::write(folder.join(&recording), &made.csv)?;
        println!("{}", line(&made, &recording)?);
    }
    Ok(())
}

fn line(made: &make::Made, recording: &str) -> Result<String, Box<dyn Error>> {
    let scenario = commonroad::read(&made.xml, made.name)?;
    let ego = read_ego(&made.csv, recording, &scenario, None)?;
    let scene = Scene::new(Arc::new(scenario), ego);
    let headline = Headline::compute(&scene, Thresholds::shipped());
    let say = |nearest: Option<Nearest>, unit: &str| {
        nearest.map_or("none".into(), |n| {
            format!("{:.2} {unit} to {} at {}", n.value, n.obstacle, n.step)
        })
    };
    Ok(format!(
        "{} · {}\n    {:?}: {} obstacles, {} steps, distance {}, ttc {}, {} kB",
        made.name,
        made.title,
        made.outcome,
        scene.scenario.obstacles.len(),
        scene.last_step(),
        say(headline.distance, "m"),
        say(headline.ttc, "s"),
        made.xml.len() / 1000,
    ))
}
