//! `generate --set KEY=VALUE`: settings of the planner, and how a model is asked.

use crate::plan::PlannerSettings;
use crate::set::{Settable, number, on_or_off};
use nearmiss_base::system::unknown;
use nearmiss_settings::Config;
use nearmiss_study::evaluation::generating::{Method, RETRIES, Ranking, SAMPLES, VOTES};

/// What `--set` changes.
#[derive(Debug, Clone)]
pub struct GenerateSettings {
    /// The planner.
    pub planner: PlannerSettings,
    votes: u32,
    /// Metres within which the model chooses the attacker.
    within: Option<f64>,
    samples: u32,
    retries: u32,
    feedback: bool,
    /// Whether the model grades its motions.
    pub grades: bool,
    /// What decides between its motions.
    pub rank: Ranking,
    /// Whether nothing is generated where the model names no possible attacker.
    pub obey: bool,
}

impl Default for GenerateSettings {
    fn default() -> Self {
        Self {
            planner: PlannerSettings::default(),
            votes: VOTES,
            within: None,
            samples: SAMPLES,
            retries: RETRIES,
            feedback: true,
            grades: true,
            rank: Ranking::default(),
            obey: false,
        }
    }
}

impl Settable for GenerateSettings {
    fn keys() -> Vec<&'static str> {
        let asked = vec![
            "votes", "within", "samples", "retries", "feedback", "grades", "rank", "obey",
        ];
        [PlannerSettings::keys(), asked].concat()
    }

    fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        match key {
            "votes" => self.votes = number(value, 1, 1000)?,
            "within" => self.within = Some(metres(value)?),
            "samples" => self.samples = number(value, 1, 1000)?,
            "retries" => self.retries = number(value, 0, 100)?,
            "feedback" => self.feedback = on_or_off(value)?,
            "grades" => self.grades = on_or_off(value)?,
            "rank" => self.rank = ranking(value)?,
            "obey" => self.obey = on_or_off(value)?,
            _ => self.planner.set(key, value)?,
        }
        Ok(())
    }
}

impl GenerateSettings {
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

fn ranking(word: &str) -> Result<Ranking, String> {
    Ranking::parse(word).ok_or_else(|| unknown("ranking", word, Ranking::ALL.map(Ranking::name)))
}

fn metres(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(metres) if metres.is_finite() && metres > 0.0 => Ok(metres),
        _ => Err("expected a number of metres above 0".into()),
    }
}
