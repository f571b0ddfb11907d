//! Draws the run list, and the selected run beside or below it.

use nearmiss_ask::llm::{Image, Message};
use nearmiss_scene::description::visible;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Filter, Run, RunState, Summary};
use nearmiss_study::evaluation::{TemplateVersion, run_summary, tool_rounds};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Block, BorderType, Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::action::Action;
use crate::model::{COUNTED, HistoryDrawn, InputPurpose, Model};
use crate::widgets::words::{date, fit_end, pad, short_techniques, thousands};
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
        let runs = u16::try_from(model.history.rows.len().max(1) + 2).unwrap_or(u16::MAX);
        let height = runs.min(body.height * 42 / 100);
        Layout::vertical([Constraint::Length(height), Constraint::Min(0)]).areas(body)
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

/// Columns of what the runs in sight say, so that no name is cut while there is room.
struct Widths {
    name: usize,
    model: usize,
    how: usize,
    version: usize,
    date: usize,
    /// Whether models stand without their providers, and tasks in short.
    short: bool,
}

/// Columns of sign, pin and verdict.
const BEFORE_NAME: usize = 2 + 5;

impl Widths {
    /// What tells runs apart gets room first: scenario and model, how was asked, the version of the template, and the
    /// date, without its year and not at all at last.
    fn new(runs: &[Summary], width: usize) -> Self {
        let widest = |columns: &dyn Fn(&Summary) -> usize| {
            let columns = runs.iter().map(columns).max();
            columns.map_or(0, |columns| columns + 1)
        };
        let name = widest(&|run| run.scenario.width());
        let whole = |short: bool| {
            let model = widest(&|run| bare(&run.model, short).width());
            (model, widest(&|run| how(run, short).width()))
        };
        let room = width.saturating_sub(BEFORE_NAME);
        let (model, how) = whole(false);
        let short = name + model + how + MONTH_TO_MINUTE > room;
        let (model, how) = if short { whole(true) } else { (model, how) };
        let mut left = room;
        let mut take = |columns: usize, least: usize| {
            let taken = columns.min(left);
            let taken = if taken < least { 0 } else { taken };
            left -= taken;
            taken
        };
        // A model is named however long the name of the scenario is.
        let name = take(name.min(room.saturating_sub(model.min(room / 2))), 0);
        let model = take(model, 0);
        let how = take(how, how);
        let version = widest(&|run| version(run).width());
        let version = take(version, version);
        let mut dates = [YEAR_TO_MINUTE, MONTH_TO_MINUTE].into_iter();
        let date = dates.find(|columns| take(*columns, *columns) > 0);
        Self {
            name,
            model,
            how,
            version,
            date: date.unwrap_or(0),
            short,
        }
    }
}

/// Columns of a date, with and without its year.
const YEAR_TO_MINUTE: usize = 16;
const MONTH_TO_MINUTE: usize = 11;

/// A model, in short without its provider.
fn bare(model: &str, short: bool) -> &str {
    match model.split_once('/') {
        Some((_, bare)) if short => bare,
        _ => model,
    }
}

/// The version of a changed template.
fn version(run: &Summary) -> String {
    let version = TemplateVersion::from_stored(&run.template);
    let changed = version.filter(|version| !version.is_shipped());
    changed.map_or(String::new(), |version| version.to_string())
}

/// How a run was asked: task, frame and techniques.
fn how(run: &Summary, short: bool) -> String {
    let task = match run.task {
        Task::Collision if short => "coll.",
        task => task.name(),
    };
    let techniques = short_techniques(&run.techniques);
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
    let when = whole.get(whole.len().saturating_sub(widths.date)..);
    // An excerpt of what is searched for stands in place of how was asked, unless it is the name.
    let name = pad(
        &fit_end(&run.scenario, widths.name.saturating_sub(1)),
        widths.name,
    );
    let marked = marked(run, &name, theme.accent);
    let (how, excerpt) = match &run.excerpt {
        Some(excerpt) if marked.is_none() => {
            let words: Vec<_> = excerpt.split_whitespace().collect();
            (String::new(), words.join(" "))
        }
        _ => (how(run, widths.short), String::new()),
    };
    let mut line = Line::from(vec![
        Span::raw(format!("{sign}{pin}")),
        Span::styled(
            pad(word, 5),
            Style::new().fg(color).add_modifier(Modifier::BOLD),
        ),
    ]);
    line.spans
        .extend(marked.unwrap_or_else(|| vec![name.into()]));
    line.push_span(Span::styled(
        pad(
            &fit_end(
                bare(&run.model, widths.short),
                widths.model.saturating_sub(1),
            ),
            widths.model,
        ),
        Style::new().fg(theme.accent),
    ));
    if excerpt.is_empty() {
        let dim = Style::new().fg(theme.dim);
        line.push_span(pad(&how, widths.how));
        line.push_span(Span::styled(pad(&version(run), widths.version), dim));
        line.push_span(Span::styled(when.unwrap_or_default().to_string(), dim));
    } else {
        let room = width.saturating_sub(line.width());
        line.push_span(pad(&excerpt, room));
    }
    if chosen {
        theme.select(line)
    } else {
        line.style(theme.base())
    }
}

/// The column of the name with what is searched for marked, where the excerpt says nothing else.
fn marked(run: &Summary, name: &str, color: Color) -> Option<Vec<Span<'static>>> {
    let excerpt = run.excerpt.as_deref()?;
    if excerpt.replace(['[', ']'], "") != run.scenario {
        return None;
    }
    let hit = Style::new()
        .fg(color)
        .add_modifier(Modifier::BOLD | Modifier::UNDERLINED);
    let mut spans = Vec::new();
    let mut rest = name;
    let hits = excerpt.split('[').skip(1);
    for found in hits.filter_map(|part| part.split(']').next()) {
        // Of a name that is cut, what is left may not hold it.
        let Some((before, behind)) = rest.split_once(found) else {
            break;
        };
        spans.push(Span::raw(before.to_string()));
        spans.push(Span::styled(found.to_string(), hit));
        rest = behind;
    }
    spans.push(Span::raw(rest.to_string()));
    Some(spans)
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
