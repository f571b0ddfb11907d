//! Words of actions beside their names: groups of the menu, labels in it, and synonyms for the palette.

use crate::action::{Action, Entry};
use crate::keymap::{Chord, Key};

/// A prefix with the title of its menu. Chords of the table and of keymap files that begin with it are in that menu.
const GROUPS: &[(&str, &str)] = &[
    ("space", "menu"),
    ("space l", "list"),
    ("space m", "map"),
    ("space a", "ask"),
    ("space e", "ego & planner"),
    ("space g", "generate"),
    ("space o", "open"),
    ("space p", "plots"),
    ("space t", "time"),
    ("space w", "panes"),
    ("space s", "settings"),
    ("g", "go to"),
    ("ctrl-w", "panes"),
];

/// The title of the menu behind these keys; nothing for a prefix that only a keymap file has.
#[must_use]
pub fn title_of(keys: &[Key]) -> Option<&'static str> {
    let name = Chord(keys.to_vec()).name();
    let found = GROUPS.iter().find(|(prefix, _)| *prefix == name);
    found.map(|(_, title)| *title)
}

/// The place of the menu behind these keys among all menus; others come last.
#[must_use]
pub fn order_of(keys: &[Key]) -> usize {
    let name = Chord(keys.to_vec()).name();
    let found = GROUPS.iter().position(|(prefix, _)| *prefix == name);
    found.unwrap_or(GROUPS.len())
}

/// What an action is called in a menu: words of its own, else those of the footer.
#[must_use]
pub fn menu_label(entry: &Entry) -> &'static str {
    use Action::*;
    match entry.action {
        ToggleTask => "task",
        ToggleFrame => "next frame",
        ToggleCp => "contextual prompting on/off",
        ToggleCot => "chain of thought on/off",
        ToggleIcl => "in-context examples on/off",
        ToggleTools => "tools for models on/off",
        PromptView => "prompt, template, description, diff",
        RereadTemplates => "reread templates",
        CloseAnswer => "remove the shown answer",
        AskMarked => "ask about many scenarios",
        ChooseTemplate => "choose a template",
        OutsideEditor => "edit in $EDITOR",
        RawAnswer => "answers as sent or rendered",
        UnfoldJson => "unfold or fold JSON",
        SavePicture => "save a figure or picture",
        About => "contents and parser notes",
        CompareScreen => "answers side by side",
        BlindMode => "rate answers blind",
        Values => "all measures at this step",
        History => "history of runs",
        TaskList => "running tasks and cost",
        Results => "results of stored answers",
        Details => "details of the picked obstacle",
        Source => "XML of the scenario",
        Follow => "follow the ego",
        NextPaths => "predicted paths",
        TakeTape => "measure a distance",
        Mark => "plot the picked obstacle too",
        PlotMeasure => "choose the plotted measure",
        PlotDrives => "planned and recorded speeds",
        HeatStrips => "measure of the timeline",
        TakeAsEgo => "picked obstacle as ego",
        DrivePlanner => "let the planner drive",
        NextForecast => "planner's prediction of traffic",
        NextPlanner => "planner that drives",
        PlannerCycle => "what the planner saw and chose",
        Drivers => "who would have avoided it",
        NextDriver => "driver shown beside the ego",
        SaveDrive => "save the planned drive",
        Generate => "search for an attack",
        GenerateWith => "search, picked obstacle attacks",
        GenerateWish => "search, by terms",
        ModelAttacks => "model attacks",
        ModelAttacksWith => "model moves the picked obstacle",
        VariantPanel => "about the variant",
        SaveVariant => "save the variant",
        GroupScenarios => "group by country, folder, …",
        TurnOrder => "reverse the order",
        EditTags => "tags of yours",
        Coverage => "coverage of the index",
        ChooseIndex => "choose an index",
        SavedViews => "saved views",
        ReadThresholds => "reread thresholds",
        Mouse => "mouse on/off",
        CollisionStep => "worst moment",
        ContactStep => "first contact",
        MinimumStep => "extreme of the plot",
        NextDifference => "next difference",
        NextDisagreement => "next answer that differs, in the list",
        FirstStep => "first step",
        LastStep => "last step",
        Experiment => "open an experiment file",
        NewExperiment => "new experiment file",
        _ => entry.short,
    }
}

