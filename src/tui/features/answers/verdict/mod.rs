//! Verdicts side by side, the built-in judge last; differences from it are marked.

pub mod table;

use nearmiss_scene::description::visible;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::{Moment, Motion, ParsedAnswer, Task, Verdict};
use nearmiss_store::{Origin, RunId};
use nearmiss_study::evaluation::{Answer, JudgeOutcome, StoredOrigin, motion_lines};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use super::obstacles::{self, bare};
use crate::action::Action;
use crate::model::{Answers, Column, Model, Pane, Progress, ShownAnswer, parts};
use crate::widgets::words::{date, fit};
use crate::widgets::{row, unbroken, window};
use table::{LABEL, Row, Table};

/// Columns that an answer needs, and from which columns of the pane on it has more.
const NARROWEST: usize = 8;
const WIDER: usize = 10;
const WIDE: usize = 60;

/// Columns that an answer needs in a pane of so many.
fn narrowest(room: usize) -> usize {
    if room >= WIDE { WIDER } else { NARROWEST }
}

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    // Inside the border, without the column of the scroll bar.
    let room = usize::from(area.width).saturating_sub(3);
    let seen_now = seen(&model.answers, room);
    let title = title(model, &seen_now, usize::from(area.width));
    let inner = window::pane(f, area, model, Pane::Verdict, title);
    let answers = &model.answers;
    let named = obstacles::named(model);
    let draw = |f: &mut Frame<'_>, inner: Rect, text| {
        row::text(
            f,
            inner,
            model,
            Pane::Verdict,
            text,
            Some(top_with_cursor(model, &named, usize::from(inner.height))),
        );
    };
    let other = matches!(model.task, Task::Attacker | Task::Trajectory);
    if other && model.scene().is_some() {
        let text = without_reference(model, seen_now, usize::from(inner.width));
        draw(f, inner, text);
        return;
    }
    let reference = answers.reference.as_ref();
    if !model.has_reference() {
        let dim = Style::new().fg(model.theme.dim);
        let error = model.open_error.clone();
        let words = error.unwrap_or_else(|| model.without_ego());
        let text = Text::styled(
            nearmiss_scene::description::visible(&words).into_owned(),
            dim,
        );
        draw(f, inner, text);
        return;
    }
    let verdict = reference.map(|r| &r.verdict);
    let seen = seen(answers, room);
    let columns = &answers.columns[seen.clone()];
    // Beside answers that state no probability, that of the built-in judge tells nothing.
    let alone = verdict.filter(|_| columns.is_empty());
    let rows = Row::visible(
        differ(columns),
        known(verdicts(columns).chain(alone)),
        columns.iter().any(|c| other_window(model, c)),
        answers.reference_ms.is_some() || columns.iter().any(is_measured),
    );
    let mut table = Table::new(model, rows);
    let ids: Vec<&str> = answers.columns[seen.clone()]
        .iter()
        .map(|c| c.model.as_str())
        .collect();
    // A gap behind each; the last column, the built-in judge's, needs none.
    let room = usize::from(inner.width).saturating_sub(LABEL + 1);
    let plotted = model.plot.measure.id == "risk" && model.plot.drives.is_none();
    let before = if plotted { LETTER } else { 0 };
    let widths = widths(&ids, Some(NARROWEST), (narrowest(room), before), room);
    let heads = of_models(&ids, &widths, before);
    for ((i, head), width) in seen.clone().zip(&heads).zip(&widths) {
        let letter = obstacles::letter(i).filter(|_| plotted);
        let head = &letter.map_or(head.clone(), |letter| format!("{letter} {head}"));
        let column = &answers.columns[i];
        let truth = column.truth_or(verdict);
        table.set_width(*width);
        table.set_color(obstacles::color(&model.theme, i));
        table.column(column, head, truth, answers.shown == ShownAnswer::Column(i));
    }
    table.set_width(widths.last().copied().unwrap_or(NARROWEST));
    table.reference(answers, verdict);
    let mut lines = table.lines();
    let mut below = inner;
    // The names of the columns stay in sight.
    if inner.height > LEAST_BELOW {
        let [first, rest] =
            Layout::vertical([Constraint::Length(1), Constraint::Min(0)]).areas(inner);
        f.render_widget(lines.remove(0), first);
        below = rest;
    }
    let mut text = Text::from(lines);
    text.extend(notes(model));
    // A column is left for the scroll bar.
    let table = obstacles::lines(model, &named, seen, &widths);
    let mut above = text.clone();
    above.extend(table.iter().take(2).cloned());
    let above = Paragraph::new(unbroken::text(above)).wrap(Wrap { trim: false });
    let rows = above.line_count(inner.width.saturating_sub(1));
    model.drawn.set_obstacles(rows);
    text.extend(table);
    text.extend(failures(model));
    text.push_line("");
    text.extend(comment(model, reference));
    draw(f, below, text);
}

