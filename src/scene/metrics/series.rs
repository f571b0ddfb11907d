//! Measures over all steps and obstacles of a scene.

use std::ops::Range;

use super::{Contact, Context, Measure, NoValue, Reading};
use crate::scenario::Scene;

/// Readings of some measures for every obstacle at every step of the ego.
#[derive(Debug, Clone)]
pub struct Series {
    steps: Range<i64>,
    obstacles: Vec<i64>,
    /// The first of each obstacle.
    contacts: Vec<Option<Contact>>,
    measures: Vec<&'static Measure>,
    /// By measure, then obstacle, then step.
    readings: Vec<Reading>,
}

impl Series {
    /// Computes `measures` over a scene.
    ///
    /// ```
    /// use nearmiss_formats::bundled;
    /// use nearmiss_scene::metrics::{MEASURES, Series};
    /// use nearmiss_scene::scenario::Scene;
    ///
    /// # let entry = &bundled()[0];
    /// # let scenario = entry.read()?;
    /// # let ego = entry.recorded_ego(&scenario)?.expect("recorded beside it");
    /// # let scene = Scene::new(scenario, ego);
    /// let ttc = MEASURES.iter().find(|m| m.id == "ttc").unwrap();
    /// let series = Series::compute(&scene, vec![ttc]);
    /// let (step, lowest) = series.most_dangerous("ttc").unwrap();
    /// println!("lowest TTC: {lowest:.2} s at step {step}");
    /// # assert!(scene.steps().contains(&step) && lowest >= 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn compute(scene: &Scene, measures: Vec<&'static Measure>) -> Self {
        Self::from_context(&Context::new(scene), measures)
    }

    /// Computes `measures` over a prepared scene.
    #[must_use]
    pub fn from_context(context: &Context<'_>, measures: Vec<&'static Measure>) -> Self {
        let everyone = 0..context.participants().len();
        Self::among(context, measures, &everyone.collect::<Vec<_>>())
    }

    /// Computes `measures` of one obstacle over a prepared scene; of none where the scene has no such obstacle.
    #[must_use]
    pub fn of_obstacle(
        context: &Context<'_>,
        measures: Vec<&'static Measure>,
        obstacle: i64,
    ) -> Self {
        let mut all = context.participants().iter();
        let place = all.position(|p| p.obstacle.id == obstacle);
        Self::among(context, measures, place.as_slice())
    }

    /// `places` are among the participants of the context.
    fn among(context: &Context<'_>, measures: Vec<&'static Measure>, places: &[usize]) -> Self {
        let steps = context.steps();
        let length = (steps.end - steps.start).max(0) as usize;
        let block = places.len() * length;
        let mut readings = vec![Reading::None(NoValue::Absent); measures.len() * block];
        for (row, &participant) in places.iter().enumerate() {
            for (index, step) in steps.clone().enumerate() {
                let Some(encounter) = context.encounter(participant, step) else {
                    continue;
                };
                let place = row * length + index;
                for (m, measure) in measures.iter().enumerate() {
                    readings[m * block + place] = measure.evaluate(&encounter);
                }
            }
        }
        Self {
            steps,
            obstacles: places
                .iter()
                .map(|&p| context.participants()[p].obstacle.id)
                .collect(),
            contacts: { places.iter() }
                .map(|&p| context.contacts(p).first().copied())
                .collect(),
            measures,
            readings,
        }
    }

    /// The steps, those of the ego.
    #[must_use]
    pub fn steps(&self) -> Range<i64> {
        self.steps.clone()
    }

    /// Ids of the obstacles, in the file's order.
    #[must_use]
    pub fn obstacles(&self) -> &[i64] {
        &self.obstacles
    }

    /// The first contact with an obstacle, at a step or between two.
    #[must_use]
    pub fn contact(&self, obstacle: i64) -> Option<Contact> {
        let place = self.obstacles.iter().position(|&id| id == obstacle)?;
        self.contacts[place]
    }

    /// The measures.
    #[must_use]
    pub fn measures(&self) -> &[&'static Measure] {
        &self.measures
    }

    /// One measure of one obstacle over all steps; empty for what was not computed.
    #[must_use]
    pub fn row(&self, measure: &str, obstacle: i64) -> &[Reading] {
        let place = self
            .measures
            .iter()
            .position(|m| m.id == measure)
            .zip(self.obstacles.iter().position(|&o| o == obstacle));
        let Some((m, o)) = place else { return &[] };
        let length = self.length();
        let start = (m * self.obstacles.len() + o) * length;
        &self.readings[start..start + length]
    }

    /// One measure of one obstacle at one step.
    #[must_use]
    pub fn at(&self, measure: &str, obstacle: i64, step: i64) -> Reading {
        let place = usize::try_from(step - self.steps.start).ok();
        place
            .and_then(|i| self.row(measure, obstacle).get(i).copied())
            .unwrap_or(Reading::None(NoValue::Absent))
    }

    /// The most dangerous value of a measure at one step, and whose it is; of a measure that only describes, the
    /// lowest.
    #[must_use]
    pub fn most_dangerous_at(&self, measure: &str, step: i64) -> Option<(i64, f64)> {
        let danger = self.measures.iter().find(|m| m.id == measure)?.danger;
        let values = self.values_at(measure, step);
        values.min_by(|a, b| danger.compare(a.1, b.1))
    }

    /// The values of a measure at one step, each with its obstacle, in the file's order.
    fn values_at(&self, measure: &str, step: i64) -> impl Iterator<Item = (i64, f64)> {
        let length = self.length();
        let place = usize::try_from(step - self.steps.start)
            .ok()
            .filter(|&place| place < length);
        let measure = self.measures.iter().position(|m| m.id == measure);
        let start = measure.map(|m| m * self.obstacles.len() * length);
        // Each obstacle's reading at the step: the rows are contiguous.
        let first = start.zip(place).map(|(start, place)| start + place);
        // Without obstacles there are no rows, whatever the step.
        let readings = first
            .and_then(|first| self.readings.get(first..))
            .unwrap_or_default();
        let column = readings.iter().step_by(length.max(1));
        let values = self.obstacles.iter().zip(column);
        values.filter_map(|(&id, reading)| Some((id, reading.value()?)))
    }

    /// The most dangerous value of a measure over all steps, and the first step at which it occurs.
    #[must_use]
    pub fn most_dangerous(&self, measure: &str) -> Option<(i64, f64)> {
        let danger = self.measures.iter().find(|m| m.id == measure)?.danger;
        let values = self
            .steps()
            .filter_map(|step| Some((step, self.most_dangerous_at(measure, step)?.1)));
        values.min_by(|a, b| danger.compare(a.1, b.1))
    }

    fn length(&self) -> usize {
        (self.steps.end - self.steps.start).max(0) as usize
    }
}
