//! Draws the results: the matrix or the list of sources, the answers of a cell, and their bars.

use nearmiss_scene::description::visible;
use nearmiss_study::evaluation::batch::{AnswerSet, CountingChoice};
use nearmiss_study::evaluation::{AnswerOutcome, Outcome, Results, Spending};
use nearmiss_workflow::TruthChoice;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::action::{Action, Scope};
use crate::features::results::matrix::{self, HEADS, NAMES, asked, model_name, version};
use crate::model::{Model, ResultsDrawn, ResultsView};
use crate::widgets::words::{date, fit, pad, thousands, whole_parts};
use crate::widgets::{hints, window};

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    let body = window::full_screen(frame, screen, model);
    let results = &model.results;
    let mut drawn = match results.inside {
        _ if results.rows.is_empty() => {
            empty(frame, body, model);
            ResultsDrawn::default()
        }
        Some(selected) => draw_answers(frame, body, model, Some(selected)),
        None => {
            let rows = rows(model);
            // The borders, the lines about the truth, and a matrix of some rows come before the bars.
            let height = u16::try_from(rows.len() + 2)
                .unwrap_or(u16::MAX)
                .min(body.height / 2);
            // What is left shows the answers of the selected cell.
            let matrix = u16::try_from(results.rows.len() + MATRIX_LINES).unwrap_or(u16::MAX);
            let left = body.height.saturating_sub(matrix.saturating_add(height));
            let left = if left < LEAST_ANSWERS { 0 } else { left };
            let [above, below, last] = Layout::vertical([
                Constraint::Min(0),
                Constraint::Length(height),
                Constraint::Length(left),
            ])
            .areas(body);
            let mut drawn = matrix::draw(frame, above, model, &title_in(results, above.width));
            drawn.bars = draw_bars(frame, below, model, &rows);
            if left > 0 {
                draw_answers(frame, last, model, None);
            }
            drawn
        }
    };
    if let Some(selected) = results.choosing {
        drawn = draw_choice(frame, body, model, selected);
    }
    model.drawn.set_results(drawn);
}

/// Lines of the matrix beside its rows: borders, headings, and what stands below them.
const MATRIX_LINES: usize = 5;

/// Fewest lines, borders included, in which answers stand below the bars.
const LEAST_ANSWERS: u16 = 7;

/// Why there is nothing to count.
fn empty(frame: &mut Frame<'_>, body: Rect, model: &Model) {
    let results = &model.results;
    let inner = window::window_at(frame, body, model, &title_in(results, body.width));
    let key = model.look.key(Action::ChooseCounted);
    let words = match (&results.error, results.reading, results.counting) {
        (Some(error), ..) => error.clone(),
        (None, true, _) => "reading the store…".into(),
        (None, false, Some(counting)) if results.locked.is_some() => format!(
            "{counting}: {}: its figures are shown when all of it is answered; {key} selects other answers",
            results.locked.as_deref().unwrap_or_default()
        ),
        (None, false, Some(counting @ AnswerSet::Batch(..))) => format!(
            "{counting} has no answers yet ({} not asked); {key} selects other answers",
            results.unasked
        ),
        (None, false, _) => {
            let key = model.look.key(Action::Run);
            format!(
                "no model has been asked yet; {key} on the main screen asks one, `nearmiss runs import` reads recorded answers"
            )
        }
    };
    let text = Paragraph::new(visible(&words).into_owned()).wrap(Wrap { trim: true });
    frame.render_widget(text.style(Style::new().fg(model.theme.dim)), inner);
}

/// Which answers are counted, and what they are compared with where that fits; else it stands below the table.
fn title_in(results: &ResultsView, width: u16) -> String {
    let whole = title(results);
    let truth = format!(" · truth: {}", visible(&results.truth_words()));
    if whole.width() + CORNERS > usize::from(width) {
        whole.replacen(&truth, "", 1)
    } else {
        whole
    }
}

/// Which answers are counted, and what they are compared with.
fn title(results: &ResultsView) -> String {
    let count: usize = results.rows.iter().map(|row| row.answers.len()).sum();
    let counting = results
        .counting
        .map_or(String::new(), |c| format!("{c} · "));
    let truth = if results.rows.is_empty() {
        String::new()
    } else {
        format!(" · truth: {}", visible(&results.truth_words()))
    };
    let reading = if results.reading && results.judging.is_none() {
        " …"
    } else {
        ""
    };
    let answers = match count {
        1 => "1 answer".into(),
        n => format!("{} answers", thousands(n as u64)),
    };
    format!("results · {counting}{answers}{truth}{reading}")
}

