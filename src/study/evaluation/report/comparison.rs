//! Declared comparisons of two configurations on the same scenarios, and their verdicts by question and by scenario.

use std::collections::{BTreeMap, BTreeSet};

use nearmiss_ask::prompts::Techniques;
use nearmiss_record::Record;
use nearmiss_record::fields::Fields;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use strum::{IntoStaticStr, VariantArray};

use super::super::statistics::{
    AllRight, AnswerAgreement, Interval, McNemar, PairedTest, ShareIntervals, holm, if_enough,
    majority, mean_interval, scenario_interval, share_interval, share_intervals,
};
use super::super::{Confusion, PromptConfig, Scored};
use super::cell::count;
use super::names;

/// Which comparisons a report makes. Names are models, or ways as tables name them: `ego · cp+cot · lab/model`, with the
/// version of the template or without.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Comparison {
    /// What all others are compared with; `None` for every pair that differs in one thing.
    pub baseline: Option<String>,
    /// The two whose comparison was declared to be the one that matters.
    pub primary: Option<(String, String)>,
}

/// Comparisons that are corrected together.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, JsonSchema, IntoStaticStr, VariantArray,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Family {
    /// The declared one; several where two models were declared that were asked in several ways.
    Declared,
    /// Those with the baseline.
    Baseline,
    /// Every pair that differs in one thing.
    Pairs,
}

nearmiss_record::named!(Family);

/// A pair to be compared, in its order.
pub(super) struct Compared {
    pub family: Family,
    /// Whether the second of the two stands first.
    pub turned: bool,
    /// In what they differ.
    pub differs: &'static str,
}

impl Comparison {
    /// The same in words: the baseline, and the comparison that matters; `None` without either.
    #[must_use]
    pub fn summary(&self) -> Option<String> {
        let baseline = self
            .baseline
            .as_ref()
            .map(|name| format!("the baseline {name}"));
        let primary = self
            .primary
            .as_ref()
            .map(|(a, b)| format!("the comparison of {a} with {b}"));
        let parts: Vec<String> = baseline.into_iter().chain(primary).collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    /// The names that none of these ways has.
    pub fn unknown<'a>(&'a self, configurations: &[&PromptConfig]) -> Vec<&'a str> {
        let primary = self.primary.iter().flat_map(|(a, b)| [a, b]);
        let all = primary.chain(&self.baseline).map(String::as_str);
        all.filter(|name| {
            !configurations
                .iter()
                .any(|configuration| is_called(configuration, name))
        })
        .collect()
    }

    /// Whether two ways are compared, and as what.
    pub(super) fn classify(&self, a: &PromptConfig, b: &PromptConfig) -> Option<Compared> {
        if a.task != b.task {
            return None;
        }
        let compared = |family, turned, differs| Compared {
            family,
            turned,
            differs,
        };
        if let Some((first, second)) = &self.primary {
            let fits = |a, b| is_called(a, first) && is_called(b, second);
            // Of models those that are asked in the same way; ways may differ in more than one thing.
            let models =
                *first == a.model && *second == b.model || *first == b.model && *second == a.model;
            let differs = if models {
                comparable(a, b)
            } else {
                Some(comparable(a, b).unwrap_or("several"))
            };
            if let Some(differs) = differs {
                if fits(a, b) {
                    return Some(compared(Family::Declared, false, differs));
                }
                if fits(b, a) {
                    return Some(compared(Family::Declared, true, differs));
                }
            }
        }
        let Some(baseline) = &self.baseline else {
            return Some(compared(Family::Pairs, false, difference(a, b)?));
        };
        let differs = comparable(a, b)?;
        match (is_called(a, baseline), is_called(b, baseline)) {
            (true, false) => Some(compared(Family::Baseline, true, differs)),
            (false, true) => Some(compared(Family::Baseline, false, differs)),
            _ => None,
        }
    }
}

/// Whether tables call a way by this name: its model, or the whole way, with the version of the template or without.
/// Batches of before call all techniques `all`.
pub(crate) fn is_called(configuration: &PromptConfig, name: &str) -> bool {
    let called = name.replace(" · all · ", &format!(" · {} · ", Techniques::ALL));
    let bare = PromptConfig {
        template: None,
        ..configuration.clone()
    };
    configuration.model == name
        || names::configuration_name(configuration) == called
        || names::configuration_name(&bare) == called
}

