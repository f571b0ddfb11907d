//! Handlers of the actions.

use crate::action::{Action, Scope};
use crate::features::answers::{self, claims};
use crate::features::compare::{self, rating};
use crate::features::{
    self, batch, drivers, experiment, generation, index, jobs, map, planner, plot, prompt,
    scenarios, timeline,
};
use crate::message::Effect;
use crate::model::{Model, Notice, Pane, PromptView, ShownAnswer, Toast};
use crate::session::restore;
use crate::update::keys::scroll;
use crate::update::{keys as on_screen, open_current, opening, pointer};

/// Does it.
pub fn perform(model: &mut Model, action: Action) -> Vec<Effect> {
    use Action::*;
    features::tour::follow(model, action);
    if let Some(effects) = features::open(model, action) {
        return effects;
    }
    match action {
        Quit => return close_or_leave(model),
        Cancel => return cancel(model),
        Suspend => return vec![Effect::Suspend],
        Mouse => {
            model.mouse = !model.mouse;
            let words = if model.mouse {
                "mouse on"
            } else {
                "mouse off: the terminal has it"
            };
            model.say(words);
            return vec![Effect::UseMouse(model.mouse)];
        }
        ReadThresholds => return vec![crate::features::values::ReadThresholds.into()],
        Mark => plot::mark(model),
        NextPane => focus_next(model, 1),
        PreviousPane => focus_next(model, Pane::ALL.len() - 1),
        Zoom => model.zoomed = !model.zoomed,
        WidenPane | NarrowPane | TallerPane | LowerPane => pointer::resize(model, action),
        EvenPanes => pointer::reset(model),
        FocusLeft | FocusDown | FocusUp | FocusRight => pointer::go(model, action),
        Filter => scenarios::begin(model),
        Choose => return scenarios::choose(model),
        GroupScenarios => scenarios::group(model),
        TurnOrder => scenarios::turn(model),
        ChooseIndex => return index::perform(model),
        NextDifference => timeline::next_difference(model),
        NextDisagreement => return timeline::next_disagreement(model),
        HeatStrips => timeline::next_heat(model),
        Up | Down | PageUp | PageDown | Top | Bottom => return moved(model, action),
        StepForward | StepBack | JumpForward | JumpBack | FirstStep | LastStep | Play | Faster
        | Slower | MinimumStep | CollisionStep | ContactStep | Loop => {
            timeline::clock(model, action)
        }
        PlaceBack => return opening::go(model, true),
        PlaceForward => return opening::go(model, false),
        PaneMain => return main_thing(model),
        ZoomIn | ZoomOut | PanLeft | PanRight | PanUp | PanDown | Follow | EgoUp | FitMap => {
            map::move_map(model, action);
        }
        SplitMap | DriverMap | PinMoment | MomentBack | MomentForward => {
            map::perform(model, action)
        }
        NextDriver => drivers::next(model),
        NextPaths => map::next_paths(model),
        TakeTape => map::tape(model),
        SwapTape if model.map.tape.is_some() => map::swap_tape(model),
        SwapTape => return perform(model, Details),
        NextObstacle => map::pick(model, 1),
        PreviousObstacle => map::pick(model, -1),
        TakeAsEgo => return map::take_as_ego(model),
        RecordedEgo => return map::recorded_ego(model),
        DrivePlanner | NextForecast | NextPlanner | PlotDrives | SaveDrive | Generate
        | GenerateWith | GenerateWish | ModelAttacks | ModelAttacksWith | SwitchVariant
        | SaveVariant => {
            if !matches!(action, SaveDrive | SaveVariant) {
                // What is planned or made is seen on the main screen.
                compare::close(model);
            }
            return planner::perform(model, action);
        }
        ToggleTask | ToggleFrame | ToggleCp | ToggleCot | ToggleIcl | ToggleTools => {
            return toggle(model, action);
        }
        PromptView if prompt::is_hidden(model) => model.focus = Pane::Prompt,
        PromptView => {
            model.prompt.view = model.prompt.view.next();
            model.prompt.scroll = 0;
            model.compare();
        }
        Edit => prompt::begin(model),
        OutsideEditor => return prompt::open_outside(model),
        EditDone | SaveTemplate | SaveTemplateAs | Find | GoToLine | Turn | Undo | Redo | Cut
        | CopySelection | PasteCopied | SelectAll => return prompt::perform(model, action),
        DiscardDraft => return prompt::reset(model),
        RereadTemplates => return vec![crate::features::prompt::request::RereadTemplates.into()],
        Run => return answers::ask(model, false),
        RunAnew => return answers::ask(model, true),
        NextAnswer | PreviousAnswer => {
            for _ in 0..model.look.times() {
                model.answers.cycle(action == NextAnswer);
            }
        }
        CloseAnswer => return answers::close(model),
        NextClaim | PreviousClaim => {
            claims::read_on(model, action == NextClaim);
        }
        CompareScreen => compare::open(model),
        BlindMode => return rating::toggle_blind(model),
        CompareLeft | CompareRight | LinkScrolling | MoreColumns | FewerColumns | BestFirst
        | BestSecond | BestThird | BestFourth | RateTie | RateAllWrong | MarkWrong | NextRound
        | Ratings => return compare::perform(model, action),
        Copy => return copy(model),
        MarkScenario => batch::mark(model),
        UnmarkScenarios => model.marks.clear(),
        AskMarked => return batch::propose(model),
        SavedViews => return scenarios::perform(model),
        RawAnswer => model.toggle_raw(),
        UnfoldJson => model.toggle_json(),
        Experiment => return experiment::open(model),
        NewExperiment => return experiment::write_new(model),
        Accept if model.experiment.confirming => return experiment::run(model),
        RunExperiment | StopExperiment | ExperimentResults | EditExperiment | ExperimentText
        | ExperimentPart | RereadExperiment => return experiment::perform(model, action),
        CancelJob | CancelAllJobs => return jobs::perform(model, action),
        // The others open a screen, or are done by the one on top.
        _ => {}
    }
    Vec::new()
}

