//! Names beside the bodies that matter: never one over another, nor over a body, a scale or a mark.

use super::Map;
use super::bodies::rings;
use crate::render::Color;
use crate::render::display::{Area, Picture, Stroke, Text};

/// Obstacles named at most, beside those that are pointed out.
const MOST: usize = 9;

struct Label {
    words: String,
    color: Color,
    bold: bool,
    /// Around the body.
    body: Area,
}

pub fn draw(map: &Map<'_>, picture: &mut Picture, taken: &[Area], contacts: &[Area]) {
    let word = |mark: &Area| Label {
        words: "contact".into(),
        color: map.palette.danger,
        bold: true,
        body: *mark,
    };
    let mut labels: Vec<Label> = contacts.iter().map(word).collect();
    labels.extend(wanted(map));
    let bodies = everybody(map);
    let mut taken: Vec<Area> = taken
        .iter()
        .chain(contacts)
        .copied()
        .chain(bodies)
        .collect();
    for label in labels {
        if let Some((area, lead)) = place(map, &label, &taken) {
            write(map, picture, &label, area, lead);
            taken.push(area.grown(0.8));
        }
    }
}

/// The ego, those pointed out, and those nearest to the ego, or to the middle of the map where there is none.
fn wanted(map: &Map<'_>) -> Vec<Label> {
    let palette = map.palette;
    let middle = map.view.area.center();
    let mut labels = Vec::new();
    let mut center = middle;
    if let Some(scene) = map.subject.scene
        && let Some(motion) = scene.ego.track.at(map.step)
        && let Some(body) =
            Area::around(&rings(map, scene.ego_footprint_at(map.step), motion).concat())
    {
        center = body.center();
        labels.push(Label {
            words: "ego".into(),
            color: palette.ego,
            bold: true,
            body,
        });
    }
    let mut others = Vec::new();
    for obstacle in map.subject.others() {
        let motion = map.subject.motion(obstacle, map.step);
        let Some((shape, motion)) = obstacle.footprint_at(map.step).zip(motion) else {
            continue;
        };
        let Some(body) = Area::around(&rings(map, shape, motion).concat()) else {
            continue;
        };
        if !map.view.area.meets(&body) {
            continue;
        }
        let (x, y) = body.center();
        let far = (x - center.0).hypot(y - center.1);
        let place = map.emphasis(obstacle.id);
        let label = Label {
            words: obstacle.id.to_string(),
            color: place.map_or(palette.text, |place| palette.emphasised(place)),
            bold: place.is_some(),
            body,
        };
        others.push((place.unwrap_or(usize::MAX), far, label));
    }
    others.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let pointed_out = others
        .iter()
        .filter(|(place, ..)| *place < usize::MAX)
        .count();
    if let Some((words, color, body)) = super::variation::name(map) {
        labels.push(Label {
            words,
            color,
            bold: false,
            body,
        });
    }
    let named = others.into_iter().map(|(.., label)| label);
    labels.extend(named.take(pointed_out + MOST));
    labels
}

/// What every body covers.
fn everybody(map: &Map<'_>) -> Vec<Area> {
    let ego = map.subject.scene.and_then(|scene| {
        let motion = scene.ego.track.at(map.step)?;
        Some((scene.ego_footprint_at(map.step), motion))
    });
    let others = map.subject.others().filter_map(|o| {
        let motion = map.subject.motion(o, map.step)?;
        Some((o.footprint_at(map.step)?, motion))
    });
    let all = ego.into_iter().chain(others);
    // Ring by ring: the box around a long body that stands askew would keep much free ground.
    let rings = all.flat_map(|(body, motion)| rings(map, body, motion));
    rings
        .flat_map(|ring| pieces(&ring))
        .filter(|area| map.shows(area))
        .collect()
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
        let spots = [
            (centered, above),
            (right, middle),
            (left, middle),
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
    let text = Text::new(at, label.words.clone(), map.letters, label.color).in_bold(label.bold);
    let text = text.anchored(crate::render::display::Anchor::Middle);
    picture.text(text.with_halo(map.palette.background));
}
