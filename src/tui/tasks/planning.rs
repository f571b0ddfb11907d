//! Planning the ego of a scenario in the background, until it is done or nobody wants it any more.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::super::loaded::Opened;
use super::super::message::Msg;
use super::super::message::planning::{PlanAsk, PlanId, PlanNews};
use super::Tasks;
use crate::planner;
use crate::simulation::Settings;

/// Drives of the planner that are under way.
#[derive(Debug, Default)]
pub struct Driving(HashMap<PlanId, Arc<AtomicBool>>);

impl Driving {
    /// All shall end.
    pub fn stop(&mut self) {
        for (_, stop) in self.0.drain() {
            stop.store(true, Ordering::Relaxed);
        }
    }
}

impl Tasks {
    pub(super) fn plan(&mut self, ask: PlanAsk) {
        match ask {
            PlanAsk::Begin(id, entry, change, forecast) => {
                // Whoever is at work holds one too.
                self.driving.0.retain(|_, stop| Arc::strong_count(stop) > 1);
                let stop = Arc::new(AtomicBool::new(false));
                self.driving.0.insert(id, stop.clone());
                let (ego, thresholds) = (self.ego.clone(), self.thresholds.clone());
                let sender = self.sender.clone();
                tokio::task::spawn_blocking(move || {
                    let news = sender.clone();
                    let mut watch = |done, of| {
                        // Nobody listens when the loop has ended.
                        let heard = news.send(Msg::Plan(PlanNews::Planned(id, done, of)));
                        heard.is_ok() && !stop.load(Ordering::Relaxed)
                    };
                    let settings = Settings {
                        planner: planner::Settings::default(),
                        forecast,
                        replan: 1,
                        without: None,
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
                if let Some(stop) = self.driving.0.remove(&id) {
                    stop.store(true, Ordering::Relaxed);
                }
            }
        }
    }
}
