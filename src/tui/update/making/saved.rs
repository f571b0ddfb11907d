//! Goes from a variant that was opened from a file to its original.

use std::path::Path;

use crate::action::Action;
use crate::message::Effect;
use crate::model::Model;
use crate::update::opening;
use nearmiss_formats::{Entry, EntryLocation};

/// The original of the saved variant that is open, unless something was made of this in turn.
pub fn original(model: &Model) -> Option<Entry> {
    let (hash, change) = model.made_of()?;
    let none = model.variant().is_none() && model.maker.find(hash, change).is_none();
    let saved = model.opened.as_ref()?.saved.as_ref().filter(|_| none)?;
    let (entry, _) = saved.original.as_ref().ok()?;
    Some(entry.clone())
}

/// Opens the original of a saved variant, which joins the list where it is not there yet.
pub fn open(model: &mut Model, entry: Entry) -> Vec<Effect> {
    let name = entry.name.clone();
    let mut rows = model.list.rows.iter();
    let listed = rows.position(|row| same_place(&row.entry.place, &entry.place));
    let place = listed.unwrap_or_else(|| model.list.append(entry));
    let effects = opening::open(model, place, None);
    model.list.show(place);
    let back = model.look.key(Action::PlaceBack);
    model.tell(format!(
        "the original {name}; {back} goes back to the variant"
    ));
    effects
}

/// Whether two scenarios are the same file, whether or not its path begins with `./`.
fn same_place(a: &EntryLocation, b: &EntryLocation) -> bool {
    let parts = |path: &Path| -> Vec<_> {
        let parts = path.components().map(|part| part.as_os_str().to_owned());
        parts.filter(|part| part != ".").collect()
    };
    match (a, b) {
        (EntryLocation::File(a), EntryLocation::File(b)) => parts(a) == parts(b),
        (a, b) => a == b,
    }
}
