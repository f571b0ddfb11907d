//! The actions, and the rows of their table.

use super::{Entry, Scope};

/// A user action, described in [`ACTIONS`].
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
    WidenPane,
    NarrowPane,
    TallerPane,
    LowerPane,
    EvenPanes,
    FocusLeft,
    FocusDown,
    FocusUp,
    FocusRight,
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
    ContactStep,
    PlaceBack,
    PlaceForward,
    PaneMain,
    NextDifference,
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
    SplitMap,
    DriverMap,
    PinMoment,
    MomentBack,
    MomentForward,
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
    DrivePlanner,
    NextForecast,
    NextPlanner,
    PlannerCycle,
    Drivers,
    NextDriver,
    PlotDrives,
    SaveDrive,
    Generate,
    GenerateWith,
    /// Search for an attack that words describe.
    GenerateWish,
    ModelAttacks,
    ModelAttacksWith,
    SwitchVariant,
    VariantPanel,
    SaveVariant,
    ToggleTask,
    ToggleFrame,
    ToggleCp,
    ToggleCot,
    ToggleIcl,
    ToggleTools,
    PromptView,
    Edit,
    DiscardDraft,
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
    Results,
    CellLeft,
    CellRight,
    OpenCell,
    ChooseCounted,
    ChangeTruth,
    SortResults,
    ExportResults,
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
    Accept,
    SavedViews,
    RawAnswer,
    UnfoldJson,
    Experiment,
    NewExperiment,
    RunExperiment,
    StopExperiment,
    ExperimentResults,
    EditExperiment,
    ExperimentText,
    ExperimentPart,
    RereadExperiment,
    Coverage,
    ChooseIndex,
    CoverageLeft,
    CoverageRight,
    OpenCoverage,
    NextSeverity,
    CoverageWindows,
}

macro_rules! table {
    ($($action:ident, $scope:ident, $id:literal, $($key:literal)|+, $footer:literal, $short:literal, $doc:literal;)+) => {
        /// Every action.
        pub const ACTIONS: &[Entry] = &[$(Entry {
            action: Action::$action, id: $id, short: $short, doc: $doc, scope: Scope::$scope,
            keys: &[$($key),*], footer: $footer,
        }),+];
    };
}

