//! An opened scenario with a driver at the wheel: what stands beside the ego's own drive.

use std::sync::Arc;

use nearmiss_drive::driver::{DRIVERS, Field};
use nearmiss_render::scene::Basemap;
use nearmiss_scene::metrics::{DrivenPath, Thresholds};
use nearmiss_scene::scenario::{Ego, Motion, Sample, Scene, Track};

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
    /// The step of the encounter.
    pub step: i64,
    /// The scene.
    pub scene: Arc<Scene>,
    /// Its map.
    pub basemap: Arc<Basemap>,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
}

impl DriverSeat {
    /// Drives: as the ego until the driver takes the wheel, then its ride along the ego's path until it ends. `None` where
    /// nobody can drive, and of an ideal driver that leaves the path, which its ride does not say.
    #[must_use]
    pub fn drive(&self) -> Option<DriverDrive> {
        let scene = &self.scene;
        let track = &scene.ego.track;
        let field = Field::around(scene, self.step)?;
        let from = field.steps().start;
        let ride = field.ride_of(&DRIVERS[self.driver], from)?;
        let own = |step| Some((step, *track.at(step)?));
        let path = DrivenPath::from_motions(field.steps().filter_map(own));
        let sign = track.at(from)?.velocity.signum();
        let before = (scene.steps().start..=from).filter_map(own);
        let after = ride.states.iter().filter(|(step, ..)| *step > from);
        let after = after.filter_map(|&(step, s, speed, acceleration)| {
            let motion = Motion {
                pose: path.at(s)?,
                velocity: sign * speed,
                acceleration: sign * acceleration,
            };
            Some((step, motion))
        });
        let samples = before.chain(after).map(|(step, motion)| Sample {
            step,
            position: motion.pose.position,
            heading: Some(motion.pose.heading),
            velocity: Some(motion.velocity),
            acceleration: Some(motion.acceleration),
        });
        let scenario = Arc::clone(&scene.scenario);
        let ego = Ego {
            track: Track::new(samples.collect(), scenario.dt(), None),
            ..scene.ego.clone()
        };
        let scene = Arc::new(Scene::new(Arc::clone(&scenario), ego));
        let (series, headline) = measured(&scene, &self.thresholds);
        let contact = ride.touch.map(|touch| touch.closing_speed);
        let leaves_path = contact.is_none() && headline.collides();
        (!leaves_path).then(|| DriverDrive {
            contact,
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