/// What the answers cost, every attempt included; nothing where no cost is known.
fn cost(results: &ResultsView) -> Option<String> {
    let mut sum = Spending::default();
    let rows = results.rows.iter();
    rows.for_each(|row| sum.join(&row.spending));
    let usd = sum.cost().filter(|usd| *usd > 0.0)?;
    Some(match sum.unpriced() {
        0 => format!("cost ${usd:.4}"),
        n => format!("cost ${usd:.4}, and {n} of unknown cost"),
    })
}

/// Columns of the corners, and of the spaces in them.
const CORNERS: usize = 4;

/// The lines below a table: progress, what is left out, what the columns mean, and those without room, which appear
/// when they are selected; gives what is above them.
pub fn foot(frame: &mut Frame<'_>, area: Rect, model: &Model, hidden: &[&str]) -> Rect {
    let results = &model.results;
    let mut words = Vec::new();
    // In the matrix the title says it, where it fits.
    let inside = results.inside.is_some();
    if inside || title(results).width() + CORNERS > usize::from(area.width) {
        words.push(format!("truth: {}", visible(&results.truth_words())));
    }
    if let Some(counting) = results.counting.filter(|_| inside) {
        words.push(format!("of {counting}"));
    }
    match results.judging {
        Some((done, of)) if of > 0 => {
            words.push(format!("judging… {done} of {of} scenes; counts follow"))
        }
        Some(_) => words.push("judging…; counts follow".into()),
        None => {}
    }
    match results.unasked {
        0 => {}
        1 => words.push("1 question not asked, not counted".into()),
        n => words.push(format!("{n} questions not asked, not counted")),
    }
    words.extend(cost(results));
    let has_claims = |answer: &&AnswerOutcome| claim_counts(answer).is_some();
    let legend = if !inside {
        let left_out = results.left_out.iter();
        words.extend(left_out.map(|words| format!("not counted: {words}")));
        "= right, ≠ wrong, p/n: says yes/no"
    } else if results.answers().iter().any(has_claims) {
        "claims: = right, ≠ wrong, ? open"
    } else {
        ""
    };
    let keys = [Action::CellLeft, Action::CellRight];
    let (keys, _) = hints::pair(model, Scope::Results, keys, "");
    let more = match hidden {
        [] => String::new(),
        [one] => format!("{keys} more: {one}"),
        _ => format!("{keys} {} more columns", hidden.len()),
    };
    // What is counted is always said, on several lines if need be; what helps to read it, as long as one line has room.
    let facts = words.join(" · ");
    let line = whole_parts([&facts, &more, legend], usize::from(area.width));
    let text = Paragraph::new(if line.starts_with(&facts) {
        line
    } else {
        facts
    })
    .style(Style::new().fg(model.theme.dim))
    .wrap(Wrap { trim: true });
    let lines = u16::try_from(text.line_count(area.width))
        .unwrap_or(u16::MAX)
        .min(area.height.saturating_sub(2) / 2);
    let [above, below] =
        Layout::vertical([Constraint::Min(0), Constraint::Length(lines)]).areas(area);
    frame.render_widget(text, below);
    above
}

/// Columns of the outcome in a word.
const WORD: usize = 11;

