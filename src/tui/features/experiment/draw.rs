//! Draws an experiment: one column of text, or on wide screens what is asked beside what the file says.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::Paragraph;

use crate::action::{Action, Scope};
use crate::model::{ExperimentView, Job, JobState, Model};
use crate::widgets::window;
use crate::widgets::words::{fit, fit_end, pad};
use nearmiss_base::system::shown_path;
use nearmiss_scene::description::visible;
use nearmiss_store::SplitPart;
use nearmiss_study::evaluation::report::configuration_name;
use nearmiss_workflow::ConfigurationProgress;
use nearmiss_workflow::batch::DryRunLine;

/// Columns of the screen from which on there are two columns of text.
const WIDE: u16 = 140;

/// Columns of names.
const NAME: usize = 16;

/// Reasons of failures that are named each.
const REASONS: usize = 3;

/// Columns of each number of the table of ways.
const NUMBER: usize = 8;

/// Columns of the window that asks for a yes.
const CONFIRM: u16 = 84;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model, scroll: usize) {
    let body = window::full_screen(frame, screen, model);
    let view = &model.experiment;
    let name = view.file.as_deref().map(shown_path).unwrap_or_default();
    let room = usize::from(body.width).saturating_sub(24);
    let title = format!("experiment · {}", fit_end(&name, room));
    if body.width >= WIDE {
        let [left, right] =
            Layout::horizontal([Constraint::Fill(1), Constraint::Fill(1)]).areas(body);
        let run = window::window_at(frame, left, model, &title);
        window::text_in(
            frame,
            run,
            model,
            Page::new(model, run.width).state(),
            scroll,
        );
        let end = model.drawn.window_end();
        let about = if view.shows_text {
            "TOML"
        } else {
            "what it asks"
        };
        let says = window::window_at(frame, right, model, about);
        window::text_in(
            frame,
            says,
            model,
            Page::new(model, says.width).file(),
            scroll,
        );
        model
            .drawn
            .set_window_end(model.drawn.window_end().max(end));
    } else {
        let inner = window::window_at(frame, body, model, &title);
        let page = Page::new(model, inner.width);
        let mut text = if view.shows_text {
            Text::default()
        } else {
            page.state()
        };
        if !text.lines.is_empty() {
            text.push_line(Line::default());
        }
        text.extend(page.file());
        window::text_in(frame, inner, model, text, scroll);
    }
    if view.confirming {
        confirm(frame, screen, model);
    }
}

/// Asks for a yes, with the cost.
fn confirm(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    let width = window::width_in(screen, CONFIRM);
    let mut page = Page::new(model, u16::try_from(width).unwrap_or(u16::MAX));
    page.cost();
    page.line("");
    let words = match model.experiment.counted.as_ref().and_then(|c| c.batch) {
        Some(batch) => format!("y goes on with {batch}; answers are stored as they arrive"),
        None => "y begins a new batch; answers are stored as they arrive".to_string(),
    };
    page.words(&words, Style::new().add_modifier(Modifier::BOLD));
    let height = page.text.lines.len() + 2;
    let height = u16::try_from(height).unwrap_or(u16::MAX);
    let inner = window::window(
        frame,
        screen,
        model,
        "ask this experiment?",
        (CONFIRM, height),
    );
    frame.render_widget(Paragraph::new(page.text), inner);
}

/// Text that is being made, of a width.
struct Page<'a> {
    model: &'a Model,
    view: &'a ExperimentView,
    width: usize,
    text: Text<'static>,
}

impl<'a> Page<'a> {
    fn new(model: &'a Model, width: u16) -> Self {
        Self {
            model,
            view: &model.experiment,
            width: usize::from(width).max(24),
            text: Text::default(),
        }
    }

    fn dim(&self) -> Style {
        Style::new().fg(self.model.theme.dim)
    }

    fn warning(&self) -> Style {
        Style::new().fg(self.model.theme.warning)
    }

    fn line(&mut self, text: &str) {
        self.text.push_line(Line::raw(visible(text).into_owned()));
    }

    fn head(&mut self, words: &str) {
        if !self.text.lines.is_empty() {
            self.text.push_line(Line::default());
        }
        let style = Style::new()
            .fg(self.model.theme.accent)
            .add_modifier(Modifier::BOLD);
        self.text
            .push_line(Line::styled(format!(" {words}"), style));
    }

