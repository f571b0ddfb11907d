//! Regions: environment obstacles, occupancy sets, goals.

use ratatui::style::{Color, Modifier, Style};
use ratatui::widgets::canvas::Context;

use super::label_placer::{Body, LabelPlacer};
use super::lines::outlines;
use super::{CellView, Layers, Theme};
use crate::geometry::{Bounds, Point};
use crate::render::scene::{GoalArea, MapScene, RegionKind};
use crate::scenario::{Goal, Position};
use crate::tui::loaded::Opened;
use crate::tui::model::Model;
use crate::tui::widgets::fill::Fill;

/// Lanelets of a goal that are named.
const NAMED: usize = 3;

/// Static regions and goals.
pub fn fixed(
    ctx: &mut Context<'_>,
    theme: &Theme,
    layers: &Layers,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    for goal in scene.goals.iter().filter(|_| layers.goal) {
        if let GoalArea::Region(rings) = goal {
            area(ctx, view, rings, theme.goal);
        }
    }
    for region in &scene.regions {
        if region.kind == RegionKind::Environment {
            outlines(ctx, view, &region.rings, theme.static_obstacle);
        }
    }
}

/// Where phantom obstacles and those with occupancy sets may be at the step, as areas.
pub fn occupancies(ctx: &mut Context<'_>, theme: &Theme, scene: &MapScene<'_>, view: &CellView) {
    for region in &scene.regions {
        if region.kind == RegionKind::Occupancy {
            let color = match region.highlighted {
                Some(_) => theme.picked,
                None => theme.obstacle,
            };
            area(ctx, view, &region.rings, color);
        }
    }
}

/// Labels of goals: lanelets, times, speeds.
pub fn goal_labels(board: &mut LabelPlacer<'_>, model: &Model, opened: &Opened, view: &CellView) {
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
        // All of it where there is room, else at least that it is a goal.
        let words = words(goal, dt);
        let _ = board.beside(&cells, &words, style) || board.beside(&cells, "goal", style);
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
    let seconds = |step: i64| step as f64 * dt;
    let (from, to) = (goal.time.from, goal.time.to);
    words.push(match from == to {
        true => format!("step {from} ({:.1} s)", seconds(from)),
        false => format!(
            "steps {from}-{to} ({:.1}-{:.1} s)",
            seconds(from),
            seconds(to)
        ),
    });
    if let Some(speed) = goal.velocity {
        words.push(match speed {
            crate::scenario::Quantity::Exact(v) => format!("{v:.1} m/s"),
            crate::scenario::Quantity::Interval(from, to) => format!("{from:.1}-{to:.1} m/s"),
        });
    }
    words.join(" · ")
}

/// Outlines with dots inside.
fn area(ctx: &mut Context<'_>, view: &CellView, rings: &[Vec<Point>], color: Color) {
    for ring in rings {
        let corners: Vec<(f64, f64)> = ring.iter().map(|p| view.at(p)).collect();
        ctx.draw(&Fill::dotted(&corners, color));
    }
    outlines(ctx, view, rings, color);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Quantity, Steps};

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
    }
}
