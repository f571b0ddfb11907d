//! What drivers are, and what they make of an encounter, as records for programs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use nearmiss_scene::scenario::Scene;

use super::{
    DriverModel, DriverOutcome, DriverResult, DriverVerdict, Field, NotMadeFor, Preventability,
    ideal,
};

/// A driver: what it is, for programs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DriverRecord {
    /// Its id.
    pub driver: &'static str,
    /// Its name.
    pub name: &'static str,
    /// When it reacts, and what it does.
    pub formula: &'static str,
    /// The numbers in the formula.
    pub parameters: Vec<ParameterRecord>,
    /// Where it is published.
    pub source: &'static str,
    /// What it leaves out.
    pub limits: &'static str,
    /// Kinds of encounters that it is not made for.
    pub not_made_for: Vec<&'static str>,
}

/// A number in a driver's formula, for programs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ParameterRecord {
    /// Its symbol in the formula.
    pub symbol: &'static str,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
}

impl From<&DriverModel> for DriverRecord {
    fn from(driver: &DriverModel) -> Self {
        let parameters = driver.parameters.iter().map(|p| ParameterRecord {
            symbol: p.symbol,
            value: p.value,
            unit: p.unit,
            meaning: p.what,
        });
        Self {
            driver: driver.id,
            name: driver.name,
            formula: driver.formula,
            parameters: parameters.collect(),
            source: driver.source,
            limits: driver.limits,
            not_made_for: driver.not_made_for.iter().map(|kind| kind.name()).collect(),
        }
    }
}

/// Which drivers avoid an encounter.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct PreventabilityRecord {
    /// Id of the other road user in it.
    pub obstacle: i64,
    /// Step of the contact, or the most severe one of a near miss.
    pub step: i64,
    /// From this step on each driver drives.
    pub from_step: i64,
    /// Closing speed at the ego's own contact; null without one.
    #[schemars(extend("unit" = "m/s"))]
    pub closing_speed: Option<f64>,
    /// Drivers that avoid contact.
    pub avoided: usize,
    /// Drivers that decide: those made for it, and not hit from behind by someone who does not see them.
    pub decided: usize,
    /// Each driver.
    pub drivers: Vec<VerdictRecord>,
}

/// What one driver makes of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct VerdictRecord {
    /// Its id.
    pub driver: String,
    /// What comes of it.
    pub result: DriverOutcome,
    /// What it is not made for.
    pub not_made_for: Option<NotMadeFor>,
    /// The step at which it first reacts.
    pub reacts_step: Option<i64>,
    /// Closing speed at its contact.
    #[schemars(extend("unit" = "m/s"))]
    pub closing_speed: Option<f64>,
    /// Id of the road user that it touches: that of the encounter, or another one.
    pub touches: Option<i64>,
    /// The last step at which it could take over and still avoid contact.
    pub last_moment_step: Option<i64>,
}

impl From<&Preventability> for PreventabilityRecord {
    fn from(found: &Preventability) -> Self {
        let (avoided, decided) = found.count();
        Self {
            obstacle: found.obstacle,
            step: found.step,
            from_step: found.from,
            closing_speed: found.contact.map(|contact| contact.closing_speed),
            avoided,
            decided,
            drivers: found.verdicts.iter().map(VerdictRecord::from).collect(),
        }
    }
}

impl From<&DriverVerdict> for VerdictRecord {
    fn from(verdict: &DriverVerdict) -> Self {
        let result = &verdict.result;
        Self {
            driver: verdict.driver.id.into(),
            result: result.outcome(),
            not_made_for: match result {
                DriverResult::NotMadeFor(kind) => Some(*kind),
                _ => None,
            },
            reacts_step: verdict.reacts,
            closing_speed: result.contact().map(|touch| touch.closing_speed),
            touches: result.contact().map(|touch| touch.obstacle),
            last_moment_step: verdict.last_moment,
        }
    }
}

impl VerdictRecord {
    /// Whether it avoids contact.
    #[must_use]
    pub fn avoids(&self) -> bool {
        self.result == DriverOutcome::Avoided
    }

    /// Why it decides nothing, in words; nothing where it does.
    #[must_use]
    pub fn why_undecided(&self) -> Option<String> {
        match self.not_made_for {
            Some(kind) => Some(format!("{} is not made for {}", self.driver, kind.words())),
            None => (!self.decides()).then(|| format!("{} is hit from behind", self.driver)),
        }
    }

    /// Whether it decides: made for it, and not hit from behind.
    #[must_use]
    pub fn decides(&self) -> bool {
        self.result.decides()
    }
}

impl PreventabilityRecord {
    /// Whether its counts are those of its drivers.
    #[must_use]
    pub fn is_consistent(&self) -> bool {
        let count = |is: fn(&VerdictRecord) -> bool| self.drivers.iter().filter(|v| is(v)).count();
        let counted = (count(VerdictRecord::avoids), count(VerdictRecord::decides));
        self.drivers.is_empty() || (self.avoided, self.decided) == counted
    }

    /// What drivers make of the encounter with an obstacle that is worst at `step`, with their last moments; `is_certified`:
    /// a certificate says that the ideal one avoids it. `None` where the ego is not there before, or touched another one.
    #[must_use]
    pub fn of(scene: &Scene, obstacle: i64, step: i64, is_certified: bool) -> Option<Self> {
        let field = Field::around(scene, obstacle, step)?;
        let mut found = Preventability::of(&field);
        if is_certified {
            found.ideal_avoids();
        }
        Some((&found.with_last_moments(&field)).into())
    }

    /// What the driver with this id makes of it.
    #[must_use]
    pub fn by(&self, driver: &str) -> Option<&VerdictRecord> {
        self.drivers.iter().find(|verdict| verdict.driver == driver)
    }

