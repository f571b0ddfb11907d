//! The bundled scenarios: invented here, and computed rather than recorded.
//!
//! `main.rs` writes them to files; a test compares the files with what is computed here.

mod cast;
mod drive;
mod map;
mod path;
mod story;

mod braking;

use std::error::Error;

use nearmiss::geometry::Point;
pub use story::{Made, Outcome};

/// Every bundled scenario, in the order of the bundle.
pub fn all() -> Result<Vec<Made>, Box<dyn Error>> {
    let stories = [braking::story];
    stories.iter().map(|story| story()?.make()).collect()
}

/// To four decimals, a tenth of a millimetre, and without a negative zero.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4 + 0.0
}

fn place(p: Point) -> Point {
    Point::new(rounded(p.x), rounded(p.y))
}
