//! The safety-metrics description: distances, times and risk of nearby obstacles; their columns and sentences.
//!
//! Nothing after the window is used, neither directly nor through the route along which lanes are followed.

use std::borrow::Cow;

use super::ego_centric::{self, OWN, own, relative};
use super::ego_lane::Lanes;
use super::nearby::VisibleObstacle;
use super::options::{Form, Moment, Options, everyone};
use super::parts::{
    self, Cell, Column, NO_EGO, column, ego_moves, everyone_there, heading, name, name_and_place,
    no_obstacles, subject,
};
use super::writer::{Subject, Writer};
use crate::metrics::{Context, Danger, Encounter, Measure, MeasureList, measure};
use crate::scenario::{Participant, Scene, Window};

/// The relation of each obstacle to the ego.
const RELATION: &[Column] = &[
    column("direction", "direction"),
    column("gap long [m]", "gap_long"),
    column("gap lat [m]", "gap_lat"),
    column("v rel long [m/s]", "v_rel_long"),
    column("v rel lat [m/s]", "v_rel_lat"),
];

/// The subject: a scene that ends with the window, and the obstacles near in it.
struct Measured<'c, 's> {
    scene: &'s Scene,
    /// Knows nothing but the window.
    context: &'c Context<'s>,
    window: &'c Window,
    options: &'c Options,
    columns: MeasureColumns,
}

pub(super) fn describe(w: &mut Writer, context: &Context<'_>, window: &Window, options: &Options) {
    let scene = context.scene();
    w.relative_to(window.last());
    let described = options.described(scene, window);
    let everyone = everyone(scene, window, options, &described);
    let measured = Measured {
        scene,
        context: &context.during(window),
        window,
        options,
        columns: MeasureColumns::new(options.measures.as_ref()),
    };
    everyone_there(w, scene, window, &everyone);
    match options.form {
        Form::Prose => measured.prose(w, described, &everyone),
        Form::Compact => measured.compact(w, described, &everyone),
    }
}

impl Measured<'_, '_> {
    fn encounter(&self, participant: &Participant<'_>, step: i64) -> Option<Encounter<'_>> {
        let id = participant.obstacle.id;
        let mut all = self.context.participants().iter();
        let place = all.position(|p| p.obstacle.id == id)?;
        self.context.encounter(place, step)
    }

    fn prose(&self, w: &mut Writer, described: Vec<Moment<'_>>, everyone: &[Participant<'_>]) {
        let lanes = Lanes::new(self.scene);
        for moment in described {
            let step = moment.step;
            heading(w, self.scene, step);
            let Some(ego) = self.scene.ego.track.at(step) else {
                w.text(NO_EGO);
                continue;
            };
            ego_moves(w, &lanes, ego, step);
            if moment.near.is_empty() && !moment.left_out {
                no_obstacles(w, self.options.radius);
            }
            for (participant, motion) in moment.near {
                let Some(encounter) = self.encounter(&participant, step) else {
                    continue;
                };
                let seen = VisibleObstacle::new(&encounter, self.options);
                name_and_place(w, &participant, step, &seen, lanes.relation(ego, motion));
                relative(w, &seen.relation);
                measures(w, &self.columns.said, &encounter);
                let words = ego_centric::describe_motion(w, &seen, self.options.contact);
                w.text(". ").text(&words).text("\n");
            }
        }
        if everyone.is_empty() || self.columns.worst.is_empty() {
            return;
        }
        self.worst_heading(w);
        for participant in everyone {
            w.about(subject(participant), None).text("  ");
            name(w, participant);
            for (place, worst) in self.columns.worst.iter().enumerate() {
                let Worst {
                    id, before, after, ..
                } = worst;
                w.text(if place == 0 { ": " } else { "; " }).text(before);
                let Some((value, step)) = self.worst(w, participant, id) else {
                    w.text("none");
                    continue;
                };
                w.about(subject(participant), Some(step));
                write_measure(w, id, value)
                    .text(after)
                    .text(" at t = ")
                    .time(step, self.scene.scenario.dt())
                    .text(" s");
            }
            w.text(".\n");
        }
    }

    fn worst_heading(&self, w: &mut Writer) {
        let dt = self.scene.scenario.dt();
        w.about(Subject::Scene, Some(self.window.first()))
            .text("\nWorst values from t = ")
            .time(self.window.first(), dt)
            .text(" s to t = ")
            .about(Subject::Scene, Some(self.window.last()))
            .time(self.window.last(), dt)
            .text(" s:\n");
    }

