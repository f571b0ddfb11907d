//! What `report` and `evaluate` require of a batch, for continuous integration, and which comparisons are declared to matter.

use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;

use nearmiss_store::{BatchId, Item, ItemState, SplitPart, Store};
use nearmiss_study::evaluation::batch::{TestSplit, answers, answers_of_part};
use nearmiss_study::evaluation::report::{Comparison, Report, ReportSubject, configuration_name};
use nearmiss_study::evaluation::{Check, PromptConfig, Requirement, Scored, regressions};
use nearmiss_workflow::stored_bundle;

use super::output::{self, Target, visible};
use super::{Failure, Outcome};

/// What must hold.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Requirements (exit status 1 if one is not met)")]
pub struct Gate {
    /// Requirement on every configuration, such as 'f1 >= 0.8', or on one: 'lab/model: recall > 0.9'; repeat for
    /// several. Metrics are named as in CSV and JSON.
    #[arg(long, value_name = "REQUIREMENT")]
    require: Vec<Requirement>,
    /// Compare each configuration with the same one in this bundle (`nearmiss help experiments`), on the same
    /// questions; needs --no-worse-than.
    #[arg(long, value_name = "FILE", requires = "no_worse_than")]
    baseline_bundle: Option<PathBuf>,
    /// Largest allowed drop in accuracy since the bundle, 0 to 1; needs --baseline-bundle.
    #[arg(long, value_name = "SHARE", requires = "baseline_bundle", value_parser = margin)]
    no_worse_than: Option<f64>,
    /// Write a JUnit XML file, replacing an existing one, with a test case per requirement and configuration.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
}

fn margin(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(margin) if (0.0..=1.0).contains(&margin) => Ok(margin),
        _ => Err("expected a number from 0 to 1".into()),
    }
}

/// A part of a split, `None` for a batch without one, and its answers.
type ScoredPart = (Option<SplitPart>, Vec<Scored>);

impl Gate {
    /// Whether anything is required.
    pub fn any(&self) -> bool {
        !self.require.is_empty() || self.baseline_bundle.is_some() || self.junit.is_some()
    }

    /// Whether a batch is needed.
    pub fn needs_batch(&self) -> bool {
        self.baseline_bundle.is_some()
    }

    /// How a batch ends that was asked with this `outcome`.
    pub fn after(&self, outcome: Outcome, store: &Store, batch: BatchId) -> Outcome {
        let done = match &outcome {
            Ok(()) => true,
            Err(failure) => failure.status == 1,
        };
        if !self.any() || !done {
            return outcome;
        }
        let parts = shown(store, batch)?;
        let report = |(part, scored): &ScoredPart| {
            let about = ReportSubject {
                split: part.map(SplitPart::name),
                ..ReportSubject::default()
            };
            Report::from_scored(scored).about(about)
        };
        let reports: Vec<Report> = parts.iter().map(report).collect();
        let checked = self.check(&reports.iter().collect::<Vec<_>>(), Some((store, batch)));
        both(outcome, checked)
    }

    /// Holds everything against a report, or those of the parts of a split, of a batch where there is one, and says what is not met.
    pub fn check(&self, reports: &[&Report], batch: Option<(&Store, BatchId)>) -> Outcome {
        if !self.any() {
            return Ok(());
        }
        let mut checks = Vec::new();
        for requirement in &self.require {
            for report in reports {
                let found = requirement.check(report);
                checks.extend(found.map_err(|why| Failure::input(format!("--require {why}")))?);
            }
        }
        checks.extend(self.against_baseline(batch)?);
        if let Some((store, id)) = batch
            && (self.baseline_bundle.is_some() || !self.require.is_empty())
        {
            checks.extend(open_questions(store, id)?);
        }
        if let Some(file) = &self.junit {
            Target::begin(Some(file), true)?.save(xml(&checks).as_bytes())?;
        }
        let unmet: Vec<&Check> = checks.iter().filter(|check| !check.is_met).collect();
        for check in &unmet {
            output::say(&format!("nearmiss: {check}"));
        }
        match unmet.len() {
            0 => Ok(()),
            n => Err(Failure::finding(format!(
                "{n} of {} not met",
                output::counted(checks.len(), "requirement")
            ))),
        }
    }