/// The one thing in which two ways differ. The built-in judge, which has no prompt, differs from all others in the
/// model.
fn comparable(a: &PromptConfig, b: &PromptConfig) -> Option<&'static str> {
    let is_judge = |configuration: &PromptConfig| configuration.model == judge::MODEL;
    if is_judge(a) != is_judge(b) {
        Some("model")
    } else {
        difference(a, b)
    }
}

fn difference(a: &PromptConfig, b: &PromptConfig) -> Option<&'static str> {
    // A judge without a prompt differs from the others in frame and techniques at once.
    if a.task != b.task || a.frame.is_some() != b.frame.is_some() {
        return None;
    }
    let axes = a.settings.differences(&b.settings);
    let mut differ = [
        (a.frame != b.frame, "frame"),
        (a.techniques != b.techniques, "techniques"),
        (a.model != b.model, "model"),
        (a.template != b.template, "template"),
    ]
    .into_iter()
    .filter(|(differs, _)| *differs)
    .map(|(_, name)| name)
    .chain(axes);
    let name = differ.next()?;
    differ.next().is_none().then_some(name)
}

/// Two ways on the same scenarios.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Pair {
    /// One way.
    pub first: PromptConfig,
    /// The other one.
    pub second: PromptConfig,
    /// In what they differ: `frame`, `techniques`, `model` or `template`; `several` of declared ones.
    pub differs: &'static str,
    /// With which other comparisons it is corrected.
    #[schemars(title = "Family")]
    pub family: Family,
    /// Units with a truth that both were asked about.
    #[schemars(title = "n")]
    pub n: u32,
    /// Units of both that one was not asked about yet.
    #[schemars(title = "Left out")]
    pub left_out: u32,
    /// Of the n those on which the samples of at least one are as often right as wrong.
    #[schemars(title = "Ties")]
    pub ties: u32,
    /// By how much the first is right more often.
    #[serde(flatten)]
    pub test: PairedTest,
    /// The p value of the test, corrected for its family of the same task, by Holm.
    #[serde(rename = "p_holm")]
    #[schemars(title = "p (Holm)", extend("decimals" = 3, "bounded" = true))]
    pub corrected: f64,
    /// The same of majorities: without ties.
    #[serde(flatten)]
    pub mcnemar: McNemar,
    /// By how much the first states more that is wrong.
    #[serde(flatten)]
    pub claims: ClaimDifference,
}

impl Record for Pair {
    const NAME: &'static str = "pair";
    const TITLE: &'static str = "Two prompt configurations on the same scenarios";
}

/// How two ways differ in their wrong claims, on the same units.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct ClaimDifference {
    /// Units in which both made claims that are right or wrong.
    #[serde(rename = "claims_n")]
    pub n: u32,
    /// The share of wrong claims of the first minus that of the second, on average over the units; null of none.
    #[serde(rename = "claims_wrong_difference")]
    #[schemars(title = "Wrong claims", extend("decimals" = 2))]
    pub difference: Option<f64>,
    /// Its bootstrap interval of 95 %, over units; null of few.
    #[serde(rename = "claims_wrong_difference_ci")]
    pub interval: Option<Interval>,
}

impl ClaimDifference {
    fn of([a, b]: [&Claims<'_>; 2]) -> Self {
        let share = |(wrong, decided): Counts| f64::from(wrong) / f64::from(decided);
        let both = a.iter().filter_map(|(unit, a)| Some((*a, *b.get(unit)?)));
        let differences: Vec<f64> = both.map(|(a, b)| share(a) - share(b)).collect();
        let n = count(differences.len());
        Self {
            n,
            difference: (n > 0).then(|| differences.iter().sum::<f64>() / f64::from(n)),
            interval: if_enough(mean_interval(&differences), n),
        }
    }
}

/// The wrong claims of each unit, and those that are right or wrong; units without any are left out.
type Claims<'a> = BTreeMap<&'a str, Counts>;

fn claims<'a>(scored: &[&'a Scored]) -> Claims<'a> {
    let mut found = Claims::new();
    for one in scored {
        if let Some([right, wrong, _]) = one.claims.known()
            && right + wrong > 0
        {
            let (of_wrong, decided) = found.entry(one.unit()).or_default();
            *of_wrong += wrong;
            *decided += right + wrong;
        }
    }
    found
}