/// Fewest rows that are left for what scrolls below the names of the columns.
const LEAST_BELOW: u16 = 3;

/// The task and which answers are in sight, with the keys to others; the header has the task where there is little room.
fn title(model: &Model, seen: &std::ops::Range<usize>, width: usize) -> Line<'static> {
    let mut title = vec![Span::raw("verdict")];
    let task = Span::raw(format!(" · {}", model.task.name()));
    let window = model.short_window().map(|steps| {
        let words = format!(" · {steps}-step window");
        Span::styled(words, Style::new().fg(model.theme.warning))
    });
    let key = |action| model.look.key(action);
    let keys = format!(
        "{} {}",
        key(Action::PreviousAnswer),
        key(Action::NextAnswer)
    );
    let (first, last, all) = (seen.start + 1, seen.end, model.answers.columns.len());
    let of_all = |word: &str, which: String| {
        vec![
            format!(" · {word} {which} of {all}, {keys} others"),
            format!(" {word} {which} of {all} {keys}"),
            format!(" {which} of {all} {keys}"),
        ]
    };
    let hints = match seen.len() {
        0 => Vec::new(),
        1 if all == 1 => Vec::new(),
        count if count == all => vec![format!(" · {keys} select answer"), format!(" · {keys}")],
        1 => of_all("answer", first.to_string()),
        _ => of_all("answers", format!("{first}–{last}")),
    };
    // Inside the corners, with a space on both sides.
    let used = 4 + title[0].width() + window.as_ref().map_or(0, Span::width);
    let left = width.saturating_sub(used);
    let beside_task = left.saturating_sub(task.width());
    let mut fits = hints.iter().find(|hint| hint.width() <= beside_task);
    if fits.is_none() && seen.len() < all {
        fits = hints.iter().find(|hint| hint.width() <= left);
    } else {
        title.push(task);
    }
    let hint = fits.cloned().unwrap_or_default();
    title.push(Span::styled(hint, Style::new().fg(model.theme.dim)));
    title.extend(window);
    Line::from(title)
}

/// The line that the pane of so many rows begins with: the obstacle that the keys stand on is in sight.
fn top_with_cursor(model: &Model, named: &[i64], rows: usize) -> usize {
    let top = model.answers.verdict_top;
    let cursor = model
        .answers
        .cursor
        .filter(|_| model.focus == Pane::Verdict);
    let place = cursor.and_then(|id| named.iter().position(|known| *known == id));
    place.map_or(top, |place| {
        let line = model.drawn.obstacles() + place;
        top.min(line).max((line + 1).saturating_sub(rows))
    })
}

/// How many requests failed.
fn failures(model: &Model) -> Option<Line<'static>> {
    let failed = model.answers.columns.iter().filter(|c| c.failed()).count();
    let key = model.look.key(Action::NextAnswer);
    let words = format!("{failed} failed; {key} shows why");
    (failed > 1).then(|| Line::styled(words, Style::new().fg(model.theme.warning)))
}

