//! Lines and hollow bodies over the traffic.

use super::Map;
use crate::display::{Picture, Stroke};
use crate::scene::{LineStyle, Outline, Overlay};

/// Draws them.
pub fn draw(map: &Map<'_>, picture: &mut Picture, overlays: &[Overlay]) {
    for overlay in overlays {
        match overlay {
            Overlay::Path(path) => {
                let color = map.color(path.role);
                let stroke = match path.style {
                    LineStyle::Thick => Stroke::new(color, 1.4).rounded(),
                    LineStyle::Solid => Stroke::new(color, 0.8).rounded(),
                    LineStyle::Dashed => Stroke::new(color, 0.8).dashed(&[2.4, 1.6]),
                    LineStyle::Dotted | LineStyle::Crossed => {
                        Stroke::new(color, 0.8).dashed(&[0.8, 2.4])
                    }
                };
                picture.line(&map.view.all(&path.points), stroke);
            }
            Overlay::Outline(Outline { role, rings, .. }) => {
                let stroke = Stroke::new(map.color(*role), 0.8).rounded();
                for ring in map.rings(rings) {
                    picture.polygon(&ring, None, Some(stroke.clone()));
                }
            }
        }
    }
}
