//! The table of actions: names, descriptions and the contexts they work in.
//!
//! Key bindings, footer, help and palette are generated from it.

mod default_keys;
mod words;

pub use default_keys::{ACTIONS, Action};
pub use words::{menu_label, order_of, synonyms_of, title_of};

impl Action {
    /// How far an action moves a list or a text, lines down, where a page has so many.
    pub fn lines(self, page: isize) -> isize {
        match self {
            Self::Up => -1,
            Self::Down => 1,
            Self::PageUp => -page,
            Self::PageDown => page,
            Self::Top => isize::MIN,
            _ => isize::MAX,
        }
    }
}

/// The context in which an action works.
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
    /// On the plot.
    Plot,
    /// In a window over the others.
    Window,
    /// In the history of runs.
    History,
    /// In the list of tasks.
    Jobs,
    /// On the screen of results.
    Results,
    /// On the coverage map of an index.
    Coverage,
    /// On the screen of an experiment.
    Experiment,
    /// In the template editor, where keys write and nothing else holds.
    Editor,
    /// On the screen of answers side by side, which has keys for everything itself.
    Compare,
}

impl Scope {
    /// Every scope with its name in keymap files and its description.
    pub const ALL: [(Self, &'static str, &'static str); 13] = [
        (Self::Global, "global", "everywhere"),
        (Self::Scenarios, "scenarios", "in the list of scenarios"),
        (Self::Map, "map", "on the map"),
        (Self::Text, "text", "in prompt, verdict and reasoning"),
        (Self::Plot, "plot", "on the plot"),
        (Self::Window, "window", "in a window"),
        (Self::History, "history", "in the history of runs"),
        (Self::Jobs, "tasks", "in the list of tasks"),
        (Self::Results, "results", "on the screen of results"),
        (Self::Coverage, "coverage", "on the coverage map"),
        (
            Self::Experiment,
            "experiment",
            "on the screen of an experiment",
        ),
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

    /// Where it is, in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        let found = Self::ALL.iter().find(|(scope, ..)| *scope == self);
        found.map_or("", |(.., words)| words)
    }

    /// Whether it is a full screen, where of the global keys only [`EVEN_THERE`] work.
    #[must_use]
    pub fn is_own(self) -> bool {
        matches!(
            self,
            Self::History
                | Self::Jobs
                | Self::Results
                | Self::Coverage
                | Self::Experiment
                | Self::Editor
                | Self::Compare
        )
    }
}

/// Global actions that work even on full screens.
pub const EVEN_THERE: [Action; 8] = [
    Action::Quit,
    Action::Help,
    Action::Palette,
    Action::Cancel,
    Action::Suspend,
    Action::History,
    Action::TaskList,
    Action::SavePicture,
];

/// Whether an action opens a screen wherever it is performed.
#[must_use]
pub fn opens(action: Action) -> bool {
    use Action::*;
    matches!(
        action,
        Help | About
            | Values
            | Details
            | Drivers
            | PlannerCycle
            | VariantPanel
            | Layers
            | Palette
            | PickTheme
            | ChooseModel
            | PlotMeasure
            | SortScenarios
            | SavePicture
            | ChooseTemplate
            | EditTags
            | Source
            | History
            | TaskList
            | Results
            | Experiment
            | Coverage
    )
}

/// Actions that give the focus to another pane.
pub const MOVES_FOCUS: [Action; 6] = [
    Action::NextPane,
    Action::PreviousPane,
    Action::FocusLeft,
    Action::FocusDown,
    Action::FocusUp,
    Action::FocusRight,
];

/// A line of the table.
#[derive(Debug)]
pub struct Entry {
    /// The action.
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
            // The editor types unbound keys, and blind mode shows little.
            Scope::Editor | Scope::Compare => false,
            scope => !scope.is_own() || EVEN_THERE.contains(&self.action),
        };
        self.scope == scope || (self.scope == Scope::Global && everywhere)
    }

    /// The full screen that alone has its action, if that is not `here`.
    #[must_use]
    pub fn elsewhere(&self, here: Scope) -> Option<Scope> {
        let mut same = ACTIONS.iter().filter(|entry| entry.action == self.action);
        let is_here = same.any(|entry| !entry.scope.is_own() || entry.scope == here);
        (!is_here).then_some(self.scope)
    }

    /// Whether a key can be pressed that does both.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        self.holds_in(other.scope) || other.holds_in(self.scope)
    }
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
