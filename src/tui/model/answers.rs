//! The compared answers, one column each, beside the built-in judge.

use super::JobId;
use nearmiss_ask::llm::ToolRound;
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge::Judgement;
use nearmiss_scene::verdict::Verdict;
use nearmiss_store::RunId;
use nearmiss_study::evaluation::claims::TimeOrigin;
use nearmiss_study::evaluation::{Answer, JudgeOutcome, MissingVerdict};

/// Answers side by side.
#[derive(Debug, Default)]
pub struct Answers {
    /// Answers of models, the oldest first.
    pub columns: Vec<Column>,
    /// The built-in judge's judgement.
    pub reference: Option<Judgement>,
    /// The question the built-in judge is answering for the store.
    pub asking_reference: Option<JobId>,
    /// Milliseconds the built-in judge took when it was last asked.
    pub reference_ms: Option<u64>,
    /// Questions about scenarios that are not open any longer, with their names.
    pub elsewhere: Vec<(JobId, String)>,
    /// The answer whose reasoning is shown.
    pub shown: ShownAnswer,
    /// How far its text is scrolled; `None` while the end is followed.
    pub scroll: Option<usize>,
    /// The line that the verdict pane begins with.
    pub verdict_top: usize,
}

/// The answer whose reasoning is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ShownAnswer {
    /// The built-in judge's.
    #[default]
    Reference,
    /// That of a column.
    Column(usize),
}

/// A compared answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The question it answers; nothing for one from the store.
    pub ask: Option<JobId>,
    /// The model asked, `provider/model`.
    pub model: String,
    /// How it was asked, in short.
    pub how: String,
    /// First and last time step that it was told of, where that is known.
    pub steps: Option<(i64, i64)>,
    /// What the times in it count from.
    pub times: TimeOrigin,
    /// Whether the store has a run for it: from then on something may have been sent.
    pub begun: bool,
    /// The built-in judge's verdict on the same question.
    pub truth: Option<Verdict>,
    /// Whether that is being computed.
    pub judging: bool,
    /// Tools that the model called so far, in rounds.
    pub tool_rounds: Vec<ToolRound>,
    /// Reasoning so far.
    pub reasoning: String,
    /// Answer so far.
    pub text: String,
    /// Where it stands.
    pub progress: Progress,
}

/// State of an answer.
#[derive(Debug, Clone, PartialEq)]
pub enum Progress {
    /// Waiting for the first chunk, for this many seconds.
    Waiting(f64),
    /// The next try follows; why.
    Retrying(String),
    /// Arriving, for this many seconds.
    Arriving(f64),
    /// It is here.
    Done(Box<Answer>),
    /// Not sent, and why.
    Unasked(String),
    /// It was cancelled, or could not be kept; why.
    Broken(String),
}

/// Answers that are kept at hand; older ones are in the store.
const MOST_COLUMNS: usize = 40;

impl Answers {
    /// Adds a column and shows it. What failed of the same model, asked in the same way, makes room, and of too many
    /// the oldest that is not running.
    pub fn add(&mut self, column: Column) {
        self.columns
            .retain(|c| !c.failed() || c.model != column.model || c.how != column.how);
        while self.columns.len() >= MOST_COLUMNS {
            let Some(old) = self.columns.iter().position(|c| !c.is_running()) else {
                break;
            };
            self.columns.remove(old);
        }
        self.columns.push(column);
        self.show(ShownAnswer::Column(self.columns.len() - 1));
    }

    /// Takes away the columns beside that of `ask` that show the same run of the store.
    pub fn show_once(&mut self, ask: JobId, run: RunId) {
        let twin = |c: &Column| c.ask != Some(ask) && c.answer().and_then(|a| a.run) == Some(run);
        while let Some(twin) = self.columns.iter().position(twin) {
            self.columns.remove(twin);
            match self.shown {
                ShownAnswer::Column(i) if i > twin => self.shown = ShownAnswer::Column(i - 1),
                ShownAnswer::Column(i) if i == twin => {
                    let same = self.columns.iter().position(|c| c.ask == Some(ask));
                    self.show(same.map_or(ShownAnswer::Reference, ShownAnswer::Column));
                }
                _ => {}
            }
        }
    }

    /// Sorts the columns: first the newest of each model that was asked in this `way`, then the others by model, frame
    /// and techniques, from none to all. The shown answer stays shown.
    pub fn arrange(&mut self, way: &str) {
        let shown = self.shown;
        let columns = std::mem::take(&mut self.columns).into_iter().enumerate();
        let marked: Vec<(bool, Column)> = columns
            .map(|(i, column)| (shown == ShownAnswer::Column(i), column))
            .collect();
        let mut models = std::collections::HashSet::new();
        let (mut first, mut behind) = (Vec::new(), Vec::new());
        for entry in marked.into_iter().rev() {
            let newest = entry.1.how == way && models.insert(entry.1.model.clone());
            if newest { &mut first } else { &mut behind }.push(entry);
        }
        behind.reverse();
        first.sort_by_cached_key(|(_, c): &(bool, Column)| c.model.clone());
        behind.sort_by_cached_key(|(_, c)| (c.model.clone(), rank(&c.how)));
        first.append(&mut behind);
        let marked = first;
        if let Some(place) = marked.iter().position(|(shown, _)| *shown) {
            self.shown = ShownAnswer::Column(place);
        }
        self.columns = marked.into_iter().map(|(_, column)| column).collect();
    }