/// Ctrl-C: what runs is cancelled first, then what is open is closed, then the program ends if it is pressed again.
pub fn interrupt(model: &mut Model) -> Vec<Effect> {
    if model.prompt.editing && model.prompt.editor.selection().is_some() {
        return prompt::perform(model, Action::CopySelection);
    }
    if model.compare.open && model.screens.is_empty() {
        return compare::interrupt(model);
    }
    let aborted = answers::abort_all(model);
    if !aborted.is_empty() {
        return aborted;
    }
    if model.prompt.editing || !model.screens.is_empty() || model.list.filtering.is_some() {
        return cancel(model);
    }
    // An answer may have ended just as the user was about to cancel it.
    twice(model, "Ctrl-C again quits".into())
}

/// The main thing of a pane with text, and of the plot.
fn main_thing(model: &mut Model) -> Vec<Effect> {
    if model.focus == Pane::Verdict
        && let Some(next) = answers::pick(model)
    {
        return match next {
            Action::Details => perform(model, next),
            _ => Vec::new(),
        };
    }
    let action = match model.focus {
        Pane::Prompt => Action::Edit,
        Pane::Verdict => Action::CompareScreen,
        Pane::Reasoning => Action::NextClaim,
        Pane::Plot => Action::PlotMeasure,
        Pane::Scenarios => Action::Choose,
        Pane::Map | Pane::Timeline => Action::Details,
    };
    perform(model, action)
}

/// The key that quits closes the window on top; without one it leaves.
fn close_or_leave(model: &mut Model) -> Vec<Effect> {
    if !model.screens.is_empty() {
        return on_screen::close_top(model);
    }
    if model.compare.open {
        return compare::perform(model, Action::Cancel);
    }
    leave(model)
}

/// The key that quits the program: where something is paid for that has not arrived yet, or a draft or variants would
/// be lost, it is asked again.
fn leave(model: &mut Model) -> Vec<Effect> {
    let lost = model.prompt.lost && !model.prompt.drafted().is_empty();
    let questions = match model.jobs.asking() {
        0 => None,
        1 => Some("1 question is running".to_string()),
        n => Some(format!("{n} questions are running")),
    };
    let variants = match model.generation.unsaved() {
        0 => None,
        1 => Some("1 variant is not saved".to_string()),
        n => Some(format!("{n} variants are not saved")),
    };
    let asks = questions.is_some();
    let draft = lost.then(|| "the draft cannot be kept".to_string());
    let what: Vec<String> = [questions, draft, variants].into_iter().flatten().collect();
    if what.is_empty() {
        return quit(model);
    }
    let then = match what.len().max(model.generation.unsaved()) {
        _ if asks => "cancels and quits",
        1 => "quits without it",
        _ => "quits without them",
    };
    let key = model.look.key(Action::Quit);
    twice(model, format!("{}; {key} again {then}", what.join(", ")))
}

/// Quits on the second press within a while, and announces that on the first.
fn twice(model: &mut Model, words: String) -> Vec<Effect> {
    if model.quit_within > 0.0 {
        return quit(model);
    }
    model.quit_within = AGAIN;
    model.toasts.retain(|t| t.kind != Notice::Reply);
    model.toasts.push(Toast {
        text: words,
        kind: Notice::Reply,
        left: AGAIN,
        shown: 0.0,
    });
    Vec::new()
}

