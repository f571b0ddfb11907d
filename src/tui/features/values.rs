//! All measures of the scene and of the picked obstacle at the current step, with the thresholds they are compared with.
//!
//! The thresholds in use, and the source of each.

use std::sync::Arc;

use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::{
    LIMITS, Reading, SCENE_MEASURES, Threshold, Thresholds, measure, measures,
};
use nearmiss_scene::scenario::Scene;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Text};

use crate::action::Action;
use crate::features::scenarios::request::{Survey, ranking};
use crate::features::{Screen, Step, moves_scene, planner};
use crate::loaded::Measured;
use crate::message::Effect;
use crate::model::{MeasureId, Model};
use crate::request::{Computation, Replies, Request};
use crate::services::Services;
use crate::update::open_again;
use crate::widgets::hints::{self, Hint};
use crate::widgets::words::quantity;
use crate::widgets::{row, unbroken, window};

/// Columns of the window at most, its borders included.
const COLUMNS: u16 = 132;

/// Columns of the sign and of the name of a measure.
const NAME: usize = 18;

/// Columns of a value with its unit.
const VALUE: usize = 13;

/// Columns of thresholds.
const LIMIT: usize = 22;

/// Every measure at the current step.
#[derive(Debug, Default)]
pub struct ValuesScreen {
    scroll: usize,
}

impl Screen for ValuesScreen {
    fn on_action(&mut self, _model: &mut Model, action: Action) -> Step {
        if moves_scene(action) {
            Step::Perform(action)
        } else {
            Step::Ignored
        }
    }

    fn follow(&mut self, model: &mut Model) -> Vec<Effect> {
        measure_picked(model).into_iter().collect()
    }

    fn scroll_mut(&mut self) -> Option<&mut usize> {
        Some(&mut self.scroll)
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let who = model
            .picked
            .map_or("no obstacle".to_string(), |id| id.to_string());
        let (time, step) = (model.clock.time(), model.clock.step());
        let title = format!("values of {who} at {time:.1} s, step {step}");
        let width = window::width_in(screen, COLUMNS);
        let text = text(model, width);
        window::scrolled_in(frame, screen, model, &title, text, COLUMNS, self.scroll);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let mut hints = vec![hints::steps(model, "step")];
        hints.extend(hints::hint_of(model, Action::NextObstacle));
        hints.extend([
            hints::scroll(model),
            hints::close(model),
            hints::page(model),
        ]);
        hints.extend(hints::hint_of(model, Action::CollisionStep));
        hints.extend(hints::hint_of(model, Action::MinimumStep));
        hints
    }
}

/// Asks for the values that are shown, if they are not known and not on their way.
fn measure_picked(model: &mut Model) -> Option<Effect> {
    let asked = model.values.asked.map(|(_, obstacle)| obstacle);
    if asked == Some(model.picked) {
        return None;
    }
    let scene = model.opened.as_ref()?.scene.clone()?;
    let id = MeasureId(model.new_id());
    model.values.asked = Some((id, model.picked));
    let thresholds = model.thresholds.clone();
    let measure = MeasureAll {
        id,
        scene,
        obstacle: model.picked,
        thresholds,
    };
    Some(measure.into())
}

fn text(model: &Model, width: usize) -> Text<'static> {
    let mut text = Text::default();
    let theme = &model.theme;
    let title = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
    let dim = Style::new().fg(theme.dim);
    match (model.scene(), model.values.for_obstacle(model.picked)) {
        (None, _) => {
            text.push_line(Line::styled(
                format!("no values: {}", model.without_ego()),
                dim,
            ));
        }
        (Some(_), None) => text.push_line(Line::styled("computing…", dim)),
        (Some(_), Some(found)) => {
            text.push_line(Line::styled("ego and all obstacles", title));
            text.extend(scene(model, found, width));
            text.push_line("");
            text.push_line(Line::styled(obstacle_title(model), title));
            text.extend(obstacle(model, found, width));
        }
    }
    text.push_line("");
    text.extend(thresholds_text(model, width));
    text
}

fn obstacle_title(model: &Model) -> String {
    let opened = model.opened.as_ref().zip(model.picked);
    let found = opened.and_then(|(opened, id)| {
        let mut all = opened.scenario.obstacles.iter();
        all.find(|o| o.id == id)
    });
    match found {
        Some(obstacle) => format!("{} {}", obstacle.kind.words(), obstacle.id),
        None => {
            let key = model.look.key(Action::NextObstacle);
            format!("no obstacle picked; {key} picks one")
        }
    }
}

