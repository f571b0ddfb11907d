//! Bodies in their real sizes with their headings, where they have been, and where the ego goes.

use super::Map;
use crate::Color;
use crate::display::{Area, Picture, Spot, Stroke};
use crate::scene::{Body, Owner, Trail};
use nearmiss_scene::scenario::Motion;

/// Seconds between two marks on the way that the ego is going to take.
const MARKS: f64 = 0.5;

/// Where everybody has been lately, the ego always, and where the ego and those pointed out go.
pub fn trails(map: &Map<'_>, picture: &mut Picture) {
    for trail in &map.scene.trails {
        match (trail.owner, trail.highlighted) {
            (Owner::Ego, _) => way(map, picture, trail, map.palette.ego),
            (_, Some(place)) => way(map, picture, trail, map.palette.emphasised(place)),
            (_, None) => {
                let stroke = Stroke::new(map.palette.obstacle.at(0.55), 0.6).rounded();
                picture.line(&spots(map, trail.past), stroke);
            }
        }
    }
}

/// The past as a line, the future as a finer one with a mark every half second.
fn way(map: &Map<'_>, picture: &mut Picture, trail: &Trail<'_>, color: Color) {
    let past = spots(map, trail.past);
    picture.line(&past, Stroke::new(color.at(0.75), 0.9).rounded());
    let future = spots(map, trail.future);
    picture.line(&future, Stroke::new(color.at(0.6), 0.5).dashed(&[1.6, 1.2]));
    let every = (MARKS / map.dt).round().max(1.0) as usize;
    for spot in future.iter().step_by(every).skip(1) {
        picture.circle(*spot, 0.8, Some(color.at(0.8)), None);
    }
}

fn spots(map: &Map<'_>, motions: &[(i64, Motion)]) -> Vec<Spot> {
    map.view.all(motions.iter().map(|(_, m)| &m.pose.position))
}

/// A body, with an arrow head at its front where there is room.
pub fn draw(map: &Map<'_>, picture: &mut Picture, body: &Body<'_>) {
    let rings = map.rings(&body.rings);
    if !Area::around(&rings.concat()).is_some_and(|around| map.shows(&around)) {
        return;
    }
    let color = map.color(body.role);
    let edge = color.towards(map.palette.text, 0.45);
    for ring in &rings {
        picture.polygon(ring, Some(color), Some(Stroke::new(edge, 0.45).rounded()));
    }
    let (length, width) = body.footprint.shape().size();
    if body.has_front && map.points(length) > 5.0 && map.points(width) > 2.2 {
        arrow(map, picture, body, width);
    }
}

/// An arrow head inside the body, at its front.
fn arrow(map: &Map<'_>, picture: &mut Picture, body: &Body<'_>, width: f64) {
    let deep = (0.62 * width).min(0.4 * body.length());
    let tip = body.along.1 - 0.22 * deep;
    let half = 0.33 * width;
    let ring = [
        (tip, 0.0),
        (tip - deep, half),
        (tip - 0.72 * deep, 0.0),
        (tip - deep, -half),
    ]
    .map(|(ahead, left)| map.view.at(&body.point(ahead, left)));
    picture.polygon(&ring, Some(map.palette.background.at(0.9)), None);
}
