//! The table of verdicts: a row a question, a column an answer.

use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use strum::VariantArray;
use unicode_width::UnicodeWidthStr;

use super::super::obstacles::{foremost_scores, names_right};
use crate::model::{Answers, Column, Model, Progress, ShownAnswer, parts};
use crate::widgets::words::{duration, fit, fit_end, fit_middle, pad, short_techniques, thousands};
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::Origin;
use nearmiss_study::evaluation::{Answer, JudgeOutcome, MissingVerdict};

/// Columns of the names of the rows.
pub const LABEL: usize = 10;
/// The built-in judge's name here.
const BUILT_IN: &str = "built-in";

/// A row of the table, in their order: what tells columns apart comes first, then what geometry judges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, VariantArray)]
pub enum Row {
    Head,
    /// From where the scene was described.
    Frame,
    /// The techniques.
    How,
    /// The template, where it is not the shipped one.
    Prompt,
    /// Yes or no.
    Says,
    Who,
    Risk,
    /// The built-in judge's verdict on the answer's own window.
    Truth,
    /// The probability of a yes that the answer states.
    Probability,
    /// The same by log probabilities.
    TokenProbability,
    Steps,
    Tokens,
    Time,
}

impl Row {
    /// The rows that are needed.
    pub fn visible(
        [frames, techniques, prompts]: [bool; 3],
        (stated, tokens): (bool, bool),
        truth: bool,
        measured: bool,
    ) -> Vec<Self> {
        let needed = |row: &Self| match row {
            Self::Frame => frames,
            Self::How => techniques,
            Self::Prompt => prompts,
            Self::Probability => stated,
            Self::TokenProbability => tokens,
            Self::Truth => truth,
            Self::Tokens | Self::Time => measured,
            _ => true,
        };
        Self::VARIANTS.iter().copied().filter(needed).collect()
    }

    fn label(self, task: Task) -> String {
        match self {
            Self::Head => "",
            Self::Frame => "frame",
            Self::How => "technique",
            Self::Prompt => "prompt",
            Self::Says => {
                return task
                    .key()
                    .replace("safety_critical", "critical")
                    .replace('_', " ");
            }
            Self::Who => return super::detail_label(task).into(),
            Self::Probability => "P(yes)",
            Self::TokenProbability => "by tokens",
            Self::Truth => "truth",
            Self::Steps => "steps",
            Self::Risk if task == Task::Trajectory => "when",
            Self::Risk => "risk",
            Self::Tokens => "tokens",
            Self::Time => "time",
        }
        .into()
    }
}

/// The table while it is filled, column by column.
pub struct Table<'a> {
    pub model: &'a Model,
    /// Columns of the terminal of the answer that is put in.
    width: usize,
    /// The colour of its name.
    color: Color,
    rows: Vec<(Row, Line<'static>)>,
}

impl<'a> Table<'a> {
    /// The names of the rows.
    pub fn new(model: &'a Model, rows: Vec<Row>) -> Self {
        let dim = Style::new().fg(model.theme.dim);
        let labelled = |row: Row| {
            let label = pad(&row.label(model.task), LABEL);
            (row, Line::from(Span::styled(label, dim)))
        };
        Self {
            model,
            width: 0,
            color: model.theme.title,
            rows: rows.into_iter().map(labelled).collect(),
        }
    }

    /// Columns of the terminal that the next answer takes.
    pub fn set_width(&mut self, width: usize) {
        self.width = width;
    }

    /// The colour of the name of the next answer.
    pub fn set_color(&mut self, color: Color) {
        self.color = color;
    }