table! {
    StepBack, Global, "step-back", "left", 2, "step", "One time step back.";
    StepForward, Global, "step-forward", "right", 2, "step", "One time step forward.";
    Play, Global, "play", "p", 3, "play", "Play, or pause.";
    Run, Global, "run", "r", 1, "ask", "Ask the chosen model, or show its answer from the store.";
    RunAnew, Global, "run-anew", "shift-r", 0, "ask again", "Ask the chosen model again, even if the store has its answer.";
    Compare, Global, "compare", "c", 10, "ask another", "Choose another model and ask it too.";
    SavePicture, Global, "picture", "space o p", 0, "picture", "Save a picture of the map, the plot or the screen, or an animation.";
    ChooseModel, Global, "model", "m", 7, "model", "Choose the model that is asked.";
    Edit, Global, "edit", "e", 8, "edit prompt", "Edit the prompt template.";
    Filter, Global, "filter", "/", 9, "filter", "Filter the list of scenarios.";
    NextPane, Global, "next-pane", "tab" | "ctrl-w w" | "space w w", 5, "pane", "Go to the next pane.";
    PreviousPane, Global, "previous-pane", "backtab" | "ctrl-w shift-w", 0, "pane back", "Go to the previous pane.";
    Help, Global, "help", "?" | "f1", 4, "help", "The keys, those of the focused pane first.";
    About, Global, "about", "space o i", 0, "about", "Contents of the open scenario, and parser notes.";
    Quit, Global, "quit", "q" | "ctrl-q", 6, "quit", "Close the window that is open; without one, leave the program.";
    Palette, Global, "palette", ":" | "ctrl-p", 11, "palette", "Find an action by name.";
    Cancel, Global, "cancel", "esc" | "ctrl-c", 0, "cancel", "Close the innermost thing that is open, or cancel the running request; Ctrl-C does the same, and quits when pressed twice.";
    Zoom, Global, "zoom-pane", "z" | "ctrl-w z" | "space w z", 0, "zoom", "Show the pane alone; again shows all panes.";
    WidenPane, Global, "widen-pane", "ctrl-w >" | "space w >", 0, "wider", "Make the pane wider; borders can be dragged with the mouse too.";
    NarrowPane, Global, "narrow-pane", "ctrl-w <" | "space w <", 0, "narrower", "Make the pane narrower.";
    TallerPane, Global, "taller-pane", "ctrl-w +" | "space w +", 0, "taller", "Make the pane taller.";
    LowerPane, Global, "lower-pane", "ctrl-w -" | "space w -", 0, "shorter", "Make the pane shorter.";
    EvenPanes, Global, "reset-panes", "ctrl-w =" | "space w =", 0, "reset sizes", "Reset the sizes of all panes.";
    FocusLeft, Global, "pane-left", "ctrl-w h" | "ctrl-w left" | "space w h", 0, "left", "Go to the pane on the left.";
    FocusDown, Global, "pane-down", "ctrl-w j" | "ctrl-w down" | "space w j", 0, "below", "Go to the pane below.";
    FocusUp, Global, "pane-up", "ctrl-w k" | "ctrl-w up" | "space w k", 0, "above", "Go to the pane above.";
    FocusRight, Global, "pane-right", "ctrl-w l" | "ctrl-w right" | "space w l", 0, "right", "Go to the pane on the right.";
    JumpBack, Global, "jump-back", "shift-left" | ",", 0, "-1 s", "Ten time steps back.";
    JumpForward, Global, "jump-forward", "shift-right" | ".", 0, "+1 s", "Ten time steps forward.";
    FirstStep, Global, "first-step", "0" | "home" | "g h", 0, "start", "Go to the first time step.";
    LastStep, Global, "last-step", "$" | "end" | "g l", 0, "end", "Go to the last time step.";
    PlaceBack, Global, "back", "ctrl-o" | "alt-left", 0, "back", "Go back to the place before the last jump: scenario, step and picked obstacle.";
    PlaceForward, Global, "forward", "alt-right", 0, "forward", "Go forward again in the list of jumps.";
    Faster, Global, "faster", ">" | "space t f", 0, "faster", "Play twice as fast.";
    Slower, Global, "slower", "<" | "space t s", 0, "slower", "Play half as fast.";
    MinimumStep, Global, "minimum", "g m", 0, "minimum", "Go to the most dangerous value of the plotted measure, of the picked obstacle or of all.";
    CollisionStep, Global, "worst", "x" | "g w", 0, "worst", "Go to the moment that matters: contact, else a course to contact or a close pass.";
    ContactStep, Global, "contact", "g c", 0, "contact", "Go to the first contact of the ego.";
    NextDifference, Global, "next-difference", "g d", 0, "difference", "Go to the next thing that an answer on this scenario says otherwise than the built-in judge: yes or no, a risk score, a critical obstacle.";
    NextDisagreement, Global, "next-disagreement", "g shift-d", 0, "disagreement", "Go to the next answer whose yes or no differs from the built-in judge's, here or in another scenario of the list.";
    Loop, Global, "loop", "space t l", 0, "loop", "Loop playback: everything, the window, or off.";
    HeatStrips, Global, "heat-strips", "space p h", 0, "heat", "Switch the measure in the strips of the timeline, or hide them.";
    ToggleTask, Global, "task", "space a t", 0, "task", "Switch the task.";
    ToggleFrame, Global, "frame", "space a f", 0, "frame", "Switch to the next frame that the task has a template for.";
    ToggleCp, Global, "cp", "space a c", 0, "cp", "Contextual prompting on or off.";
    ToggleCot, Global, "cot", "space a h", 0, "cot", "Chain of thought on or off.";
    ToggleIcl, Global, "icl", "space a i", 0, "icl", "In-context examples on or off.";
    ToggleTools, Global, "tools", "space a u", 0, "tools", "Let models call tools that compute distances, times and measures, or not.";
    PromptView, Global, "prompt-view", "space a v", 0, "view", "Show the rendered prompt, the template, or the description.";
    DiscardDraft, Global, "discard-draft", "space a d", 0, "discard draft", "Discard the draft of the template and your saved copy: the shipped one is used. Both are kept as .bak files.";
    RereadTemplates, Global, "reread-templates", "space a r", 0, "reread", "Read the templates in your prompts folder again.";
    NextAnswer, Global, "next-answer", "]", 0, "answer", "Show the reasoning of the next answer.";
    PreviousAnswer, Global, "previous-answer", "[", 0, "answer back", "Show the reasoning of the previous answer.";
    CloseAnswer, Global, "close-answer", "space a x", 0, "close", "Remove the shown answer from the comparison; it stays in the store.";
    NextClaim, Global, "next-claim", ")", 0, "claim", "Go to the next claim of the shown answer: its obstacle is picked, the clock goes to its step.";
    PreviousClaim, Global, "previous-claim", "(", 0, "claim back", "Previous claim.";
    CompareScreen, Global, "compare-screen", "space o c", 0, "side by side", "Up to four answers side by side, with their claims checked.";
    BlindMode, Global, "blind", "space o b", 0, "blind", "Compare and rate answers with their models hidden.";
    NextObstacle, Global, "next-obstacle", "n", 0, "obstacle", "Pick the next obstacle, the most dangerous first.";
    PreviousObstacle, Global, "previous-obstacle", "shift-n", 0, "obstacle back", "Pick the previous obstacle.";
    Mark, Global, "mark", "space p o", 0, "mark", "Plot the picked obstacle beside the others; again removes it.";
    PlotMeasure, Global, "plot", "space p m", 0, "plot", "Choose the measure that is plotted over time.";
    Values, Global, "values", "space o v", 0, "values", "Every measure of the picked obstacle and of the scene at this step, and the thresholds.";
    ReadThresholds, Global, "read-thresholds", "space s r", 0, "thresholds", "Read thresholds.toml again and recompute the measures.";
    SortScenarios, Global, "sort", "space l s", 0, "sort", "Sort the list of scenarios; the same order again reverses it.";
    TurnOrder, Global, "turn-order", "space l r", 0, "reverse", "Reverse the order of the list.";
    GroupScenarios, Global, "group", "space l g", 0, "group", "Group the list by country, folder, tag, verdict, or not at all.";
    EditTags, Global, "tags", "space l t", 0, "tags", "Set your own tags on the selected scenario.";
    TakeAsEgo, Global, "take-as-ego", "space e t", 0, "as ego", "Take the picked obstacle as the ego.";
    RecordedEgo, Global, "recorded-ego", "space e r", 0, "recorded ego", "Back to the recorded ego (or that of --ego) from a picked or planned one, and to the original scenario from a variant.";
    DrivePlanner, Global, "drive", "space e p", 0, "drive", "Let the planner drive the ego from the start of the planning problem; again stops it.";
    NextForecast, Global, "forecast", "space e f", 0, "forecast", "Switch the planner's prediction of the traffic: along the lanes, constant velocity, or as recorded.";
    NextPlanner, Global, "planner", "space e n", 0, "planner", "Switch the planner that drives: the built-in one, and the processes of [planner.NAME] in config.toml.";
    PlannerCycle, Global, "planner-cycle", "space e w", 0, "planner cycle", "What the planner saw and chose at this step: candidates, rejections, costs.";
    Drivers, Global, "drivers", "space e d", 0, "drivers", "Which drivers avoid the encounter with the picked obstacle, when they react, and until when they could take over.";
    NextDriver, Global, "next-driver", "space e c", 0, "next driver", "Show the next driver beside the ego: in the strip, on the second map, and where it reacts on the timeline.";
    PlotDrives, Global, "plot-drives", "space p d", 0, "planned or recorded", "Plot the speeds of the planned and the recorded ego, the distance between them, or the measure again.";
    SaveDrive, Global, "save-drive", "space e s", 0, "save drive", "Write the planned ego, as an ego trajectory (CSV) and as a CommonRoad solution, into the folder that pictures go to.";
    Generate, Global, "generate", "space g g", 0, "make dangerous", "Make the scenario dangerous: search for a motion of an obstacle that endangers the planned ego and that an ideal driver survives; again uses the next seed.";
    GenerateWith, Global, "generate-with", "space g a", 0, "picked attacks", "The same, with the picked obstacle as the attacker.";
    GenerateWish, Global, "generate-wish", "space g d", 0, "describe an attack", "Search for an attack that terms describe: who, which manoeuvre, from where.";
    ModelAttacks, Global, "generate-with-model", "space g m", 0, "model attacks", "Make the scenario dangerous with the chosen model: it picks the attacker and writes its motion, and sees what the gate refuses; again asks it again.";
    ModelAttacksWith, Global, "generate-with-model-by", "space g w", 0, "model writes", "The same, with the picked obstacle as the attacker: the model only writes its motion.";
    SwitchVariant, Global, "switch-variant", "space g o", 0, "original or variant", "Switch between the generated variant and its original.";
    VariantPanel, Global, "variant", "space g v", 0, "variant", "The variant: attacker, outcome, risk before and after, avoidability, refusals, and the difference at this step.";
    SaveVariant, Global, "save-variant", "space g s", 0, "save variant", "Write the variant as CommonRoad XML with the ego's drive, its solution and all proofs, into the folder that pictures go to.";
    Follow, Global, "follow", "space m f", 0, "follow", "Keep the ego in the middle of the map; again lets go.";
    EgoUp, Global, "ego-up", "space m u", 0, "turn with the ego", "Turn the map with the ego, or north up.";
    FitMap, Global, "fit", "space m a", 0, "fit all", "Show the whole map.";
    SplitMap, Global, "split-map", "space m s", 0, "second map", "Two maps: beside the present step the contact or the worst moment of the picked obstacle, or beside a variant its original; again shows one.";
    DriverMap, Global, "driver-map", "space m g", 0, "driver beside", "Beside the ego a driver in its seat, each with outcome and gap; again shows what was there before.";
    PinMoment, Global, "pin-moment", "space m h", 0, "pin moment", "Pin the second map to the present step; again frees it.";
    MomentBack, Global, "moment-back", "{" | "space m ,", 0, "second map back", "Move the second map one time step back.";
    MomentForward, Global, "moment-forward", "}" | "space m .", 0, "second map on", "Move the second map one time step forward.";
    ZoomIn, Global, "zoom-in", "+" | "=", 0, "zoom in", "Zoom the map in.";
    ZoomOut, Global, "zoom-out", "-", 0, "zoom out", "Zoom the map out.";
    History, Global, "history", "space o h" | "ctrl-r", 0, "history", "The history of runs: what was asked and answered.";
    TaskList, Global, "tasks", "space o j", 0, "tasks", "Running, waiting and finished tasks, and their cost.";
    Results, Global, "results", "space o r", 0, "results", "Results of the stored answers, of a batch or all: right and wrong by model, frame and techniques, with the answers behind each number.";
    MarkScenario, Global, "mark-scenario", "*" | "space l m", 0, "mark scenario", "Mark the selected scenario, or unmark it.";
    UnmarkScenarios, Global, "unmark-scenarios", "space l u", 0, "unmark all", "Unmark all scenarios.";
    AskMarked, Global, "ask-marked", "space a a", 0, "ask marked", "Ask the chosen model about the marked scenarios; without marks, about all listed.";
    Details, Global, "details", "space o d", 0, "details", "Everything about the picked obstacle at this step: state, signals, relation to the ego.";
    NextPaths, Global, "paths", "space m p", 0, "paths", "Show predicted and constant-velocity paths: none, of the picked obstacle, or of all near the ego.";
    Layers, Global, "layers", "space m l", 0, "layers", "Switch layers of the map on and off.";
    TakeTape, Global, "tape", "space m t", 0, "tape", "Measure distances on the map, first from the ego to the picked obstacle; again closes the tape.";
    Copy, Global, "copy", "y", 0, "copy", "Copy the pane's text to the clipboard of the terminal (OSC 52).";
    Mouse, Global, "mouse", "space s m", 0, "mouse", "Use the mouse, or leave it to the terminal.";
    PickTheme, Global, "theme", "space s t" | "ctrl-t", 0, "theme", "Choose the colours, with a live preview.";
    OutsideEditor, Global, "external-editor", "ctrl-e" | "space a e", 0, "$EDITOR", "Edit the template in $VISUAL or $EDITOR, or view a copy of the prompt there.";
    ChooseTemplate, Global, "templates", "space a p", 0, "templates", "Choose among the templates for the task and frame.";
    Source, Global, "source", "space o s", 0, "source", "The scenario's XML, at the picked obstacle.";
    Suspend, Global, "suspend", "ctrl-z", 0, "suspend", "Go back to the shell; `fg` returns.";
    Up, Scenarios, "up", "up" | "k", 0, "up", "Select the scenario above.";
    Down, Scenarios, "down", "down" | "j", 0, "down", "Select the scenario below.";
    Choose, Scenarios, "choose", "enter", 0, "open", "Open the selected scenario; on a group, collapse or expand it.";
    PageUp, Scenarios, "page-up", "pageup", 0, "page up", "A page up.";
    PageDown, Scenarios, "page-down", "pagedown", 0, "page down", "A page down.";
    Top, Scenarios, "top", "g g", 0, "top", "The first scenario.";
    Bottom, Scenarios, "bottom", "shift-g" | "g e", 0, "bottom", "The last scenario.";
    PanLeft, Map, "pan-left", "h", 0, "left", "Move the map's view, or the end of the tape, to the left.";
    PanDown, Map, "pan-down", "j" | "down", 0, "down", "Move the map's view, or the end of the tape, down.";
    PanUp, Map, "pan-up", "k" | "up", 0, "up", "Move the map's view, or the end of the tape, up.";
    PanRight, Map, "pan-right", "l", 0, "right", "Move the map's view, or the end of the tape, to the right.";
    SwapTape, Map, "swap-tape", "enter", 0, "details", "Show the details of the picked obstacle; with the tape out, move its other end.";
    Up, Text, "up", "up" | "k", 0, "up", "A line up.";
    Down, Text, "down", "down" | "j", 0, "down", "A line down.";
    PageUp, Text, "page-up", "pageup" | "ctrl-u", 0, "page up", "A page up.";
    PageDown, Text, "page-down", "pagedown" | "ctrl-d", 0, "page down", "A page down.";
    Top, Text, "top", "g g", 0, "top", "To the beginning.";
    Bottom, Text, "bottom", "shift-g" | "g e", 0, "bottom", "To the end; new text is followed from there.";
    PaneMain, Text, "main", "enter", 0, "edit, compare, next claim", "The main thing of the pane: edit the prompt, compare the verdicts, go to the next claim.";
    PaneMain, Plot, "main", "enter", 0, "measure", "Choose the measure that is plotted.";
    Up, Window, "up", "up" | "k", 0, "up", "A line up.";
    Down, Window, "down", "down" | "j", 0, "down", "A line down.";
    PageUp, Window, "page-up", "pageup" | "ctrl-u", 0, "page up", "A page up.";
    PageDown, Window, "page-down", "pagedown" | "ctrl-d", 0, "page down", "A page down.";
    Top, Window, "top", "g g", 0, "top", "To the beginning.";
    Bottom, Window, "bottom", "shift-g" | "g e", 0, "bottom", "To the end.";
    Accept, Window, "accept", "enter", 0, "accept", "Switch the selected line, or confirm.";
    Up, History, "up", "up" | "k", 0, "up", "The newer run; or a line up in the details.";
    Down, History, "down", "down" | "j", 0, "down", "The older run; or a line down in the details.";
    PageUp, History, "page-up", "pageup" | "ctrl-u", 0, "page up", "A page up.";
    PageDown, History, "page-down", "pagedown" | "ctrl-d", 0, "page down", "A page down.";
    Top, History, "top", "g g" | "home", 0, "newest", "The newest run; or the beginning of the details.";
    Bottom, History, "bottom", "shift-g" | "g e" | "end", 0, "oldest", "The oldest run; or the end of the details.";
    ReopenRun, History, "reopen-run", "enter", 1, "reopen", "Open the run's scenario at its window, asked in the same way, with its answer.";
    SearchRuns, History, "search-runs", "/", 2, "search", "Search by words and filters: model: scenario: task: verdict: state: origin: batch: since: before: pinned deleted.";
    OtherHalf, History, "other-half", "tab" | "backtab", 3, "details", "Switch between the list and the details.";
    PinRun, History, "pin-run", "p", 4, "pin", "Pin the run, so that it cannot be deleted; again unpins it.";
    DeleteRun, History, "delete-run", "d" | "delete", 5, "delete", "Delete the run; among deleted ones, restore it.";
    UndoDelete, History, "undo-delete", "u", 6, "undo", "Undo the last deletion, then the one before it.";
    NoteRun, History, "note-run", "n", 7, "note", "Write a note on the run; the search finds notes too.";
    CopyRun, History, "copy-run", "y", 8, "copy", "Copy the run's answer, with its reasoning, to the clipboard of the terminal.";
    ExportRuns, History, "export-runs", "e", 9, "export", "Export the listed runs to a file, as JSON lines.";
    Up, Jobs, "up", "up" | "k", 0, "up", "The task above.";
    Down, Jobs, "down", "down" | "j", 0, "down", "The task below.";
    CancelJob, Jobs, "cancel-task", "x" | "delete", 1, "cancel", "Cancel the selected task; a batch first stops sending, and a second press cancels what is running.";
    CancelAllJobs, Jobs, "cancel-tasks", "shift-x", 2, "cancel all", "Cancel everything that runs.";
    ShowJob, Jobs, "show-task", "enter", 3, "show runs", "Show the runs of the selected batch in the history.";
    Up, Results, "up", "up" | "k", 0, "up", "The row or the answer above.";
    Down, Results, "down", "down" | "j", 0, "down", "The row or the answer below.";
    PageUp, Results, "page-up", "pageup" | "ctrl-u", 0, "page up", "A page up.";
    PageDown, Results, "page-down", "pagedown" | "ctrl-d", 0, "page down", "A page down.";
    Top, Results, "top", "g g" | "home", 0, "first", "The first row or answer.";
    Bottom, Results, "bottom", "shift-g" | "g e" | "end", 0, "last", "The last row or answer.";
    CellLeft, Results, "cell-left", "left" | "h", 2, "cell", "The number on the left.";
    CellRight, Results, "cell-right", "right" | "l", 2, "cell", "The number on the right.";
    OpenCell, Results, "open-cell", "enter", 1, "open", "List the answers behind the number; open the scenario of an answer, asked in the same way.";
    ChooseCounted, Results, "choose-counted", "b", 3, "which answers", "Choose which answers are counted: those of a batch, or all.";
    EditDone, Editor, "edit-done", "esc", 1, "done", "Leave the editor; the draft stays in use. In vim's modes, first back to normal.";
    Run, Editor, "run", "alt-r" | "ctrl-enter", 1, "ask", "Ask the chosen model with the draft; what changed stands beside the editor.";
    SaveTemplate, Editor, "save-template", "ctrl-s", 2, "save", "Save the template in your prompts folder.";
    SaveTemplateAs, Editor, "save-as", "ctrl-a" | "alt-s", 8, "save as", "Save it under a new name, and use that for the task and frame.";
    Find, Editor, "find", "ctrl-f" | "alt-/", 3, "find", "Find a word; again for the next one, up for the one before.";
    Undo, Editor, "undo", "ctrl-z" | "alt-z", 9, "undo", "Undo the last change.";
    Redo, Editor, "redo", "ctrl-y" | "alt-y", 10, "redo", "Redo it.";
    Turn, Editor, "beside", "ctrl-o" | "alt-o", 4, "side pane", "Side pane: rendered prompt, description, diff, answer; in a narrow terminal in place of the editor.";
    OutsideEditor, Editor, "external-editor", "ctrl-e" | "alt-e", 11, "$EDITOR", "Continue in $VISUAL or $EDITOR.";
    GoToLine, Editor, "go-to-line", "ctrl-g" | "alt-g", 12, "line", "Go to a line by its number.";
    ToggleTask, Editor, "task", "alt-t" | "f2", 5, "task, frame", "Switch the task, and the template with it.";
    ToggleFrame, Editor, "frame", "alt-f" | "f3", 5, "task, frame", "Switch to the next frame, and to its template.";
    ToggleCp, Editor, "cp", "alt-1" | "f4", 6, "cp cot icl", "Contextual prompting on or off.";
    ToggleCot, Editor, "cot", "alt-2" | "f5", 6, "cp cot icl", "Chain of thought on or off.";
    ToggleIcl, Editor, "icl", "alt-3" | "f6", 6, "cp cot icl", "In-context examples on or off.";
    Up, Editor, "up", "alt-up", 7, "scroll side pane", "A line up in the side pane.";
    Down, Editor, "down", "alt-down", 7, "scroll side pane", "A line down there.";
    PageUp, Editor, "page-up", "alt-pageup", 0, "page up", "A page up there.";
    PageDown, Editor, "page-down", "alt-pagedown", 0, "page down", "A page down there.";
    Help, Editor, "help", "f1", 13, "help", "The keys, those of the editor first.";
    Cut, Editor, "cut", "ctrl-x", 0, "cut", "Cut the selection, also to the terminal's clipboard (OSC 52).";
    CopySelection, Editor, "copy-selection", "alt-w", 0, "copy", "Copy the selection; Ctrl-C does it too while something is selected.";
    PasteCopied, Editor, "paste", "ctrl-v", 0, "paste", "Paste what was cut or copied here.";
    SelectAll, Editor, "select-all", "alt-a", 0, "all", "Select everything; Shift with a motion selects on the way.";
    Cancel, Compare, "cancel", "esc", 6, "close", "Close the screen, or what is open over it.";
    CompareScreen, Compare, "compare-screen", "shift-c", 0, "close", "Close the screen.";
    CompareLeft, Compare, "compare-left", "left" | "h" | "backtab", 7, "column", "Go to the column on the left.";
    CompareRight, Compare, "compare-right", "right" | "l" | "tab", 7, "column", "Go to the column on the right.";
    Up, Compare, "up", "up" | "k", 0, "up", "A line up, in all columns where they are linked.";
    Down, Compare, "down", "down" | "j", 0, "down", "A line down.";
    PageUp, Compare, "page-up", "pageup" | "ctrl-u", 0, "page up", "A page up.";
    PageDown, Compare, "page-down", "pagedown" | "ctrl-d", 0, "page down", "A page down.";
    Top, Compare, "top", "g g" | "home", 0, "top", "To the beginning.";
    Bottom, Compare, "bottom", "shift-g" | "g e" | "end", 0, "bottom", "To the end; new text is followed from there.";
    LinkScrolling, Compare, "link-scrolling", "s", 12, "link", "Link or unlink the scrolling of the columns.";
    PreviousAnswer, Compare, "previous-answer", "[", 9, "answer", "The previous answer in this column.";
    NextAnswer, Compare, "next-answer", "]", 9, "answer", "The next answer in this column.";
    MoreColumns, Compare, "more-columns", "+" | "=", 11, "columns", "Add a column.";
    FewerColumns, Compare, "fewer-columns", "-", 11, "columns", "Remove this column.";
    NextClaim, Compare, "next-claim", "n" | ")", 5, "claim", "Go to the next claim, wrong ones first: its obstacle is picked, linked columns scroll to it, the clock goes to its step.";
    PreviousClaim, Compare, "previous-claim", "shift-n" | "(", 5, "claim", "Previous claim.";
    PreviousObstacle, Compare, "previous-obstacle", "{", 12, "obstacle", "Pick the previous obstacle that an answer speaks of.";
    NextObstacle, Compare, "next-obstacle", "}", 12, "obstacle", "Pick the next obstacle that an answer speaks of; linked columns scroll to where they do.";
    StepBack, Compare, "step-back", ",", 0, "step", "One time step back.";
    StepForward, Compare, "step-forward", ".", 0, "step", "One time step forward.";
    BlindMode, Compare, "blind", "shift-b", 8, "blind", "Hide the models and shuffle the answers, or show them again.";
    BestFirst, Compare, "best-1", "1", 1, "best", "The first answer is the best.";
    BestSecond, Compare, "best-2", "2", 1, "best", "The second answer is the best.";
    BestThird, Compare, "best-3", "3", 1, "best", "The third answer is the best.";
    BestFourth, Compare, "best-4", "4", 1, "best", "The fourth answer is the best.";
    RateTie, Compare, "tie", "t", 2, "tie", "They are equally good.";
    RateAllWrong, Compare, "all-wrong", "0", 3, "all wrong", "All of them are wrong.";
    MarkWrong, Compare, "mark-wrong", "w", 10, "wrong", "Mark the answer of this column as wrong, with a reason; again unmarks it.";
    NextRound, Compare, "next-round", "enter", 4, "next", "In blind mode: the next answers, or the next scenario.";
    Ratings, Compare, "ratings", "shift-s", 13, "ratings", "Totals of the ratings.";
    SavePicture, Compare, "picture", "o", 0, "picture", "Save a picture of the screen, the map or the plot.";
    Help, Compare, "help", "?" | "f1", 14, "help", "The keys, those of the focused pane first.";
    Quit, Compare, "quit", "q" | "ctrl-q", 0, "close", "Close the screen.";
    ChangeTruth, Results, "change-truth", "t", 4, "truth", "Compare with another truth: labels, exact geometry of recordings, or the built-in judge where there are no labels.";
    SortResults, Results, "sort-results", "s", 5, "sort", "Sort by the selected column; again, the other way around; once more, by prompt.";
    ExportResults, Results, "export-results", "e", 6, "export", "Write the table as CSV and as JSON lines into the folder that pictures go to.";
    RawAnswer, Global, "raw-answer", "space a m", 0, "raw", "Show answers as they were sent, or with their Markdown rendered.";
    UnfoldJson, Global, "unfold-json", "space a j", 0, "JSON", "Unfold the JSON of answers, or fold it to one line.";
    SavedViews, Global, "saved-views", "space l v", 0, "views", "Save the filter, order and grouping of the list under a name, or choose a saved view.";
    Experiment, Global, "experiment", "space o e", 0, "experiment", "Open an experiment file, or write a new one from the marked scenarios.";
    NewExperiment, Global, "new-experiment", "space a n", 0, "new experiment", "Write an experiment file that asks the chosen model about the marked or listed scenarios as the workbench would, and open it.";
    Up, Experiment, "up", "up" | "k", 0, "up", "A line up.";
    Down, Experiment, "down", "down" | "j", 0, "down", "A line down.";
    PageUp, Experiment, "page-up", "pageup" | "ctrl-u", 0, "page up", "A page up.";
    PageDown, Experiment, "page-down", "pagedown" | "ctrl-d", 0, "page down", "A page down.";
    Top, Experiment, "top", "g g" | "home", 0, "top", "To the beginning.";
    Bottom, Experiment, "bottom", "shift-g" | "end", 0, "bottom", "To the end.";
    RunExperiment, Experiment, "run-experiment", "r", 1, "run", "Ask what is open, after a yes to the cost; a batch that was begun before goes on.";
    StopExperiment, Experiment, "stop-experiment", "x" | "delete", 2, "stop", "Send no new requests; again cancels those already sent.";
    ExperimentResults, Experiment, "experiment-results", "enter", 3, "results", "The results of its batch; a test split stays locked until it is complete.";
    EditExperiment, Experiment, "edit-experiment", "e" | "ctrl-e", 4, "edit", "Edit the file in $VISUAL or $EDITOR; it is read again afterwards.";
    Experiment, Experiment, "experiment", "o", 8, "open", "Open another experiment, or write a new one.";
    ExperimentText, Experiment, "experiment-text", "t", 5, "TOML", "Show the text of the file, or what it says.";
    ExperimentPart, Experiment, "experiment-part", "p", 6, "dev/test", "Ask both parts of the split, only dev, or only test.";
    RereadExperiment, Experiment, "reread-experiment", "shift-r", 7, "reread", "Read the file again and count anew.";
    Coverage, Global, "coverage", "space l c", 0, "coverage", "The coverage map of the index: windows by manoeuvre, road and severity, and those asked about.";
    ChooseIndex, Global, "index", "space l i", 0, "index", "Choose the index of a corpus, whose terms filter the list; `:index FOLDER` reads one at once.";
    Up, Coverage, "up", "up" | "k", 1, "cell", "The manoeuvre above, or the window above.";
    Down, Coverage, "down", "down" | "j", 1, "cell", "The manoeuvre below, or the window below.";
    CoverageLeft, Coverage, "cell-left", "left" | "h", 1, "cell", "The road on the left.";
    CoverageRight, Coverage, "cell-right", "right" | "l", 1, "cell", "The road on the right.";
    PageUp, Coverage, "page-up", "pageup" | "ctrl-u", 0, "page up", "A page up.";
    PageDown, Coverage, "page-down", "pagedown" | "ctrl-d", 0, "page down", "A page down.";
    Top, Coverage, "top", "g g" | "home", 0, "first", "The first manoeuvre, or the worst window.";
    Bottom, Coverage, "bottom", "shift-g" | "g e" | "end", 0, "last", "All manoeuvres, or the last window.";
    OpenCoverage, Coverage, "open-cell", "enter", 2, "filter", "Filter the list to the cell; on a window, open it at its worst step.";
    CoverageWindows, Coverage, "cell-windows", "tab" | "backtab", 3, "windows", "Go to the worst windows of the cell, or back to the table.";
    NextSeverity, Coverage, "next-severity", "s", 4, "severity", "Count windows of the next severity alone, or of all.";
    ChooseIndex, Coverage, "index", "i", 5, "index", "Choose another index, or read this one again.";
}
