//! Traffic lights with what they show at the cursor, and signs with what they mean where there is room.

use ratatui::style::{Color, Modifier, Style};

use super::CellView;
use super::label_placer::{Body, LabelPlacer};
use crate::model::Model;
use nearmiss_render::scene::MapScene;
use nearmiss_scene::description::visible;
use nearmiss_scene::scenario::{Sign, SignMeaning, SignalColor};

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

impl Placed {
    /// What is on one of two maps.
    pub fn and(self, other: Self) -> Self {
        Self {
            lights: self.lights || other.lights,
            posts: self.posts || other.posts,
        }
    }
}

/// Says whether there are lights.
pub fn lights(
    board: &mut LabelPlacer<'_>,
    model: &Model,
    scene: &MapScene<'_>,
    view: &CellView,
) -> bool {
    if !model.map.layers.lights || view.cell.0 > SEEN {
        return false;
    }
    let mut any = false;
    for light in &scene.lights {
        let (letter, color) = shown(model, light.color);
        let style = Style::new()
            .fg(color)
            .add_modifier(Modifier::BOLD | Modifier::REVERSED);
        // One of several at the same place is enough.
        any |= board.put_if_free(view.at(&light.at), letter, style);
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
    scene: &MapScene<'_>,
    view: &CellView,
) -> bool {
    if !model.map.layers.signs || view.cell.0 > SEEN {
        return false;
    }
    let style = Style::new().fg(model.theme.dim);
    let mut posts = false;
    for post in &scene.signs {
        let at = view.at(&post.at);
        let words = words(post.sign).filter(|_| view.cell.0 <= READ);
        let read = words.is_some_and(|words| {
            let body = Body::around([at]).map(|body| board.cells(&body));
            board.put_if_free(at, &words, style)
                || body.is_some_and(|cells| board.beside(&cells, &words, style))
        });
        posts |= !read && board.put_if_free(at, POST, style);
    }
    posts
}

/// What a post says; `None` if none of its numbers is known.
fn words(sign: &Sign) -> Option<String> {
    let speed = |speed: f64| {
        let (value, unit) = sign.speed_shown(speed);
        format!("{value:.0} {unit}")
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
    use nearmiss_scene::scenario::SignElement;

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
