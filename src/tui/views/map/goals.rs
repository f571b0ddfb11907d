//! Labels of goals: where, when and how fast.

use ratatui::style::{Modifier, Style};

use super::CellView;
use super::label_placer::{Body, LabelPlacer};
use crate::loaded::Opened;
use crate::model::Model;
use nearmiss_base::geometry::{Bounds, Point};
use nearmiss_scene::scenario::{Goal, Position};

/// Lanelets of a goal that are named.
const NAMED: usize = 3;

/// Labels of goals: lanelets, times, speeds.
pub fn labels(board: &mut LabelPlacer<'_>, model: &Model, opened: &Opened, view: &CellView) {
    if !model.map.layers.goal {
        return;
    }
    let dt = opened.scenario.dt();
    let style = Style::new()
        .fg(model.theme.goal)
        .add_modifier(Modifier::BOLD);
    let problems = opened.scenario.planning_problems.iter();
    for goal in problems.flat_map(|p| &p.goals) {
        let Some(at) = place(opened, goal, view) else {
            continue;
        };
        let Some(body) = Body::around([view.at(&at)]) else {
            continue;
        };
        let cells = board.cells(&body);
        // All of it where there is room, else when, else at least that it is a goal.
        let (all, when) = (words(goal, dt), format!("goal {}", seconds(goal, dt)));
        let mut texts = [all.as_str(), &when, "goal"].into_iter();
        texts.any(|text| board.has_room(text) && board.beside(&cells, text, style));
    }
}

/// The place of a goal that is seen nearest to the middle of the map.
fn place(opened: &Opened, goal: &Goal, view: &CellView) -> Option<Point> {
    let network = &opened.scenario.network;
    let mut places = Vec::new();
    for position in &goal.positions {
        match position {
            Position::Point(p) => places.push(*p),
            Position::Region(region) => {
                let outlines = region.outlines();
                places.extend(Bounds::from_points(outlines.iter().flatten()).map(|b| b.center()));
            }
            Position::Lanelets(ids) => {
                for lanelet in ids.iter().filter_map(|id| network.lanelet(*id)) {
                    let (left, right) = (&lanelet.left.points, &lanelet.right.points);
                    let middles = left.iter().zip(right);
                    places.extend(middles.map(|(l, r)| nalgebra::center(l, r)));
                }
            }
        }
    }
    let away = |p: &Point| {
        let (x, y) = view.at(p);
        x.hypot(y)
    };
    let seen = places.into_iter().filter(|p| view.sees_point(p));
    seen.min_by(|a, b| away(a).total_cmp(&away(b)))
}

/// When a goal is to be reached.
fn seconds(goal: &Goal, dt: f64) -> String {
    let seconds = |step: i64| step as f64 * dt;
    let (from, to) = (seconds(goal.time.from), seconds(goal.time.to));
    if goal.time.from == goal.time.to {
        format!("{from:.1} s")
    } else {
        format!("{from:.1}-{to:.1} s")
    }
}

/// Describes a goal.
pub fn words(goal: &Goal, dt: f64) -> String {
    let mut words = vec!["goal".to_string()];
    let lanelets = goal.lanelets();
    if !lanelets.is_empty() {
        let ids: Vec<String> = lanelets.iter().take(NAMED).map(i64::to_string).collect();
        let more = if lanelets.len() > NAMED { " …" } else { "" };
        let plural = if lanelets.len() > 1 { "s" } else { "" };
        words.push(format!("lanelet{plural} {}{more}", ids.join(" ")));
    }
    let (from, to) = (goal.time.from, goal.time.to);
    let seconds = seconds(goal, dt);
    words.push(if from == to {
        format!("step {from} ({seconds})")
    } else {
        format!("steps {from}-{to} ({seconds})")
    });
    if let Some(speed) = goal.velocity {
        words.push(match speed {
            nearmiss_scene::scenario::Quantity::Exact(v) => format!("{v:.1} m/s"),
            nearmiss_scene::scenario::Quantity::Interval(from, to) => {
                format!("{from:.1}-{to:.1} m/s")
            }
        });
    }
    words.join(" · ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_scene::scenario::{Quantity, Steps};

    #[test]
    fn a_goal_says_where_when_and_how_fast() {
        let mut goal = Goal {
            time: Steps { from: 40, to: 60 },
            positions: vec![Position::Lanelets(vec![12, 13])],
            orientation: None,
            velocity: Some(Quantity::Interval(5.0, 8.5)),
        };
        assert_eq!(
            words(&goal, 0.1),
            "goal · lanelets 12 13 · steps 40-60 (4.0-6.0 s) · 5.0-8.5 m/s"
        );
        goal.time = Steps::exact(30);
        goal.positions.clear();
        goal.velocity = None;
        assert_eq!(words(&goal, 0.2), "goal · step 30 (6.0 s)");
        assert_eq!(seconds(&goal, 0.2), "6.0 s");
    }
}
