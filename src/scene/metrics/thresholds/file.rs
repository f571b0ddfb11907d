//! A file of thresholds: what it may say, entry by entry, and clear words for what it may not.

use std::ops::Range;

use nearmiss_base::system::{Mistake, line_at, toml_mistake};
use serde::Deserialize;
use toml::Spanned;

use super::super::{Danger, LIMITS, Measure, measure, measures};
use super::{Threshold, Thresholds};

/// Why a file of thresholds is not in use.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}: {message}", line.map(|l| format!(":{l}")).unwrap_or_default())]
pub struct ThresholdError {
    /// Which file.
    pub file: String,
    /// Line from 1.
    pub line: Option<usize>,
    /// The mistake, with the key and the allowed values.
    pub message: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    threshold: Vec<OwnThreshold>,
    #[serde(default)]
    level: Vec<OwnLevel>,
    #[serde(default)]
    limit: Vec<OwnLimit>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OwnThreshold {
    pub measure: Spanned<String>,
    pub name: Spanned<String>,
    pub value: Spanned<f64>,
    pub unit: Option<Spanned<String>>,
    pub source: Option<Spanned<String>>,
    pub strict: Option<bool>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OwnLevel {
    pub score: Spanned<i64>,
    pub distance: Option<Spanned<f64>>,
    pub time: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OwnLimit {
    pub name: Spanned<String>,
    pub value: Spanned<f64>,
    pub unit: Option<Spanned<String>>,
}

/// Longest piece of a line that is shown, characters.
const MAX_EXCERPT: usize = 80;

impl Thresholds {
    /// Those that come with the program, changed entry by entry by the text of a file; `file` is its name, for errors
    /// and for people.
    ///
    /// # Errors
    /// The first thing that is wrong: file, line, key, and what is allowed.
    pub fn read(text: &str, file: &str) -> Result<Self, ThresholdError> {
        let error = |(at, message): (usize, String)| ThresholdError {
            file: file.into(),
            line: Some(line_at(text, at)),
            message,
        };
        let said: File = toml::from_str(text).map_err(|wrong| syntax(text, file, &wrong))?;
        let mut thresholds = Self::shipped().clone();
        thresholds.file = Some(file.into());
        thresholds
            .take_thresholds(&said.threshold, file)
            .and_then(|()| thresholds.take_levels(&said.level))
            .and_then(|()| thresholds.take_limits(&said.limit))
            .map_err(error)?;
        Ok(thresholds)
    }
}

/// A mistake of TOML's, or an unknown key, with the line that it is in: messages alone do not always name the key.
fn syntax(text: &str, file: &str, wrong: &toml::de::Error) -> ThresholdError {
    let Mistake { line, words } = toml_mistake(text, wrong);
    let message = words
        .replace("expected f64", "expected a number")
        .replace("expected i64", "expected a whole number");
    let shown = line
        .and_then(|line| text.lines().nth(line - 1))
        .map(str::trim);
    let shown: Option<String> = shown.map(|line| line.chars().take(MAX_EXCERPT).collect());
    ThresholdError {
        file: file.into(),
        line,
        message: match shown {
            Some(shown) if !shown.is_empty() => format!("{message}, in `{shown}`"),
            _ => message,
        },
    }
}

/// More critical values of one measure than this cannot be told apart in a plot.
const MAX_CRITICAL_VALUES: usize = 8;

/// Longest name or source, characters.
const MAX_CHARACTERS: usize = 80;

/// Largest bound of a risk level, metres or seconds.
const MAX_BOUND: f64 = 1e4;

/// The byte of the file at which something is wrong, and what.
type Wrong = (usize, String);

impl Thresholds {
    pub(super) fn take_thresholds(
        &mut self,
        all: &[OwnThreshold],
        file: &str,
    ) -> Result<(), Wrong> {
        let shipped = self.critical.clone();
        for own in all {
            self.take_threshold(own, file)?;
        }
        for own in all {
            self.keeps_order(own, &shipped)?;
        }
        let place = |t: &Threshold| measures().position(|m| m.id == t.measure);
        self.critical.sort_by(|a, b| {
            let of_one = place(a).cmp(&place(b));
            let danger = measure(&a.measure).map_or(Danger::Neutral, |m| m.danger);
            of_one.then_with(|| danger.compare(a.value, b.value))
        });
        Ok(())
    }

    fn take_threshold(&mut self, own: &OwnThreshold, file: &str) -> Result<(), Wrong> {
        let measure = known(&own.measure)?;
        let name = one_line("name", &own.name)?;
        let value = finite("value", &own.value)?;
        unit(own.unit.as_ref(), measure.id, measure.unit)?;
        let source = match &own.source {
            Some(source) => one_line("source", source)?,
            None => file,
        };
        let of_measure = || self.critical.iter().filter(|t| t.measure == measure.id);
        let place = self
            .critical
            .iter()
            .position(|t| t.measure == measure.id && t.name == name);
        let old = place.map(|place| &self.critical[place]);
        let at = own.name.span().start;
        if old.is_some_and(|old| old.own) {
            let message = format!("name `{name}` of {} is given twice", measure.id);
            return Err((at, message));
        }
        if old.is_none() && of_measure().count() >= MAX_CRITICAL_VALUES {
            let message = format!(
                "measure `{}` has more than {MAX_CRITICAL_VALUES} thresholds",
                measure.id
            );
            return Err((at, message));
        }
        let threshold = Threshold {
            measure: measure.id.into(),
            value,
            name: name.into(),
            source: source.into(),
            strict: own.strict.unwrap_or(old.is_some_and(|old| old.strict)),
            own: true,
        };
        match place {
            Some(place) => self.critical[place] = threshold,
            None => self.critical.push(threshold),
        }
        Ok(())
    }

    /// Whether what an entry changes is still in the order of danger that its names promise.
    fn keeps_order(&self, own: &OwnThreshold, shipped: &[Threshold]) -> Result<(), Wrong> {
        let measure = known(&own.measure)?;
        let names = shipped.iter().filter(|t| t.measure == measure.id);
        let names: Vec<&str> = names.map(|t| t.name.as_str()).collect();
        let value = |name: &str| self.for_measure(measure.id).find(|t| t.name == name);
        for pair in names.windows(2) {
            let [Some(worse), Some(better)] = [value(pair[0]), value(pair[1])] else {
                continue;
            };
            let ordered = measure.danger.compare(worse.value, better.value).is_lt();
            if !ordered && pair.contains(&own.name.get_ref().as_str()) {
                let side = match measure.danger {
                    Danger::High => "above",
                    Danger::Low | Danger::Neutral => "below",
                };
                return Err((
                    own.value.span().start,
                    format!(
                        "value of {}: `{}` ({}) must be {side} `{}` ({})",
                        measure.id, worse.name, worse.value, better.name, better.value
                    ),
                ));
            }
        }
        Ok(())
    }

    pub(super) fn take_levels(&mut self, all: &[OwnLevel]) -> Result<(), Wrong> {
        let last = self.risk.levels.len() - 1;
        for own in all {
            let (at, score) = (own.score.span().start, *own.score.get_ref());
            let place = usize::try_from(score).ok().filter(|place| *place < last);
            let Some(place) = place else {
                let message = format!(
                    "score {score} has no bounds; allowed are 0 to {}, and {last} is everything above",
                    last - 1
                );
                return Err((at, message));
            };
            let level = &mut self.risk.levels[place];
            if self.own_levels.contains(&level.score) {
                return Err((at, format!("score {score} is given twice")));
            }
            if own.distance.is_none() && own.time.is_none() {
                return Err((
                    at,
                    format!("score {score} needs `distance`, `time` or both"),
                ));
            }
            if let Some(distance) = &own.distance {
                level.distance = Some(bound("distance", distance)?);
            }
            if let Some(time) = &own.time {
                level.time = Some(bound("time", time)?);
            }
            self.own_levels.push(level.score);
        }
        for own in all {
            let score = *own.score.get_ref();
            self.rises("distance", "m", own.distance.as_ref(), score, |l| {
                l.distance
            })?;
            self.rises("time", "s", own.time.as_ref(), score, |l| l.time)?;
        }
        Ok(())
    }

    /// Whether a bound lies above that of the score before and below that of the next one.
    fn rises(
        &self,
        key: &str,
        unit: &str,
        own: Option<&Spanned<f64>>,
        score: i64,
        bound: fn(&super::super::RiskLevel) -> Option<f64>,
    ) -> Result<(), Wrong> {
        let Some(own) = own else { return Ok(()) };
        let of = |score: i64| {
            let score = u8::try_from(score).ok()?;
            bound(self.risk.level(score)?)
        };
        let value = *own.get_ref();
        let beside = [(score - 1, "above"), (score + 1, "below")];
        for (other, side) in beside {
            let Some(limit) = of(other) else { continue };
            let fine = if other < score {
                value > limit
            } else {
                value < limit
            };
            if !fine {
                let message = format!(
                    "{key} {value} {unit} of score {score} must be {side} that of score {other}, {limit} {unit}"
                );
                return Err((own.span().start, message));
            }
        }
        Ok(())
    }

    pub(super) fn take_limits(&mut self, all: &[OwnLimit]) -> Result<(), Wrong> {
        for own in all {
            let (at, name) = (own.name.span().start, own.name.get_ref());
            let Some(limit) = LIMITS.iter().find(|l| l.id == name) else {
                let names: Vec<&str> = LIMITS.iter().map(|l| l.id).collect();
                let message = format!(
                    "unknown limit `{}`; available: {}",
                    name.escape_debug(),
                    names.join(", ")
                );
                return Err((at, message));
            };
            if self.own_limits.contains(&limit.id) {
                return Err((at, format!("limit {} is given twice", limit.id)));
            }
            unit(own.unit.as_ref(), limit.id, limit.unit)?;
            let value = *own.value.get_ref();
            if !limit.allowed.contains(&value) {
                let message = format!(
                    "value {value} of {} is not allowed; it must be {} to {} {}",
                    limit.id,
                    limit.allowed.start(),
                    limit.allowed.end(),
                    limit.unit
                );
                return Err((own.value.span().start, message));
            }
            limit.set(&mut self.limits, value);
            self.own_limits.push(limit.id);
        }
        // Whatever order is broken, an entry of the file broke it.
        let about = |order: &str| {
            let named = |own: &&OwnLimit| order.split(' ').any(|word| word == own.name.get_ref());
            all.iter().rev().find(named)
        };
        match self.limits.mistake() {
            None => Ok(()),
            Some(order) => {
                let at = about(order).map_or(0, |own| own.value.span().start);
                Err((at, format!("value: {order}")))
            }
        }
    }
}

fn known(id: &Spanned<String>) -> Result<&'static Measure, Wrong> {
    match measure(id.get_ref()) {
        Some(found) if found.danger != Danger::Neutral => Ok(found),
        found => {
            let why = match found {
                Some(_) => "is descriptive and has no dangerous values",
                None => "is not known",
            };
            let can = measures().filter(|m| m.danger != Danger::Neutral);
            let ids: Vec<&str> = can.map(|m| m.id).collect();
            let message = format!(
                "measure `{}` {why}; allowed are {}",
                id.get_ref().escape_debug(),
                ids.join(", ")
            );
            Err((id.span().start, message))
        }
    }
}

/// A text that can be shown on one line.
fn one_line<'a>(key: &str, text: &'a Spanned<String>) -> Result<&'a str, Wrong> {
    let words = text.get_ref().as_str();
    if words.trim().is_empty()
        || words.chars().count() > MAX_CHARACTERS
        || words.contains(char::is_control)
    {
        let message = format!(
            "{key} must be 1 to {MAX_CHARACTERS} characters on one line, without control characters"
        );
        return Err((text.span().start, message));
    }
    Ok(words)
}

