//! Background work: runs effects as tasks, which send messages back.

mod asking;
mod batch;
pub mod drives;
mod experiment;
pub mod history;
mod index;
mod job;
pub mod making;
pub mod pictures;
mod planning;
mod queue;
pub mod results;
mod scenarios;
mod scenes;
mod templates;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::mpsc::UnboundedSender;

use self::job::RunningJobs;
use self::queue::Queue;
use super::loaded::{PictureJob, Source};
use super::message::{Effect, ExternalEdit, Msg, StoredOf};
use super::session::{self, drafts};
use nearmiss_ask::llm::{Effort, Environment, Parameters, Registry, probe};
use nearmiss_ask::prompts::Library;
use nearmiss_drive::simulation::{ExternalPlanner, Settings};
use nearmiss_formats::EgoSelection;
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::{Config, Folders, SavedViews, TextFile};
use nearmiss_store::{Origin, Store};
use nearmiss_study::evaluation::{Answer, default_planning};
use nearmiss_workflow::{Models, experiments_in};

/// Times five milliseconds that cancelled questions have to be written down.
const PATIENCE: usize = 100;

/// How long after a change the session is saved: what a killed program loses.
const SESSION_DELAY: Duration = Duration::from_secs(2);

/// Earlier answers that are looked through: the newest on a scenario and task.
const MOST_STORED: usize = 100;

/// Shared resources of all tasks.
pub struct Tasks {
    /// Where messages go.
    sender: UnboundedSender<Msg>,
    folders: Folders,
    /// The models that can be asked; this session's budget bounds what they cost.
    models: Models,
    thresholds: Arc<Thresholds>,
    store: Option<Arc<Store>>,
    /// The ego of a scenario where no obstacle is taken in its place.
    ego: EgoSelection,
    jobs: RunningJobs,
    pictures: pictures::Drawing,
    /// How the configuration wants the ego to be planned.
    planning: Settings,
    /// The planners of the configuration that are processes.
    planners: Vec<Arc<ExternalPlanner>>,
    /// Reads for the history, while that is open.
    history: Option<history::Reader>,
    /// Tells the reading of results that is under way to end.
    results: Arc<std::sync::atomic::AtomicBool>,
    batches: batch::Batches,
    /// The user's providers, as the configuration has them.
    providers: toml::Table,
    /// Requests of batches at once, to one provider.
    concurrency: std::num::NonZeroU32,
    /// Scenarios whose facts are wanted.
    survey: Queue,
    /// Scenarios whose value of a measure is wanted.
    ranking: Queue,
}

/// Effects left to the main loop, which owns the terminal.
#[derive(Debug)]
pub enum LoopEffect {
    /// Paint the screen for a picture, and give it back.
    Picture(Box<PictureJob>),
    /// Put text into the clipboard.
    Copy(String),
    /// Use the mouse, or not.
    UseMouse(bool),
    /// Let the user edit a text in an editor of theirs.
    EditOutside(ExternalEdit),
    /// Go back to the shell for a while.
    Suspend,
    /// End the program.
    Quit,
}

impl Tasks {
    /// Ready for work.
    #[must_use]
    pub fn new(
        sender: UnboundedSender<Msg>,
        folders: Folders,
        (registry, environment): (Registry, Environment),
        config: &Config,
        thresholds: Arc<Thresholds>,
        store: Option<Arc<Store>>,
        ego: EgoSelection,
    ) -> Self {
        Self {
            survey: Queue::new(sender.clone()),
            ranking: Queue::new(sender.clone()),
            sender,
            folders,
            models: Models::new(registry, environment, parameters(config), config.budget),
            thresholds,
            store,
            ego,
            jobs: RunningJobs::default(),
            pictures: pictures::Drawing::default(),
            planning: config.planning(default_planning()),
            planners: { config.external_planners().into_iter() }
                .map(|(name, options)| Arc::new(ExternalPlanner::new(name, options)))
                .collect(),
            history: None,
            results: Arc::default(),
            batches: batch::Batches::default(),
            providers: config.providers.clone(),
            concurrency: config.concurrency,
        }
    }

