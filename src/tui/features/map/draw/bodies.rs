//! Draws what is on the map: bodies with their signs, paths, goals, the planner's candidates and the tape.
//!
//! The planner's view at a moment, and the recorded ego beside the planned one.
//!
//! Feasible candidates are lines, rejected ones dots, the chosen one a thick line with its seconds; predicted bodies
//! are outlines; the recorded ego's path is dashed and its body hollow.

use nearmiss_base::geometry::{Bounds, Point};
use nearmiss_render::cells::{Appearance, CellView, MapStyle, heading_arrow};
use nearmiss_render::scene::{Importance, LineStyle, MapScene, Outline, Overlay, Owner, Role};
use nearmiss_scene::description::visible;
use nearmiss_scene::scenario::{Goal, Position, Sign, SignMeaning, SignalColor};
use ratatui::style::{Color, Modifier, Style};

use crate::features::map::draw::labels::{Body, LabelPlacer};
use crate::loaded::{CycleShown, Opened};
use crate::model::{Foreseen, Measurement, Model, Moment, On, Tape};
use crate::widgets::words::hundredths;

/// Bodies that are too small for their heading to show are arrows, the ego on top. Among lines alone others have an arrow,
/// too, and those that are too small for an outline have it in a box, which is filled for the ego.
pub fn arrows(
    board: &mut LabelPlacer<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    let all = scene.bodies.iter().chain(&scene.ego);
    for body in all {
        let mut style = Style::new().fg(look.color(body.role));
        let is_tiny = body.is_tiny(view.cell.0);
        let is_boxed = is_hollow(look) && !is_tiny && body.is_small(view.cell.0);
        let shows_shape = body.stands || !body.has_front;
        if !is_tiny && !is_boxed && (look.style.has_backgrounds() || shows_shape) {
            continue;
        }
        // Without colours nothing else marks the ego, and others are outlined.
        let is_ego = body.owner == Owner::Ego;
        if is_ego && !look.has_colors() || !is_tiny && look.has_colors() {
            style = style.add_modifier(Modifier::REVERSED);
        }
        if body.importance >= Importance::Danger {
            style = style.add_modifier(Modifier::BOLD);
        }
        let pose = body.motion.pose;
        let glyph = if body.stands {
            "▪"
        } else {
            heading_arrow(&view.turned(&pose.forward()))
        };
        let glyph = match (is_boxed, is_ego) {
            (true, true) => format!(" {glyph} "),
            (true, false) => format!("[{glyph}]"),
            (false, _) => glyph.into(),
        };
        board.put(view.at(&middle(body)), &glyph, style);
    }
}

/// Where the arrow of a body stands.
fn middle(body: &nearmiss_render::scene::Body<'_>) -> Point {
    if body.stands {
        body.motion.pose.position
    } else {
        body.point(body.part(0.5), 0.0)
    }
}

/// Whether the bodies of others are outlines, as there are no colours.
pub fn is_hollow(look: &Appearance<'_>) -> bool {
    look.style == MapStyle::Braille && !look.has_colors()
}

/// Where the ego touches others: what matters most on the map. The arrows of both stay in sight below it.
pub fn contacts(
    board: &mut LabelPlacer<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    let style = Style::new()
        .fg(look.theme.danger)
        .bg(look.theme.map_ground)
        .add_modifier(Modifier::BOLD);
    let tiny = scene.bodies.iter().chain(&scene.ego);
    let tiny = tiny.filter(|body| body.is_tiny(view.cell.0));
    let arrows: Vec<_> = tiny.map(|b| board.cell(view.at(&middle(b)))).collect();
    for contact in &scene.contacts {
        let at = view.at(&contact.at);
        let above = (at.0, at.1 + view.cell.1);
        let hides = arrows.contains(&board.cell(at)) && !arrows.contains(&board.cell(above));
        board.put(if hides { above } else { at }, "×", style);
    }
}

/// Where a cell is at most this wide, lights and signs are seen, metres.
const SEEN: f64 = 1.6;

