//! Explains every number of a report: beneath the tables of papers, at the end of all other reports.

use super::super::Cluster;
use super::super::statistics::{DRAWS, EXACT_BELOW, EXACT_UP_TO, FEWEST, RESAMPLES, SEED};

/// Everything, in the order of the tables.
pub(super) fn all(unit: Cluster) -> impl Iterator<Item = String> {
    let last = [claims(unit), samples(), consumption()].join(" ");
    let all = [
        counts(),
        intervals(unit),
        pairs(unit),
        naming(),
        calibration(),
        last,
    ];
    all.into_iter()
}

pub(super) fn counts() -> String {
    "n is every question, answered or not: TP, FP, FN and TN are verdicts beside the truth; unparsed answers hold no \
     verdict, failed questions were asked and have no whole answer (an answer that was cut off or filtered is none, \
     whatever it says), others were not asked, or not yet. Right of all: the share of the questions asked, with a truth, \
     whose verdict is right; a question without a verdict is not. Precision, recall, specificity, accuracy and F1 are of \
     the verdicts alone. Yes and no are counted as said, whichever obstacle is named."
        .into()
}

pub(super) fn intervals(unit: Cluster) -> String {
    let with = match unit {
        Cluster::Scenario => "windows and samples",
        Cluster::Map => "scenarios, windows and samples",
    };
    format!(
        "Intervals are of 95 %, with the {unit} as the unit: the percentile bootstrap over {unit}s with all their \
         {with} ({RESAMPLES} resamples, seed {SEED}; Efron 1979, Davison and Hinkley 1997), as answers about \
         one {unit} are not independent; so are those of named obstacles, leads and transformed scenes. Shares of \
         answers of which each {unit} has one have Wilson's interval; so have shares of 0 and 1, where the bootstrap \
         cannot vary, with the {unit}s as observations. F1 has no interval where no draw differs. Below {FEWEST} \
         {unit}s no interval is given."
    )
}

pub(super) fn pairs(unit: Cluster) -> String {
    format!(
        "Difference: the mean over {unit}s of the first's share of questions that are right of those asked minus the \
         second's, where no verdict is not right, with its bootstrap interval. p is that of the paired permutation test by {unit} (Fisher 1935): the share of \
         assignments of signs to the {unit}s' differences whose sum is as far from 0, all of them for up to \
         {EXACT_UP_TO} {unit}s that differ, else {DRAWS} random ones (seed {SEED}). p (Holm) is corrected for the \
         comparisons of the same family and task (Holm 1979): a single declared comparison (--compare) is not corrected, \
         those with the baseline (--baseline) are together, and without a baseline all pairs that differ in frame, \
         techniques, model or template alone. Detectable: the difference that would be found with a power of 80 % at a \
         level of 5 %, (1.96 + 0.84)·√(mean d²/n) of n {unit}s' differences d (Connor 1987, Miller 2024); a smaller true \
         difference is likely missed. Ties: {unit}s on which the questions of one are as often right as wrong; they count \
         by half. JSON and CSV have McNemar's test of majorities, which leaves ties out (exact below {EXACT_BELOW} \
         discordant {unit}s)."
    )
}

pub(super) fn naming() -> String {
    "Windows are the dangerous ones, with a verdict, whose critical obstacles are known. Obstacle named: the share of \
     them of which the answer names one (recall of naming); named worst: no obstacle has a graver risk score. Names are the \
     obstacles named over these and the safe windows; names right: the share that is truly critical (precision of \
     naming), so a yes on a safe window names only bystanders. An answer names the critical_obstacles of a yes; one without \
     that list, those of risk score 0 or 1, or of 2 if that is the gravest of a yes. κ is Cohen's, of yes and no beside \
     the built-in judge."
        .into()
}

pub(super) fn calibration() -> String {
    "Every verdict beside a truth has a probability of yes: the one that the answer states; else the largest of its \
     critical_obstacles; else that of its log probabilities; else 1 − s/5 with its gravest risk score s as written; \
     else 1 for yes and 0 for no. The columns say how many are from each. Brier is the mean square of what they miss; AUROC the probability that a yes in truth has a \
     higher one than a no, ties counted half; ECE has ten bins of the same width."
        .into()
}

pub(super) fn token_calibration() -> String {
    "Log probabilities: of the tokens with which an answer decides, e^l of those that begin a yes over that of those that \
     begin a yes or a no, among the alternatives that the server lists; of the verdicts for which it gives them."
        .into()
}

pub(super) fn samples() -> String {
    "Samples: unanimous is the share of questions on which all samples agree, agreement the share of pairs of samples \
     that do (Fleiss 1971). All right: the chance that all k samples of a question are right, pass^k, with k the number \
     of samples; C(r, k)/C(n, k) of r right among n answers (Chen et al. 2021, Yao et al. 2024), over questions with k \
     answers; one without a verdict is wrong. Ties have yes and no equally often; undecided are these and questions without any verdict; coverage is the share of questions \
     with a majority, and the majority's counts and F1 are of these alone."
        .into()
}

pub(super) fn claims(unit: Cluster) -> String {
    format!(
        "Claims are sentences of whole answers that give one obstacle a distance, time, velocity, acceleration, place or \
         contact; found and checked against the geometry as `nearmiss help answers` says. Open: it depends on what is meant. \
         Wrong share: the wrong ones of those that are right or wrong, with the bootstrap over {unit}s. Not checked: the \
         scenario of the answer was not at hand."
    )
}

pub(super) fn consumption() -> String {
    "Tokens and dollars are of every attempt at a question: answers that were cut off or filtered, and superseded \
     attempts, in whose place another one counts; deleted runs are left out. Times are of the answers that count. \
     Unknown costs and times are counted, never taken as 0; at most: what attempts of unknown cost can have cost, where \
     a price and a limit bound it. The built-in judge and questions that were not sent cost nothing."
        .into()
}
