//! Results of all stored answers: a matrix of prompt configurations, the answers of a cell, and the source counted.

pub mod draw;
pub mod matrix;
pub mod request;
pub mod state;

use ratatui::Frame;
use ratatui::layout::Rect;

use crate::action::{Action, Scope};
use crate::features::results::request::{ResultsCommand, ResultsEvent, ResultsQuery};
use crate::features::{Screen, Step};
use crate::message::{Effect, Mouse};
use crate::model::{Model, PageId, RESULTS_COLUMNS};
use crate::widgets::hints::{self, Hint};

/// The screen of results; what it shows is kept in the model, so that it is there until the store is read again.
#[derive(Debug)]
pub struct ResultsScreen;

impl Screen for ResultsScreen {
    fn scope(&self) -> Scope {
        Scope::Results
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        use Action::*;
        let results = &mut model.results;
        let matrix = results.inside.is_none() && results.choosing.is_none();
        match action {
            Cancel => return back(model),
            OpenCell => return Step::Stay(enter(model)),
            Up | Down | PageUp | PageDown | Top | Bottom => moved(model, action),
            CellLeft if matrix => results.column = results.column.saturating_sub(1),
            CellRight if matrix => {
                results.column = (results.column + 1).min(RESULTS_COLUMNS - 1);
            }
            ChangeTruth => return Step::Stay(change_truth(model)),
            SortResults if matrix => results.sort_by_column(),
            ExportResults => return Step::Stay(export(model)),
            ChooseCounted if results.choosing.take().is_none() => {
                let now = results.counting;
                let place = results.offers.iter().position(|o| Some(o.counting) == now);
                results.choosing = Some(place.unwrap_or(0));
            }
            CellLeft | CellRight | ChooseCounted | SortResults => {}
            _ => return Step::Ignored,
        }
        Step::stay()
    }

    fn on_mouse(&mut self, model: &mut Model, mouse: Mouse) -> Step {
        Step::Stay(on_mouse(model, mouse))
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        draw::draw(frame, screen, model);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let back = || (model.look.key(Action::Cancel), "back".to_string());
        let results = &model.results;
        if results.choosing.is_some() {
            let enter = model.look.keymap.key_in(Action::OpenCell, Scope::Results);
            let select = [Action::Up, Action::Down];
            let select = hints::pair(model, Scope::Results, select, "select");
            return vec![select, (enter, "choose".into()), back()];
        }
        if results.inside.is_none() {
            return hints::own(model, Scope::Results);
        }
        let of_matrix = [Action::CellLeft, Action::CellRight, Action::SortResults];
        let mut hints = hints::own_but(model, Scope::Results, &of_matrix);
        hints.pop();
        hints.push(back());
        hints
    }
}

/// Opens the screen; what it showed before is there until the store is read.
pub fn open(model: &mut Model) -> Vec<Effect> {
    model.screens.open(ResultsScreen);
    let results = &mut model.results;
    results.inside = None;
    results.choosing = None;
    results.wanted = None;
    read(model)
}

/// Asks for the answers that are to be counted.
fn read(model: &mut Model) -> Vec<Effect> {
    let id = PageId(model.new_id());
    let entries = model.list.rows.iter().map(|row| row.entry.clone());
    let ask = ResultsCommand::Read(ResultsQuery {
        id,
        answers: model.results.chosen,
        truth: model.results.chosen_truth,
        entries: entries.collect(),
    });
    model.results.asked = id;
    model.results.reading = true;
    vec![ask.into()]
}

/// Compares the answers with another truth.
fn change_truth(model: &mut Model) -> Vec<Effect> {
    if !model.results.next_truth() {
        model.say(if model.results.reading {
            "the store is still being read"
        } else {
            "there is no other truth for these answers"
        });
        return Vec::new();
    }
    read(model)
}

/// Writes the table, once all of it is counted.
fn export(model: &mut Model) -> Vec<Effect> {
    let results = &model.results;
    if results.rows.is_empty() || results.reading {
        let why = if results.reading {
            "still counting; export when it is done"
        } else {
            "nothing to export"
        };
        model.say(why);
        return Vec::new();
    }
    let folder = model.config.pictures.clone();
    let ask = ResultsCommand::Export(results.rows.clone(), results.truth_words(), folder);
    vec![ask.into()]
}