/// Where a cell is at most this wide, signs are read, metres.
const READ: f64 = 0.9;

/// A sign that cannot be read, or whose number is not known.
const POST: &str = "▫";

/// More letters than this of a sign's number are no number.
const MAX_NUMBER_LETTERS: usize = 8;

/// Kinds of symbols placed on the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Placed {
    /// Whether there are lights.
    pub lights: bool,
    /// Whether there are signs that are not read out.
    pub posts: bool,
}

impl Placed {
    /// What is on one of two maps.
    pub fn and(self, other: Self) -> Self {
        Self {
            lights: self.lights || other.lights,
            posts: self.posts || other.posts,
        }
    }
}

/// Says whether there are lights.
pub fn lights(
    board: &mut LabelPlacer<'_>,
    model: &Model,
    scene: &MapScene<'_>,
    view: &CellView,
) -> bool {
    if !model.map.layers.lights || view.cell.0 > SEEN {
        return false;
    }
    let mut placed: Vec<(f64, f64)> = Vec::new();
    for light in &scene.lights {
        let (letter, color) = shown(model, light.color);
        let style = Style::new()
            .fg(color)
            .add_modifier(Modifier::BOLD | Modifier::REVERSED);
        let at = view.at(&light.at);
        let is_near = |placed: &(f64, f64)| {
            (placed.0 - at.0).abs() < 3.0 * view.cell.0
                && (placed.1 - at.1).abs() < 1.5 * view.cell.1
        };
        // One of several at the same place is enough.
        let is_said = placed.iter().any(is_near);
        if !is_said
            && (board.put_if_free(at, letter, style) || board.beside_point(at, letter, style))
        {
            placed.push(at);
        }
    }
    !placed.is_empty()
}

/// A letter and a colour; the letter says it without the colour.
fn shown(model: &Model, color: SignalColor) -> (&'static str, Color) {
    let theme = &model.theme;
    match color {
        SignalColor::Red => ("R", theme.danger),
        SignalColor::RedYellow => ("RA", theme.warning),
        SignalColor::Yellow => ("A", theme.warning),
        SignalColor::Green => ("G", theme.safe),
        SignalColor::Inactive => ("-", theme.dim),
    }
}

/// Says whether there are signs that are not read out.
pub fn signs(
    board: &mut LabelPlacer<'_>,
    model: &Model,
    scene: &MapScene<'_>,
    view: &CellView,
) -> bool {
    if !model.map.layers.signs || view.cell.0 > SEEN {
        return false;
    }
    let style = Style::new().fg(model.theme.dim);
    let mut posts = false;
    for post in &scene.signs {
        let at = view.at(&post.at);
        let words = sign_label(post.sign).filter(|_| view.cell.0 <= READ);
        let read = words.is_some_and(|words| {
            board.put_if_free(at, &words, style) || board.beside_point(at, &words, style)
        });
        posts |= !read && board.put_if_free(at, POST, style);
    }
    posts
}

/// What a post says; `None` if none of its numbers is known.
fn sign_label(sign: &Sign) -> Option<String> {
    let speed = |speed: f64| {
        let (value, unit) = sign.speed_shown(speed);
        format!("{value:.0} {unit}")
    };
    let all = sign.elements.iter().map(|element| match element.meaning() {
        Some(SignMeaning::SpeedLimit(limit)) => speed(limit),
        Some(SignMeaning::LeastSpeed(least)) => format!("at least {}", speed(least)),
        Some(SignMeaning::Words(words)) => words.into(),
        None => {
            let number = visible(&element.id);
            format!(
                "sign {}",
                number.chars().take(MAX_NUMBER_LETTERS).collect::<String>()
            )
        }
    });
    let all: Vec<String> = all.collect();
    (!all.is_empty()).then(|| all.join(", "))
}

/// The cycle of the moment, if it is to be seen.
fn cycle<'a>(model: &Model, moment: &Moment<'a>) -> Option<&'a CycleShown> {
    moment.cycle().filter(|_| model.map.layers.planner)
}

