//! What signs of 2024 say: in the map, and anew in the dynamic file.

use super::messages::MapSignElement;
use super::report::{At, Report};
use super::signs::{Sign2024, of_2024};
use super::values::texts;
use crate::scenario::SignElement;
use crate::scenario::commonroad::ReadError;
use crate::scenario::commonroad::xml::short;

/// What is on a post; `country` is that of the map.
pub(super) fn elements(
    r: &mut Report,
    at: &At<'_>,
    messages: &[MapSignElement],
    country: &str,
) -> Result<Vec<SignElement>, ReadError> {
    let mut found = Vec::with_capacity(messages.len());
    for (i, message) in messages.iter().enumerate() {
        let at = at.nth("traffic_sign_elements", i);
        let place = r.need(&at, "element_id", message.element_id)?;
        let id = match of_2024(country, place) {
            Sign2024::Own(id) => id,
            Sign2024::German(id) => {
                let country = short(country);
                r.warn(
                    &at,
                    format!("{country} has no number for this sign; the German {id} was taken"),
                );
                id
            }
            Sign2024::Unknown => {
                r.warn(&at, "an unknown sign; its number was left empty");
                ""
            }
        };
        found.push(SignElement {
            id: id.to_string(),
            values: texts(r, &at, "additional_values", &message.additional_values),
        });
    }
    Ok(found)
}