    /// Begins what an effect asks for; gives back what only the loop can do.
    pub fn perform(&mut self, effect: Effect) -> Option<LoopEffect> {
        match effect {
            Effect::Find(paths) => self.find(paths),
            Effect::Probe => self.probe(),
            Effect::Survey(entries) => self.survey(entries),
            Effect::SurveyMore(entries) => self.survey.add(entries),
            Effect::SurveyFirst(places) => self.survey.first(places),
            Effect::Recount(entries) => self.recount(entries),
            Effect::ReadTags => self.read_tags(),
            Effect::ChangeTags(scenario, tags) => self.change_tags(scenario, tags),
            Effect::ReadViews => {
                let path = self.folders.views();
                self.background(move || Msg::Views(SavedViews::read(&path)));
            }
            Effect::ChangeView(name, view) => {
                let path = self.folders.views();
                self.background(move || Msg::Views(SavedViews::change(&path, &name, view)));
            }
            Effect::Rank(measure, entries) => self.rank(measure, entries),
            Effect::Open(id, entry, obstacle) => self.open(id, entry, obstacle, None),
            Effect::OpenChanged(id, entry, obstacle, change) => {
                self.open(id, entry, obstacle, Some(change));
            }
            Effect::Compute(computation) => {
                self.background(move || Msg::Computed(computation.run()));
            }
            Effect::ReadThresholds => {
                let path = self.folders.thresholds();
                self.background(move || Msg::Thresholds(thresholds(&path).map(Arc::new)));
            }
            Effect::UseThresholds(thresholds) => self.thresholds = thresholds,
            Effect::LoadStored(of) => self.load_stored(of),
            Effect::Rate(round, rating, replaced) => self.with_store(move |store| {
                let keep = |store: &Store| match replaced {
                    None => store.rate(&rating),
                    Some(id) => store.rate_anew(id, &rating).map(|()| id),
                };
                let kept = store.and_then(|s| keep(&s).map_err(|e| e.to_string()));
                Msg::Rated(round, kept)
            }),
            Effect::ReadRatings => {
                self.with_store(|store| {
                    Msg::Ratings(store.and_then(|s| s.ratings().map_err(|e| e.to_string())))
                });
            }
            Effect::FindUnrated(task, person) => self.with_store(move |store| {
                let find = |store: Arc<Store>| store.unrated(task, &person, judge::MODEL);
                Msg::Unrated(store.and_then(|s| find(s).map_err(|e| e.to_string())))
            }),
            Effect::KeepDraft(file, draft) => {
                // At once and not in the background: the program may be about to end.
                let folder = self.folders.drafts();
                if let Err(error) = drafts::keep(&folder, &file, draft.as_deref()) {
                    let _ = self.sender.send(Msg::Complaint(error));
                }
            }
            Effect::RememberLater => {
                let sender = self.sender.clone();
                tokio::spawn(async move {
                    tokio::time::sleep(SESSION_DELAY).await;
                    // The receiver is gone once the loop has ended.
                    let _ = sender.send(Msg::KeepSession);
                });
            }
            // At once and not in the background: the program may be about to end.
            Effect::Remember(session) => {
                if let Err(error) = session::file::write(&self.folders.sessions(), &session) {
                    let complaint = format!("{error}; the session is not kept");
                    let _ = self.sender.send(Msg::Complaint(complaint));
                }
            }
            Effect::History(ask) => self.history(ask),
            Effect::Results(ask) => self.results(ask),
            Effect::Start(id, request) => self.start(id, request),
            Effect::Cancel(id) => self.jobs.cancel(id),
            Effect::SaveDrive(files) => {
                self.background(move || Msg::DriveSaved(files.key, drives::write(&files)));
            }
            Effect::SaveVariant(made, folder) => self.background(move || {
                let written = making::write(&made, folder.as_deref());
                Msg::VariantSaved(made, written)
            }),
            Effect::StopSurvey => self.survey.stop(),
            Effect::StopRanking => self.ranking.stop(),
            Effect::SaveTemplate(file, text) => {
                let path = self.folders.prompts().join(&file);
                self.change_template(file, move || {
                    let written = Folders::write(&path, &text);
                    written.map_err(|e| templates::named(&path, &e))?;
                    Ok(format!("saved as {}", path.display()))
                });
            }
            Effect::RemoveTemplate(file, draft) => {
                let path = self.folders.prompts().join(&file);
                self.change_template(file, move || {
                    templates::set_aside(&path, draft.as_deref())
                        .map_err(|e| templates::named(&path, &e))
                });
            }
            Effect::SaveTemplateAs(file, text) => {
                let folder = self.folders.prompts();
                self.change_template(file.clone(), move || {
                    templates::save_as(&folder, &file, &text)
                });
            }
            Effect::UseTemplate(file) => {
                let folder = self.folders.prompts();
                self.change_template(file.clone(), move || templates::choose(&folder, &file));
            }
            Effect::EditOutside(outside) => return Some(LoopEffect::EditOutside(outside)),
            Effect::ListExperiments(folder) => self.background(move || {
                let found = experiments_in(&folder);
                Msg::ExperimentFiles(folder, found)
            }),
            Effect::ReadSource(place, entry) => {
                self.background(move || Msg::Source(place, Source::read(&entry).map(Box::new)))
            }
            Effect::RereadTemplates => {
                let folder = self.folders.prompts();
                self.background(move || Msg::Reread(Library::load(Some(&folder))));
            }
            Effect::Picture(job) if job.needs_screen() => return Some(LoopEffect::Picture(job)),
            Effect::Picture(job) => self.draw(job),
            Effect::Copy(text) => return Some(LoopEffect::Copy(text)),
            Effect::UseMouse(on) => return Some(LoopEffect::UseMouse(on)),
            Effect::Suspend => return Some(LoopEffect::Suspend),
            Effect::Quit => return Some(LoopEffect::Quit),
        }
        None
    }

