//! Which action opens which screen.

use crate::action::Action;
use crate::features::generation::panel;
use crate::features::planner::cycle;
use crate::features::prompt::saving;
use crate::features::scenarios::{self, tags};
use crate::features::{
    about, coverage, details, help, history, jobs, map, models, palette, picker, pictures, plot,
    results, source, themes, values,
};
use crate::message::Effect;
use crate::model::Model;

/// Opens the screen of an action, or says why it stays closed; `None` for other actions. An action of a screen opens
/// the screen where it is not on top, and does nothing else.
pub fn open(model: &mut Model, action: Action) -> Option<Vec<Effect>> {
    use Action::*;
    match action {
        Help => model.screens.open(help::HelpScreen::default()),
        About => model.screens.open(about::AboutScreen::default()),
        Values => model.screens.open(values::ValuesScreen::default()),
        Details => details::open(model),
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
