//! Answer fields, one row each for all answers; rows that differ are marked.

use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};

use crate::features::answers::obstacles::{exact, foremost_scores, names_right};
use crate::features::answers::verdict::table::is_imported;
use crate::model::{Model, Progress, ShownAnswer, parts};
use crate::widgets::claimed;
use crate::widgets::words::{duration, fit, pad};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Verdict;
use nearmiss_store::Choice;
use nearmiss_study::evaluation::{Answer, JudgeOutcome, consumption};

/// A row: its name, its value, and how that is shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    pub name: &'static str,
    pub value: String,
    /// What is exact beside it: whether that is the same, and what it is where that is not clear.
    pub exact: Option<(bool, String)>,
    pub color: Option<Color>,
    /// Whether it says what was judged: those differences count.
    pub counts: bool,
}

impl Field {
    /// Its value, held against what is exact.
    fn words(&self) -> String {
        match &self.exact {
            None => self.value.clone(),
            Some((true, _)) => format!("{} =", self.value),
            Some((false, exact)) => format!("{} ≠ {exact}", self.value).trim_end().into(),
        }
    }
}

/// Columns of the names.
const LABEL: usize = 12;

/// Behind the name of a row in which answers differ from each other.
const DIFFERS: &str = "◆";

/// What the signs in the rows mean.
pub fn legend(all: &[Vec<Field>], differ: &[bool]) -> String {
    let differ = differ
        .contains(&true)
        .then(|| format!("{DIFFERS} answers differ"));
    let is_held = all.iter().flatten().any(|field| field.exact.is_some());
    let exact = is_held.then(|| "= ≠ exact".to_string());
    let parts: Vec<String> = differ.into_iter().chain(exact).collect();
    parts.join(" · ")
}

/// The fields of an answer. While models are hidden, those that could tell them apart are left out for all.
pub fn fields(model: &Model, shown: ShownAnswer) -> Vec<Field> {
    let hides = model.compare.hides();
    let mut fields = Vec::new();
    let mut add = |name, value: String, color, counts| {
        fields.push(Field {
            name,
            value: nearmiss_scene::description::visible(&value).into_owned(),
            exact: None,
            color,
            counts,
        });
    };
    let theme = &model.theme;
    let reference = model.answers.reference.as_ref().map(|r| &r.verdict);
    let (verdict, how, steps, says) = match shown {
        ShownAnswer::Reference => {
            let window = match model.task {
                // It looks at the whole recording.
                task if task.is_about_all_steps() => model.scene().map(|_| model.clock.range()),
                _ => model.window().map(|w| (w.first(), w.last())),
            };
            (
                reference,
                judge::how(judge::MODEL).unwrap_or_default().to_string(),
                window,
                String::new(),
            )
        }
        ShownAnswer::Column(place) => match model.answers.columns.get(place) {
            Some(column) => (
                column.answer().and_then(Answer::verdict),
                column.how.clone(),
                column.steps,
                progress(&column.progress),
            ),
            None => (None, String::new(), None, "gone".into()),
        },
    };
    if !hides {
        let (frame, techniques, template) = parts(&how);
        let asked = [frame, techniques].map(str::trim);
        let asked: Vec<&str> = asked.into_iter().filter(|part| !part.is_empty()).collect();
        add("asked", asked.join(" · "), None, false);
        let column = match shown {
            ShownAnswer::Column(place) => model.answers.columns.get(place),
            ShownAnswer::Reference => None,
        };
        let template = match (template, column) {
            ("", Some(column)) if is_imported(column) => "unknown",
            ("", Some(_)) => "shipped",
            (other, _) => other,
        };
        add("prompt", template.into(), None, false);
    }
    let word = match verdict {
        Some(verdict) => (verdict.word().to_string(), None),
        None => (says, Some(theme.warning)),
    };
    add("verdict", word.0, word.1, true);
    add("P(yes)", probability(verdict, hides), None, false);
    add("who", who(verdict), None, true);
    add("risk", risk(verdict), None, true);
    add(
        "steps",
        steps.map_or("unknown".into(), |(a, b)| format!("{a}–{b}")),
        None,
        false,
    );
    if !hides {
        let consumed = consumed(model, shown);
        add("tokens", consumed.0, None, false);
        add("time · cost", consumed.1, None, false);
    }
    let claims = model.document(shown).map_or(String::new(), |document| {
        let claims = model.claims.get(document.key);
        let unread = model.claims.unread(document.key).len();
        match (document.complete, claims.is_empty(), unread) {
            _ if hides => "hidden until rated".into(),
            (false, ..) => "when complete".into(),
            (true, true, 0) => "none found".into(),
            (true, false, 0) => claimed::short_counts(claims),
            (true, _, unread) => {
                let checked = claimed::short_counts(claims);
                format!("{checked} {unread} not understood")
                    .trim_start()
                    .into()
            }
        }
    });
    add("claims", claims, None, false);
    let column = match shown {
        ShownAnswer::Column(place) => model.answers.columns.get(place),
        ShownAnswer::Reference => None,
    };
    let truth = column.and_then(|column| exact(model, column));
    // Agreement with what is exact would bias the rating.
    if let Some((verdict, truth)) = verdict.zip(truth).filter(|_| !hides) {
        for field in &mut fields {
            let (same, words) = match field.name {
                "verdict" => (verdict.dangerous == truth.dangerous, String::new()),
                "who" => match names_right(verdict, truth) {
                    Some(right) => (right, String::new()),
                    None => continue,
                },
                "risk" => match foremost_scores(verdict, truth) {
                    Some((stated, exact)) => (stated == exact, exact.to_string()),
                    None => continue,
                },
                _ => continue,
            };
            field.exact = Some((same, words));
            field.color = Some(if same { theme.agree } else { theme.disagree });
        }
    }
    fields
}

