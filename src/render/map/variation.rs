//! The two motions of a variant's attacker over each other: as recorded dashed, as changed a thick line, and the body that
//! is not driven in what is drawn hollow.

use super::Map;
use super::bodies::{rings, spots};
use crate::render::Color;
use crate::render::display::{Area, Picture, Stroke};
use crate::render::view::Variation;

/// Both ways from where they part.
pub fn ways(map: &Map<'_>, picture: &mut Picture) {
    let Some(both) = map.variation else { return };
    let after = both.from..i64::MAX;
    let recorded = spots(map, both.recorded.track(), after.clone());
    let dashed = Stroke::new(map.palette.dim, 0.8).dashed(&[2.4, 1.6]);
    picture.line(&recorded, dashed);
    let changed = spots(map, both.changed.track(), after);
    picture.line(&changed, Stroke::new(color(map, &both), 1.4).rounded());
}

/// The body that would be elsewhere, where the two are not in one place.
pub fn body(map: &Map<'_>, picture: &mut Picture) {
    let Some((both, rings)) = hollow(map) else {
        return;
    };
    let color = match both.shows_changed {
        true => map.palette.dim,
        false => color(map, &both),
    };
    for ring in &rings {
        picture.polygon(ring, None, Some(Stroke::new(color, 0.8).rounded()));
    }
}

/// What that body is called, its colour, and where it is.
pub fn name(map: &Map<'_>) -> Option<(String, Color, Area)> {
    let (both, rings) = hollow(map)?;
    let around = Area::around(&rings.concat()).filter(|around| map.shows(around))?;
    Some(match both.shows_changed {
        true => (
            format!("{} recorded", both.recorded.id),
            map.palette.dim,
            around,
        ),
        false => (
            format!("{} changed", both.changed.id),
            color(map, &both),
            around,
        ),
    })
}

type Rings = Vec<Vec<(f64, f64)>>;

fn hollow<'a>(map: &Map<'a>) -> Option<(Variation<'a>, Rings)> {
    let both = map.variation.filter(|both| map.step > both.from)?;
    let obstacle = match both.shows_changed {
        true => both.recorded,
        false => both.changed,
    };
    let motion = map.subject.motion(obstacle, map.step)?;
    let body = obstacle.footprint_at(map.step)?;
    Some((both, rings(map, body, motion)))
}

fn color(map: &Map<'_>, both: &Variation<'_>) -> Color {
    let place = map.emphasis(both.changed.id);
    place.map_or(map.palette.text, |place| map.palette.emphasised(place))
}
