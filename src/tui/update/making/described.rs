//! A search for an attack that terms describe.

use super::{ready, request, still_searching};
use crate::model::Model;
use crate::screens::wish;

/// Asks for the terms that describe an attack.
pub fn ask(model: &mut Model) {
    if still_searching(model) {
        return;
    }
    let Some((hash, change)) = ready(model) else {
        return;
    };
    // The seed is chosen when the search begins: a line that is closed uses none up.
    if let Some((place, request)) = request(model, change, None, 0, None) {
        wish::open(model, place, hash, request);
    }
}