/// The fan, where it is shown: candidates that can be driven, over the rejected ones.
pub fn fan<'a>(model: &Model, moment: &Moment<'a>) -> impl Iterator<Item = Overlay> + use<'a> {
    let cycle = cycle(model, moment).filter(|_| model.map.layers.candidates);
    let lines = cycle.into_iter().flat_map(|cycle| cycle.fan.lines());
    lines.map(|(line, drivable)| {
        if drivable {
            Overlay::path(Role::Feasible, LineStyle::Solid, line)
        } else {
            Overlay::path(Role::Rejected, LineStyle::Dotted, line)
        }
    })
}

/// Where the recorded ego went and where it is, predicted bodies, and above them what was chosen.
pub fn overlays(model: &Model, moment: &Moment<'_>) -> Vec<Overlay> {
    let mut found = Vec::new();
    if let Some(scene) = moment.recorded().filter(|_| model.map.layers.planner) {
        let way = scene
            .ego
            .track
            .iter()
            .map(|(_, m)| m.pose.position)
            .collect();
        found.push(Overlay::path(Role::RecordedEgo, LineStyle::Dashed, way));
        found.extend(scene.ego_at(moment.step).map(|body| {
            Overlay::Outline(Outline {
                role: Role::RecordedEgo,
                faint: false,
                rings: body.outlines(),
                name: Some("ego recorded".into()),
            })
        }));
    }
    if let Some(cycle) = cycle(model, moment) {
        let foreseen = cycle
            .foreseen
            .iter()
            .filter(|_| model.map.layers.candidates);
        found.extend(foreseen.map(|body| {
            Overlay::Outline(Outline {
                role: Role::PredictedBody,
                faint: !body.avoided,
                rings: vec![body.corners.to_vec()],
                name: None,
            })
        }));
        let chosen = cycle.chosen.clone();
        found.push(Overlay::path(Role::Ego, LineStyle::Thick, chosen));
    }
    found
}

/// The full seconds on what was chosen.
pub fn seconds(board: &mut LabelPlacer<'_>, model: &Model, moment: &Moment<'_>, view: &CellView) {
    let Some(cycle) = cycle(model, moment) else {
        return;
    };
    let style = Style::new()
        .fg(model.theme.ego)
        .add_modifier(Modifier::BOLD);
    let places = cycle.chosen.iter().step_by(cycle.second).skip(1);
    for (place, second) in places.zip(1..10) {
        board.put_if_apart(view.at(place), &format!("{second} s"), style);
    }
}

/// Marks the end of a constant-velocity path.
const STRAIGHT: &str = "x";
/// Characters along such a path that has room for it.
const STRAIGHT_FROM: f64 = 4.5;

/// Predicted courses dashed, the way straight on dotted.
pub fn predictions(model: &Model, moment: &Moment<'_>) -> Vec<Overlay> {
    let mut found = Vec::new();
    for future in &moment.foresight.futures {
        let role = role(model, future.who);
        let courses = future.courses.iter().map(|(_, course)| course);
        found.extend(courses.map(|c| Overlay::path(role, LineStyle::Dashed, c.clone())));
        let straight = future.straight.clone();
        found.push(Overlay::path(
            Role::ConstantVelocity,
            LineStyle::Dotted,
            straight,
        ));
    }
    found
}

/// How likely each course of the picked obstacle is, and where the ways straight on end.
pub fn ends(board: &mut LabelPlacer<'_>, model: &Model, moment: &Moment<'_>, view: &CellView) {
    let alone = model.map.layers.paths == Foreseen::Picked;
    for future in &moment.foresight.futures {
        let style = Style::new()
            .fg(super::look(model).color(Role::ConstantVelocity))
            .add_modifier(Modifier::BOLD);
        if let [first, .., end] = future.straight.as_slice()
            && (end - first).norm() > STRAIGHT_FROM * view.cell.0
        {
            board.put_if_free(view.at(end), STRAIGHT, style);
        }
        if !(alone
            || model
                .picked
                .is_some_and(|id| future.who == On::Obstacle(id)))
        {
            continue;
        }
        let style = Style::new().fg(super::look(model).color(role(model, future.who)));
        for (weight, course) in &future.courses {
            // Its end, or where it leaves the map.
            let end: Option<&Point> = course.iter().rfind(|p| view.sees_point(p));
            if let Some(end) = end {
                board.beside_point(view.at(end), &format!("{:.0}%", weight * 100.0), style);
            }
        }
    }
}

