//! The planning cycle at the cursor, in a panel at the right that keeps the map in view.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Text};

use crate::action::Action;
use crate::features::{Screen, Step, moves_scene};
use crate::loaded::{CycleShown, PlannedEgo};
use crate::model::{Model, forecast_words};
use crate::theme::Theme;
use crate::widgets::hints::{self, Hint};
use crate::widgets::row::{self, Lines};
use crate::widgets::window;
use crate::widgets::words::{duration, hundredths};
use nearmiss_drive::planner::{Emergency, occupancy_sets};
use nearmiss_drive::simulation::ExternalReport;
use nearmiss_scene::description::visible;
use nearmiss_scene::traffic_rules::RuleStatus;

/// The planner's cycle at the cursor.
#[derive(Debug, Default)]
pub struct CycleScreen {
    scroll: usize,
}

/// Opens the window, where the ego was planned.
pub fn open(model: &mut Model) {
    if model.planned().is_none() {
        let why = model.unplanned();
        return model.say(why);
    }
    model.screens.open(CycleScreen::default());
}

impl Screen for CycleScreen {
    fn on_action(&mut self, _model: &mut Model, action: Action) -> Step {
        match action {
            Action::PlannerCycle => Step::close(),
            Action::Play
            | Action::PlotDrives
            | Action::NextForecast
            | Action::NextPlanner
            | Action::SaveDrive
            | Action::Palette => Step::Perform(action),
            _ if moves_scene(action) => Step::Perform(action),
            _ => Step::Ignored,
        }
    }

    fn scroll_mut(&mut self) -> Option<&mut usize> {
        Some(&mut self.scroll)
    }

    fn columns_at_right(&self, screen: Rect) -> Option<u16> {
        Some(row::width(screen))
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let width = row::width(screen);
        let text = match model.planned().zip(model.cycle()) {
            Some((planned, cycle)) => text(model, planned, cycle, usize::from(width).max(2) - 2),
            None => Text::styled(without(model), Style::new().fg(model.theme.dim)),
        };
        window::at_right(
            frame,
            screen,
            model,
            "the planner",
            text,
            width,
            self.scroll,
        );
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let mut hints = vec![hints::steps(model, "cycle"), hints::scroll(model)];
        hints.push(hints::close(model));
        hints.extend(hints::hint_of(model, Action::NextForecast));
        hints.extend(hints::hint_of(model, Action::PlotDrives));
        hints
    }
}

fn without(model: &Model) -> String {
    match model.planned() {
        None => {
            let key = model.look.key(Action::DrivePlanner);
            format!("the ego was not planned: {key} lets the planner drive")
        }
        Some(_) => "nothing planned up to this step".into(),
    }
}

fn text(model: &Model, planned: &PlannedEgo, cycle: &CycleShown, width: usize) -> Text<'static> {
    let theme = &model.theme;
    let mut lines = Lines::new(theme, width);
    lines.title("the drive");
    lines.say("ended", &planned.ended());
    let forecast = forecast_words(planned.forecast);
    lines.say("prediction", forecast.trim_start_matches("predictions "));
    lines.say("cycles", &planned.cycles.len().to_string());
    rules(&mut lines, planned, model);
    if let Some(beyond) = &planned.beyond {
        lines.say_in(
            "vehicle",
            &beyond.to_string(),
            Style::new().fg(theme.warning),
        );
    }
    if let Some(process) = &planned.process {
        external(&mut lines, process, theme);
    }
    if let Some(words) = model
        .opened
        .as_ref()
        .and_then(|o| occupancy_sets(&o.scenario))
    {
        lines.say_in("sets", &words, Style::new().fg(theme.warning));
    }
    let dt = model.opened.as_ref().map_or(0.0, |o| o.scenario.dt());
    let time = cycle.step as f64 * dt;
    lines.title(&format!("planned at {time:.1} s, step {}", cycle.step));
    if let Some(emergency) = cycle.emergency {
        let words = match emergency {
            Emergency::LatestContact => "! no feasible candidate: taking the latest contact",
            Emergency::Braking => "! no feasible candidate: braking along the path",
        };
        let style = Style::new().fg(theme.danger).add_modifier(Modifier::BOLD);
        lines.say_in("emergency", words, style);
    }
    let (now, end) = cycle.speeds;
    let speed = hundredths;
    lines.say(
        "speed",
        &format!("{} m/s, at the end {}", speed(now), speed(end)),
    );
    if planned.process.is_none() {
        lines.say("wanted", &format!("{} m/s", speed(cycle.wanted)));
    }
    if let Some(hold) = cycle.hold {
        let words = format!(
            "{}, {} m ahead",
            hold.rule.text(),
            hundredths(hold.distance)
        );
        lines.say_in("stops for", &words, Style::new().fg(theme.warning));
    }
    lines.say("took", &took(cycle));
    if planned.process.is_none() {
        candidates(&mut lines, cycle);
        costs(&mut lines, cycle);
    }
    lines.title("the drive is kept");
    let kept = kept(model);
    lines.text.lines.extend(
        textwrap::wrap(&kept, width.max(8))
            .into_iter()
            .map(|l| Line::raw(l.into_owned())),
    );
    lines.text
}

