//! Possible attackers, and what a model chose and wrote: the outcome, cost and reasons of each answer.

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Text};

use crate::loaded::{Authorship, GeneratedVariant};
use crate::model::{Model, consequence_words};
use crate::widgets::row::Lines;
use crate::widgets::words::{hundredths, pad, thousands};
use nearmiss_drive::generation::attacker::Candidate;
use nearmiss_drive::generation::{Attack, Refusal, summarize};
use nearmiss_scene::description::visible;
use nearmiss_scene::verdict::ObstacleRisk;
use nearmiss_study::evaluation::generating::{
    Agreement, AuthoredAttack, AuthoringUsage, Choice, ChosenBy, Ranking, Source,
};

/// Places of a ranking that are shown.
const PLACES: usize = 8;

/// Columns of the model's side of both rankings.
const SIDE: usize = 17;

/// Columns from which on there is room for both numbers and words in it.
const WIDE: usize = 46;

/// Kinds of reasons of one answer that are shown.
const KINDS: usize = 4;

/// A model's output without a dangerous result.
pub fn alone(model: &Model, wrote: &Authorship, width: usize) -> Text<'static> {
    let mut lines = Lines::new(&model.theme, width);
    lines.title("nothing dangerous found");
    lines.say("source", &visible(&wrote.model));
    written(&mut lines, model, wrote, wrote.authored.choice.attacker);
    reasons(&mut lines, wrote);
    lines.text
}

/// Possible attackers by the reference.
pub fn ranking(lines: &mut Lines, made: &GeneratedVariant) {
    let attackers: Vec<i64> = made.effect.ids().collect();
    lines.title("possible attackers, least change first");
    for (place, candidate) in made.ranked.iter().take(PLACES).enumerate() {
        let id = marked(candidate.obstacle, &attackers);
        let how = match (candidate.reaches, candidate.behind) {
            (false, _) => ", only in reverse",
            (true, true) => ", from behind",
            (true, false) => "",
        };
        let words = format!(
            "{:.2} m/s², at step {}{how}",
            candidate.acceleration, candidate.step
        );
        lines.say(&format!("{} {id}", place + 1), &words);
    }
    more(lines, made.ranked.len());
}

/// Possible attackers by the model and by the reference.
fn both(lines: &mut Lines, wrote: &Authorship, attacker: Option<i64>) {
    let choice = &wrote.authored.choice;
    let said = choice.proposal.as_ref().and_then(|p| p.choice.as_ref());
    let its: &[ObstacleRisk] = said.map_or(&[], |said| &said.obstacles);
    lines.title("possible attackers");
    let named = match its {
        [] => "",
        _ => "by the model",
    };
    lines.row(&format!("   {}{}", pad(named, SIDE), "by the reference"));
    let reference = &choice.ranked;
    for place in 0..its.len().max(reference.len()).min(PLACES) {
        let left = its.get(place).map_or(String::new(), |risk| {
            format!(
                "{} risk {}",
                marked(risk.id, attacker.as_slice()),
                risk.risk_score
            )
        });
        let wide = lines.width >= WIDE;
        let right = |c: &Candidate| {
            let id = marked(c.obstacle, attacker.as_slice());
            let why = match (c.reaches, c.behind) {
                (false, _) => "in reverse",
                (true, true) => "behind",
                (true, false) => return format!("{id} {:.2} m/s²", c.acceleration),
            };
            if wide {
                format!("{id} {:.2} m/s², {why}", c.acceleration)
            } else {
                // Why it comes after those that need more.
                format!("{id} {why}")
            }
        };
        let right = reference.get(place).map_or(String::new(), right);
        lines.row(&format!("{:>2} {}{right}", place + 1, pad(&left, SIDE)));
    }
    more(lines, its.len().max(reference.len()));
    if choice.votes.len() > 1 {
        lines.say("votes", &votes(choice));
    }
    let stopped = wrote.authored.stopped.as_ref().map(ToString::to_string);
    lines.say("chosen", &visible(&chosen(choice, stopped.as_deref())));
}

/// How many votes each obstacle got, and how a tie was decided.
fn votes(choice: &Choice) -> String {
    let counts = choice.tally().into_iter();
    let mut words: Vec<String> = counts.map(|(id, votes)| format!("{id} ×{votes}")).collect();
    let void = choice
        .votes
        .iter()
        .filter(|vote| vote.refused.is_some())
        .count();
    if void > 0 {
        words.push(format!("{void} rejected"));
    }
    let tie = if choice.tied.is_empty() {
        ""
    } else {
        "; a tie, decided by the reference"
    };
    format!("{}{tie}", words.join(", "))
}

