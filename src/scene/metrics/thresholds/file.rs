//! A file of thresholds: what it may say, and clear words for what it may not.

use serde::Deserialize;
use toml::Spanned;

use super::Thresholds;
use nearmiss_base::system::{Mistake, line_at, toml_mistake};

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
