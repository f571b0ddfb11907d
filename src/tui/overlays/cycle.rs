//! What the planner saw and chose at the cursor, at the right, so that the map stays in sight.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};

use crate::planner::{Emergency, unavoided};
use crate::text::visible;
use crate::tui::action::Action;
use crate::tui::loaded::{CycleShown, Planned};
use crate::tui::model::{Model, forecast_words};
use crate::tui::theme::Theme;
use crate::tui::widgets::words::{duration, hundredths, pad};

/// Columns of the window at most, its borders included.
const COLUMNS: u16 = 54;

/// Columns before what is said about a word.
const INDENT: usize = 11;

/// Columns before a number with a bar.
const NUMBERS: usize = 18;

/// Columns of the longest bar.
const BAR: usize = 12;

/// Columns of the window: on a narrow screen the map has the left half.
pub fn width(screen: Rect) -> u16 {
    COLUMNS.min(screen.width * 48 / 100).min(screen.width)
}

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model, scroll: usize) {
    let width = width(screen);
    let text = match model.planned().zip(model.cycle()) {
        Some((planned, cycle)) => text(model, planned, cycle, usize::from(width).max(2) - 2),
        None => Text::styled(without(model), Style::new().fg(model.theme.dim)),
    };
    let lines = u16::try_from(text.lines.len()).unwrap_or(u16::MAX);
    let height = screen.height.saturating_sub(2);
    let area = Rect {
        x: screen.right() - width,
        y: screen.y + 1.min(screen.height),
        width,
        height: height.min(lines.saturating_add(2).max(6)),
    };
    let inner = super::window_at(frame, area, model, "the planner");
    super::text_in(frame, inner, text, scroll);
}

fn without(model: &Model) -> String {
    match model.planned() {
        None => {
            let key = model.look.key(Action::DrivePlanner);
            format!("the ego was not planned: {key} lets the planner drive")
        }
        Some(_) => "nothing was planned until this step".into(),
    }
}

/// Names with what is said about them, under titles.
pub struct Lines {
    pub text: Text<'static>,
    word: Style,
    title: Style,
    pub width: usize,
}

impl Lines {
    /// None yet, in so many columns.
    pub fn new(theme: &Theme, width: usize) -> Self {
        Self {
            text: Text::default(),
            word: Style::new().fg(theme.accent),
            title: Style::new().fg(theme.ego).add_modifier(Modifier::BOLD),
            width,
        }
    }

    pub fn title(&mut self, words: &str) {
        if !self.text.lines.is_empty() {
            self.text.push_line("");
        }
        self.text
            .push_line(Line::styled(words.to_string(), self.title));
    }

    pub fn say(&mut self, name: &str, said: &str) {
        self.say_in(name, said, Style::new());
    }

    pub fn say_in(&mut self, name: &str, said: &str, style: Style) {
        let room = self.width.saturating_sub(INDENT).max(8);
        let mut lines = textwrap::wrap(said, room).into_iter();
        self.text.push_line(Line::from(vec![
            Span::styled(pad(name, INDENT), self.word),
            Span::styled(lines.next().unwrap_or_default().into_owned(), style),
        ]));
        for more in lines {
            let line = format!("{:INDENT$}{more}", "");
            self.text.push_line(Line::styled(line, style));
        }
    }

    /// A number, and a bar for its share of the largest one.
    pub fn bar(&mut self, name: &str, number: &str, share: f64) {
        let cells = (share * BAR as f64).round().clamp(0.0, BAR as f64) as usize;
        let room = self.width.saturating_sub(NUMBERS + 9);
        let bar = "━".repeat(cells.min(room));
        self.text.push_line(Line::from(vec![
            Span::styled(pad(&format!("  {name}"), NUMBERS), self.word),
            Span::raw(format!("{number:>8} ")),
            Span::styled(bar, self.word),
        ]));
    }
}

fn text(model: &Model, planned: &Planned, cycle: &CycleShown, width: usize) -> Text<'static> {
    let theme = &model.theme;
    let mut lines = Lines::new(theme, width);
    lines.title("the drive");
    lines.say("ended", &planned.outcome.to_string());
    lines.say("was told", forecast_words(planned.forecast));
    lines.say("cycles", &planned.cycles.len().to_string());
    if let Some(words) = model.opened.as_ref().and_then(|o| unavoided(&o.scenario)) {
        lines.say_in("not seen", &words, Style::new().fg(theme.warning));
    }
    let dt = model.opened.as_ref().map_or(0.0, |o| o.scenario.dt());
    let time = cycle.step as f64 * dt;
    lines.title(&format!("planned at {time:.1} s, step {}", cycle.step));
    if let Some(emergency) = cycle.emergency {
        let words = match emergency {
            Emergency::LatestContact => "! nothing can be driven: what touches somebody last",
            Emergency::Braking => "! nothing can be driven: braking along the path",
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
    lines.say("wanted", &format!("{} m/s", speed(cycle.wanted)));
    lines.say("took", &took(cycle));
    candidates(&mut lines, cycle);
    costs(&mut lines, cycle);
    lines.title("the drive is kept");
    let kept = kept(model);
    lines.text.lines.extend(
        textwrap::wrap(&kept, width.max(8))
            .into_iter()
            .map(|l| Line::raw(l.into_owned())),
    );
    lines.text
}

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
    lines.title(&format!("cost of the chosen one: {}", hundredths(total)));
    for (name, value) in cycle.cost.terms() {
        let share = if total > 0.0 { value / total } else { 0.0 };
        lines.bar(name, &hundredths(value), share);
    }
}