/// The words, separated by spaces.
#[must_use]
pub fn synonyms_of(action: Action) -> &'static str {
    use Action::*;
    match action {
        SavePicture => "figure screenshot image svg png gif animation save export plot",
        ExportRuns => "save write jsonl download runs",
        SaveVariant | SaveDrive => "export write xml csv file",
        Filter => "search find narrow query select",
        SearchRuns => "find filter query",
        Undo | UndoDelete => "undo revert restore back",
        RecordedEgo => "undo revert original reset",
        DiscardDraft => "undo revert discard default shipped",
        ChooseModel => "llm price cost provider gpt claude gemini",
        TaskList => "jobs progress cost price spent money budget queue running",
        AskMarked => "batch many bulk cost price estimate run",
        Run => "send query ask submit",
        RunAnew => "retry repeat resend again",
        Compare => "another second model ask",
        CompareScreen => "diff versus four columns",
        BlindMode => "rate vote preference",
        Ratings => "votes score wins preference",
        Coverage => "corpus heatmap manoeuvre maneuver road severity matrix gaps",
        ChooseIndex => "corpus folder parquet coverage",
        Results => "accuracy precision recall f1 confusion score table statistics percent",
        History => "log past earlier runs answers",
        PlotMeasure => "metric chart graph ttc risk curve",
        Values => "metrics table numbers measures",
        ReadThresholds => "limits critical reload",
        HeatStrips => "timeline heatmap colour",
        PickTheme => "colors colours dark light style appearance",
        Mouse => "click pointer select copy",
        Details => "info inspect obstacle properties",
        About => "info scenario summary warnings notes",
        Source => "xml file raw",
        Layers => "show hide toggle lights signs lanes",
        NextPaths => "prediction trajectory future",
        TakeTape => "measure distance ruler",
        FitMap => "overview whole all reset zoom",
        SplitMap => "two moments side by side compare map before after original beside",
        DriverMap => {
            "ideal certificate survives avoidable side by side compare drives planner evasive"
        }
        Drivers | NextDriver => {
            "preventable avoidable competent careful ideal cc rss fsm r157 nieon"
        }
        PinMoment => "second map keep hold freeze compare here",
        MomentBack | MomentForward => "second map step compare time",
        EgoUp => "rotate heading north",
        Follow => "center centre track ego",
        Edit => "prompt template change write modify",
        OutsideEditor => "vim helix vscode editor external",
        ChooseTemplate => "prompt version library",
        PromptView => "description diff rendered tokens",
        ToggleTask => "question collision safety recording",
        ToggleFrame => "cartesian ego coordinates metrics picture",
        ToggleCp => "contextual prompting technique",
        ToggleCot => "chain of thought reasoning technique",
        ToggleIcl => "few-shot in-context examples technique",
        ToggleTools => "function calls instruments calculator",
        CollisionStep => "danger critical moment crash jump",
        ContactStep => "collision crash impact",
        NextDifference | NextDisagreement => "wrong mistake differ disagree",
        GenerateWish => "wish terms attack",
        Generate => "attack adversarial variant danger",
        DrivePlanner => "plan simulate closed loop autopilot",
        NextPlanner => "external process own planner under test",
        SwitchVariant => "original before after",
        SortScenarios => "order by severity",
        GroupScenarios => "country folder tag collapse",
        EditTags => "label category",
        MarkScenario | UnmarkScenarios => "select choose star",
        Zoom => "maximise maximize fullscreen alone",
        EvenPanes => "layout reset sizes default",
        Quit => "exit leave close",
        Help => "keys bindings shortcuts",
        PlaceBack => "jump list previous return",
        PlaceForward => "jump list next",
        Copy => "clipboard yank",
        Experiment => "open toml study evaluate matrix batch file",
        NewExperiment => "write experiment toml study evaluate batch create",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::{ACTIONS, Scope};
    use super::*;

    #[test]
    fn every_prefix_of_the_table_has_a_title_and_every_title_a_key() {
        let all = ACTIONS.iter().flat_map(|entry| entry.keys);
        let all: Vec<Chord> = all.filter_map(|keys| Chord::parse(keys).ok()).collect();
        for chord in &all {
            for length in 1..chord.0.len() {
                assert!(title_of(&chord.0[..length]).is_some(), "{chord}");
            }
        }
        for (prefix, title) in GROUPS {
            let prefix = Chord::parse(prefix).unwrap();
            assert!(all.iter().any(|chord| prefix.begins(chord)), "{title}");
        }
    }

    #[test]
    fn every_action_takes_three_keys_at_most() {
        for entry in ACTIONS.iter().filter(|e| e.scope == Scope::Global) {
            let shortest = entry.keys.iter().map(|keys| keys.split(' ').count()).min();
            assert!(shortest.is_some_and(|n| n <= 3), "{}", entry.id);
        }
    }
}
