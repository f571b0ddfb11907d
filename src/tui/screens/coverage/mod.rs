//! The coverage map of an index: windows by manoeuvre and road, the worst of a cell, and a filter of the list to it.

mod cell;
mod draw;

use std::sync::Arc;

use ratatui::Frame;
use ratatui::layout::Rect;

use self::cell::{CellChoice, CellDetail};
use super::{Screen, Step};
use crate::action::{Action, Scope};
use crate::message::{Effect, Mouse};
use crate::model::{Model, Pane, Place};
use crate::widgets::hints::{self, Hint};
use nearmiss_scene::corpus::{CorpusIndex, Manoeuvre, RoadType, SEVERITIES, WindowEgo};

/// The row and the column of all: behind those of one manoeuvre or road.
const ALL: (usize, usize) = (Manoeuvre::ALL.len(), RoadType::ALL.len());

/// The screen.
#[derive(Debug, Default)]
pub struct CoverageScreen {
    /// The selected cell.
    row: usize,
    column: usize,
    /// The severity that is counted alone.
    severity: Option<u8>,
    /// The selected window of the cell, while the keys are there.
    inside: Option<usize>,
    /// What is said of the cell.
    detail: Option<CellDetail>,
}

/// Opens the screen on the first cell that has windows.
pub fn open(model: &mut Model) {
    let mut screen = CoverageScreen::default();
    if let Some(index) = model.list.index().ready() {
        let has_windows = |row: usize, column: usize| {
            let counts = index.counts(Some(Manoeuvre::ALL[row]), Some(RoadType::ALL[column]));
            counts.windows.iter().any(|windows| *windows > 0)
        };
        let cells = (0..ALL.0).flat_map(|row| (0..ALL.1).map(move |column| (row, column)));
        let first = cells
            .into_iter()
            .find(|(row, column)| has_windows(*row, *column));
        (screen.row, screen.column) = first.unwrap_or_default();
    }
    model.screens.open(screen);
}

impl Screen for CoverageScreen {
    fn scope(&self) -> Scope {
        Scope::Coverage
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        use Action::*;
        match action {
            Cancel if self.inside.take().is_some() => {}
            Cancel => return Step::close(),
            Up | Down | PageUp | PageDown | Top | Bottom => self.moved(model, action),
            CoverageLeft if self.inside.is_none() => self.column = self.column.saturating_sub(1),
            CoverageRight if self.inside.is_none() => self.column = (self.column + 1).min(ALL.1),
            NextSeverity if self.inside.is_none() => {
                self.severity = match self.severity {
                    None => Some(0),
                    Some(last) if usize::from(last) + 1 >= SEVERITIES => None,
                    Some(severity) => Some(severity + 1),
                };
            }
            CoverageWindows => {
                let windows = self.detail.as_ref().map_or(0, |detail| detail.worst.len());
                self.inside = match self.inside {
                    None if windows > 0 => Some(0),
                    None => {
                        model.say("there is no window in this cell");
                        None
                    }
                    Some(_) => None,
                };
            }
            OpenCoverage => return self.enter(model),
            CoverageLeft | CoverageRight | NextSeverity => {}
            _ => return Step::Ignored,
        }
        Step::stay()
    }

    fn on_mouse(&mut self, model: &mut Model, mouse: Mouse) -> Step {
        match mouse {
            Mouse::WheelUp(_) => self.moved(model, Action::Up),
            Mouse::WheelDown(_) => self.moved(model, Action::Down),
            Mouse::Press(_) | Mouse::Drag(_) | Mouse::Release(_) => {}
        }
        Step::stay()
    }

