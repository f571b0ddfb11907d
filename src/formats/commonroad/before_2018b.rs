//! What versions before 2018b have in other places: times in seconds, first states, speed limits.

use nearmiss_base::geometry::{Footprint, Pose, Shape};
use nearmiss_scene::scenario::plausibility::LARGEST_NUMBER;
use nearmiss_scene::scenario::{
    Lanelet, ObstacleParts, ObstacleRole, Position, Prediction, Quantity, Severity, Sign, State,
    Steps, in_frame,
};

use super::builder::SourceLocation;
use super::xml::Xml;

/// Whether a version, a year and a letter, is one of these.
pub(super) fn is_meant(version: &str) -> bool {
    let year = version.trim().get(..4).and_then(|y| y.parse::<u16>().ok());
    let letter = version.trim().get(4..).unwrap_or_default();
    match year {
        Some(year) if year >= 2000 => (year, letter) < (2018, "b"),
        _ => false,
    }
}

/// Gives an obstacle the initial state that later versions have: the first state of its trajectory, or where the shape
/// of a static one says that it is. Shapes in world coordinates come into the obstacle's own frame.
pub(super) fn complete(at: &impl SourceLocation, parts: &mut ObstacleParts) {
    if parts.initial.is_some() {
        return;
    }
    match &mut parts.prediction {
        Prediction::Trajectory(states) if !states.is_empty() => {
            let first = states.remove(0);
            own_frame(at, &first, &mut parts.footprint);
            parts.initial = Some(first);
        }
        Prediction::None if parts.role == ObstacleRole::Static => {
            parts.initial = parts.footprint.as_mut().and_then(standing);
        }
        _ => {}
    }
    if parts.prediction == Prediction::Trajectory(Vec::new()) {
        parts.prediction = Prediction::None;
    }
}

/// The state of a body that stands where its shape is; the shape comes into its frame.
fn standing(body: &mut Footprint) -> Option<State> {
    let shape = body.shape();
    let heading = match shape {
        Shape::Rectangle { orientation, .. } => *orientation,
        _ => 0.0,
    };
    let position = shape.centroid()?;
    *body = Footprint::new(in_frame(shape, &Pose { position, heading })).ok()?;
    Some(State {
        position: Some(Position::Point(position)),
        orientation: Some(Quantity::Exact(heading)),
        ..State::at(Steps::exact(0))
    })
}

/// Brings a shape that lies beside the obstacle's own origin into its frame: it is in world coordinates.
fn own_frame(at: &impl SourceLocation, first: &State, body: &mut Option<Footprint>) {
    let Some(shape) = body.as_ref().map(Footprint::shape) else {
        return;
    };
    let (Some(centre), Some(position)) = (shape.centroid(), first.point()) else {
        return;
    };
    let corners = shape.outlines().into_iter().flatten();
    let reach = corners.map(|p| (p - centre).norm()).fold(0.0, f64::max);
    let off = centre.coords.norm();
    if off <= reach {
        return;
    }
    let heading = first.orientation.map_or(0.0, |q| q.middle());
    let own = Footprint::new(in_frame(shape, &Pose { position, heading }));
    if let Ok(own) = own {
        at.warn(format!(
            "the shape's centre is {off:.1} m from the obstacle's own origin; taken as in world coordinates at its first state"
        ));
        *body = Some(own);
    }
}

/// The German number of the sign for a maximum speed, which the reference reader takes in most countries.
const MAXIMUM_SPEED: &str = "274";

/// How far beyond the ids in use the reference reader numbers the signs it makes up.
const ID_OFFSET: i64 = 10_000;

/// Makes a sign for every lanelet with a speed limit, numbered as the reference reader does it.
///
/// `used` is the largest id in the file.
pub(super) fn signs(xml: &mut Xml<'_>, lanelets: &mut [Lanelet], used: i64) -> Vec<Sign> {
    let limits = xml.take_speed_limits();
    let mut signs = Vec::with_capacity(limits.len());
    let mut last = used;
    for (id, limit, place) in limits {
        let Some(lanelet) = lanelets.iter_mut().find(|l| l.id == id) else {
            continue;
        };
        if limit.is_nan() || limit < 0.0 {
            let message = format!("speed limit {limit} m/s; left out");
            xml.note_at(Severity::Warning, &place, message);
            continue;
        }
        // Writers put the largest number that they know where there is no limit.
        if limit > LARGEST_NUMBER {
            let message = "so large a speed limit is taken as none".into();
            xml.note_at(Severity::Note, &place, message);
            continue;
        }
        last = last.saturating_add(1 + ID_OFFSET);
        lanelet.signs.push(last);
        let position = lanelet.right.points.first().copied();
        signs.push(Sign::speed_limit(last, MAXIMUM_SPEED, limit, position));
        let message = format!("speed limit {limit} m/s taken as sign {last}");
        xml.note_at(Severity::Note, &place, message);
    }
    signs
}

