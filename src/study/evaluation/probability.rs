//! The probability of a yes that a verdict stands for, by its own words or the log probabilities of its tokens.

use nearmiss_ask::llm::Token;
use nearmiss_scene::verdict::{ObstacleRisk, Task, Verdict};
use serde::Serialize;

/// Where the probability of a verdict is from, in the order in which they are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ProbabilitySource {
    /// The answer states it.
    Stated,
    /// The largest of its critical obstacles.
    Critical,
    /// The log probabilities of the tokens with which the answer decides.
    Token,
    /// 1 − score/5 of its gravest obstacle, by the scores that the model wrote.
    Score,
    /// Its yes or no, 1 or 0.
    Decision,
}

/// The probability of a yes that a verdict stands for: every verdict has one.
///
/// The paper gives its scores 0 (collision) to 5 (negligible) no probabilities; the straight line between both ends is a
/// convention.
#[must_use]
pub fn probability(verdict: &Verdict) -> (f64, ProbabilitySource) {
    let critical = verdict
        .critical
        .iter()
        .flatten()
        .filter_map(|c| c.probability)
        .reduce(f64::max);
    let score = || {
        // What the model wrote: the grade of a group is this program's reading.
        let scores = verdict.obstacles.iter().map(ObstacleRisk::stated_score);
        Some(1.0 - f64::from(scores.min()?.min(5)) / 5.0)
    };
    if let Some(stated) = verdict.probability {
        (stated, ProbabilitySource::Stated)
    } else if let Some(largest) = critical {
        (largest, ProbabilitySource::Critical)
    } else if let Some(of_tokens) = verdict.token_probability {
        (of_tokens, ProbabilitySource::Token)
    } else if let Some(of_score) = score() {
        (of_score, ProbabilitySource::Score)
    } else {
        (
            f64::from(u8::from(verdict.dangerous)),
            ProbabilitySource::Decision,
        )
    }
}

/// The probability of a yes at the token with which an answer decides: e^l of the tokens there that begin a yes, over
/// that of those that begin a yes or a no, among the alternatives that the server lists. `None` where the tokens do not
/// show where the answer decides as its verdict says, or none of them is a yes or a no.
///
/// The key of the decision (`safety_critical`, `collision`) is looked for from the end: an answer may quote it before.
#[must_use]
pub fn token_probability(tokens: &[Token], task: Task, dangerous: bool) -> Option<f64> {
    let text: String = tokens.iter().map(|token| token.text.as_str()).collect();
    let key = task.key();
    let mut before = text.len();
    while let Some(at) = text[..before].rfind(key) {
        let behind = at + key.len();
        let between = |c: char| c.is_whitespace() || ['"', '\'', ':'].contains(&c);
        let value = text[behind..].trim_start_matches(between);
        let at_value = text.len() - value.len();
        if at_value > behind && decision(value) == Some(dangerous) {
            return at_token(tokens, at_value);
        }
        before = at;
    }
    None
}

/// The same at the token that holds the byte `at` of the answer.
fn at_token(tokens: &[Token], at: usize) -> Option<f64> {
    let mut start = 0;
    let token = tokens.iter().find(|token| {
        let holds = start + token.text.len() > at;
        start += if holds { 0 } else { token.text.len() };
        holds
    })?;
    // Some tokens hold more than the value, such as a colon or a space before it.
    let lead = token.text.get(..at - start)?;
    let chosen = (&token.text, token.log_probability);
    let others = token
        .alternatives
        .iter()
        .map(|(text, log)| (text, *log))
        .filter(|(text, _)| *text != chosen.0);
    let [mut yes, mut no] = [0.0, 0.0];
    for (text, log) in std::iter::once(chosen).chain(others) {
        let value = text
            .strip_prefix(lead)
            .unwrap_or(text)
            .trim_start_matches(|c: char| !c.is_alphanumeric());
        match decision(value) {
            Some(true) => yes += log.exp(),
            Some(false) => no += log.exp(),
            None => {}
        }
    }
    let probability = yes / (yes + no);
    probability.is_finite().then_some(probability)
}