fn who(verdict: Option<&Verdict>) -> String {
    let Some(verdict) = verdict else {
        return "–".into();
    };
    if !verdict.dangerous {
        return "–".into();
    }
    let lowest = verdict.worst().map(|w| w.risk_score);
    let worst = verdict
        .obstacles
        .iter()
        .filter(|o| Some(o.risk_score) == lowest);
    let ids: Vec<String> = match &verdict.critical {
        Some(critical) if verdict.dangerous && !critical.is_empty() => {
            let named = critical.iter().map(|c| match c.probability {
                Some(p) => format!("{} ({p:.2})", c.id),
                None => c.id.to_string(),
            });
            named.collect()
        }
        _ => worst.map(|o| o.id.to_string()).collect(),
    };
    if ids.is_empty() {
        "–".into()
    } else {
        ids.join(", ")
    }
}

/// The stated probability, and the one by log probabilities; which models give these could tell them apart.
fn probability(verdict: Option<&Verdict>, hides: bool) -> String {
    let stated = verdict
        .and_then(|v| v.probability)
        .map(|p| format!("{p:.2}"));
    let tokens = verdict
        .and_then(|v| v.token_probability)
        .filter(|_| !hides)
        .map(|p| format!("{p:.2} by tokens"));
    let all: Vec<String> = stated.into_iter().chain(tokens).collect();
    if all.is_empty() {
        "–".into()
    } else {
        all.join(", ")
    }
}

fn risk(verdict: Option<&Verdict>) -> String {
    let score = verdict
        .and_then(Verdict::foremost)
        .and_then(|(_, score)| score);
    score.map_or("–".into(), |score| score.to_string())
}

fn progress(progress: &Progress) -> String {
    match progress {
        Progress::Waiting(s) => format!("waiting {s:.0} s"),
        Progress::Arriving(s) => format!("streaming {s:.0} s"),
        Progress::Retrying(_) => "trying again".into(),
        Progress::Unasked(_) => "not asked".into(),
        Progress::Broken(_) => "no answer".into(),
        Progress::Done(answer) => match &answer.judged {
            JudgeOutcome::Other(reading) => reading.said.task().name().into(),
            _ => "no verdict".into(),
        },
    }
}

