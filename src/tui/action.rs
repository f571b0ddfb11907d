//! The one table of actions: what can be done, what it is called, where it holds.
//!
//! Keys, footer, help and palette are all made from it.

/// Something a person can do; what it means is in [`ACTIONS`].
#[allow(missing_docs, reason = "the table has a sentence for each")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Action {
    Quit,
    Cancel,
    Help,
    About,
    Palette,
    NextPane,
    PreviousPane,
    Zoom,
    Up,
    Down,
    PageUp,
    PageDown,
    Top,
    Bottom,
    Choose,
    Filter,
    StepForward,
    StepBack,
    JumpForward,
    JumpBack,
    FirstStep,
    LastStep,
    Play,
    Faster,
    Slower,
    NearestStep,
    CollisionStep,
    ZoomIn,
    ZoomOut,
    PanLeft,
    PanRight,
    PanUp,
    PanDown,
    Follow,
    EgoUp,
    FitMap,
    PlotMeasure,
    Values,
    ReadThresholds,
    SortScenarios,
    Mark,
    NextObstacle,
    PreviousObstacle,
    TakeAsEgo,
    RecordedEgo,
    ToggleTask,
    ToggleFrame,
    ToggleCp,
    ToggleCot,
    ToggleIcl,
    PromptView,
    Edit,
    ResetTemplate,
    RereadTemplates,
    Run,
    RunAnew,
    Compare,
    SavePicture,
    ChooseModel,
    NextAnswer,
    PreviousAnswer,
    CloseAnswer,
    Copy,
    Mouse,
    Suspend,
}

/// Where an action holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Scope {
    /// Everywhere.
    Global,
    /// In the list of scenarios.
    Scenarios,
    /// On the map.
    Map,
    /// In panes with text.
    Text,
}

/// A line of the table.
#[derive(Debug)]
pub struct Entry {
    /// What to do.
    pub action: Action,
    /// A word for it, for the palette and keymap files.
    pub id: &'static str,
    /// A word or two, for the footer.
    pub short: &'static str,
    /// A sentence.
    pub doc: &'static str,
    /// Where it holds.
    pub scope: Scope,
    /// Keys, the first one shown first; empty for what is only in the palette.
    pub keys: &'static [&'static str],
    /// How early it stands in the footer; 0 is not in it.
    pub footer: u8,
}

macro_rules! table {
    ($($action:ident, $scope:ident, $id:literal, [$($key:literal),*], $footer:literal, $short:literal, $doc:literal;)+) => {
        /// Every action.
        pub const ACTIONS: &[Entry] = &[$(Entry {
            action: Action::$action, id: $id, short: $short, doc: $doc, scope: Scope::$scope,
            keys: &[$($key),*], footer: $footer,
        }),+];
    };
}

