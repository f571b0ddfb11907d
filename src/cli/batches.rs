//! `nearmiss runs batches`: lists provider batches, and collects their answers.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use schemars::JsonSchema;
use serde::Serialize;

use super::filters::store;
use super::open::configuration;
use super::{Failure, Outcome, ending, output};
use nearmiss_ask::llm::{Client, Environment, Error, Parameters, Registry};
use nearmiss_store::{ProviderBatch, ProviderBatchId, ProviderBatchState, Store};
use nearmiss_study::evaluation::remote::{self, GivenUp, Progress, RemoteError};
use nearmiss_study::evaluation::{Judge, ModelJudge};

/// Arguments of `batches`.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Batches {
    #[command(subcommand)]
    what: Option<BatchesCommand>,
    #[command(flatten)]
    format: output::FormatOption,
}

#[derive(Debug, clap::Subcommand)]
enum BatchesCommand {
    /// Fetch the answers that the provider has ready.
    Collect {
        /// Batch number [default: every unfinished batch].
        id: Option<i64>,
        /// Poll until every answer has arrived.
        #[arg(long)]
        wait: bool,
    },
    /// Ask the provider to cancel a batch; finished answers are charged and can still be collected.
    Cancel {
        /// Batch number.
        id: i64,
    },
    /// Give up a batch that the provider has lost, so that its questions can be asked again; answered ones may be
    /// charged twice.
    GiveUp {
        /// Batch number.
        id: i64,
        /// Skip the check with the provider, even if it may still deliver or is unreachable.
        #[arg(long)]
        force: bool,
    },
}

/// The first and the longest wait between two questions about a batch, with --wait.
const WAITS: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(60));

/// Runs `batches`.
pub fn run(arguments: &Batches) -> Outcome {
    let store = store()?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(Failure::input)?;
    match &arguments.what {
        None => list_batches(&store, arguments.format.is_json()),
        Some(BatchesCommand::Collect { id, wait }) => {
            let wanted = match id {
                Some(id) => vec![known(&store, *id)?],
                None => open(&store)?,
            };
            if wanted.is_empty() {
                output::say("nearmiss: no batch is open at a provider");
                return Ok(());
            }
            runtime.block_on(interruptible(collect(&store, wanted, *wait)))
        }
        Some(BatchesCommand::Cancel { id }) => {
            let batch = known(&store, *id)?;
            runtime.block_on(interruptible(cancel(&store, batch)))
        }
        Some(BatchesCommand::GiveUp { id, force }) => {
            let batch = known(&store, *id)?;
            runtime.block_on(interruptible(give_up(&store, batch, *force)))
        }
    }
}

/// Until Ctrl-C or SIGTERM: whatever it interrupts is in the store and can be done again.
async fn interruptible(work: impl Future<Output = Outcome>) -> Outcome {
    tokio::select! {
        done = work => done,
        () = ending::signal() => Err(Failure::interrupted(
            "the batches stay with their providers: run `nearmiss runs batches collect` again",
        )),
    }
}

fn known(store: &Store, id: i64) -> Result<ProviderBatch, Failure> {
    let id = ProviderBatchId(id);
    let found = store.provider_batch(id).map_err(Failure::input)?;
    found.ok_or_else(|| Failure::input(RemoteError::NoBatch(id)))
}

/// The batches that are not over, oldest first.
fn open(store: &Store) -> Result<Vec<ProviderBatch>, Failure> {
    let mut all = store.provider_batches().map_err(Failure::input)?;
    all.retain(|batch| batch.state.is_open());
    all.reverse();
    Ok(all)
}

/// The model of a batch as it is configured now.
fn model(batch: &ProviderBatch, client: &Client) -> Result<Box<ModelJudge>, Failure> {
    let (folders, config) = configuration()?;
    let environment = Environment::with_files(&[Path::new("."), &folders.config]);
    let registry = Registry::lenient(&config.provider, &folders.config_file());
    let parameters = Parameters::default();
    match Judge::resolve(&batch.model, &registry, client, parameters, &environment) {
        Ok(Judge::Model(model)) => Ok(model),
        Ok(Judge::Recorded(id)) => Err(Failure::input(format!(
            "{id}: recorded answers have no batches"
        ))),
        Ok(Judge::Reference) => Err(Failure::input("the built-in judge has no batches")),
        Err(error) => Err(Failure::input(format!("batch {}: {error}", batch.id))),
    }
}

