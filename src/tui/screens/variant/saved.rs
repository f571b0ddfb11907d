//! A saved variant: what the manifest beside it says.

use ratatui::style::{Modifier, Style};
use ratatui::text::Text;

use super::{change, good_driver_words, hundredths};
use crate::loaded::SavedVariant;
use crate::model::Model;
use crate::widgets::lines::Lines;
use nearmiss_drive::generation::{AttackerRecord, OutcomeName};
use nearmiss_scene::description::visible;

/// Attack, outcome and certificates as they were written.
pub fn text(model: &Model, saved: &SavedVariant, width: usize) -> Text<'static> {
    let mut lines = Lines::new(&model.theme, width);
    let manifest = &saved.origin.manifest;
    lines.title("outcome, from the manifest beside the variant");
    let (color, mark) = match manifest.outcome {
        OutcomeName::Collision => (model.theme.danger, "X "),
        OutcomeName::NoEffect => (model.theme.safe, ""),
        _ => (model.theme.warning, "! "),
    };
    let style = Style::new().fg(color).add_modifier(Modifier::BOLD);
    let outcome = format!("{mark}{}", spoken(manifest.outcome.name()));
    lines.say_in("outcome", &outcome, style);
    if let Some(contact) = &manifest.collision {
        let (with, step) = (contact.with, contact.step);
        let (ego, other) = (visible(&contact.ego_side), visible(&contact.other_side));
        let words = format!("{with} at step {step}: the ego's {ego}, the other's {other}");
        lines.say("contact", &words);
    }
    let ends = spoken(&manifest.drive.ended_with);
    lines.say("ego", &format!("its drive ends: {ends}"));
    lines.say("without it", &spoken(&manifest.baseline.ended_with));
    certificates(&mut lines, model, saved);
    lines.title("the attack");
    for attacker in &manifest.attackers {
        lines.say(&attacker.id.to_string(), &attacker_words(attacker));
    }
    lines.say("source", &visible(&manifest.by));
    lines.say("others", "as recorded; only the ego reacts");
    let refused = manifest.rejected.len();
    lines.say("refused", &format!("{refused} motions before it"));
    lines.say("made by", &visible(&manifest.program));
    lines.plain("");
    lines.plain(&model.saved_variant(saved));
    lines.text
}

fn certificates(lines: &mut Lines, model: &Model, saved: &SavedVariant) {
    let Some(all) = &saved.origin.manifest.avoidable else {
        return;
    };
    lines.title("avoidable by a good driver, by reaction time");
    let mut latest = None;
    for (delay, record) in all {
        let name = format!("{} s", visible(delay));
        if let Some(evasion) = record.evasion.as_ref().filter(|_| record.avoided) {
            lines.say(&name, &format!("yes: {}", visible(&evasion.found_by)));
            latest = Some(evasion);
        } else {
            let why = record.why.as_deref().unwrap_or_default();
            let style = Style::new().fg(model.theme.warning);
            lines.say_in(&name, &format!("no: {}", visible(why)), style);
        }
    }
    if let Some(driver) = latest {
        let broken = driver.rules_broken.join(", ");
        let (used, left) = (driver.max_acceleration, driver.leaves_roadway_step);
        for (name, words) in good_driver_words(used, &visible(&broken), left) {
            lines.say(name, &words);
        }
    }
}

fn attacker_words(attacker: &AttackerRecord) -> String {
    let risk = change(attacker.min_risk_before, attacker.min_risk_after);
    let mut words = format!("{}, risk {risk}", visible(&attacker.manoeuvre));
    if let Some(distance) = attacker.min_distance {
        words.push_str(&format!(", {} m at least", hundredths(distance)));
    }
    if let Some(without) = &attacker.outcome_without {
        words.push_str(&format!("; without it {}", spoken(without)));
    }
    words
}

/// A name of a document as words.
fn spoken(name: &str) -> String {
    visible(name).replace('_', " ")
}
