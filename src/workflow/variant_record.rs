//! What the manifest beside a saved variant says of its attack, outcome and certificates.

use serde_json::Value;

use nearmiss_scene::description::visible;

/// The record, as it was written when the variant was made. A field that a manifest does not have is `None` or empty.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct VariantRecord {
    /// The program that made it.
    pub program: String,
    /// The author of the attack: a search with its settings, or a model.
    pub by: String,
    /// The name of the outcome: collision, near_miss, no_effect or planner_error.
    pub outcome: String,
    /// The contact: obstacle, step, sides.
    pub contact: Option<String>,
    /// How the ego's drive ended, with the attack and without it.
    pub ended: (String, String),
    /// Each attacker: its id and manoeuvre, risk and distance.
    pub attackers: Vec<(String, String)>,
    /// Reaction times (s) of the good driver, each with whether it avoids the outcome, and how or why not.
    pub reactions: Vec<(String, bool, String)>,
    /// What the good driver of the longest of them does: acceleration, broken rules, left lanelets.
    pub good_driver: Vec<(&'static str, String)>,
    /// Motions that were refused before this one.
    pub refused: usize,
}

impl VariantRecord {
    /// Of a manifest.
    #[must_use]
    pub fn of(manifest: &Value) -> Self {
        let contact = &manifest["collision"];
        let risk = |of: &Value| {
            let score = |name: &str| of[name].as_u64().map_or("–".into(), |s| s.to_string());
            format!(
                "risk {} → {}",
                score("min_risk_before"),
                score("min_risk_after")
            )
        };
        let attackers = manifest["attackers"]
            .as_array()
            .into_iter()
            .flatten()
            .map(|one| {
                let mut words = format!("{}, {}", word(&one["manoeuvre"]), risk(one));
                if let Some(distance) = one["min_distance"].as_f64() {
                    words.push_str(&format!(", {distance:.2} m at least"));
                }
                if let Some(without) = one["outcome_without"].as_str() {
                    words.push_str(&format!("; without it {}", spoken(without)));
                }
                (one["id"].to_string(), words)
            });
        let all = manifest["avoidable"].as_object().into_iter().flatten();
        let mut reactions: Vec<(String, bool, String)> = all
            .map(|(delay, one)| {
                let avoided = one["avoided"] == true;
                let how = if avoided { "found_by" } else { "why" };
                (visible(delay).into_owned(), avoided, word(&one[how]))
            })
            .collect();
        reactions.sort();
        let latest = reactions
            .iter()
            .rev()
            .find(|(_, avoided, _)| *avoided)
            .map(|(delay, _, _)| &manifest["avoidable"][delay]);
        Self {
            program: word(&manifest["program"]),
            by: word(&manifest["by"]),
            outcome: spoken(&word(&manifest["outcome"])),
            contact: contact.is_object().then(|| {
                format!(
                    "{} at step {}: the ego's {}, the other's {}",
                    contact["with"],
                    contact["step"],
                    word(&contact["ego_side"]),
                    word(&contact["other_side"])
                )
            }),
            ended: (
                spoken(&word(&manifest["drive"]["ended_with"])),
                spoken(&word(&manifest["baseline"]["ended_with"])),
            ),
            attackers: attackers.collect(),
            good_driver: latest.map(good_driver).unwrap_or_default(),
            reactions,
            refused: manifest["rejected"].as_array().map_or(0, Vec::len),
        }
    }
}

fn good_driver(certificate: &Value) -> Vec<(&'static str, String)> {
    let broken = certificate["rules_broken"].as_array().into_iter().flatten();
    let broken: Vec<String> = broken.map(word).collect();
    good_driver_words(
        certificate["max_acceleration"].as_f64(),
        &broken.join(", "),
        certificate["leaves_roadway_step"].as_i64(),
    )
}

/// What a good driver does, line by line: the acceleration (m/s²) that it uses, the rules that it breaks, and the step at
/// which it leaves the lanelets of cars.
#[must_use]
pub fn good_driver_words(
    used: Option<f64>,
    broken: &str,
    left: Option<i64>,
) -> Vec<(&'static str, String)> {
    let used = used.map(|used| ("uses", format!("up to {used:.1} m/s²")));
    let broken = (!broken.is_empty()).then(|| ("breaks", broken.to_owned()));
    let left = left.map(|step| ("leaves", format!("the lanelets of cars at step {step}")));
    used.into_iter().chain(broken).chain(left).collect()
}

fn word(value: &Value) -> String {
    visible(value.as_str().unwrap_or_default()).into_owned()
}

/// A name of a document as words.
fn spoken(name: &str) -> String {
    name.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_manifest_is_read_field_by_field() {
        let record = VariantRecord::of(&json!({
            "by": "search, seed 1", "outcome": "near_miss", "program": "nearmiss 0.1.0",
            "collision": {"with": 7, "step": 41, "ego_side": "front", "other_side": "left"},
            "drive": {"ended_with": "off_road"}, "baseline": {"ended_with": "goal"},
            "attackers": [{"id": 7, "manoeuvre": "cut-in", "min_risk_before": 5, "min_risk_after": 1,
                "min_distance": 0.25, "outcome_without": null}],
            "avoidable": {
                "0.0": {"avoided": true, "found_by": "planner, usual"},
                "0.5": {"avoided": true, "found_by": "planner, usual", "max_acceleration": 9.04,
                    "rules_broken": ["safe-distance"], "leaves_roadway_step": 12},
                "1.0": {"avoided": false, "why": "nothing found"},
            },
            "rejected": [{}, {}],
        }));
        assert_eq!(record.outcome, "near miss");
        assert_eq!(record.ended, ("off road".into(), "goal".into()));
        let contact = "7 at step 41: the ego's front, the other's left";
        assert_eq!(record.contact.as_deref(), Some(contact));
        let attacker = (
            "7".into(),
            "cut-in, risk 5 → 1, 0.25 m at least".to_string(),
        );
        assert_eq!(record.attackers, [attacker]);
        let last = ("1.0".into(), false, "nothing found".to_string());
        assert_eq!(record.reactions.last(), Some(&last));
        let driver = [
            ("uses", "up to 9.0 m/s²".to_string()),
            ("breaks", "safe-distance".into()),
            ("leaves", "the lanelets of cars at step 12".into()),
        ];
        assert_eq!(record.good_driver, driver);
        assert_eq!(record.refused, 2);
    }

    #[test]
    fn of_other_json_nothing_is_known() {
        let nothing = VariantRecord::of(&json!({"variant": 3}));
        assert!(nothing.attackers.is_empty() && nothing.reactions.is_empty());
        assert_eq!((nothing.contact, nothing.by), (None, String::new()));
    }
}