/// Answers to a task about which the built-in judge says nothing.
fn without_reference(model: &Model, seen: std::ops::Range<usize>, room: usize) -> Text<'static> {
    let answers = &model.answers;
    let dim = Style::new().fg(model.theme.dim);
    if seen.is_empty() {
        let hint = format!(
            "only language models answer this task: {} chooses one, {} asks it",
            model.look.key(Action::ChooseModel),
            model.look.key(Action::Run)
        );
        return Text::styled(hint, dim);
    }
    let measured = answers.columns[seen.clone()].iter().any(is_measured);
    let ways = differ(&answers.columns[seen.clone()]);
    let rows = Row::visible(ways, (false, false), false, measured);
    let mut table = Table::new(model, rows);
    let ids: Vec<&str> = answers.columns[seen.clone()]
        .iter()
        .map(|c| c.model.as_str())
        .collect();
    let room = room.saturating_sub(LABEL + 1);
    let widths = widths(&ids, None, (NARROWEST, 0), room);
    let heads = of_models(&ids, &widths, 0);
    for ((i, head), width) in seen.zip(&heads).zip(&widths) {
        let shown = answers.shown == ShownAnswer::Column(i);
        table.set_width(*width);
        table.column(&answers.columns[i], head, None, shown);
    }
    let mut text = Text::from(table.lines());
    text.push_line("");
    text.extend(notes(model));
    text.extend(of_column(model));
    text
}

/// The letter of an answer in the plot and a space, before its name.
const LETTER: usize = 2;

/// The heads of answers with a gap behind each, and so many columns left before them.
fn of_models(ids: &[&str], widths: &[usize], before: usize) -> Vec<String> {
    let rooms = widths.iter().map(|width| width.saturating_sub(1 + before));
    heads(ids, &rooms.collect::<Vec<_>>())
}

/// The answers that fit beside the built-in judge, the shown one among them.
fn seen(answers: &Answers, room: usize) -> std::ops::Range<usize> {
    let fit = (room.saturating_sub(LABEL) / narrowest(room))
        .saturating_sub(1)
        .max(1);
    let count = answers.columns.len();
    let wanted = match answers.shown {
        ShownAnswer::Column(i) => (i + 1).max(fit),
        ShownAnswer::Reference => fit,
    };
    let last = wanted.min(count);
    last.saturating_sub(fit)..last
}

/// Whether not all in sight were asked from the same frame, with the same techniques, and with the same prompt.
fn differ(columns: &[Column]) -> [bool; 3] {
    let ways: Vec<_> = columns.iter().map(|c| parts(&c.how)).collect();
    let pairs = || ways.windows(2).map(|pair| (pair[0], pair[1]));
    [
        pairs().any(|(a, b)| a.0 != b.0),
        pairs().any(|(a, b)| a.1 != b.1),
        pairs().any(|(a, b)| a.2 != b.2),
    ]
}

/// Whether time or tokens of an answer are known, or still being counted: recorded answers have neither.
fn is_measured(column: &Column) -> bool {
    column.answer().is_none_or(|answer| {
        let consumed = &answer.consumed;
        consumed.duration_ms.or(consumed.output_tokens).is_some()
    })
}

/// Whether the built-in judge's column is about another window than the answer.
fn other_window(model: &Model, column: &Column) -> bool {
    let now = model.window().map(|w| (w.first(), w.last()));
    model.task == Task::Safety && column.steps.is_some() && column.steps != now
}

/// Whence an answer of the store.
fn stored(past: &StoredOrigin, run: Option<RunId>) -> String {
    let run = run.map_or("stored".into(), |run| format!("run {run}"));
    let at = date(past.created_ms);
    match past.origin {
        Origin::Asked => format!("{run}, asked {at}"),
        Origin::Replayed => format!("{run}, replayed: asked {at} elsewhere"),
        Origin::Recorded => format!("{run}, imported"),
    }
}