    /// Arranges the columns and shows one that was asked in this way, of the shown model if it has one; what arrives
    /// stays shown.
    pub fn show_way(&mut self, way: &str) {
        self.arrange(way);
        let shown = self.column();
        if shown.is_some_and(|c| c.is_running() || c.how == way) {
            return;
        }
        let of_way = |c: &Column| c.how == way;
        let same = shown.map(|c| c.model.clone()).and_then(|model| {
            let twin = |c: &Column| of_way(c) && c.model == model;
            self.columns.iter().position(twin)
        });
        if let Some(place) = same.or_else(|| self.columns.iter().position(of_way)) {
            self.show(ShownAnswer::Column(place));
        }
    }

    /// Shows the reasoning of an answer, from its beginning, or at its end while it arrives.
    pub fn show(&mut self, shown: ShownAnswer) {
        self.shown = shown;
        let running = self.column().is_some_and(Column::is_running);
        self.scroll = if running { None } else { Some(0) };
        self.verdict_top = 0;
    }

    /// The shown column.
    #[must_use]
    pub fn column(&self) -> Option<&Column> {
        match self.shown {
            ShownAnswer::Reference => None,
            ShownAnswer::Column(i) => self.columns.get(i),
        }
    }

    /// Shows the next answer, or the one before; the built-in judge is the last.
    pub fn cycle(&mut self, forward: bool) {
        let count = self.columns.len() + 1;
        let now = match self.shown {
            ShownAnswer::Column(i) => i,
            ShownAnswer::Reference => count - 1,
        };
        let next = if forward {
            (now + 1) % count
        } else {
            (now + count - 1) % count
        };
        self.show(if next == count - 1 {
            ShownAnswer::Reference
        } else {
            ShownAnswer::Column(next)
        });
    }

    /// Whether an answer is on its way.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.columns.iter().any(Column::is_running) || !self.elsewhere.is_empty()
    }
}

impl Column {
    /// Whether it is on its way.
    #[must_use]
    pub fn is_running(&self) -> bool {
        matches!(
            self.progress,
            Progress::Waiting(_) | Progress::Retrying(_) | Progress::Arriving(_)
        )
    }

    /// Whether there is no whole answer, and none will come.
    #[must_use]
    pub fn failed(&self) -> bool {
        match &self.progress {
            Progress::Unasked(_) | Progress::Broken(_) => true,
            Progress::Done(answer) => matches!(
                answer.judged,
                JudgeOutcome::Missing(
                    MissingVerdict::NoAnswer(_)
                        | MissingVerdict::NotSent(_)
                        | MissingVerdict::Cancelled
                )
            ),
            Progress::Waiting(_) | Progress::Retrying(_) | Progress::Arriving(_) => false,
        }
    }

    /// The reference of an answer: the ground truth of its own question, else the built-in judge's verdict on the open
    /// scene; `None` while the ground truth is being computed.
    #[must_use]
    pub fn truth_or<'a>(&'a self, reference: Option<&'a Verdict>) -> Option<&'a Verdict> {
        let other = reference.filter(|_| !self.judging);
        self.truth.as_ref().or(other)
    }

    /// The answer, once it is here.
    #[must_use]
    pub fn answer(&self) -> Option<&Answer> {
        match &self.progress {
            Progress::Done(answer) => Some(answer),
            _ => None,
        }
    }
}

/// Frame, techniques and template of a [`Column::how`]; each may be empty.
#[must_use]
pub fn parts(how: &str) -> (&str, &str, &str) {
    let mut parts = how.splitn(3, " · ");
    let mut next = || parts.next().unwrap_or_default();
    (next(), next(), next())
}

/// Where a way of asking stands among the others: by its frame, then from no technique to all.
fn rank(how: &str) -> (usize, usize) {
    let (frame, techniques, _) = parts(how);
    let frame = Frame::ALL.iter().position(|f| f.name() == frame);
    let has = |name| usize::from(techniques.split('+').any(|t| t == name));
    (
        frame.unwrap_or(Frame::ALL.len()),
        has("cp") + 2 * has("cot") + 4 * has("icl"),
    )
}

impl From<Answer> for Column {
    /// An answer from the store.
    fn from(answer: Answer) -> Self {
        Self {
            ask: None,
            model: answer.model.clone(),
            how: answer.how.clone(),
            steps: answer.window,
            times: answer.times,
            begun: true,
            truth: None,
            judging: false,
            tool_rounds: answer.tool_rounds.clone(),
            reasoning: answer.reasoning.clone(),
            text: answer.text.clone(),
            progress: Progress::Done(Box::new(answer)),
        }
    }
}
