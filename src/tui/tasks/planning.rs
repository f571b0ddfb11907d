//! Planning the ego of a scenario in the background, until it is done or nobody wants it any more.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::super::loaded::Opened;
use super::super::message::Msg;
use super::super::message::planning::{PlanAsk, PlanId, PlanNews};
use super::Tasks;
use crate::config::Config;
use crate::evaluation::{set_planning, usual_planning};
use crate::simulation::Settings;

/// Drives of the planner that are under way, and how the configuration wants them.
#[derive(Debug)]
pub struct Driving {
    under_way: HashMap<PlanId, Arc<AtomicBool>>,
    settings: Settings,
}

/// How the section `[planner]` of the configuration wants drives to be. Its values were checked when it was read.
#[must_use]
pub fn settings(config: &Config) -> Settings {
    let mut settings = usual_planning();
    for (key, value) in config.planner_values() {
        // What this version does not know is left as usual.
        let _ = set_planning(&mut settings, key.id, value);
    }
    settings
}

impl Driving {
    /// None yet.
    pub fn new(config: &Config) -> Self {
        Self {
            under_way: HashMap::new(),
            settings: settings(config),
        }
    }

    /// All shall end.
    pub fn stop(&mut self) {
        for (_, stop) in self.under_way.drain() {
            stop.store(true, Ordering::Relaxed);
        }
    }
}

impl Tasks {
    pub(super) fn plan(&mut self, ask: PlanAsk) {
        match ask {
            PlanAsk::Begin(id, entry, change, forecast) => {
                // Whoever is at work holds one too.
                let settings = Settings {
                    forecast,
                    ..self.driving.settings
                };
                self.driving
                    .under_way
                    .retain(|_, stop| Arc::strong_count(stop) > 1);
                let stop = Arc::new(AtomicBool::new(false));
                self.driving.under_way.insert(id, stop.clone());
                let (ego, thresholds) = (self.ego.clone(), self.thresholds.clone());
                let sender = self.sender.clone();
                tokio::task::spawn_blocking(move || {
                    let news = sender.clone();
                    let mut watch = |done, of| {
                        // Nobody listens when the loop has ended.
                        let heard = news.send(Msg::Plan(PlanNews::Planned(id, done, of)));
                        heard.is_ok() && !stop.load(Ordering::Relaxed)
                    };
                    let how = (change, &settings);
                    let planned = Opened::planned(&entry, &ego, &thresholds, how, &mut watch);
                    if let Some(planned) = planned.transpose() {
                        let ended = PlanNews::Ended(id, planned.map(Box::new));
                        let _ = sender.send(Msg::Plan(ended));
                    }
                });
            }
            PlanAsk::Stop(id) => {
                if let Some(stop) = self.driving.under_way.remove(&id) {
                    stop.store(true, Ordering::Relaxed);
                }
            }
        }
    }
}