    fn follow(&mut self, model: &mut Model) -> Vec<Effect> {
        let Some(index) = model.list.index().ready() else {
            (self.detail, self.inside) = (None, None);
            return Vec::new();
        };
        let choice = self.choice();
        let is_true = |detail: &CellDetail| detail.is_of(index, choice, &model.list);
        if !self.detail.as_ref().is_some_and(is_true) {
            let detail = CellDetail::of(&Arc::clone(index), choice, &model.list);
            self.inside = match detail.worst.len() {
                0 => None,
                windows => self.inside.map(|place| place.min(windows - 1)),
            };
            self.detail = Some(detail);
        }
        Vec::new()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        draw::draw(frame, screen, model, self);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let idle: &[Action] = match (model.list.index().ready(), self.inside) {
            (None, _) => &[
                Action::Up,
                Action::Down,
                Action::CoverageLeft,
                Action::CoverageRight,
                Action::OpenCoverage,
                Action::CoverageWindows,
                Action::NextSeverity,
            ],
            (Some(_), None) => &[],
            (Some(_), Some(_)) => {
                let select = [Action::Up, Action::Down];
                let table = model
                    .look
                    .keymap
                    .key_in(Action::CoverageWindows, Scope::Coverage);
                let open = model
                    .look
                    .keymap
                    .key_in(Action::OpenCoverage, Scope::Coverage);
                return vec![
                    hints::pair(model, Scope::Coverage, select, "select"),
                    (open, "open".into()),
                    (table, "table".into()),
                    (model.look.key(Action::Cancel), "back".into()),
                ];
            }
        };
        hints::own_but(model, Scope::Coverage, idle)
    }
}

impl CoverageScreen {
    fn choice(&self) -> CellChoice {
        CellChoice {
            manoeuvre: Manoeuvre::ALL.get(self.row).copied(),
            road: RoadType::ALL.get(self.column).copied(),
            severity: self.severity,
        }
    }

    /// Moves within the windows of the cell, or to another manoeuvre.
    fn moved(&mut self, model: &Model, action: Action) {
        const PAGE: isize = 5;
        let lines = model.look.lines(action, PAGE);
        let moved = |place: usize, last: usize| place.saturating_add_signed(lines).min(last);
        match &mut self.inside {
            Some(place) => {
                let windows = self.detail.as_ref().map_or(0, |detail| detail.worst.len());
                *place = moved(*place, windows.saturating_sub(1));
            }
            None => self.row = moved(self.row, ALL.0),
        }
    }

    /// From the table to the list, filtered to the cell; from a window to its scenario.
    fn enter(&self, model: &mut Model) -> Step {
        let Some(index) = model.list.index().ready().cloned() else {
            return Step::CloseAndPerform(Action::ChooseIndex);
        };
        match self.inside {
            Some(place) => self.visit(model, &index, place),
            None => {
                let filter = self.choice().filter();
                model.list.set_filter(filter.clone());
                model.focus = Pane::Scenarios;
                let listed = model.list.visible.len();
                let words = model.list.index_share().words();
                let words = if words.is_empty() {
                    String::new()
                } else {
                    format!("; of the list, {words}")
                };
                let all = model.list.rows.len();
                model.say(format!("/{filter}: {listed} of {all} scenarios{words}"));
                Step::close()
            }
        }
    }

    /// Goes to a window: its ego, its obstacle, and the worst step.
    fn visit(&self, model: &mut Model, index: &CorpusIndex, place: usize) -> Step {
        let Some(worst) = self.detail.as_ref().and_then(|d| d.worst.get(place)) else {
            return Step::stay();
        };
        let scenario = &index.scenarios()[worst.scenario];
        let of_hash = |hash: &str| hash == scenario.hash;
        let mut rows = model.list.rows.iter();
        let row = rows.position(|row| row.facts().is_some_and(|facts| of_hash(&facts.hash)));
        let Some(row) = row else {
            let changed = model
                .list
                .rows
                .iter()
                .any(|row| row.entry.name == scenario.name);
            let words = if changed {
                "is in the list with other contents than in the index"
            } else {
                "is not in the list; start nearmiss with the folder that it is in"
            };
            model.say(format!("{} {words}", scenario.name));
            return Step::stay();
        };
        let window = worst.window.example;
        Step::Visit(Place {
            scenario: row,
            taken: match window.ego {
                WindowEgo::Recorded => None,
                WindowEgo::Obstacle(id) => Some(id),
            },
            step: window.worst_step,
            picked: Some(window.obstacle),
        })
    }
}
