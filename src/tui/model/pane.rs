//! The panes of the main screen, and how much room each gets.

use ratatui::layout::{Position, Rect};
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

use crate::action::{Action, Scope};

/// The panes of the main screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
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
        self.into()
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

/// An arrangement of panes; each has sizes of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrangement {
    /// Three columns.
    Wide,
    /// Two columns, in which panes take turns.
    Compact,
    /// One column.
    Narrow,
}

/// A border that can be moved, by the pane that it makes wider or higher.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// The list of scenarios: its width, in two columns its height, in one column that of the map below it.
    List,
    /// The column on the right: its width.
    Right,
    /// The prompt: its height.
    Prompt,
    /// The timeline: its height.
    Timeline,
    /// The verdicts: their height; in one column that of the pane below the map or the prompt.
    Verdict,
    /// The plot: its height; in one column that of the lowest pane.
    Plot,
}

/// Pane sizes set by the user, as fractions of the screen's width or height; others keep their defaults.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PaneShares {
    list: Option<f64>,
    right: Option<f64>,
    prompt: Option<f64>,
    timeline: Option<f64>,
    verdict: Option<f64>,
    plot: Option<f64>,
}

/// The sizes of the panes in each arrangement.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sizes {
    /// In three columns.
    pub wide: PaneShares,
    /// In two columns.
    pub compact: PaneShares,
    /// In one column.
    #[serde(skip_serializing_if = "PaneShares::is_usual")]
    pub narrow: PaneShares,
}

impl PaneShares {
    /// Whether no border was moved.
    fn is_usual(&self) -> bool {
        *self == Self::default()
    }

    fn share(&mut self, edge: Edge) -> &mut Option<f64> {
        match edge {
            Edge::List => &mut self.list,
            Edge::Right => &mut self.right,
            Edge::Prompt => &mut self.prompt,
            Edge::Timeline => &mut self.timeline,
            Edge::Verdict => &mut self.verdict,
            Edge::Plot => &mut self.plot,
        }
    }

    /// Columns or rows of `total` where a border stands: as it was moved, else as `usual`; never beyond its limits.
    #[must_use]
    pub fn cells(mut self, edge: Edge, total: u16, usual: u16, limits: (u16, u16)) -> u16 {
        let (least, most) = limits;
        let share = *self.share(edge);
        // A saved value may be no valid fraction.
        let moved = share.filter(|share| (0.0..=1.0).contains(share));
        let wanted = moved.map_or(usual, |share| (share * f64::from(total)).round() as u16);
        wanted.min(most).max(least)
    }
}

/// A border as it was drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Border {
    /// Which one.
    pub edge: Edge,
    /// The arrangement that it belongs to.
    pub arrangement: Arrangement,
    /// The cells where the mouse can take it: the last line of one pane and the first of the next.
    pub strip: Rect,
    /// Whether it stands upright, and moves sideways.
    pub upright: bool,
    /// Whether its pane lies before it: on the left, or above.
    pub before: bool,
    /// Columns or rows that its pane has.
    pub size: u16,
    /// The fewest and the most that it may have.
    pub limits: (u16, u16),
    /// Columns or rows of the screen, of which that is a part.
    pub total: u16,
}

impl Border {
    /// Where the border would be if it were taken from one position of the screen to another.
    #[must_use]
    pub fn dragged(&self, from: Position, to: Position) -> u16 {
        let by = if self.upright {
            i32::from(to.x) - i32::from(from.x)
        } else {
            i32::from(to.y) - i32::from(from.y)
        };
        self.moved(if self.before { by } else { -by })
    }

    /// The size of its pane with this many more columns or rows, within the limits.
    #[must_use]
    pub fn moved(&self, by: i32) -> u16 {
        let (least, most) = (i32::from(self.limits.0), i32::from(self.limits.1));
        let wanted = (i32::from(self.size) + by).min(most).max(least);
        u16::try_from(wanted).unwrap_or(self.size)
    }
}

impl Sizes {
    /// Resizes the pane of a border to this many columns or rows.
    pub fn set(&mut self, border: &Border, cells: u16) {
        let shares = match border.arrangement {
            Arrangement::Wide => &mut self.wide,
            Arrangement::Compact => &mut self.compact,
            Arrangement::Narrow => &mut self.narrow,
        };
        *shares.share(border.edge) = Some(f64::from(cells) / f64::from(border.total.max(1)));
    }
}