fn scene(model: &Model, found: &Measured, width: usize) -> Vec<Line<'static>> {
    let step = model.clock.step();
    let readings = found.scene_at(step).unwrap_or_default();
    let rows = SCENE_MEASURES
        .iter()
        .zip(readings)
        .flat_map(|(m, reading)| line(model, m.id, m.unit, m.source, reading, width));
    rows.collect()
}

fn obstacle(model: &Model, found: &Measured, width: usize) -> Vec<Line<'static>> {
    let Some(id) = found.obstacle else {
        return Vec::new();
    };
    let at = |measure: &str| found.series.at(measure, id, model.clock.step());
    let rows = measures().flat_map(|m| line(model, m.id, m.unit, m.source, at(m.id), width));
    rows.collect()
}

/// A measure: a sign and its name, its value or why there is none, its thresholds, its source.
fn line(
    model: &Model,
    id: &str,
    unit: &str,
    source: &str,
    reading: Reading,
    width: usize,
) -> Vec<Line<'static>> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let reached = |value: f64| {
        let measure = measure(id)?;
        model.thresholds.reached(measure, value)
    };
    let cells = match reading {
        Reading::None(why) => vec![
            (format!("  {id}"), NAME, dim),
            (format!("– {}", why.reason()), VALUE + LIMIT, dim),
        ],
        Reading::Value(value) => {
            let (sign, style, limit) = match reached(value) {
                Some(threshold) => {
                    let danger = Style::new().fg(theme.danger).add_modifier(Modifier::BOLD);
                    (
                        "!",
                        danger,
                        (threshold_label(threshold, unit), LIMIT, danger),
                    )
                }
                None => (" ", Style::new(), (nearest(model, id, unit), LIMIT, dim)),
            };
            vec![
                (format!("{sign} {id}"), NAME, style),
                (quantity(value, unit), VALUE, style),
                limit,
            ]
        }
    };
    row::lines(&cells, (source, dim), width)
}

/// The threshold that a value that is not dangerous would reach first.
fn nearest(model: &Model, id: &str, unit: &str) -> String {
    let last = model.thresholds.for_measure(id).last();
    last.map_or(String::new(), |t| threshold_label(t, unit))
}

fn threshold_label(threshold: &Threshold, unit: &str) -> String {
    let own = if threshold.own { "*" } else { "" };
    let value = quantity(threshold.value, unit);
    format!("{} {value}{own}", threshold.name)
}

/// Every measure of an obstacle, if one is picked, and of the scene.
#[derive(Debug)]
pub struct MeasureAll {
    /// Its number.
    pub id: MeasureId,
    /// The scene.
    pub scene: Arc<Scene>,
    /// The obstacle.
    pub obstacle: Option<i64>,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
}

impl Computation for MeasureAll {
    type Value = (MeasureId, Box<Measured>);

    fn compute(self) -> Self::Value {
        let measured = Measured::new(&self.scene, self.obstacle, &self.thresholds);
        (self.id, Box::new(measured))
    }

    fn take(model: &mut Model, (id, measured): Self::Value) {
        if model.values.asked.is_some_and(|(asked, _)| asked == id) {
            model.values.found = Some(measured);
        }
    }
}

/// Columns of what is limited, in a narrow window and in a wide one.
const THRESHOLD_NAME: [usize; 2] = [28, 40];

/// Columns of a value with its unit.
const THRESHOLD_VALUE: usize = 18;

fn thresholds_text(model: &Model, width: usize) -> Vec<Line<'static>> {
    let name_width = THRESHOLD_NAME[usize::from(width > 100)];
    let theme = &model.theme;
    let thresholds = &model.thresholds;
    let title = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
    let dim = Style::new().fg(theme.dim);
    let from = match thresholds.file() {
        None => "shipped values; to change them, write thresholds.toml in the configuration folder"
            .to_string(),
        Some(file) => format!("* from {}, the others shipped", visible(file)),
    };
    let mut lines = Vec::new();
    let mut part = |name: &str, rows: Vec<(String, String, bool, String)>| {
        lines.push(Line::styled(name.to_string(), title));
        for (name, value, own, source) in rows {
            let (sign, style) = if own {
                ("* ", Style::new().fg(theme.accent))
            } else {
                ("  ", Style::new())
            };
            let cells = [
                (format!("{sign}{name}"), name_width, style),
                (value, THRESHOLD_VALUE, style),
            ];
            lines.extend(row::lines(&cells, (&source, dim), width));
        }
    };
    part("thresholds", critical(thresholds));
    part("risk scores, up to", levels(thresholds));
    part("limits used by the measures", limits(thresholds));
    let place = 1;
    for wrapped in unbroken::wrap(&from, width.saturating_sub(2).max(10))
        .iter()
        .rev()
    {
        lines.insert(place, Line::styled(format!("  {wrapped}"), dim));
    }
    lines
}

