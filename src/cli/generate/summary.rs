//! Summary figures over all scenarios.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;

use super::model::ModelsReport;
use super::table;
use crate::{Failure, Outcome, output};
use nearmiss_drive::generation::{MotionQuantity, MotionSamples, OutcomeName};
use nearmiss_formats::commonroad::NewFile;
use nearmiss_scene::scenario::{HumanLimits, ObstacleType};
use nearmiss_workflow::PlanError;
use nearmiss_workflow::variant::VariantLine;

/// Counts over all scenarios.
#[derive(Debug, Default)]
pub struct Summary {
    /// What is counted one by one; the rest of it follows from that.
    sums: GenerateReport,
    unfit: usize,
    missed: usize,
    /// Lowest risk scores of the attackers before and after.
    before: Vec<u8>,
    after: Vec<u8>,
    /// Of the ideal drivers who survive collisions and near misses the largest acceleration, m/s².
    hardest: Option<f64>,
    /// Variants by how many obstacles attack together.
    together: BTreeMap<usize, usize>,
    /// Variants with a plausibility.
    plausible: usize,
    seconds: Vec<f64>,
    /// Motions of attackers, and those recorded in their scenarios.
    attackers: MotionSamples,
    recorded: MotionSamples,
}

/// What a driver makes of all collisions and near misses.
#[derive(Debug, Clone, Copy, Default, Serialize, JsonSchema)]
struct DriverCount {
    /// Variants whose contact it avoids.
    avoided: usize,
    /// Variants that it was made for, and in which nobody hits it from behind without seeing it.
    decided: usize,
}

/// A summary of all scenarios.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct GenerateReport {
    /// Scenarios done.
    scenarios: usize,
    /// Scenarios requested.
    asked_for: usize,
    /// Whether the run was interrupted.
    interrupted: bool,
    /// Scenarios attacked.
    driven: usize,
    /// Scenarios reused from an earlier run.
    taken_over: usize,
    /// Scenarios that could not be attacked.
    not_driven: usize,
    /// Of these, scenarios in which the planner's process failed without an attack.
    planner_failed: usize,
    /// The planners that were attacked.
    planners: BTreeSet<String>,
    /// Variants with a collision.
    collisions: usize,
    /// Variants under which the planner's process fails.
    planner_errors: usize,
    /// Variants with a near miss.
    near_misses: usize,
    /// Variants without effect.
    no_effect: usize,
    /// Scenarios without a variant.
    none: usize,
    /// Originals that are not safe.
    not_safe_before: usize,
    /// Outcomes of the drives.
    drives: BTreeMap<String, usize>,
    /// Drives that end with a hit from behind, which is no effect of the attack.
    hit_from_behind: usize,
    /// Variants whose contact is only between two steps, at which the bodies are apart.
    touched_between_steps: usize,
    /// Share of variants with an effect.
    effective_share: Option<f64>,
    /// Mean worst risk score before; 0 is a collision.
    mean_min_risk_before: Option<f64>,
    /// Mean worst risk score after; 0 is a collision.
    mean_min_risk_after: Option<f64>,
    /// Avoidable variants by reaction time in seconds.
    avoidable: BTreeMap<String, usize>,
    /// By driver: collisions and near misses that it avoids, of those that it decides.
    preventable_by: BTreeMap<String, DriverCount>,
    /// Number of motions tried.
    candidates: usize,
    /// Share of motions that passed the gate.
    valid_share_of_candidates: Option<f64>,
    /// Rejected motions by reason.
    refused: BTreeMap<String, usize>,
    /// Variants by manoeuvre; those of several attackers with +.
    manoeuvres: BTreeMap<String, usize>,
    /// Variants by number of attackers.
    by_attackers: BTreeMap<String, usize>,
    /// How different the manoeuvres are.
    diversity: Diversity,
    /// Wasserstein distance of the attackers' motions to recorded ones: acceleration (m/s²), jerk (m/s³), yaw_rate
    /// (rad/s), lane_offset (m).
    wasserstein_to_recorded: BTreeMap<String, f64>,
    /// Median duration of a scenario, seconds.
    median_seconds: Option<f64>,
    #[serde(flatten)]
    models: ModelsReport,
}

/// How different manoeuvres are.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
struct Diversity {
    distinct_manoeuvres: usize,
    /// Entropy of their shares.
    entropy_bits: f64,
}

