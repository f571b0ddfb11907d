//! Planning the ego of a scenario in the background, until it is done or cancelled.

use std::collections::HashMap;

use super::super::loaded::Opened;
use super::super::message::Msg;
use super::super::message::planning::{PlanAsk, PlanId, PlanNews};
use super::making::Making;
use super::{Tasks, drives};
use crate::config::Config;
use crate::evaluation::{default_planning, set_planning};
use crate::planner::Cancel;
use crate::simulation::Settings;
use crate::workflow::{OpenRequest, PlanRequest};

/// Drives of the planner that are under way, and how the configuration wants them.
#[derive(Debug)]
pub struct Driving {
    under_way: HashMap<PlanId, Cancel>,
    /// Or why nothing can be planned as it wants.
    settings: Result<Settings, String>,
    /// The search for a dangerous variant.
    pub(super) making: Making,
}

/// How the section `[planner]` of the configuration wants drives to be.
///
/// # Errors
/// It has a key or a value that the planner does not know: in words. Who reads the configuration checks both.
pub fn settings(config: &Config) -> Result<Settings, String> {
    let mut settings = default_planning();
    for (key, value) in config.planner_values() {
        set_planning(&mut settings, key.id, value).map_err(|e| format!("config.toml: {e}"))?;
    }
    Ok(settings)
}

impl Driving {
    /// None yet.
    pub fn new(config: &Config) -> Self {
        Self {
            under_way: HashMap::new(),
            settings: settings(config),
            making: Making::default(),
        }
    }

    /// How drives are wanted.
    ///
    /// # Errors
    /// The configuration wants something that there is not: in words.
    pub fn settings(&self) -> Result<Settings, String> {
        self.settings.clone()
    }

    /// All shall end.
    pub fn stop(&mut self) {
        self.making.stop();
        for (_, cancel) in self.under_way.drain() {
            cancel.ask();
        }
    }
}

impl Tasks {
    pub(super) fn plan(&mut self, ask: PlanAsk) {
        match ask {
            PlanAsk::Begin(id, entry, change, forecast) => {
                let settings = match &self.driving.settings {
                    Ok(settings) => Settings {
                        forecast,
                        ..*settings
                    },
                    Err(why) => {
                        let ended = PlanNews::Ended(id, Err(why.clone()));
                        // The receiver is gone once the loop has ended.
                        let _ = self.sender.send(Msg::Plan(ended));
                        return;
                    }
                };
                // What has ended is marked so, too.
                self.driving
                    .under_way
                    .retain(|_, cancel| !cancel.is_asked());
                let cancel = Cancel::default();
                self.driving.under_way.insert(id, cancel.clone());
                let (ego, thresholds) = (self.ego.clone(), self.thresholds.clone());
                let sender = self.sender.clone();
                tokio::task::spawn_blocking(move || {
                    let request = PlanRequest {
                        open: OpenRequest {
                            entry: &entry,
                            ego: &ego,
                            transform: change,
                            strict: false,
                        },
                        problem: None,
                        settings: &settings,
                    };
                    let mut on_step = |done, of| {
                        // The receiver is gone once the loop has ended; that cancels.
                        let _ = sender.send(Msg::Plan(PlanNews::Planned(id, done, of)));
                    };
                    let planned = Opened::planned(&request, &thresholds, &cancel, &mut on_step);
                    cancel.ask();
                    if let Some(planned) = planned.transpose() {
                        let ended = PlanNews::Ended(id, planned.map(Box::new));
                        let _ = sender.send(Msg::Plan(ended));
                    }
                });
            }
            PlanAsk::Save(files) => self.background(move || {
                let written = drives::write(&files);
                Msg::Plan(PlanNews::Saved(files.key, written))
            }),
            PlanAsk::Stop(id) => {
                if let Some(cancel) = self.driving.under_way.remove(&id) {
                    cancel.ask();
                }
            }
        }
    }
}
