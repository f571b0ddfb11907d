//! Where the ego and another body touch at this step: a ring around the place.

use super::Map;
use crate::display::{Area, Picture, Spot, Stroke};

/// Marks every contact; gives what the marks cover.
pub fn draw(map: &Map<'_>, picture: &mut Picture) -> Vec<Area> {
    let contacts = map.scene.contacts.iter();
    let marks = contacts.map(|contact| mark(map, picture, map.view.at(&contact.at)));
    marks.collect()
}

/// A ring with rays.
fn mark(map: &Map<'_>, picture: &mut Picture, (x, y): Spot) -> Area {
    let (palette, inner, outer) = (map.palette, 4.2, 7.0);
    let ring = Stroke::new(palette.danger, 1.1);
    let halo = Stroke::new(palette.background.at(0.85), 2.4);
    picture.circle((x, y), inner, None, Some(halo.clone()));
    let rays: Vec<[Spot; 2]> = (0..8)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * (f64::from(i) + 0.5) / 8.0).sin_cos();
            [
                (x + 5.2 * cos, y + 5.2 * sin),
                (x + outer * cos, y + outer * sin),
            ]
        })
        .collect();
    for ray in &rays {
        picture.line(ray, halo.clone());
    }
    picture.circle((x, y), inner, None, Some(ring.clone()));
    for ray in &rays {
        picture.line(ray, ring.clone());
    }
    Area {
        x: x - outer,
        y: y - outer,
        width: 2.0 * outer,
        height: 2.0 * outer,
    }
}