/// Draws them, the selected one in the middle; gives where the list stands. Without a selected one they only show what
/// is in the cell.
pub fn draw_answers(
    frame: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    selected: Option<usize>,
) -> ResultsDrawn {
    let results = &model.results;
    let all = results.answers();
    let cell = results.column.min(HEADS.len() - 1);
    let title = results.row().map_or(String::new(), |row| {
        let head = HEADS[cell];
        let version =
            version(&row.configuration).map_or(String::new(), |words| format!(" · {words}"));
        let model = model_name(&row.configuration);
        let [whole, short] = [false, true].map(|short| {
            let how = asked(&row.configuration, short).join(" ");
            format!("{model} · {how}{version} · {head} {}", all.len())
        });
        if whole.width() + CORNERS <= usize::from(area.width) {
            whole
        } else {
            short
        }
    });
    let (inner, list) = if selected.is_some() {
        let inner = window::window_at(frame, area, model, &title);
        (inner, foot(frame, inner, model, &[]))
    } else {
        let inner = window::beside(frame, area, model, &title);
        (inner, inner)
    };
    let rows = usize::from(list.height);
    let top = selected
        .unwrap_or(0)
        .saturating_sub(rows / 2)
        .min(all.len().saturating_sub(rows));
    let mut widths = AnswerWidths::new(&all, usize::from(list.width));
    // Those that are only shown stand side by side where there is room.
    let beside = match selected {
        Some(_) => 1,
        None => (widths.whole / widths.needed.max(1)).max(1),
    };
    widths.whole /= beside;
    let line = |place: usize| {
        let answer = all.get(place)?;
        let chosen = selected == Some(place);
        let line = answer_line(model, answer, chosen, &widths);
        Some(if chosen {
            model.theme.select(line)
        } else {
            line.style(model.theme.base())
        })
    };
    let lines = (top..(top + rows).min(all.len())).map(|first| {
        let mut whole = line(first).unwrap_or_default();
        let others = (1..beside).filter_map(|column| line(first + column * rows));
        whole.spans.extend(others.flatten());
        whole
    });
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), list);
    let below = all.len().saturating_sub(top + rows * beside);
    window::below(frame, inner, model, below);
    ResultsDrawn {
        list,
        top,
        ..ResultsDrawn::default()
    }
}

/// Columns between answers that stand side by side.
const GAP: usize = 3;

/// Columns of answers, so that no name is cut while there is room.
struct AnswerWidths {
    /// Of a line.
    whole: usize,
    /// What a line needs, with a gap behind it.
    needed: usize,
    name: usize,
    what: usize,
    claims: usize,
    /// Whether everything but names is said in fewer words.
    brief: bool,
}

impl AnswerWidths {
    fn new(all: &[&AnswerOutcome], width: usize) -> Self {
        let widest = |columns: &dyn Fn(&AnswerOutcome) -> usize| {
            all.iter().map(|answer| columns(answer)).max().unwrap_or(0)
        };
        let room = width.saturating_sub(2 + WORD);
        let name = widest(&|answer| visible(&answer.scenario).width() + 1).min(NAMES);
        let of = |brief: bool| {
            let what = widest(&|answer| what(answer, brief).width());
            let claims = widest(&|answer| claims(answer, brief).width());
            let tail = widest(&|answer| run(answer).width());
            (what, claims, room.saturating_sub(claims + tail))
        };
        let brief = {
            let (what, _, left) = of(false);
            name + what > left
        };
        let (what, claims, left) = of(brief);
        let needed = width - left.saturating_sub(name + what) + GAP;
        Self {
            whole: width,
            needed,
            name: name.min(left - what.min(left / 2)),
            what: what.min(left / 2),
            claims,
            brief,
        }
    }
}

/// Its run, and which of several it is.
fn run(answer: &AnswerOutcome) -> String {
    let sample = match answer.sample {
        0 => String::new(),
        n => format!(" sample {n}"),
    };
    let run = answer
        .run
        .map_or("no run".into(), |run| format!("run {run}"));
    format!("  {run}{sample}")
}

/// What it says, and what is true where that differs.
fn what(answer: &AnswerOutcome, brief: bool) -> &'static str {
    let (_, whole) = outcome_label(answer);
    match whole.strip_prefix("says ") {
        Some(short) if brief => short,
        _ => whole,
    }
}

fn answer_line(
    model: &Model,
    answer: &AnswerOutcome,
    chosen: bool,
    widths: &AnswerWidths,
) -> Line<'static> {
    let theme = &model.theme;
    let (word, _) = outcome_label(answer);
    let color = match answer.outcome.is_right() {
        Some(true) => theme.agree,
        Some(false) => theme.disagree,
        None => theme.warning,
    };
    let name = pad(&visible(&answer.scenario), widths.name.saturating_sub(1));
    let claims = pad(&claims(answer, widths.brief), widths.claims);
    let mut line = Line::from(vec![
        Span::raw(if chosen { "▸ " } else { "  " }),
        Span::styled(
            pad(word, WORD),
            Style::new().fg(color).add_modifier(Modifier::BOLD),
        ),
        Span::raw(format!("{name} ")),
        Span::raw(pad(what(answer, widths.brief), widths.what)),
        Span::styled(
            format!("{claims}{}", run(answer)),
            Style::new().fg(theme.dim),
        ),
    ]);
    // The line that is selected is marked from border to border.
    line.push_span(" ".repeat(widths.whole.saturating_sub(line.width())));
    line
}