    fn compact(&self, w: &mut Writer, described: Vec<Moment<'_>>, everyone: &[Participant<'_>]) {
        let lanes = Lanes::new(self.scene);
        let measures = self.columns.columns();
        parts::titles(w, &[OWN, RELATION, &measures]);
        for Moment { step, near, .. } in described {
            parts::begin(w, self.scene, step, None);
            let ego = self.scene.ego.track.at(step);
            let cells = ego.map(|ego| own(&lanes, ego));
            parts::cells(w, OWN, cells.as_ref().map_or(&[], |c| c));
            parts::cells(w, RELATION, &[]);
            parts::cells(w, &measures, &[]);
            w.text("\n");
            for (participant, motion) in near {
                let Some((ego, encounter)) = ego.zip(self.encounter(&participant, step)) else {
                    continue;
                };
                let seen = VisibleObstacle::new(&encounter, self.options);
                let relation = &seen.relation;
                parts::begin(w, self.scene, step, Some(&participant));
                parts::cells(w, OWN, &[Cell::text(lanes.relation(ego, motion))]);
                let cells = [
                    Cell::Words(seen.direction.name()),
                    Cell::Real(relation.gap_long),
                    Cell::Real(relation.gap_lat),
                    Cell::Real(relation.velocity.x),
                    Cell::Real(relation.velocity.y),
                ];
                parts::cells(w, RELATION, &cells);
                let cells: Vec<Cell> = measures
                    .iter()
                    .map(|c| cell(c.quantity, read(w, c.quantity, &encounter)))
                    .collect();
                parts::cells(w, &measures, &cells);
                w.text("\n");
            }
        }
        if everyone.is_empty() || self.columns.worst.is_empty() {
            return;
        }
        self.worst_heading(w);
        let titles = self.columns.worst_columns();
        parts::titles_after(w, "who", &[&titles]);
        for participant in everyone {
            w.about(subject(participant), None);
            name(w, participant);
            for (place, Worst { id, .. }) in self.columns.worst.iter().enumerate() {
                let worst = self.worst(w, participant, id);
                w.about(subject(participant), worst.map(|(_, step)| step));
                let dt = self.scene.scenario.dt();
                let cells = match worst {
                    Some((value, step)) => vec![cell(id, Some(value)), Cell::Time(step, dt)],
                    None => Vec::new(),
                };
                parts::cells(w, &titles[2 * place..2 * place + 2], &cells);
            }
            w.text("\n");
        }
    }

    /// The most dangerous value of a measure in the window, and its first step.
    fn worst(&self, w: &Writer, participant: &Participant<'_>, id: &str) -> Option<(f64, i64)> {
        let danger = measure(id)?.danger;
        let values = self.window.steps().filter_map(|step| {
            let encounter = self.encounter(participant, step)?;
            Some((read(w, id, &encounter)?, step))
        });
        values.min_by(|a, b| danger.compare(a.0, b.0))
    }
}

/// The measures of an obstacle at a step.
fn measures(w: &mut Writer, said_of: &[MeasureAtEachStep], encounter: &Encounter<'_>) {
    for (place, one) in said_of.iter().enumerate() {
        // The two times to close gaps belong together.
        let between = if one.continues { ", " } else { "; " };
        w.text(if place == 0 { "; " } else { between })
            .text(&one.before);
        match read(w, one.id, encounter) {
            Some(value) => write_measure(w, one.id, value).text(&one.after),
            None => w.text("none"),
        };
    }
}

/// The lowest risk score that is written: whether bodies touch is for the reader to find.
const LOWEST_RISK: f64 = 1.0;

/// The value of a measure; no time where the speed that it is computed with is written as 0.
fn read(w: &Writer, id: &str, encounter: &Encounter<'_>) -> Option<f64> {
    let value = measure(id)?.evaluate(encounter).value()?;
    let relation = encounter.relation();
    let v_long = w.written("v_rel_long", relation.velocity.x);
    let v_lat = w.written("v_rel_lat", relation.velocity.y);
    match id {
        "risk" => Some(value.max(LOWEST_RISK)),
        "ttc_long" => (v_long != 0.0).then_some(value),
        "ttc_lat" => (v_lat != 0.0).then_some(value),
        "ttc" => (value == 0.0 || v_long != 0.0 || v_lat != 0.0).then_some(value),
        "time_gap" => (w.written("velocity", encounter.ego.velocity) != 0.0).then_some(value),
        _ => Some(value),
    }
}

/// Scores are whole; everything else has decimals.
fn cell(id: &str, value: Option<f64>) -> Cell {
    match value {
        Some(value) if id == "risk" => Cell::Whole(value as i64),
        value => Cell::number(value),
    }
}

fn write_measure<'w>(w: &'w mut Writer, id: &'static str, value: f64) -> &'w mut Writer {
    match id {
        "risk" => w.integer(id, value as i64),
        _ => w.number(id, value),
    }
}

/// A measure that is told at every step.
pub(super) struct MeasureAtEachStep {
    pub id: &'static str,
    /// Its title where it has one of its own.
    title: Cow<'static, str>,
    /// Words of the prose before the number.
    pub before: Cow<'static, str>,
    /// Words after it: its unit.
    pub after: Cow<'static, str>,
    /// Whether it belongs to the one before it.
    pub continues: bool,
}

