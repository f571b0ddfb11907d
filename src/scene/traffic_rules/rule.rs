//! The rules, their names and sources, and what can become of them.

/// A rule of the road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Rule {
    /// R-G1: enough distance to the vehicle in front to stop behind it.
    SafeDistance,
    /// R-G2: no abrupt braking without a reason.
    UnnecessaryBraking,
    /// R-G3: no faster than the limit of the lane.
    SpeedLimit,
    /// R-IN1: a stop at the line of a stop sign.
    StopSign,
    /// R-IN2: no crossing of the line at red, nor at yellow where a comfortable stop is possible.
    RedLight,
    /// R-IN3: right before left, where neither signs nor lights decide.
    RightBeforeLeft,
    /// R-IN4: the right of way of others by signs.
    Priority,
    /// R-IN5: oncoming traffic before one's own left turn.
    LeftTurn,
}

/// What became of a rule in a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RuleStatus {
    /// It was broken.
    Broken,
    /// It applied, and was obeyed.
    Obeyed,
    /// There was no occasion for it.
    NotApplicable,
    /// The scenario does not say what is needed to decide it.
    Undecided,
}

/// Below this speed a vehicle stands, m/s: recordings are noisy.
pub const STANDING: f64 = 0.1;

/// Seconds that a vehicle has to stand at a stop sign (t_slw of the implementations of R-IN1; the law asks for a
/// standstill without saying how long).
pub const STOP_SECONDS: f64 = 3.0;

/// Seconds within which another vehicle must not follow into an area of conflict (t_ib of R-IN3 to R-IN5).
pub const YIELD_BEFORE: f64 = 1.0;

/// Seconds for which an area of conflict is not entered after another vehicle left it (t_ia).
pub const YIELD_AFTER: f64 = 0.5;

impl Rule {
    /// All of them, in the order of reports.
    pub const ALL: [Self; 8] = [
        Self::SafeDistance,
        Self::UnnecessaryBraking,
        Self::SpeedLimit,
        Self::StopSign,
        Self::RedLight,
        Self::RightBeforeLeft,
        Self::Priority,
        Self::LeftTurn,
    ];

    /// Its name in documents and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::SafeDistance => "safe_distance",
            Self::UnnecessaryBraking => "unnecessary_braking",
            Self::SpeedLimit => "speed_limit",
            Self::StopSign => "stop_sign",
            Self::RedLight => "red_light",
            Self::RightBeforeLeft => "right_before_left",
            Self::Priority => "priority",
            Self::LeftTurn => "left_turn",
        }
    }

    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::SafeDistance => "safe distance",
            Self::UnnecessaryBraking => "unnecessary braking",
            Self::SpeedLimit => "speed limit",
            Self::StopSign => "stop sign",
            Self::RedLight => "red light",
            Self::RightBeforeLeft => "right before left",
            Self::Priority => "priority",
            Self::LeftTurn => "left turn",
        }
    }

    /// Its number in the formalisation.
    #[must_use]
    pub fn number(self) -> &'static str {
        match self {
            Self::SafeDistance => "R-G1",
            Self::UnnecessaryBraking => "R-G2",
            Self::SpeedLimit => "R-G3",
            Self::StopSign => "R-IN1",
            Self::RedLight => "R-IN2",
            Self::RightBeforeLeft => "R-IN3",
            Self::Priority => "R-IN4",
            Self::LeftTurn => "R-IN5",
        }
    }

    /// What a violation is measured in.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::SafeDistance => "m",
            Self::UnnecessaryBraking => "m/s²",
            Self::SpeedLimit | Self::RedLight => "m/s",
            Self::StopSign | Self::RightBeforeLeft | Self::Priority | Self::LeftTurn => "s",
        }
    }
}

impl RuleStatus {
    /// Its name in documents and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Broken => "broken",
            Self::Obeyed => "obeyed",
            Self::NotApplicable => "not_applicable",
            Self::Undecided => "undecided",
        }
    }
}
