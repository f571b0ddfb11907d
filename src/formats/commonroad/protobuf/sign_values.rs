//! Sign values of 2024: in the map, and updated in the dynamic file.

use super::messages::MapSignElement;
use super::report::FieldPath;
use super::signs::{Sign2024, of_2024};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::commonroad::xml::short;
use nearmiss_scene::scenario::SignElement;

/// The sign elements on a post; `country` is that of the map.
pub(super) fn elements(
    at: &FieldPath<'_>,
    messages: &[MapSignElement],
    country: &str,
) -> Result<Vec<SignElement>, ReadError> {
    let element = |(i, message): (usize, &MapSignElement)| {
        let at = at.nth("traffic_sign_elements", i);
        let place = at.need("element_id", message.element_id)?;
        let id = match of_2024(country, place) {
            Sign2024::Own(id) => id,
            Sign2024::German(id) => {
                let country = short(country);
                at.warn(format!(
                    "{country} has no number for this sign; the German {id} is used"
                ));
                id
            }
            Sign2024::Unknown => {
                at.warn("an unknown sign; its number was left empty");
                ""
            }
        };
        Ok(SignElement {
            id: id.to_string(),
            values: at.texts("additional_values", &message.additional_values),
        })
    };
    messages.iter().enumerate().map(element).collect()
}
