//! Feedback to a model on a refused answer, and on a motion that the ego was driven against.

use nearmiss_drive::generation::{Refusal, summarize};
use nearmiss_scene::scenario::Motion;

/// Most kinds of reasons that are told.
const MOST: usize = 12;

/// Most characters of an answer that are sent back with the reasons: who rambled is not to pay for it twice.
pub(super) const ANSWER: usize = 8000;

/// The reasons, and the renewed request. `start` is the recorded state of the obstacle at a step.
pub(super) fn refused(attacker: i64, refusals: &[Refusal], start: Option<(i64, Motion)>) -> String {
    let mut words = String::from("This motion cannot be used:\n");
    let all = summarize(refusals);
    for one in all.iter().take(MOST) {
        words.push_str(&format!("- {one}\n"));
    }
    if all.len() > MOST {
        words.push_str(&format!("- and {} more reasons\n", all.len() - MOST));
    }
    words.push_str(&again(attacker, "to which none of this applies", start));
    words
}

/// What came of the drive, and the renewed request.
pub(super) fn not_wanted(attacker: i64, drive: &str, start: Option<(i64, Motion)>) -> String {
    let again = again(
        attacker,
        "that is better and still keeps every limit",
        start,
    );
    format!("{drive}{again}")
}

fn again(attacker: i64, motion: &str, start: Option<(i64, Motion)>) -> String {
    let mut words = format!(
        "\nGive the whole answer again for obstacle {attacker}, in the same form, with a motion {motion}."
    );
    if let Some((step, motion)) = start {
        let at = motion.pose.position;
        words.push_str(&format!(
            " At step {step} the obstacle is recorded at ({:.2}, {:.2}) m with heading {:.3} rad and velocity {:.2} m/s.",
            at.x, at.y, motion.pose.heading, motion.velocity
        ));
    }
    words
}

/// The answer as it is sent back.
pub(super) fn shortened(answer: &str) -> String {
    match answer.char_indices().nth(ANSWER) {
        Some((end, _)) => format!("{} …", &answer[..end]),
        None => answer.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_drive::generation::Reason;

    #[test]
    fn the_gate_is_quoted_and_ramblings_are_cut() {
        let refusal = Refusal::at(7, Reason::Jump).with(10.7, 2.5);
        let words = refused(12, &[refusal], None);
        assert!(words.contains("- step 7: jump 10.7000 m, at most 2.5000\n"));
        assert!(words.contains("for obstacle 12,"));
        let long = "ä".repeat(ANSWER + 1);
        assert_eq!(shortened(&long).chars().count(), ANSWER + 2);
        assert_eq!(shortened("no"), "no");
    }
}
