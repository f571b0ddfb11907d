//! How attackers move: as people do, or as far as their vehicles can.

use super::Capability;
use crate::planner::Limits;
use nearmiss_scene::scenario::HumanLimits;

/// The limits that attackers keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum AttackStyle {
    /// Those of people, by kind of road user; see [`HumanLimits`].
    #[default]
    Human,
    /// Those of the vehicle.
    Limit,
}

impl AttackStyle {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Human, Self::Limit];

    /// Its name in options and documents.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Human => "human",
            Self::Limit => "limit",
        }
    }

    /// The style of this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|style| style.name() == name)
    }
}

impl std::fmt::Display for AttackStyle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// What squared jerks of people cost: 2 m/s³ as much as 0.2 m off the way.
const JERK_COST: f64 = 1e-2;

impl Capability {
    /// What is left of it to a person who keeps these limits.
    #[must_use]
    pub fn of_person(self, person: &HumanLimits) -> Self {
        let limits = &self.limits;
        Self {
            limits: Limits {
                acceleration: limits.acceleration.min(person.braking),
                steering: limits
                    .steering
                    .min((limits.wheelbase / person.radius).atan()),
                speed: limits.speed.min(person.speed),
                ..*limits
            },
            jerk: self.jerk.min(person.jerk),
            jerk_cost: JERK_COST,
            speeding_up: self.speeding_up.min(person.speeding_up),
            lateral: self.lateral.min(person.lateral),
            ..self
        }
    }
}
