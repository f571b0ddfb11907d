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
    PickTheme,
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
    MinimumStep,
    CollisionStep,
    NextDisagreement,
    Loop,
    HeatStrips,
    GroupScenarios,
    TurnOrder,
    EditTags,
    ZoomIn,
    ZoomOut,
    PanLeft,
    PanRight,
    PanUp,
    PanDown,
    Follow,
    EgoUp,
    FitMap,
    TakeTape,
    SwapTape,
    NextPaths,
    Layers,
    Details,
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
    NextClaim,
    PreviousClaim,
    CompareScreen,
    BlindMode,
    CompareLeft,
    CompareRight,
    LinkScrolling,
    MoreColumns,
    FewerColumns,
    BestFirst,
    BestSecond,
    BestThird,
    BestFourth,
    RateTie,
    RateAllWrong,
    MarkWrong,
    NextRound,
    Ratings,
    Copy,
    Mouse,
    Suspend,
    History,
    TaskList,
    MarkScenario,
    UnmarkScenarios,
    AskMarked,
    ReopenRun,
    SearchRuns,
    PinRun,
    DeleteRun,
    UndoDelete,
    NoteRun,
    CopyRun,
    ExportRuns,
    OtherHalf,
    CancelJob,
    CancelAllJobs,
    ShowJob,
    OutsideEditor,
    ChooseTemplate,
    Source,
    EditDone,
    SaveTemplate,
    SaveTemplateAs,
    Find,
    GoToLine,
    Turn,
    Undo,
    Redo,
    Cut,
    CopySelection,
    PasteCopied,
    SelectAll,
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
    /// In the history of runs.
    History,
    /// In the list of tasks.
    Jobs,
    /// In the template editor, where keys write and nothing else holds.
    Editor,
    /// On the screen of answers side by side, which has keys for everything itself.
    Compare,
}

impl Scope {
    /// Every place with its name in keymap files, and in words.
    pub const ALL: [(Self, &'static str, &'static str); 8] = [
        (Self::Global, "global", "everywhere"),
        (Self::Scenarios, "scenarios", "in the list of scenarios"),
        (Self::Map, "map", "on the map"),
        (Self::Text, "text", "in prompt, verdict and reasoning"),
        (Self::History, "history", "in the history of runs"),
        (Self::Jobs, "tasks", "in the list of tasks"),
        (Self::Editor, "editor", "in the template editor"),
        (
            Self::Compare,
            "compare",
            "on the screen of answers side by side",
        ),
    ];

    /// Its name in keymap files.
    #[must_use]
    pub fn name(self) -> &'static str {
        let found = Self::ALL.iter().find(|(scope, ..)| *scope == self);
        found.map_or("", |(_, name, _)| name)
    }

    /// Whether it is a screen of its own, where of the keys that hold everywhere only [`EVEN_THERE`] do.
    #[must_use]
    pub fn is_own(self) -> bool {
        matches!(
            self,
            Self::History | Self::Jobs | Self::Editor | Self::Compare
        )
    }
}

/// What holds everywhere, even on screens of their own.
pub const EVEN_THERE: [Action; 6] = [
    Action::Help,
    Action::Palette,
    Action::Cancel,
    Action::Suspend,
    Action::History,
    Action::TaskList,
];

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
    /// Keys, the first one shown first; keys that follow each other have a space between them. Empty for what is
    /// only in the palette. These are the default ones: views ask the model's keymap.
    pub keys: &'static [&'static str],
    /// How early it stands in the footer; 0 is not in it.
    pub footer: u8,
}

impl Entry {
    /// Whether its keys do it where `scope` holds.
    #[must_use]
    pub fn holds_in(&self, scope: Scope) -> bool {
        let everywhere = match scope {
            // What is no key of the editor's writes, and in blind mode little may be shown.
            Scope::Editor | Scope::Compare => false,
            scope => !scope.is_own() || EVEN_THERE.contains(&self.action),
        };
        self.scope == scope || (self.scope == Scope::Global && everywhere)
    }