/// The shown answer's comment, or what is critical to the built-in judge: the reasoning begins with its comment.
fn comment(model: &Model, reference: Option<&judge::Judgement>) -> Text<'static> {
    match model.answers.column() {
        None => {
            let mut text = Text::default();
            let dim = Style::new().fg(model.theme.dim);
            match reference {
                Some(judged) => text.extend(critical(&judged.verdict, dim)),
                None => text.push_line(Line::styled("judging…", model.theme.base())),
            }
            if model.answers.columns.is_empty() {
                let key = |action| model.look.key(action);
                let hint = format!(
                    "{} chooses a language model, {} asks it, {} asks another one",
                    key(Action::ChooseModel),
                    key(Action::Run),
                    key(Action::Compare)
                );
                text.push_line(Line::styled(hint, dim));
            }
            text
        }
        Some(_) => of_column(model),
    }
}

/// Whence the shown answer is, and what is doubtful in it.
fn notes(model: &Model) -> Text<'static> {
    let theme = &model.theme;
    let warning = Style::new().fg(theme.warning);
    let words = |s: &str| nearmiss_scene::description::visible(s).into_owned();
    let mut text = Text::default();
    if let Some(answer) = model.answers.column().and_then(Column::answer) {
        let dim = Style::new().fg(theme.dim);
        text.extend(answer.verdict().and_then(|verdict| critical(verdict, dim)));
        if let Some(past) = &answer.past {
            let words = stored(past, answer.run);
            text.push_line(Line::styled(words, Style::new().fg(theme.dim)));
        }
        if answer.model_differs() {
            let returned = answer.model_returned.as_deref().unwrap_or_default();
            text.push_line(Line::styled(
                words(&format!("answered by {returned}")),
                warning,
            ));
        }
        let scenario = model.opened.as_ref().map(|o| &o.scenario);
        for flag in scenario.map_or(Vec::new(), |s| answer.flags(s)) {
            text.push_line(Line::styled(format!("doubtful: {flag}"), warning));
        }
        if !answer.repairs().is_empty() {
            let notes = format!("* repaired: {}", answer.repairs().join("; "));
            text.push_line(Line::styled(words(&notes), warning));
        }
    }
    text
}

/// The shown answer's comment.
fn of_column(model: &Model) -> Text<'static> {
    let theme = &model.theme;
    let warning = Style::new().fg(theme.warning);
    let words = |s: &str| nearmiss_scene::description::visible(s).into_owned();
    let mut text = Text::default();
    match model.answers.column() {
        None => {}
        Some(column) => match column.answer() {
            Some(answer) => match &answer.judged {
                JudgeOutcome::Verdict(parsed) => {
                    text.extend(Text::styled(
                        words(&parsed.verdict.justification),
                        theme.base(),
                    ));
                }
                JudgeOutcome::Other(reading) => {
                    text.extend(answer_text(model, &reading.said));
                }
                JudgeOutcome::Missing(missing) => {
                    text.push_line(Line::styled(words(&missing.to_string()), warning));
                }
            },
            None => {
                if let Progress::Unasked(why) | Progress::Broken(why) | Progress::Retrying(why) =
                    &column.progress
                {
                    text.push_line(Line::styled(words(why), warning));
                }
            }
        },
    }
    text
}

/// Columns of answers, and of the built-in judge where `last` names what it needs: as much as each needs, and what is
/// left in equal parts; where there is less, the widest get less. An answer needs `least`, and `before` columns, its model
/// without the provider, and a gap.
fn widths(
    ids: &[&str],
    last: Option<usize>,
    (least, before): (usize, usize),
    room: usize,
) -> Vec<usize> {
    let answers = ids
        .iter()
        .map(|id| least.max(before + bare(id).width() + 1));
    let needed: Vec<usize> = answers.chain(last).collect();
    let count = needed.len().max(1);
    let sum: usize = needed.iter().sum();
    if sum <= room {
        let share = (room - sum) / count;
        return needed.into_iter().map(|width| width + share).collect();
    }
    // The narrow ones get what they need, the others share what is left.
    let (mut share, mut narrow) = (room / count, 0);
    loop {
        let within = || needed.iter().filter(|width| **width <= share);
        let taken: usize = within().sum();
        let (few, others) = (within().count(), count - within().count());
        if few == narrow || others == 0 {
            break;
        }
        (share, narrow) = (room.saturating_sub(taken) / others, few);
    }
    let mut widths: Vec<usize> = needed.iter().map(|width| share.min(*width)).collect();
    // What equal shares leave goes to those that need least.
    let mut spare = room.saturating_sub(widths.iter().sum());
    let mut order: Vec<usize> = (0..widths.len()).collect();
    order.sort_by_key(|place| needed[*place]);
    for place in order {
        let more = spare.min(needed[place] - widths[place]);
        widths[place] += more;
        spare -= more;
    }
    widths
}

