//! Drivers in the encounter with the picked obstacle: a line each, and the one that is shown with formula, source and
//! limits, in a panel beside the ego's drive and its own.

pub mod state;
pub mod strip;

use nearmiss_drive::driver::{DRIVERS, DriverOutcome, PreventabilityRecord, VerdictRecord};
use nearmiss_scene::description::visible;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Text};

use crate::action::Action;
use crate::features::generation::panel::VariantScreen;
use crate::features::{Screen, Step, moves_scene};
use crate::loaded::{DriverDrive, DriverSeat};
use crate::message::Effect;
use crate::model::{EncounterKey, EncounterToJudge, Model};
use crate::request::Computation;
use crate::widgets::hints::{self, Hint};
use crate::widgets::row::{self, Lines};
use crate::widgets::window;

/// Columns of a driver's line: sign and id, outcome, reaction, last moment.
const COLUMNS: [usize; 4] = [8, 16, 7, 5];

/// The drivers in an encounter.
#[derive(Debug, Default)]
pub struct DriversScreen {
    scroll: usize,
}

/// Opens the panel, where there is an encounter.
pub fn open(model: &mut Model) {
    match model.without_drivers() {
        Some(why) if model.encounter().is_none() => model.say(why),
        _ => model.screens.open(DriversScreen::default()),
    }
}

/// Shows the next driver.
pub fn next(model: &mut Model) {
    let times = usize::try_from(model.look.times()).unwrap_or(1);
    model.drivers.shown = (model.drivers.shown + times) % DRIVERS.len();
    let name = model.driver_shown().name;
    let said = model.judged().zip(model.verdict_shown());
    let words = said.map_or(String::new(), |(found, verdict)| {
        format!(": {}", outcome(found, verdict))
    });
    model.say(format!("{name}{words}"));
}

impl Screen for DriversScreen {
    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        let all = DRIVERS.len();
        match action {
            Action::Drivers => return Step::close(),
            Action::Up => model.drivers.shown = (model.drivers.shown + all - 1) % all,
            Action::Down => model.drivers.shown = (model.drivers.shown + 1) % all,
            Action::Play | Action::DriverMap | Action::NextDriver | Action::Palette => {
                return Step::Perform(action);
            }
            _ if moves_scene(action) => return Step::Perform(action),
            _ => return Step::Ignored,
        }
        Step::stay()
    }

    fn scroll_mut(&mut self) -> Option<&mut usize> {
        Some(&mut self.scroll)
    }

    fn columns_at_right(&self, screen: Rect) -> Option<u16> {
        Some(row::width(screen))
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let width = row::width(screen);
        let left = Rect {
            y: screen.y + 1.min(screen.height),
            width: screen.width - width,
            height: screen.height.saturating_sub(2),
            ..screen
        };
        if let Some(strip) = model.strip().filter(|_| strip::fits(left)) {
            strip::draw(frame, left, model, &strip);
        }
        let text = text(model, usize::from(width).max(2) - 2);
        window::at_right(frame, screen, model, "drivers", text, width, self.scroll);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let (keys, _) = hints::scroll(model);
        let mut hints = vec![(keys, "driver".into()), hints::steps(model, "step")];
        hints.extend(hints::hint_of(model, Action::NextObstacle));
        hints.push(hints::close(model));
        hints.push(hints::page(model));
        hints.extend(hints::hint_of(model, Action::DriverMap));
        hints
    }
}

fn text(model: &Model, width: usize) -> Text<'static> {
    let mut lines = Lines::new(&model.theme, width);
    let dim = Style::new().fg(model.theme.dim);
    if let Some(words) = model.encounter_words() {
        lines.title("the encounter");
        lines.plain(&words);
    }
    match (model.judged(), model.without_drivers()) {
        (_, Some(why)) => lines.plain(&why),
        (None, None) => lines.text.push_line(Line::styled("computing…", dim)),
        (Some(found), None) => {
            lines.plain(&found.words());
            lines.text.push_line("");
            let head = ["", "outcome", "reacts", "last"];
            let head: Vec<row::Cell> = { head.into_iter().zip(COLUMNS) }
                .map(|(words, columns)| (words.into(), columns, dim))
                .collect();
            lines.text.extend(row::lines(&head, ("", dim), width));
            for verdict in &found.drivers {
                lines.text.extend(line(model, found, verdict, width));
            }
            let legend = "closing speed of ego → driver; seconds before the encounter: its first reaction, its last moment to take over; behind: someone runs into it from behind";
            let legend = textwrap::wrap(legend, width.max(8)).into_iter();
            let legend = legend.map(|words| Line::styled(words.into_owned(), dim));
            lines.text.extend(legend);
        }
    }
    about(&mut lines, model);
    lines.text
}

