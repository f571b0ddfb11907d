//! The question as it stands, and what it would cost.

use std::collections::BTreeSet;

use jiff::civil::Date;

use crate::action::Action;
use crate::model::{Model, PromptView};
use nearmiss_ask::llm::{Pricing, Registry, ToolLimits};
use nearmiss_ask::prompts::{Library, TemplateError};
use nearmiss_base::system::crash::{self, Subject, trying};
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge;
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
        self.prompt.shipped_question = None;
        self.refill();
    }

    /// Fills the template again, which alone has changed.
    pub fn refill(&mut self) {
        let Some(case) = self.case() else { return };
        self.techniques = case.techniques;
        self.prompt.fill_in = None;
        self.prompt.load(&self.library, self.task, self.frame);
        let draft = self.prompt.draft();
        self.prompt.held = crash::is_held(&self.subject());
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
            crash::release(&self.subject());
            self.refill();
        }
        held
    }

    /// Fills the shipped template, too, while the two are compared.
    pub fn compare(&mut self) {
        let prompt = &self.prompt;
        let rendered = prompt.view == PromptView::Rendered && prompt.is_draft();
        let compared = prompt.editing || prompt.view == PromptView::Diff || rendered;
        let Some((file, shipped)) = self.prompt.shipped().filter(|_| compared) else {
            return;
        };
        if self.prompt.shipped_question.is_some() {
            return;
        }
        let Some(case) = self.case() else { return };
        let question = self.prepared(case, Some(&(file.into(), shipped.into())));
        self.prompt.shipped_question = question.ok().map(|q| (q.tokens(), q.prompt));
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
            attack: AttackTerms::of_style(self.config.attack_style),
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

/// Prices of all models on a day.
#[derive(Debug, Clone, Default)]
pub struct Prices(Option<PriceTable>);

#[derive(Debug, Clone)]
struct PriceTable {
    registry: Registry,
    /// Providers that cost nothing, as [`Registry::free`] has them.
    free: BTreeSet<String>,
    day: Date,
}

/// Price of a model where none is known.
const UNKNOWN: &str = "price unknown";

/// Price of the built-in judge, and of models on this machine.
const FREE: &str = "free";

/// A price to a hundredth, or as exactly as it is stated.
fn dollars(price: f64) -> String {
    let exact = price.to_string();
    match exact.split_once('.') {
        Some((_, decimals)) if decimals.len() > 2 => format!("${exact}"),
        _ => format!("${price:.2}"),
    }
}

/// Tokens of one request.
#[derive(Debug, Clone, Copy)]
pub struct RequestTokens {
    /// Of the question.
    pub question: usize,
    /// Of the answer at most, where that has a limit.
    pub answer: Option<u32>,
}

impl Prices {
    /// The prices that a registry knows, on a day; `free` names the providers that cost nothing.
    #[must_use]
    pub fn new(registry: Registry, free: BTreeSet<String>, day: Date) -> Self {
        Self(Some(PriceTable {
            registry,
            free,
            day,
        }))
    }

    fn pricing_for(&self, model: &str) -> Option<Pricing> {
        let table = self.0.as_ref()?;
        table.registry.pricing(model, table.day)
    }

    /// Whether nothing is paid: the built-in judge, or a server on this machine for which no price is stated.
    #[must_use]
    pub fn is_free(&self, model: &str) -> bool {
        let provider = model.split('/').next().unwrap_or_default();
        let free = self.0.as_ref().is_some_and(|t| t.free.contains(provider));
        model == judge::MODEL || free
    }

    /// The most that requests to a model can cost, in words; includes the answers if their length has a limit.
    #[must_use]
    pub fn of_requests(&self, model: &str, requests: &[RequestTokens]) -> String {
        if self.is_free(model) {
            return FREE.into();
        }
        let Some(pricing) = self.pricing_for(model) else {
            return UNKNOWN.into();
        };
        let most = |one: &RequestTokens| {
            let question = u32::try_from(one.question).unwrap_or(u32::MAX);
            pricing.at_most(question, one.answer.unwrap_or(0))
        };
        let Some(usd) = requests.iter().map(most).sum::<Option<f64>>() else {
            return UNKNOWN.into();
        };
        match (requests.iter().all(|one| one.answer.is_some()), requests) {
            (true, _) => format!("at most ${usd:.4}"),
            (false, [_]) => format!("${usd:.4} + answer"),
            (false, _) => format!("${usd:.4} + answers"),
        }
    }

    /// The price of a million tokens, in words: `$2.00 in, $10.00 out / 1M`.
    #[must_use]
    pub fn per_million(&self, model: &str) -> String {
        if self.is_free(model) {
            return FREE.into();
        }
        match self.pricing_for(model) {
            Some(Pricing { price, .. }) => {
                let [input, output] = [price.input, price.output].map(dollars);
                format!("{input} in, {output} out / 1M")
            }
            None => UNKNOWN.into(),
        }
    }

    /// What the bound on a model's cost counts beyond listed prices, in words.
    #[must_use]
    pub fn bound(&self, model: &str) -> Option<String> {
        self.pricing_for(model)?.bound_note()
    }

    /// Where the price of a model is from, or how to state one.
    #[must_use]
    pub fn origin(&self, model: &str) -> String {
        if model == judge::MODEL {
            return "built in: runs here, costs nothing".into();
        }
        if self.is_free(model) {
            return "a server on this machine: costs nothing".into();
        }
        let provider = model.split('/').next().unwrap_or_default();
        match self.pricing_for(model) {
            Some(pricing) => match pricing.origin() {
                Some(origin) => format!("price {origin}"),
                None => "price from your config.toml".into(),
            },
            None => format!(
                "no price known; [[provider.{provider}.prices]] in config.toml sets one, in US dollars per 1M tokens"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_ask::llm::Environment;

    #[test]
    fn a_price_only_where_one_is_known_and_free_only_what_runs_here() {
        let users = "[lab]\nbase_url = \"http://lab.example\"\n[[lab.prices]]\nmodel = \"big\"\ninput = 2.0\noutput = 10.0\n\
            [desk]\nbase_url = \"http://localhost:1\"\n[shop]\nbase_url = \"http://localhost:2\"\n[[shop.prices]]\nmodel = \"sold\"\ninput = 1.0\noutput = 1.0\n";
        let registry = Registry::new(&toml::from_str(users).unwrap()).unwrap();
        let free = registry.free(&Environment::from_lookup(|_| None));
        assert!(free.contains("desk"), "{free:?}");
        assert!(!free.contains("lab") && !free.contains("shop"));
        let prices = Prices::new(registry, free, jiff::civil::date(2026, 1, 1));
        let words = |model, answer| {
            let question = 1000;
            prices.of_requests(model, &[RequestTokens { question, answer }])
        };
        assert_eq!(words("lab/big", None), "$0.0020 + answer");
        assert_eq!(words("lab/big", Some(100)), "at most $0.0030");
        assert_eq!(words("lab/small", None), UNKNOWN);
        assert_eq!(words("nobody/x", None), UNKNOWN);
        assert_eq!(words(judge::MODEL, None), FREE);
        assert_eq!(words("desk/any", None), FREE);
        assert_eq!(words("shop/any", None), UNKNOWN);
        assert_eq!(words("shop/sold", Some(0)), "at most $0.0010");
        assert_eq!(prices.per_million("lab/big"), "$2.00 in, $10.00 out / 1M");
        assert!(
            prices
                .origin("lab/small")
                .contains("[[provider.lab.prices]]")
        );
        let two = [(1000, Some(100)), (500, Some(0))]
            .map(|(question, answer)| RequestTokens { question, answer });
        assert_eq!(prices.of_requests("lab/big", &two), "at most $0.0040");
    }
}