/// Models' ids in so many columns each: whole, or without their provider, and then with their beginning. Of those that
/// would read the same, as much of the provider is left as tells them apart, or what differs stands behind their
/// beginning. The title of the reasoning has them whole.
fn heads(ids: &[&str], widths: &[usize]) -> Vec<String> {
    let width = |i: usize| widths.get(i).copied().unwrap_or(0);
    let plain = ids.iter().enumerate();
    let plain: Vec<String> = plain.map(|(i, id)| short(id, 0, width(i))).collect();
    let alike = |i: usize, heads: &[String]| {
        (0..ids.len()).any(|j| ids[j] != ids[i] && heads[j] == heads[i])
    };
    let longest = ids.iter().filter_map(|id| id.find('/')).max().unwrap_or(0);
    let mut best = plain.clone();
    for letters in 1..=longest {
        let unclear: Vec<usize> = (0..ids.len()).filter(|i| alike(*i, &best)).collect();
        if unclear.is_empty() {
            break;
        }
        // All that read alike change together, also those that another one of them has just left alone.
        for i in (0..ids.len()).filter(|i| alike(*i, &plain)) {
            best[i] = short(ids[i], letters, width(i));
        }
    }
    let unclear: Vec<usize> = (0..ids.len()).filter(|i| alike(*i, &best)).collect();
    let names = unclear.iter().map(|i| bare(ids[*i]));
    let same = names
        .clone()
        .map(|name| same_start(name, names.clone()))
        .min();
    for i in unclear {
        best[i] = from_difference(bare(ids[i]), same.unwrap_or(0), width(i));
    }
    best
}

/// The bytes in which a name begins as others do that are not the same: the fewest.
fn same_start<'n>(name: &str, others: impl Iterator<Item = &'n str>) -> usize {
    let start = |other: &str| {
        let pairs = name.chars().zip(other.chars());
        pairs
            .take_while(|(a, b)| a == b)
            .map(|(a, _)| a.len_utf8())
            .sum()
    };
    others
        .filter(|other| *other != name)
        .map(start)
        .min()
        .unwrap_or(0)
}

/// A name from where it differs from others on, behind its first letters.
fn from_difference(name: &str, at: usize, width: usize) -> String {
    let letters = width.saturating_sub(1 + name[at..].width()).max(width / 3);
    let begin: String = name.chars().take(letters).collect();
    if at <= begin.len() {
        return fit(name, width);
    }
    fit(&format!("{begin}…{}", &name[at..]), width)
}

/// An id within `width` columns, with `letters` of its provider if it does not fit whole.
fn short(id: &str, letters: usize, width: usize) -> String {
    match id.split_once('/') {
        Some((provider, model)) if id.width() > width || letters == 0 => {
            let some: String = provider.chars().take(letters).collect();
            if some.is_empty() {
                fit(model, width)
            } else {
                fit(&format!("{some}/{model}"), width)
            }
        }
        _ => fit(id, width),
    }
}

/// The label of the table's second row.
fn detail_label(task: Task) -> &'static str {
    match task {
        Task::Collision | Task::Safety | Task::Recording => "who",
        Task::Attacker => "others",
        Task::Trajectory => "motion",
    }
}