/// How a drive ends that is no collision, and no good either.
const OTHER_FAILURES: [(&str, &str); 3] = [
    ("off_road", "off the road"),
    ("infeasible", "infeasible"),
    ("planner_error", "with an error of the planner"),
];

impl Summary {
    /// Starts a summary of this many scenarios.
    pub fn new(all: usize) -> Self {
        let mut summary = Self::default();
        summary.sums.asked_for = all;
        summary
    }

    pub fn missed(&mut self, error: &PlanError) {
        match error {
            PlanError::NothingToPlan(_) => self.missed += 1,
            PlanError::PlannerFailed(_) => self.sums.planner_failed += 1,
            _ => self.unfit += 1,
        }
    }

    pub fn count(&mut self, line: &VariantLine) {
        self.sums.driven += 1;
        self.sums.taken_over += usize::from(line.taken_over);
        self.sums.not_safe_before += usize::from(!line.safe_before);
        self.sums.candidates += line.candidates;
        self.seconds.push(line.seconds);
        self.sums.planners.insert(line.attacked());
        if let Some(consumed) = &line.model {
            self.sums.models.count(consumed);
        }
        for (reason, count) in &line.refused {
            *self.sums.refused.entry(reason.clone()).or_default() += count;
        }
        match line.outcome {
            OutcomeName::Collision => self.sums.collisions += 1,
            OutcomeName::PlannerError => self.sums.planner_errors += 1,
            OutcomeName::NearMiss => self.sums.near_misses += 1,
            OutcomeName::NoEffect => self.sums.no_effect += 1,
            OutcomeName::None => {
                self.sums.none += 1;
                return;
            }
        }
        self.sums.hit_from_behind += usize::from(line.is_hit_from_behind());
        self.sums.touched_between_steps += usize::from(line.touched_after_step.is_some());
        self.plausible += usize::from(line.plausibility.is_some());
        self.before.extend(line.min_risk_before);
        self.after.extend(line.min_risk_after);
        if line.outcome.is_effective() {
            let driver = line.good_driver.as_ref();
            let used = driver.and_then(|driver| driver.max_acceleration);
            self.hardest = self.hardest.into_iter().chain(used).reduce(f64::max);
            for (delay, avoided) in line.avoidable.iter().flatten() {
                *self.sums.avoidable.entry(delay.clone()).or_default() += usize::from(*avoided);
            }
            // A near miss, which the ego avoids, needs no driver.
            let contacts = { line.preventability.iter() }.filter(|it| it.closing_speed.is_some());
            for verdict in contacts.flat_map(|found| &found.drivers) {
                let count = self
                    .sums
                    .preventable_by
                    .entry(verdict.driver.clone())
                    .or_default();
                count.decided += usize::from(verdict.decides());
                count.avoided += usize::from(verdict.avoids());
            }
        }
        if let Some(samples) = &line.motion_samples {
            self.attackers.merge(&samples.attacker);
            self.recorded.merge(&samples.recorded);
        }
        *self.together.entry(line.ids().len()).or_default() += 1;
        let named = [
            (&mut self.sums.manoeuvres, line.manoeuvres()),
            (&mut self.sums.drives, line.drive.clone()),
        ];
        for (counts, name) in named {
            if let Some(name) = name {
                *counts.entry(name).or_default() += 1;
            }
        }
    }