    fn against_baseline(&self, batch: Option<(&Store, BatchId)>) -> Result<Vec<Check>, Failure> {
        let (Some(file), Some(margin)) = (&self.baseline_bundle, self.no_worse_than) else {
            return Ok(Vec::new());
        };
        let Some((store, id)) = batch else {
            return Err(Failure::input(
                "--baseline-bundle needs --batch: it compares a batch",
            ));
        };
        let parts = shown(store, id)?.into_iter();
        let now: Vec<Scored> = parts.flat_map(|(_, scored)| scored).collect();
        let items = store.items(id).map_err(Failure::input)?;
        let (bundle, earlier) = stored_bundle(file).map_err(Failure::input)?;
        let before = answers(&bundle, earlier).map_err(Failure::input)?;
        let old = bundle.items(earlier).map_err(Failure::input)?;
        let (ours, theirs) = (hashes(&items), hashes(&old));
        let is_same = |name: &str| match (ours.get(name), theirs.get(name)) {
            (Some(ours), Some(theirs)) => ours == theirs,
            _ => false,
        };
        let found = regressions(&now, &before.plain, is_same);
        if found.is_empty() {
            return Err(Failure::input(format!(
                "--baseline-bundle {}: no way of the batch is in it; `nearmiss runs import FILE --dry-run` lists its contents",
                file.display()
            )));
        }
        Ok(found.iter().map(|one| one.check(margin)).collect())
    }
}

/// The split of a batch, where it has one.
fn split_of(store: &Store, id: BatchId) -> Result<Option<TestSplit>, Failure> {
    let batch = store.batch(id).map_err(Failure::input)?;
    let test = batch.map(|batch| TestSplit::open(store, &batch, false));
    Ok(test.transpose().map_err(Failure::input)?.flatten())
}

/// The answers of a batch, of each part of a split alone; those of a locked test split are left out.
fn shown(store: &Store, id: BatchId) -> Result<Vec<ScoredPart>, Failure> {
    let Some(test) = split_of(store, id)? else {
        return Ok(vec![(
            None,
            answers(store, id).map_err(Failure::input)?.plain,
        )]);
    };
    let parts = test.visible_parts().iter().map(|part| {
        let answers = answers_of_part(store, id, Some(*part)).map_err(Failure::input)?;
        Ok((Some(*part), answers.plain))
    });
    parts.collect()
}

/// That no question is open which counts in what is shown: who stopped early was not asked the same as the others.
fn open_questions(store: &Store, id: BatchId) -> Result<Option<Check>, Failure> {
    let test = split_of(store, id)?;
    let is_shown = |part: Option<SplitPart>| match &test {
        Some(test) => part.is_some_and(|part| test.visible_parts().contains(&part)),
        None => true,
    };
    let items = store.items(id).map_err(Failure::input)?;
    let open = items
        .iter()
        .filter(|item| item.state == ItemState::Waiting)
        .filter(|item| is_shown(item.asked.split))
        .count();
    Ok((open > 0).then(|| Check {
        requirement: "every question asked".into(),
        configuration: id.to_string(),
        found: format!("{} not asked yet", output::counted(open, "question")),
        is_met: false,
    }))
}

/// The file of each scenario by its name.
fn hashes(items: &[Item]) -> HashMap<&str, Option<&str>> {
    let each = items.iter().map(|item| {
        let asked = &item.asked;
        (asked.scenario.as_str(), asked.scenario_hash.as_deref())
    });
    each.collect()
}

