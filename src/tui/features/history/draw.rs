//! Draws the run list, and the selected run beside or below it.

use nearmiss_ask::llm::{Image, Message};
use nearmiss_scene::description::visible;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Filter, Run, RunState, Summary};
use nearmiss_study::evaluation::{TemplateVersion, run_summary, tool_rounds};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Block, BorderType, Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::action::Action;
use crate::model::{COUNTED, HistoryDrawn, InputPurpose, Model};
use crate::widgets::words::{date, fit_end, pad, thousands};
use crate::widgets::{markdown, window};

/// Columns from which on the details stand beside the list.
const SIDE_BY_SIDE_COLUMNS: u16 = 110;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    let body = window::full_screen(frame, screen, model);
    let [line, body] = Layout::vertical([Constraint::Length(1), Constraint::Min(0)]).areas(body);
    search(frame, line, model);
    let [left, right] = if body.width >= SIDE_BY_SIDE_COLUMNS {
        Layout::horizontal([Constraint::Percentage(48), Constraint::Min(0)]).areas(body)
    } else {
        Layout::vertical([Constraint::Percentage(42), Constraint::Min(0)]).areas(body)
    };
    let rows = pane(frame, left, model, title(model), !model.history.on_details);
    let top = list(frame, rows, model);
    let what = match model.history.current() {
        Some(id) => format!("run {id}"),
        None => "no run".into(),
    };
    let text = pane(frame, right, model, what, model.history.on_details);
    let lines = details(frame, text, model);
    model.drawn.set_history(HistoryDrawn {
        list: rows,
        top,
        details: text,
        lines,
    });
}

/// How many runs there are.
fn title(model: &Model) -> String {
    let history = &model.history;
    let number = match history.total {
        Some(n) if n >= COUNTED && history.is_filtered() => format!(" {}+", thousands(COUNTED)),
        Some(n) => format!(" {}", thousands(n)),
        None => String::new(),
    };
    let reading = if history.loading.is_some() {
        " …"
    } else {
        ""
    };
    let kind = if history.filter.deleted {
        "deleted runs"
    } else {
        "runs"
    };
    format!("{kind}{number}{reading}")
}

/// The line at the top: what is searched for, or what is being typed.
fn search(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let (theme, history) = (&model.theme, &model.history);
    let accent = Style::new().fg(theme.accent);
    let width = usize::from(area.width).saturating_sub(12);
    let (label, text, typing) = match &history.typing {
        Some(InputPurpose::Note(id, text)) => (format!(" note on run {id}: "), text.as_str(), true),
        Some(InputPurpose::Export(file)) => (" export to: ".into(), file.as_str(), true),
        Some(InputPurpose::Search) => (" /".into(), history.line.as_str(), true),
        None => (" /".into(), history.line.as_str(), false),
    };
    // The end is where one types.
    let shown = fit_end(text, width.saturating_sub(label.width()));
    let mut line = Line::from(vec![
        Span::styled(label, accent.add_modifier(Modifier::BOLD)),
        Span::styled(shown, accent),
    ]);
    if typing {
        line.push_span(Span::styled("▏", accent));
    }
    let left = usize::from(area.width).saturating_sub(line.width() + 3);
    let note = match &history.wrong {
        Some(why) => Some((why.as_str(), theme.danger)),
        None if text.is_empty() && !matches!(history.typing, Some(InputPurpose::Note(..))) => {
            Some((Filter::NAMES, theme.dim))
        }
        None => None,
    };
    if let Some((words, color)) = note {
        let words = if words.width() <= left {
            words.to_string()
        } else {
            // Of names, whole ones.
            whole_words(words, left)
        };
        line.push_span(Span::styled(format!("  {words}"), color));
    }
    frame.render_widget(line, area);
}

/// As many words as there is room for.
fn whole_words(words: &str, room: usize) -> String {
    let mut shown = String::new();
    for word in words.split_inclusive(' ') {
        if shown.width() + word.width() + 1 > room {
            break;
        }
        shown.push_str(word);
    }
    format!("{}…", shown.trim_end())
}

fn pane(frame: &mut Frame<'_>, area: Rect, model: &Model, title: String, focused: bool) -> Rect {
    let theme = &model.theme;
    let (color, kind) = if focused {
        (theme.border_focused, BorderType::Thick)
    } else {
        (theme.border, BorderType::Plain)
    };
    let block = Block::bordered()
        .border_type(kind)
        .border_style(Style::new().fg(color))
        .title(Span::styled(
            format!(" {title} "),
            Style::new().fg(theme.title),
        ));
    let inner = block.inner(area);
    frame.render_widget(block, area);
    inner
}