    /// The filled table.
    pub fn lines(self) -> Vec<Line<'static>> {
        self.rows.into_iter().map(|(_, line)| line).collect()
    }

    fn push(&mut self, row: Row, span: Span<'static>) {
        if let Some((_, line)) = self.rows.iter_mut().find(|(r, _)| *r == row) {
            line.push_span(span);
        }
    }

    pub fn cell(&mut self, row: Row, text: &str, style: Style) {
        let cell = format!("{} ", pad(text, self.width.saturating_sub(1)));
        self.push(row, Span::styled(cell, style));
    }

    fn head(&mut self, name: &str, shown: bool) {
        // A gap behind it, but for the last column.
        let gap = usize::from(name != BUILT_IN);
        let name = fit(name, self.width.saturating_sub(gap));
        let style = if shown {
            Style::new()
                .fg(self.color)
                .add_modifier(Modifier::BOLD | Modifier::UNDERLINED)
        } else {
            Style::new().fg(self.color)
        };
        let rest = " ".repeat(self.width.saturating_sub(name.width()));
        self.push(Row::Head, Span::styled(name, style));
        self.push(Row::Head, Span::raw(rest));
    }

    /// The built-in judge, about the window at the current step.
    pub fn reference(&mut self, answers: &Answers, verdict: Option<&Verdict>) {
        self.color = self.model.theme.text;
        self.head(BUILT_IN, answers.shown == ShownAnswer::Reference);
        let Some(verdict) = verdict else {
            let dim = Style::new().fg(self.model.theme.dim);
            for row in [
                Row::Says,
                Row::Probability,
                Row::TokenProbability,
                Row::Who,
                Row::Risk,
                Row::Steps,
                Row::Tokens,
                Row::Time,
            ] {
                self.cell(row, "…", dim);
            }
            return;
        };
        let base = self.model.theme.base();
        let color = if verdict.dangerous {
            self.model.theme.danger
        } else {
            self.model.theme.danger_low
        };
        self.cell(
            Row::Says,
            yes(verdict.dangerous),
            Style::new().fg(color).add_modifier(Modifier::BOLD),
        );
        self.probabilities(Some(verdict), base);
        self.cell(Row::Who, &who(verdict), base);
        self.cell(Row::Risk, &risk(verdict), base);
        let window = self.model.window().map(|w| (w.first(), w.last()));
        let steps = match verdict.task {
            task if task.is_about_all_steps() => "all".into(),
            _ => window.map_or("–".into(), |told| steps(Some(told))),
        };
        self.cell(Row::Steps, &steps, base);
        self.cell(Row::Tokens, "–", base);
        self.cell(
            Row::Time,
            &answers.reference_ms.map_or("–".into(), duration),
            base,
        );
    }

    /// An answer, held against `truth` where there is one, under a short name of its model.
    pub fn column(&mut self, column: &Column, name: &str, truth: Option<&Verdict>, shown: bool) {
        let theme = &self.model.theme;
        let (base, dim) = (theme.base(), Style::new().fg(theme.dim));
        self.head(name, shown);
        self.way(&column.how, is_imported(column));
        self.truth(column);
        let waiting = match &column.progress {
            Progress::Done(answer) => return self.answer(answer, column.steps, truth),
            Progress::Waiting(_) => "waiting…",
            Progress::Retrying(_) => "retrying…",
            Progress::Arriving(_) => "streaming…",
            Progress::Unasked(_) => self.not_sent(),
            Progress::Broken(_) => "no answer",
        };
        self.cell(Row::Says, waiting, dim);
        let rest = [
            Row::Probability,
            Row::TokenProbability,
            Row::Who,
            Row::Risk,
            Row::Tokens,
        ];
        for row in rest {
            self.cell(row, "", base);
        }
        self.cell(Row::Steps, &steps(column.steps), base);
        let time = match column.progress {
            Progress::Waiting(s) | Progress::Arriving(s) => format!("{s:.0} s"),
            _ => String::new(),
        };
        self.cell(Row::Time, &time, base);
    }

    /// Tokens of question and answer, in full or, where that does not fit, in thousands: a number is never cut.
    fn tokens(&self, input: u64, output: u64) -> String {
        let room = self.width.saturating_sub(1);
        let short = |tokens: u64| match tokens {
            0..1_000 => tokens.to_string(),
            1_000..9_950 => format!("{:.1}k", tokens as f64 / 1e3),
            _ => format!("{:.0}k", tokens as f64 / 1e3),
        };
        let both = [
            format!("{}+{}", thousands(input), thousands(output)),
            format!("{}+{}", short(input), short(output)),
        ];
        let fits = both.into_iter().find(|words| words.width() <= room);
        fits.unwrap_or_else(|| short(input + output))
    }

    /// The label of a question that was never sent.
    fn not_sent(&self) -> &'static str {
        if self.width < LABEL {
            "unsent"
        } else {
            "not sent"
        }
    }

    /// Frame and techniques, where answers differ in them.
    fn way(&mut self, how: &str, imported: bool) {
        let (frame, techniques, prompt) = parts(how);
        let all = [Row::Frame, Row::How, Row::Prompt];
        for (row, words) in all.into_iter().zip([frame, techniques, prompt]) {
            let words = match words {
                "" if row == Row::Prompt && imported => "unknown".into(),
                "" if row == Row::Prompt => "shipped".into(),
                "cartesian" => "cart".into(),
                other => other.to_string(),
            };
            let room = self.width.saturating_sub(1);
            let brief = words.replace("+tools", "+t");
            let short = [&words, &brief].map(|words| short_techniques(words));
            // The word for all techniques is that of the options.
            let least = brief.replace("cp+cot+icl", "all");
            let forms = [&words, &short[0], &brief, &short[1], &least];
            let fitting = forms.into_iter().find(|words| words.width() <= room);
            let style = Style::new().fg(self.model.theme.dim);
            let cell = match (fitting, row) {
                (Some(words), _) => words.clone(),
                // The last technique stays whole, and whether it had tools.
                (None, Row::How) => fit_end(&least, room),
                (None, _) => fit_middle(&words, room),
            };
            self.cell(row, &cell, style);
        }
    }

    /// What `=` and `≠` compare with, where it is not the column of the built-in judge.
    fn truth(&mut self, column: &Column) {
        let computing = column.judging.then(|| "…".to_string());
        let words = column.truth.as_ref().map(|verdict| {
            let yes = yes(verdict.dangerous);
            let Some((id, _)) = verdict.foremost().filter(|_| verdict.dangerous) else {
                return yes.to_string();
            };
            // Where there is no room for both, whom it names says that it says yes.
            let both = format!("{yes} {id}");
            if both.width() < self.width {
                both
            } else {
                id.to_string()
            }
        });
        let style = Style::new().fg(self.model.theme.dim);
        let words = words.or(computing);
        self.cell(Row::Truth, words.as_deref().unwrap_or("unknown"), style);
    }

    fn answer(&mut self, answer: &Answer, told: Option<(i64, i64)>, truth: Option<&Verdict>) {
        let theme = &self.model.theme;
        let (base, dim) = (theme.base(), Style::new().fg(theme.dim));
        let mark = |text: String, same: bool| {
            let color = if same { theme.agree } else { theme.disagree };
            let sign = if same { "=" } else { "≠" };
            (
                format!("{text} {sign}"),
                Style::new().fg(color).add_modifier(Modifier::BOLD),
            )
        };
        // The truth of the safety task is that of a window.
        self.probabilities(answer.verdict(), base);
        let known = truth.filter(|truth| told.is_some() || truth.task != Task::Safety);
        match (answer.verdict(), known) {
            (Some(verdict), None) => {
                self.cell(Row::Says, yes(verdict.dangerous), base);
                self.cell(Row::Who, &who(verdict), base);
                self.cell(Row::Risk, &risk(verdict), base);
            }
            (Some(verdict), Some(truth)) => {
                let repaired = if answer.repairs().is_empty() { "" } else { "*" };
                let (text, style) = mark(
                    format!("{}{repaired}", yes(verdict.dangerous)),
                    verdict.dangerous == truth.dangerous,
                );
                self.cell(Row::Says, &text, style);
                let (text, style) = match names_right(verdict, truth) {
                    Some(right) => mark(who(verdict), right),
                    None => (who(verdict), base),
                };
                self.cell(Row::Who, &text, style);
                let (text, style) = match foremost_scores(verdict, truth) {
                    Some((stated, exact)) if stated != exact => {
                        let (text, style) = mark(stated.to_string(), false);
                        (format!("{text} {exact}"), style)
                    }
                    Some((stated, _)) => mark(stated.to_string(), true),
                    None => (risk(verdict), base),
                };
                self.cell(Row::Risk, &text, style);
            }
            (None, _) if matches!(answer.judged, JudgeOutcome::Other(_)) => self.other(answer),
            (None, _) => {
                let warning = Style::new().fg(theme.warning).add_modifier(Modifier::BOLD);
                let words = match &answer.judged {
                    JudgeOutcome::Missing(MissingVerdict::NoAnswer(_)) => "no answer",
                    JudgeOutcome::Missing(MissingVerdict::NotSent(_)) => self.not_sent(),
                    JudgeOutcome::Missing(MissingVerdict::Cancelled) => "cancelled",
                    _ => "no verdict",
                };
                self.cell(Row::Says, words, warning);
                self.cell(Row::Who, "–", base);
                self.cell(Row::Risk, "–", base);
            }
        }
        let consumed = &answer.consumed;
        let recorded = answer.past.filter(|p| p.origin == Origin::Recorded);
        let tokens = match (consumed.input_tokens, consumed.output_tokens) {
            _ if recorded.is_some() => "–".into(),
            (Some(i), Some(o)) => self.tokens(i, o),
            _ => "unknown".into(),
        };
        self.cell(Row::Steps, &steps(told), dim);
        self.cell(Row::Tokens, &tokens, dim);
        self.cell(
            Row::Time,
            &consumed.duration_ms.map_or("–".into(), duration),
            dim,
        );
    }
}

/// Whether it is an answer of others, whose prompt is not known.
pub fn is_imported(column: &Column) -> bool {
    let past = column.answer().and_then(|answer| answer.past);
    past.is_some_and(|past| past.origin == Origin::Recorded)
}

/// Whom a verdict means: the obstacle that matters most; none where nothing happens.
fn who(verdict: &Verdict) -> String {
    let who = verdict.foremost().filter(|_| verdict.dangerous);
    who.map_or("–".into(), |(id, _)| id.to_string())
}

/// The score of the obstacle that matters most.
fn risk(verdict: &Verdict) -> String {
    let score = verdict.foremost().and_then(|(_, score)| score);
    score.map_or("–".into(), |score| score.to_string())
}

fn steps(told: Option<(i64, i64)>) -> String {
    told.map_or("unknown".into(), |(first, last)| format!("{first}–{last}"))
}

fn yes(dangerous: bool) -> &'static str {
    if dangerous { "yes" } else { "no" }
}
