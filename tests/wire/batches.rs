//! Batches with providers: against a server that keeps them, in all four dialects.
#![allow(clippy::unwrap_used)]

mod broken;
mod command;
mod given_up;
mod killed;
use crate::support;

use std::sync::Arc;
use std::time::Duration;

use nearmiss::description::Frame;
use nearmiss::evaluation::batch::{Experiment, QuestionBuilder, Variant};
use nearmiss::evaluation::remote::{
    Progress, RemoteError, SubmissionOutcome, cancel, collect, submit,
};
use nearmiss::evaluation::{ModelJudge, PromptConfig, Question, RunOptions};
use nearmiss::formats::{EgoSelection, bundled};
use nearmiss::llm::{Client, Dialect, Endpoint, Parameters, Price, PriceEntry, Prices, Retry};
use nearmiss::metrics::Thresholds;
use nearmiss::prompts::{Library, Techniques};
use nearmiss::store::{Filter, ProviderBatchId, ProviderBatchState, Run, RunState, Store};
use nearmiss::verdict::Task;
use support::batches::{Fate, Provider};

const KEY: &str = "sk-test-batch-0123456789";

const DIALECTS: [Dialect; 4] = [
    Dialect::OpenAiChat,
    Dialect::OpenAiResponses,
    Dialect::Anthropic,
    Dialect::Gemini,
];

/// A provider, a store in a file, and the model to be asked.
struct Bench {
    provider: Provider,
    folder: tempfile::TempDir,
    store: Arc<Store>,
    model: ModelJudge,
}

impl Bench {
    async fn new(dialect: Dialect) -> Self {
        let provider = Provider::start().await;
        let folder = tempfile::tempdir().unwrap();
        let store = Arc::new(Store::open(&folder.path().join("runs.sqlite")).unwrap());
        let model = ModelJudge {
            id: "lab/tiny".into(),
            name: "tiny".into(),
            endpoint: endpoint(provider.base_url(), dialect),
            client: Client::direct(),
            parameters: Parameters {
                max_tokens: Some(500),
                ..Parameters::default()
            },
        };
        Self {
            provider,
            folder,
            store,
            model,
        }
    }

    /// The store as another program opens it after this one was killed.
    fn reopen(&mut self) {
        self.store = Arc::new(Store::open(&self.folder.path().join("runs.sqlite")).unwrap());
    }

    async fn submit(&self, samples: u32) -> Result<SubmissionOutcome, RemoteError> {
        submit(&questions(samples), &self.model, &self.store).await
    }

    async fn collect(&self, id: ProviderBatchId) -> Result<Progress, RemoteError> {
        collect(id, &self.model, &self.store).await
    }

    fn runs(&self) -> Vec<Run> {
        let ids = self.store.numbers(&Filter::default()).unwrap().into_iter();
        let mut runs: Vec<Run> = ids.map(|id| self.store.run(id).unwrap().unwrap()).collect();
        runs.sort_by_key(|run| run.id);
        runs
    }

    /// Fails unless each answered run has its own answer, once.
    fn each_has_its_own(&self) {
        let answered = self.runs().into_iter();
        for run in answered.filter(|run| run.ending.state == RunState::Answered) {
            let parts = run.answer.matches("justification").count();
            assert_eq!((parts, run.reasoning.as_str()), (1, "because"));
            assert!(
                run.answer.contains(&format!("-{} ", run.id)),
                "{}",
                run.answer
            );
            assert!(run.ending.verdict.is_some(), "{run:?}");
        }
    }

    fn states(&self) -> Vec<RunState> {
        self.runs().iter().map(|run| run.ending.state).collect()
    }
}

fn endpoint(base_url: &str, dialect: Dialect) -> Endpoint {
    let price = PriceEntry {
        model: "tiny*".into(),
        from: None,
        to: None,
        up_to: None,
        price: Price {
            input: 2.0,
            output: 8.0,
            cached: None,
            cache_write: None,
        },
        as_of: None,
        source: None,
    };
    Endpoint {
        dialect,
        key: Some(KEY.into()),
        retry: Retry {
            attempts: 3,
            first_wait: Duration::from_millis(1),
            longest_wait: Duration::from_secs(1),
        },
        prices: Prices {
            entries: vec![price],
            peak: None,
            batch_factor: Some(0.5),
        },
        ..Endpoint::new("lab", base_url)
    }
}

/// One question as often as wanted.
fn questions(samples: u32) -> Vec<(Question, RunOptions)> {
    let thresholds = Arc::new(Thresholds::shipped().clone());
    let experiment = Experiment::default();
    let builder = QuestionBuilder::new(
        Library::load(None),
        thresholds,
        experiment,
        EgoSelection::Beside,
    );
    let way = PromptConfig {
        task: Task::Collision,
        frame: Some(Frame::Ego),
        techniques: Some(Techniques::ALL),
        model: "lab/tiny".into(),
        settings: nearmiss::evaluation::AxisValues::default(),
        template: None,
    };
    let question = builder.question(&bundled()[0], &way, &Variant::default(), None);
    let question = Question::clone(&question.unwrap());
    let wanted = |sample| RunOptions {
        sample,
        ..RunOptions::default()
    };
    (0..samples)
        .map(|s| (question.clone(), wanted(s)))
        .collect()
}

fn over(state: ProviderBatchState, taken: usize, without: u64) -> Progress {
    Progress::Over {
        state,
        taken,
        without,
    }
}

#[tokio::test]
async fn a_question_that_a_provider_cut_has_no_verdict() {
    for dialect in DIALECTS {
        let bench = Bench::new(dialect).await;
        bench.provider.world().context = Some(1024);
        let id = bench.submit(1).await.unwrap().batches[0];
        bench.collect(id).await.unwrap();
        let run = &bench.runs()[0];
        let why = run.ending.reading.as_deref().unwrap_or_default();
        assert!(why.contains("the server counts 1024 of about"), "{run:?}");
        assert_eq!(run.ending.verdict, None, "{dialect:?}");
        assert!(run.answer.contains("justification"), "the answer is kept");
    }
}