/// Draws the rows that fit; gives the first.
fn list(frame: &mut Frame<'_>, area: Rect, model: &Model) -> usize {
    let history = &model.history;
    let rows = usize::from(area.height);
    let top = history
        .selected
        .saturating_sub(rows / 2)
        .min(history.rows.len().saturating_sub(rows));
    if history.rows.is_empty() {
        let words = match (&history.error, history.loading.is_some()) {
            (Some(error), _) => error.clone(),
            (None, true) => "reading the store…".into(),
            (None, false) if history.is_filtered() => {
                let key = model.look.key(Action::Cancel);
                format!("no runs match; {key} clears the search")
            }
            (None, false) => {
                let key = model.look.key(Action::Run);
                format!("no runs yet; {key} on the main screen asks")
            }
        };
        let text = Paragraph::new(visible(&words).into_owned()).wrap(Wrap { trim: true });
        frame.render_widget(text.style(Style::new().fg(model.theme.dim)), area);
        return 0;
    }
    let shown = history.rows.iter().enumerate().skip(top).take(rows);
    let width = usize::from(area.width);
    let widths = Widths::new(
        &history.rows[top..(top + rows).min(history.rows.len())],
        width,
    );
    let lines = shown.map(|(i, run)| row(model, run, i == history.selected, width, &widths));
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), area);
    top
}

/// Columns that the runs in sight need.
struct Widths {
    how: usize,
    model: usize,
    /// Whether tasks are written in short, to leave room for the names.
    short: bool,
}

/// Columns from which on a row says how was asked.
const SAYS_HOW: usize = 70;

/// Columns from which on it names the version of a changed template.
const SAYS_VERSION: usize = 86;

/// Columns of sign and pin, verdict and date.
const BEFORE_NAME: usize = 2 + 5 + 13;

impl Widths {
    fn new(runs: &[Summary], width: usize) -> Self {
        let widest = |columns: &dyn Fn(&Summary) -> usize| runs.iter().map(columns).max();
        let widest = |columns: &dyn Fn(&Summary) -> usize| widest(columns).unwrap_or(0);
        let name = widest(&|run| run.scenario.width());
        let model = widest(&|run| run.model.width());
        let whole = widest(&|run| how(run, false).width());
        let short = BEFORE_NAME + whole + 1 + name + 1 + model > width;
        Self {
            how: widest(&|run| how(run, short).width()),
            model,
            short,
        }
    }
}

/// A model, without its provider where both have no room.
fn bare(model: &str, width: usize) -> &str {
    match model.split_once('/') {
        Some((_, bare)) if model.width() > width => bare,
        _ => model,
    }
}

/// How a run was asked: task, frame and techniques.
fn how(run: &Summary, short: bool) -> String {
    let task = match run.task {
        Task::Collision if short => "coll.",
        task => task.name(),
    };
    let techniques = run.techniques.replace("cp+cot+icl", "all");
    let frame = run.frame.replace("cartesian", "cart");
    match judge::how(&run.model) {
        // There is no room for all of it.
        Some(_) => format!("{task} exact"),
        // The frame of the trajectory task has its name.
        None if frame == run.task.name() => format!("{frame} {techniques}"),
        None => format!("{task} {frame} {techniques}"),
    }
}

/// A run on one line: what it says, when, on what, by whom.
fn row(model: &Model, run: &Summary, chosen: bool, width: usize, widths: &Widths) -> Line<'static> {
    let theme = &model.theme;
    let (word, color) = match (run.dangerous, run.state) {
        // What a cut answer says does not count.
        (Some(true), RunState::Answered) => ("yes", theme.danger),
        (Some(false), RunState::Answered) => ("no", theme.danger_low),
        (None, RunState::Answered) => ("none", theme.warning),
        (_, RunState::Running) => ("…", theme.accent),
        (_, RunState::Failed) => ("fail", theme.danger),
        (_, RunState::Cancelled) => ("canc", theme.dim),
        (_, RunState::Truncated | RunState::Interrupted) => ("cut", theme.warning),
    };
    let sign = if chosen { "▸" } else { " " };
    let pin = if run.pinned { "+" } else { " " };
    // Of the date the year goes first where there is little room.
    let whole = date(run.created_ms);
    let when = match width {
        0..100 => whole.get(5..).unwrap_or(&whole).to_string(),
        _ => whole,
    };
    // Runs on one scenario differ in how they were asked; an excerpt of what is searched for comes first.
    let how = match width {
        SAYS_HOW.. if run.excerpt.is_none() => {
            format!("{} ", pad(&how(run, widths.short), widths.how))
        }
        _ => String::new(),
    };
    let version = TemplateVersion::from_stored(&run.template);
    let version = match version.filter(|version| !version.is_shipped()) {
        Some(version) if width >= SAYS_VERSION && !how.is_empty() => format!("{version} "),
        _ => String::new(),
    };
    let fixed = 2 + 5 + how.width() + when.width() + 2 + version.width();
    let rest = width.saturating_sub(fixed);
    let model_width = (rest / 2).min(34).min(widths.model);
    let name_width = rest.saturating_sub(model_width + 1);
    let name = match &run.excerpt {
        Some(excerpt) if width >= SAYS_HOW => {
            let words: Vec<_> = excerpt.split_whitespace().collect();
            format!("{}  {}", run.scenario, words.join(" "))
        }
        _ => run.scenario.clone(),
    };
    let line = Line::from(vec![
        Span::raw(format!("{sign}{pin}")),
        Span::styled(
            pad(word, 5),
            Style::new().fg(color).add_modifier(Modifier::BOLD),
        ),
        Span::raw(how),
        Span::styled(format!("{when}  "), Style::new().fg(theme.dim)),
        Span::raw(pad(&name, name_width)),
        Span::raw(" "),
        Span::styled(version, Style::new().fg(theme.dim)),
        Span::styled(
            fit_end(bare(&run.model, model_width), model_width),
            Style::new().fg(theme.accent),
        ),
    ]);
    if chosen {
        theme.select(line)
    } else {
        line.style(theme.base())
    }
}

