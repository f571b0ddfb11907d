//! Traffic lights with what they show at the cursor, and signs with what they mean where there is room.

use ratatui::style::{Color, Modifier, Style};

use super::Projection;
use super::label_placer::{Body, LabelPlacer};
use crate::description::visible;
use crate::geometry::Point;
use crate::scenario::{Sign, SignMeaning, SignalColor};
use crate::tui::loaded::Opened;
use crate::tui::model::Model;

/// Where a cell is at most this wide, lights and signs are seen, metres.
const SEEN: f64 = 1.6;

/// Where a cell is at most this wide, signs are read, metres.
const READ: f64 = 0.9;

/// A sign that cannot be read, or whose number is not known.
const POST: &str = "▫";

/// More letters than this of a sign's number are no number.
const LONGEST: usize = 8;

/// Kinds of symbols placed on the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Placed {
    /// Whether there are lights.
    pub lights: bool,
    /// Whether there are signs that are not read out.
    pub posts: bool,
}

pub fn lights(
    board: &mut LabelPlacer<'_>,
    model: &Model,
    opened: &Opened,
    view: &Projection,
    step: i64,
) -> bool {
    if !model.map.layers.lights || view.cell.0 > SEEN {
        return false;
    }
    let network = &opened.scenario.network;
    let mut any = false;
    for light in &network.lights {
        let Some(position) = network.position_of(light) else {
            continue;
        };
        if !view.sees_point(&position) {
            continue;
        }
        let (letter, color) = shown(model, light.color_at(step));
        let style = Style::new()
            .fg(color)
            .add_modifier(Modifier::BOLD | Modifier::REVERSED);
        // One of several at the same place is enough.
        any |= board.put_if_free(view.at(&position), letter, style);
    }
    any
}

/// A letter and a colour; the letter says it without the colour.
fn shown(model: &Model, color: SignalColor) -> (&'static str, Color) {
    let theme = &model.theme;
    match color {
        SignalColor::Red => ("R", theme.danger),
        SignalColor::RedYellow => ("RA", theme.warning),
        SignalColor::Yellow => ("A", theme.warning),
        SignalColor::Green => ("G", theme.safe),
        SignalColor::Inactive => ("-", theme.dim),
    }
}

/// Says whether there are signs that are not read out.
pub fn signs(
    board: &mut LabelPlacer<'_>,
    model: &Model,
    opened: &Opened,
    view: &Projection,
) -> bool {
    if !model.map.layers.signs || view.cell.0 > SEEN {
        return false;
    }
    let style = Style::new().fg(model.theme.dim);
    let mut posts = false;
    for (sign, position) in signs_seen(opened, view) {
        let at = view.at(&position);
        let words = words(sign).filter(|_| view.cell.0 <= READ);
        let read = words.is_some_and(|words| {
            let body = Body::around([at]).map(|body| board.cells(&body));
            board.put_if_free(at, &words, style)
                || body.is_some_and(|cells| board.beside(&cells, &words, style))
        });
        posts |= !read && board.put_if_free(at, POST, style);
    }
    posts
}

fn signs_seen<'a>(
    opened: &'a Opened,
    view: &'a Projection,
) -> impl Iterator<Item = (&'a Sign, Point)> {
    let signs = opened.scenario.network.signs.iter();
    signs.filter_map(|sign| {
        let position = sign.position?;
        view.sees_point(&position).then_some((sign, position))
    })
}

/// What a post says; `None` if none of its numbers is known.
fn words(sign: &Sign) -> Option<String> {
    let speed = |metres: f64| {
        if sign.in_miles() {
            format!("{:.0} mph", metres * 2.236_936)
        } else {
            format!("{:.0} km/h", metres * 3.6)
        }
    };
    let all = sign.elements.iter().map(|element| match element.meaning() {
        Some(SignMeaning::SpeedLimit(limit)) => speed(limit),
        Some(SignMeaning::LeastSpeed(least)) => format!("at least {}", speed(least)),
        Some(SignMeaning::Words(words)) => words.into(),
        None => {
            let number = visible(&element.id);
            format!("sign {}", number.chars().take(LONGEST).collect::<String>())
        }
    });
    let all: Vec<String> = all.collect();
    (!all.is_empty()).then(|| all.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::SignElement;

    fn sign(elements: &[(&str, &str)]) -> Sign {
        let element = |(id, value): &(&str, &str)| SignElement {
            id: (*id).into(),
            values: vec![(*value).into()],
        };
        Sign {
            id: 1,
            elements: elements.iter().map(element).collect(),
            position: None,
            is_virtual: false,
        }
    }

    #[test]
    fn posts_are_read_in_the_units_of_their_country() {
        let read = |elements: &[(&str, &str)]| words(&sign(elements));
        assert_eq!(
            read(&[("274", "22.2222"), ("276", "")]).as_deref(),
            Some("80 km/h, no overtaking")
        );
        assert_eq!(read(&[("R2-1", "15.6464")]).as_deref(), Some("35 mph"));
        assert_eq!(read(&[("\u{1b}[2J9", "")]).as_deref(), Some("sign ␛[2J9"));
        assert_eq!(read(&[]), None);
    }
}
