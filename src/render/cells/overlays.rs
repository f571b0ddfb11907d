//! Lines and hollow bodies over the traffic: predictions, the planner's view, a variant's motions, the tape.

use super::canvas::Canvas;
use super::lines::{outlines, styled};
use super::{Appearance, CellView};
use crate::scene::{LineStyle, Outline, Overlay};

/// Draws them; thick lines cover what was drawn before.
pub fn draw(canvas: &mut Canvas<'_>, look: &Appearance<'_>, overlays: &[Overlay], view: &CellView) {
    for overlay in overlays {
        match overlay {
            Overlay::Path(path) => {
                if path.style == LineStyle::Thick {
                    canvas.layer();
                }
                if view.sees_any(&path.points) {
                    styled(
                        canvas,
                        view,
                        &path.points,
                        path.style,
                        look.color(path.role),
                    );
                }
            }
            Overlay::Outline(Outline {
                role, faint, rings, ..
            }) => {
                let color = look.color(*role);
                if !view.sees_any(rings.iter().flatten()) {
                    continue;
                }
                if *faint {
                    for corner in rings.iter().flatten() {
                        canvas.point(view.at(corner), color);
                    }
                } else {
                    outlines(canvas, view, rings, color)
                }
            }
        }
    }
}
