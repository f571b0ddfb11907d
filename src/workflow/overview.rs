//! A scenario in a row: the moment that matters, what is most dangerous, who is the ego. Rows are filtered and ordered as the
//! list of the workbench is.

use std::cmp::Ordering;

use nearmiss_formats::Entry;
use nearmiss_record::Record;
use nearmiss_scene::corpus::window_of_moment;
use nearmiss_scene::metrics::{
    Context, CriticalMoment, Headline, Measure, SEVERITY_NAMES, Series, Thresholds,
};
use nearmiss_scene::scenario::Severity;
use schemars::JsonSchema;
use serde::Serialize;

use super::OpenedScene;
use super::scenario_filter::{
    Agreement, Facts, Filter, Filterable, HEADLINE, Indexed, Matching, Number, Property, Verdicts,
    WordMatch,
};

/// A scenario in a row of a table.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ScenarioRow {
    /// The file's name without its ending.
    #[schemars(title = "scenario")]
    pub scenario: String,
    /// Path as it was found.
    pub file: String,
    /// First 12 digits of the SHA-256 of the scenario's content.
    pub hash: String,
    /// Severity of the moment that matters, 0 (contact) to 5 (none).
    pub severity: Option<u8>,
    /// Name of that number.
    #[schemars(title = "severity")]
    pub severity_name: Option<&'static str>,
    /// The moment that matters, seconds since time step 0.
    #[schemars(title = "at", extend("unit" = "s", "decimals" = 1))]
    pub moment: Option<f64>,
    /// The same as a time step.
    pub step: Option<i64>,
    /// What makes it matter.
    #[schemars(title = "what")]
    pub what: Option<String>,
    /// The other road user of the moment.
    pub obstacle: Option<i64>,
    /// Its type.
    pub obstacle_type: Option<&'static str>,
    /// The other road user of the moment, in words.
    #[schemars(title = "with")]
    pub with: Option<String>,
    /// What it does to the ego, such as cut_in, following or crossing.
    #[schemars(title = "manoeuvre")]
    pub manoeuvre: Option<&'static str>,
    /// Kind of road under the ego.
    pub road: Option<&'static str>,
    /// Lowest time to collision with anyone.
    #[schemars(title = "lowest ttc", extend("unit" = "s", "decimals" = 2))]
    pub ttc: Option<f64>,
    /// Lowest distance to anyone.
    #[schemars(title = "lowest distance", extend("unit" = "m", "decimals" = 2))]
    pub distance: Option<f64>,
    /// Closing speed at the first contact; missing without contact.
    #[schemars(title = "contact", extend("unit" = "m/s", "decimals" = 1, "rare" = true))]
    pub contact_speed: Option<f64>,
    /// Id of the ego.
    #[schemars(title = "ego")]
    pub ego: Option<i64>,
    /// Where its motion is from; why there is no ego.
    #[schemars(title = "from")]
    pub ego_source: String,
    /// From the first step of the ego to its last; of everybody where there is no ego.
    #[schemars(title = "duration", extend("unit" = "s", "decimals" = 1))]
    pub seconds: f64,
    /// Number of these steps.
    pub steps: i64,
    /// Number of obstacles.
    #[schemars(title = "obstacles")]
    pub obstacles: usize,
    /// Number of lanelets.
    pub lanelets: usize,
    /// Tags of the file.
    #[schemars(title = "tags", extend("rare" = true))]
    pub tags: Vec<String>,
    /// Number of warnings of the parser.
    #[schemars(title = "warnings", extend("rare" = true))]
    pub warnings: usize,
    /// Number of kinds of elements, attributes, fields or columns that stand in the file and are not used.
    #[schemars(title = "not used", extend("rare" = true))]
    pub not_used: usize,
}

impl Record for ScenarioRow {
    const NAME: &'static str = "inspect-folder";
    const TITLE: &'static str = "`inspect PATH… --format json`: one scenario a line";
}

