//! All measures of the scene and of the picked obstacle at the current step, with thresholds.

mod thresholds;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Text};

use super::{Screen, Step, moves_scene};
use crate::action::Action;
use crate::loaded::Measured;
use crate::message::Effect;
use crate::model::{MeasureId, Model};
use crate::request::Computation;
use crate::widgets::hints::{self, Hint};
use crate::widgets::words::quantity;
use crate::widgets::{row, window};
use nearmiss_scene::metrics::{MEASURES, Reading, SCENE_MEASURES, Threshold, Thresholds, measure};
use nearmiss_scene::scenario::Scene;
use std::sync::Arc;

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
                format!(
                    "no values without an ego: {} picks an obstacle, {} makes it the ego",
                    model.look.key(Action::NextObstacle),
                    model.look.key(Action::TakeAsEgo)
                ),
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
    text.extend(thresholds::text(model, width));
    text
}

fn obstacle_title(model: &Model) -> String {
    let opened = model.opened.as_ref().zip(model.picked);
    let found = opened.and_then(|(opened, id)| {
        let mut all = opened.scenario.obstacles.iter();
        all.find(|o| o.id == id)
    });
    match found {
        Some(obstacle) => format!("{} {}", obstacle.kind, obstacle.id),
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
    let rows = MEASURES
        .iter()
        .flat_map(|m| line(model, m.id, m.unit, m.source, at(m.id), width));
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
                    ("!", danger, (words(threshold, unit), LIMIT, danger))
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
    last.map_or(String::new(), |t| words(t, unit))
}

fn words(threshold: &Threshold, unit: &str) -> String {
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
