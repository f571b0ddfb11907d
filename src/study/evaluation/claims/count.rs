//! Counts the claims of a whole answer, in the text that the workbench shows of it.

use super::{CheckedClaim, Judgement, Subject, checked};
use nearmiss_scene::description::visible;
use nearmiss_scene::verdict::{ReasonedAnswer, reasons_first};
use nearmiss_store::ClaimCounts;

/// The version of finding and checking claims: grows when the same text can give other counts, so that stored ones
/// are counted anew.
pub const CHECK: u32 = 2;

/// The separator between reasoning and answer.
const ANSWER: &str = "── answer ──";

/// The heading of the reasoning.
const REASONING: &str = "── reasoning ──";

/// An answer as it is read and checked: its reasoning, then its text, with the reasons that its JSON begins with before
/// that JSON unless it is shown `raw`. Safe to show on a terminal.
#[must_use]
pub fn shown_text(reasoning: &str, answer: &str, raw: bool) -> String {
    let readable = (!raw).then(|| readable(answer)).flatten();
    let answer = readable.as_deref().unwrap_or(answer);
    match (reasoning.is_empty(), answer.is_empty()) {
        (true, _) => visible(answer).into_owned(),
        // The heading is there from the start, so that nothing moves when the answer begins.
        (false, true) => visible(&format!("{REASONING}\n{reasoning}")).into_owned(),
        (false, false) => {
            let whole = format!("{REASONING}\n{reasoning}\n\n{ANSWER}\n{answer}");
            visible(&whole).into_owned()
        }
    }
}

/// An answer with the reasons that its JSON begins with before that JSON, as text.
fn readable(answer: &str) -> Option<String> {
    let ReasonedAnswer { reasons, rest } = reasons_first(answer)?;
    Some(if rest.is_empty() {
        reasons
    } else {
        format!("{reasons}\n\n{rest}")
    })
}

/// How many claims are right, wrong, and cannot be decided.
#[must_use]
pub fn counted(claims: &[CheckedClaim]) -> (usize, usize, usize) {
    let count = |is: fn(&Judgement) -> bool| claims.iter().filter(|c| is(&c.judgement)).count();
    (
        count(|j| *j == Judgement::Right),
        count(|j| *j == Judgement::Wrong),
        count(|j| matches!(j, Judgement::Unknown(_))),
    )
}

/// The claims of an answer, found, checked and counted.
#[must_use]
pub fn count(reasoning: &str, answer: &str, subject: &Subject<'_>) -> ClaimCounts {
    let (right, wrong, open) = counted(&checked(&shown_text(reasoning, answer, false), subject));
    let number = |n: usize| u32::try_from(n).ok();
    ClaimCounts {
        claims_right: number(right),
        claims_wrong: number(wrong),
        claims_open: number(open),
        claims_check: Some(CHECK),
    }
}