    /// Describes the line.
    pub fn words(&self) -> String {
        let counts = [
            (self.sums.collisions, "collision"),
            (self.sums.planner_errors, "error of the planner"),
            (self.sums.near_misses, "near miss"),
            (self.sums.no_effect, "without effect"),
            (self.sums.none, "without a variant"),
            (
                self.sums.planner_failed,
                "not driven by the planner (it failed without an attack)",
            ),
            (self.missed + self.unfit, "not attackable"),
        ];
        let counts = counts.iter().filter(|(n, _)| *n > 0);
        let counts: Vec<String> = counts.map(|(n, what)| format!("{n} {what}")).collect();
        let scenarios = output::counted(self.done(), "scenario");
        let mut text = format!("{scenarios}: {}\n", counts.join(", "));
        if let (Some(before), Some(after)) = (mean(&self.before), mean(&self.after)) {
            text.push_str(&format!(
                "worst risk score of attackers (0 = collision), mean: {before:.2} → {after:.2}\n"
            ));
        }
        let effective = self.sums.collisions + self.sums.near_misses;
        if effective > 0 {
            text.push_str(&self.avoidable_words(effective));
            let counted =
                { self.sums.preventable_by.iter() }.filter(|(_, count)| count.decided > 0);
            let counted =
                counted.map(|(id, count)| format!("{id} {} of {}", count.avoided, count.decided));
            let counted: Vec<String> = counted.collect();
            if !counted.is_empty() {
                text.push_str(&format!(
                    "contacts preventable by: {}\n",
                    counted.join(", ")
                ));
            }
            let people = HumanLimits::for_kind(ObstacleType::Car).braking;
            if let Some(hardest) = self.hardest.filter(|hardest| *hardest > people) {
                text.push_str(&format!(
                    "peak of the ideal driver {hardest:.1} m/s²: people brake with up to {people:.1} m/s²\n"
                ));
            }
        }
        text.push_str(&table::contacts(
            self.sums.hit_from_behind,
            self.sums.touched_between_steps,
        ));
        let astray = OTHER_FAILURES.iter().filter_map(|(outcome, words)| {
            let n = self.sums.drives.get(*outcome)?;
            Some(format!("{n} {words}"))
        });
        let astray: Vec<String> = astray.collect();
        if !astray.is_empty() {
            text.push_str(&format!(
                "drives that end otherwise: {}\n",
                astray.join(", ")
            ));
        }
        if self.sums.not_safe_before > 0 {
            text.push_str(&format!(
                "not safe as recorded (collision, or risk score of 1 or below): {}\n",
                output::counted(self.sums.not_safe_before, "original")
            ));
        }
        if self.sums.taken_over > 0 {
            text.push_str(&format!(
                "{} reused from an earlier run, {} new\n",
                self.sums.taken_over,
                self.sums.driven - self.sums.taken_over
            ));
        }
        let refused: usize = self.sums.refused.values().sum();
        text.push_str(&format!(
            "{} tried, {refused} rejected\n",
            output::counted(self.sums.candidates, "motion")
        ));
        let kinds: Vec<String> = self
            .sums
            .manoeuvres
            .iter()
            .map(|(k, n)| format!("{n} {k}"))
            .collect();
        if !kinds.is_empty() {
            text.push_str(&format!(
                "manoeuvres: {}{}\n",
                kinds.join(", "),
                match kinds.len() {
                    1 => String::new(),
                    _ => format!(" (diversity {:.1} bits)", entropy(&self.sums.manoeuvres)),
                }
            ));
        }
        let several = self
            .together
            .iter()
            .filter(|(attackers, _)| **attackers > 1);
        let several: Vec<String> = several
            .map(|(attackers, n)| format!("{n} with {attackers} attackers"))
            .collect();
        if !several.is_empty() {
            text.push_str(&format!("{}\n", several.join(", ")));
        }
        if self.plausible > 0 {
            text.push_str(table::PLAUSIBILITY);
        }
        let apart = self.wasserstein();
        let apart: Vec<String> = { apart.iter() }
            .map(|(q, apart)| format!("{} {apart:.2} {}", q.name().replace('_', " "), q.unit()))
            .collect();
        if !apart.is_empty() {
            text.push_str(&format!(
                "Wasserstein distance of the attackers' motions to recorded ones: {}\n",
                apart.join(", ")
            ));
        }
        if !self.sums.planners.is_empty() && !self.sums.planners.iter().eq(["nearmiss"]) {
            let all: Vec<&str> = self.sums.planners.iter().map(String::as_str).collect();
            text.push_str(&format!("attacked planner: {}\n", all.join(", ")));
        }
        text.push_str(&self.sums.models.words());
        text
    }

    /// How far the attackers' motions are from the recorded ones.
    fn wasserstein(&self) -> Vec<(MotionQuantity, f64)> {
        let apart = |quantity: MotionQuantity| {
            let apart = self.attackers.wasserstein(&self.recorded, quantity)?;
            Some((quantity, apart))
        };
        MotionQuantity::ALL.into_iter().filter_map(apart).collect()
    }

