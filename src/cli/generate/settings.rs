//! `generate --set KEY=VALUE`: settings of the planner, and how a model is asked.

use nearmiss_base::system::unknown;
use nearmiss_record::fields::{Fields, Layers};
use nearmiss_settings::{Config, Planning};
use nearmiss_study::evaluation::generating::{Method, RETRIES, Ranking, SAMPLES, VOTES};

use crate::{Failure, knobs, plan};

nearmiss_record::fields! {
    /// How a model is asked.
    pub struct AskSettings {
        "model" {
            /// Votes for the attacker.
            votes: u32 = VOTES, Takes::Whole(1, 1000);
            /// The model chooses the attacker within this distance; by default as the configuration says.
            within: Option<f64>, Takes::Above(0.0, 1e6), "m";
            /// Motions.
            samples: u32 = SAMPLES, Takes::Whole(1, 1000);
            /// How often a motion goes back to the model.
            retries: u32 = RETRIES, Takes::Whole(0, 100);
            /// Whether what came of the drive goes back to the model.
            feedback: bool = true;
            /// Whether the model grades its motions.
            grades: bool = true;
            /// What decides between its motions.
            rank: Ranking;
            /// Whether nothing is generated where the model names no possible attacker.
            obey: bool;
        }
    }
}

/// Every key.
pub fn keys() -> impl Iterator<Item = String> {
    Planning::keys().chain(AskSettings::rows().iter().map(|row| row.key.into()))
}

/// What is set.
pub fn read(set: &[(String, String)], config: &Config) -> Result<(Planning, AskSettings), Failure> {
    let keys: Vec<String> = keys().collect();
    if let Some((key, _)) = set.iter().find(|(key, _)| !keys.contains(key)) {
        let keys = keys.iter().map(String::as_str);
        return Err(Failure::input(unknown("key", key, keys)));
    }
    let (asking, planning): (Vec<_>, Vec<_>) =
        { set.iter().cloned() }.partition(|(key, _)| AskSettings::row(key).is_ok());
    let asking = knobs::read(Layers::default(), &asking)?;
    Ok((plan::planning(&planning, config)?, asking))
}

impl AskSettings {
    /// How a model is asked.
    pub fn method(&self, config: &Config) -> Method {
        Method {
            votes: self.votes,
            within: self.within.unwrap_or(config.attack_within),
            samples: self.samples,
            retries: self.retries,
            feedback: self.feedback,
            grades: self.grades,
            rank: self.rank,
        }
    }
}