/// An id, with a mark if that one attacks.
fn marked(id: i64, attackers: &[i64]) -> String {
    let mark = if attackers.contains(&id) { "▸" } else { " " };
    format!("{mark}{id}")
}

fn more(lines: &mut Lines, count: usize) {
    if count > PLACES {
        lines.row(&format!("   and {} more", count - PLACES));
    }
}

/// The attacker and who chose it; why the model was stopped stands elsewhere.
fn chosen(choice: &Choice, stopped: Option<&str>) -> String {
    let who = choice.attacker.map_or("none".into(), |id| id.to_string());
    let refused = choice.proposal.as_ref().and_then(|p| p.refused.as_ref());
    let why = refused.map_or(String::new(), |why| {
        let why = why.to_string();
        if stopped.is_some_and(|stopped| why.contains(stopped)) {
            "; the model did not answer".into()
        } else {
            format!("; the model's choice was rejected: {why}")
        }
    });
    let why = { choice.not_asked() }.map_or(why, |why| format!("; {why}"));
    match choice.by {
        ChosenBy::User => format!("{who}, by you"),
        ChosenBy::Model => format!("{who}, by the model"),
        ChosenBy::Reference => format!("{who}, by the reference{why}"),
        ChosenBy::NoAttacker => format!("{who}{why}"),
    }
}

/// Possible attackers, each answer with its outcome, and the total consumption.
pub fn written(lines: &mut Lines, model: &Model, wrote: &Authorship, attacker: Option<i64>) {
    both(lines, wrote, attacker);
    let (authored, theme) = (&wrote.authored, &model.theme);
    let passed = authored.attacks.len();
    let answers = match authored.candidates() {
        1 => "1 answer".into(),
        n => format!("{n} answers"),
    };
    lines.title(&format!("{answers}, {passed} passed the gate"));
    let mut all: Vec<(Source, String, Style)> = Vec::new();
    for attack in &authored.attacks {
        let mut words = match &attack.admitted.repair {
            Some(repair) => format!(
                "+ passed, repaired by {} m at step {}",
                hundredths(repair.moved),
                repair.step
            ),
            None => "+ passed as it is".into(),
        };
        words.push_str(&format!(": {}", effect(&attack.admitted.attack)));
        words.push_str(&graded(attack));
        if attack.feedback.is_some() {
            words.push_str("; sent back with what came of it");
        }
        let mut style = Style::new().fg(theme.safe);
        if wrote.taken == Some(attack.source) {
            words.push_str("; taken");
            style = style.add_modifier(Modifier::BOLD);
        }
        all.push((attack.source, words, style));
    }
    for declined in &authored.declined {
        let style = Style::new().fg(theme.warning);
        all.push((declined.source, refusals(&declined.refusals), style));
    }
    all.sort_by_key(|(source, ..)| (source.sample, source.retry));
    let mut before = String::new();
    for (source, words, style) in all {
        // What goes wrong is often the same every time.
        let again = words == before;
        let said = if again {
            format!("{} the same", words.get(..1).unwrap_or("x")).into()
        } else {
            visible(&words)
        };
        lines.say_in(&answer(source), &said, style);
        before = words;
    }
    if let Some(agreement) = authored.agreement() {
        lines.say("ranking", &rankings(&agreement, authored.rank));
    }
    if let Some(why) = &authored.stopped {
        let style = Style::new().fg(theme.danger);
        lines.say_in("stopped", &visible(why), style);
    }
    spent(lines, &authored.spent);
}

/// The model's own grade of a motion.
fn graded(one: &AuthoredAttack) -> String {
    match one.grade.as_ref().map(|grade| grade.score) {
        Some(Some(score)) => format!(", graded {score}"),
        Some(None) => ", not graded".into(),
        None => String::new(),
    }
}

/// Whether the model's grades and the exact ranking prefer the same motion, and which of them decided.
fn rankings(agreement: &Agreement, rank: Ranking) -> String {
    let decided = match rank {
        Ranking::Exact => "the exact ranking decides",
        Ranking::Model => "the model's grades decide",
    };
    if agreement.agrees {
        return format!("the model's grades prefer the same of {}", agreement.of);
    }
    format!(
        "the model's grades prefer {}, the exact ranking {}, of {}; {decided}",
        answer(agreement.model),
        answer(agreement.exact),
        agreement.of
    )
}

