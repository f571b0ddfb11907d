//! The coverage map of an index: windows by manoeuvre and road, the worst of a cell, and a filter of the list to it.

pub mod draw;

use std::collections::HashSet;
use std::sync::Arc;

use nearmiss_scene::corpus::{
    CellCounts, CellWindows, CorpusIndex, Manoeuvre, RoadType, SEVERITIES, WindowEgo,
};
use ratatui::Frame;
use ratatui::layout::Rect;

use crate::action::{Action, Scope};
use crate::features::{Screen, Step};
use crate::message::{Effect, Mouse};
use crate::model::{List, Model, Pane, Place};
use crate::widgets::hints::{self, Hint};

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
            let detail = CellDetail::new(&Arc::clone(index), choice, &model.list);
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
                let words = model.list.index_share().summary();
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

/// Windows that are listed of a cell at most.
const MAX_LISTED: usize = 100;

/// A cell; nothing of a kind means all of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct CellChoice {
    pub manoeuvre: Option<Manoeuvre>,
    pub road: Option<RoadType>,
    pub severity: Option<u8>,
}

/// A window of a cell, as the first of its scenario with that severity and type of obstacle.
#[derive(Debug, Clone)]
struct WorstWindow {
    /// Its scenario, by the place in the index.
    pub scenario: usize,
    /// Where it is, and how many are like it.
    pub window: CellWindows,
}

/// What is said of a cell.
#[derive(Debug, Clone)]
struct CellDetail {
    index: Arc<CorpusIndex>,
    choice: CellChoice,
    /// How many scenarios of the list were listed and read then.
    known: (usize, usize),
    /// Windows, and those that were asked about.
    pub windows: u64,
    pub asked: u64,
    /// Scenarios, and those of them that are in the list.
    pub scenarios: usize,
    pub listed: usize,
    /// The worst windows, one a scenario, severity and type of obstacle.
    pub worst: Vec<WorstWindow>,
}

impl CellChoice {
    fn holds(self, window: &CellWindows) -> bool {
        self.manoeuvre
            .is_none_or(|wanted| wanted == window.manoeuvre)
            && self.road.is_none_or(|wanted| wanted == window.road)
            && self.severity.is_none_or(|wanted| wanted == window.severity)
    }

    /// The filter of the list for it.
    pub fn filter(self) -> String {
        let manoeuvre = self
            .manoeuvre
            .map(|one| format!("manoeuvre:{}", one.name()));
        let road = self.road.map(|one| format!("road:{}", one.name()));
        let severity = self.severity.map(|one| format!("severity={one}"));
        let terms = [manoeuvre, road, severity].into_iter().flatten();
        match terms.collect::<Vec<_>>() {
            terms if terms.is_empty() => "has:index".into(),
            terms => terms.join(" "),
        }
    }

    /// Its windows and those asked about.
    pub fn sums(self, counts: &CellCounts) -> (u64, u64) {
        match self.severity.map(usize::from) {
            Some(severity) => (counts.windows[severity], counts.asked[severity]),
            None => (counts.windows.iter().sum(), counts.asked.iter().sum()),
        }
    }
}

impl CellDetail {
    /// Looks through the scenarios of an index.
    pub fn new(index: &Arc<CorpusIndex>, choice: CellChoice, list: &List) -> Self {
        let facts = list.rows.iter().filter_map(|row| row.facts());
        let listed: HashSet<&str> = facts.map(|facts| facts.hash.as_str()).collect();
        let (windows, asked) = choice.sums(&index.counts(choice.manoeuvre, choice.road));
        let mut detail = Self {
            index: Arc::clone(index),
            choice,
            known: (list.rows.len(), list.facts_read),
            windows,
            asked,
            scenarios: 0,
            listed: 0,
            worst: Vec::new(),
        };
        for (place, scenario) in index.scenarios().iter().enumerate() {
            let mut found = scenario
                .windows
                .iter()
                .filter(|w| choice.holds(w))
                .peekable();
            if found.peek().is_none() {
                continue;
            }
            detail.scenarios += 1;
            detail.listed += usize::from(listed.contains(scenario.hash.as_str()));
            detail.worst.extend(found.map(|window| WorstWindow {
                scenario: place,
                window: window.clone(),
            }));
            // Only the worst are kept, so that a cell of many scenarios takes no room.
            if detail.worst.len() > 2 * MAX_LISTED {
                detail.keep_worst();
            }
        }
        detail.keep_worst();
        detail
    }

    fn keep_worst(&mut self) {
        self.worst
            .sort_by_key(|one| (one.window.severity, one.scenario));
        self.worst.truncate(MAX_LISTED);
    }

    /// Whether it is still what would be said.
    pub fn is_of(&self, index: &Arc<CorpusIndex>, choice: CellChoice, list: &List) -> bool {
        Arc::ptr_eq(&self.index, index)
            && self.choice == choice
            && self.known == (list.rows.len(), list.facts_read)
    }
}
