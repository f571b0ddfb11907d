//! The table of variants, a line a scenario as soon as it is made, and the figures of all together.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use super::made::Generated;
use crate::cli::plan::Missed;
use crate::cli::{Failure, Outcome, output};
use crate::generation::{Consequence, Saved};
use crate::scenario::Entry;
use crate::scenario::commonroad::NewFile;
use crate::verdict::Motion;

/// Longer names push the columns behind them.
const WIDEST: usize = 48;

/// What is counted.
#[derive(Debug, Default)]
pub struct Summary {
    width: usize,
    begun: bool,
    all: usize,
    generated: usize,
    unfit: usize,
    missed: usize,
    collisions: usize,
    near_misses: usize,
    no_effect: usize,
    none: usize,
    /// Lowest risk scores of the attackers before and after.
    before: Vec<u8>,
    after: Vec<u8>,
    /// Of collisions and near misses, by reaction time.
    avoidable: BTreeMap<String, usize>,
    kinds: BTreeMap<&'static str, usize>,
    candidates: usize,
    refused: BTreeMap<String, usize>,
    seconds: Vec<f64>,
    /// Of models.
    requests: u32,
    tokens: u64,
    usd: f64,
    unpriced: u32,
}

impl Summary {
    pub fn new(entries: &[Entry]) -> Self {
        let names = entries
            .iter()
            .map(|e| output::visible(&e.name).chars().count());
        Self {
            width: names.max().unwrap_or(0).clamp("scenario".len(), WIDEST),
            all: entries.len(),
            ..Self::default()
        }
    }

    pub fn missed(&mut self, missed: &Missed) {
        match missed {
            Missed::Nothing(_) => self.missed += 1,
            _ => self.unfit += 1,
        }
    }

    pub fn count(&mut self, generated: &Generated) {
        let made = &generated.made;
        self.generated += 1;
        self.candidates += made.found.candidates;
        self.seconds.push(generated.took.as_secs_f64());
        if let Some(authored) = &generated.authored {
            let spent = &authored.spent;
            self.requests += spent.requests;
            self.tokens += spent.input_tokens + spent.output_tokens;
            self.usd += spent.usd;
            self.unpriced += spent.unpriced;
        }
        for refusal in &made.found.refused {
            let name = refusal.reason.name().to_owned();
            *self.refused.entry(name).or_default() += 1;
        }
        let chosen = made.chosen.as_ref();
        let Some((chosen, effect)) = chosen.and_then(|c| Some((c, c.attack.effect.as_ref()?)))
        else {
            self.none += 1;
            return;
        };
        match effect.consequence {
            Consequence::Collision(_) => self.collisions += 1,
            Consequence::NearMiss => self.near_misses += 1,
            Consequence::NoEffect => self.no_effect += 1,
        }
        self.before.extend(effect.lowest_before());
        self.after.extend(effect.lowest_after());
        if effect.consequence != Consequence::NoEffect {
            for (delay, certificate) in &chosen.avoidability.certificates {
                let count = self.avoidable.entry(format!("{delay:.1}")).or_default();
                *count += usize::from(certificate.avoidance().is_some());
            }
        }
        *self.kinds.entry(kind(&chosen.attack.asked)).or_default() += 1;
    }

    /// A line of the table, the first time with its header.
    pub fn row(&mut self, generated: &Generated, saved: Option<&Saved>) -> String {
        let mut text = String::new();
        if !std::mem::replace(&mut self.begun, true) {
            let cells = [
                "outcome",
                "attacker",
                "manoeuvre",
                "risk",
                "avoidable",
                "s",
                "written",
            ];
            text.push_str(&self.line("scenario", &cells));
        }
        let made = &generated.made;
        let chosen = made.chosen.as_ref();
        let effect = chosen.and_then(|c| c.attack.effect.as_ref());
        let score = |score: Option<u8>| score.map_or("-".into(), |s| s.to_string());
        let avoidable = chosen.map_or("-".into(), |c| {
            let all = c.avoidability.certificates.iter();
            let late = all.filter(|(_, c)| c.avoidance().is_some()).map(|(d, _)| d);
            late.copied()
                .reduce(f64::max)
                .map_or("not found".into(), |d| format!("{d:.1} s late"))
        });
        let written = saved.map(|s| output::visible(&s.id));
        let written = written.or(generated.note()).unwrap_or_default();
        let cells = [
            effect.map_or("none", |e| e.consequence.name()),
            &effect.map_or("-".into(), |e| e.attacker.to_string()),
            chosen.map_or("-", |c| kind(&c.attack.asked)),
            &effect.map_or("-".into(), |e| {
                format!("{} → {}", score(e.lowest_before()), score(e.lowest_after()))
            }),
            &avoidable,
            &format!("{:.1}", generated.took.as_secs_f64()),
            &written,
        ];
        text.push_str(&self.line(&generated.name, &cells));
        text
    }

    fn line(&self, scenario: &str, cells: &[&str; 7]) -> String {
        let [
            outcome,
            attacker,
            manoeuvre,
            risk,
            avoidable,
            seconds,
            written,
        ] = cells;
        let width = self.width;
        let line = format!(
            "{scenario:<width$}  {outcome:<9}  {attacker:>8}  {manoeuvre:<13}  {risk:<7}  {avoidable:<10}  {seconds:>5}  {written}"
        );
        format!("{}\n", line.trim_end())
    }