    /// With which reaction times an ideal driver avoids the collisions and near misses, of which there are so many.
    fn avoidable_words(&self, effective: usize) -> String {
        if effective == 1 {
            let mut avoided = self.sums.avoidable.iter().filter(|(_, n)| **n > 0);
            return match avoided.next_back() {
                Some((delay, _)) => {
                    format!(
                        "avoidable by an ideal driver with a reaction time of up to {delay} s\n"
                    )
                }
                None => "no way was found by which an ideal driver avoids it\n".into(),
            };
        }
        let late = self.sums.avoidable.iter();
        let late: Vec<String> = late
            .map(|(delay, n)| format!("{n} with a reaction time of {delay} s"))
            .collect();
        format!(
            "of {effective} collisions and near misses, an ideal driver avoids: {}\n",
            late.join(", ")
        )
    }

    fn done(&self) -> usize {
        self.sums.driven + self.not_driven()
    }

    fn not_driven(&self) -> usize {
        self.missed + self.unfit + self.sums.planner_failed
    }

    fn report(&self, interrupted: bool) -> GenerateReport {
        let effective = self.sums.collisions + self.sums.near_misses;
        let refused: usize = self.sums.refused.values().sum();
        let share = |n: usize, of: usize| (of > 0).then(|| n as f64 / of as f64);
        let mut seconds = self.seconds.clone();
        seconds.sort_by(f64::total_cmp);
        let by_attackers = self.together.iter();
        let apart = self.wasserstein().into_iter();
        GenerateReport {
            scenarios: self.done(),
            interrupted,
            not_driven: self.not_driven(),
            effective_share: share(effective, self.sums.driven),
            mean_min_risk_before: mean(&self.before),
            mean_min_risk_after: mean(&self.after),
            valid_share_of_candidates: share(
                self.sums.candidates.saturating_sub(refused),
                self.sums.candidates,
            ),
            by_attackers: by_attackers
                .map(|(n, count)| (n.to_string(), *count))
                .collect(),
            diversity: Diversity {
                distinct_manoeuvres: self.sums.manoeuvres.len(),
                entropy_bits: entropy(&self.sums.manoeuvres),
            },
            wasserstein_to_recorded: apart.map(|(q, apart)| (q.name().into(), apart)).collect(),
            median_seconds: seconds.get(seconds.len() / 2).copied(),
            ..self.sums.clone()
        }
    }

    /// Writes the line.
    pub fn save(&self, path: &Path, interrupted: bool, overwrite: bool) -> Result<(), Failure> {
        use std::io::Write;
        let mut file = NewFile::begin(path, overwrite).map_err(Failure::input)?;
        let text = output::json_line(&self.report(interrupted))?;
        file.write_all(text.as_bytes())
            .map_err(|e| Failure::system(path.display(), &e))?;
        file.finish().map_err(Failure::input)
    }

    /// The exit status.
    pub fn outcome(&self) -> Outcome {
        let finding = |message| Err(Failure::finding(message));
        let without = self.sums.no_effect + self.sums.none;
        match (without, self.not_driven()) {
            (0, 0) => Ok(()),
            _ if self.unfit == self.sums.asked_for => {
                Err(Failure::input("no scenario could be attacked"))
            }
            (0, n) => finding(format!(
                "{} could not be attacked",
                output::of_scenarios(n, self.sums.asked_for)
            )),
            (n, 0) => finding(format!(
                "{} ended without a collision or near miss",
                output::of_scenarios(n, self.sums.asked_for)
            )),
            (n, m) => finding(format!(
                "{} ended without a collision or near miss, and {m} could not be attacked",
                output::of_scenarios(n, self.sums.asked_for)
            )),
        }
    }
}

/// How diverse the counted things are: the entropy of their shares, bits; 0 where all are the same (Shannon 1948).
fn entropy(counts: &BTreeMap<String, usize>) -> f64 {
    let all: usize = counts.values().sum();
    let shares = counts.values().map(|n| *n as f64 / all as f64);
    shares
        .map(|share| -share * share.log2())
        .sum::<f64>()
        .max(0.0)
        + 0.0 // no negative zero
}

fn mean(scores: &[u8]) -> Option<f64> {
    let sum: f64 = scores.iter().map(|s| f64::from(*s)).sum();
    (!scores.is_empty()).then(|| sum / scores.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diversity_is_the_entropy_of_the_kinds() {
        let of = |counts: &[usize]| {
            let named = counts.iter().enumerate();
            entropy(&named.map(|(i, n)| (i.to_string(), *n)).collect())
        };
        assert_eq!(of(&[]), 0.0);
        assert_eq!(of(&[7]), 0.0);
        assert_eq!(of(&[3, 3]), 1.0);
        assert_eq!(of(&[2, 1, 1]), 1.5);
    }
}
