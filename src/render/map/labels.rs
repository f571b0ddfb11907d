//! Names beside the bodies that matter, never over one another, a body or a mark; scale bar, time, and north.

use nearmiss_base::geometry::Point;

use super::Map;
use crate::Color;
use crate::display::{Anchor, Area, Picture, Stroke, Text};
use crate::scene::{Body, Contact, MAX_NAMED, Overlay, Owner};

struct Label {
    words: String,
    color: Color,
    bold: bool,
    /// Around the body.
    body: Area,
}

pub fn draw(map: &Map<'_>, picture: &mut Picture, taken: &[Area], contacts: &[Area]) {
    let word = |(mark, contact): (&Area, &Contact)| Label {
        words: if contact.is_possible {
            "possible contact".into()
        } else {
            "contact".into()
        },
        color: map.palette.danger,
        bold: true,
        body: *mark,
    };
    let mut labels: Vec<Label> = contacts.iter().zip(&map.scene.contacts).map(word).collect();
    labels.extend(wanted(map));
    let bodies = everybody(map);
    let mut taken: Vec<Area> = taken
        .iter()
        .chain(contacts)
        .copied()
        .chain(bodies)
        .chain(arrows(map))
        .collect();
    for label in labels {
        if let Some((area, lead)) = place(map, &label, &taken) {
            write(map, picture, &label, area, lead);
            taken.push(area.grown(0.8));
        }
    }
}

/// Bodies by their ids, and after the ego the hollow ones.
fn wanted(map: &Map<'_>) -> Vec<Label> {
    let label = |words, color, bold, rings: &[Vec<Point>]| {
        let body = Area::around(&map.rings(rings).concat()).filter(|body| map.shows(body))?;
        Some(Label {
            words,
            color,
            bold,
            body,
        })
    };
    let of_body = |body: &Body<'_>| {
        let (words, known) = match body.owner {
            Owner::Ego => ("ego".into(), true),
            Owner::Obstacle(id) => (id.to_string(), body.highlighted.is_some()),
        };
        let color = if known {
            map.color(body.role)
        } else {
            map.palette.text
        };
        label(words, color, known, &body.rings)
    };
    let hollow = map.scene.hollow().filter_map(|(name, outline)| {
        label(name.into(), map.color(outline.role), false, &outline.rings)
    });
    let mut named = map.scene.named(MAX_NAMED).into_iter().peekable();
    let ego = named
        .next_if(|body| body.owner == Owner::Ego)
        .and_then(of_body)
        .into_iter();
    ego.chain(hollow).chain(named.filter_map(of_body)).collect()
}

/// What every body covers.
fn everybody(map: &Map<'_>) -> Vec<Area> {
    let all = map.scene.ego.iter().chain(&map.scene.bodies);
    // Ring by ring: the box around a long body that stands askew would keep much free ground.
    let rings = all.flat_map(|body| map.rings(&body.rings));
    rings
        .flat_map(|ring| pieces(&ring))
        .filter(|area| map.shows(area))
        .collect()
}

/// What the arrows of a storyboard cover: boxes along each.
fn arrows(map: &Map<'_>) -> Vec<Area> {
    let overlays = map.scene.overlays.iter().filter(|_| map.title.is_some());
    let along = overlays.filter_map(|overlay| match overlay {
        Overlay::Path(path) => {
            let ends = map.view.all(path.points.iter().take(2));
            let &[(ax, ay), (bx, by)] = &ends[..] else {
                return None;
            };
            let boxed = move |i: u8| {
                let part = f64::from(i) / 8.0;
                let at = (ax + (bx - ax) * part, ay + (by - ay) * part);
                Area::around(&[at]).map(|area| area.grown(2.0))
            };
            Some((0..=8).filter_map(boxed))
        }
        Overlay::Outline(_) => None,
    });
    along.flatten().filter(|area| map.shows(area)).collect()
}

/// Boxes that cover a ring: of a box that stands askew, four along it.
fn pieces(ring: &[(f64, f64)]) -> Vec<Area> {
    let &[a, b, c, d] = ring else {
        return Area::around(ring).into_iter().collect();
    };
    let part =
        |p: (f64, f64), q: (f64, f64), t: f64| (p.0 + (q.0 - p.0) * t, p.1 + (q.1 - p.1) * t);
    let piece = |i: u8| {
        let (from, to) = (f64::from(i) / 4.0, f64::from(i + 1) / 4.0);
        // From the edge b–c to the opposite one d–a, along a–b.
        Area::around(&[
            part(a, b, from),
            part(a, b, to),
            part(d, c, from),
            part(d, c, to),
        ])
    };
    (0..4).filter_map(piece).collect()
}

/// Where a label may stand, and whether it needs a line to its body.
fn place(map: &Map<'_>, label: &Label, taken: &[Area]) -> Option<(Area, bool)> {
    let width = Text::width(&label.words, map.letters);
    let height = map.letters * 0.86;
    let body = label.body;
    let (x, y) = body.center();
    for (ring, gap) in [1.6, 7.0, 13.0, 20.0].into_iter().enumerate() {
        let (left, right) = (body.x - gap - width, body.right() + gap);
        let (above, below) = (body.y - gap - height, body.bottom() + gap);
        let (centered, middle) = (x - width / 2.0, y - height / 2.0);
        // In a storyboard arrows begin at the fronts, which mostly are above.
        let [first, second, third] = match map.title {
            None => [(centered, above), (right, middle), (left, middle)],
            Some(_) => [(right, middle), (left, middle), (centered, above)],
        };
        let spots = [
            first,
            second,
            third,
            (centered, below),
            (right, above),
            (right, below),
            (left, above),
            (left, below),
        ];
        let areas = spots.map(|(x, y)| Area {
            x,
            y,
            width,
            height,
        });
        let inside = map.view.area.grown(-2.0);
        let free = |area: &&Area| inside.holds(area) && !taken.iter().any(|t| t.meets(area));
        if let Some(area) = areas.iter().find(free) {
            return Some((*area, ring > 0));
        }
    }
    None
}

fn write(map: &Map<'_>, picture: &mut Picture, label: &Label, area: Area, lead: bool) {
    if lead {
        // From the edge of the label to the body.
        let (x, y) = label.body.center();
        let from = (
            x.clamp(area.x, area.right()),
            y.clamp(area.y, area.bottom()),
        );
        picture.line(
            &[from, (x, y)],
            Stroke::new(map.palette.background.at(0.8), 1.4),
        );
        picture.line(&[from, (x, y)], Stroke::new(map.palette.dim, 0.4));
    }
    let at = (area.x + area.width / 2.0, area.y + map.letters * 0.76);
    let text = Text::new(at, label.words.clone(), map.letters, label.color)
        .in_bold(label.bold)
        .anchored(crate::display::Anchor::Middle);
    picture.text(text.with_halo(map.palette.background));
}

/// From the edge of the map, points.
const MARGIN: f64 = 4.0;

/// Draws it; gives what it covers.
pub fn draw_furniture(map: &Map<'_>, picture: &mut Picture) -> Vec<Area> {
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