/// The graver of two ends; what both say is said.
pub fn both(first: Outcome, second: Outcome) -> Outcome {
    match (first, second) {
        (Err(first), Err(second)) => {
            first.say();
            Err(second)
        }
        (first, second) => first.and(second),
    }
}

/// A test case for each requirement and way.
fn xml(checks: &[Check]) -> String {
    let failures = checks.iter().filter(|check| !check.is_met).count();
    let (tests, mut text) = (
        checks.len(),
        String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"),
    );
    text += &format!(
        "<testsuites tests=\"{tests}\" failures=\"{failures}\">\n  <testsuite name=\"nearmiss\" tests=\"{tests}\" \
         failures=\"{failures}\" errors=\"0\" skipped=\"0\">\n"
    );
    for check in checks {
        let (class, name) = (escaped(&check.configuration), escaped(&check.requirement));
        let found = escaped(&check.found);
        text += &if check.is_met {
            format!("    <testcase classname=\"{class}\" name=\"{name}\"/>\n")
        } else {
            format!(
                "    <testcase classname=\"{class}\" name=\"{name}\">\n      <failure message=\"{found}\"/>\n    \
                 </testcase>\n"
            )
        };
    }
    text + "  </testsuite>\n</testsuites>\n"
}

fn escaped(text: &str) -> String {
    let text = visible(text);
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// Declared comparisons.
#[derive(Debug, Clone, clap::Args)]
pub struct Declared {
    /// Model or prompt configuration to compare all others with, by its name in the tables (`lab/model` or `ego · cp ·
    /// lab/model`). Only these comparisons are made; their p-values are adjusted together.
    #[arg(long, value_name = "NAME")]
    baseline: Option<String>,
    /// Primary comparison, as two names. Its p-value is not adjusted for the other comparisons.
    #[arg(long, value_name = "A,B", value_parser = two_names)]
    compare: Option<(String, String)>,
}

/// Two names, separated by a comma.
fn two_names(text: &str) -> Result<(String, String), String> {
    let names = text.split_once(',').map(|(a, b)| (a.trim(), b.trim()));
    match names {
        Some((a, b)) if !a.is_empty() && !b.is_empty() && a != b => Ok((a.into(), b.into())),
        _ => Err("write two different names, separated by a comma".into()),
    }
}

impl Declared {
    /// Whether there are any.
    pub fn any(&self) -> bool {
        self.baseline.is_some() || self.compare.is_some()
    }

    /// The comparisons between ways that there are.
    pub fn comparison(&self, ways: &[&PromptConfig]) -> Result<Comparison, Failure> {
        let comparison = Comparison {
            baseline: self.baseline.clone(),
            primary: self.compare.clone(),
        };
        let Some(name) = comparison
            .unknown(ways)
            .first()
            .map(|name| (*name).to_string())
        else {
            return Ok(comparison);
        };
        let models: BTreeSet<&str> = ways.iter().map(|way| way.model.as_str()).collect();
        let models: Vec<&str> = models.into_iter().collect();
        let example = ways.iter().find(|way| way.frame.is_some()).or(ways.first());
        Err(Failure::input(format!(
            "{name}: no such model or prompt configuration; the models are {}; a prompt configuration is called as in \
             tables, such as `{}`",
            models.join(", "),
            example
                .map(|way| configuration_name(way))
                .unwrap_or_default()
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_for_each_check_and_nothing_is_obeyed() {
        let check = |is_met| Check {
            requirement: "f1 >= 0.8".into(),
            configuration: "lab/<a>\"&\u{1b}".into(),
            found: "f1 is 0.7".into(),
            is_met,
        };
        let text = xml(&[check(true), check(false)]);
        assert!(text.contains("tests=\"2\" failures=\"1\""), "{text}");
        assert!(
            text.contains("classname=\"lab/&lt;a&gt;&quot;&amp;␛\""),
            "{text}"
        );
        assert!(text.contains("<failure message=\"f1 is 0.7\"/>"), "{text}");
    }
}
