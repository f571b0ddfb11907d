//! The panes of the main screen, and keyboard focus.

use crate::action::{Action, Scope};

/// The panes of the main screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Pane {
    /// The list of scenarios.
    Scenarios,
    /// The map from above.
    Map,
    /// Danger over time.
    Timeline,
    /// The prompt.
    Prompt,
    /// Verdicts side by side.
    Verdict,
    /// The reasoning of one answer.
    Reasoning,
    /// A measure over time.
    Plot,
}

impl Pane {
    /// Every pane that can have the keys, in the order of Tab.
    pub const ALL: [Self; 6] = [
        Self::Scenarios,
        Self::Map,
        Self::Prompt,
        Self::Verdict,
        Self::Reasoning,
        Self::Plot,
    ];

    /// Its name in session files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Scenarios => "scenarios",
            Self::Map => "map",
            Self::Timeline => "timeline",
            Self::Prompt => "prompt",
            Self::Verdict => "verdict",
            Self::Reasoning => "reasoning",
            Self::Plot => "plot",
        }
    }

    /// The actions everywhere that belong to it.
    #[must_use]
    pub fn actions(self) -> &'static [Action] {
        use Action::*;
        match self {
            Self::Scenarios => &[
                Filter,
                SortScenarios,
                TurnOrder,
                GroupScenarios,
                EditTags,
                MarkScenario,
                UnmarkScenarios,
                AskMarked,
            ],
            Self::Map | Self::Timeline => &[
                ZoomIn,
                ZoomOut,
                Follow,
                EgoUp,
                FitMap,
                NextObstacle,
                PreviousObstacle,
                SplitMap,
                PinMoment,
                Layers,
                NextPaths,
                TakeTape,
            ],
            Self::Prompt => &[
                Edit,
                PromptView,
                ToggleTask,
                ToggleFrame,
                ToggleCp,
                ToggleCot,
                ToggleIcl,
                ToggleTools,
                ChooseTemplate,
                DiscardDraft,
                OutsideEditor,
            ],
            Self::Verdict => &[
                Compare,
                CompareScreen,
                BlindMode,
                PreviousAnswer,
                NextAnswer,
                CloseAnswer,
            ],
            Self::Reasoning => &[
                NextClaim,
                PreviousClaim,
                PreviousAnswer,
                NextAnswer,
                CompareScreen,
                Copy,
            ],
            Self::Plot => &[
                PlotMeasure,
                MinimumStep,
                Mark,
                NextObstacle,
                PreviousObstacle,
                PlotDrives,
                HeatStrips,
            ],
        }
    }

    /// The scope of its keys.
    #[must_use]
    pub fn scope(self) -> Scope {
        match self {
            Self::Scenarios => Scope::Scenarios,
            Self::Map => Scope::Map,
            Self::Prompt | Self::Reasoning | Self::Verdict => Scope::Text,
            Self::Plot => Scope::Plot,
            Self::Timeline => Scope::Global,
        }
    }
}
