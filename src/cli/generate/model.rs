//! Attacks written by a language model: which, what it consumed or would consume at most, and figures over all scenarios.

use std::sync::{Arc, Mutex};

use nearmiss_ask::llm::Parameters;
use nearmiss_drive::generation::AttackSetup;
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::Entry;
use nearmiss_scene::judge;
use nearmiss_scene::scenario::Scene;
use nearmiss_settings::{Config, Folders};
use nearmiss_store::Store;
use nearmiss_study::evaluation::Settings;
use nearmiss_study::evaluation::batch::Spec;
use nearmiss_study::evaluation::generating::{
    self, Author, AuthorError, Authored, AuthoredRecord, Bound, Tries, bound,
};
use nearmiss_workflow::variant::WriterSettings;
use nearmiss_workflow::{
    AttackSource, AttackWriter, GenerateRequest, Server, generate, prepare_beside,
};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;
use tokio::runtime::{Handle, Runtime};

use super::GenerateArguments;
use super::settings::AskSettings;
use super::variant::GenerateJob;
use crate::ending::interrupted;
use crate::many_files::{Job, NEXT};
use crate::open::{configured_models, configured_parameters, judge_of, runtime, user_thresholds};
use crate::output::Align::{Left, Right};
use crate::output::{self, counted};
use crate::prompts::templates;
use crate::{Failure, Outcome};

/// The model, ready to ask.
pub struct Writer {
    author: Author,
    parameters: Parameters,
    runtime: Runtime,
}

impl Writer {
    /// The model that the arguments name.
    pub fn new(
        arguments: &GenerateArguments,
        asking: &AskSettings,
        folders: &Folders,
        config: &Config,
    ) -> Result<Self, Failure> {
        let model = &arguments.model;
        if model == judge::MODEL {
            return Err(Failure::input(format!(
                "{model} cannot answer attack questions; --model search needs no model"
            )));
        }
        let mut providers = config.provider.clone();
        if let Some(url) = &arguments.base_url {
            let server = Server {
                url,
                ..Server::default()
            };
            server.overlay(&mut providers, model.split('/').next().unwrap_or_default());
        }
        let parameters = configured_parameters(config);
        let budget = arguments.budget.or(config.budget);
        let models = configured_models(&providers, folders, parameters, budget);
        let judge = judge_of(&models, model)?;
        let library = templates(folders)?;
        let store = Store::open(&folders.store()).map_err(Failure::input)?;
        let author = Author {
            name: String::new(),
            judge,
            store: Some(Arc::new(store)),
            library,
            thresholds: Arc::new(user_thresholds(folders)?),
            settings: Settings::default(),
            frame: None,
            method: asking.method(config),
            at_once: config.concurrency as usize,
            attacker: arguments.attacker.first().copied(),
            obey: asking.obey,
            fresh: arguments.fresh,
            batch: None,
        };
        Ok(Self {
            author,
            parameters,
            runtime: runtime(1)?,
        })
    }

    /// Who writes about the scenario of this name.
    pub fn author(&self, name: &str) -> Author {
        Author {
            name: name.into(),
            ..self.author.clone()
        }
    }

    /// What it is asked on.
    pub fn runtime(&self) -> Handle {
        self.runtime.handle().clone()
    }

    /// All that decides what it is asked, and how often.
    pub fn settings(&self) -> WriterSettings {
        let author = &self.author;
        WriterSettings {
            id: self.id().into(),
            method: author.method,
            obey: author.obey,
            parameters: json!(self.parameters),
            templates: author.templates(),
            thresholds: Spec::threshold_changes(&author.thresholds),
        }
    }

    /// Its id.
    pub fn id(&self) -> &str {
        self.author.judge.id()
    }
}

/// What models did in all scenarios.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct ModelsReport {
    /// Answers of models.
    requests: u32,
    /// Of these, answers from the store.
    from_store: u32,
    /// Tokens of prompts and answers.
    tokens: u64,
    /// Cost of answers with a known price, US dollars.
    cost_usd: f64,
    /// Answers without a known price.
    unpriced: u32,
    /// Conversations with a model: how many of their first answers pass the gate, and have an effect that an ideal driver
    /// survives.
    tries: Tries,
    /// Scenarios in which the model's grades and the exact ranking were compared.
    agreement: AgreementReport,
}

