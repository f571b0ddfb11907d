//! A saved variant: what the manifest beside it says.

use ratatui::style::{Modifier, Style};
use ratatui::text::Text;

use crate::loaded::SavedVariant;
use crate::model::Model;
use crate::widgets::lines::Lines;

/// Attack, outcome and certificates as they were written.
pub fn text(model: &Model, saved: &SavedVariant, width: usize) -> Text<'static> {
    let mut lines = Lines::new(&model.theme, width);
    let record = &saved.origin.record;
    lines.title("outcome, from the manifest beside the variant");
    let (color, mark) = match record.outcome.as_str() {
        "collision" => (model.theme.danger, "X "),
        "no effect" => (model.theme.safe, ""),
        _ => (model.theme.warning, "! "),
    };
    let style = Style::new().fg(color).add_modifier(Modifier::BOLD);
    lines.say_in("outcome", &format!("{mark}{}", record.outcome), style);
    if let Some(contact) = &record.contact {
        lines.say("contact", contact);
    }
    let (with, without) = &record.ended;
    lines.say("ego", &format!("its drive ends: {with}"));
    lines.say("without it", without);
    if !record.reactions.is_empty() {
        lines.title("avoidable by a good driver, by reaction time");
    }
    for (delay, avoided, how) in &record.reactions {
        let name = format!("{delay} s");
        if *avoided {
            lines.say(&name, &format!("yes: {how}"))
        } else {
            let style = Style::new().fg(model.theme.warning);
            lines.say_in(&name, &format!("no: {how}"), style);
        }
    }
    for (name, words) in &record.good_driver {
        lines.say(name, words);
    }
    lines.title("the attack");
    for (id, words) in &record.attackers {
        lines.say(id, words);
    }
    lines.say("source", &record.by);
    lines.say("others", "as recorded; only the ego reacts");
    lines.say("refused", &format!("{} motions before it", record.refused));
    lines.say("made by", &record.program);
    lines.plain("");
    lines.plain(&model.saved_variant(saved));
    lines.text
}