async fn collect(store: &Arc<Store>, mut wanted: Vec<ProviderBatch>, wait: bool) -> Outcome {
    let client = Client::new();
    let (mut pause, longest) = WAITS;
    let mut said = HashMap::new();
    let mut hopeless = false;
    loop {
        let mut failed = false;
        let mut still = Vec::new();
        for batch in wanted {
            let model = model(&batch, &client)?;
            match remote::collect(batch.id, &model, store).await {
                Ok(progress) => {
                    let words = batch_line(&batch, &progress);
                    if said.insert(batch.id, words.clone()) != Some(words.clone()) {
                        output::say(&words);
                    }
                    if progress.is_open() {
                        still.push(batch);
                    }
                }
                Err(
                    error @ (RemoteError::Provider(_)
                    | RemoteError::Short { .. }
                    | RemoteError::Gone { .. }),
                ) => {
                    let words = format!("nearmiss: batch {}: {error}", batch.id);
                    if said.insert(batch.id, words.clone()) != Some(words.clone()) {
                        output::say(&words);
                    }
                    failed = true;
                    // A network that is gone comes back; a key that is missing does not.
                    if may_pass(&error) {
                        still.push(batch)
                    } else {
                        hopeless = true
                    }
                }
                Err(error) => return Err(Failure::input(error)),
            }
        }
        wanted = still;
        if !wait || wanted.is_empty() {
            return if failed || hopeless {
                Err(Failure::finding(
                    "some batches could not be collected; try again",
                ))
            } else {
                Ok(())
            };
        }
        tokio::time::sleep(pause).await;
        pause = (pause * 2).min(longest);
    }
}

/// Whether asking again later may go better by itself.
fn may_pass(error: &RemoteError) -> bool {
    let error = match error {
        RemoteError::Provider(error) => error,
        RemoteError::Gone { .. } => return false,
        _ => return true,
    };
    match error {
        Error::RateLimited { exhausted, .. } => !exhausted,
        Error::Refused { .. } | Error::Unreachable { .. } | Error::Timeout { .. } => true,
        Error::Server { .. } | Error::Truncated { .. } => true,
        _ => false,
    }
}

async fn cancel(store: &Arc<Store>, batch: ProviderBatch) -> Outcome {
    let id = batch.id;
    let model = model(&batch, &Client::new())?;
    let asked = remote::cancel(id, &model, store).await;
    output::say(&if asked.map_err(Failure::input)? {
        format!(
            "batch {id}: asked the provider to stop; `nearmiss runs batches collect {id}` fetches the answers so far"
        )
    } else {
        format!("batch {id}: already finished")
    });
    Ok(())
}

async fn give_up(store: &Arc<Store>, batch: ProviderBatch, force: bool) -> Outcome {
    let id = batch.id;
    if !batch.state.is_open() {
        output::say(&format!("batch {id}: already finished"));
        return Ok(());
    }
    let done = if force {
        remote::give_up_unasked(id, "given up without asking the provider", store)
    } else {
        let model = model(&batch, &Client::new())?;
        remote::give_up(id, &model, store).await
    };
    let done = done.map_err(|error| match error {
        error @ RemoteError::Provider(_) => Failure::input(format!(
            "batch {id}: {error}; --force gives it up without asking the provider"
        )),
        error => Failure::input(error),
    })?;
    output::say(&match done {
        GivenUp::Collected(progress) => batch_line(&batch, &progress),
        GivenUp::Freed { questions, batches } => {
            let again: Vec<String> = batches
                .iter()
                .map(|batch| format!("`nearmiss evaluate {batch}`"))
                .collect();
            let again = if again.is_empty() {
                String::new()
            } else {
                format!(": {}", again.join(", "))
            };
            format!(
                "batch {id}: given up; {questions} questions can be asked again{again}; you may pay twice for those already answered"
            )
        }
    });
    Ok(())
}