/// How often a way is right about each scenario of each unit, and how often not: see [`Scored::is_right`].
type Right<'a> = BTreeMap<&'a str, BTreeMap<&'a str, Counts>>;

/// Every comparison, the declared ones first, in the order of the ways.
pub(super) fn compare_pairs(
    configurations: &[(&PromptConfig, Vec<&Scored>)],
    comparison: &Comparison,
) -> Vec<Pair> {
    let told: Vec<(Right<'_>, Claims<'_>)> = configurations
        .par_iter()
        .map(|(_, scored)| (right(scored), claims(scored)))
        .collect();
    let mut wanted = Vec::new();
    for (i, (first, _)) in configurations.iter().enumerate() {
        for (j, (second, _)) in configurations.iter().enumerate().skip(i + 1) {
            if let Some(compared) = comparison.classify(first, second) {
                let (i, j) = if compared.turned { (j, i) } else { (i, j) };
                wanted.push((i, j, compared));
            }
        }
    }
    let pairs = wanted.into_par_iter().filter_map(|(i, j, compared)| {
        pair(
            [configurations[i].0, configurations[j].0],
            &compared,
            [&told[i].0, &told[j].0],
            ClaimDifference::of([&told[i].1, &told[j].1]),
        )
    });
    let mut pairs: Vec<Pair> = pairs.collect();
    pairs.sort_by_key(|pair| Family::ALL.iter().position(|family| *family == pair.family));
    for (task, family) in Task::VERDICTS
        .into_iter()
        .flat_map(|task| Family::ALL.map(|family| (task, family)))
    {
        let together = |pair: &&mut Pair| pair.first.task == task && pair.family == family;
        let mut of_family: Vec<&mut Pair> = pairs.iter_mut().filter(together).collect();
        let p: Vec<f64> = of_family.iter().map(|p| p.test.p).collect();
        for (pair, corrected) in of_family.iter_mut().zip(holm(&p)) {
            pair.corrected = corrected;
        }
    }
    pairs
}

fn right<'a>(scored: &[&'a Scored]) -> Right<'a> {
    let mut found = Right::new();
    for one in scored {
        if one.is_collision().is_none() {
            continue;
        }
        let of_unit = found.entry(one.unit()).or_default();
        let (right, wrong) = of_unit.entry(&one.scenario).or_default();
        match one.is_right() {
            Some(true) => *right += 1,
            Some(false) => *wrong += 1,
            None => {}
        }
    }
    found
}

/// Right and not.
type Counts = (u32, u32);

/// Sums over the scenarios of a unit that both were asked about, zeros where that is none; `None` where they have no
/// scenario in common.
fn common(a: &BTreeMap<&str, Counts>, b: &BTreeMap<&str, Counts>) -> Option<[Counts; 2]> {
    let shared = { a.iter() }.filter_map(|(name, a)| Some([*a, *b.get(name)?]));
    let shared: Vec<[Counts; 2]> = shared.collect();
    let asked = shared
        .iter()
        .filter(|both| both.iter().all(|(right, wrong)| right + wrong > 0));
    let sum = |x: Counts, y: Counts| (x.0 + y.0, x.1 + y.1);
    let sums = asked.fold([(0, 0); 2], |all, one| {
        [sum(all[0], one[0]), sum(all[1], one[1])]
    });
    (!shared.is_empty()).then_some(sums)
}