/// Seconds within which the key has to be pressed again to quit.
const AGAIN: f64 = 2.0;

/// Leaves; the draft is kept for the next start.
pub fn quit(model: &mut Model) -> Vec<Effect> {
    let mut effects = prompt::keep(model);
    effects.extend(restore::keep(model));
    effects.push(Effect::Quit);
    effects
}

/// Esc: the innermost thing that is open is closed.
pub fn cancel(model: &mut Model) -> Vec<Effect> {
    if !model.screens.is_empty() {
        return on_screen::on_action(model, Action::Cancel);
    }
    if model.prompt.editing {
        return prompt::end(model);
    }
    if model.list.filtering.is_some() {
        return scenarios::cancel(model);
    }
    if model.map.tape.take().is_some() {
        return Vec::new();
    }
    if model.zoomed {
        model.zoomed = false;
        return Vec::new();
    }
    if generation::asks_again(model) {
        return Vec::new();
    }
    let aborted = answers::abort_all(model);
    if aborted.is_empty() && !model.list.filter.is_empty() {
        scenarios::drop_kept(model);
    }
    aborted
}

fn focus_next(model: &mut Model, by: usize) {
    let now = Pane::ALL
        .iter()
        .position(|p| *p == model.focus)
        .unwrap_or(0);
    model.focus = Pane::ALL[(now + by) % Pane::ALL.len()];
}

fn moved(model: &mut Model, action: Action) -> Vec<Effect> {
    if model.focus.scope() == Scope::Scenarios {
        let page = model.drawn.extent(Pane::Scenarios).rows.max(2) - 1;
        let page = isize::try_from(page).unwrap_or(1);
        if let Some(line) = model.look.line(action) {
            let last = model.list.lines.len().saturating_sub(1);
            model.list.selected = line.min(last);
        } else {
            model.list.move_by(model.look.lines(action, page));
        }
        return open_current(model);
    }
    let pane = model.focus;
    if pane != Pane::Verdict || !answers::move_cursor(model, action) {
        scroll(model, pane, action);
    }
    Vec::new()
}

fn toggle(model: &mut Model, action: Action) -> Vec<Effect> {
    let mut effects = Vec::new();
    match action {
        Action::ToggleTask => {
            super::next(model);
            timeline::to_moment(model);
            // Answers to another question do not compare.
            let name = model
                .opened
                .as_ref()
                .map_or(String::new(), |o| o.name.clone());
            answers::leave(model, &name);
            model.answers.show(ShownAnswer::Reference);
            effects.extend(answers::load(model));
        }
        Action::ToggleFrame => {
            model.frame = model.next_frame();
            model.frame_chosen = Some(model.frame);
        }
        Action::ToggleTools => {
            model.tools = !model.tools;
            tools_switched(model);
        }
        _ => {
            model.techniques_chosen = true;
            let on = match action {
                Action::ToggleCp => &mut model.techniques.cp,
                Action::ToggleCot => &mut model.techniques.cot,
                _ => &mut model.techniques.icl,
            };
            *on = !*on;
        }
    }
    model.refresh();
    let way = model.way();
    model.answers.show_way(&way);
    effects
}

/// Says what the switched tools mean for the chosen model.
fn tools_switched(model: &mut Model) {
    let words = match (model.tools, answers::calls_tools(&model.model)) {
        (false, _) => "models are asked without tools".into(),
        (true, true) => format!("{} may call tools: {}", model.model, model.price()),
        (true, false) => {
            let key = model.look.key(Action::ChooseModel);
            format!(
                "tools on, but not for {}; {key} chooses a model",
                model.model
            )
        }
    };
    model.say(words);
}

fn copy(model: &mut Model) -> Vec<Effect> {
    let question = model.prompt.question.as_ref();
    let text = match model.focus {
        Pane::Prompt => match model.prompt.view {
            PromptView::Template => Some(model.prompt.text()),
            PromptView::Description => question.map(|q| q.description.clone()),
            PromptView::Diff => model.prompt.difference(),
            PromptView::Answer => answers::shown_text(model),
            PromptView::Rendered => {
                question.map(|q| format!("{}\n\n{}", q.prompt.system, q.prompt.user))
            }
        },
        Pane::Scenarios => model.opened.as_ref().map(|o| o.name.clone()),
        _ => answers::shown_text(model),
    };
    match text {
        Some(text) => {
            model.say(format!("{} characters copied", text.chars().count()));
            vec![Effect::Copy(text)]
        }
        None => Vec::new(),
    }
}