    /// Words over as many lines as they take.
    fn words(&mut self, words: &str, style: Style) {
        for words in textwrap::wrap(&visible(words), self.width.saturating_sub(2)) {
            self.text
                .push_line(Line::styled(format!(" {words}"), style));
        }
    }

    /// A name with its value; further lines stand below the value.
    fn row(&mut self, name: &str, value: &str, style: Style) {
        let mut label = format!(" {}", pad(name, NAME));
        let room = self.width.saturating_sub(NAME + 2).max(16);
        for words in textwrap::wrap(&visible(value), room) {
            self.text.push_line(Line::from(vec![
                Span::styled(label, self.dim()),
                Span::styled(words.into_owned(), style),
            ]));
            label = " ".repeat(NAME + 1);
        }
    }

    /// What is to be done, what it costs, and how far it is.
    fn state(&self) -> Text<'static> {
        let mut page = Self::new(self.model, u16::try_from(self.width).unwrap_or(u16::MAX));
        let view = page.view;
        let bold = Style::new().add_modifier(Modifier::BOLD);
        let title = view
            .outline
            .as_ref()
            .and_then(|outline| outline.title.clone());
        if let Some(title) = title {
            page.words(&title, bold);
        }
        if let Some(problem) = &view.problem {
            page.head("cannot be asked");
            for line in problem.lines() {
                page.words(line, page.warning());
            }
            let key = |action| page.model.look.keymap.key_in(action, Scope::Experiment);
            let (edit, read) = (key(Action::EditExperiment), key(Action::RereadExperiment));
            let hint = format!("{edit} edits the file, {read} reads it again");
            page.words(&hint, page.dim());
        }
        page.now();
        if view.counted.as_ref().is_some_and(|c| !c.lines.is_empty()) && view.asking.is_none() {
            page.head("to ask now");
            page.cost();
        }
        page.ways();
        let doubts = view.counted.as_ref().map_or(&[][..], |c| &c.doubts);
        if !doubts.is_empty() {
            page.head("notes");
            for doubt in doubts {
                page.words(doubt, page.warning());
            }
        }
        page.text
    }

    /// Where it stands, in a few rows.
    fn now(&mut self) {
        let view = self.view;
        let plain = Style::new();
        if let Some(working) = &view.working {
            self.row("reading", &format!("{working}…"), self.warning());
        }
        if let Some(job) = self.job() {
            let state = match job.state {
                JobState::Stopping => "stopping: no new requests; again cancels those already sent",
                _ => "running",
            };
            let words = format!("{state} · {} of {}", job.done, job.of);
            self.row("asking", &words, Style::new().fg(self.model.theme.accent));
        }
        let Some(counted) = &view.counted else { return };
        let [answered, failed, open, unaskable] = view.progress.sums();
        let is_complete = failed + open == 0 && answered > 0;
        let asked = self.job().and_then(|job| job.batch.clone());
        let keymap = &self.model.look.keymap;
        let batch = match (asked, counted.batch) {
            (Some(name), _) => name,
            (None, Some(batch)) if is_complete => {
                format!("{batch}: every question has its answer")
            }
            (None, Some(batch)) => {
                let key = keymap.key_in(Action::RunExperiment, Scope::Experiment);
                format!("{batch}: {key} goes on with it")
            }
            (None, None) => "new: not run yet".to_string(),
        };
        self.row("batch", &batch, plain);
        let mut progress = format!("{answered} answered · {failed} failed · {open} open");
        if unaskable > 0 {
            progress.push_str(&format!(" · {unaskable} cannot be asked"));
        }
        self.row("questions", &progress, plain);
        for (why, count) in counted.reasons.iter().take(REASONS) {
            self.row("", &format!("{count} × {why}"), self.warning());
        }
        let count = |count: usize, one: &str, more: &str| match count {
            1 => format!("1 {one}"),
            n => format!("{n} {more}"),
        };
        let size = format!(
            "{} · {} · {}",
            count(view.progress.scenarios, "scenario", "scenarios"),
            count(view.progress.windows, "window", "windows"),
            count(
                view.progress.configurations.len(),
                "way of asking",
                "ways of asking"
            )
        );
        self.row("size", &size, plain);
        self.spent();
        if let Some((dev, test)) = counted.split {
            let asked = match view.part {
                None => "both are asked",
                Some(SplitPart::Dev) => "only dev is asked",
                Some(SplitPart::Test) => "only test is asked",
            };
            let words = format!("{dev} dev, {test} test scenarios · {asked}");
            self.row("split", &words, plain);
        }
        for words in &counted.test {
            self.row("lock", words, self.warning());
        }
    }

    /// What the batch cost so far.
    fn spent(&mut self) {
        let (mut usd, mut unknown) = self.view.counted.as_ref().map_or((0.0, 0), |c| c.spent);
        if let Some(job) = self.job() {
            usd += job.cost;
            unknown += job.unpriced;
        }
        let words = match (usd > 0.0, unknown) {
            (false, 0) => "nothing".to_string(),
            (true, 0) => format!("${usd:.4}"),
            (false, unknown) => format!("{unknown} of unknown cost"),
            (true, unknown) => format!("${usd:.4}, and {unknown} of unknown cost"),
        };
        self.row("cost so far", &words, Style::new());
    }

    /// The job that asks it.
    fn job(&self) -> Option<&'a Job> {
        let id = self.view.asking?;
        self.model.jobs.all.iter().find(|job| job.id == id)
    }

    /// What asking the rest takes, in the words of a dry run.
    fn cost(&mut self) {
        let lines = self.view.counted.as_ref().map_or(&[][..], |c| &c.lines);
        let bold = Style::new().add_modifier(Modifier::BOLD);
        for line in lines {
            match line {
                DryRunLine::Value(name @ ("requests" | "price"), value) => {
                    self.row(name, value, bold);
                }
                DryRunLine::Value(name @ "refused", value) => self.row(name, value, self.warning()),
                DryRunLine::Value(name, value) => self.row(name, value, Style::new()),
                DryRunLine::Note(words) => self.row("", words, self.dim()),
                DryRunLine::Reason(words) => self.row("", words, self.warning()),
            }
        }
    }

    /// A table of progress by way of asking.
    fn ways(&mut self) {
        let ways = &self.view.progress.configurations;
        if ways.is_empty() {
            return;
        }
        self.head("by way of asking");
        let room = self.width.saturating_sub(4 * NUMBER + 2).max(12);
        let head = ["answered", "failed", "open", "all"].map(|name| format!("{name:>NUMBER$}"));
        let head = format!(" {}{}", pad("", room), head.concat());
        let style = self.dim();
        self.text.push_line(Line::styled(head, style));
        let several = ways
            .iter()
            .any(|way| way.configuration.task != ways[0].configuration.task);
        for way in ways {
            let line = self.way(way, several, room);
            self.text.push_line(line);
        }
    }

    fn way(&self, way: &ConfigurationProgress, names_task: bool, room: usize) -> Line<'static> {
        let name = configuration_name(&way.configuration);
        let name = if names_task {
            format!("{} · {name}", way.configuration.task.name())
        } else {
            name
        };
        let numbers = [way.answered, way.failed, way.open, way.all()].map(|number| match number {
            0 => format!("{:>NUMBER$}", "–"),
            number => format!("{number:>NUMBER$}"),
        });
        let failed = match way.failed {
            0 => Style::new(),
            _ => self.warning(),
        };
        let [answered, wrong, open, all] = numbers;
        Line::from(vec![
            Span::raw(format!(" {}{answered}", pad(&name, room))),
            Span::styled(wrong, failed),
            Span::raw(open),
            Span::styled(all, self.dim()),
        ])
    }

    /// What the file says, or its text.
    fn file(&self) -> Text<'static> {
        let mut page = Self::new(self.model, u16::try_from(self.width).unwrap_or(u16::MAX));
        let view = page.view;
        if view.shows_text || view.outline.is_none() {
            let text = view.text.as_deref().unwrap_or_default();
            let digits = text.lines().count().to_string().len();
            for (i, line) in text.lines().enumerate() {
                let room = page.width.saturating_sub(digits + 3);
                page.text.push_line(Line::from(vec![
                    Span::styled(format!(" {:>digits$} ", i + 1), page.dim()),
                    Span::raw(fit(line, room)),
                ]));
            }
            return page.text;
        }
        let Some(outline) = &view.outline else {
            return page.text;
        };
        page.head("matrix");
        for axis in &outline.axes {
            let (words, style) = match axis.values.len() {
                0 => ("default".to_string(), page.dim()),
                1 => (axis.values.concat(), Style::new()),
                n => (format!("{} ({n})", axis.values.join(", ")), Style::new()),
            };
            page.row(axis.name, &words, style);
        }
        page.row("ways of asking", &outline.ways.to_string(), Style::new());
        page.head("scenarios and comparison");
        for (name, value) in &outline.facts {
            page.row(name, value, Style::new());
        }
        page.text
    }
}