fn pair(
    [first, second]: [&PromptConfig; 2],
    compared: &Compared,
    [a, b]: [&Right<'_>; 2],
    claims: ClaimDifference,
) -> Option<Pair> {
    let units = { a.iter() }.filter_map(|(unit, a)| Some((a, b.get(unit)?)));
    let both: Vec<_> = units.filter_map(|(a, b)| common(a, b)).collect();
    let asked = both.iter().filter(|[(right, wrong), _]| right + wrong > 0);
    let pairs: Vec<_> = asked.collect();
    let share = |(right, wrong): Counts| f64::from(right) / f64::from(right + wrong);
    let differences: Vec<f64> = pairs.iter().map(|[a, b]| share(*a) - share(*b)).collect();
    let majority = |(right, wrong): Counts| (right != wrong).then_some(right > wrong);
    let votes = pairs.iter().map(|[a, b]| majority(*a).zip(majority(*b)));
    let only = |wanted| count(votes.clone().filter(|v| *v == Some(wanted)).count());
    Some(Pair {
        first: first.clone(),
        second: second.clone(),
        differs: compared.differs,
        family: compared.family,
        n: count(pairs.len()),
        left_out: count(both.len() - pairs.len()),
        ties: count(votes.clone().filter(Option::is_none).count()),
        test: PairedTest::of_differences(&differences)?.if_enough(count(pairs.len())),
        mcnemar: McNemar::from_discordant(only((true, false)), only((false, true))),
        corrected: 1.0,
        claims,
    })
}

/// Steps of a window, first and last.
type Window = Option<(i64, i64)>;

/// The verdicts on one question: one scenario, one window.
#[derive(Debug, Default)]
struct Votes {
    truth: Option<bool>,
    yes: u32,
    no: u32,
    /// Answers without a verdict.
    silent: u32,
    samples: BTreeSet<u32>,
}

/// The verdicts of one way.
#[derive(Debug, Default)]
pub(super) struct Ballot<'a> {
    questions: BTreeMap<(&'a str, Window), Votes>,
    units: BTreeMap<&'a str, Confusion>,
    /// By unit, the questions that it is right about, and those asked.
    right: BTreeMap<&'a str, (u32, u32)>,
}

/// What several samples of the same questions come to.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct Samples {
    /// Questions with two verdicts or more.
    #[schemars(title = "Questions")]
    pub scenarios: u32,
    /// Of them those on which all samples agree.
    pub unanimous: u32,
    /// Their share.
    #[schemars(title = "Unanimous", extend("decimals" = 2))]
    pub unanimity: Option<f64>,
    /// The share of pairs of samples that agree.
    #[schemars(title = "Agreement", extend("decimals" = 2))]
    pub agreement: Option<f64>,
    /// The chance that all k samples of a question are right.
    #[schemars(title = "All right", extend("decimals" = 2))]
    pub all_right: Option<f64>,
    /// The number of samples, k.
    pub all_right_k: u32,
    /// Questions with k answers.
    pub all_right_of: u32,
    /// The majority of samples for each question, against the ground truth.
    pub majority: Confusion,
    /// Questions with a truth whose samples say yes and no equally often, or nothing at all.
    #[schemars(title = "Undecided")]
    pub undecided: u32,
    /// Of them those whose samples say yes and no equally often.
    #[schemars(title = "Ties")]
    pub ties: u32,
    /// The share of questions with a truth that have a majority.
    #[schemars(title = "Coverage", extend("decimals" = 2))]
    pub majority_coverage: Option<f64>,
    /// F1 of the majorities.
    #[schemars(title = "F1", extend("decimals" = 2))]
    pub majority_f1: Option<f64>,
}

impl<'a> Ballot<'a> {
    /// Takes an answer, or that there is none; `said` is its yes or no.
    pub fn take(&mut self, one: &'a Scored, said: Option<bool>) {
        let votes = self
            .questions
            .entry((&one.scenario, one.window))
            .or_default();
        votes.truth = votes.truth.or(one.is_collision());
        votes.samples.insert(one.sample);
        match said {
            Some(true) => votes.yes += 1,
            Some(false) => votes.no += 1,
            None => votes.silent += u32::from(one.is_right().is_some()),
        }
        if let Some(is_right) = one.is_right() {
            let (right, asked) = self.right.entry(one.unit()).or_default();
            *right += u32::from(is_right);
            *asked += 1;
        }
        let unit = self.units.entry(one.unit()).or_default();
        if let (Some(said), Some(truth)) = (said, one.is_collision()) {
            unit.count(said, truth);
        }
    }