/// Whether a text begins with a yes or a no, or is the beginning of one.
fn decision(text: &str) -> Option<bool> {
    let word: String = text
        .chars()
        .take_while(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect();
    let is = |whole: &str| !word.is_empty() && whole.starts_with(&word);
    if is("true") || is("yes") || word == "1" {
        Some(true)
    } else if is("false") || is("no") || word == "0" {
        Some(false)
    } else {
        None
    }
}

/// A verdict that was read anew from its text, with the token probability that the stored one has.
#[must_use]
pub fn with_token_probability(mut verdict: Verdict, stored: Option<&str>) -> Verdict {
    let beside = ["token_probability", "unknown_obstacles"];
    let stored = stored
        .filter(|json| beside.iter().any(|key| json.contains(key)))
        .and_then(|json| serde_json::from_str::<Verdict>(json).ok());
    let same = stored.filter(|kept| kept.dangerous == verdict.dangerous);
    if let Some(kept) = same {
        verdict.token_probability = kept.token_probability;
        verdict.unknown = kept.unknown;
    }
    verdict
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::ProbabilitySource::{Critical, Decision, Score, Stated};
    use super::*;
    use nearmiss_scene::verdict::{CriticalObstacle, Task};

    #[test]
    fn every_verdict_has_a_probability() {
        let risk = |id, risk_score| ObstacleRisk {
            id,
            risk_score,
            reason: String::new(),
            written_score: None,
        };
        let critical = |probability| CriticalObstacle {
            id: 7,
            probability: Some(probability),
        };
        let mut verdict = Verdict {
            task: Task::Safety,
            dangerous: true,
            obstacles: vec![risk(7, 4), risk(8, 1)],
            justification: String::new(),
            critical: Some(vec![critical(0.3), critical(0.6)]),
            probability: Some(0.7),
            token_probability: None,
            unknown: Vec::new(),
        };
        assert_eq!(probability(&verdict), (0.7, Stated));
        verdict.probability = None;
        assert_eq!(probability(&verdict), (0.6, Critical));
        verdict.critical = Some(vec![CriticalObstacle::new(7)]);
        verdict.token_probability = Some(0.95);
        assert_eq!(probability(&verdict), (0.95, ProbabilitySource::Token));
        verdict.token_probability = None;
        assert_eq!(probability(&verdict), (0.8, Score));
        verdict.obstacles[1].written_score = Some(3);
        let (graded, source) = probability(&verdict);
        assert!((graded - 0.4).abs() < 1e-12 && source == Score, "{graded}");
        verdict.obstacles.clear();
        assert_eq!(probability(&verdict), (1.0, Decision));
        verdict.dangerous = false;
        assert_eq!(probability(&verdict), (0.0, Decision));
    }

    fn token(text: &str, probability: f64, others: &[(&str, f64)]) -> Token {
        let log = |(text, p): &(&str, f64)| ((*text).to_string(), p.ln());
        Token {
            text: text.into(),
            log_probability: f64::ln(probability),
            alternatives: others.iter().map(log).collect(),
        }
    }

    fn near(found: Option<f64>, wanted: f64) {
        assert!(
            found.is_some_and(|p| (p - wanted).abs() < 1e-12),
            "{found:?}"
        );
    }

    #[test]
    fn the_share_of_yes_at_the_decision_counts() {
        let plain = |text: &str| token(text, 1.0, &[]);
        let others = [("true", 0.6), ("false", 0.2), ("null", 0.1), ("True", 0.1)];
        let tokens = [
            plain("{\"justification\": \"`safety_critical\": no idea\", \""),
            plain("safety"),
            plain("_critical"),
            plain("\": "),
            token("true", 0.6, &others),
            plain("}"),
        ];
        near(token_probability(&tokens, Task::Safety, true), 0.7 / 0.9);
        // The verdict is read as something else than what stands there.
        assert_eq!(token_probability(&tokens, Task::Collision, true), None);
    }

    #[test]
    fn tokens_may_hold_what_stands_before_the_value_or_half_of_it() {
        let tokens = [
            token("{\"collision\"", 1.0, &[]),
            token(":fal", 0.75, &[(":fal", 0.75), (":tr", 0.25), (" \"", 0.0)]),
            token("se}", 1.0, &[]),
        ];
        near(token_probability(&tokens, Task::Collision, false), 0.25);
        assert_eq!(
            token_probability(&tokens[..1], Task::Collision, false),
            None
        );
        assert_eq!(token_probability(&[], Task::Collision, false), None);
        let alone = [
            token("\"collision\": ", 1.0, &[]),
            token("\"yes\"", 0.5, &[]),
        ];
        near(token_probability(&alone, Task::Collision, true), 1.0);
    }

    #[test]
    fn a_verdict_that_is_read_anew_keeps_it_while_it_says_the_same() {
        let text = r#"{"task":"safety","safety_critical":true,"obstacles":[],"justification":"","token_probability":0.8}"#;
        let stored: Verdict = serde_json::from_str(text).unwrap();
        let read = Verdict {
            token_probability: None,
            unknown: Vec::new(),
            ..stored.clone()
        };
        assert_eq!(with_token_probability(read.clone(), Some(text)), stored);
        assert_eq!(with_token_probability(read.clone(), None), read);
        let other = Verdict {
            dangerous: false,
            ..read
        };
        assert_eq!(with_token_probability(other.clone(), Some(text)), other);
    }
}
