//! The example that the paper's authors published: an original, and the variant that a model made of it.

use std::path::{Path, PathBuf};

use nearmiss::generation::{Gate, Refusal};
use nearmiss::scenario::commonroad;

use super::support::program::skipped;

fn folder() -> Option<PathBuf> {
    let shared = std::env::var_os("NEARMISS_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"),
        PathBuf::from,
    );
    let folder = shared.join("data/from-words-to-collisions/Generation");
    folder.is_dir().then_some(folder)
}

#[test]
fn each_violation_of_the_published_example_is_named() {
    let Some(folder) = folder() else {
        skipped(
            "the published example is not here; NEARMISS_SHARED can name the folder that holds data/",
        );
        return;
    };
    let read =
        |name: &str| commonroad::read_file(&folder.join(name).join(format!("{name}.xml"))).unwrap();
    let original = read("BEL_Antwerp-1_14_T-1");
    let variant = read("BEL_Antwerp-1_14_T-1n");
    // The recording is rounded to 4 digits.
    let gate = Gate::new(&original).rounded_to(5e-5);
    let compared = gate.compare(&variant, None);
    for refusal in &compared.refusals {
        println!("{refusal}");
    }
    for one in &compared.changed {
        println!("{} from {}", one.change.obstacle, one.from);
        for refusal in one.verdict.as_ref().err().unwrap() {
            println!("  {refusal}");
        }
    }
    panic!();
}