/// Its claims about obstacles: how many are right, wrong and open; nothing where there are none or they were not checked.
fn claims(answer: &AnswerOutcome, brief: bool) -> String {
    let word = if brief { "" } else { "claims " };
    claim_counts(answer).map_or(String::new(), |counts| {
        let some = counts.into_iter().zip(["=", "≠", " open"]);
        let some = some.filter(|(count, _)| *count > 0);
        let parts: Vec<String> = some.map(|(count, sign)| format!("{count}{sign}")).collect();
        format!("  {word}{}", parts.join(" "))
    })
}

fn claim_counts(answer: &AnswerOutcome) -> Option<[u32; 3]> {
    let counts = answer.claims.known();
    counts.filter(|counts| counts.iter().any(|count| *count > 0))
}

fn outcome_label(answer: &AnswerOutcome) -> (&'static str, &'static str) {
    match answer.outcome {
        Outcome::TruePositive if answer.naming.windows > answer.naming.found => {
            ("= right", "yes, obstacle not named")
        }
        Outcome::TruePositive => ("= right", "says yes"),
        Outcome::TrueNegative => ("= right", "says no"),
        Outcome::FalsePositive => ("≠ wrong", "says yes, truth: no"),
        Outcome::FalseNegative => ("≠ wrong", "says no, truth: yes"),
        Outcome::Open => ("no truth", "nothing to compare with"),
        Outcome::Unparsed => ("no verdict", "none could be read"),
        Outcome::Failed => ("failed", "no complete answer"),
    }
}

/// Columns of a bar at most, and at least where numbers stand beside it.
const BAR: (usize, usize) = (80, 12);

/// The rows of the matrix that differ from the selected one in nothing but techniques.
pub fn rows(model: &Model) -> Vec<usize> {
    let results = &model.results;
    let Some(row) = results.row() else {
        return Vec::new();
    };
    let like = |other: &Results| {
        let (a, b) = (&row.configuration, &other.configuration);
        (a.task, a.frame, &a.model, a.settings) == (b.task, b.frame, &b.model, b.settings)
            && (a.techniques != b.techniques || a.template == b.template)
    };
    let all = results.rows.iter().enumerate();
    all.filter(|(_, other)| like(other))
        .map(|(place, _)| place)
        .collect()
}

/// Draws them; gives where the bars stand, and of which rows they are.
pub fn draw_bars(
    frame: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    rows: &[usize],
) -> (Rect, Vec<usize>) {
    let results = &model.results;
    let title = results.row().map_or(String::new(), |row| {
        let task = row.configuration.task.name();
        let frame = row.configuration.frame.map_or("–", |frame| frame.name());
        let model = model_name(&row.configuration);
        format!("right by techniques, ▓░ 95 % interval · {task} {frame} · {model}")
    });
    let inner = window::beside(frame, area, model, &title);
    let height = usize::from(inner.height);
    let chosen = rows.iter().position(|row| *row == results.selected);
    let top = (chosen.unwrap_or(0) + 1).saturating_sub(height);
    let shown: Vec<usize> = rows.iter().copied().skip(top).take(height).collect();
    let lines: Vec<Line<'_>> = shown
        .iter()
        .map(|row| bar(model, *row, usize::from(inner.width)))
        .collect();
    frame.render_widget(Paragraph::new(lines), inner);
    (inner, shown)
}

