//! Regions of the world: goals, buildings and the like, and where an obstacle may be.

use super::Map;
use crate::Color;
use crate::display::{Picture, Stroke};
use crate::scene::{GoalArea, RegionKind};
use nearmiss_base::geometry::Point;

/// Goals: lanelets and regions, tinted, with a dashed edge.
pub fn goals(map: &Map<'_>, picture: &mut Picture) {
    let color = map.palette.goal;
    for goal in &map.scene.goals {
        match goal {
            GoalArea::Region(rings) => outlined(map, picture, rings, color, 0.22),
            GoalArea::Lanelet(place) => {
                let ring = map.view.all(&map.scene.basemap.surfaces[*place].ring);
                picture.polygon(&ring, Some(color.at(0.22)), None);
            }
            GoalArea::Point(at) => {
                let edge = Stroke::new(color, 0.8).dashed(&[2.0, 1.5]);
                picture.circle(map.view.at(at), 4.0, Some(color.at(0.22)), Some(edge));
            }
        }
    }
}

/// What stands for ever, and where phantom obstacles and those with occupancy sets may be.
pub fn draw(map: &Map<'_>, picture: &mut Picture) {
    for region in &map.scene.regions {
        let (color, opacity) = match region.kind {
            RegionKind::Environment => (map.palette.static_obstacle, 0.6),
            RegionKind::Occupancy => (map.color_of(region.highlighted, map.palette.obstacle), 0.25),
        };
        outlined(map, picture, &region.rings, color, opacity);
    }
}

fn outlined(
    map: &Map<'_>,
    picture: &mut Picture,
    rings: &[Vec<Point>],
    color: Color,
    opacity: f64,
) {
    for ring in map.rings(rings) {
        let stroke = Stroke::new(color, 0.6).dashed(&[2.0, 1.5]);
        picture.polygon(&ring, Some(color.at(opacity)), Some(stroke));
    }
}
