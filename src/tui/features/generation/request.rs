//! Making a scenario dangerous in the background; writing a variant.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use tokio::sync::oneshot;

use crate::features::jobs::notes;
use crate::loaded::{
    GeneratedVariant, GenerationInputs, GenerationOutcome, GenerationProgress, Opened,
    VariantRequest, Writer,
};
use crate::message::Effect;
use crate::model::{JobId, JobState, Model, Update};
use crate::request::{Replies, Request};
use crate::services::Services;
use nearmiss_drive::generation::{Effort, VariantFiles};
use nearmiss_drive::simulation::Settings;
use nearmiss_study::evaluation::generating::Author;
use nearmiss_workflow::{AttackSource, ModelWriter};

/// Makes a scenario dangerous: a model writes the attack, or it is searched for.
#[derive(Debug)]
pub struct Generate {
    /// Its number.
    pub id: JobId,
    /// What is wanted.
    pub request: Box<VariantRequest>,
}

/// Making a scenario dangerous.
pub type GenerationUpdate = Update<GenerationProgress, GenerationOutcome>;

impl Request for Generate {
    type Reply = (JobId, GenerationUpdate);

    fn sent(&self, model: &mut Model) {
        let job = super::job(self.id, &self.request, model.uptime);
        model.jobs.add(job);
    }

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Self { id, request } = self;
        let settings = Settings {
            forecast: request.forecast,
            ..services.planning
        };
        let planner = services.planner(request.planner);
        let writing = match request.writer.as_deref() {
            Some(writer) => match author(services, writer, request.only) {
                Ok(author) => Some((author, until_dropped(services))),
                Err(why) => {
                    replies.send((id, Update::Ended(Err(why))));
                    return;
                }
            },
            None => None,
        };
        let (ego, thresholds) = (services.ego.clone(), services.thresholds.clone());
        let runtime = tokio::runtime::Handle::current();
        services.run(id, replies, move |cancel, progress| {
            let model = writing.as_ref().map(|(author, _)| ModelWriter {
                author,
                runtime: &runtime,
            });
            let effort = Effort::default();
            let how = GenerationInputs {
                settings: &settings,
                planner,
                source: match &model {
                    Some(model) => AttackSource::Model(model),
                    None => AttackSource::Search(&effort),
                },
            };
            Opened::generated(&request, &ego, &thresholds, &how, cancel, progress)
        });
    }

    fn reply(model: &mut Model, (id, update): Self::Reply) -> Vec<Effect> {
        let job = model.jobs.running_mut(id);
        let stopping = job.is_some_and(|job| job.state == JobState::Stopping);
        if !notes::note(model, id, |job, now| super::note(job, &update, now)) {
            return Vec::new();
        }
        match update {
            Update::Progress(_) if stopping => {}
            _ if stopping => super::stopped(model),
            update => return super::on_update(model, update),
        }
        Vec::new()
    }
}

/// The author that a model is; nothing is asked yet.
///
/// # Errors
/// No such model is known: in words.
fn author(services: &Services, writer: &Writer, only: Option<i64>) -> Result<Author, String> {
    Ok(Author {
        name: writer.name.clone(),
        // As `generate` asks.
        judge: services.judge(&writer.model, None)?,
        store: services.store.clone(),
        library: writer.library.clone(),
        thresholds: Arc::clone(&services.thresholds),
        settings: writer.settings,
        frame: None,
        method: writer.method,
        at_once: usize::try_from(services.concurrency.get()).unwrap_or(1),
        attacker: only,
        obey: false,
        fresh: writer.fresh,
        batch: None,
    })
}

/// The end of the program waits until this is dropped: a cancelled request is written down by then.
fn until_dropped(services: &mut Services) -> oneshot::Sender<()> {
    let (guard, dropped) = oneshot::channel();
    let until = tokio::spawn(async { drop(dropped.await) });
    services.jobs.wait_for(until.abort_handle());
    guard
}

/// Writes a variant into a folder; the current one if none is named.
#[derive(Debug)]
pub struct SaveVariant(pub Arc<GeneratedVariant>, pub Option<PathBuf>);

impl Request for SaveVariant {
    /// The files, or why it was not written.
    type Reply = (Arc<GeneratedVariant>, Result<String, String>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Self(variant, folder) = self;
        services.background(replies, move || {
            let written = write(&variant, folder.as_deref());
            (variant, written)
        });
    }

    /// A variant was written, or not.
    fn reply(model: &mut Model, (made, result): Self::Reply) -> Vec<Effect> {
        match result {
            Ok(files) => {
                model.generation.saved(&made, &files);
                model.say(format!("saved as {files}"));
            }
            Err(error) => model.complain(format!("the variant is not written: {error}")),
        }
        Vec::new()
    }
}

/// Writes a variant with its papers; gives their names.
///
/// # Errors
/// They cannot be made or written: in words, with what to do.
pub fn write(made: &GeneratedVariant, folder: Option<&Path>) -> Result<String, String> {
    let folder = folder.unwrap_or(Path::new("."));
    let variant = made.variant();
    let id = variant.free_id(folder);
    let saved = variant
        .save(folder, &id, false)
        .map_err(|e| format!("{e}; `pictures` in config.toml names another folder"))?;
    Ok(names(&saved))
}

fn names(saved: &VariantFiles) -> String {
    let shown = |path: &Path| {
        let path = path.strip_prefix(".").unwrap_or(path);
        path.display().to_string()
    };
    let name = |path: &Path| {
        let name = path.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    };
    let beside = [&saved.ego, &saved.solution];
    let mut beside: Vec<String> = beside.into_iter().map(|path| name(path)).collect();
    beside.extend(saved.avoiding.iter().map(|(_, path)| name(path)));
    let scenario = shown(&saved.scenario);
    let document = name(&saved.document);
    format!("{scenario}, beside it {} and {document}", beside.join(", "))
}