    /// The figures in words.
    pub fn words(&self) -> String {
        let counts = [
            (self.collisions, "collision"),
            (self.near_misses, "near miss"),
            (self.no_effect, "without effect"),
            (self.none, "without a motion that passes"),
            (self.missed + self.unfit, "not driven"),
        ];
        let counts = counts.iter().filter(|(n, _)| *n > 0);
        let counts: Vec<String> = counts.map(|(n, what)| format!("{n} {what}")).collect();
        let mut text = format!("{} scenarios: {}\n", self.done(), counts.join(", "));
        if let (Some(before), Some(after)) = (mean(&self.before), mean(&self.after)) {
            text.push_str(&format!(
                "lowest risk score of the attacker, mean: {before:.2} → {after:.2}\n"
            ));
        }
        let effective = self.collisions + self.near_misses;
        if effective > 0 {
            let late = self.avoidable.iter();
            let late: Vec<String> = late.map(|(delay, n)| format!("{n} at {delay} s")).collect();
            text.push_str(&format!(
                "of the {effective} with an effect a good driver avoids, reacting late: {}\n",
                late.join(", ")
            ));
        }
        let refused: usize = self.refused.values().sum();
        text.push_str(&format!(
            "{} motions tried, {refused} refused; all that is written passes the gate\n",
            self.candidates
        ));
        let kinds: Vec<String> = self.kinds.iter().map(|(k, n)| format!("{n} {k}")).collect();
        if !kinds.is_empty() {
            text.push_str(&format!("manoeuvres: {}\n", kinds.join(", ")));
        }
        if self.requests > 0 {
            text.push_str(&format!(
                "{} requests, {} tokens, {:.4} USD{}\n",
                self.requests,
                self.tokens,
                self.usd,
                match self.unpriced {
                    0 => String::new(),
                    n => format!(", and {n} answers whose price is not known"),
                }
            ));
        }
        text
    }

    fn done(&self) -> usize {
        self.generated + self.missed + self.unfit
    }

    fn document(&self) -> Value {
        let effective = self.collisions + self.near_misses;
        let refused: usize = self.refused.values().sum();
        let share = |n: usize, of: usize| (of > 0).then(|| n as f64 / of as f64);
        let mut seconds = self.seconds.clone();
        seconds.sort_by(f64::total_cmp);
        json!({
            "scenarios": self.done(),
            "driven": self.generated,
            "not_driven": self.missed + self.unfit,
            "collisions": self.collisions,
            "near_misses": self.near_misses,
            "no_effect": self.no_effect,
            "none": self.none,
            "effective_share": share(effective, self.generated),
            "mean_min_risk_before": mean(&self.before),
            "mean_min_risk_after": mean(&self.after),
            "avoidable": self.avoidable,
            "candidates": self.candidates,
            "valid_share_of_candidates": share(self.candidates.saturating_sub(refused), self.candidates),
            "refused": self.refused,
            "manoeuvres": self.kinds,
            "distinct_manoeuvres": self.kinds.len(),
            "median_seconds": seconds.get(seconds.len() / 2),
            "requests": self.requests,
            "tokens": self.tokens,
            "cost_usd": self.usd,
            "unpriced": self.unpriced,
        })
    }

    /// Writes the figures.
    pub fn save(&self, path: &Path, interrupted: bool) -> Result<(), Failure> {
        use std::io::Write;
        let mut file = NewFile::begin(path, false).map_err(Failure::input)?;
        let mut document = self.document();
        document["interrupted"] = interrupted.into();
        document["asked_for"] = self.all.into();
        let text = format!("{}\n", output::escaped(&document.to_string()));
        file.write_all(text.as_bytes())
            .map_err(|e| Failure::system(path.display(), &e))?;
        file.finish().map_err(Failure::input)
    }

    /// The exit status.
    pub fn outcome(&self) -> Outcome {
        let finding = |message| Err(Failure { message, status: 1 });
        let without = self.no_effect + self.none;
        match (without, self.missed + self.unfit) {
            (0, 0) => Ok(()),
            _ if self.unfit == self.all => Err(Failure::input("no scenario could be driven")),
            (0, n) => finding(format!("{n} of {} scenarios could not be driven", self.all)),
            (n, 0) => finding(format!(
                "{n} of {} scenarios have neither a collision nor a near miss",
                self.all
            )),
            (n, m) => finding(format!(
                "{n} of {} scenarios have neither a collision nor a near miss, and {m} could not be driven",
                self.all
            )),
        }
    }
}

fn kind(asked: &Motion) -> &'static str {
    match asked {
        Motion::Manoeuvre(manoeuvre) => manoeuvre.kind.name(),
        Motion::Waypoints(_) => "waypoints",
    }
}

fn mean(scores: &[u8]) -> Option<f64> {
    let sum: f64 = scores.iter().map(|s| f64::from(*s)).sum();
    (!scores.is_empty()).then(|| sum / scores.len() as f64)
}
