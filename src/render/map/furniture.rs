//! What helps to read a map: a scale bar, the time, and north where that is not above.

use super::Map;
use crate::display::{Anchor, Area, Picture, Stroke, Text};

/// From the edge of the map, points.
const MARGIN: f64 = 4.0;

/// Draws it; gives what it covers.
pub fn draw(map: &Map<'_>, picture: &mut Picture) -> Vec<Area> {
    let mut taken = vec![time(map, picture)];
    taken.extend(map.scale_bar.then(|| scale(map, picture)));
    if map.title.is_none() {
        taken.extend(north(map, picture));
    }
    taken
}

/// A light ground below furniture.
fn ground(map: &Map<'_>, picture: &mut Picture, area: &Area) {
    picture.rectangle(area, Some(map.palette.background.at(0.85)), None);
}

fn scale(map: &Map<'_>, picture: &mut Picture) -> Area {
    let (palette, size, frame) = (map.palette, map.letters, map.view.area);
    let room = (frame.width * 0.25).min(90.0);
    let lengths = [
        0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0,
        10_000.0, 20_000.0,
    ];
    let fitting = lengths.into_iter().rev().find(|l| map.points(*l) <= room);
    let metres = fitting.unwrap_or(lengths[0]);
    let (length, words) = (map.points(metres), format!("{metres} m"));
    let area = Area {
        x: frame.x + MARGIN,
        y: frame.bottom() - MARGIN - 8.0,
        width: length + 3.0 * MARGIN + Text::width(&words, size),
        height: 8.0_f64.max(size + 2.0),
    };
    ground(map, picture, &area);
    let (left, y) = (area.x + MARGIN, area.y + area.height / 2.0);
    let right = left + length;
    let stroke = || Stroke::new(palette.text, 0.8);
    picture.line(&[(left, y), (right, y)], stroke());
    for x in [left, right] {
        picture.line(&[(x, y - 2.0), (x, y + 2.0)], stroke());
    }
    let at = (right + MARGIN, y + size * 0.35);
    picture.text(Text::new(at, words, size, palette.text));
    area
}

fn time(map: &Map<'_>, picture: &mut Picture) -> Area {
    let (palette, size, frame) = (map.palette, map.letters, map.view.area);
    let time = || format!("t = {:.1} s", map.seconds);
    let words = map.title.clone().unwrap_or_else(time);
    let area = Area {
        x: frame.x + MARGIN,
        y: frame.y + MARGIN,
        width: Text::width(&words, size) + 2.0 * MARGIN,
        height: size + 4.0,
    };
    ground(map, picture, &area);
    let at = (area.x + MARGIN, area.y + 2.0 + size * 0.82);
    picture.text(Text::new(at, words, size, palette.text));
    area
}

/// An arrow to the north, where the map is turned.
fn north(map: &Map<'_>, picture: &mut Picture) -> Option<Area> {
    let turn = map.view.frame.heading - std::f64::consts::FRAC_PI_2;
    if turn.abs() < 1e-3 {
        return None;
    }
    let (palette, size, frame) = (map.palette, map.letters, map.view.area);
    let side = 18.0;
    let area = Area {
        x: frame.right() - MARGIN - side,
        y: frame.y + MARGIN,
        width: side,
        height: side,
    };
    picture.circle(
        area.center(),
        side / 2.0,
        Some(palette.background.at(0.85)),
        None,
    );
    let (x, y) = area.center();
    // North on the page: up, turned the other way than the map.
    let (sin, cos) = turn.sin_cos();
    let spot = |right: f64, up: f64| (x + right * cos + up * sin, y - up * cos + right * sin);
    let needle = [
        spot(0.0, 4.5),
        spot(2.4, -5.5),
        spot(0.0, -3.2),
        spot(-2.4, -5.5),
    ];
    picture.polygon(&needle, Some(palette.text), None);
    let (lx, ly) = spot(0.0, 7.0);
    let letter = Text::new((lx, ly + size * 0.3), "N", size * 0.85, palette.text);
    picture.text(letter.anchored(Anchor::Middle).in_bold(true));
    Some(area)
}
