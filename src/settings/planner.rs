//! `[planner]` of `config.toml`, and `--set` of `plan` and `generate`: the settings of drives by their keys.

use nearmiss_drive::planner::{self, Forecast, RuleMode, Sampling, Weights};
use nearmiss_drive::simulation::{Settings, TrafficMode};
use nearmiss_record::fields::Fields;
use nearmiss_scene::scenario::VehicleType;
use toml::{Table, Value};

use super::validation::wrong;
use super::{Config, external_planner};

fn usual() -> planner::Settings {
    planner::Settings::default()
}

nearmiss_record::fields! {
    /// How motions are planned.
    pub struct Planning {
        "planner" {
            /// How far ahead is planned.
            horizon: f64 = usual().horizon, Takes::Number(0.5, 20.0), "s";
            /// Steps that are driven of a plan before the next one.
            replan: usize = 1, Takes::Whole(1, 1000), "steps";
            /// What the planner takes for the others' future.
            prediction: Forecast = Forecast::Lane;
            /// What the others do.
            traffic: TrafficMode;
            /// Whether lights, signs and right of way are obeyed.
            rules: RuleMode;
            /// Number of the CommonRoad vehicle.
            vehicle: u32 = usual().vehicle.number().into(), Takes::Whole(1, 4);
            /// Share of the vehicle's forces and steering that plans use.
            share: f64 = usual().share, Takes::Number(0.1, 1.0);
            /// Below this speed the offset is planned over the length of the way instead of time.
            low_speed: f64 = usual().low_speed, Takes::Number(0.0, 20.0), "m/s";
            /// What is kept free around predicted bodies.
            margin: f64 = usual().margin, Takes::Number(0.0, 5.0), "m";
            /// Deceleration that stopping distances are worked out with.
            braking: f64 = usual().braking, Takes::Number(0.5, 20.0), "m/s²";
            /// Reaction time that stopping distances are worked out with.
            reaction: f64 = usual().reaction, Takes::Number(0.0, 5.0), "s";
            /// Seconds that a planner's process may take for a cycle; by default as its table says.
            timeout [run]: Option<f64>, Takes::Number(0.001, 3600.0), "s";
            /// Density of the samples.
            sampling: Sampling;
            /// Weights of the terms of the cost.
            weights: Weights;
        }
    }
}

impl Planning {
    /// The values that drives have, by key: those of its tables as `weights.risk`, last.
    #[must_use]
    pub fn values(settings: &Settings) -> Vec<(String, Value)> {
        let own = Self::from(settings);
        let mut all = values("", &own);
        all.retain(|(_, value)| !value.is_table());
        all.extend(values("sampling.", &own.sampling));
        all.extend(values("weights.", &own.weights));
        all
    }

    /// Every key, as [`Planning::values`] has them.
    pub fn keys() -> impl Iterator<Item = String> {
        let settings = Settings::from(&Self::default());
        let keys = Self::values(&settings).into_iter().map(|(key, _)| key);
        keys.chain(["timeout".into()])
    }
}

fn values<F: Fields>(table: &str, fields: &F) -> Vec<(String, Value)> {
    let rows = F::rows().iter();
    let value = |key: &str| Some((format!("{table}{key}"), fields.value(key)?));
    rows.filter_map(|row| value(row.key)).collect()
}

impl From<&Settings> for Planning {
    fn from(settings: &Settings) -> Self {
        let planner = &settings.planner;
        Self {
            horizon: planner.horizon,
            replan: settings.replan,
            prediction: settings.forecast,
            traffic: settings.traffic,
            rules: planner.rules,
            vehicle: planner.vehicle.number().into(),
            share: planner.share,
            low_speed: planner.low_speed,
            margin: planner.margin,
            braking: planner.braking,
            reaction: planner.reaction,
            timeout: None,
            sampling: planner.sampling,
            weights: planner.weights,
        }
    }
}

impl From<&Planning> for Settings {
    fn from(planning: &Planning) -> Self {
        let vehicle = VehicleType::parse(&planning.vehicle.to_string());
        Self {
            planner: planner::Settings {
                vehicle: vehicle.unwrap_or(usual().vehicle),
                horizon: planning.horizon,
                sampling: planning.sampling,
                weights: planning.weights,
                share: planning.share,
                low_speed: planning.low_speed,
                margin: planning.margin,
                braking: planning.braking,
                reaction: planning.reaction,
                rules: planning.rules,
            },
            forecast: planning.prediction,
            replan: planning.replan,
            without: None,
            traffic: planning.traffic,
        }
    }
}

impl Config {
    /// How motions are planned, as the section `[planner]` of the file says.
    #[must_use]
    pub fn planning(&self) -> Planning {
        let mut own = self.planner.clone();
        own.retain(|name, _| !external_planner::is_name(name));
        Planning::from_table(&own).unwrap_or_default()
    }
}

/// What is wrong with a section: the names that lead to each mistake from its beginning, and a message.
pub(super) fn mistakes(section: &Table) -> Vec<(Vec<String>, String)> {
    let mut found = Vec::new();
    for (name, value) in section {
        match (name.as_str(), value) {
            ("sampling", Value::Table(table)) => found.extend(in_table::<Sampling>(name, table)),
            ("weights", Value::Table(table)) => found.extend(in_table::<Weights>(name, table)),
            (_, Value::Table(table)) if external_planner::is_name(name) => {
                let mistakes = external_planner::mistakes(name, table);
                found.extend(mistakes.map(|(key, message)| {
                    (std::iter::once(name.clone()).chain(key).collect(), message)
                }));
            }
            _ => {
                let message = wrong::<Planning>("planner.", name, value);
                found.extend(message.map(|message| (vec![name.clone()], message)));
            }
        }
    }
    found
}

fn in_table<F: Fields>(name: &str, table: &Table) -> impl Iterator<Item = (Vec<String>, String)> {
    table.iter().filter_map(move |(key, value)| {
        let message = wrong::<F>(&format!("planner.{name}."), key, value)?;
        Some((vec![name.to_owned(), key.clone()], message))
    })
}

#[cfg(test)]
#[path = "planner_tests.rs"]
mod tests;