    /// `preventable by 4 of 6`, of a near miss `avoided by 4 of 6`; who disagrees is named. Where no model of a person
    /// decides, that is said: the ideal driver alone says little.
    #[must_use]
    pub fn words(&self) -> String {
        if self.decided == 0 {
            return "no driver is made for it".into();
        }
        if !self.people().any(VerdictRecord::decides) {
            let avoids = self.by(ideal::MODEL.id).is_some_and(VerdictRecord::avoids);
            let does = if avoids {
                "avoids it"
            } else {
                "does not avoid it"
            };
            return format!("no model of a person decides; the ideal driver {does}");
        }
        match self.disagreement() {
            Some(words) => format!("{}; {words}", self.short()),
            None => self.short(),
        }
    }

    /// The same where there is little room: `preventable by 4 of 6`, `ideal avoids it`.
    #[must_use]
    pub fn short(&self) -> String {
        let count = format!("by {} of {}", self.avoided, self.decided);
        let does = self.by(ideal::MODEL.id).is_some_and(VerdictRecord::avoids);
        match (
            self.people().any(VerdictRecord::decides),
            self.closing_speed,
        ) {
            (true, Some(_)) => format!("preventable {count}"),
            (true, None) => format!("avoided {count}"),
            (false, _) if self.decided == 0 => "no driver made for it".into(),
            (false, _) if does => "ideal avoids it".into(),
            (false, _) => "ideal fails".into(),
        }
    }

    /// What drivers are not made for, in words: `oncoming traffic, curves`.
    #[must_use]
    pub fn not_made_for(&self) -> Option<String> {
        let mut kinds: Vec<&str> = Vec::new();
        for kind in self
            .drivers
            .iter()
            .filter_map(|verdict| verdict.not_made_for)
        {
            if !kinds.contains(&kind.words()) {
                kinds.push(kind.words());
            }
        }
        (!kinds.is_empty()).then(|| kinds.join(", "))
    }

    /// The verdicts of models of people.
    pub fn people(&self) -> impl Iterator<Item = &VerdictRecord> {
        { self.drivers.iter() }.filter(|verdict| verdict.driver != ideal::MODEL.id)
    }

    /// The same as a sentence, with the last moment of each driver that avoids it; `dt`: seconds between two steps.
    #[must_use]
    pub fn sentence(&self, dt: f64) -> String {
        let words = match self.closing_speed {
            Some(_) => self.words(),
            None => format!("the ego avoids it; {}", self.words()),
        };
        let mut letters = words.chars();
        let first = letters.next().map(|letter| letter.to_ascii_uppercase());
        let mut told: String = first.into_iter().chain(letters).collect();
        let avoiding = self.drivers.iter().filter(|verdict| verdict.avoids());
        let moments = avoiding.filter_map(|one| Some((&one.driver, one.last_moment_step?)));
        for (place, (driver, step)) in moments.enumerate() {
            let before = (self.step - step) as f64 * dt;
            told += &match place {
                0 => format!("; the last moment for {driver} was {before:.1} s before"),
                _ => format!(", for {driver} {before:.1} s"),
            };
        }
        told + "."
    }

    /// Where models of people disagree: `cc, r157 do not avoid it, fsm does`.
    #[must_use]
    pub fn disagreement(&self) -> Option<String> {
        let of = |avoids: bool| -> Vec<&str> {
            let decided = self.people().filter(|verdict| verdict.decides());
            let these = decided.filter(|verdict| verdict.avoids() == avoids);
            these.map(|verdict| verdict.driver.as_str()).collect()
        };
        let (yes, no) = (of(true), of(false));
        let verb = |of: &[&str]| if of.len() == 1 { "does" } else { "do" };
        let disagree = !yes.is_empty() && !no.is_empty();
        disagree.then(|| {
            let (fails, avoids) = (verb(&no), verb(&yes));
            format!(
                "{} {fails} not avoid it, {} {avoids}",
                no.join(", "),
                yes.join(", ")
            )
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Manifests have these words.
    #[test]
    fn outcomes_are_read_as_they_are_written() {
        for outcome in DriverOutcome::ALL {
            let kind = (outcome == DriverOutcome::NotMadeFor).then_some(NotMadeFor::Curve);
            let verdict = VerdictRecord {
                driver: "cc".into(),
                result: outcome,
                not_made_for: kind,
                ..VerdictRecord::default()
            };
            let text = serde_json::to_string(&verdict).unwrap();
            assert!(
                text.contains(&format!("\"result\":\"{}\"", outcome.name())),
                "{text}"
            );
            assert_eq!(
                serde_json::from_str::<VerdictRecord>(&text).unwrap(),
                verdict
            );
        }
    }

    #[test]
    fn the_ideal_driver_alone_is_no_majority() {
        let verdict = |driver: &str, result| VerdictRecord {
            driver: driver.into(),
            result,
            ..VerdictRecord::default()
        };
        let mut found = PreventabilityRecord {
            closing_speed: Some(5.0),
            avoided: 1,
            decided: 1,
            drivers: vec![
                verdict("cc", DriverOutcome::NotMadeFor),
                verdict("ideal", DriverOutcome::Avoided),
            ],
            ..PreventabilityRecord::default()
        };
        assert_eq!(
            found.words(),
            "no model of a person decides; the ideal driver avoids it"
        );
        assert_eq!(found.short(), "ideal avoids it");
        found.drivers[0].result = DriverOutcome::NotAvoided;
        found.decided = 2;
        assert_eq!(
            (found.words(), found.short()),
            (
                "preventable by 1 of 2".into(),
                "preventable by 1 of 2".into()
            )
        );
    }
}
