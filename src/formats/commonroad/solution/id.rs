//! The benchmark id of a solution: `KS2:SM1:DEU_Test-1_1_T-1:2020a`, or `[KS2,PM1]:[SM1,JB1]:…` for several vehicles.

use super::{ProblemSolution, Solution};
use nearmiss_scene::scenario::{VehicleModel, VehicleType};

/// The cost functions that commonroad-io 2026.1 knows.
pub(super) const COST_FUNCTIONS: [&str; 9] = [
    "JB1", "SA1", "WX1", "SM1", "SM2", "SM3", "MW1", "TR1", "TR2",
];

/// The cost functions that are defined for a point mass.
pub(super) const POINT_MASS_COSTS: [&str; 3] = ["JB1", "WX1", "MW1"];

/// A benchmark id taken apart.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct BenchmarkId {
    pub vehicles: Vec<(VehicleModel, VehicleType)>,
    pub costs: Vec<String>,
    pub scenario: String,
    pub version: String,
}

impl BenchmarkId {
    /// # Errors
    /// It is invalid, and why.
    pub fn parse(text: &str) -> Result<Self, String> {
        let bare: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        let parts: Vec<&str> = bare.split(':').collect();
        let [vehicles, costs, scenario, version] = parts[..] else {
            return Err(format!(
                "{} parts between colons; expected vehicle, cost function, scenario and version, as in `KS2:SM1:DEU_Test-1_1_T-1:2020a`",
                parts.len()
            ));
        };
        let vehicles: Vec<_> = list(vehicles).map(vehicle).collect::<Result<_, _>>()?;
        let costs: Vec<String> = list(costs).map(str::to_string).collect();
        if let Some(odd) = costs.iter().find(|c| !is_word(c)) {
            return Err(format!("`{odd}` is not a cost function such as `SM1`"));
        }
        if costs.len() != vehicles.len() {
            return Err(format!(
                "{} vehicles but {} cost functions; each vehicle needs one",
                vehicles.len(),
                costs.len()
            ));
        }
        if scenario.is_empty() || version.is_empty() {
            return Err("scenario or version is empty".into());
        }
        if !legal(scenario) || !legal(version) {
            return Err("scenario or version contains control characters".into());
        }
        Ok(Self {
            vehicles,
            costs,
            scenario: scenario.to_string(),
            version: version.to_string(),
        })
    }
}

/// Whether XML can hold a text in an attribute and give it back.
pub(super) fn legal(text: &str) -> bool {
    !text
        .chars()
        .any(|c| c < ' ' || matches!(c, '\u{fffe}' | '\u{ffff}'))
}

/// Letters and digits, at least one.
pub(super) fn is_word(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_alphanumeric())
}

fn list(text: &str) -> impl Iterator<Item = &str> {
    text.trim_matches(['[', ']']).split(',')
}

fn vehicle(id: &str) -> Result<(VehicleModel, VehicleType), String> {
    let digits = id.find(|c: char| c.is_ascii_digit()).unwrap_or(id.len());
    let (model, number) = id.split_at(digits);
    VehicleModel::parse(model)
        .zip(VehicleType::parse(number))
        .ok_or_else(|| {
            format!(
                "`{id}` is not a vehicle id: a model (PM, KS, ST, MB, KST) and a vehicle from 1 to {}, as in `KS2`",
                VehicleType::ALL.len()
            )
        })
}

/// The id of a solution, with its vehicles in the order in which they are written.
pub(super) fn compose(solution: &Solution, order: &[&ProblemSolution]) -> String {
    let joined = |words: Vec<String>| match &words[..] {
        [one] => one.clone(),
        several => format!("[{}]", several.join(",")),
    };
    let vehicles = order.iter().map(|p| p.vehicle_id()).collect();
    let costs = order.iter().map(|p| p.cost.clone()).collect();
    format!(
        "{}:{}:{}:{}",
        joined(vehicles),
        joined(costs),
        solution.scenario_id,
        solution.version
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn one_vehicle_and_several() {
        let id = BenchmarkId::parse("KS2:SM1:DEU_Test-1_1_T-1:2020a").unwrap();
        assert_eq!(id.vehicles, [(VehicleModel::Ks, VehicleType::Bmw320i)]);
        assert_eq!(
            (&id.costs[0][..], &id.scenario[..]),
            ("SM1", "DEU_Test-1_1_T-1")
        );
        let id = BenchmarkId::parse("[PM1, KST4]:[JB1,SA1]:C-DEU_Test-1:2020a").unwrap();
        assert_eq!(
            id.vehicles,
            [
                (VehicleModel::Pm, VehicleType::FordEscort),
                (VehicleModel::Kst, VehicleType::Truck)
            ]
        );
        assert_eq!(id.costs, ["JB1", "SA1"]);
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, word) in [
            ("", "1 parts"),
            ("KS2:SM1:DEU_Test-1", "3 parts"),
            ("KS9:SM1:X:2020a", "`KS9`"),
            ("XX1:SM1:X:2020a", "`XX1`"),
            ("KS:SM1:X:2020a", "`KS`"),
            ("[KS1,KS2]:SM1:X:2020a", "2 vehicles but 1 cost"),
            ("KS1:S[M:X:2020a", "`S[M`"),
            ("KS1:SM1::2020a", "empty"),
        ] {
            let said = BenchmarkId::parse(text).unwrap_err();
            assert!(said.contains(word), "{text}: {said}");
        }
    }
}
