//! The bundled scenarios: the files are what the program in scenarios/make computes, move as bodies can, and end as
//! declared.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod files;
#[path = "../../scenarios/make/mod.rs"]
mod make;
mod motion;
mod occupancies;
mod outcome;
mod pictures;
mod recording;
mod windows;

use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

use nearmiss::formats::{commonroad, read_ego};
use nearmiss::scenario::Scene;

/// A bundled scenario as it is declared, and as it is read back from its files.
struct Case {
    made: make::Made,
    scene: Scene,
}

static CASES: LazyLock<Vec<Case>> = LazyLock::new(|| {
    let read = |made: make::Made| {
        let bytes =
            |ending: &str| std::fs::read(folder().join(format!("{}.{ending}", made.name))).unwrap();
        let scenario = commonroad::read(&bytes("xml"), made.name).unwrap();
        let ego = read_ego(&bytes("ego_trajectory.csv"), made.name, &scenario, None).unwrap();
        let scene = Scene::new(Arc::new(scenario), ego);
        Case { made, scene }
    };
    make::all().unwrap().into_iter().map(read).collect()
});

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenarios")
}

/// Fails with all complaints at once, so that a scenario can be mended in one go.
fn none(complaints: &[String]) {
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}