/// In how many scenarios the model's grades and the exact ranking prefer the same motion.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
struct AgreementReport {
    compared: usize,
    agreed: usize,
    share: Option<f64>,
    /// In how many they would by chance.
    by_chance: f64,
}

impl ModelsReport {
    pub fn count(&mut self, consumed: &AuthoredRecord) {
        self.requests += consumed.requests;
        self.from_store += consumed.from_store;
        self.tokens += consumed.input_tokens + consumed.output_tokens;
        self.cost_usd += consumed.cost_usd;
        self.unpriced += consumed.unpriced;
        let tries = consumed.tries;
        self.tries.conversations += tries.conversations;
        self.tries.first_admitted += tries.first_admitted;
        self.tries.first_effective += tries.first_effective;
        self.tries.effective += tries.effective;
        if let Some(agreed) = consumed.agreement {
            let all = &mut self.agreement;
            all.compared += 1;
            all.agreed += usize::from(agreed.agrees);
            all.by_chance += agreed.by_chance;
            all.share = Some(all.agreed as f64 / all.compared as f64);
        }
    }

    /// Describes the figures; nothing where no model was asked.
    pub fn words(&self) -> String {
        if self.requests == 0 {
            return String::new();
        }
        let mut text = String::new();
        let Tries {
            conversations,
            first_admitted,
            first_effective,
            effective,
        } = self.tries;
        if conversations > 0 {
            text.push_str(&format!(
                "{}: first answers that pass the gate {first_admitted}, effective and survivable {first_effective}; after retries {effective}\n",
                counted(conversations, "conversation"),
            ));
        }
        let AgreementReport {
            compared,
            agreed,
            by_chance,
            ..
        } = self.agreement;
        if compared > 0 {
            text.push_str(&format!(
                "the model's grades and the exact ranking prefer the same motion in {agreed} of {} (by chance in {by_chance:.1})\n",
                counted(compared, "scenario"),
            ));
        }
        text + &self.consumed()
    }

    fn consumed(&self) -> String {
        let sent = self.requests.saturating_sub(self.from_store);
        let cost = match self.unpriced {
            0 => format!("{:.4} USD", self.cost_usd),
            n if n >= self.requests => "price unknown".into(),
            n => format!(
                "{:.4} USD, plus {} without a known price",
                self.cost_usd,
                counted(n as usize, "answer")
            ),
        };
        let stored = match self.from_store {
            0 => String::new(),
            n => format!(
                ", {} from the store (counted here, paid before)",
                counted(n as usize, "answer")
            ),
        };
        let sent = counted(sent as usize, "request");
        format!("{sent}{stored}; {} tokens, {cost}\n", self.tokens)
    }
}

/// Counts in place of asking.
struct Counter {
    author: Author,
    found: Mutex<Option<Bound>>,
}

impl AttackWriter for Counter {
    fn write(
        &self,
        ground: &AttackSetup<'_>,
        scene: &Arc<Scene>,
        delay: f64,
        _: &Cancel,
        _: &mut dyn FnMut(generating::Progress),
    ) -> Result<Option<Authored>, AuthorError> {
        let bound = bound(&self.author, ground, scene, delay)?;
        if let Ok(mut found) = self.found.lock() {
            *found = Some(bound);
        }
        Ok(None)
    }
}