/// A measure of which the worst value over the window is told.
pub(super) struct Worst {
    pub id: &'static str,
    title: Cow<'static, str>,
    /// Words of the prose before the number.
    pub before: Cow<'static, str>,
    /// Words after it: its unit.
    pub after: Cow<'static, str>,
}

/// The measures of a description.
pub(super) struct MeasureColumns {
    pub said: Vec<MeasureAtEachStep>,
    pub worst: Vec<Worst>,
}

/// The usual measures: id, title, words of the prose before and after.
const DEFAULT_MEASURE_TEXTS: [[&str; 4]; 7] = [
    ["distance", "distance [m]", "distance ", " m"],
    [
        "ttc_long",
        "ttc long [s]",
        "time to close the gap longitudinal ",
        " s",
    ],
    ["ttc_lat", "ttc lat [s]", "lateral ", " s"],
    ["ttc", "ttc [s]", "time to collision ", " s"],
    ["time_gap", "time gap [s]", "time gap ", " s"],
    ["drac", "drac [m/s²]", "deceleration needed ", " m/s²"],
    ["risk", "risk", "risk score ", ""],
];

/// The usual measures whose worst values over the window are told.
const WORST: [[&str; 4]; 4] = [
    ["distance", "min distance [m]", "smallest distance ", " m"],
    ["ttc", "min ttc [s]", "smallest time to collision ", " s"],
    [
        "drac",
        "max drac [m/s²]",
        "largest deceleration needed ",
        " m/s²",
    ],
    ["risk", "min risk", "lowest risk score ", ""],
];

impl MeasureColumns {
    /// Those of the chosen measures; the usual ones for `None`.
    pub fn new(chosen: Option<&MeasureList>) -> Self {
        let Some(chosen) = chosen else {
            let said = DEFAULT_MEASURE_TEXTS.map(|[id, title, before, after]| MeasureAtEachStep {
                id,
                title: title.into(),
                before: before.into(),
                after: after.into(),
                continues: id == "ttc_lat",
            });
            let worst = WORST.map(|[id, title, before, after]| Worst {
                id,
                title: title.into(),
                before: before.into(),
                after: after.into(),
            });
            return Self {
                said: said.into(),
                worst: worst.into(),
            };
        };
        let said = chosen.iter().map(|measure| MeasureAtEachStep {
            id: measure.id,
            title: title(measure).into(),
            before: format!("{} ", measure.name).into(),
            after: unit(measure).into(),
            continues: false,
        });
        // Where neither side is dangerous there is no worst value.
        let graded = chosen.iter().filter(|m| m.danger != Danger::Neutral);
        let worst = graded.map(|measure| Worst {
            id: measure.id,
            title: format!("{} {}", measure.danger.extreme(), title(measure)).into(),
            before: match measure.danger {
                Danger::High => format!("largest {} ", measure.name).into(),
                Danger::Low | Danger::Neutral => format!("smallest {} ", measure.name).into(),
            },
            after: unit(measure).into(),
        });
        Self {
            said: said.collect(),
            worst: worst.collect(),
        }
    }

    /// The columns of every step.
    pub fn columns(&self) -> Vec<Column> {
        let columns = self.said.iter().map(|one| Column {
            title: one.title.clone(),
            quantity: one.id,
        });
        columns.collect()
    }

    /// The columns of the worst values: two for each measure, the value and its time.
    pub fn worst_columns(&self) -> Vec<Column> {
        let columns = self.worst.iter().flat_map(|one| {
            let value = Column {
                title: one.title.clone(),
                quantity: one.id,
            };
            [value, column("at t [s]", "time")]
        });
        columns.collect()
    }
}

/// What a measure is called in the tables of the metrics frame: `ttc long`.
#[must_use]
pub fn measure_column(measure: &Measure) -> String {
    measure.id.replace('_', " ")
}

/// The title of its column, with its unit: `ttc long [s]`.
fn title(measure: &Measure) -> String {
    let name = measure_column(measure);
    match measure.unit {
        "" => name,
        unit => format!("{name} [{unit}]"),
    }
}

fn unit(measure: &Measure) -> String {
    match measure.unit {
        "" => String::new(),
        unit => format!(" {unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chosen_measures_are_titled_as_the_usual_ones() {
        let ids = DEFAULT_MEASURE_TEXTS.map(|[id, ..]| id);
        let chosen = MeasureList::from_ids(ids).ok();
        let titles = |columns: &MeasureColumns| {
            let titles = columns.columns().into_iter().map(|c| c.title.into_owned());
            titles.collect::<Vec<_>>()
        };
        let usual = titles(&MeasureColumns::new(None));
        assert_eq!(titles(&MeasureColumns::new(chosen.as_ref())), usual);
        let neutral = MeasureList::parse("v_rel_long").ok();
        assert!(MeasureColumns::new(neutral.as_ref()).worst.is_empty());
    }
}
