//! The legend on the map's lower border: only symbols in view, as many as fit.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use unicode_width::UnicodeWidthStr;

use super::signs::Placed;
use crate::model::{Foreseen, Foresight, Model, Trails};
use nearmiss_render::cells::MapStyle;
use nearmiss_render::scene::{LineStyle, Role};

/// Between two entries.
const SEPARATOR: &str = " │ ";

/// An entry: the sign as the map draws it, its colour, and what it means.
struct Entry {
    sign: &'static str,
    color: Color,
    words: String,
}

impl Entry {
    fn width(&self) -> usize {
        let blank = usize::from(!self.sign.is_empty());
        self.sign.width() + blank + self.words.width()
    }
}

/// Draws as many entries as fit into the free part of the border.
pub fn draw(f: &mut Frame<'_>, free: Rect, model: &Model, shown: Placed) {
    let room = usize::from(free.width.saturating_sub(2));
    let entries = fitting(entries(model, shown), room);
    if entries.is_empty() || free.height == 0 {
        return;
    }
    let dim = Style::new().fg(model.theme.dim);
    let mut line = Line::from(" ");
    for (i, entry) in entries.into_iter().enumerate() {
        if i > 0 {
            line.push_span(Span::styled(SEPARATOR, dim));
        }
        if !entry.sign.is_empty() {
            let sign = format!("{} ", entry.sign);
            line.push_span(Span::styled(sign, Style::new().fg(entry.color)));
        }
        line.push_span(Span::styled(entry.words, dim));
    }
    line.push_span(Span::raw(" "));
    let width = u16::try_from(line.width())
        .unwrap_or(u16::MAX)
        .min(free.width);
    f.render_widget(line, Rect { width, ..free });
}

/// The sign of a line, as it is drawn from left to right.
fn sign(model: &Model, style: LineStyle) -> &'static str {
    match (super::look(model).style, style) {
        (MapStyle::Ascii, LineStyle::Solid) => "''",
        (MapStyle::Ascii, LineStyle::Thick) => "::",
        (MapStyle::Ascii, LineStyle::Dashed) => "'' ''",
        (MapStyle::Ascii, LineStyle::Dotted) => "' '",
        (MapStyle::Ascii, LineStyle::Crossed) => ": :",
        (MapStyle::Cells(_), LineStyle::Thick) => "▄▄",
        (_, LineStyle::Solid) => "⠒⠒",
        (_, LineStyle::Thick) => "⠶⠶",
        (_, LineStyle::Dashed) => "⠒⠂⠐⠒",
        (_, LineStyle::Dotted) => "⠂ ⠂",
        (_, LineStyle::Crossed) => "⠕⠅",
    }
}

fn entries(model: &Model, shown: Placed) -> Vec<Entry> {
    let look = super::look(model);
    let line = |style, role, words: &str| Entry {
        sign: sign(model, style),
        color: look.color(role),
        words: words.into(),
    };
    let plain = |words: &str| Entry {
        sign: "",
        color: model.theme.dim,
        words: words.into(),
    };
    let mut entries = Vec::new();
    let horizon = Foresight::HORIZON;
    let predicted = |role, whose: &str| {
        let words = format!("predicted {horizon:.0} s{whose}");
        let straight = Role::ConstantVelocity;
        [
            line(LineStyle::Dashed, role, &words),
            line(LineStyle::Crossed, straight, "constant velocity"),
        ]
    };
    if let Some(variant) = model.variant().filter(|_| model.map.layers.variant) {
        let all = &variant.made.effect.attackers;
        for (place, attacker) in all.iter().enumerate() {
            let words = match all.len() {
                1 => "attack".into(),
                _ => format!("attack {}", attacker.obstacle),
            };
            entries.push(line(LineStyle::Thick, Role::Attacker(place), &words));
        }
        entries.push(line(LineStyle::Dashed, Role::Recorded, "recorded instead"));
    }
    if let Some(planned) = model.planned().filter(|_| model.map.layers.planner) {
        entries.push(line(LineStyle::Thick, Role::Ego, "chosen, 1 2 3 s ahead"));
        entries.push(line(LineStyle::Solid, Role::Feasible, "drivable"));
        if model.map.layers.rejected {
            entries.push(line(LineStyle::Dotted, Role::Rejected, "rejected"));
        }
        let outlined = line(LineStyle::Solid, Role::PredictedBody, "predicted bodies");
        entries.push(outlined);
        if planned.recorded.is_some() {
            entries.push(line(LineStyle::Dashed, Role::RecordedEgo, "recorded ego"));
        }
    }
    match model.map.layers.paths {
        Foreseen::Off => {}
        _ if model.scene().is_none() => entries.push(plain("no predictions without an ego")),
        Foreseen::Picked => {
            entries.extend(predicted(Role::Highlighted(0), ", picked: % how likely"));
        }
        Foreseen::Near => entries.extend(predicted(Role::Prediction, ", near the ego")),
    }
    if model.map.tape.is_some() {
        entries.push(plain("+ # tape: # moves"));
    }
    if shown.lights {
        entries.push(plain("R A G lights"));
    }
    if shown.posts {
        entries.push(plain("▫ sign"));
    }
    if model.map.layers.trails != Trails::Off {
        let color = match model.scene() {
            Some(_) => model.theme.ego_trail,
            None => model.theme.trail,
        };
        for (style, words) in [
            (LineStyle::Thick, "past"),
            (LineStyle::Dotted, "recorded future"),
        ] {
            entries.push(Entry {
                color,
                ..line(style, Role::Ego, words)
            });
        }
    }
    entries
}

/// The entries that are whole within so many columns, the first ones first.
fn fitting(entries: Vec<Entry>, room: usize) -> Vec<Entry> {
    let mut width = 0;
    let mut kept = Vec::new();
    for entry in entries {
        let separator = if kept.is_empty() {
            0
        } else {
            SEPARATOR.width()
        };
        if width + separator + entry.width() <= room {
            width += separator + entry.width();
            kept.push(entry);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_left_out_whole() {
        let entry = |words: &str| Entry {
            sign: "",
            color: Color::Reset,
            words: words.into(),
        };
        let kept = |room| -> Vec<String> {
            let entries = ["one", "a long one", "two"].map(entry).into();
            fitting(entries, room)
                .into_iter()
                .map(|e| e.words)
                .collect()
        };
        assert_eq!(kept(40), ["one", "a long one", "two"]);
        assert_eq!(kept(12), ["one", "two"]);
        assert!(kept(2).is_empty());
    }
}