fn role(model: &Model, who: On) -> Role {
    match who {
        On::Ego => Role::Ego,
        On::Obstacle(id) if model.picked == Some(id) => Role::Highlighted(0),
        On::Obstacle(_) => Role::Prediction,
    }
}

/// Lanelets of a goal that are named.
const MAX_NAMED_LANELETS: usize = 3;

/// Labels of goals: lanelets, times, speeds.
pub fn labels(board: &mut LabelPlacer<'_>, model: &Model, opened: &Opened, view: &CellView) {
    if !model.map.layers.goal {
        return;
    }
    let dt = opened.scenario.dt();
    let style = Style::new()
        .fg(model.theme.safe)
        .add_modifier(Modifier::BOLD);
    let problems = opened.scenario.planning_problems.iter();
    for goal in problems.flat_map(|p| &p.goals) {
        let Some(at) = place(opened, goal, view) else {
            continue;
        };
        let corners = corners(goal, view);
        let region = Body::around(corners.iter().copied()).map(|around| board.cells(&around));
        // Where vehicles hide its middle, beside a corner.
        let spots: Vec<(f64, f64)> = std::iter::once(view.at(&at)).chain(corners).collect();
        // All of it where there is room, else when, else at least that it is a goal.
        let (all, when) = (
            goal_label(goal, dt),
            format!("goal {}", goal_seconds(goal, dt)),
        );
        let texts = [all.as_str(), &when, "goal"];
        let texts = texts.map(|text| if board.has_room(text) { text } else { "" });
        if region.is_some_and(|region| board.beside(&region, &texts, style)) {
            continue;
        }
        let mut texts = texts.into_iter().filter(|text| !text.is_empty());
        texts.any(|text| {
            let mut spots = spots.iter();
            spots.any(|at| board.beside_point(*at, text, style))
        });
    }
}

