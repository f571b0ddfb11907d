//! The JSON line of one scenario's variant, and the figures in it that table and report use.
//!
//! Both read only the line, so one taken over from an earlier run counts like a new one.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::Value;

use nearmiss_drive::generation::MotionSamples;
use nearmiss_drive::simulation::CollisionKind;
use nearmiss_study::evaluation::generating::Tries;

/// The outcome of a scenario without a variant.
pub const NONE: &str = "none";

/// A line with its figures.
#[derive(Debug, Clone)]
pub struct Line {
    pub document: Value,
    pub figures: Figures,
}

/// Figures of a line that are counted and shown.
#[derive(Debug, Clone, Deserialize)]
pub struct Figures {
    pub scenario: String,
    #[serde(default)]
    pub file: Option<String>,
    pub outcome: OutcomeName,
    pub attacker: Option<i64>,
    /// All attackers; of versions that knew only one none.
    #[serde(default)]
    pub attackers: Option<Vec<AttackerFigures>>,
    pub manoeuvre: Option<String>,
    pub min_risk_before: Option<u8>,
    pub min_risk_after: Option<u8>,
    /// Reaction times (s) and whether a good driver avoids it.
    pub avoidable: Option<BTreeMap<String, bool>>,
    pub candidates: usize,
    /// Motions that were refused, by reason.
    pub refused: BTreeMap<String, usize>,
    pub id: Option<String>,
    pub note: Option<String>,
    pub safe_before: bool,
    /// Of versions that did not measure it none.
    #[serde(default)]
    pub plausibility: Option<LogLikelihoods>,
    #[serde(default)]
    pub motion_samples: Option<ComparedSamples>,
    /// How the ego's drive in the variant ended.
    pub drive: Option<String>,
    /// Which body drove into which at its end, also where that is no effect.
    #[serde(default)]
    pub collision_kind: Option<String>,
    /// The step before a contact between steps.
    #[serde(default)]
    pub touched_after_step: Option<i64>,
    /// Of versions that did not review it none.
    #[serde(default)]
    pub good_driver: Option<GoodDriver>,
    pub model: Option<Consumed>,
    /// The planner that is attacked, as it was named; of versions that attacked only their own none.
    #[serde(default)]
    pub planner: Option<String>,
    /// What its process says of itself.
    #[serde(default)]
    pub external_planner: Option<PlannerFigures>,
    pub taken_over: bool,
    pub seconds: f64,
}

/// One attacker and its motion.
#[derive(Debug, Clone, Deserialize)]
pub struct AttackerFigures {
    pub id: i64,
    pub manoeuvre: String,
}

/// The driver of the longest reaction time who survives.
#[derive(Debug, Clone, Deserialize)]
pub struct GoodDriver {
    /// m/s²; of versions that did not measure it none.
    #[serde(default)]
    pub max_acceleration: Option<f64>,
    #[serde(default)]
    pub rules_broken: Vec<String>,
    #[serde(default)]
    pub leaves_roadway_step: Option<i64>,
}

/// What a planner's process says of itself.
#[derive(Debug, Clone, Deserialize)]
pub struct PlannerFigures {
    #[serde(default)]
    pub name: String,
    #[serde(default)]
    pub version: String,
}

/// Log-likelihoods, nats per second.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct LogLikelihoods {
    #[serde(rename = "log_likelihood_per_second")]
    pub attacker: f64,
    #[serde(rename = "recorded_log_likelihood_per_second")]
    pub recorded: f64,
}

/// Samples of the attacker's motion and of the recorded ones.
#[derive(Debug, Clone, Deserialize)]
pub struct ComparedSamples {
    pub attacker: MotionSamples,
    pub recorded: MotionSamples,
}

/// The outcomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OutcomeName {
    Collision,
    PlannerError,
    NearMiss,
    NoEffect,
    None,
}

/// A model's consumption.
#[derive(Debug, Clone, Deserialize)]
pub struct Consumed {
    pub requests: u32,
    #[serde(default)]
    pub from_store: u32,
    pub input_tokens: u64,
    pub output_tokens: u64,
    pub cost_usd: f64,
    pub unpriced: u32,
    /// Why it did not get to the end, where it did not.
    pub stopped: Option<String>,
    /// Of versions that did not count them none.
    #[serde(default)]
    pub tries: Option<Tries>,
    /// Whether its grades and the exact ranking prefer the same motion; none where there was nothing to compare.
    #[serde(default)]
    pub agreement: Option<Agreed>,
}

/// Whether both rankings prefer the same motion, of how many.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Agreed {
    pub agrees: bool,
    pub of: usize,
    /// Of versions that counted equal motions as different ones none.
    #[serde(default)]
    pub by_chance: Option<f64>,
}

impl OutcomeName {
    pub fn name(self) -> &'static str {
        match self {
            Self::Collision => "collision",
            Self::PlannerError => "planner_error",
            Self::NearMiss => "near_miss",
            Self::NoEffect => "no_effect",
            Self::None => NONE,
        }
    }

    pub fn is_effective(self) -> bool {
        matches!(self, Self::Collision | Self::NearMiss)
    }
}

impl Line {
    /// The line with this document.
    ///
    /// # Errors
    /// A field is missing or of another type.
    pub fn from_document(document: Value) -> Result<Self, String> {
        match Figures::deserialize(&document) {
            Ok(figures) => Ok(Self { document, figures }),
            Err(error) => Err(error.to_string()),
        }
    }
}

impl Figures {
    /// The ids of all attackers.
    pub fn ids(&self) -> Vec<i64> {
        match &self.attackers {
            Some(all) => all.iter().map(|one| one.id).collect(),
            None => self.attacker.into_iter().collect(),
        }
    }

    /// The planner that is attacked: as it was named, and as its process names itself.
    pub fn attacked(&self) -> Option<String> {
        let named = self.planner.clone()?;
        Some(match &self.external_planner {
            Some(said) if !said.name.is_empty() => {
                let said = format!("{} {}", said.name, said.version);
                format!("{} ({named})", said.trim())
            }
            _ => named,
        })
    }

    /// Whether its drive ended with a hit from behind, which is no effect.
    pub fn is_hit_from_behind(&self) -> bool {
        let kind = self.collision_kind.as_deref();
        kind == Some(CollisionKind::RearEnded.name()) && self.outcome != OutcomeName::Collision
    }

    /// What the attackers do: the names of their manoeuvres.
    pub fn manoeuvres(&self) -> Option<String> {
        match &self.attackers {
            Some(all) if !all.is_empty() => {
                let names: Vec<&str> = all.iter().map(|one| one.manoeuvre.as_str()).collect();
                Some(names.join(" + "))
            }
            _ => self.manoeuvre.clone(),
        }
    }

    /// What the good driver who survives does that is to be noted: broken rules, leaving the roadway.
    pub fn good_driver_note(&self) -> Option<String> {
        let driver = self.good_driver.as_ref()?;
        let rules = (!driver.rules_broken.is_empty())
            .then(|| format!("breaks {}", driver.rules_broken.join(", ")));
        let leaves = driver
            .leaves_roadway_step
            .map(|step| format!("leaves the lanelets of cars at step {step}"));
        let both: Vec<String> = rules.into_iter().chain(leaves).collect();
        (!both.is_empty()).then(|| format!("the good driver {}", both.join(" and ")))
    }

    /// The longest reaction time (s) with which a good driver avoids it.
    pub fn latest(&self) -> Option<&str> {
        let all = self.avoidable.iter().flatten();
        let avoided = all.filter(|(_, avoided)| **avoided);
        avoided.map(|(delay, _)| delay.as_str()).next_back()
    }
}
