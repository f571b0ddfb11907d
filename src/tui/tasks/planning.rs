//! Planning the ego of a scenario in the background, until it is done or cancelled.

use std::collections::HashMap;

use super::super::loaded::Opened;
use super::super::message::Msg;
use super::super::message::planning::{PlanAsk, PlanId, PlanNews};
use super::making::Making;
use super::{Tasks, drives};
use crate::evaluation::default_planning;
use crate::planner::Cancel;
use crate::settings::Config;
use crate::simulation::Settings;
use crate::workflow::{OpenRequest, PlanRequest};

/// Drives of the planner that are under way, and how the configuration wants them.
#[derive(Debug)]
pub struct Driving {
    under_way: HashMap<PlanId, Cancel>,
    settings: Settings,
    /// The search for a dangerous variant.
    pub(super) making: Making,
}

impl Driving {
    /// None yet.
    pub fn new(config: &Config) -> Self {
        Self {
            under_way: HashMap::new(),
            settings: config.planning(default_planning()),
            making: Making::default(),
        }
    }

    /// How drives are wanted.
    pub fn settings(&self) -> Settings {
        self.settings
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
                let settings = Settings {
                    forecast,
                    ..self.driving.settings()
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
