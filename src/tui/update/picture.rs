//! Saves pictures of the current view.

use super::super::model::Model;

/// Says where a picture is, or why there is none.
pub fn saved(model: &mut Model, saved: Result<String, String>) {
    match saved {
        Ok(path) => model.say(format!("saved as {path}")),
        Err(error) => model.complain(format!("no picture: {error}")),
    }
}