/// The rules of the road that the drive breaks, each with its first violation; else how many it obeys.
fn rules(lines: &mut Lines, planned: &PlannedEgo, model: &Model) {
    let dt = model.opened.as_ref().map_or(0.0, |o| o.scenario.dt());
    let findings = &planned.rules.findings;
    let broken = findings
        .iter()
        .filter_map(|f| Some((f.rule, f.violations.first()?)));
    let mut any = false;
    for (rule, first) in broken {
        any = true;
        let words = format!(
            "{} broken at {:.1} s by {} {}",
            rule.text(),
            first.from as f64 * dt,
            hundredths(first.amount),
            rule.unit()
        );
        lines.say_in("rules", &words, Style::new().fg(model.theme.warning));
    }
    let count = |status| findings.iter().filter(|f| f.status == status).count();
    let undecided = match count(RuleStatus::Undecided) {
        0 => String::new(),
        n => format!(", {n} undecided"),
    };
    let obeyed = count(RuleStatus::Obeyed);
    if !any {
        lines.say("rules", &format!("{obeyed} obeyed{undecided}"));
    }
}

/// What is known of a planner's process.
fn external(lines: &mut Lines, process: &ExternalReport, theme: &Theme) {
    lines.say(
        "planner",
        &visible(&format!("{} {}", process.name, process.version)),
    );
    let words = if process.predictions {
        "sent"
    } else {
        "not asked for"
    };
    lines.say("predictions", words);
    let style = Style::new().fg(theme.danger);
    if let Some(fault) = process.fault_in_words().or(process.message.clone()) {
        lines.say_in("message", &visible(&fault), style);
    }
    for line in process.stderr.iter().rev().take(STDERR_LINES).rev() {
        lines.say("stderr", &visible(line));
    }
}

/// Lines of standard error that are shown.
const STDERR_LINES: usize = 5;

/// Where the drive is, and for how long.
fn kept(model: &Model) -> String {
    let key = model.opened.as_ref().and_then(|opened| opened.drive_key());
    let drive = key.and_then(|key| model.driver.kept.find(key));
    match drive.and_then(|drive| drive.saved.as_deref()) {
        Some(files) => format!("in {}", visible(files)),
        None => {
            let key = model.look.key(Action::SaveDrive);
            format!("until you quit; {key} writes it")
        }
    }
}

fn took(cycle: &CycleShown) -> String {
    let again = match cycle.refinements {
        0 => String::new(),
        1 => ", refined once".into(),
        n => format!(", refined {n} times"),
    };
    let took = cycle.took;
    let ms = took.as_secs_f64() * 1e3;
    if ms < 100.0 {
        return format!("{ms:.1} ms{again}");
    }
    let ms = u64::try_from(took.as_millis()).unwrap_or(u64::MAX);
    format!("{}{again}", duration(ms))
}

fn candidates(lines: &mut Lines, cycle: &CycleShown) {
    lines.title(&format!(
        "{} candidates, {} on the map",
        cycle.candidates,
        cycle.fan.count()
    ));
    let of = cycle.candidates.max(1) as f64;
    let mut row = |name: &str, count: usize| lines.bar(name, &count.to_string(), count as f64 / of);
    row("drivable", cycle.feasible);
    for (why, count) in &cycle.rejected {
        row(why, *count);
    }
}

fn costs(lines: &mut Lines, cycle: &CycleShown) {
    if cycle.emergency == Some(Emergency::Braking) {
        return;
    }
    let total = cycle.cost.total();
    lines.title(&format!("cost of the chosen plan: {}", hundredths(total)));
    for (name, value) in cycle.cost.terms() {
        let share = if total > 0.0 { value / total } else { 0.0 };
        lines.bar(name, &hundredths(value), share);
    }
}