#[tokio::test]
async fn answers_come_back_to_their_questions_at_half_the_price() {
    for dialect in DIALECTS {
        let mut bench = Bench::new(dialect).await;
        bench.provider.world().state = "in_progress".into();
        let done = bench.submit(3).await.unwrap();
        assert_eq!((done.handed, done.stored, done.taken), (3, 0, 0));
        let [id] = done.batches[..] else {
            panic!("{done:?}")
        };
        // Opened anew, the runs are still with the provider, and none is asked twice.
        bench.reopen();
        assert_eq!(bench.states(), [RunState::Running; 3]);
        let again = bench.submit(4).await.unwrap();
        assert_eq!((again.handed, again.taken), (1, 3));
        let working = bench.collect(id).await.unwrap();
        assert!(matches!(working, Progress::Working { .. }), "{working:?}");

        bench.provider.world().state = String::new();
        let ended = bench.collect(id).await.unwrap();
        assert_eq!(ended, over(ProviderBatchState::Ended, 3, 0), "{dialect:?}");
        assert_eq!(
            bench.collect(id).await.unwrap(),
            over(ProviderBatchState::Ended, 0, 0)
        );
        bench.collect(again.batches[0]).await.unwrap();
        bench.each_has_its_own();
        for run in bench.runs() {
            let ending = &run.ending;
            assert_eq!(ending.state, RunState::Answered);
            assert_eq!(ending.model_returned.as_deref(), Some("tiny-1"));
            assert_eq!(ending.finish.as_deref(), Some("stop"));
            // So many tokens at 2 and 100 at 8 dollars a million, halved.
            let read = ending.consumed.input_tokens.unwrap() as f64;
            let usd = ending.consumed.cost_usd.unwrap();
            assert!((usd - (read + 400.0) * 1e-6).abs() < 1e-12, "{usd}");
            let source = ending.price_source.as_deref().unwrap();
            assert!(source.contains("times 0.5 of listed prices"), "{source}");
        }
        assert_eq!(bench.submit(4).await.unwrap().stored, 4);
        let world = bench.provider.world();
        assert_eq!(world.batches.len(), 2);
        for (id, body) in &world.batches[0].items {
            assert!(
                id.len() <= 64 && body.get("stream").is_none(),
                "{id} {body}"
            );
        }
        let header = dialect.auth() as usize;
        let names = ["authorization", "x-api-key", "x-goog-api-key"];
        for request in &world.requests {
            let key = request.header(names[header]).unwrap();
            assert!(key.ends_with(KEY), "{}", request.path);
        }
    }
}

#[tokio::test]
async fn a_cancelled_or_expired_batch_gives_what_it_has() {
    let fates = [
        Fate::Answered,
        Fate::Errored,
        Fate::Cancelled,
        Fate::Expired,
    ];
    for dialect in DIALECTS {
        for state in ["cancelled", "expired"] {
            let bench = Bench::new(dialect).await;
            {
                let mut world = bench.provider.world();
                world.fates = fates.to_vec();
                world.words = "out of order".into();
                world.state = "in_progress".into();
            }
            let id = bench.submit(4).await.unwrap().batches[0];
            if state == "cancelled" {
                assert!(cancel(id, &bench.model, &bench.store).await.unwrap());
                let working = bench.collect(id).await.unwrap();
                assert!(working.is_open(), "{working:?}");
            }
            bench.provider.world().state = state.into();
            let ended = bench.collect(id).await.unwrap();
            let Progress::Over { taken, without, .. } = ended else {
                panic!("{ended:?}")
            };
            assert_eq!(taken as u64 + without, 4, "{dialect:?} {ended:?}");
            bench.each_has_its_own();
            let runs = bench.runs();
            assert_eq!(runs[0].ending.state, RunState::Answered);
            assert_eq!(runs[1].ending.state, RunState::Failed);
            let error = runs[1].ending.error.as_deref().unwrap();
            assert!(error.contains("out of order"), "{error}");
            for (run, fate) in runs.iter().zip(fates).skip(2) {
                // Gemini does not say which; the batch as a whole does.
                let cancelled = match dialect {
                    Dialect::Gemini => state == "cancelled",
                    _ => fate == Fate::Cancelled,
                };
                if cancelled {
                    assert_eq!(run.ending.state, RunState::Cancelled)
                } else {
                    assert_eq!(run.ending.state, RunState::Failed);
                    let error = run.ending.error.as_deref().unwrap();
                    assert!(error.contains("expired"), "{error}");
                }
            }
            // What has no answer can be asked again.
            assert_eq!(bench.submit(4).await.unwrap().handed, 3);
        }
    }
}

#[tokio::test]
async fn what_is_too_large_for_one_batch_becomes_several() {
    let bench = Bench::new(Dialect::OpenAiChat).await;
    let mut large = questions(3);
    for (question, _) in &mut large {
        question.prompt.user = "x".repeat(6 << 20);
    }
    let done = submit(&large, &bench.model, &bench.store).await.unwrap();
    assert_eq!((done.handed, done.batches.len()), (3, 2));
    let sizes: Vec<usize> = bench
        .provider
        .world()
        .batches
        .iter()
        .map(|b| b.items.len())
        .collect();
    assert_eq!(sizes, [2, 1]);
    for id in done.batches {
        let ended = bench.collect(id).await.unwrap();
        assert!(
            matches!(ended, Progress::Over { without: 0, .. }),
            "{ended:?}"
        );
    }
    bench.each_has_its_own();
}