fn finite(key: &str, value: &Spanned<f64>) -> Result<f64, Wrong> {
    let found = *value.get_ref();
    if found.is_finite() {
        Ok(found)
    } else {
        Err((
            value.span().start,
            format!("{key} must be a finite number, not {found}"),
        ))
    }
}

fn bound(key: &str, value: &Spanned<f64>) -> Result<f64, Wrong> {
    let found = *value.get_ref();
    if (0.0..=MAX_BOUND).contains(&found) {
        Ok(found)
    } else {
        let message = format!("{key} {found} is not allowed; it must be 0 to {MAX_BOUND}");
        Err((value.span().start, message))
    }
}

/// A unit may be left out, but what is said must be right.
fn unit(said: Option<&Spanned<String>>, of: &str, right: &str) -> Result<(), Wrong> {
    let Some(said) = said else { return Ok(()) };
    let plain = |unit: &str| unit.replace('²', "2").replace("^2", "2").replace(' ', "");
    if plain(said.get_ref()) == plain(right) {
        return Ok(());
    }
    let allowed = match right {
        "" => "it has none".to_string(),
        unit => format!("it is in {unit}"),
    };
    let message = format!(
        "unit `{}` of {of} is wrong: {allowed}",
        said.get_ref().escape_debug()
    );
    let Range { start, .. } = said.span();
    Err((start, message))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::super::{LIMITS, measure};
    use super::*;

    fn read(text: &str) -> Result<Thresholds, ThresholdError> {
        Thresholds::read(text, "mine.toml")
    }

    #[test]
    fn entries_change_what_they_name_and_nothing_else() {
        let shipped = Thresholds::shipped();
        let none = read("# nothing\n").unwrap();
        assert_eq!(none.changes(), []);
        assert_eq!(
            (none.file(), &none.risk),
            (Some("mine.toml"), &shipped.risk)
        );
        let text = r#"
            [[threshold]]
            measure = "ttc"
            name = "critical"
            value = 1
            unit = "s"
            source = "a study"
            [[threshold]]
            measure = "ttb"
            name = "late"
            value = 0.5
            [[level]]
            score = 1
            distance = 0.8
            [[limit]]
            name = "full_braking"
            value = 6.5
            unit = "m/s^2"
        "#;
        let own = read(text).unwrap();
        let ttc: Vec<_> = own
            .for_measure("ttc")
            .map(|t| (t.name.as_str(), t.value, t.own))
            .collect();
        assert_eq!(ttc, [("critical", 1.0, true), ("conflict", 3.0, false)]);
        assert_eq!(own.for_measure("ttc").next().unwrap().source, "a study");
        assert_eq!(own.for_measure("ttb").next().unwrap().source, "mine.toml");
        assert_eq!(
            own.reached(measure("ttb").unwrap(), 0.4).unwrap().name,
            "late"
        );
        assert_eq!(
            (own.risk.of_distance(0.8), shipped.risk.of_distance(0.8)),
            (1, 2)
        );
        assert_eq!(own.risk.of_time(Some(0.6)), shipped.risk.of_time(Some(0.6)));
        assert_eq!(own.limits.full_braking, 6.5);
        let others = LIMITS.iter().filter(|l| l.id != "full_braking");
        for limit in others {
            assert_eq!(
                limit.value(&own.limits),
                limit.value(&shipped.limits),
                "{}",
                limit.id
            );
            assert!(!own.own_limit(limit));
        }
        let changes: Vec<_> = own.changes().iter().map(ToString::to_string).collect();
        let expected = [
            "threshold ttc critical 1 s",
            "threshold ttb late 0.5 s",
            "risk 1 distance 0.8 m",
            "limit full_braking 6.5 m/s²",
        ];
        assert_eq!(changes, expected);
    }

    #[test]
    fn a_strict_threshold_stays_strict_unless_it_is_said() {
        let text = "[[threshold]]\nmeasure = \"rss_margin\"\nname = \"dangerous\"\nvalue = 0.2\n";
        let strict = |text: &str| {
            read(text)
                .unwrap()
                .for_measure("rss_margin")
                .next()
                .unwrap()
                .strict
        };
        assert!(strict(text));
        assert!(!strict(&format!("{text}strict = false\n")));
    }

    /// Each with the line of its mistake, and words that the error must hold.
    #[test]
    fn mistakes_are_named_with_file_line_key_and_what_is_allowed() {
        let ttc = "[[threshold]]\nmeasure = \"ttc\"\n";
        let limit = |name: &str, rest: &str| format!("[[limit]]\nname = \"{name}\"\n{rest}\n");
        let level = |rest: &str| format!("[[level]]\n{rest}\n");
        let cases: &[(String, usize, &[&str])] = &[
            ("foo = 1".into(), 1, &["foo", "threshold", "level", "limit"]),
            ("[[limit]".into(), 1, &["[[limit]"]),
            (
                "[[threshold]]\nname = \"a\"\nvalue = 1".into(),
                1,
                &["measure"],
            ),
            (
                format!("{ttc}nam = \"a\"\nvalue = 1"),
                3,
                &["nam", "`name`", "`value`", "`unit`"],
            ),
            (
                format!("{ttc}name = \"a\"\nvalue = \"1 s\""),
                4,
                &["a number", "value = \"1 s\""],
            ),
            (
                format!("{ttc}name = \"a\"\nvalue = inf"),
                4,
                &["value", "finite"],
            ),
            (
                format!("{ttc}name = \"a\"\nvalue = 1\nunit = \"ms\""),
                5,
                &["unit `ms` of ttc", "in s"],
            ),
            (
                format!("{ttc}name = \"a\\u001b[2J\"\nvalue = 1"),
                3,
                &["name", "control"],
            ),
            (
                format!("{ttc}name = \"critical\"\nvalue = 3"),
                4,
                &["`critical` (3)", "below `conflict` (3)"],
            ),
            (
                format!("{ttc}name = \"a\"\nvalue = 1\n{ttc}name = \"a\"\nvalue = 2"),
                7,
                &["`a` of ttc", "twice"],
            ),
            (
                "[[threshold]]\nmeasure = \"gap_lat\"\nname = \"a\"\nvalue = 1".into(),
                2,
                &["gap_lat", "is descriptive", "ttc, risk"],
            ),
            (
                "[[threshold]]\nmeasure = \"tcc\"\nname = \"a\"\nvalue = 1".into(),
                2,
                &["`tcc` is not known", "ttc, risk"],
            ),
            (
                "[[threshold]]\nmeasure = \"risk\"\nname = \"a\"\nvalue = 1\nunit = \"s\"".into(),
                5,
                &["it has none"],
            ),
            (level("score = 5\ntime = 9"), 2, &["score 5", "0 to 4"]),
            (level("score = -1\ntime = 9"), 2, &["score -1", "0 to 4"]),
            (level("score = 2"), 2, &["`distance`, `time`"]),
            (level("score = 2\ntime = -1"), 3, &["time -1", "0 to 10000"]),
            (
                level("score = 2\ntime = 3"),
                3,
                &["time 3 s of score 2", "below", "score 3, 3 s"],
            ),
            (
                level("score = 3\ndistance = 0.9"),
                3,
                &["distance 0.9 m of score 3", "above", "score 2, 1 m"],
            ),
            (
                level("score = 2\ntime = 1.1\n[[level]]\nscore = 2\ntime = 1.2"),
                5,
                &["twice"],
            ),
            (
                limit("full_brake", "value = 1"),
                2,
                &["`full_brake`", "full_braking, kick_down"],
            ),
            (
                limit("tau", "value = 0"),
                3,
                &["value 0 of tau", "0.01 to 100 s"],
            ),
            (
                limit("tau", "value = nan"),
                3,
                &["value NaN of tau", "0.01 to 100 s"],
            ),
            (
                limit("tau", "value = 1\nunit = \"m/s²\""),
                4,
                &["unit `m/s²` of tau", "in s"],
            ),
            (
                limit("madr_least", "value = 9"),
                3,
                &["madr_least < madr_mean"],
            ),
            (
                limit("rss_brake_least", "value = 8.5"),
                3,
                &["rss_brake_least ≤ rss_brake_most"],
            ),
            (
                limit("tau", "value = 1\n[[limit]]\nname = \"tau\"\nvalue = 3"),
                5,
                &["tau", "twice"],
            ),
        ];
        for (text, line, words) in cases {
            let error = read(text).expect_err(text);
            assert_eq!(
                (error.file.as_str(), error.line),
                ("mine.toml", Some(*line)),
                "{text}: {error}"
            );
            let shown = error.to_string();
            assert!(shown.starts_with(&format!("mine.toml:{line}: ")), "{shown}");
            for word in *words {
                assert!(shown.contains(word), "`{word}` is not in: {shown}");
            }
            assert!(!shown.contains(char::is_control), "{shown:?}");
        }
    }

    #[test]
    fn a_measure_has_no_more_thresholds_than_can_be_told_apart() {
        let entry =
            |i: usize| format!("[[threshold]]\nmeasure = \"ttc\"\nname = \"n{i}\"\nvalue = {i}\n");
        let file = |count: usize| (0..count).map(entry).collect::<String>();
        // Two are shipped.
        let most = read(&file(6)).unwrap();
        let values: Vec<f64> = most.for_measure("ttc").map(|t| t.value).collect();
        assert_eq!(
            values,
            [0.0, 1.0, 1.5, 2.0, 3.0, 3.0, 4.0, 5.0],
            "the most dangerous first"
        );
        assert!(read(&file(7)).unwrap_err().message.contains("more than 8"));
    }
}
