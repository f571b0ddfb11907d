//! Panes beside a panel at the right.

use ratatui::layout::Rect;

use super::arranged::{Arranged, NARROW};
use crate::model::Pane;

impl Arranged {
    /// Ends the panes at a column, where a panel stands. One that becomes too narrow gives its place to the pane on its
    /// left; the map and its timeline take the place of that pane instead.
    pub fn end_at(&mut self, column: u16) {
        for (_, area) in &mut self.panes {
            area.width = area.width.min(column.saturating_sub(area.x));
        }
        let narrow = |(_, area): &&(Pane, Rect)| area.width < NARROW && area.right() >= column;
        let shows_map = |pane: Pane| matches!(pane, Pane::Map | Pane::Timeline);
        let map = self
            .panes
            .iter()
            .filter(narrow)
            .find(|(p, _)| shows_map(*p));
        if let Some(left) = map.map(|(_, area)| area.x) {
            let before = self.panes.iter().filter(|(_, area)| area.right() == left);
            let from = before.map(|(_, area)| area.x).min().unwrap_or(left);
            self.panes.retain(|(_, area)| area.right() != left);
            for (_, area) in self.panes.iter_mut().filter(|(_, area)| area.x == left) {
                area.x = from;
                area.width = column - from;
            }
        }
        let narrow = self.panes.iter().filter(narrow).map(|(_, area)| area.x);
        if let Some(left) = narrow.min() {
            self.panes.retain(|(_, area)| area.x < left);
            for (_, area) in self
                .panes
                .iter_mut()
                .filter(|(_, area)| area.right() == left)
            {
                area.width = column - area.x;
            }
        }
        // They stand where they were until the panel closes.
        self.borders.clear();
    }
}