/// Tokens, and time with cost.
fn consumed(model: &Model, shown: ShownAnswer) -> (String, String) {
    let consumed = match shown {
        ShownAnswer::Reference => {
            let ms = model.answers.reference_ms;
            return ("–".into(), ms.map_or("–".into(), duration));
        }
        ShownAnswer::Column(place) => model
            .answers
            .columns
            .get(place)
            .and_then(|c| c.answer())
            .map(|a| a.consumed),
    };
    let Some(consumed) = consumed else {
        return ("–".into(), "–".into());
    };
    let tokens = consumption::tokens(&consumed).unwrap_or("unknown".into());
    if consumed.duration_ms.is_none() && consumed.cost_usd.is_none() {
        return (tokens, "unknown".into());
    }
    let time = consumed.duration_ms.map_or("unknown".into(), duration);
    let cost = match consumed.cost_usd {
        None => "cost unknown".into(),
        Some(0.0) => "free".into(),
        Some(usd) => format!("${usd:.4}"),
    };
    (tokens, format!("{time} · {cost}"))
}

/// The rows in which two answers state different things about the same steps.
pub fn differing(all: &[Vec<Field>]) -> Vec<bool> {
    let Some(first) = all.first() else {
        return Vec::new();
    };
    // Probabilities in brackets are not what is compared.
    let bare = |field: &Field| {
        let plain = field.value.split('(').enumerate().map(|(i, part)| match i {
            0 => part,
            _ => part.split_once(')').map_or(part, |(_, rest)| rest),
        });
        plain.map(str::trim).collect::<String>()
    };
    let steps = |fields: &[Field]| {
        let steps = fields.iter().find(|field| field.name == "steps");
        steps.map(|field| field.value.clone())
    };
    let stated = |field: &Field| !matches!(field.value.as_str(), "" | "–");
    let differs = |(row, field): (usize, &Field)| {
        let pairs = || {
            all.iter()
                .enumerate()
                .flat_map(|(i, a)| all[..i].iter().map(move |b| (a, b)))
        };
        field.counts
            && pairs().any(|(a, b)| match (a.get(row), b.get(row)) {
                (Some(x), Some(y)) => {
                    let comparable = stated(x) && stated(y) && steps(a) == steps(b);
                    comparable && bare(x) != bare(y)
                }
                _ => false,
            })
    };
    first.iter().enumerate().map(differs).collect()
}

/// Whether a value says nothing.
fn is_blank(value: &str) -> bool {
    matches!(value, "" | "–" | "unknown")
}

/// The rows that say the same of all answers, or nothing, where there are several.
pub fn equal_rows(all: &[Vec<Field>]) -> Vec<bool> {
    let Some((first, others)) = all.split_first().filter(|(_, others)| !others.is_empty()) else {
        return all
            .first()
            .map_or(Vec::new(), |fields| vec![false; fields.len()]);
    };
    let is_same = |(row, field): (usize, &Field)| {
        let same =
            |o: &Field| o.words() == field.words() || is_blank(&o.value) && is_blank(&field.value);
        others.iter().all(|other| other.get(row).is_some_and(same))
    };
    first.iter().enumerate().map(is_same).collect()
}

/// What the answers in sight have in common, in a line.
pub fn common(
    model: &Model,
    seen: &[Vec<Field>],
    same: &[bool],
    width: u16,
) -> Option<Line<'static>> {
    let known = |(field, same): &(&Field, &bool)| **same && !is_blank(&field.value);
    let fields = seen.first().map_or(&[][..], Vec::as_slice);
    let parts = fields.iter().zip(same).filter(known);
    let parts: Vec<String> = parts
        .map(|(field, _)| format!("{} {}", field.name, field.words()))
        .collect();
    let who = if seen.len() < model.compare.shown.len() {
        "in sight"
    } else {
        "all"
    };
    let words = fit(&format!(" {who}: {}", parts.join("; ")), usize::from(width));
    (!parts.is_empty()).then(|| Line::styled(words, Style::new().fg(model.theme.dim)))
}

/// The rows that are not the same for all, each with whether answers differ in it.
fn rows<'a>(
    fields: &'a [Field],
    differ: &'a [bool],
    same: &'a [bool],
) -> impl Iterator<Item = (&'a Field, bool)> {
    let all = fields.iter().zip(differ).zip(same);
    all.filter(|(_, same)| !**same)
        .map(|((field, differs), _)| (field, *differs))
}