/// Counts speed limits of a version that has signs for them as not used.
pub(super) fn count_unused(xml: &mut Xml<'_>) {
    for (_, _, place) in xml.take_speed_limits() {
        xml.unused_at(&place);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::commonroad::{ReadError, read};
    use nearmiss_base::geometry::Point;
    use nearmiss_scene::scenario::Scenario;

    fn state(time: &str, x: f64) -> String {
        format!(
            "<state><position><point><x>{x}</x><y>0</y></point></position><orientation><exact>0</exact></orientation>\
             <time>{time}</time><velocity><exact>10</exact></velocity></state>"
        )
    }

    /// A scenario with a moving obstacle, a standing one in world coordinates, one given as a set, and a task.
    fn scenario(version: &str, times: [&str; 3], yaw_rate: &str) -> Result<Scenario, ReadError> {
        let states: String = times
            .iter()
            .zip([0.0, 1.0, 2.0])
            .map(|(time, x)| state(&format!("<exact>{time}</exact>"), x))
            .collect();
        let square = "<shape><rectangle><length>4</length><width>2</width></rectangle></shape>";
        let text = format!(
            "<commonRoad commonRoadVersion='{version}' benchmarkID='A' timeStepSize='0.1'>\
             <obstacle id='1'><role>dynamic</role><type>car</type>{square}<trajectory>{states}</trajectory></obstacle>\
             <obstacle id='2'><role>static</role><type>unknown</type><shape><rectangle><length>4</length><width>2</width>\
             <orientation>1.5</orientation><center><x>50</x><y>7</y></center></rectangle></shape></obstacle>\
             <obstacle id='3'><role>dynamic</role><type>car</type><occupancySet><occupancy><shape><circle>\
             <radius>1</radius><center><x>30</x><y>0</y></center></circle></shape><time><intervalStart>{}</intervalStart>\
             <intervalEnd>{}</intervalEnd></time></occupancy></occupancySet></obstacle>\
             <planningProblem id='4'>{}<goalRegion><state><time><intervalStart>{}</intervalStart>\
             <intervalEnd>{}</intervalEnd></time></state></goalRegion></planningProblem></commonRoad>",
            times[0],
            times[1],
            state(&format!("<exact>{}</exact>", times[0]), 0.0)
                .replace("state>", "initialState>")
                .replace(
                    "</initialState>",
                    &format!("<yawRate><exact>{yaw_rate}</exact></yawRate></initialState>")
                ),
            times[1],
            times[2],
        );
        read(text.as_bytes(), "a.xml")
    }

    #[test]
    fn seconds_first_states_and_world_shapes_become_those_of_later_versions() {
        for version in ["2017a", "2018a"] {
            let read = scenario(version, ["0.0", "0.10", "0.2"], "NaN").unwrap();
            let car = read.obstacle(1).unwrap();
            assert_eq!(car.track().steps(), 0..3);
            assert!(car.initial.is_some() && car.states().count() == 3);
            let stands = read.obstacle(2).unwrap();
            let pose = stands.motion_at(7).unwrap().pose;
            assert!((pose.position - Point::new(50.0, 7.0)).norm() < 1e-9);
            assert!((pose.heading - 1.5).abs() < 1e-9);
            let corners = stands.placed_at(7).unwrap().outlines().concat();
            let far = |p: &Point| (p - pose.position).norm();
            assert!(corners.iter().all(|p| far(p) < 2.3), "{corners:?}");
            let set = read.obstacle(3).unwrap();
            assert!(set.is_occupancy_at(0) && set.is_occupancy_at(1) && !set.is_occupancy_at(2));
            let problem = &read.planning_problems[0];
            assert_eq!(problem.goals[0].time, Steps { from: 1, to: 2 });
            assert!(problem.initial.more.is_empty(), "NaN is left out");
            let said: Vec<String> = read.diagnostics.iter().map(ToString::to_string).collect();
            assert!(
                said.iter().any(|d| d.contains("times in seconds")),
                "{said:?}"
            );
            assert!(
                said.iter()
                    .any(|d| d.contains("yawRate") && d.contains("left out"))
            );
            assert!(
                !said
                    .iter()
                    .any(|d| d.contains("no goal") || d.contains("no initial state"))
            );
        }
    }

    #[test]
    fn later_versions_have_whole_steps() {
        let read = scenario("2018b", ["0", "1.0", "2"], "0").unwrap();
        assert_eq!(read.obstacle(1).unwrap().track().steps(), 0..3);
        assert_eq!(read.planning_problems[0].initial.more.len(), 1);
        for version in ["2018b", "2020a", ""] {
            let error = scenario(version, ["0", "0.1", "0.2"], "0").unwrap_err();
            assert!(
                error
                    .message
                    .contains("`0.1` is no time step; it looks like seconds, 1 step"),
                "{error}"
            );
        }
        let odd = scenario("2018a", ["0", "0.15", "0.2"], "0").unwrap_err();
        assert!(
            odd.message.contains("no whole number of time steps"),
            "{odd}"
        );
        let open = scenario("2020a", ["0", "1", "100000000"], "0").unwrap_err();
        assert!(
            open.message.contains("implausible"),
            "a state is at no open time: {open}"
        );
    }

    #[test]
    fn versions_are_in_order() {
        for (version, before) in [
            ("2017a", true),
            ("2018a", true),
            ("2018b", false),
            ("2018c", false),
            ("2020a", false),
            ("", false),
            ("v1", false),
            ("1.0", false),
        ] {
            assert_eq!(is_meant(version), before, "{version}");
        }
    }
}