/// A scenario as its row, as a filter sees it, and as it is ordered.
#[derive(Debug, Clone)]
pub struct Overview {
    /// The row.
    pub row: ScenarioRow,
    /// The moment that matters.
    pub moment: Option<CriticalMoment>,
    entry: Entry,
    facts: Facts,
    /// The most dangerous values of the measures of the filter, beside those of every row.
    compared: Vec<(&'static str, f64)>,
    window: Indexed,
}

/// Digits of a hash that tell files apart, as elsewhere.
const DIGITS: usize = 12;

impl Overview {
    /// That of a scenario that is open; terms about answers go by these verdicts, and the measures of the filter are worked out.
    #[must_use]
    pub fn new(
        entry: &Entry,
        opened: &OpenedScene,
        thresholds: &Thresholds,
        verdicts: &Verdicts,
        filter: Option<&Filter>,
    ) -> Self {
        let scenario = &opened.scenario;
        let scene = opened.scene.as_deref();
        let context = scene.map(|scene| Context::under(scene, thresholds)).ok();
        let headline = context.as_ref().map(Headline::from_context);
        let moment = headline.as_ref().and_then(Headline::worst).copied();
        let window = context
            .as_ref()
            .zip(moment)
            .and_then(|(context, moment)| window_of_moment(context, &moment));
        let compared =
            { context.as_ref() }.map_or_else(Vec::new, |context| measured(context, filter));
        let measured = scene.ok().zip(headline);
        let facts = Facts::new(entry, scenario, measured, thresholds, verdicts);
        let count = |severity: Severity| {
            let diagnostics = scenario.diagnostics.iter();
            diagnostics.filter(|d| d.severity == severity).count()
        };
        let other = moment.and_then(|moment| scenario.obstacle(moment.obstacle));
        let headline = facts.headline.as_ref();
        let severity = moment.map(|moment| moment.grade.number());
        let steps = scene.map_or_else(|_| scenario.steps(), |scene| scene.steps());
        let row = ScenarioRow {
            scenario: entry.name.clone(),
            file: entry.display(),
            hash: facts.hash.chars().take(DIGITS).collect(),
            severity,
            severity_name: severity.map(|number| SEVERITY_NAMES[usize::from(number)]),
            moment: moment.map(|moment| thousandth(moment.step as f64 * scenario.dt())),
            step: moment.map(|moment| moment.step),
            what: moment.map(|moment| moment.hazard.to_string()),
            obstacle: moment.map(|moment| moment.obstacle),
            obstacle_type: other.map(|other| other.kind.name()),
            with: other.map(|other| format!("{} {}", other.kind.name(), other.id)),
            manoeuvre: window.as_ref().map(|window| window.manoeuvre.name()),
            road: window.as_ref().map(|window| window.road.name()),
            ttc: headline
                .and_then(|h| h.ttc)
                .map(|ttc| thousandth(ttc.value)),
            distance: headline
                .and_then(|h| h.distance)
                .map(|distance| thousandth(distance.value)),
            contact_speed: headline
                .and_then(|h| h.contact.as_ref())
                .map(|contact| thousandth(contact.impact.closing_speed)),
            ego: scene.ok().map(|scene| scene.ego.id),
            ego_source: match scene {
                Ok(scene) => scene.ego.source.short(),
                Err(why) => why.to_string(),
            },
            seconds: thousandth(facts.seconds),
            steps: steps.end - steps.start,
            obstacles: facts.obstacles,
            lanelets: scenario.network.lanelets.len(),
            tags: facts.tags.clone(),
            warnings: count(Severity::Warning),
            not_used: count(Severity::Unused),
        };
        let windows = window.map(|window| Indexed::Windows([window].into()));
        Self {
            row,
            moment,
            entry: entry.clone(),
            compared,
            window: windows.unwrap_or(Indexed::Missing),
            facts,
        }
    }

    /// The more severe one first; those without a moment last.
    #[must_use]
    pub fn compare(&self, other: &Self) -> Ordering {
        match (&self.moment, &other.moment) {
            (Some(one), Some(other)) => one.compare_across(other),
            (one, other) => other.is_some().cmp(&one.is_some()),
        }
    }

    /// Whether a filter lets it through; words have to be parts of its name, folder or tags.
    #[must_use]
    pub fn fits(&self, filter: &Filter) -> bool {
        let mut matching = Matching::default();
        filter.score(self, WordMatch::Part, &mut matching).is_some()
    }

    /// Checks a filter for rows: terms about windows are about that around the moment that matters.
    ///
    /// # Errors
    /// A term is wrong, has no value, or is about tags of the user or an index.
    pub fn filter(text: &str) -> Result<Filter, String> {
        let filter = Filter::read_of_all(text);
        if let Some(why) = filter.wrong.first() {
            return Err(why.clone());
        }
        if filter.incomplete {
            return Err(format!("`{text}`: a term has no value"));
        }
        if let Some(term) = filter.personal().filter(|term| *term == "has:tags") {
            return Err(format!(
                "`{term}`: tags of yours are known in the workbench"
            ));
        }
        if filter.filters() {
            Ok(filter)
        } else {
            Err("expected terms such as ttc<1.5 or tag:cut_in".into())
        }
    }
}

/// The most dangerous values of the measures of a filter that are not known of every row.
fn measured(context: &Context<'_>, filter: Option<&Filter>) -> Vec<(&'static str, f64)> {
    let compared = filter.into_iter().flat_map(Filter::measures);
    let wanted: Vec<_> = compared.filter(|m| !HEADLINE.contains(&m.id)).collect();
    let series = Series::from_context(context, wanted);
    let worst = |m: &&Measure| Some((m.id, series.most_dangerous(m.id)?.1));
    series.measures().iter().filter_map(worst).collect()
}

/// Thousandths are enough for people and tables of them.
fn thousandth(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

impl Filterable for Overview {
    fn entry(&self) -> &Entry {
        &self.entry
    }

    fn tags(&self) -> impl Iterator<Item = &str> {
        self.facts.tags.iter().map(String::as_str)
    }

    fn country(&self) -> &str {
        &self.facts.country
    }

    fn has(&self, property: Property) -> Option<bool> {
        self.facts.has(property)
    }

    fn agreement(&self) -> Option<Agreement> {
        Some(self.facts.agreement())
    }

    /// As the row shows it: a value that is copied from there is itself within the bound.
    fn number(&self, number: Number) -> Option<f64> {
        let exact = match number {
            Number::Of(measure) if !HEADLINE.contains(&measure.id) => {
                let mut compared = self.compared.iter();
                compared
                    .find(|(id, _)| *id == measure.id)
                    .map(|(_, value)| *value)
            }
            _ => self.facts.number(number),
        };
        exact.map(thousandth)
    }

    fn indexed(&self) -> &Indexed {
        &self.window
    }
}
