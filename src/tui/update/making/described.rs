//! A search for an attack that words describe.

use super::{ready, request, still_searching};
use crate::tui::model::Model;
use crate::tui::screens::wish;

/// Asks for the words that describe an attack.
pub fn ask(model: &mut Model) {
    if still_searching(model) {
        return;
    }
    let Some((hash, change)) = ready(model) else {
        return;
    };
    let seed = model.maker.next_seed(hash, None);
    if let Some((place, request)) = request(model, change, None, seed, None) {
        wish::open(model, place, request);
    }
}
