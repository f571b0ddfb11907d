//! The answers on the open scenario, the built-in judge's, and how they are read.

use std::collections::HashMap;
use std::sync::Arc;

use crate::action::Action;
use crate::model::{JobId, Model};
use crate::widgets::long_text::ReadingMode;
use nearmiss_ask::llm::ToolRound;
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge::Judgement;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::{Task, Verdict};
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
    /// The obstacle of the verdict pane's table that the keys stand on.
    pub cursor: Option<i64>,
    /// The disagreement that was gone to last.
    pub walked: Option<crate::model::Disagreement>,
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
        let is_failed = |(_, column): &(bool, Column)| column.failed();
        let mut failed: Vec<_> = first.extract_if(.., |entry| is_failed(entry)).collect();
        failed.extend(behind.extract_if(.., |entry| is_failed(entry)));
        first.sort_by_cached_key(|(_, c): &(bool, Column)| c.model.clone());
        behind.sort_by_cached_key(|(_, c)| (c.model.clone(), rank(&c.how)));
        first.append(&mut behind);
        // What has no answer stands in no answer's way.
        first.append(&mut failed);
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

/// Windows that are judged ahead of the current one, so that stepping and playing find theirs there.
const AHEAD: i64 = 12;

/// The first and last step of a window, and the built-in judge's answer about it.
pub type WindowJudgement = ((i64, i64), Judgement);

/// Windows of a scene, by their first and last steps, which the built-in judge is to judge.
#[derive(Debug)]
pub struct WindowsToJudge {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The task.
    pub task: Task,
    /// The windows.
    pub windows: Vec<(i64, i64)>,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
}

/// Safety judgements of one scene under the same thresholds, by the first and last step of their windows.
#[derive(Debug, Default)]
pub struct Judgements {
    about: Option<(Arc<Scene>, Arc<Thresholds>)>,
    /// `None` while a judgement is on its way.
    windows: HashMap<(i64, i64), Option<Judgement>>,
}

impl Judgements {
    fn is_about(&self, scene: &Arc<Scene>, thresholds: &Arc<Thresholds>) -> bool {
        self.about.as_ref().is_some_and(|(known, under)| {
            Arc::ptr_eq(known, scene) && Arc::ptr_eq(under, thresholds)
        })
    }

    /// The judgement of a window; `None` until it has arrived.
    fn get(
        &self,
        scene: &Arc<Scene>,
        thresholds: &Arc<Thresholds>,
        window: (i64, i64),
    ) -> Option<&Judgement> {
        let known = self.windows.get(&window)?.as_ref();
        known.filter(|_| self.is_about(scene, thresholds))
    }

    /// Notes that these windows are judged; gives those that were not requested before. Another scene or other
    /// thresholds clear what is known.
    fn request(
        &mut self,
        scene: &Arc<Scene>,
        thresholds: &Arc<Thresholds>,
        windows: impl IntoIterator<Item = (i64, i64)>,
    ) -> Vec<(i64, i64)> {
        if !self.is_about(scene, thresholds) {
            self.windows.clear();
            self.about = Some((scene.clone(), thresholds.clone()));
        }
        let mut missing = Vec::new();
        for window in windows {
            self.windows.entry(window).or_insert_with(|| {
                missing.push(window);
                None
            });
        }
        missing
    }

    /// Takes judgements that were requested; those of another scene are dropped.
    pub fn take(
        &mut self,
        scene: &Arc<Scene>,
        thresholds: &Arc<Thresholds>,
        found: &[WindowJudgement],
    ) {
        if self.is_about(scene, thresholds) {
            let found = found.iter().cloned();
            self.windows
                .extend(found.map(|(window, judgement)| (window, Some(judgement))));
        }
    }
}

impl Model {
    /// The built-in judge on the current window, where it is known.
    fn judged_now(&self) -> Option<Judgement> {
        let opened = self.opened.as_ref()?;
        let (scene, window) = (opened.scene.as_ref()?, self.window()?);
        match self.task {
            Task::Collision => opened.collision.clone(),
            Task::Recording => opened.recording.clone(),
            Task::Safety => {
                let window = (window.first(), window.last());
                let known = self.judgements.get(scene, &self.thresholds, window);
                known.cloned()
            }
            Task::Attacker | Task::Trajectory => None,
        }
    }