/// A level back: from the list of what can be counted, or from the answers, to the matrix, from the matrix to the
/// main screen.
fn back(model: &mut Model) -> Step {
    let results = &mut model.results;
    results.wanted = None;
    if results.choosing.take().is_some() || results.inside.take().is_some() {
        return Step::stay();
    }
    // A reading still in progress is abandoned.
    model.results.asked = PageId(model.new_id());
    model.results.reading = false;
    Step::Close(vec![ResultsCommand::Stop.into()])
}

/// From the list of what can be counted to the matrix, from a cell to its answers, from an answer to its scenario.
fn enter(model: &mut Model) -> Vec<Effect> {
    let results = &mut model.results;
    if let Some(line) = results.choosing.take() {
        let Some(offer) = results.offers.get(line) else {
            return Vec::new();
        };
        results.chosen = Some(offer.counting);
        return read(model);
    }
    let answers = results.answers();
    let Some(place) = results.inside else {
        if answers.is_empty() {
            model.say("there is no answer in this cell");
        } else {
            results.inside = Some(0);
        }
        return Vec::new();
    };
    let Some(answer) = answers.get(place) else {
        return Vec::new();
    };
    let Some(run) = answer.run else {
        model.say("the store has no run of this question: nothing was sent");
        return Vec::new();
    };
    results.wanted = Some(run);
    vec![ResultsCommand::Run(run).into()]
}

/// Moves the selection.
fn moved(model: &mut Model, action: Action) {
    let rows = model.drawn.results().list.height;
    let page = isize::from(rows.cast_signed() - 1).max(1);
    model.results.move_by(model.look.lines(action, page));
}

/// The mouse: a click selects, a click on what is selected opens it, the wheel moves the selection.
fn on_mouse(model: &mut Model, mouse: Mouse) -> Vec<Effect> {
    let at = match mouse {
        Mouse::WheelUp(_) => {
            moved(model, Action::Up);
            return Vec::new();
        }
        Mouse::WheelDown(_) => {
            moved(model, Action::Down);
            return Vec::new();
        }
        Mouse::Press(at) => at,
        Mouse::Drag(_) | Mouse::Release(_) => return Vec::new(),
    };
    let drawn = model.drawn.results();
    let results = &mut model.results;
    let Some(row) = drawn.row(at) else {
        if let Some(row) = drawn.bar(at).filter(|row| *row < results.rows.len()) {
            results.selected = row;
        }
        return Vec::new();
    };
    let (lines, before) = match (results.choosing, results.inside) {
        (Some(line), _) => (results.offers.len(), line),
        (None, Some(place)) => (results.answers().len(), place),
        (None, None) => (results.rows.len(), results.selected),
    };
    if row >= lines {
        return Vec::new();
    }
    let mut again = row == before;
    match (&mut results.choosing, &mut results.inside) {
        (Some(line), _) => *line = row,
        (None, Some(place)) => *place = row,
        (None, None) => {
            let column = drawn.cell(at.x);
            again &= column == results.column;
            (results.selected, results.column) = (row, column);
        }
    }
    if again { enter(model) } else { Vec::new() }
}

/// Handles the store's answers.
pub fn on_event(model: &mut Model, event: ResultsEvent) -> Step {
    match event {
        ResultsEvent::Read(id, result) if id == model.results.asked => match result {
            Ok(read) => {
                model.results.error = None;
                model.results.take(*read);
            }
            Err(error) => {
                model.results.reading = false;
                model.results.judging = None;
                // Shown in place of the table where there is none.
                if !model.results.rows.is_empty() {
                    model.complain(error.clone());
                }
                model.results.error = Some(error);
            }
        },
        ResultsEvent::Judging(id, done) if id == model.results.asked => {
            // Threads may tell of an earlier one last.
            let judging = &mut model.results.judging;
            *judging = judging.map(|before| before.max(done));
        }
        ResultsEvent::Exported(Ok(files)) => model.say(format!("saved {files}")),
        ResultsEvent::Exported(Err(error)) => model.complain(format!("not saved: {error}")),
        ResultsEvent::Run(id, result) if model.results.wanted == Some(id) => {
            model.results.wanted = None;
            match result {
                Ok(Some(run)) => {
                    if !model.files_of(&run.question.scenario).is_empty() {
                        model.screens.close::<ResultsScreen>();
                    }
                    return Step::Reopen(run);
                }
                Ok(None) => model.say(format!("run {id} is no longer in the store")),
                Err(error) => model.complain(error),
            }
        }
        ResultsEvent::Read(..) | ResultsEvent::Judging(..) | ResultsEvent::Run(..) => {}
    }
    Step::stay()
}
