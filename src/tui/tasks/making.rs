//! Making a scenario dangerous in the background, until it is done or cancelled; writing a variant.

mod writing;

use std::path::Path;

use super::super::loaded::{Heard, How, Made, Opened};
use super::super::message::Msg;
use super::super::message::making::{MakeAsk, MakeId, MakeNews};
use super::Tasks;
use crate::generation::{Effort, Saved};
use crate::planner::Cancel;
use crate::simulation::Settings;
use crate::workflow::{AttackSource, ModelWriter};

/// The search that is under way.
#[derive(Debug, Default)]
pub struct Making {
    under_way: Option<(MakeId, Cancel)>,
}

impl Making {
    /// It shall end.
    pub fn stop(&mut self) {
        if let Some((_, cancel)) = self.under_way.take() {
            cancel.ask();
        }
    }
}

impl Tasks {
    pub(super) fn make(&mut self, ask: MakeAsk) {
        match ask {
            MakeAsk::Begin(id, wish) => {
                self.driving.making.stop();
                let settings = Settings {
                    forecast: wish.forecast,
                    ..self.driving.settings()
                };
                let writing = match wish.writer.as_deref() {
                    Some(writer) => match self.author(writer, wish.only) {
                        Ok(author) => Some((author, self.held())),
                        Err(why) => {
                            let _ = self.sender.send(Msg::Make(MakeNews::Ended(id, Err(why))));
                            return;
                        }
                    },
                    None => None,
                };
                let cancel = Cancel::default();
                self.driving.making.under_way = Some((id, cancel.clone()));
                let (ego, thresholds) = (self.ego.clone(), self.thresholds.clone());
                let sender = self.sender.clone();
                let runtime = tokio::runtime::Handle::current();
                tokio::task::spawn_blocking(move || {
                    // The receiver is gone once the loop has ended; that cancels.
                    let tell = |news| {
                        let _ = sender.send(Msg::Make(news));
                    };
                    let mut on_event = |heard| {
                        tell(match heard {
                            Heard::Working(at) => MakeNews::Working(id, at),
                            Heard::Model(progress) => MakeNews::Heard(id, progress),
                        });
                    };
                    let model = writing.as_ref().map(|(author, _)| ModelWriter {
                        author,
                        runtime: &runtime,
                    });
                    let effort = Effort::default();
                    let how = How {
                        settings: &settings,
                        source: match &model {
                            Some(model) => AttackSource::Model(model),
                            None => AttackSource::Search(&effort),
                        },
                    };
                    let made =
                        Opened::generated(&wish, &ego, &thresholds, &how, &cancel, &mut on_event);
                    tell(match made.transpose() {
                        Some(made) => MakeNews::Ended(id, made),
                        None => MakeNews::Stopped(id),
                    });
                });
            }
            MakeAsk::Stop(id) => {
                if self
                    .driving
                    .making
                    .under_way
                    .as_ref()
                    .is_some_and(|u| u.0 == id)
                {
                    self.driving.making.stop();
                }
            }
            MakeAsk::Save(made, folder) => self.background(move || {
                let written = write(&made, folder.as_deref());
                Msg::Make(MakeNews::Saved(made, written))
            }),
        }
    }
}

/// Writes a variant with its papers; gives their names.
///
/// # Errors
/// They cannot be made or written: in words, with what to do.
pub fn write(made: &Made, folder: Option<&Path>) -> Result<String, String> {
    let folder = folder.unwrap_or(Path::new("."));
    let variant = made.variant();
    let id = variant.free_id(folder);
    let saved = variant.save(folder, &id, false);
    let saved =
        saved.map_err(|e| format!("{e}; `pictures` in config.toml names another folder"))?;
    Ok(names(&saved))
}

fn names(saved: &Saved) -> String {
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