fn bar(model: &Model, place: usize, width: usize) -> Line<'static> {
    let (theme, results) = (&model.theme, &model.results);
    let row = &results.rows[place];
    let (right, asked) = row.right();
    let share = row.right_of_all();
    let number = share.map_or("  – ".into(), |share| format!("{share:.2}"));
    let interval = row.right_interval;
    let ends = interval.map_or("–".into(), |i| format!("{:.2} to {:.2}", i.low, i.high));
    let ends = pad(&ends, 12);
    let whole = format!(" {number}  {ends}  {right} of {asked}");
    let techniques = row
        .configuration
        .techniques
        .map_or("–".into(), |t| t.to_string());
    let room = |tail: &str| width.saturating_sub(2 + 11 + tail.width()).min(BAR.0);
    let tail = if room(&whole) < BAR.1 {
        format!(" {number}")
    } else {
        whole
    };
    let room = room(&tail);
    let cell = |share: f64| (share * room as f64).round() as usize;
    let long = cell(share.unwrap_or(0.0));
    let (low, high) = interval.map_or((long, long), |i| (cell(i.low), cell(i.high)));
    let low = low.min(long);
    let high = high.max(long);
    let chosen = place == results.selected;
    let style = Style::new().fg(if chosen { theme.accent } else { theme.dim });
    Line::from(vec![
        Span::raw(if chosen { "▸ " } else { "  " }),
        Span::raw(pad(&techniques, 11)),
        Span::styled("█".repeat(low), style),
        Span::styled("▓".repeat(long - low), style),
        Span::styled("░".repeat(high - long), style),
        Span::raw(" ".repeat(room - high)),
        Span::raw(tail),
    ])
}

/// Columns of the window, and of what stands in a line of it.
const COLUMNS: u16 = 116;
const NAME: usize = 32;

/// Columns for the truth at least: with fewer it stands below the list alone.
const MIN_TRUTH_COLUMNS: usize = 16;

/// Lines below the list, for the truth of the selected line.
const TRUTH_LINES: u16 = 3;

/// Draws the list; gives where it stands.
pub fn draw_choice(
    frame: &mut Frame<'_>,
    body: Rect,
    model: &Model,
    selected: usize,
) -> ResultsDrawn {
    let (theme, offers) = (&model.theme, &model.results.offers);
    let lines = u16::try_from(offers.len()).unwrap_or(u16::MAX);
    let height = lines.saturating_add(TRUTH_LINES + 2);
    let title = "answers to count";
    let inner = window::window(frame, body, model, title, (COLUMNS, height));
    let [list, below] =
        Layout::vertical([Constraint::Min(1), Constraint::Length(TRUTH_LINES)]).areas(inner);
    let rows = usize::from(list.height);
    let top = (selected + 1).saturating_sub(rows);
    let shown = offers.iter().enumerate().skip(top).take(rows);
    let line = |(place, offer): (usize, &CountingChoice)| {
        let chosen = place == selected;
        let line = choice_line(model, offer, chosen, usize::from(list.width));
        if chosen {
            theme.select(line)
        } else {
            line.style(theme.base())
        }
    };
    frame.render_widget(Paragraph::new(shown.map(line).collect::<Vec<_>>()), list);
    if let Some(offer) = offers.get(selected) {
        let words = match offer.truth.as_str() {
            "" => format!("\ntruth: {}", TruthChoice::Usual.label()),
            truth => format!("\ntruth: {}", visible(truth)),
        };
        let text = Paragraph::new(words).wrap(Wrap { trim: true });
        frame.render_widget(text.style(Style::new().fg(theme.dim)), below);
    }
    ResultsDrawn {
        list,
        top,
        ..ResultsDrawn::default()
    }
}

fn choice_line(model: &Model, offer: &CountingChoice, chosen: bool, width: usize) -> Line<'static> {
    let dim = Style::new().fg(model.theme.dim);
    let begun = offer.created_ms.map_or(String::new(), date);
    let progress = offer.progress;
    let done = match progress.all() {
        0 => String::new(),
        all => format!(
            "{} of {}",
            // As `evaluate list` has it.
            thousands(progress.answered),
            thousands(all)
        ),
    };
    let sign = if model.results.counting == Some(offer.counting) {
        "*"
    } else {
        " "
    };
    let head = format!(
        "{sign} {}",
        pad(&fit(&offer.counting.to_string(), NAME), NAME)
    );
    let tail = format!(" {} {}  ", pad(&begun, 16), pad(&done, 15));
    let left = width.saturating_sub(2 + 2 + NAME + 1 + 16 + 1 + 15 + 2);
    Line::from(vec![
        Span::raw(if chosen { "▸ " } else { "  " }),
        Span::raw(head),
        Span::styled(tail, dim),
        Span::raw(if left < MIN_TRUTH_COLUMNS {
            String::new()
        } else {
            fit(&visible(&offer.truth), left)
        }),
    ])
}
