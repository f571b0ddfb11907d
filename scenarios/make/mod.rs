//! The bundled scenarios: invented here, and computed rather than recorded.
//!
//! `main.rs` writes them to files; a test compares the files with what is computed here.

mod cast;
mod drive;
mod junction;
mod lane;
mod map;
mod path;
mod story;

mod braking;
mod cut_in;
mod jam_tail;
mod merge;
mod overtaking;
mod pedestrian;
mod red_light;
mod right_turn;

use std::error::Error;

use nearmiss::geometry::Point;
pub use story::Made;
#[allow(unused_imports, reason = "the tests look at it, the program does not")]
pub use story::Outcome;

/// Every bundled scenario, in the order of the bundle.
pub fn all() -> Result<Vec<Made>, Box<dyn Error>> {
    let stories = [
        braking::story,
        cut_in::story,
        red_light::story,
        overtaking::story,
        pedestrian::story,
        merge::story,
        right_turn::story,
        jam_tail::story,
    ];
    stories.iter().map(|story| story()?.make()).collect()
}

/// To four decimals, a tenth of a millimetre, and without a negative zero.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4 + 0.0
}

fn place(p: Point) -> Point {
    Point::new(rounded(p.x), rounded(p.y))
}