    /// Takes the built-in judge's answer on the current window, where it is known.
    pub fn take_reference(&mut self) {
        self.answers.reference = self.judged_now();
    }

    /// Whether the built-in judge has an answer on the current window, or is at work on it.
    #[must_use]
    pub fn has_reference(&self) -> bool {
        self.answers.reference.is_some() || self.is_judging()
    }

    /// Whether the built-in judge is at work on the current window.
    #[must_use]
    pub fn is_judging(&self) -> bool {
        self.task == Task::Safety && self.answers.reference.is_none() && self.scene().is_some()
    }

    /// Judgements to request: that of the current window by itself, then those of the steps after it.
    pub fn missing_judgements(&mut self) -> Vec<WindowsToJudge> {
        let scene = self.opened.as_ref().and_then(|o| o.scene.clone());
        let Some((scene, now)) = scene.zip(self.window()) else {
            return Vec::new();
        };
        if self.task != Task::Safety {
            return Vec::new();
        }
        let history = self.decided().history;
        let ends = |window: Window| (window.first(), window.last());
        let end = self.clock.range().1.min(now.last().saturating_add(AHEAD));
        let after = (now.last() + 1..=end).map(|s| ends(Window::ending_at(&scene, s, history)));
        let thresholds = self.thresholds.clone();
        let known = &mut self.judgements;
        let now = known.request(&scene, &thresholds, [ends(now)]);
        let after = known.request(&scene, &thresholds, after);
        [now, after]
            .into_iter()
            .filter(|windows| !windows.is_empty())
            .map(|windows| WindowsToJudge {
                scene: scene.clone(),
                task: Task::Safety,
                windows,
                thresholds: thresholds.clone(),
            })
            .collect()
    }
}

/// How answers are read.
#[derive(Debug, Default)]
pub struct ReadingView {
    /// As they were sent, with all markup.
    pub raw: bool,
    /// With their JSON.
    pub unfold: bool,
    /// The question whose answer the reader scrolled while it was streamed.
    pub scrolled: Option<JobId>,
}

impl Model {
    /// How answers are shown now, with the key that unfolds JSON.
    #[must_use]
    pub fn reading_mode(&self) -> ReadingMode {
        ReadingMode {
            raw: self.reading.raw,
            unfold: self.reading.unfold,
            hint: format!(" · {} unfolds", self.look.key(Action::UnfoldJson)),
        }
    }

    /// Shows answers as they were sent, or rendered again.
    pub fn toggle_raw(&mut self) {
        self.reading.raw = !self.reading.raw;
        self.say(if self.reading.raw {
            "answers as sent"
        } else {
            "answers rendered as Markdown"
        });
    }

    /// Unfolds the JSON of answers, or folds it again.
    pub fn toggle_json(&mut self) {
        self.reading.unfold = !self.reading.unfold;
        if self.reading.raw {
            self.say("raw answers are never folded");
        }
    }

    /// Notes that the reader scrolls the shown answer.
    pub fn note_scrolled(&mut self) {
        let column = self.answers.column().filter(|c| c.is_running());
        if let Some(ask) = column.and_then(|c| c.ask) {
            self.reading.scrolled = Some(ask);
        }
    }

    /// The stream of a question ends: a reader who scrolled stays where they are, for any other the answer is shown from
    /// its beginning, where reading starts.
    pub fn end_stream(&mut self, ask: JobId) {
        let shown = self.answers.column().and_then(|c: &Column| c.ask);
        if shown != Some(ask) {
            return;
        }
        let stays = self.reading.scrolled.take_if(|id| *id == ask).is_some();
        if !stays {
            self.answers.scroll = Some(0);
        } else if self.answers.scroll.is_none() {
            let extent = self.drawn.extent(crate::model::Pane::Reasoning);
            self.answers.scroll = Some(extent.top);
        }
    }
}
