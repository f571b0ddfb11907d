//! Answers beyond yes or no: possible attackers, and new motions for an attacker.

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Text};

use super::table::{Row, Table};
use crate::model::Model;
use nearmiss_scene::description::visible;
use nearmiss_scene::verdict::{Moment, Motion, ParsedAnswer, Task};
use nearmiss_study::evaluation::{Answer, JudgeOutcome, motion_lines};

/// The label of the table's second row.
pub fn second_label(task: Task) -> &'static str {
    match task {
        Task::Collision | Task::Safety | Task::Recording => "who",
        Task::Attacker => "others",
        Task::Trajectory => "motion",
    }
}

/// The cells of an answer: what it says, the row below, and the risk or the time.
pub fn cells(said: &ParsedAnswer) -> [String; 3] {
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
pub fn text(model: &Model, said: &ParsedAnswer) -> Text<'static> {
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