/// Which answer it was.
fn answer(source: Source) -> String {
    match source.retry {
        0 => format!("{}", source.sample + 1),
        n => format!("{} try {}", source.sample + 1, n + 1),
    }
}

fn effect(attack: &Attack) -> &'static str {
    match &attack.effect {
        Some(effect) if effect.is_hit_from_behind() => "hit from behind",
        Some(effect) => consequence_words(&effect.consequence),
        None => "not simulated",
    }
}

/// Reasons in a row, each with the worst step, its value and the limit.
fn refusals(all: &[Refusal]) -> String {
    let kinds = summarize(all);
    let mut words: Vec<String> = kinds.iter().take(KINDS).map(ToString::to_string).collect();
    if kinds.len() > KINDS {
        words.push(format!("{} more reasons", kinds.len() - KINDS));
    }
    format!("x rejected: {}", words.join("; "))
}

fn spent(lines: &mut Lines, spent: &AuthoringUsage) {
    let stored = match spent.stored {
        0 => String::new(),
        n => format!(", {n} from the store"),
    };
    lines.say(
        "asked",
        &format!(
            "{}, {} answered{stored}",
            match spent.requests {
                1 => "once".into(),
                n => format!("{n} times"),
            },
            spent.answers
        ),
    );
    let (sent, came) = (
        thousands(spent.input_tokens),
        thousands(spent.output_tokens),
    );
    lines.say("tokens", &format!("{sent} in, {came} out"));
    let mut cost = format!("${:.4}", spent.usd);
    if spent.usd_before > 0.0 {
        cost.push_str(&format!(", ${:.4} of it paid before", spent.usd_before));
    }
    if spent.unpriced > 0 {
        cost.push_str(&format!(", {} of unknown cost", spent.unpriced));
    }
    lines.say("cost", &cost);
}

/// Why this attacker and this motion, in the model's own words.
pub fn reasons(lines: &mut Lines, wrote: &Authorship) {
    if let Some(proposal) = &wrote.authored.choice.proposal {
        if let Some(said) = &proposal.choice {
            lines.title("why this attacker (the model)");
            lines.prose(&said.justification);
            for risk in said.obstacles.iter().take(PLACES) {
                lines.prose(&format!("{}: {}", risk.id, risk.reason));
            }
        }
        lines.reasoning("the model's reasoning: attacker", &proposal.reasoning);
    }
    let mut attacks = wrote.authored.attacks.iter();
    if let Some(taken) = attacks.find(|attack| Some(attack.source) == wrote.taken) {
        lines.title("why this motion (the model)");
        lines.prose(&taken.justification);
        lines.reasoning("the model's reasoning: motion", &taken.reasoning);
    }
}

impl Lines {
    /// A row of a table, cut at the border.
    fn row(&mut self, words: &str) {
        self.text.push_line(Line::raw(words.to_string()));
    }

    /// A model's words, which may hold anything.
    fn prose(&mut self, words: &str) {
        let shown = visible(words).replace('\t', " ");
        for line in shown.lines() {
            self.plain(line);
        }
    }

    fn reasoning(&mut self, title: &str, words: &str) {
        if !words.trim().is_empty() {
            self.title(title);
            self.prose(words);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_study::evaluation::generating::Proposal;

    #[test]
    fn why_a_model_was_stopped_is_said_once() {
        let proposal = |refused: &str| Proposal {
            run: None,
            window: (0, 9),
            choice: None,
            reasoning: String::new(),
            refused: Some(Refusal::answer(refused)),
        };
        let choice = |refused| Choice {
            ranked: Vec::new(),
            proposal: Some(proposal(refused)),
            votes: vec![proposal(refused)],
            tied: Vec::new(),
            within: None,
            none_within: None,
            attacker: Some(7),
            by: ChosenBy::Reference,
        };
        let stopped = Some("cannot reach lab");
        assert_eq!(
            chosen(&choice("no answer: cannot reach lab"), stopped),
            "7, by the reference; the model did not answer"
        );
        let refused = chosen(&choice("it chose 9, which stands"), stopped);
        assert!(
            refused.ends_with("was rejected: it chose 9, which stands"),
            "{refused}"
        );
    }
}
