//! A file of thresholds: what it may say, and clear words for what it may not.

use serde::Deserialize;
use toml::Spanned;

use super::Thresholds;

/// Why a file of thresholds is not in use.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}: {message}", line.map(|l| format!(":{l}")).unwrap_or_default())]
pub struct ThresholdError {
    /// Which file.
    pub file: String,
    /// Line from 1.
    pub line: Option<usize>,
    /// What is wrong, with the key and what is allowed.
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
const LONGEST: usize = 80;

pub(super) fn read(
    shipped: &Thresholds,
    text: &str,
    file: &str,
) -> Result<Thresholds, ThresholdError> {
    let error = |(at, message): (usize, String)| ThresholdError {
        file: file.into(),
        line: Some(
            1 + text.as_bytes()[..at]
                .iter()
                .filter(|b| **b == b'\n')
                .count(),
        ),
        message,
    };
    let said: File = toml::from_str(text).map_err(|wrong| syntax(text, file, &wrong))?;
    let mut thresholds = shipped.clone();
    thresholds.file = Some(file.into());
    thresholds
        .take_thresholds(&said.threshold, file)
        .and_then(|()| thresholds.take_levels(&said.level))
        .and_then(|()| thresholds.take_limits(&said.limit))
        .map_err(error)?;
    Ok(thresholds)
}

/// A mistake of TOML's, or an unknown key, with the line that it is in: messages alone do not always name the key.
fn syntax(text: &str, file: &str, wrong: &toml::de::Error) -> ThresholdError {
    let message = wrong.message().trim().replace('\n', " ");
    let before = wrong.span().and_then(|span| text.get(..span.start));
    let line = before.map(|before| before.matches('\n').count());
    let shown = line.and_then(|line| text.lines().nth(line)).map(str::trim);
    let shown: Option<String> = shown.map(|line| line.chars().take(LONGEST).collect());
    ThresholdError {
        file: file.into(),
        line: line.map(|line| line + 1),
        message: match shown {
            Some(shown) if !shown.is_empty() => format!("{message}, in `{shown}`"),
            _ => message,
        },
    }
}
