//! Explains every number of a report: beneath the tables of papers, at the end of all other reports.

use super::super::statistics::{EXACT_BELOW, FEWEST, RESAMPLES, SEED};

/// Everything, in the order of the tables.
pub(super) fn all() -> impl Iterator<Item = String> {
    let last = [agreement(), samples(), consumption()].join(" ");
    [counts(), intervals(), pairs(), last].into_iter()
}

pub(super) fn counts() -> String {
    "n is every question, answered or not: TP, FP, FN and TN are verdicts beside the truth; unparsed answers hold no \
     verdict, failed questions were asked and have no whole answer, others were not asked, or not yet, and none of these \
     is counted as right or wrong. A yes to the safety task about a scenario whose truth names an obstacle has to name \
     that obstacle as the danger (risk score 0 or 1, or 2 if that is the gravest of a yes); else it is a no. So many of FN say yes and name another obstacle, or none: \
     wrong obstacle."
        .into()
}

pub(super) fn intervals() -> String {
    format!(
        "Intervals are of 95 %: Wilson's for proportions, and for F1 the percentile bootstrap over scenarios with all \
         their samples ({RESAMPLES} resamples, seed {SEED}). Wilson's take answers as independent, and are too narrow \
         where a scenario was asked about several times. The bootstrap cannot vary where no answer is right, or every \
         one: an interval of F1 without width says nothing. Below {FEWEST} observations no interval is given."
    )
}

pub(super) fn pairs() -> String {
    format!(
        "Pairs differ in frame, techniques or model alone and are compared by McNemar's test on scenarios, by the \
         majority of samples: exact below {EXACT_BELOW} scenarios that one alone is right about, else chi-square with \
         continuity correction. p (Holm) is corrected for all pairs of a task."
    )
}

pub(super) fn agreement() -> String {
    "Named: the true obstacle is named as the danger (risk score 0 or 1, or 2 if that is the gravest of a yes); named worst: no obstacle has a graver score. κ is Cohen's, of \
     yes and no beside the built-in judge. Calibration takes the gravest risk score s of an answer as the \
     probability 1 − s/5 of a collision; ECE has a bin for each score."
        .into()
}

pub(super) fn samples() -> String {
    "A tie of samples is no vote.".into()
}

pub(super) fn consumption() -> String {
    "Unknown costs and times are counted, never taken as 0. The built-in judge and questions that were not sent cost \
     nothing; questions that were not asked are not in that table.".into()
}
