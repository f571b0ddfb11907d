//! Bodies in their real sizes with their headings, where they have been, and where the ego goes.

use super::Map;
use crate::geometry::{Footprint, Point};
use crate::render::Color;
use crate::render::display::{Area, Picture, Spot, Stroke};
use crate::scenario::{Motion, ObstacleRole, ObstacleType, Track};

/// Seconds of the past that obstacles leave behind.
const TRAIL: f64 = 2.0;
/// Seconds between two marks on the way that the ego is going to take.
const MARKS: f64 = 0.5;

/// Where everybody has been lately, the ego always, and where the ego and those pointed out go.
pub fn trails(map: &Map<'_>, picture: &mut Picture) {
    let dt = map.subject.scenario.dt();
    let back = (TRAIL / dt).ceil() as i64;
    for obstacle in map.subject.others() {
        let track = obstacle.track();
        match map.emphasis(obstacle.id) {
            Some(place) => way(map, picture, track, map.palette.emphasised(place), dt),
            None => {
                let past = spots(map, track, map.step - back..map.step + 1);
                if Area::around(&past).is_some_and(|around| map.shows(&around.grown(1.0))) {
                    picture.line(
                        &past,
                        Stroke::new(map.palette.obstacle.at(0.55), 0.6).rounded(),
                    );
                }
            }
        }
    }
    if let Some(scene) = map.subject.scene {
        way(map, picture, &scene.ego.track, map.palette.ego, dt);
    }
}

/// The past as a line, the future as a finer one with a mark every half second.
fn way(map: &Map<'_>, picture: &mut Picture, track: &Track, color: Color, dt: f64) {
    let past = spots(map, track, track.steps().start..map.step + 1);
    picture.line(&past, Stroke::new(color.at(0.75), 0.9).rounded());
    let future = spots(map, track, map.step..track.steps().end);
    picture.line(&future, Stroke::new(color.at(0.6), 0.5).dashed(&[1.6, 1.2]));
    let every = (MARKS / dt).round().max(1.0) as usize;
    for spot in future.iter().step_by(every).skip(1) {
        picture.circle(*spot, 0.8, Some(color.at(0.8)), None);
    }
}

/// Where a track is on the page at some steps.
pub fn spots(map: &Map<'_>, track: &Track, steps: std::ops::Range<i64>) -> Vec<Spot> {
    let there = track.steps();
    let steps = steps.start.max(there.start)..steps.end.min(there.end);
    let motions = steps.filter_map(|step| track.at(step));
    motions.map(|m| map.view.at(&m.pose.position)).collect()
}

/// Everyone but the ego; those who are pointed out lie over the others.
pub fn obstacles(map: &Map<'_>, picture: &mut Picture) {
    let palette = map.palette;
    for pointed_out in [false, true] {
        for obstacle in map.subject.others() {
            let place = map.emphasis(obstacle.id);
            if place.is_some() != pointed_out {
                continue;
            }
            let motion = map.subject.motion(obstacle, map.step);
            let Some((body, motion)) = obstacle.footprint_at(map.step).zip(motion) else {
                continue;
            };
            let parked = obstacle.role == ObstacleRole::Static;
            let color = match place {
                Some(place) => palette.emphasised(place),
                None if parked => palette.static_obstacle,
                None => palette.obstacle,
            };
            draw(map, picture, body, motion, color, has_front(obstacle.kind));
        }
    }
}

pub fn ego(map: &Map<'_>, picture: &mut Picture) {
    let Some(scene) = map.subject.scene else {
        return;
    };
    if let Some(motion) = scene.ego.track.at(map.step) {
        let body = scene.ego_footprint_at(map.step);
        draw(map, picture, body, motion, map.palette.ego, true);
    }
}

/// Whether it drives or walks forwards; walls and posts do not.
fn has_front(kind: ObstacleType) -> bool {
    use ObstacleType::{Building, ConstructionZone, MedianStrip, Pillar, RoadBoundary};
    !matches!(
        kind,
        Building | ConstructionZone | MedianStrip | Pillar | RoadBoundary
    )
}

/// The outlines of a body on the page.
pub fn rings(map: &Map<'_>, body: &Footprint, motion: &Motion) -> Vec<Vec<Spot>> {
    let outlines = body.at(motion.pose).outlines();
    outlines.iter().map(|ring| map.view.all(ring)).collect()
}

fn draw(
    map: &Map<'_>,
    picture: &mut Picture,
    body: &Footprint,
    motion: &Motion,
    color: Color,
    front: bool,
) {
    let rings = rings(map, body, motion);
    if !Area::around(&rings.concat()).is_some_and(|around| map.shows(&around)) {
        return;
    }
    let edge = color.towards(map.palette.text, 0.45);
    for ring in &rings {
        picture.polygon(ring, Some(color), Some(Stroke::new(edge, 0.45).rounded()));
    }
    let (length, width) = body.shape().size();
    if front && map.points(length) > 5.0 && map.points(width) > 2.2 {
        arrow(map, picture, body, motion, width);
    }
}

/// An arrow head inside the body, at its front.
fn arrow(map: &Map<'_>, picture: &mut Picture, body: &Footprint, motion: &Motion, width: f64) {
    let pose = motion.pose;
    let (_, front) = body.at(pose).extent(&pose.position, &pose.forward());
    let (rear, _) = body.at(pose).extent(&pose.position, &pose.forward());
    let deep = (0.62 * width).min(0.4 * (front - rear));
    let tip = front - 0.22 * deep;
    let corner = |x: f64, y: f64| map.view.at(&pose.to_world(&Point::new(x, y)));
    let half = 0.33 * width;
    let ring = [
        corner(tip, 0.0),
        corner(tip - deep, half),
        corner(tip - 0.72 * deep, 0.0),
        corner(tip - deep, -half),
    ];
    picture.polygon(&ring, Some(map.palette.background.at(0.9)), None);
}