    /// Whether a key can be pressed that does both.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        self.holds_in(other.scope) || other.holds_in(self.scope)
    }
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
    NextPane, Global, "next-pane", ["tab", "ctrl-w w"], 10, "pane", "Go to the next pane.";
    PreviousPane, Global, "previous-pane", ["backtab", "ctrl-w shift-w"], 0, "pane back", "Go to the previous pane.";
    Help, Global, "help", ["?", "f1"], 7, "help", "All keys.";
    About, Global, "about", ["i"], 0, "about", "What is in the opened scenario, and what reading it had to assume.";
    Quit, Global, "quit", ["q", "ctrl-q"], 8, "quit", "Leave the program.";
    Palette, Global, "palette", [":", "ctrl-p"], 11, "palette", "All actions by name.";
    Cancel, Global, "cancel", ["esc", "ctrl-c"], 0, "cancel", "Close what is open, or cancel the running request; Ctrl-C quits when there is nothing to cancel.";
    Zoom, Global, "zoom-pane", ["z", "ctrl-w z"], 0, "zoom", "Show the pane alone, or all of them again.";
    JumpBack, Global, "jump-back", ["shift-left", ","], 0, "-1 s", "Ten time steps back.";
    JumpForward, Global, "jump-forward", ["shift-right", "."], 0, "+1 s", "Ten time steps forward.";
    FirstStep, Global, "first-step", ["home", "0"], 0, "start", "Go to the first time step.";
    LastStep, Global, "last-step", ["end", "$"], 0, "end", "Go to the last time step.";
    Faster, Global, "faster", [">"], 0, "faster", "Play twice as fast.";
    Slower, Global, "slower", ["<"], 0, "slower", "Play half as fast.";
    MinimumStep, Global, "minimum", ["shift-m"], 0, "minimum", "Go to the most dangerous value of the plotted measure: of the picked obstacle, else of all.";
    CollisionStep, Global, "worst", ["x"], 0, "worst", "Go to the first contact, or the step of the lowest risk score.";
    NextDisagreement, Global, "next-disagreement", ["shift-d"], 0, "disagreement", "Go to the next answer that differs from the built-in judge, here or in another scenario of the list.";
    Loop, Global, "loop", [";"], 0, "loop", "Play over and over: everything, the window, or no longer.";
    HeatStrips, Global, "heat-strips", ["shift-h"], 0, "heat", "Show another measure in the strips of the timeline, or none.";
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
    NextClaim, Global, "next-claim", [")"], 0, "claim", "Go to the next claim of the shown answer: its obstacle is picked, the clock goes to its step.";
    PreviousClaim, Global, "previous-claim", ["("], 0, "claim back", "Go to the claim before.";
    CompareScreen, Global, "compare-screen", ["shift-c"], 0, "side by side", "Up to four answers side by side on the whole screen, with their claims checked.";
    BlindMode, Global, "blind", ["shift-b"], 0, "blind", "Compare answers with their models hidden, and rate them.";
    NextObstacle, Global, "next-obstacle", ["n"], 0, "obstacle", "Pick the next obstacle, the most dangerous first.";
    PreviousObstacle, Global, "previous-obstacle", ["shift-n"], 0, "obstacle back", "Pick the previous obstacle.";
    Mark, Global, "mark", ["b"], 0, "mark", "Plot the picked obstacle beside the others, or no longer.";
    PlotMeasure, Global, "plot", ["p"], 0, "plot", "Choose the measure that is plotted over time.";
    Values, Global, "values", ["shift-v"], 0, "values", "Every measure of the picked obstacle and of the scene at this step, and the thresholds.";
    ReadThresholds, Global, "read-thresholds", [], 0, "thresholds", "Read thresholds.toml again and measure anew.";
    SortScenarios, Global, "sort", ["s"], 0, "sort", "Sort the list of scenarios; by the same again, the other way around.";
    TurnOrder, Global, "turn-order", [], 0, "turn", "Turn the order of the list around.";
    GroupScenarios, Global, "group", ["shift-s"], 0, "group", "Group the list by country, folder, tag, what answers say, or not at all.";
    EditTags, Global, "tags", ["#"], 0, "tags", "Give the selected scenario tags of your own.";
    TakeAsEgo, Global, "take-as-ego", ["shift-e"], 0, "as ego", "Take the picked obstacle as the ego.";
    RecordedEgo, Global, "recorded-ego", ["backspace"], 0, "recorded ego", "Go back from an obstacle as the ego to the recorded one, or to that of --ego.";
    Follow, Global, "follow", ["w"], 0, "follow", "Keep the ego in the middle of the map, or not.";
    EgoUp, Global, "ego-up", ["u"], 0, "ego up", "Turn the map so that the ego drives upwards, or north up.";
    FitMap, Global, "fit", ["a"], 0, "fit all", "Show the whole map.";
    ZoomIn, Global, "zoom-in", ["+", "="], 0, "zoom in", "Zoom the map in.";
    ZoomOut, Global, "zoom-out", ["-"], 0, "zoom out", "Zoom the map out.";
    History, Global, "history", ["ctrl-r"], 0, "history", "The history of runs: what was asked and answered.";
    TaskList, Global, "tasks", ["shift-j"], 0, "tasks", "Everything that runs or waits, what it costs, and what became of what ran.";
    MarkScenario, Global, "mark-scenario", ["*"], 0, "mark scenario", "Mark the selected scenario, or take its mark away.";
    UnmarkScenarios, Global, "unmark-scenarios", [], 0, "unmark all", "Take the marks of all scenarios away.";
    AskMarked, Global, "ask-marked", ["shift-a"], 0, "ask many", "Ask the chosen model about the marked scenarios, or about all that are listed where none is marked.";
    Details, Global, "details", ["shift-i"], 0, "details", "Everything about the picked obstacle at this step: state, signals, relation to the ego.";
    NextPaths, Global, "paths", ["shift-p"], 0, "paths", "Show predicted and constant-velocity paths on the map: of nobody, the picked obstacle, all near the ego.";
    Layers, Global, "layers", ["shift-l"], 0, "layers", "Switch layers of the map on and off.";
    TakeTape, Global, "tape", ["shift-t"], 0, "tape", "Measure distances on the map, from the ego to the picked obstacle at first; again puts the tape away.";
    Copy, Global, "copy", ["y"], 0, "copy", "Copy the pane's text to the clipboard of the terminal (OSC 52).";
    Mouse, Global, "mouse", [], 0, "mouse", "Use the mouse, or leave it to the terminal.";
    PickTheme, Global, "theme", ["ctrl-t"], 0, "theme", "Choose the colours, and see them at once.";
    OutsideEditor, Global, "external-editor", ["ctrl-e"], 0, "$EDITOR", "Edit the template in $VISUAL or $EDITOR, or look at a copy of the prompt there.";
    ChooseTemplate, Global, "templates", [], 0, "templates", "Choose among the templates for the task and frame.";
    Source, Global, "source", ["shift-x"], 0, "source", "The scenario's XML, at the picked obstacle.";
    Suspend, Global, "suspend", ["ctrl-z"], 0, "suspend", "Go back to the shell; `fg` returns.";
    Up, Scenarios, "up", ["up", "k"], 0, "up", "Select the scenario above.";
    Down, Scenarios, "down", ["down", "j"], 0, "down", "Select the scenario below.";
    Choose, Scenarios, "choose", ["enter"], 0, "open", "Open the selected scenario now; on a group, shut or open it.";
    PageUp, Scenarios, "page-up", ["pageup"], 0, "page up", "A page up.";
    PageDown, Scenarios, "page-down", ["pagedown"], 0, "page down", "A page down.";
    Top, Scenarios, "top", ["g"], 0, "top", "The first scenario.";
    Bottom, Scenarios, "bottom", ["shift-g"], 0, "bottom", "The last scenario.";
    PanLeft, Map, "pan-left", ["h"], 0, "left", "Move the map's view, or the end of the tape, to the left.";
    PanDown, Map, "pan-down", ["j", "down"], 0, "down", "Move the map's view, or the end of the tape, down.";
    PanUp, Map, "pan-up", ["k", "up"], 0, "up", "Move the map's view, or the end of the tape, up.";
    PanRight, Map, "pan-right", ["l"], 0, "right", "Move the map's view, or the end of the tape, to the right.";
    SwapTape, Map, "swap-tape", ["enter"], 0, "other end", "Move the other end of the measuring tape.";
    Up, Text, "up", ["up", "k"], 0, "up", "A line up.";
    Down, Text, "down", ["down", "j"], 0, "down", "A line down.";
    PageUp, Text, "page-up", ["pageup", "ctrl-u"], 0, "page up", "A page up.";
    PageDown, Text, "page-down", ["pagedown", "ctrl-d"], 0, "page down", "A page down.";
    Top, Text, "top", ["g"], 0, "top", "To the beginning.";
    Bottom, Text, "bottom", ["shift-g"], 0, "bottom", "To the end; new text is followed from there.";
    Up, History, "up", ["up", "k"], 0, "up", "The newer run; or a line up in the details.";
    Down, History, "down", ["down", "j"], 0, "down", "The older run; or a line down in the details.";
    PageUp, History, "page-up", ["pageup", "ctrl-u"], 0, "page up", "A page up.";
    PageDown, History, "page-down", ["pagedown", "ctrl-d"], 0, "page down", "A page down.";
    Top, History, "top", ["g", "home"], 0, "newest", "The newest run; or the beginning of the details.";
    Bottom, History, "bottom", ["shift-g", "end"], 0, "oldest", "The oldest run; or the end of the details.";
    ReopenRun, History, "reopen-run", ["enter"], 1, "reopen", "Open the run's scenario at its window, asked in the same way, with its answer.";
    SearchRuns, History, "search-runs", ["/"], 2, "search", "Words to search for, and filters: model: scenario: task: verdict: state: origin: batch: since: before: pinned deleted.";
    OtherHalf, History, "other-half", ["tab", "backtab"], 3, "list, details", "Move in the details, or in the list again.";
    PinRun, History, "pin-run", ["p"], 4, "pin", "Keep the run from being deleted, or no longer.";
    DeleteRun, History, "delete-run", ["d", "delete"], 5, "delete", "Delete the run; among deleted ones, restore it.";
    UndoDelete, History, "undo-delete", ["u"], 6, "undo", "Take the last deletion back, then the one before it.";
    NoteRun, History, "note-run", ["n"], 7, "note", "Write something about the run; notes are searched too.";
    CopyRun, History, "copy-run", ["y"], 8, "copy", "Copy the run's answer, with its reasoning, to the clipboard of the terminal.";
    ExportRuns, History, "export-runs", ["e"], 9, "export", "Write the listed runs into a file, complete, as JSON lines.";
    Up, Jobs, "up", ["up", "k"], 0, "up", "The task above.";
    Down, Jobs, "down", ["down", "j"], 0, "down", "The task below.";
    CancelJob, Jobs, "cancel-task", ["x", "delete"], 1, "cancel", "Cancel the selected task; a batch begins nothing more, and a second time what it began is cancelled too.";
    CancelAllJobs, Jobs, "cancel-tasks", ["shift-x"], 2, "cancel all", "Cancel everything that runs.";
    ShowJob, Jobs, "show-task", ["enter"], 3, "its runs", "Show the runs of the selected batch in the history.";
    EditDone, Editor, "edit-done", ["esc"], 1, "done", "Give the keys back; the draft stays in use. In vim's modes, first back to normal.";
    SaveTemplate, Editor, "save-template", ["ctrl-s"], 2, "save as yours", "Save the template in your prompts folder.";
    SaveTemplateAs, Editor, "save-as", ["ctrl-a", "alt-s"], 3, "save as", "Save it under a new name, and use that for the task and frame.";
    Find, Editor, "find", ["ctrl-f", "alt-/"], 4, "find", "Find a word; again for the next one, up for the one before.";
    Undo, Editor, "undo", ["ctrl-z", "alt-z"], 5, "undo", "Take the last change back.";
    Redo, Editor, "redo", ["ctrl-y", "alt-y"], 6, "redo", "Make it again.";
    Turn, Editor, "beside", ["ctrl-o", "alt-o"], 7, "beside", "What stands beside the editor: rendered prompt, description, diff; in a narrow terminal in its place.";
    OutsideEditor, Editor, "external-editor", ["ctrl-e", "alt-e"], 8, "$EDITOR", "Go on in $VISUAL or $EDITOR.";
    GoToLine, Editor, "go-to-line", ["ctrl-g", "alt-g"], 9, "line", "Go to a line by its number.";
    Cut, Editor, "cut", ["ctrl-x"], 0, "cut", "Cut the selection, also to the terminal's clipboard (OSC 52).";
    CopySelection, Editor, "copy-selection", ["alt-w"], 0, "copy", "Copy the selection; Ctrl-C does it too while something is selected.";
    PasteCopied, Editor, "paste", ["ctrl-v"], 0, "paste", "Paste what was cut or copied here.";
    SelectAll, Editor, "select-all", ["alt-a"], 0, "all", "Select everything; Shift with a motion selects on the way.";
    Cancel, Compare, "cancel", ["esc"], 11, "close", "Close the screen, or what is open over it.";
    CompareScreen, Compare, "compare-screen", ["shift-c"], 0, "close", "Close the screen.";
    CompareLeft, Compare, "compare-left", ["left", "h", "backtab"], 3, "column", "Go to the column on the left.";
    CompareRight, Compare, "compare-right", ["right", "l", "tab"], 3, "column", "Go to the column on the right.";
    Up, Compare, "up", ["up", "k"], 0, "up", "A line up, in all columns where they are linked.";
    Down, Compare, "down", ["down", "j"], 0, "down", "A line down.";
    PageUp, Compare, "page-up", ["pageup", "ctrl-u"], 0, "page up", "A page up.";
    PageDown, Compare, "page-down", ["pagedown", "ctrl-d", "space"], 0, "page down", "A page down.";
    Top, Compare, "top", ["g", "home"], 0, "top", "To the beginning.";
    Bottom, Compare, "bottom", ["shift-g", "end"], 0, "bottom", "To the end; new text is followed from there.";
    LinkScrolling, Compare, "link-scrolling", ["s"], 7, "link", "Scroll the columns together, or each on its own.";
    NextAnswer, Compare, "next-answer", ["]"], 4, "answer", "Another answer in this column.";
    PreviousAnswer, Compare, "previous-answer", ["["], 4, "answer", "Another answer in this column, backwards.";
    MoreColumns, Compare, "more-columns", ["+", "="], 8, "columns", "One answer more.";
    FewerColumns, Compare, "fewer-columns", ["-"], 8, "columns", "Take this column away.";
    NextClaim, Compare, "next-claim", ["n", ")"], 2, "claim", "Go to the next claim: its obstacle is picked, the clock goes to its step.";
    PreviousClaim, Compare, "previous-claim", ["shift-n", "("], 2, "claim", "Go to the claim before.";
    StepBack, Compare, "step-back", [","], 0, "step", "One time step back.";
    StepForward, Compare, "step-forward", ["."], 0, "step", "One time step forward.";
    BlindMode, Compare, "blind", ["shift-b"], 9, "blind", "Hide the models and draw answers by lot, or show them again.";
    BestFirst, Compare, "best-1", ["1"], 1, "better", "The first answer is the best.";
    BestSecond, Compare, "best-2", ["2"], 1, "better", "The second answer is the best.";
    BestThird, Compare, "best-3", ["3"], 0, "better", "The third answer is the best.";
    BestFourth, Compare, "best-4", ["4"], 0, "better", "The fourth answer is the best.";
    RateTie, Compare, "tie", ["t"], 5, "tie", "They are equally good.";
    RateAllWrong, Compare, "all-wrong", ["0"], 6, "all wrong", "All of them are wrong.";
    MarkWrong, Compare, "mark-wrong", ["w"], 6, "wrong", "Mark the answer of this column as wrong, and say why; or no longer.";
    NextRound, Compare, "next-round", ["enter"], 10, "next", "In blind mode: the next answers, or the next scenario.";
    Ratings, Compare, "ratings", ["shift-s"], 12, "sums", "What the ratings add up to.";
    Help, Compare, "help", ["?", "f1"], 13, "help", "All keys.";
    Quit, Compare, "quit", ["q", "ctrl-q"], 0, "quit", "Leave the program.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_action_has_a_name_of_its_own_where_it_holds() {
        for (i, a) in ACTIONS.iter().enumerate() {
            assert!(Scope::ALL.iter().any(|(scope, ..)| *scope == a.scope));
            for b in &ACTIONS[i + 1..] {
                assert!(!a.meets(b) || a.id != b.id, "{}", a.id);
            }
        }
    }
}
