//! Bodies that are too small to be drawn, as arrows, and the room that words leave to the others.

use ratatui::style::{Modifier, Style};

use super::label_placer::{Body, LabelPlacer};
use nearmiss_render::cells::{Appearance, CellView, Heading, heading_arrow};
use nearmiss_render::scene::{Importance, MapScene, Owner};

/// Bodies that are too small for their heading to show are arrows, the ego on top.
pub fn arrows(
    board: &mut LabelPlacer<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    let all = scene.bodies.iter().chain(&scene.ego);
    for body in all {
        let mut style = Style::new().fg(look.color(body.role));
        match Heading::new(look, view, body) {
            // Without colours nothing else marks the ego.
            Heading::Alone if body.owner == Owner::Ego && !look.has_colors() => {
                style = style.add_modifier(Modifier::REVERSED);
            }
            Heading::Alone => {}
            Heading::OnBody if look.style.has_backgrounds() => {
                style = Style::new()
                    .fg(look.theme.map_ground)
                    .bg(look.color(body.role));
            }
            Heading::OnBody => style = style.add_modifier(Modifier::REVERSED),
            Heading::Windscreen | Heading::None => continue,
        }
        if body.importance >= Importance::Danger {
            style = style.add_modifier(Modifier::BOLD);
        }
        let pose = body.motion.pose;
        let middle = if body.stands {
            pose.position
        } else {
            body.point(body.part(0.5), 0.0)
        };
        let glyph = if body.stands {
            "▪"
        } else {
            heading_arrow(&view.turned(&pose.forward()))
        };
        board.put(view.at(&middle), glyph, style);
    }
}

/// Where the ego touches others: what matters most on the map.
pub fn contacts(
    board: &mut LabelPlacer<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    // Bodies are of the colour of danger, too: the sign has a background of its own.
    let style = Style::new()
        .fg(look.theme.danger)
        .bg(look.theme.background)
        .add_modifier(Modifier::BOLD);
    for contact in &scene.contacts {
        let at = view.at(&contact.at);
        // At the edge of the map there is less room.
        if !board.put(at, "─×─", style) {
            board.put(at, "×", style);
        }
    }
}

/// Keeps words off the bodies that have no name.
pub fn keep_clear(board: &mut LabelPlacer<'_>, scene: &MapScene<'_>, view: &CellView) {
    for body in &scene.bodies {
        let (x, y) = view.at(&body.motion.pose.position);
        let (_, width) = body.footprint.shape().size();
        let half = width.min(2.0 * body.footprint.reach()) / 2.0;
        let body = Body {
            x: (x - half, x + half),
            y: (y - half, y + half),
        };
        let cells = board.cells(&body);
        board.reserve(cells);
    }
}
