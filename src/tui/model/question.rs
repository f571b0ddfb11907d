//! The current question, rendered again whenever one of its inputs changes.

use super::{Model, PromptView, RequestTokens};
use crate::action::Action;
use nearmiss_ask::llm::ToolLimits;
use nearmiss_ask::prompts::{Library, TemplateError};
use nearmiss_base::system::activity::{self, Subject, trying};
use nearmiss_scene::description::Frame;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::{
    AttackTerms, Case, CaseError, default_frame, prepare, tool_rounds, with_tools,
};

impl Model {
    /// Steps in the window of the safety task, where the current step has fewer before it than are wanted.
    #[must_use]
    pub fn short_window(&self) -> Option<i64> {
        let window = self.window().filter(|_| self.task == Task::Safety)?;
        let steps = window.last() - window.first() + 1;
        let wanted = i64::try_from(self.decided().history).unwrap_or(i64::MAX);
        Some(steps).filter(|&steps| steps < wanted)
    }

    /// How it is asked now, in short: as [`Column::how`] has it.
    #[must_use]
    pub fn way(&self) -> String {
        let techniques = || with_tools(&self.techniques.to_string(), self.tools);
        let way = || format!("{} · {}", self.frame.name(), techniques());
        let question = self.prompt.question.as_ref();
        question.map_or_else(way, |question| question.label(self.tools))
    }

    /// The frame after the present one that has a template for the task.
    #[must_use]
    pub fn next_frame(&self) -> Frame {
        let all = Frame::ALL;
        let now = all.iter().position(|f| *f == self.frame).unwrap_or(0);
        let mut after = (1..=all.len()).map(|n| all[(now + n) % all.len()]);
        let fits = |f: &Frame| self.library.find(self.task.name(), f.name()).is_some();
        after.find(fits).unwrap_or(self.frame)
    }

    /// Works out again what depends on the scene, the window, the template and the switches:
    /// the prompt and the built-in judge's verdict.
    pub fn refresh(&mut self) {
        let (Some(opened), Some(_)) = (&self.opened, self.window()) else {
            self.prompt.question = None;
            self.answers.reference = None;
            return;
        };
        if opened.scene.is_none() {
            return;
        }
        self.take_reference();
        self.prompt.shipped_tokens = None;
        self.refill();
    }

    /// Fills the template again, which alone has changed.
    pub fn refill(&mut self) {
        let Some(case) = self.case() else { return };
        self.techniques = case.techniques;
        self.prompt.fill_in = None;
        self.prompt.load(&self.library, self.task, self.frame);
        let draft = self.prompt.draft();
        self.prompt.held = activity::is_held(&self.subject());
        if self.prompt.held {
            self.hold();
            return;
        }
        let prepared = self.prepared(case.clone(), draft.as_ref());
        match prepared {
            Ok(question) => {
                self.prompt.error = None;
                self.prompt.error_line = None;
                self.prompt.accept(draft);
                self.prompt.question = Some(question);
            }
            Err(error) => {
                self.prompt.error_line = line_of(&error, self.prompt.file());
                self.prompt.error = Some(error.to_string());
                // The last template that could be filled is shown; nothing is asked with it.
                let good = self.prompt.good();
                self.prompt.question = self.prepared(case, good.as_ref()).ok();
            }
        }
        self.prompt.tokens = self.prompt.question.as_ref().map_or(0, |q| q.tokens());
        self.compare();
    }

    /// The text that is filled, for what ended the program.
    fn subject(&self) -> Subject {
        Subject::template(self.prompt.file(), &self.prompt.text())
    }

    /// Blocks rendering: the program ended at the last attempt.
    fn hold(&mut self) {
        let (ask, edit) = (self.look.key(Action::Run), self.look.key(Action::Edit));
        self.prompt.error = Some(format!(
            "{}: the program crashed while rendering this template; {ask} renders it anyway, {edit} edits it",
            self.prompt.file()
        ));
        self.prompt.error_line = None;
        self.prompt.question = None;
        self.prompt.tokens = 0;
    }