fn critical(thresholds: &Thresholds) -> Vec<(String, String, bool, String)> {
    let rows = measures().flat_map(|measure| {
        thresholds.for_measure(measure.id).map(|t| {
            let name = format!("{} {}", measure.id, t.name);
            (
                name,
                quantity(t.value, measure.unit),
                t.own,
                t.source.clone(),
            )
        })
    });
    rows.collect()
}

fn levels(thresholds: &Thresholds) -> Vec<(String, String, bool, String)> {
    let risk = &thresholds.risk;
    let rows = risk.levels.iter().map(|level| {
        let bounds = match (level.distance, level.time) {
            (Some(d), Some(t)) => format!("{}, {}", quantity(d, "m"), quantity(t, "s")),
            _ => "above".to_string(),
        };
        let name = format!("{} {}", level.score, level.name);
        let own = thresholds.own_level(level.score);
        let source = if own {
            String::new()
        } else {
            risk.source.clone()
        };
        (name, bounds, own, source)
    });
    rows.collect()
}

fn limits(thresholds: &Thresholds) -> Vec<(String, String, bool, String)> {
    let rows = LIMITS.iter().map(|limit| {
        let own = thresholds.own_limit(limit);
        let source = if own { "" } else { limit.source };
        let about = format!("{} ({})", limit.name, limit.measures.join(" "));
        let about = match source {
            "" => about,
            source => format!("{about} · {source}"),
        };
        let value = quantity(limit.value(&thresholds.limits), limit.unit);
        (limit.id.to_string(), value, own, about)
    });
    rows.collect()
}

/// Reads them again.
#[derive(Debug)]
pub struct ReadThresholds;

impl Request for ReadThresholds {
    /// They, or why they cannot be used.
    type Reply = Result<Arc<Thresholds>, String>;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let path = services.folders.thresholds();
        services.background(replies, move || {
            nearmiss_settings::read_thresholds(&path).map(Arc::new)
        });
    }

    /// Measures everything anew with other thresholds; those that cannot be used change nothing.
    fn reply(model: &mut Model, read: Self::Reply) -> Vec<Effect> {
        let thresholds = match read {
            Ok(thresholds) => thresholds,
            Err(error) => {
                model.complain(format!("{error}; the thresholds stay as they were"));
                return Vec::new();
            }
        };
        model.tell(match thresholds.file() {
            Some(file) => format!("{} entries of {file}", thresholds.changes().len()),
            None => "there is no thresholds.toml: the shipped thresholds are in use".into(),
        });
        model.thresholds = thresholds.clone();
        model.values = Values::default();
        model.driver.kept.forget();
        model.generation.forget();
        let survey = Survey::All(model.list.entries());
        let mut effects = vec![UseThresholds(thresholds).into(), survey.into()];
        model.list.forget_values();
        effects.extend(ranking(model));
        if let Some(place) = model.list.opened {
            effects.extend(if model.planned().is_some() {
                planner::again(model, place)
            } else {
                open_again(model, place, model.taken)
            });
        }
        effects
    }
}

/// Measures with these from now on.
#[derive(Debug)]
pub struct UseThresholds(pub Arc<Thresholds>);

impl Request for UseThresholds {
    type Reply = ();

    fn perform(self, services: &mut Services, _: Replies<Self>) {
        services.thresholds = self.0;
    }
}

/// The last request and its result.
#[derive(Debug, Default)]
pub struct Values {
    /// The last request, and about whom; `None` before the first one for a scene.
    pub asked: Option<(MeasureId, Option<i64>)>,
    /// The last result; it may be about the obstacle that was picked before.
    pub found: Option<Box<Measured>>,
}

impl Values {
    /// The values of this obstacle, if they are known.
    #[must_use]
    pub fn for_obstacle(&self, obstacle: Option<i64>) -> Option<&Measured> {
        self.found
            .as_deref()
            .filter(|found| found.obstacle == obstacle)
    }
}
