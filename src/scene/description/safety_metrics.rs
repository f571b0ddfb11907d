//! The safety-metrics description: distances, times and risk of nearby obstacles, and the window's worst values.
//!
//! Nothing after the window is used, neither directly nor through the route along which lanes are followed.

use super::ego_centric::{OWN, own, relative};
use super::lanes::Lanes;
use super::measure_columns::{MeasureColumns, Said, Worst};
use super::motion_words;
use super::options::{Form, Moment, Options, everyone};
use super::parts::{
    NO_EGO, ego_moves, everyone_there, heading, name, name_and_place, no_obstacles, subject,
};
use super::seen::Seen;
use super::table::{self, Cell, Column, column};
use super::writer::{Subject, Writer};
use crate::metrics::{Context, Encounter, measure};
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
                w.words(NO_EGO);
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
                let seen = Seen::new(&encounter, self.options);
                name_and_place(w, &participant, step, &seen, lanes.of(ego, motion));
                relative(w, &seen.relation);
                measures(w, &self.columns.said, &encounter);
                let words = motion_words::describe_motion(w, &seen, self.options.contact);
                w.words(". ").words(&words).words("\n");
            }
        }
        if everyone.is_empty() || self.columns.worst.is_empty() {
            return;
        }
        self.worst_heading(w);
        for participant in everyone {
            w.about(subject(participant), None).words("  ");
            name(w, participant);
            for (place, worst) in self.columns.worst.iter().enumerate() {
                let Worst {
                    id, before, after, ..
                } = worst;
                w.words(if place == 0 { ": " } else { "; " }).words(before);
                let Some((value, step)) = self.worst(w, participant, id) else {
                    w.words("none");
                    continue;
                };
                w.about(subject(participant), Some(step));
                said(w, id, value)
                    .words(after)
                    .words(" at t = ")
                    .time(step, self.scene.scenario.dt())
                    .words(" s");
            }
            w.words(".\n");
        }
    }

    fn worst_heading(&self, w: &mut Writer) {
        let dt = self.scene.scenario.dt();
        w.about(Subject::Scene, Some(self.window.first()))
            .words("\nWorst values from t = ")
            .time(self.window.first(), dt)
            .words(" s to t = ")
            .about(Subject::Scene, Some(self.window.last()))
            .time(self.window.last(), dt)
            .words(" s:\n");
    }

    fn compact(&self, w: &mut Writer, described: Vec<Moment<'_>>, everyone: &[Participant<'_>]) {
        let lanes = Lanes::new(self.scene);
        let measures = self.columns.columns();
        table::titles(w, &[OWN, RELATION, &measures]);
        for Moment { step, near, .. } in described {
            table::begin(w, self.scene, step, None);
            let ego = self.scene.ego.track.at(step);
            let cells = ego.map(|ego| own(&lanes, ego));
            table::cells(w, OWN, cells.as_ref().map_or(&[], |c| c));
            table::cells(w, RELATION, &[]);
            table::cells(w, &measures, &[]);
            w.words("\n");
            for (participant, motion) in near {
                let Some((ego, encounter)) = ego.zip(self.encounter(&participant, step)) else {
                    continue;
                };
                let seen = Seen::new(&encounter, self.options);
                let relation = &seen.relation;
                table::begin(w, self.scene, step, Some(&participant));
                table::cells(w, OWN, &[Cell::words(lanes.of(ego, motion))]);
                let cells = [
                    Cell::Words(seen.direction.name()),
                    Cell::Real(relation.gap_long),
                    Cell::Real(relation.gap_lat),
                    Cell::Real(relation.velocity.x),
                    Cell::Real(relation.velocity.y),
                ];
                table::cells(w, RELATION, &cells);
                let cells: Vec<Cell> = measures
                    .iter()
                    .map(|c| cell(c.quantity, read(w, c.quantity, &encounter)))
                    .collect();
                table::cells(w, &measures, &cells);
                w.words("\n");
            }
        }
        if everyone.is_empty() || self.columns.worst.is_empty() {
            return;
        }
        self.worst_heading(w);
        let titles = self.columns.worst_columns();
        table::titles_after(w, "who", &[&titles]);
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
                table::cells(w, &titles[2 * place..2 * place + 2], &cells);
            }
            w.words("\n");
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
fn measures(w: &mut Writer, said_of: &[Said], encounter: &Encounter<'_>) {
    for (place, one) in said_of.iter().enumerate() {
        // The two times to close gaps belong together.
        let between = if one.continues { ", " } else { "; " };
        w.words(if place == 0 { "; " } else { between })
            .words(&one.before);
        match read(w, one.id, encounter) {
            Some(value) => said(w, one.id, value).words(&one.after),
            None => w.words("none"),
        };
    }
}

/// The lowest risk score that is written: whether bodies touch is for the reader to find.
const LOWEST_RISK: f64 = 1.0;

/// The value of a measure; no time where the speed that it is computed with is written as 0.
fn read(w: &Writer, id: &str, encounter: &Encounter<'_>) -> Option<f64> {
    let value = measure(id)?.of(encounter).value()?;
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

fn said<'w>(w: &'w mut Writer, id: &'static str, value: f64) -> &'w mut Writer {
    match id {
        "risk" => w.whole(id, value as i64),
        _ => w.number(id, value),
    }
}
