//! Computations on the open scene.

use std::sync::Arc;

use crate::loaded::{Measured, plotted};
use crate::model::{
    Document, Future, MeasureId, Model, PathRequest, SeriesId, WindowJudgement, WindowsToJudge,
};
use crate::pixels::{ImageRequest, MapImage};
use crate::request::Computation;
use crate::update::{answers, map};
use nearmiss_scene::judge::judge_under;
use nearmiss_scene::metrics::{Measure, Series, Thresholds};
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_study::evaluation::claims::{CheckedClaim, Subject, checked};

/// Every measure of an obstacle, if one is picked, and of the scene.
#[derive(Debug)]
pub struct MeasureAll {
    /// Its number.
    pub id: MeasureId,
    /// The scene.
    pub scene: Arc<Scene>,
    /// The obstacle.
    pub obstacle: Option<i64>,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
}

impl Computation for MeasureAll {
    type Value = (MeasureId, Box<Measured>);

    fn compute(self) -> Self::Value {
        let measured = Measured::new(&self.scene, self.obstacle, &self.thresholds);
        (self.id, Box::new(measured))
    }

    fn take(model: &mut Model, (id, measured): Self::Value) {
        if model.values.asked.is_some_and(|(asked, _)| asked == id) {
            model.values.found = Some(measured);
        }
    }
}

/// A measure over a scene, for the plot.
#[derive(Debug)]
pub struct PlotMeasure {
    /// Its number.
    pub id: SeriesId,
    /// The scene.
    pub scene: Arc<Scene>,
    /// The measure.
    pub measure: &'static Measure,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
}

impl Computation for PlotMeasure {
    type Value = (SeriesId, Box<Series>);

    fn compute(self) -> Self::Value {
        let series = plotted(&self.scene, self.measure, &self.thresholds);
        (self.id, Box::new(series))
    }

    fn take(model: &mut Model, (id, series): Self::Value) {
        model.plot.take(id, series);
    }
}

impl Computation for WindowsToJudge {
    /// The windows, and the judge's answers about them.
    type Value = (Self, Vec<WindowJudgement>);

    fn compute(self) -> Self::Value {
        let judge = |&(first, last): &(i64, i64)| {
            let steps = last.saturating_sub(first).saturating_add(1);
            let steps = usize::try_from(steps).unwrap_or(1);
            let window = Window::ending_at(&self.scene, last, steps);
            let judgement = judge_under(&self.scene, self.task, &window, &self.thresholds);
            ((first, last), judgement)
        };
        let judgements = self.windows.iter().map(judge).collect();
        (self, judgements)
    }

    fn take(model: &mut Model, (asked, judgements): Self::Value) {
        answers::judged(model, &asked, &judgements);
    }
}

impl Computation for PathRequest {
    type Value = (Self, Vec<Future>);

    fn compute(self) -> Self::Value {
        let futures = self.predict();
        (self, futures)
    }

    fn take(model: &mut Model, (request, futures): Self::Value) {
        map::take_paths(model, &request, futures);
    }
}

/// The map as an image.
#[derive(Debug)]
pub struct DrawMap(pub Box<ImageRequest>);

impl Computation for DrawMap {
    /// The image, or why there is none.
    type Value = Result<MapImage, String>;

    fn compute(self) -> Self::Value {
        self.0.run()
    }

    fn take(model: &mut Model, image: Self::Value) {
        if let Err(why) = model.map.images.take(image) {
            model.complain(format!("the map is drawn in cells: {why}"));
        }
    }
}

/// Claims of an answer, checked against the scene.
#[derive(Debug)]
pub struct CheckClaims(pub Arc<Document>, pub Arc<Scene>);

impl Computation for CheckClaims {
    /// The key of the document, and its claims.
    type Value = (u64, Vec<CheckedClaim>);

    fn compute(self) -> Self::Value {
        let Self(document, scene) = self;
        let subject = Subject {
            scene: &scene,
            times: document.times,
            window: document.window,
        };
        (document.key, checked(&document.text, &subject))
    }

    fn take(model: &mut Model, (key, claims): Self::Value) {
        model.claims.take(key, claims);
    }
}