    fn background(&self, work: impl FnOnce() -> Msg + Send + 'static) {
        let sender = self.sender.clone();
        tokio::task::spawn_blocking(move || {
            // The receiver is gone once the loop has ended.
            let _ = sender.send(work());
        });
    }

    fn probe(&self) {
        let registry = self.models.registry().clone();
        let environment = self.models.environment().clone();
        let sender = self.sender.clone();
        tokio::spawn(async move {
            let mut found = probe(&registry, &environment).await;
            found.models.retain(|model| !model.is_no_chat());
            let notes = found.notes.into_iter().map(Msg::Complaint);
            for message in std::iter::once(Msg::Discovered(found.models)).chain(notes) {
                let _ = sender.send(message);
            }
        });
    }

    fn load_stored(&self, of: StoredOf) {
        let Some(store) = self.store.clone() else {
            return;
        };
        self.background(move || {
            match store.of_scenario(&of.scenario, &of.name, of.task, MOST_STORED) {
                Ok(runs) => {
                    let same = runs.into_iter().filter(|run| match run.origin {
                        Origin::Recorded => of.recorded,
                        _ => run.question.ego == of.ego,
                    });
                    let answers = same.map(Answer::from).collect();
                    Msg::Stored(of, answers)
                }
                Err(error) => Msg::Complaint(format!("earlier answers are not shown: {error}")),
            }
        });
    }

    /// Works on the store, or says that there is none.
    fn with_store(&self, work: impl FnOnce(Result<Arc<Store>, String>) -> Msg + Send + 'static) {
        let store = self.store.clone();
        self.background(move || {
            work(store.ok_or_else(|| "the store of runs is not open".to_string()))
        });
    }

    /// Cancels what is on its way and waits until that is written down.
    pub async fn finish(&mut self) {
        self.jobs.cancel_all();
        self.pictures.stop();
        for _ in 0..PATIENCE {
            if self.jobs.is_settled() && self.pictures.ended() {
                return;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    }

    /// Draws and saves a picture in the background.
    pub fn draw(&self, job: Box<PictureJob>) {
        let drawing = self.pictures.begin();
        self.background(move || Msg::Pictured(pictures::save(&job, &drawing)));
    }

    fn change_template(
        &self,
        file: String,
        change: impl FnOnce() -> Result<String, String> + Send + 'static,
    ) {
        let folder = self.folders.prompts();
        self.background(move || {
            let result = change().map(|words| (Library::load(Some(&folder)), words));
            Msg::Saved(file, result)
        });
    }
}

/// Request parameters beside the messages; tools are switched while the workbench runs.
fn parameters(config: &Config) -> Parameters {
    Parameters {
        temperature: config.temperature,
        max_tokens: config.max_tokens,
        seed: None,
        effort: config.effort.as_deref().and_then(Effort::parse),
        log_probabilities: config.log_probabilities,
        tools: None,
    }
}

/// The shipped thresholds, changed by the user's file if it is there.
///
/// # Errors
/// The file cannot be read, or has an invalid entry: with file and line.
pub fn thresholds(path: &Path) -> Result<Thresholds, String> {
    match TextFile::read_if_there(path)? {
        Some(said) => Thresholds::read(&said.text, &said.file).map_err(|e| e.to_string()),
        None => Ok(Thresholds::shipped().clone()),
    }
}
