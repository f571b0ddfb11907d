//! An opened scenario with a driver at the wheel: what stands beside the ego's own drive.

use std::sync::Arc;

use nearmiss_drive::driver::{DRIVERS, Field};
use nearmiss_render::scene::Basemap;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::Scene;

use super::{Opened, measured};

/// The drive of a driver.
#[derive(Debug)]
pub struct DriverDrive {
    /// Closing speed at its contact, m/s; `None` without one.
    pub contact: Option<f64>,
    /// The scenario with that drive as its ego.
    pub opened: Opened,
}

/// Which drive that is to be.
#[derive(Debug)]
pub struct DriverSeat {
    /// The driver, by its place in [`DRIVERS`].
    pub driver: usize,
    /// The obstacle of the encounter.
    pub obstacle: i64,
    /// Its step.
    pub step: i64,
    /// The scene.
    pub scene: Arc<Scene>,
    /// Its map.
    pub basemap: Arc<Basemap>,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
}

impl DriverSeat {
    /// Drives: as the ego until the driver takes the wheel, then its ride until it ends. `None` where there is no time before.
    #[must_use]
    pub fn drive(&self) -> Option<DriverDrive> {
        let scene = &self.scene;
        let field = Field::around(scene, self.obstacle, self.step)?;
        let from = field.steps().start;
        let ride = field.ride_of(&DRIVERS[self.driver], from)?;
        let scenario = Arc::clone(&scene.scenario);
        let ego = field.ego_of(&ride);
        let scene = Arc::new(Scene::new(Arc::clone(&scenario), ego));
        let (series, headline) = measured(&scene, &self.thresholds);
        Some(DriverDrive {
            contact: ride.touch.map(|touch| touch.closing_speed),
            opened: Opened {
                name: scenario.header.benchmark_id.clone(),
                file: String::new(),
                change: None,
                basemap: Arc::clone(&self.basemap),
                scenario,
                scene: Some(scene),
                no_ego: None,
                chosen: false,
                series: Some(series),
                headline: Some(headline),
                collision: None,
                recording: None,
                ranking: Vec::new(),
                planned: None,
                variant: None,
                saved: None,
                certificate: None,
            },
        })
    }
}
