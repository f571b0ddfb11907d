//! Names of risk scores beside a word such as risk: `high risk or worse`, `worse than medium risk`.

use super::items::{Item, What};
use super::lexicon::{Meaning, Unit};
use super::reading::Part;

/// `high severity` means a high risk: the numbers of severities have other names.
const SEVERITY: Meaning = Meaning::Measure("severity", Unit::None);

/// Reads levels that begin at the first item: how many items they are, and their terms. Nothing if none begin there.
pub fn read(items: &[Item]) -> Option<(usize, Option<Vec<Part>>)> {
    let what = |at: usize| items.get(at).map(|item| &item.what);
    let level = |at: usize| match what(at) {
        Some(What::Means(Meaning::Level(score))) => Some(*score),
        _ => None,
    };
    let means = |at: usize, meaning: Meaning| what(at) == Some(&What::Means(meaning));
    let names = |at: usize| means(at, Meaning::Risk) || means(at, SEVERITY);
    let mut at = 0;
    let mut named = names(at);
    at += usize::from(named);
    let sign = match what(at) {
        Some(What::Means(Meaning::Worse)) => Some("<"),
        // More risk is a lower score.
        Some(What::Means(Meaning::Compare(">=", _))) => Some("<="),
        Some(What::Means(Meaning::Compare(">", _))) => Some("<"),
        Some(What::Means(Meaning::Compare("<=", _))) => Some(">="),
        Some(What::Means(Meaning::Compare("<", _))) => Some(">"),
        _ => None,
    };
    at += usize::from(sign.is_some());
    let mut scores = vec![level(at)?];
    at += 1;
    let joins = |at: usize| means(at, Meaning::And) || means(at, Meaning::Or);
    while let (true, Some(score)) = (joins(at), level(at + 1)) {
        scores.push(score);
        at += 2;
    }
    if names(at) {
        named = true;
        at += 1;
    }
    let worse = means(at, Meaning::OrWorse) || means(at, Meaning::OrMore);
    let better = means(at, Meaning::OrLess);
    at += usize::from(worse || better);
    // `high speed` says nothing of risk; `extreme` can be nothing else.
    if !named && sign.is_none() && scores != [1] {
        return None;
    }
    let sign = match (sign, worse, better) {
        (None, true, _) => Some("<="),
        (None, _, true) => Some(">="),
        (sign, ..) => sign,
    };
    let parts = match (sign, &scores[..]) {
        (Some(sign), [score]) => Some(vec![Part::Whole(format!("risk{sign}{score}"))]),
        (Some(_), _) => None,
        (None, [score]) => Some(vec![Part::Whole(format!("risk={score}"))]),
        (None, scores) => {
            // Terms hold together: only scores that follow each other are a range.
            let (least, most) = (scores.iter().min()?, scores.iter().max()?);
            let all = (*least..=*most).all(|score| scores.contains(&score));
            let range = [format!("risk>={least}"), format!("risk<={most}")];
            all.then(|| range.map(Part::Whole).to_vec())
        }
    };
    Some((at, parts))
}