/// The values of an answer in the rows that are not the same for all; `named` behind their names, with a sign where
/// answers differ.
pub fn lines(
    model: &Model,
    fields: &[Field],
    named: bool,
    differ: &[bool],
    same: &[bool],
) -> Vec<Line<'static>> {
    let theme = &model.theme;
    let bold = |color| Style::new().fg(color).add_modifier(Modifier::BOLD);
    let name = |field: &Field, differs: bool| {
        let words = format!("{} {}", field.name, if differs { DIFFERS } else { "" });
        // Not in the colours of right and wrong.
        let dim = Style::new().fg(theme.dim);
        let style = if differs { bold(theme.text) } else { dim };
        named.then(|| Span::styled(pad(&words, LABEL), style))
    };
    let line = |(field, differs): (&Field, bool)| {
        let mut style = field.color.map_or(theme.base(), bold);
        if differs {
            style = style.add_modifier(Modifier::BOLD);
        }
        let value = Span::styled(field.words(), style);
        Line::from_iter(name(field, differs).into_iter().chain([value]))
    };
    rows(fields, differ, same).map(line).collect()
}

/// The rating of the answer at a place: chosen, tied, marked as wrong.
pub fn outcome(model: &Model, place: usize) -> Option<Line<'static>> {
    let (compare, theme) = (&model.compare, &model.theme);
    let mark = compare.marks.get(place).cloned().flatten();
    let chosen = match compare.choice {
        Some(Choice::Best(best)) if best == place => Some(("* best", theme.agree)),
        Some(Choice::Tie) => Some(("= tie", theme.accent)),
        Some(Choice::AllWrong) => Some(("x all wrong", theme.disagree)),
        _ => None,
    };
    let mut spans = Vec::new();
    if let Some((words, color)) = chosen {
        let style = Style::new().fg(color).add_modifier(Modifier::BOLD);
        spans.push(Span::styled(format!(" {words} "), style));
    }
    if let Some(reason) = mark {
        let words = format!(
            " x {} ",
            nearmiss_scene::description::visible(&reason).replace('\n', " ")
        );
        spans.push(Span::styled(words, Style::new().fg(theme.danger)));
    }
    (!spans.is_empty()).then(|| Line::from(spans))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_judged_counts_as_a_difference() {
        let field = |name, value: &str, counts| Field {
            name,
            value: value.into(),
            exact: None,
            color: None,
            counts,
        };
        let agrees = |field: Field, same| Field {
            exact: Some((same, String::new())),
            ..field
        };
        let a = vec![
            agrees(field("verdict", "collision", true), true),
            field("who", "3", true),
            field("tokens", "1", false),
        ];
        let same = vec![field("who", "3 (0.90), 4", true)];
        let other = vec![field("who", "3, 4 (0.2)", true)];
        assert_eq!(differing(&[same, other]), [false]);
        let b = vec![
            agrees(field("verdict", "collision", true), false),
            field("who", "4", true),
            field("tokens", "2", false),
        ];
        let words = [&a, &b].map(|fields| fields[0].words());
        assert_eq!(words, ["collision =", "collision ≠"]);
        assert_eq!(differing(&[a.clone(), b]), [false, true, false]);
        // What one does not state, and what is about other steps, is no difference.
        let of =
            |who: &str, steps: &str| vec![field("who", who, true), field("steps", steps, false)];
        assert_eq!(differing(&[of("3", "0–9"), of("–", "0–9")]), [false; 2]);
        assert_eq!(differing(&[of("3", "0–9"), of("4", "0–148")]), [false; 2]);
        assert!(differing(&[of("3", "0–9"), of("4", "0–148"), of("5", "0–9")])[0]);
        assert_eq!(equal_rows(&[of("3", "0–9"), of("4", "0–9")]), [false, true]);
        // Rows that say nothing are folded, too.
        let blank = ["unknown", "–"].map(|tokens| vec![field("tokens", tokens, false)]);
        assert_eq!(equal_rows(&blank), [true]);
        assert_eq!(differing(&[a]), [false; 3]);
        assert_eq!(differing(&[]), [false; 0]);
    }
}