    /// How many scenarios were asked about.
    pub fn scenarios(&self) -> u32 {
        let names: BTreeSet<&str> = self.questions.keys().map(|(name, _)| *name).collect();
        count(names.len())
    }

    /// What samples come to, with F1 where it is wanted. A question without a run has no window: it is that of the
    /// scenario, where there is one.
    pub fn samples(&mut self, with_f1: bool) -> Samples {
        let unknown: Vec<&str> = self
            .questions
            .keys()
            .filter(|(_, w)| w.is_none())
            .map(|(s, _)| *s)
            .collect();
        for scenario in unknown {
            let after = (scenario, Some((i64::MIN, i64::MIN)));
            let known = self.questions.range(after..).next().map(|(key, _)| *key);
            let Some(known) = known.filter(|(name, _)| *name == scenario) else {
                continue;
            };
            if let Some(votes) = self.questions.remove(&(scenario, None)) {
                let into = self.questions.entry(known).or_default();
                into.samples.extend(votes.samples);
                into.yes += votes.yes;
                into.no += votes.no;
                into.silent += votes.silent;
            }
        }
        let mut found = Samples::default();
        let mut spread = AnswerAgreement::default();
        for votes in self.questions.values() {
            spread.count(votes.yes, votes.no);
            match (majority(votes.yes, votes.no), votes.truth) {
                (Some(said), Some(truth)) => found.majority.count(said, truth),
                (None, Some(_)) => {
                    found.undecided += 1;
                    found.ties += u32::from(votes.yes > 0);
                }
                (_, None) => {}
            }
        }
        let most = self
            .questions
            .values()
            .map(|votes| votes.samples.len())
            .max();
        // An answer without a verdict is not right; a sample that is not asked yet is no answer.
        let right = self.questions.values().filter_map(|votes| {
            let (right, wrong) = if votes.truth? {
                (votes.yes, votes.no)
            } else {
                (votes.no, votes.yes)
            };
            Some((right, wrong + votes.silent))
        });
        let all_right = AllRight::of_questions(count(most.unwrap_or(0)), right);
        let decided = found.majority.answered();
        let all = decided + found.undecided;
        Samples {
            scenarios: spread.scenarios,
            unanimous: spread.unanimous,
            unanimity: spread.unanimity(),
            agreement: spread.agreement(),
            all_right: all_right.share,
            all_right_k: all_right.k,
            all_right_of: all_right.questions,
            majority_coverage: (all > 0).then(|| f64::from(decided) / f64::from(all)),
            majority_f1: found.majority.f1().filter(|_| with_f1),
            ..found
        }
    }

    /// The counts of the units with a verdict and a truth.
    fn counted(&self) -> Vec<Confusion> {
        let all = self.units.values().copied();
        all.filter(|counts| counts.answered() > 0).collect()
    }

    /// The intervals of shares: over units where one has several answers, else Wilson's, F1 apart.
    pub fn intervals(&self) -> ShareIntervals {
        let counted = self.counted();
        let mut sum = Confusion::default();
        counted.iter().for_each(|counts| sum.add(counts));
        let drawn = share_intervals(&counted);
        let clustered = counted.iter().any(|counts| counts.answered() > 1);
        let of = |interval: Option<Interval>, part: fn(&Confusion) -> (u32, u32)| {
            let (hits, all) = part(&sum);
            let holding = counted.iter().filter(|counts| part(counts).1 > 0).count();
            share_interval(interval.filter(|_| clustered), (hits, all), count(holding))
        };
        let right: Vec<(u32, u32)> = self.right.values().copied().collect();
        ShareIntervals {
            right: scenario_interval(&right),
            precision: of(drawn.precision, |c| {
                (c.true_positives, c.true_positives + c.false_positives)
            }),
            recall: of(drawn.recall, |c| (c.true_positives, c.positives())),
            specificity: of(drawn.specificity, |c| (c.true_negatives, c.negatives())),
            accuracy: of(drawn.accuracy, |c| {
                (c.true_positives + c.true_negatives, c.answered())
            }),
            // Where no draw differs, the bootstrap says nothing.
            f1: if_enough(drawn.f1, count(counted.len())).filter(|drawn| drawn.low < drawn.high),
        }
    }
}