/// The corners of the regions of a goal, those to be seen.
fn corners(goal: &Goal, view: &CellView) -> Vec<(f64, f64)> {
    let regions = goal.positions.iter().filter_map(|position| match position {
        Position::Region(region) => Some(region.outlines()),
        Position::Point(_) | Position::Lanelets(_) => None,
    });
    let points = regions.flatten().flatten();
    points
        .filter(|p| view.sees_point(p))
        .map(|p| view.at(&p))
        .collect()
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
fn goal_seconds(goal: &Goal, dt: f64) -> String {
    let seconds = |step: i64| step as f64 * dt;
    let (from, to) = (seconds(goal.time.from), seconds(goal.time.to));
    if goal.time.from == goal.time.to {
        format!("{from:.1} s")
    } else {
        format!("{from:.1}-{to:.1} s")
    }
}

/// Describes a goal.
pub fn goal_label(goal: &Goal, dt: f64) -> String {
    let mut words = vec!["goal".to_string()];
    let lanelets = goal.lanelets();
    if !lanelets.is_empty() {
        let ids: Vec<String> = lanelets
            .iter()
            .take(MAX_NAMED_LANELETS)
            .map(i64::to_string)
            .collect();
        let more = if lanelets.len() > MAX_NAMED_LANELETS {
            " …"
        } else {
            ""
        };
        let plural = if lanelets.len() > 1 { "s" } else { "" };
        words.push(format!("lanelet{plural} {}{more}", ids.join(" ")));
    }
    let (from, to) = (goal.time.from, goal.time.to);
    let seconds = goal_seconds(goal, dt);
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

/// The line between the two ends.
pub fn line(model: &Model, moment: &Moment<'_>) -> Option<Overlay> {
    let measured = moment.measured(model.map.tape.as_ref()?);
    let (from, to) = measured.gap.ends;
    Some(Overlay::path(Role::Tape, LineStyle::Solid, vec![from, to]))
}

/// The two ends, where they are.
pub fn tape_ends(board: &mut LabelPlacer<'_>, model: &Model, moment: &Moment<'_>, view: &CellView) {
    let Some(tape) = &model.map.tape else {
        return;
    };
    let (from, to) = moment.measured(tape).gap.ends;
    board.put(view.at(&from), "+", style(model));
    // The end that keys move.
    board.put(view.at(&to), "#", style(model));
}

fn style(model: &Model) -> Style {
    Style::new()
        .fg(model.theme.accent)
        .add_modifier(Modifier::BOLD)
}

/// The measurement, as much as fits beside its middle, or beside its end.
pub fn label(board: &mut LabelPlacer<'_>, model: &Model, moment: &Moment<'_>, view: &CellView) {
    let Some(tape) = &model.map.tape else {
        return;
    };
    let measured = moment.measured(tape);
    let (from, to) = measured.gap.ends;
    let places = [view.at(&nalgebra::center(&from, &to)), view.at(&to)];
    let all = tape_label(tape, &measured);
    for count in (1..=all.len()).rev() {
        let words = all[..count].join(" · ");
        for place in places {
            if board.beside_point(place, &words, style(model)) {
                return;
            }
        }
    }
}

/// The length, what it was taken between, and the time that the ego needs for it; the most telling first.
fn tape_label(tape: &Tape, measured: &Measurement) -> Vec<String> {
    let mut words = vec![format!("{} m", hundredths(measured.gap.metres))];
    if let (Some(seconds), Some(speed)) = (measured.seconds, measured.speed) {
        words.push(format!("{seconds:.1} s at the ego's {speed:.1} m/s"));
    }
    if measured.bodies > 0 {
        let name = |on: Option<On>| match on {
            Some(On::Ego) => "ego".to_string(),
            Some(On::Obstacle(id)) => id.to_string(),
            None => "point".to_string(),
        };
        words.push(format!("{} to {}", name(tape.from.on), name(tape.to.on)));
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_scene::scenario::{Quantity, SignElement, Steps};

    fn sign(elements: &[(&str, &str)]) -> Sign {
        let element = |(id, value): &(&str, &str)| SignElement {
            id: (*id).into(),
            values: vec![(*value).into()],
        };
        Sign {
            id: 1,
            elements: elements.iter().map(element).collect(),
            position: None,
            is_virtual: false,
        }
    }

    #[test]
    fn posts_are_read_in_the_units_of_their_country() {
        let read = |elements: &[(&str, &str)]| sign_label(&sign(elements));
        assert_eq!(
            read(&[("274", "22.2222"), ("276", "")]).as_deref(),
            Some("80 km/h, no overtaking")
        );
        assert_eq!(read(&[("R2-1", "15.6464")]).as_deref(), Some("35 mph"));
        assert_eq!(read(&[("\u{1b}[2J9", "")]).as_deref(), Some("sign ␛[2J9"));
        assert_eq!(read(&[]), None);
    }

    #[test]
    fn a_goal_says_where_when_and_how_fast() {
        let mut goal = Goal {
            time: Steps { from: 40, to: 60 },
            positions: vec![Position::Lanelets(vec![12, 13])],
            orientation: None,
            velocity: Some(Quantity::Interval(5.0, 8.5)),
        };
        assert_eq!(
            goal_label(&goal, 0.1),
            "goal · lanelets 12 13 · steps 40-60 (4.0-6.0 s) · 5.0-8.5 m/s"
        );
        goal.time = Steps::exact(30);
        goal.positions.clear();
        goal.velocity = None;
        assert_eq!(goal_label(&goal, 0.2), "goal · step 30 (6.0 s)");
        assert_eq!(goal_seconds(&goal, 0.2), "6.0 s");
    }
}