/// The cells of an answer: what it says, the row below, and the risk or the time.
fn cells(said: &ParsedAnswer) -> [String; 3] {
    let dash = || "–".to_string();
    match said {
        ParsedAnswer::Verdict(_) => [dash(), dash(), dash()],
        ParsedAnswer::Attacker(choice) => {
            let of = |id: i64| choice.obstacles.iter().find(|o| o.id == id);
            let risk = choice.attacker.and_then(of).map(|o| o.risk_score);
            let others = choice
                .obstacles
                .iter()
                .map(|o| o.id)
                .filter(|id| Some(*id) != choice.attacker)
                .count();
            [
                choice.attacker.map_or("none".into(), |id| id.to_string()),
                others.to_string(),
                risk.map_or_else(dash, |risk| risk.to_string()),
            ]
        }
        ParsedAnswer::Trajectory(new) => {
            let (motion, when) = match &new.motion {
                Motion::Manoeuvre(m) => (
                    m.kind.name().to_string(),
                    format!("{:.1} s +{:.1} s", m.start, m.duration),
                ),
                Motion::Waypoints(points) => {
                    let ends = points.first().zip(points.last());
                    let when = ends.map(|(a, b)| format!("{}–{}", moment(a.at), moment(b.at)));
                    (
                        format!("{} points", points.len()),
                        when.unwrap_or_else(dash),
                    )
                }
            };
            [new.obstacle.to_string(), motion, when]
        }
    }
}

impl Table<'_> {
    /// An answer that is no yes or no.
    pub fn other(&mut self, answer: &Answer) {
        let JudgeOutcome::Other(reading) = &answer.judged else {
            return;
        };
        let base = self.model.theme.base();
        let [says, who, risk] = cells(&reading.said);
        let repaired = if answer.repairs().is_empty() {
            ""
        } else {
            " *"
        };
        let bold = base.add_modifier(Modifier::BOLD);
        self.cell(Row::Says, &format!("{says}{repaired}"), bold);
        self.cell(Row::Who, &who, base);
        self.cell(Row::Risk, &risk, base);
    }
}

fn moment(at: Moment) -> String {
    match at {
        Moment::Step(step) => step.to_string(),
        Moment::Seconds(seconds) => format!("{seconds:.1} s"),
    }
}

/// Everything that an answer says.
fn answer_text(model: &Model, said: &ParsedAnswer) -> Text<'static> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let justification = visible(said.justification()).into_owned();
    let mut text = Text::styled(justification, theme.base());
    match said {
        ParsedAnswer::Verdict(_) => {}
        ParsedAnswer::Attacker(choice) => {
            for o in &choice.obstacles {
                let sign = if choice.attacker == Some(o.id) {
                    "▸"
                } else {
                    " "
                };
                let line = format!("{sign} {} risk {}: {}", o.id, o.risk_score, o.reason);
                let style = Style::new().fg(theme.risk(f64::from(o.risk_score)));
                text.push_line(Line::styled(visible(&line).into_owned(), style));
            }
        }
        ParsedAnswer::Trajectory(new) => {
            for line in motion_lines(&new.motion) {
                text.push_line(Line::styled(line, dim));
            }
        }
    }
    text
}

/// Whether a verdict states a probability, and whether one has log probabilities.
fn known<'a>(verdicts: impl Iterator<Item = &'a Verdict>) -> (bool, bool) {
    verdicts.fold((false, false), |(stated, tokens), verdict| {
        (
            stated || verdict.probability.is_some(),
            tokens || verdict.token_probability.is_some(),
        )
    })
}

/// The verdicts of answers.
fn verdicts(columns: &[Column]) -> impl Iterator<Item = &Verdict> {
    columns.iter().filter_map(|c| c.answer()?.verdict())
}

impl Table<'_> {
    /// The probabilities of a yes; a dash where one is not known, nothing of answers that are yet to come.
    pub fn probabilities(&mut self, verdict: Option<&Verdict>, style: Style) {
        let words = |p: Option<f64>| p.map_or("–".to_string(), two);
        let stated = words(verdict.and_then(|v| v.probability));
        let tokens = words(verdict.and_then(|v| v.token_probability));
        self.cell(Row::Probability, &stated, style);
        self.cell(Row::TokenProbability, &tokens, style);
    }
}