/// A driver: what comes of it, when it reacts, and its last moment.
fn line(
    model: &Model,
    found: &PreventabilityRecord,
    verdict: &VerdictRecord,
    width: usize,
) -> Vec<Line<'static>> {
    let theme = &model.theme;
    let shown = verdict.driver == model.driver_shown().id;
    let (sign, style) = if shown {
        let bold = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
        ("▸", bold)
    } else {
        (" ", Style::new())
    };
    let color = match verdict.result {
        DriverOutcome::Avoided => theme.safe,
        DriverOutcome::Mitigated => theme.warning,
        DriverOutcome::NotAvoided => theme.danger,
        DriverOutcome::HitFromBehind | DriverOutcome::NotMadeFor => theme.dim,
    };
    let before = |step: Option<i64>| {
        let step = step.zip(model.encounter());
        step.map_or("–".into(), |(step, (opened, _))| {
            format!("{:.1}", (found.step - step) as f64 * opened.scenario.dt())
        })
    };
    let [name, outcomes, reacts, last] = COLUMNS;
    let what = outcome(found, verdict);
    let mut cells = vec![(format!("{sign} {}", verdict.driver), name, style)];
    let outcome_style = Style::new().fg(color);
    if verdict.not_made_for.is_some() {
        cells.push((what, outcomes + reacts + last, outcome_style));
    } else {
        cells.push((what, outcomes, outcome_style));
        cells.push((before(verdict.reacts_step), reacts, style));
        cells.push((before(verdict.last_moment_step), last, style));
    }
    row::lines(&cells, ("", style), width)
}

/// What comes of a driver: `avoided`, `10.0 → 5.2 m/s`, `not for curves`.
fn outcome(found: &PreventabilityRecord, verdict: &VerdictRecord) -> String {
    match (
        verdict.not_made_for,
        verdict.closing_speed,
        found.closing_speed,
    ) {
        (Some(what), ..) => format!("not for {}", what.words()),
        (None, None, _) => verdict.result.name().replace('_', " "),
        (None, Some(speed), _) if verdict.result == DriverOutcome::HitFromBehind => {
            format!("behind {speed:.1} m/s")
        }
        (None, Some(speed), Some(own)) => format!("{own:.1}→{speed:.1} m/s"),
        (None, Some(speed), None) => format!("hits {speed:.1} m/s"),
    }
}

/// The driver that is shown: formula, numbers, source and limits.
fn about(lines: &mut Lines, model: &Model) {
    let driver = model.driver_shown();
    lines.title(driver.name);
    if let Some((verdict, (opened, _))) = model.verdict_shown().zip(model.encounter()) {
        let dt = opened.scenario.dt();
        let when = |step: i64| format!("at {:.1} s, step {step}", step as f64 * dt);
        let moments = [
            ("reacts", verdict.reacts_step),
            ("last", verdict.last_moment_step),
        ];
        for (name, step) in moments {
            if let Some(step) = step {
                lines.say(name, &when(step));
            }
        }
    }
    lines.plain(driver.formula);
    for p in driver.parameters {
        let value = format!("{:.3}", p.value);
        let value = value.trim_end_matches('0').trim_end_matches('.');
        lines.say(p.symbol, &format!("{value} {}: {}", p.unit, p.what));
    }
    lines.say("source", driver.source);
    lines.say("limits", driver.limits);
    let kinds: Vec<&str> = driver
        .not_made_for
        .iter()
        .map(|kind| kind.words())
        .collect();
    if !kinds.is_empty() {
        lines.say("not for", &kinds.join(", "));
    }
}

/// Adds how many drivers avoid the encounter, and the key that tells more.
pub fn counted(lines: &mut Lines, model: &Model) {
    if let Some(found) = model.judged() {
        let key = model.look.key(Action::Drivers);
        lines.say(
            "drivers",
            &format!("{}; {key} tells more", visible(&found.words())),
        );
    }
}

/// What the encounter lacks: its verdicts, and the drive where one is shown.
pub fn request(model: &mut Model) -> Vec<Effect> {
    let judge = model.unjudged().map(JudgeEncounter);
    let mut effects: Vec<Effect> = judge.map(Effect::from).into_iter().collect();
    let screens = &model.screens;
    let in_strip =
        screens.find::<DriversScreen>().is_some() || screens.find::<VariantScreen>().is_some();
    if in_strip || (model.map.second.on && model.map.second.driver) {
        let drive = model.undriven();
        effects.extend(drive.map(|(key, seat)| Effect::from(TakeSeat { key, seat })));
    }
    effects
}

/// Asks all drivers about an encounter.
#[derive(Debug)]
pub struct JudgeEncounter(EncounterToJudge);

impl Computation for JudgeEncounter {
    type Value = (EncounterKey, PreventabilityRecord);

    fn compute(self) -> Self::Value {
        let EncounterToJudge { key, scene, .. } = self.0;
        let found = PreventabilityRecord::of(&scene, key.obstacle, key.step, self.0.is_certified);
        (key, found.unwrap_or_default())
    }

    fn take(model: &mut Model, (key, record): Self::Value) {
        model.drivers.take(&key, record);
    }
}

/// Puts a driver in the ego's seat.
#[derive(Debug)]
pub struct TakeSeat {
    key: EncounterKey,
    seat: DriverSeat,
}

impl Computation for TakeSeat {
    type Value = (EncounterKey, usize, Option<Box<DriverDrive>>);

    fn compute(self) -> Self::Value {
        let drive = self.seat.drive().map(Box::new);
        (self.key, self.seat.driver, drive)
    }

    fn take(model: &mut Model, (key, driver, drive): Self::Value) {
        model.drivers.take_drive(&key, driver, drive);
    }
}
