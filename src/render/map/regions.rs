//! Regions of the world: goals, buildings and the like, and where an obstacle may be.

use super::Map;
use crate::geometry::{Bounds, Shape};
use crate::render::Color;
use crate::render::display::{Picture, Stroke};
use crate::scenario::{ObstacleRole, Position, Prediction};

/// Goals: lanelets and regions, tinted, with a dashed edge.
pub fn goals(map: &Map<'_>, picture: &mut Picture) {
    let scenario = map.subject.scenario;
    let color = map.palette.goal;
    let goals = scenario.planning_problems.iter().flat_map(|p| &p.goals);
    let mut drawn = Vec::new();
    for position in goals.flat_map(|goal| &goal.positions) {
        match position {
            Position::Region(region) => outlined(map, picture, region, color, 0.22),
            Position::Lanelets(ids) => {
                for id in ids {
                    let Some(lanelet) = scenario.network.lanelet(*id) else {
                        continue;
                    };
                    if drawn.contains(id) {
                        continue;
                    }
                    drawn.push(*id);
                    let ring = map.view.all(&lanelet.ring());
                    picture.polygon(&ring, Some(color.at(0.22)), None);
                }
            }
            Position::Point(at) => {
                let stroke = Stroke::new(color, 0.8).dashed(&[2.0, 1.5]);
                picture.circle(map.view.at(at), 4.0, Some(color.at(0.22)), Some(stroke));
            }
        }
    }
}

/// What stands for ever, and where phantom obstacles and those with occupancy sets may be.
pub fn draw(map: &Map<'_>, picture: &mut Picture) {
    let palette = map.palette;
    for obstacle in &map.subject.scenario.obstacles {
        if obstacle.role == ObstacleRole::Environment
            && let Some(body) = &obstacle.footprint
        {
            outlined(map, picture, body.shape(), palette.static_obstacle, 0.6);
        }
        let Prediction::Occupancies(occupancies) = &obstacle.prediction else {
            continue;
        };
        let color = match map.emphasis(obstacle.id) {
            Some(place) => palette.emphasised(place),
            None => palette.obstacle,
        };
        for occupancy in occupancies {
            if (occupancy.time.from..=occupancy.time.to).contains(&map.step) {
                outlined(map, picture, &occupancy.region, color, 0.25);
            }
        }
    }
}

fn outlined(map: &Map<'_>, picture: &mut Picture, region: &Shape, color: Color, opacity: f64) {
    for ring in region.outlines() {
        if Bounds::from_points(&ring).is_some_and(|bounds| map.view.sees(&bounds)) {
            let stroke = Stroke::new(color, 0.6).dashed(&[2.0, 1.5]);
            picture.polygon(&map.view.all(&ring), Some(color.at(opacity)), Some(stroke));
        }
    }
}
