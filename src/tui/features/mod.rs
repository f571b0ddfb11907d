//! Screens and windows that open over the main screen: one file each, behind the trait [`Screen`].
//!
//! A new one is a file here, its `mod` and its line in [`open`], and its action's row in `action/default_keys.rs`.

pub mod about;
pub mod answers;
pub mod batch;
pub mod compare;
pub mod coverage;
pub mod details;
pub mod drivers;
pub mod experiment;
pub mod generation;
pub mod help;
pub mod history;
pub mod index;
pub mod jobs;
pub mod map;
pub mod models;
pub mod palette;
pub mod picker;
pub mod pictures;
pub mod planner;
pub mod plot;
pub mod prompt;
pub mod results;
pub mod scenarios;
mod screen;
pub mod source;
pub mod themes;
pub mod timeline;
pub mod tour;
pub mod values;

use super::action::Action;
use super::message::Effect;
use super::model::Model;
use generation::panel;
use planner::cycle;
use prompt::saving;
use scenarios::tags;
pub(crate) use screen::{PAGE, WHEEL};
pub use screen::{Screen, Screens, Step, act, moves_scene};

/// Opens the screen of an action, or says why it stays closed; `None` for other actions. An action of a screen opens
/// the screen where it is not on top, and does nothing else.
pub fn open(model: &mut Model, action: Action) -> Option<Vec<Effect>> {
    use Action::*;
    match action {
        Help => help::open(model),
        About => model.screens.open(about::AboutScreen::default()),
        Values => model.screens.open(values::ValuesScreen::default()),
        Details => details::open(model),
        Drivers => drivers::open(model),
        PlannerCycle => cycle::open(model),
        VariantPanel => panel::open(model),
        Layers => model.screens.open(map::LayersScreen::default()),
        Palette => picker::open(model, palette::Palette),
        PickTheme => themes::open(model),
        ChooseModel => picker::open(model, models::Models { ask: false }),
        Compare => picker::open(model, models::Models { ask: true }),
        PlotMeasure => picker::open(model, plot::Measures),
        SortScenarios => picker::open(model, scenarios::Orders),
        SavePicture => pictures::open(model),
        ChooseTemplate => picker::open(model, saving::Templates),
        EditTags => tags::open(model),
        Source => return Some(source::open(model)),
        History => return Some(history::open(model)),
        ReopenRun | SearchRuns | PinRun | DeleteRun | UndoDelete | NoteRun | CopyRun
        | ExportRuns | OtherHalf
            if !model.screens.is_top::<history::HistoryScreen>() =>
        {
            return Some(history::open(model));
        }
        TaskList => jobs::open(model),
        CancelJob | CancelAllJobs | ShowJob if !model.screens.is_top::<jobs::JobsScreen>() => {
            jobs::open(model);
        }
        Coverage => coverage::open(model),
        CoverageLeft | CoverageRight | OpenCoverage | NextSeverity | CoverageWindows
            if !model.screens.is_top::<coverage::CoverageScreen>() =>
        {
            coverage::open(model);
        }
        Results => return Some(results::open(model)),
        CellLeft | CellRight | OpenCell | ChooseCounted | ChangeTruth | SortResults
        | ExportResults
            if !model.screens.is_top::<results::ResultsScreen>() =>
        {
            return Some(results::open(model));
        }
        _ => return None,
    }
    Some(Vec::new())
}
