//! Areas of the last frame: written by drawing, read by mouse and page keys.

use std::cell::{Cell, RefCell};

use ratatui::layout::{Position, Rect};

use crate::action::Action;
use crate::model::{Border, Pane, ResultsDrawn, ShownAnswer, TextChanges};
use crate::widgets::long_text::Reading;
use nearmiss_base::geometry::Point;
use nearmiss_render::Picture;

/// Areas and texts of the last frame.
#[derive(Debug, Default)]
pub struct LastFrame {
    panes: RefCell<Vec<(Pane, Rect)>>,
    borders: RefCell<Vec<Border>>,
    texts: RefCell<Vec<(Pane, Extent)>>,
    maps: RefCell<Vec<MapDrawn>>,
    cramped: Cell<bool>,
    scales: RefCell<Vec<Rect>>,
    history: Cell<Option<HistoryDrawn>>,
    window_end: Cell<usize>,
    obstacles: Cell<usize>,
    results: RefCell<ResultsDrawn>,
    list: RefCell<Option<Rect>>,
    columns: RefCell<Vec<Extent>>,
    for_picture: Cell<bool>,
    picture: RefCell<Option<MapPicture>>,
    before_text: Cell<usize>,
    /// Long texts as they were drawn last.
    pub readings: RefCell<Readings>,
}

/// Long texts as last drawn, kept across frames so that unchanged text is not laid out again.
#[derive(Debug)]
pub struct Readings {
    /// The system's message of the prompt.
    pub system: Reading,
    /// The user's message.
    pub user: Reading,
    /// What an answer says otherwise than the one before.
    pub changes: TextChanges,
    /// The built-in judge's reasoning, then the answers by their columns.
    answers: Vec<Reading>,
}

impl Default for Readings {
    fn default() -> Self {
        Self {
            system: Reading::markdown(),
            user: Reading::markdown(),
            changes: TextChanges::default(),
            answers: Vec::new(),
        }
    }
}

impl Readings {
    /// An answer's text.
    pub fn answer(&mut self, shown: ShownAnswer) -> &mut Reading {
        let place = match shown {
            ShownAnswer::Reference => 0,
            ShownAnswer::Column(column) => column + 1,
        };
        if self.answers.len() <= place {
            self.answers.resize_with(place + 1, Reading::answer);
        }
        &mut self.answers[place]
    }
}

/// The history as it was drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HistoryDrawn {
    /// The rows of the list.
    pub list: Rect,
    /// The first row that is shown.
    pub top: usize,
    /// The text of the details.
    pub details: Rect,
    /// Its lines.
    pub lines: usize,
}

/// Lines of a text, and how many of them the pane shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Extent {
    /// All lines.
    pub lines: usize,
    /// Lines shown at once.
    pub rows: usize,
    /// First line shown.
    pub top: usize,
}

impl Extent {
    /// The first line where the last one is in sight.
    pub fn last_top(self) -> usize {
        self.lines.saturating_sub(self.rows)
    }

    /// The first line after an action that scrolls, by so many lines a page.
    pub fn scrolled(self, action: Action, page: usize) -> usize {
        self.moved(action.lines(page.cast_signed()))
    }

    /// The first line so many lines further down.
    pub fn moved(self, by: isize) -> usize {
        self.top.saturating_add_signed(by).min(self.last_top())
    }
}

/// A map as it was drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapDrawn {
    /// Whether it is the second one, beside that of the clock.
    pub second: bool,
    /// The cells of the map.
    pub area: Rect,
    /// The view's frame: forward is up.
    pub frame: nearmiss_base::geometry::Pose,
    /// Metres a cell is wide.
    pub cell: f64,
    /// Metres a cell is high.
    pub row: f64,
}

/// The map as a picture, to be made an image.
#[derive(Debug)]
pub struct MapPicture {
    /// What is on it.
    pub picture: Picture,
    /// Its resolution.
    pub dpi: f64,
    /// The columns and rows that it fills.
    pub cells: (u16, u16),
}

impl LastFrame {
    /// What is drawn until the next call is a picture of the screen, in which there are no images, or no longer.
    pub fn draw_for_picture(&self, on: bool) {
        self.for_picture.set(on);
    }

    /// Whether a picture of the screen is drawn.
    #[must_use]
    pub fn is_for_picture(&self) -> bool {
        self.for_picture.get()
    }

    /// The map is to be shown as this picture.
    pub fn set_picture(&self, picture: MapPicture) {
        *self.picture.borrow_mut() = Some(picture);
    }

    /// Whether the map is to be shown as a picture.
    #[must_use]
    pub fn has_picture(&self) -> bool {
        self.picture.borrow().is_some()
    }

    /// Takes the picture of the map that was drawn last.
    pub fn take_picture(&self) -> Option<MapPicture> {
        self.picture.borrow_mut().take()
    }

    /// Begins a new frame.
    pub fn clear(&self) {
        self.panes.borrow_mut().clear();
        self.borders.borrow_mut().clear();
        self.texts.borrow_mut().clear();
        self.maps.borrow_mut().clear();
        self.cramped.set(false);
        self.scales.borrow_mut().clear();
        self.history.set(None);
        *self.results.borrow_mut() = ResultsDrawn::default();
        *self.list.borrow_mut() = None;
        self.columns.borrow_mut().clear();
        self.before_text.set(0);
    }

    /// So many rows of the reasoning stand before the answer's text.
    pub fn set_before_text(&self, rows: usize) {
        self.before_text.set(rows);
    }

    /// The rows of the reasoning before the answer's text.
    #[must_use]
    pub fn before_text(&self) -> usize {
        self.before_text.get()
    }

    /// The history is here.
    pub fn set_history(&self, drawn: HistoryDrawn) {
        self.history.set(Some(drawn));
    }

