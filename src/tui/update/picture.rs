//! Saves pictures of the current view.

use super::super::model::Model;

/// Says where a picture is, or why there is none.
pub fn saved(model: &mut Model, saved: Result<String, String>) {
    match saved {
        // Long enough to read a path, whatever key comes next.
        Ok(path) => model.tell(format!("saved as {path}")),
        Err(error) => model.complain(format!("no picture: {error}")),
    }
}