    /// Fills a template that was held, as the user says; whether there was one.
    pub fn fill_held(&mut self) -> bool {
        let held = self.prompt.held;
        if held {
            activity::release(&self.subject());
            self.refill();
        }
        held
    }

    /// Counts the tokens of the shipped template, while the two are compared.
    pub fn compare(&mut self) {
        let compared = self.prompt.editing || self.prompt.view == PromptView::Diff;
        let Some((file, shipped)) = self.prompt.shipped().filter(|_| compared) else {
            return;
        };
        if self.prompt.shipped_tokens.is_some() {
            return;
        }
        let Some(case) = self.case() else { return };
        let question = self.prepared(case, Some(&(file.into(), shipped.into())));
        self.prompt.shipped_tokens = question.ok().map(|q| q.tokens());
    }

    fn prepared(
        &self,
        case: Case,
        draft: Option<&(String, String)>,
    ) -> Result<nearmiss_study::evaluation::Question, CaseError> {
        let draft = draft.map(|(file, text)| (file.as_str(), text.as_str()));
        let shipped = draft.is_some_and(|(file, text)| Library::shipped(file) == Some(text));
        let _trying = (!shipped).then(|| {
            let (file, text) = draft.unwrap_or((self.prompt.file(), self.prompt.saved()));
            let words = format!("filling the template {file}");
            trying(words, Subject::template(file, text))
        });
        prepare(case, &self.library, draft)
    }

    /// The cost of asking the chosen model the question as it stands, in words.
    #[must_use]
    pub fn price(&self) -> String {
        self.price_of(&self.model)
    }

    /// The same of another model: with tools, of all rounds of calls and of the answer after them.
    #[must_use]
    pub fn price_of(&self, model: &str) -> String {
        let (tokens, answer) = (self.prompt.tokens, self.config.max_tokens);
        let request = |question| RequestTokens { question, answer };
        let requests: Vec<RequestTokens> = match self.tool_limits() {
            None => vec![request(tokens)],
            Some(limits) => tool_rounds::most_tokens(tokens, &limits, answer)
                .into_iter()
                .map(request)
                .collect(),
        };
        self.prompt.prices.of_requests(model, &requests)
    }

    /// How often models may call tools; `None` where they may not.
    #[must_use]
    pub fn tool_limits(&self) -> Option<ToolLimits> {
        self.tools.then(ToolLimits::default)
    }

    /// Roughly how many tokens a question of another task about this moment has; `None` where it cannot be asked.
    #[must_use]
    pub fn tokens_of(&self, task: Task, obstacle: Option<i64>) -> Option<usize> {
        self.tokens_in(task, default_frame(&self.library, task), obstacle)
    }

    /// The same in a frame.
    #[must_use]
    pub fn tokens_in(&self, task: Task, frame: Frame, obstacle: Option<i64>) -> Option<usize> {
        let mut case = self.case()?;
        (case.task, case.frame) = (task, frame);
        case.options.obstacle = obstacle;
        let question = prepare(case, &self.library, None).ok()?;
        Some(question.tokens())
    }

    fn case(&self) -> Option<Case> {
        let opened = self.opened.as_ref()?;
        let decided = self.decided();
        Some(Case {
            name: opened.name.clone(),
            scene: opened.scene.clone()?,
            task: self.task,
            frame: self.frame,
            techniques: decided.techniques,
            window: self.window()?,
            options: decided.options,
            thresholds: self.thresholds.clone(),
            horizon: Case::HORIZON,
            attack: AttackTerms::of_style(self.config.attack_style.as_deref()),
        })
    }
}

/// The line of the template that an error is in.
fn line_of(error: &CaseError, file: &str) -> Option<usize> {
    match error {
        CaseError::Draft { error, .. } => Some(match error {
            TemplateError::NoFrontMatter => 1,
            TemplateError::Wrong { line, .. } => *line,
        }),
        CaseError::Render(error) if error.file == file => error.line,
        _ => None,
    }
}
