//! Map layers that can be switched on and off, in one struct that can be saved.

use serde::{Deserialize, Serialize};

/// Selects the obstacles whose predicted paths are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Foreseen {
    /// No paths.
    #[default]
    Off,
    /// The picked obstacle's.
    Picked,
    /// Those of everyone near the ego, and the ego's own.
    Near,
}

impl Foreseen {
    /// The one after it.
    #[must_use]
    pub fn next(self) -> Self {
        match self {
            Self::Off => Self::Picked,
            Self::Picked => Self::Near,
            Self::Near => Self::Off,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Picked => "of the picked one",
            Self::Near => "of all near the ego",
        }
    }
}

/// Selects whose trails are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", from = "SavedTrails")]
pub enum Trails {
    /// Of no obstacle.
    Off,
    /// The ego's and the picked obstacle's.
    #[default]
    Picked,
    /// Everyone's.
    All,
}

/// Trails as sessions hold them; older ones say whether there are any.
#[derive(Deserialize)]
#[serde(untagged)]
enum SavedTrails {
    Any(bool),
    Whose(SavedWhose),
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum SavedWhose {
    Off,
    Picked,
    All,
}

impl From<SavedTrails> for Trails {
    fn from(saved: SavedTrails) -> Self {
        match saved {
            SavedTrails::Any(false) | SavedTrails::Whose(SavedWhose::Off) => Self::Off,
            SavedTrails::Any(true) | SavedTrails::Whose(SavedWhose::Picked) => Self::Picked,
            SavedTrails::Whose(SavedWhose::All) => Self::All,
        }
    }
}

impl Trails {
    /// The one after it.
    #[must_use]
    pub fn next(self) -> Self {
        match self {
            Self::Off => Self::Picked,
            Self::Picked => Self::All,
            Self::All => Self::Off,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Picked => "of the ego and the picked one",
            Self::All => "of all",
        }
    }
}

/// The layers of the map.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Layers {
    /// Markings of lanes, crossings and driving directions.
    pub lanes: bool,
    /// Traffic signs.
    pub signs: bool,
    /// Traffic lights and stop lines.
    pub lights: bool,
    /// Whose past and recorded future is drawn.
    pub trails: Trails,
    /// Predicted and counterfactual paths.
    pub paths: Foreseen,
    /// Occupancy sets.
    pub occupancy: bool,
    /// Names beside vehicles.
    pub labels: bool,
    /// Goals of the planning problems.
    pub goal: bool,
    /// The planner's candidates and choice, and the recorded ego beside the planned one.
    pub planner: bool,
    /// The planner's candidates that cannot be driven.
    pub rejected: bool,
    /// The two motions of a variant's attacker.
    pub variant: bool,
    /// The picture that models are shown in place of the map, in terminals that show images.
    pub shown: bool,
}

impl Default for Layers {
    fn default() -> Self {
        Self {
            lanes: true,
            signs: true,
            lights: true,
            trails: Trails::Picked,
            paths: Foreseen::Off,
            occupancy: true,
            labels: true,
            goal: true,
            planner: true,
            rejected: false,
            variant: true,
            shown: false,
        }
    }
}

impl Layers {
    /// How many layers there are.
    pub const COUNT: usize = 12;

    /// Every layer: what it is, and how it is switched.
    #[must_use]
    pub fn rows(&self) -> [(&'static str, &'static str); Self::COUNT] {
        let on = |on: bool| if on { "on" } else { "off" };
        [
            ("lane markings and directions", on(self.lanes)),
            ("signs", on(self.signs)),
            ("lights and stop lines", on(self.lights)),
            ("trails", self.trails.name()),
            ("predicted paths", self.paths.name()),
            ("occupancy sets", on(self.occupancy)),
            ("labels", on(self.labels)),
            ("goals", on(self.goal)),
            ("planner's candidates and choice", on(self.planner)),
            ("planner's rejected candidates", on(self.rejected)),
            ("both motions of a variant's attacker", on(self.variant)),
            ("the picture for models, as an image", on(self.shown)),
        ]
    }

    /// Switches the layer in this row of [`Layers::rows`].
    pub fn switch(&mut self, row: usize) {
        let layer = match row {
            0 => &mut self.lanes,
            1 => &mut self.signs,
            2 => &mut self.lights,
            3 => {
                self.trails = self.trails.next();
                return;
            }
            4 => {
                self.paths = self.paths.next();
                return;
            }
            5 => &mut self.occupancy,
            6 => &mut self.labels,
            7 => &mut self.goal,
            8 => &mut self.planner,
            9 => &mut self.rejected,
            10 => &mut self.variant,
            11 => &mut self.shown,
            _ => return,
        };
        *layer = !*layer;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_row_switches_what_it_names_and_is_kept() {
        for row in 0..Layers::COUNT {
            let mut layers = Layers::default();
            layers.switch(row);
            let changed =
                (0..Layers::COUNT).filter(|&r| layers.rows()[r] != Layers::default().rows()[r]);
            assert_eq!(changed.collect::<Vec<_>>(), [row]);
            let saved = toml::to_string(&layers).unwrap();
            assert_eq!(toml::from_str::<Layers>(&saved).unwrap(), layers);
        }
        let old: Layers = toml::from_str("signs = false").unwrap();
        assert!(!old.signs && old.lanes, "what is not said is as usual");
        // Sessions written before trails were chosen said only whether there are any.
        for (saved, trails) in [
            ("true", Trails::Picked),
            ("false", Trails::Off),
            ("\"all\"", Trails::All),
        ] {
            let old: Layers = toml::from_str(&format!("trails = {saved}")).unwrap();
            assert_eq!(old.trails, trails);
        }
    }
}