/// The critical obstacles with their probabilities: `critical: 301 (0.90), 305 (0.20)`; nothing where none has one.
fn critical(verdict: &Verdict, style: Style) -> Option<Line<'static>> {
    let all = verdict.critical.as_ref()?;
    all.iter().find_map(|one| one.probability)?;
    let each = all.iter().map(|one| match one.probability {
        Some(p) => format!("{} ({})", one.id, two(p)),
        None => one.id.to_string(),
    });
    let words = format!("critical: {}", each.collect::<Vec<_>>().join(", "));
    Some(Line::styled(words, style))
}

/// A probability with two decimals.
fn two(probability: f64) -> String {
    format!("{probability:.2}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_read_the_same_keeps_a_part_of_its_provider() {
        let two = ["recorded/gpt-4o", "openai/gpt-4o"];
        assert_eq!(heads(&two, &[20, 20]), two);
        assert_eq!(heads(&two, &[10, 10]), ["r/gpt-4o", "o/gpt-4o"]);
        let narrow = heads(&two, &[7, 7]);
        assert_ne!(narrow[0], narrow[1], "{narrow:?}");
        assert!(narrow.iter().all(|head| head.width() <= 7), "{narrow:?}");
        let providers = ["openrouter/gpt-4o", "openai/gpt-4o"];
        assert_eq!(
            heads(&providers, &[12, 12]),
            ["openr/gpt-4o", "opena/gpt-4o"]
        );
    }

    #[test]
    fn what_differs_within_names_is_kept() {
        let three = [
            "lab/qwen2.5-vl-7b-instruct",
            "lab/qwen2.5-vl-72b-instruct",
            "lab/gpt-4o",
        ];
        let cut = heads(&three, &[12, 12, 12]);
        assert_eq!(cut, ["qwen…b-inst…", "qwen…2b-ins…", "gpt-4o"]);
        let tour = ["example/example-a", "example/example-b"];
        assert_eq!(heads(&tour, &[5, 5]), ["exa…a", "exa…b"]);
        assert_eq!(heads(&["lab/deepseek-chat"], &[12]), ["deepseek-ch…"]);
    }

    #[test]
    fn what_is_clear_or_the_same_stays_short() {
        let clear = ["openai/gpt-4o-mini", "gemini/gemini-2.5-pro"];
        assert_eq!(heads(&clear, &[11, 11]), ["gpt-4o-mini", "gemini-2.5…"]);
        let same = ["openai/gpt-4o-mini", "openai/gpt-4o-mini"];
        assert_eq!(heads(&same, &[11, 11]), ["gpt-4o-mini"; 2]);
        assert_eq!(heads(&[], &[]), [""; 0]);
    }

    #[test]
    fn columns_are_as_wide_as_their_heads() {
        let ids = ["lab/pyro-8b", "lab/sage-70b", "lab/pyro-8b", "lab/sage-70b"];
        let widths = |ids: &[&str], last, room| widths(ids, last, (8, 0), room);
        let narrow = widths(&ids, Some(8), 43);
        assert_eq!(narrow, [8, 9, 8, 9, 8]);
        assert_eq!(
            heads(&ids, &[7, 8, 7, 8]),
            ["pyro-8b", "sage-70b"].repeat(2)
        );
        assert_eq!(
            super::widths(&ids, Some(8), (8, LETTER), 50),
            [10, 11, 10, 11, 8],
            "with the letters"
        );
        assert_eq!(
            widths(&["lab/a-very-long-name", "a/b"], Some(8), 30),
            [14, 8, 8]
        );
        assert_eq!(
            widths(&ids, Some(8), 20),
            [4; 5],
            "never more than there is"
        );
        let paper = ["r/deepseek-chat", "r/gemini-1.5-pro", "r/gpt-4o"];
        assert_eq!(
            super::widths(&paper, Some(8), (8, LETTER), 33),
            [8, 8, 9, 8],
            "what is left makes one whole"
        );
        assert_eq!(widths(&[], Some(8), 20), [20]);
        assert_eq!(widths(&[], None, 20), [0; 0]);
    }
}