table! {
    StepBack, Global, "step-back", ["left"], 1, "step", "One time step back.";
    StepForward, Global, "step-forward", ["right"], 1, "step", "One time step forward.";
    Play, Global, "play", ["space"], 2, "play", "Play, or pause.";
    Run, Global, "run", ["r"], 3, "run", "Ask the chosen model, or show its answer from the store.";
    RunAnew, Global, "run-anew", ["shift-r"], 0, "anew", "Ask the chosen model anew, even where the store has its answer.";
    Compare, Global, "compare", ["c"], 9, "compare", "Choose another model and ask it too.";
    SavePicture, Global, "picture", ["o"], 0, "picture", "Save a picture of the map, the plot or the screen, or an animation.";
    ChooseModel, Global, "model", ["m"], 4, "model", "Choose the model that is asked.";
    Edit, Global, "edit", ["e"], 5, "edit prompt", "Edit the prompt template.";
    Filter, Global, "filter", ["/"], 6, "filter", "Filter the list of scenarios.";
    NextPane, Global, "next-pane", ["tab"], 10, "pane", "Go to the next pane.";
    PreviousPane, Global, "previous-pane", ["backtab"], 0, "pane back", "Go to the previous pane.";
    Help, Global, "help", ["?", "f1"], 7, "help", "All keys.";
    About, Global, "about", ["i"], 0, "about", "What is in the opened scenario, and what reading it had to assume.";
    Quit, Global, "quit", ["q", "ctrl-q"], 8, "quit", "Leave the program.";
    Palette, Global, "palette", [":", "ctrl-p"], 11, "palette", "All actions by name.";
    Cancel, Global, "cancel", ["esc", "ctrl-c"], 0, "cancel", "Close what is open, or cancel the running request; Ctrl-C quits when there is nothing to cancel.";
    Zoom, Global, "zoom-pane", ["z"], 0, "zoom", "Show the pane alone, or all of them again.";
    JumpBack, Global, "jump-back", ["shift-left", ","], 0, "-1 s", "Ten time steps back.";
    JumpForward, Global, "jump-forward", ["shift-right", "."], 0, "+1 s", "Ten time steps forward.";
    FirstStep, Global, "first-step", ["home", "0"], 0, "start", "Go to the first time step.";
    LastStep, Global, "last-step", ["end", "$"], 0, "end", "Go to the last time step.";
    Faster, Global, "faster", [">"], 0, "faster", "Play twice as fast.";
    Slower, Global, "slower", ["<"], 0, "slower", "Play half as fast.";
    NearestStep, Global, "nearest", [], 0, "nearest", "Go to the step of the smallest distance.";
    CollisionStep, Global, "worst", ["x"], 0, "worst", "Go to the first contact, or the step of the lowest risk score.";
    ToggleTask, Global, "task", ["t"], 0, "task", "Switch the task.";
    ToggleFrame, Global, "frame", ["f"], 0, "frame", "Switch to the next frame that the task has a template for.";
    ToggleCp, Global, "cp", ["1"], 0, "cp", "Contextual prompting on or off.";
    ToggleCot, Global, "cot", ["2"], 0, "cot", "Chain of thought on or off.";
    ToggleIcl, Global, "icl", ["3"], 0, "icl", "In-context examples on or off.";
    PromptView, Global, "prompt-view", ["v"], 0, "view", "Show the rendered prompt, the template, or the description.";
    ResetTemplate, Global, "reset-template", [], 0, "reset", "Discard the draft and the user's copy of the template.";
    RereadTemplates, Global, "reread-templates", [], 0, "reread", "Read the templates in your prompts folder again.";
    NextAnswer, Global, "next-answer", ["]"], 0, "answer", "Show the reasoning of the next answer.";
    PreviousAnswer, Global, "previous-answer", ["["], 0, "answer back", "Show the reasoning of the previous answer.";
    CloseAnswer, Global, "close-answer", ["d"], 0, "close", "Take the shown answer off the comparison; it stays in the store.";
    NextObstacle, Global, "next-obstacle", ["n"], 0, "obstacle", "Pick the next obstacle, the most dangerous first.";
    PreviousObstacle, Global, "previous-obstacle", ["shift-n"], 0, "obstacle back", "Pick the previous obstacle.";
    Mark, Global, "mark", ["b"], 0, "mark", "Plot the picked obstacle beside the others, or no longer.";
    PlotMeasure, Global, "plot", ["p"], 0, "plot", "Choose the measure that is plotted over time.";
    Values, Global, "values", ["shift-v"], 0, "values", "Every measure of the picked obstacle and of the scene at this step, and the thresholds.";
    ReadThresholds, Global, "read-thresholds", [], 0, "thresholds", "Read thresholds.toml again and measure anew.";
    SortScenarios, Global, "sort", ["s"], 0, "sort", "Sort the list of scenarios by a measure, the most dangerous first.";
    TakeAsEgo, Global, "take-as-ego", ["shift-e"], 0, "as ego", "Take the picked obstacle as the ego.";
    RecordedEgo, Global, "recorded-ego", ["backspace"], 0, "recorded ego", "Go back from an obstacle as the ego to the recorded one, or to that of --ego.";
    Follow, Global, "follow", ["w"], 0, "follow", "Keep the ego in the middle of the map, or not.";
    EgoUp, Global, "ego-up", ["u"], 0, "ego up", "Turn the map so that the ego drives upwards, or north up.";
    FitMap, Global, "fit", ["a"], 0, "fit all", "Show the whole map.";
    ZoomIn, Global, "zoom-in", ["+", "="], 0, "zoom in", "Zoom the map in.";
    ZoomOut, Global, "zoom-out", ["-"], 0, "zoom out", "Zoom the map out.";
    Copy, Global, "copy", ["y"], 0, "copy", "Copy the pane's text to the clipboard of the terminal (OSC 52).";
    Mouse, Global, "mouse", [], 0, "mouse", "Use the mouse, or leave it to the terminal.";
    Suspend, Global, "suspend", ["ctrl-z"], 0, "suspend", "Go back to the shell; `fg` returns.";
    Up, Scenarios, "up", ["up", "k"], 0, "up", "Select the scenario above.";
    Down, Scenarios, "down", ["down", "j"], 0, "down", "Select the scenario below.";
    Choose, Scenarios, "choose", ["enter"], 0, "open", "Open the selected scenario now.";
    PageUp, Scenarios, "page-up", ["pageup"], 0, "page up", "A page up.";
    PageDown, Scenarios, "page-down", ["pagedown"], 0, "page down", "A page down.";
    Top, Scenarios, "top", ["g"], 0, "top", "The first scenario.";
    Bottom, Scenarios, "bottom", ["shift-g"], 0, "bottom", "The last scenario.";
    PanLeft, Map, "pan-left", ["h"], 0, "left", "Move the map's view to the left.";
    PanDown, Map, "pan-down", ["j", "down"], 0, "down", "Move the map's view down.";
    PanUp, Map, "pan-up", ["k", "up"], 0, "up", "Move the map's view up.";
    PanRight, Map, "pan-right", ["l"], 0, "right", "Move the map's view to the right.";
    Up, Text, "up", ["up", "k"], 0, "up", "A line up.";
    Down, Text, "down", ["down", "j"], 0, "down", "A line down.";
    PageUp, Text, "page-up", ["pageup", "ctrl-u"], 0, "page up", "A page up.";
    PageDown, Text, "page-down", ["pagedown", "ctrl-d"], 0, "page down", "A page down.";
    Top, Text, "top", ["g"], 0, "top", "To the beginning.";
    Bottom, Text, "bottom", ["shift-g"], 0, "bottom", "To the end; new text is followed from there.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_means_two_things_in_one_place() {
        for (i, a) in ACTIONS.iter().enumerate() {
            for b in &ACTIONS[i + 1..] {
                let meet =
                    a.scope == b.scope || a.scope == Scope::Global || b.scope == Scope::Global;
                let shared = a.keys.iter().find(|key| b.keys.contains(key));
                assert!(
                    !meet || shared.is_none(),
                    "{} and {} share {shared:?}",
                    a.id,
                    b.id
                );
            }
        }
    }
}
