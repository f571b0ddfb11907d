//! Making a scenario dangerous in the background; writing a variant.

mod writing;

use std::path::Path;

use super::super::loaded::{GeneratedVariant, GenerationInputs, Opened, VariantRequest};
use super::super::message::{JobEvent, JobId, Msg, Update};
use super::Tasks;
use nearmiss_drive::generation::{Effort, VariantFiles};
use nearmiss_drive::simulation::Settings;
use nearmiss_workflow::{AttackSource, ModelWriter};

impl Tasks {
    /// Makes a scenario dangerous: a model writes the attack, or it is searched for.
    pub(super) fn generate(&mut self, id: JobId, request: Box<VariantRequest>) {
        let settings = Settings {
            forecast: request.forecast,
            ..self.planning
        };
        let chosen = request.planner.checked_sub(1);
        let planner = chosen.and_then(|chosen| self.planners.get(chosen)).cloned();
        let writing = match request.writer.as_deref() {
            Some(writer) => match self.author(writer, request.only) {
                Ok(author) => Some((author, self.held())),
                Err(why) => {
                    let failed = JobEvent::Generate(Update::Ended(Err(why)));
                    let _ = self.sender.send(Msg::Job(id, failed));
                    return;
                }
            },
            None => None,
        };
        let (ego, thresholds) = (self.ego.clone(), self.thresholds.clone());
        let runtime = tokio::runtime::Handle::current();
        self.run(id, JobEvent::Generate, move |cancel, tell| {
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
            Opened::generated(&request, &ego, &thresholds, &how, cancel, tell)
        });
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
