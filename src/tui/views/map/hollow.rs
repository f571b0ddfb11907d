//! Names beside hollow bodies.

use ratatui::style::{Modifier, Style};

use super::label_placer::{Body, LabelPlacer};
use nearmiss_render::cells::{Appearance, CellView};
use nearmiss_render::scene::MapScene;

/// Names hollow bodies.
pub fn names(
    board: &mut LabelPlacer<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    for (name, outline) in scene.hollow() {
        let corners = outline.rings.iter().flatten().map(|p| view.at(p));
        if let Some(body) = Body::around(corners) {
            let cells = board.cells(&body);
            let style = Style::new().fg(look.color(outline.role));
            board.beside(&cells, name, style.add_modifier(Modifier::BOLD));
        }
    }
}
