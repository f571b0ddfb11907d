//! What is to be noted of a model's work on one scenario, beside its JSON line.

use nearmiss_study::evaluation::generating::{Authored, ChosenBy};

/// Notes on a model's work beside the table.
pub fn authoring_notes(authored: &Authored) -> Vec<String> {
    let proposal = authored.choice.proposal.as_ref();
    let instead = match authored.choice.by {
        ChosenBy::NoAttacker => "nothing is generated (obey=on)",
        _ => "the first of the reference ranking attacks",
    };
    let choice = proposal
        .and_then(|p| p.refused.as_ref())
        .map(|why| format!("attacker rejected: {why}; {instead}"));
    let not_asked = { authored.choice.not_asked() }
        .map(|why| format!("{why}: the model is not asked who attacks; {instead}"));
    let choice = choice.or(not_asked);
    let tally = authored.choice.tally();
    let disagree = (tally.len() > 1).then(|| {
        let votes = tally.iter().map(|(id, votes)| format!("{id} ({votes})"));
        let votes: Vec<String> = votes.collect();
        let tie = if authored.choice.tied.is_empty() {
            ""
        } else {
            "; a tie, decided by the reference ranking"
        };
        format!("votes for the attacker: {}{tie}", votes.join(", "))
    });
    let void = authored
        .choice
        .votes
        .iter()
        .filter(|v| v.refused.is_some())
        .count();
    let void = (void > 0 && void < authored.choice.votes.len())
        .then(|| format!("{void} of {} votes rejected", authored.choice.votes.len()));
    let differ = authored.agreement().filter(|agreement| !agreement.agrees).map(|agreement| {
        format!(
            "best motion by the model's grades: answer {}, try {}; by the exact ranking: answer {}, try {}",
            agreement.model.sample + 1,
            agreement.model.retry + 1,
            agreement.exact.sample + 1,
            agreement.exact.retry + 1
        )
    });
    let refused = authored.declined.iter().map(|d| {
        let why = d.refusals.first().map(ToString::to_string);
        format!(
            "answer {}, try {}: {}: {}",
            d.source.sample + 1,
            d.source.retry + 1,
            if d.arrived { "rejected" } else { "failed" },
            why.unwrap_or_default()
        )
    });
    let stopped = authored.stopped.iter().map(|why| format!("stopped: {why}"));
    let about_choice = choice.into_iter().chain(disagree).chain(void);
    about_choice
        .chain(refused)
        .chain(differ)
        .chain(stopped)
        .collect()
}
