//! Lines and hollow bodies over the traffic: predictions, the planner's view, a variant's motions, the tape.

use ratatui::style::{Modifier, Style};
use ratatui::widgets::canvas::{Context, Points};

use super::label_placer::{Body, LabelPlacer};
use super::lines::{outlines, styled};
use super::{CellView, Theme, color};
use crate::render::scene::{LineStyle, MapScene, Outline, Overlay};

/// Draws them; thick lines cover what was drawn before.
pub fn draw(ctx: &mut Context<'_>, theme: &Theme, overlays: &[Overlay], view: &CellView) {
    for overlay in overlays {
        match overlay {
            Overlay::Path(path) => {
                if path.style == LineStyle::Thick {
                    ctx.layer();
                }
                if view.sees_any(&path.points) {
                    styled(ctx, view, &path.points, path.style, color(theme, path.role));
                }
            }
            Overlay::Outline(Outline {
                role, faint, rings, ..
            }) => {
                let color = color(theme, *role);
                if !view.sees_any(rings.iter().flatten()) {
                    continue;
                }
                match faint {
                    false => outlines(ctx, view, rings, color),
                    true => {
                        let corners = rings.iter().flatten();
                        let coords: Vec<(f64, f64)> = corners.map(|p| view.at(p)).collect();
                        ctx.draw(&Points {
                            coords: &coords,
                            color,
                        });
                    }
                }
            }
        }
    }
}

/// Names hollow bodies.
pub fn names(board: &mut LabelPlacer<'_>, theme: &Theme, scene: &MapScene<'_>, view: &CellView) {
    for (name, outline) in scene.hollow() {
        let corners = outline.rings.iter().flatten().map(|p| view.at(p));
        if let Some(body) = Body::around(corners) {
            let cells = board.cells(&body);
            let style = Style::new().fg(color(theme, outline.role));
            board.beside(&cells, name, style.add_modifier(Modifier::BOLD));
        }
    }
}