/// Explains how to find a batch whose id did not come back from the provider.
pub fn lost_note(batch: &ProviderBatch) -> Option<String> {
    let is_lost = batch.state == ProviderBatchState::Submitting && batch.remote_id.is_none();
    is_lost.then(|| {
        format!(
            "no id came back, but the provider may have it, with question ids starting with {}; `nearmiss runs batches collect {}` looks for it",
            batch.tag, batch.id
        )
    })
}

fn batch_line(batch: &ProviderBatch, progress: &Progress) -> String {
    let id = batch.id;
    match progress {
        Progress::Unknown => format!(
            "batch {id}: unknown whether it reached {}, where its question ids start with {}; collect again in a few minutes",
            batch.model, batch.tag
        ),
        Progress::NotSent => {
            format!(
                "batch {id}: never reached {}; ask its questions again",
                batch.model
            )
        }
        Progress::Working {
            cancelling,
            answered,
            failed,
        } => format!(
            "batch {id}: {} is {} it: {answered} answered and {failed} failed of {}",
            batch.model,
            if *cancelling {
                "stopping"
            } else {
                "working on"
            },
            batch.requests
        ),
        Progress::Over {
            state,
            taken,
            without,
        } => format!(
            "batch {id}: {}; {taken} results stored, {without} questions without a result",
            state.name()
        ),
    }
}

fn list_batches(store: &Store, as_json: bool) -> Outcome {
    use output::Align::{Left, Right};
    let all = store.provider_batches().map_err(Failure::input)?;
    if as_json {
        return all
            .iter()
            .try_for_each(|batch| output::document(&Document::of(batch)));
    }
    if all.is_empty() {
        output::say(
            "nearmiss: no batches at providers yet; `nearmiss evaluate --batch` submits one",
        );
        return Ok(());
    }
    let titles = [
        "batch",
        "sent",
        "state",
        "results",
        "model",
        "provider's id",
    ]
    .map(String::from);
    let rows = all.iter().map(|batch| {
        [
            batch.id.to_string(),
            output::local(batch.submitted_ms),
            batch.state.name().into(),
            format!("{}/{}", batch.done, batch.requests),
            batch.model.clone(),
            batch.remote_id.as_deref().unwrap_or("not known").into(),
        ]
    });
    let widest = all.iter().map(|b| b.model.chars().count()).max();
    let width = widest.unwrap_or(0).max("model".len());
    let columns = [Right(5), Left(16), Left(10), Right(11), Left(width)];
    let mut table = output::line("  ", &columns, &titles);
    for (batch, row) in all.iter().zip(rows) {
        table += &output::line("  ", &columns, &row);
        if let Some(problem) = batch.problem.clone().or_else(|| lost_note(batch)) {
            table.push_str(&format!("       {problem}\n"));
        }
    }
    output::text(&output::visible(&table))
}

/// A batch for programs.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    provider_batch: i64,
    /// State of the batch.
    state: &'static str,
    /// Beginning of the ids of its questions at the provider.
    tag: String,
    model: String,
    /// Address of the server.
    address: String,
    /// Id at the provider.
    provider_id: Option<String>,
    created_at: String,
    /// Time of submission, RFC 3339.
    submitted_at: String,
    /// Number of requests.
    requests: u64,
    /// Number of results in the store.
    results: u64,
    problem: Option<String>,
}

impl Document {
    fn of(batch: &ProviderBatch) -> Self {
        Self {
            provider_batch: batch.id.0,
            state: batch.state.name(),
            tag: batch.tag.clone(),
            model: batch.model.clone(),
            address: batch.address.clone(),
            provider_id: batch.remote_id.clone(),
            created_at: output::rfc3339(batch.created_ms),
            submitted_at: output::rfc3339(batch.submitted_ms),
            requests: batch.requests,
            results: batch.done,
            problem: batch.problem.clone(),
        }
    }
}