/// Draws the selected run; gives its lines.
fn details(frame: &mut Frame<'_>, area: Rect, model: &Model) -> usize {
    let history = &model.history;
    let Some(found) = history.shown() else {
        if history.current().is_some() {
            let words = Span::styled("reading…", Style::new().fg(model.theme.dim));
            frame.render_widget(words, area);
        }
        return 0;
    };
    let truth = history.truth.filter(|(id, _)| *id == found.id);
    let text = text(model, found, truth.and_then(|(_, truth)| truth));
    let paragraph = Paragraph::new(text).wrap(Wrap { trim: false });
    let lines = paragraph.line_count(area.width);
    let last = lines.saturating_sub(usize::from(area.height));
    let top = u16::try_from(history.scroll.min(last)).unwrap_or(u16::MAX);
    frame.render_widget(paragraph.scroll((top, 0)), area);
    lines
}

/// Columns of the names.
const NAME: usize = 12;

/// The run; `truth` is what the built-in judge says to the same question, where that is known.
pub fn text(model: &Model, run: &Run, truth: Option<bool>) -> Text<'static> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let title = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
    let mut text = Text::default();
    for (name, value, style) in rows(model, run, truth) {
        let value = visible(&value).replace(['\n', '\t'], " ");
        text.push_line(Line::from(vec![
            Span::styled(format!("{name:<NAME$} "), dim),
            Span::styled(value, style),
        ]));
    }
    let mut part = |name: &str, words: &str| {
        if words.trim().is_empty() {
            return;
        }
        text.push_line("");
        text.push_line(Line::styled(format!("── {name} ──"), title));
        let mut is_code = false;
        for line in visible(words.trim_end()).lines() {
            let line = line.replace('\t', "    ");
            if line.trim_start().starts_with("```") {
                is_code = !is_code;
                continue;
            }
            let pieces = if is_code {
                markdown::code(&line, theme)
            } else {
                markdown::line(&line, theme)
            };
            text.push_line(Line::from_iter(pieces.into_iter().map(|piece| piece.span)));
        }
    };
    let rounds = tool_rounds::stored(run.tool_rounds.as_deref());
    let calls: Vec<String> = rounds.iter().flat_map(tool_rounds::lines).collect();
    part("tool calls", &calls.join("\n"));
    part("reasoning", &run.reasoning);
    part("answer", &run.answer);
    for (role, content) in messages(&run.question.messages) {
        part(&format!("message: {role}"), &content);
    }
    text
}

/// Names and values, in the order of what people look for.
fn rows(model: &Model, run: &Run, truth: Option<bool>) -> Vec<(&'static str, String, Style)> {
    let theme = &model.theme;
    let plain = Style::new();
    let bold = |color| Style::new().fg(color).add_modifier(Modifier::BOLD);
    let (question, ending) = (&run.question, &run.ending);
    let mut rows = Vec::new();
    let verdict = ending.verdict.as_ref().and_then(|said| said.verdict());
    let said = verdict.map(|verdict| verdict.dangerous);
    if let Some(verdict) = verdict {
        let color = if verdict.dangerous {
            theme.danger
        } else {
            theme.danger_low
        };
        rows.push(("verdict", verdict.word().to_string(), bold(color)));
    }
    if question.model != judge::MODEL {
        let words = |dangerous| if dangerous { "yes" } else { "no" };
        let (value, style) = match (truth, said) {
            (Some(truth), Some(said)) if truth == said => {
                (format!("= {}", words(truth)), bold(theme.agree))
            }
            (Some(truth), Some(_)) => (format!("≠ {}", words(truth)), bold(theme.disagree)),
            (Some(truth), None) => (words(truth).to_string(), plain),
            (None, _) => ("unknown".to_string(), Style::new().fg(theme.dim)),
        };
        rows.push(("built-in", value, style));
    }
    let words = run_summary(run, run.most_usd).into_iter();
    rows.extend(words.map(|(name, value)| (name, value, plain)));
    rows
}

/// Roles and contents of the messages; of what is no list of messages, the text as it is.
fn messages(json: &str) -> Vec<(String, String)> {
    let Ok(all) = serde_json::from_str::<Vec<Message>>(json) else {
        return vec![("as stored".into(), json.to_string())];
    };
    let pictures = |message: &Message| -> String {
        let images = message.images.iter();
        let words = |image: &Image| {
            format!(
                "\n\n[picture {}: nearmiss runs show writes it]",
                image.sha256
            )
        };
        images.map(words).collect()
    };
    let text = |m: &Message| (m.role.name().into(), m.content.clone() + &pictures(m));
    all.iter().map(text).collect()
}
