//! Speed limits of versions up to 2018b, where lanelets carry numbers; later versions use signs.

use super::xml::Xml;
use nearmiss_scene::scenario::plausibility::limits::LARGEST_NUMBER;
use nearmiss_scene::scenario::{Lanelet, Severity, Sign, SignElement};

/// The German number of the sign for a maximum speed, which the reference reader takes in most countries.
const MAXIMUM_SPEED: &str = "274";

/// How far beyond the ids in use the reference reader numbers the signs it makes up.
const BEYOND: i64 = 10_000;

/// Makes a sign for every lanelet with a speed limit, numbered as the reference reader does it.
///
/// `used` is the largest id in the file.
pub(super) fn signs(xml: &mut Xml<'_>, lanelets: &mut [Lanelet], used: i64) -> Vec<Sign> {
    let limits = xml.take_speed_limits();
    let mut signs = Vec::with_capacity(limits.len());
    let mut last = used;
    for (id, limit, place) in limits {
        let Some(lanelet) = lanelets.iter_mut().find(|l| l.id == id) else {
            continue;
        };
        if limit.is_nan() || limit < 0.0 {
            let message = format!("speed limit {limit} m/s; left out");
            xml.note_at(Severity::Warning, &place, message);
            continue;
        }
        // Writers put the largest number that they know where there is no limit.
        if limit > LARGEST_NUMBER {
            let message = "so large a speed limit is taken as none".into();
            xml.note_at(Severity::Note, &place, message);
            continue;
        }
        last = last.saturating_add(1 + BEYOND);
        lanelet.signs.push(last);
        signs.push(Sign {
            id: last,
            elements: vec![SignElement {
                id: MAXIMUM_SPEED.into(),
                values: vec![limit.to_string()],
            }],
            position: lanelet.right.points.first().copied(),
            is_virtual: true,
        });
        let message = format!("speed limit {limit} m/s taken as sign {last}");
        xml.note_at(Severity::Note, &place, message);
    }
    signs
}

/// Counts speed limits of a version that has signs for them as not used.
pub(super) fn count_unused(xml: &mut Xml<'_>) {
    for (_, _, place) in xml.take_speed_limits() {
        xml.unused_at(&place);
    }
}
