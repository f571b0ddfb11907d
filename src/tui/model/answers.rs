//! The answers that are compared, one column each, beside the built-in judge.

use crate::evaluation::Answer;
use crate::judge::Judgement;
use crate::store::RunId;
use crate::tui::message::AskId;
use crate::verdict::Verdict;

/// Answers side by side.
#[derive(Debug, Default)]
pub struct Answers {
    /// Answers of models, the oldest first.
    pub columns: Vec<Column>,
    /// What the built-in judge says.
    pub reference: Option<Judgement>,
    /// The question the built-in judge is answering for the store.
    pub asking_reference: Option<AskId>,
    /// Milliseconds the built-in judge took when it was last asked.
    pub reference_ms: Option<u64>,
    /// Questions about scenarios that are not open any longer, with their names.
    pub elsewhere: Vec<(AskId, String)>,
    /// Whose reasoning is shown.
    pub shown: Shown,
    /// How far its text is scrolled; nothing while the end is followed.
    pub scroll: Option<usize>,
}

/// Whose reasoning is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shown {
    /// The built-in judge's.
    #[default]
    Reference,
    /// That of a column.
    Column(usize),
}

/// One answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The question it answers; nothing for one from the store.
    pub ask: Option<AskId>,
    /// The model asked, `provider/model`.
    pub model: String,
    /// How it was asked, in short.
    pub how: String,
    /// First and last time step that it was told of, where that is known.
    pub steps: Option<(i64, i64)>,
    /// What the built-in judge says about the same question.
    pub truth: Option<Verdict>,
    /// Reasoning so far.
    pub reasoning: String,
    /// Answer so far.
    pub text: String,
    /// Where it stands.
    pub progress: Progress,
}

/// Where an answer stands.
#[derive(Debug, Clone, PartialEq)]
pub enum Progress {
    /// The question is on its way, for so many seconds.
    Waiting(f64),
    /// The next try follows; why.
    Retrying(String),
    /// It arrives, for so many seconds.
    Arriving(f64),
    /// It is here.
    Done(Box<Answer>),
    /// It could not be kept or asked; why.
    Broken(String),
}

/// Answers that are kept at hand; older ones are in the store.
const MOST_COLUMNS: usize = 40;

impl Answers {
    /// Adds a column and shows it; the oldest that is not running makes room.
    pub fn add(&mut self, column: Column) {
        while self.columns.len() >= MOST_COLUMNS {
            let Some(old) = self.columns.iter().position(|c| !c.is_running()) else {
                break;
            };
            self.columns.remove(old);
        }
        self.columns.push(column);
        self.show(Shown::Column(self.columns.len() - 1));
    }

    /// Takes away the columns beside that of `ask` that show the same run of the store.
    pub fn show_once(&mut self, ask: AskId, run: RunId) {
        let twin = |c: &Column| c.ask != Some(ask) && c.answer().and_then(|a| a.run) == Some(run);
        while let Some(twin) = self.columns.iter().position(twin) {
            self.columns.remove(twin);
            match self.shown {
                Shown::Column(i) if i > twin => self.shown = Shown::Column(i - 1),
                Shown::Column(i) if i == twin => {
                    let same = self.columns.iter().position(|c| c.ask == Some(ask));
                    self.show(same.map_or(Shown::Reference, Shown::Column));
                }
                _ => {}
            }
        }
    }

    /// Shows the reasoning of an answer, from its beginning, or at its end while it arrives.
    pub fn show(&mut self, shown: Shown) {
        self.shown = shown;
        let running = self.column().is_some_and(Column::is_running);
        self.scroll = if running { None } else { Some(0) };
    }

    /// The shown column.
    #[must_use]
    pub fn column(&self) -> Option<&Column> {
        match self.shown {
            Shown::Reference => None,
            Shown::Column(i) => self.columns.get(i),
        }
    }

    /// Shows the next answer, or the one before; the built-in judge is the last.
    pub fn cycle(&mut self, forward: bool) {
        let count = self.columns.len() + 1;
        let now = match self.shown {
            Shown::Column(i) => i,
            Shown::Reference => count - 1,
        };
        let next = if forward {
            (now + 1) % count
        } else {
            (now + count - 1) % count
        };
        self.show(if next == count - 1 {
            Shown::Reference
        } else {
            Shown::Column(next)
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

    /// The answer, once it is here.
    #[must_use]
    pub fn answer(&self) -> Option<&Answer> {
        match &self.progress {
            Progress::Done(answer) => Some(answer),
            _ => None,
        }
    }
}

impl From<Answer> for Column {
    /// An answer from the store.
    fn from(answer: Answer) -> Self {
        Self {
            ask: None,
            model: answer.model.clone(),
            how: answer.how.clone(),
            steps: answer.window,
            truth: None,
            reasoning: answer.reasoning.clone(),
            text: answer.text.clone(),
            progress: Progress::Done(Box::new(answer)),
        }
    }
}