    /// The history as it was drawn last.
    #[must_use]
    pub fn history(&self) -> HistoryDrawn {
        self.history.get().unwrap_or_default()
    }

    /// The line that the window of text on top is scrolled to at its end.
    pub fn set_window_end(&self, line: usize) {
        self.window_end.set(line);
    }

    /// The same as it was drawn last.
    #[must_use]
    pub fn window_end(&self) -> usize {
        self.window_end.get()
    }

    /// The line of the verdicts at which the table of obstacles begins.
    pub fn set_obstacles(&self, line: usize) {
        self.obstacles.set(line);
    }

    /// The same as it was drawn last.
    #[must_use]
    pub fn obstacles(&self) -> usize {
        self.obstacles.get()
    }

    /// The screen of results is here.
    pub fn set_results(&self, drawn: ResultsDrawn) {
        *self.results.borrow_mut() = drawn;
    }

    /// The screen of results as it was drawn last.
    #[must_use]
    pub fn results(&self) -> ResultsDrawn {
        self.results.borrow().clone()
    }

    /// A pane is here.
    pub fn pane(&self, pane: Pane, area: Rect) {
        self.panes.borrow_mut().push((pane, area));
    }

    /// These borders can be moved.
    pub fn set_borders(&self, borders: &[Border]) {
        self.borders.borrow_mut().extend_from_slice(borders);
    }

    /// The borders that can be moved.
    #[must_use]
    pub fn borders(&self) -> Vec<Border> {
        self.borders.borrow().clone()
    }

    /// The area of a pane; `None` if it is not shown.
    #[must_use]
    pub fn area(&self, pane: Pane) -> Option<Rect> {
        let panes = self.panes.borrow();
        panes
            .iter()
            .find(|(p, _)| *p == pane)
            .map(|(_, area)| *area)
    }

    /// A pane's text has this extent.
    pub fn text(&self, pane: Pane, extent: Extent) {
        self.texts.borrow_mut().push((pane, extent));
    }

    /// The next answer side by side has this extent.
    pub fn next_column(&self, extent: Extent) {
        self.columns.borrow_mut().push(extent);
    }

    /// The extent of an answer side by side, by its place.
    #[must_use]
    pub fn column(&self, place: usize) -> Extent {
        let columns = self.columns.borrow();
        columns.get(place).copied().unwrap_or_default()
    }

    /// A map is here.
    pub fn map(&self, map: MapDrawn) {
        self.maps.borrow_mut().push(map);
    }

    /// Whether there are two maps.
    #[must_use]
    pub fn has_second_map(&self) -> bool {
        self.maps.borrow().iter().any(|map| map.second)
    }

    /// There was no room for a second map.
    pub fn set_cramped(&self) {
        self.cramped.set(true);
    }

    /// Whether there was no room for a second map.
    #[must_use]
    pub fn is_cramped(&self) -> bool {
        self.cramped.get()
    }

    /// Whether something follows from what was drawn: an image is to be made, or a word is to be said.
    #[must_use]
    pub fn has_consequences(&self) -> bool {
        self.has_picture() || self.is_cramped()
    }

    /// The lines of the list of scenarios are here, without what stands above them.
    pub fn list(&self, area: Rect) {
        *self.list.borrow_mut() = Some(area);
    }

    /// The line of the list at a position of the screen.
    #[must_use]
    pub fn list_line(&self, at: Position) -> Option<usize> {
        let area = (*self.list.borrow()).filter(|area| area.contains(at))?;
        Some(usize::from(at.y - area.y) + self.extent(Pane::Scenarios).top)
    }

    /// Time runs across these cells, first to last step.
    pub fn time_scale(&self, area: Rect) {
        self.scales.borrow_mut().push(area);
    }

    /// First column and width of the time scale inside a pane; the whole pane where it has none.
    #[must_use]
    pub fn scale(&self, pane: Rect) -> (u16, u16) {
        let scales = self.scales.borrow();
        let inside = scales.iter().find(|s| s.intersects(pane));
        inside.map_or((pane.x, pane.width), |s| (s.x, s.width))
    }

    /// The pane at a position of the screen, with its area.
    #[must_use]
    pub fn pane_at(&self, at: Position) -> Option<(Pane, Rect)> {
        self.panes
            .borrow()
            .iter()
            .find(|(_, area)| area.contains(at))
            .copied()
    }

    /// The extent of a pane's text.
    #[must_use]
    pub fn extent(&self, pane: Pane) -> Extent {
        let texts = self.texts.borrow();
        texts
            .iter()
            .find(|(p, _)| *p == pane)
            .map(|(_, e)| *e)
            .unwrap_or_default()
    }

    /// The point of the world under a position of the screen.
    #[must_use]
    pub fn point_at(&self, at: Position) -> Option<(Point, f64)> {
        let map = self.map_at(at)?;
        let right = f64::from(at.x - map.area.x) + 0.5 - f64::from(map.area.width) / 2.0;
        let down = f64::from(at.y - map.area.y) + 0.5 - f64::from(map.area.height) / 2.0;
        let local = Point::new(-down * map.row, -right * map.cell);
        Some((map.frame.to_world(&local), map.cell))
    }

    /// The map at a position of the screen.
    #[must_use]
    pub fn map_at(&self, at: Position) -> Option<MapDrawn> {
        let maps = self.maps.borrow();
        maps.iter().find(|map| map.area.contains(at)).copied()
    }

    /// Columns and rows of the map.
    #[must_use]
    pub fn map_size(&self) -> (u16, u16) {
        let maps = self.maps.borrow();
        maps.first()
            .map_or((60, 25), |m| (m.area.width, m.area.height))
    }
}