/// Prints a line for each scenario, and the sum.
pub fn dry_run(entries: &[Entry], job: &GenerateJob) -> Outcome {
    let Some(writer) = &job.writer else {
        return Err(Failure::input(
            "--dry-run counts what a model is asked; name one with --model, the search asks none",
        ));
    };
    let stop = interrupted(true);
    let cancel = Cancel::from_flag(&stop);
    let width = entries
        .iter()
        .map(|e| output::visible(&e.name).chars().count())
        .max()
        .unwrap_or(0)
        .clamp("scenario".len(), 48);
    let line = |name: &str, cells: [&str; 6]| {
        let columns = [
            Left(width),
            Right(8),
            Right(6),
            Right(8),
            Right(7),
            Right(9),
            Right(10),
        ];
        let cells: Vec<&str> = std::iter::once(name).chain(cells).collect();
        output::line("  ", &columns, &cells)
    };
    let cells = |bound: &Bound| {
        [
            bound.requests().to_string(),
            bound.votes.to_string(),
            bound.motions.to_string(),
            bound.grades.to_string(),
            bound.tokens.to_string(),
            bound
                .usd
                .map_or("unknown".into(), |usd| format!("{usd:.4}")),
        ]
    };
    let shown = |name: &str, bound: &Bound| {
        let cells = cells(bound);
        let [a, b, c, d, e, f] = &cells;
        line(name, [a, b, c, d, e, f])
    };
    output::text(&line(
        "scenario",
        ["requests", "votes", "motions", "grades", "tokens", "USD"],
    ))?;
    let mut all = Bound {
        usd: Some(0.0),
        ..Bound::default()
    };
    let mut failed = 0;
    let count = |entry: &Entry| {
        let counter = Counter {
            author: writer.author(&entry.name),
            found: Mutex::new(None),
        };
        let prepared = prepare_beside(entry, job.problem, &job.attack.settings);
        let counted = prepared.and_then(|prepared| {
            let prepared = prepared.driven_by(job.attack.planner.clone());
            let request = GenerateRequest {
                prepared: &prepared,
                attackers: &job.attack.only,
                wish: None,
                delay: job.attack.effort.delay,
                style: job.attack.style,
                source: AttackSource::Model(&counter),
            };
            generate(&request, &cancel, &mut |_| {})
        });
        // Nothing is asked where the ego is touched already.
        let none = || Bound {
            usd: Some(0.0),
            ..Bound::default()
        };
        let found = counter.found.into_inner().ok().flatten();
        Some(counted.map(|_| found.unwrap_or_else(none)))
    };
    let done = Job::new("scenarios", &stop).run(entries, count, |entry, found| {
        match found {
            Ok(found) => {
                output::text(&shown(&output::visible(&entry.name), &found))?;
                all = all.and(&found);
            }
            Err(error) => {
                output::say(&format!("nearmiss: {error}"));
                failed += 1;
            }
        }
        NEXT
    });
    done.end("nothing was asked")?;
    if entries.len() > 1 {
        output::text(&shown("all, at most", &all))?;
    }
    match failed {
        0 => Ok(()),
        n => Err(Failure::finding(format!(
            "{} could not be attacked",
            output::of_scenarios(n, entries.len())
        ))),
    }
}

#[cfg(test)]
mod tests {
    use nearmiss_study::evaluation::generating::AgreementRecord;

    use super::*;

    fn consumed(tries: Tries, agreement: Option<AgreementRecord>) -> AuthoredRecord {
        AuthoredRecord {
            requests: 4,
            from_store: 1,
            input_tokens: 30,
            output_tokens: 3,
            cost_usd: 0.5,
            tries,
            agreement,
            ..AuthoredRecord::default()
        }
    }

    #[test]
    fn first_tries_and_agreement_are_summed_up() {
        let tries = Tries {
            conversations: 2,
            first_admitted: 2,
            first_effective: 1,
            effective: 2,
        };
        let agreement = |agrees: bool, by_chance: f64| AgreementRecord {
            agrees,
            of: 2,
            by_chance,
            ..AgreementRecord::default()
        };
        let mut figures = ModelsReport::default();
        assert_eq!(figures.words(), "");
        figures.count(&consumed(tries, Some(agreement(true, 0.5))));
        figures.count(&consumed(tries, Some(agreement(false, 0.25))));
        // No motion of its own to compare.
        figures.count(&consumed(Tries::default(), None));
        assert_eq!(figures.tries.first_effective, 2);
        let agreement = AgreementReport {
            compared: 2,
            agreed: 1,
            share: Some(0.5),
            by_chance: 0.75,
        };
        assert_eq!(figures.agreement, agreement);
        let words = figures.words();
        assert!(
            words.contains("the same motion in 1 of 2 scenarios"),
            "{words}"
        );
        assert!(
            words.contains("4 conversations: first answers that pass the gate 4, "),
            "{words}"
        );
        assert!(words.ends_with("9 requests, 3 answers from the store (counted here, paid before); 99 tokens, 1.5000 USD\n"));
    }
}
