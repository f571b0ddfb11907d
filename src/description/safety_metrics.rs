//! The safety-metrics description: distances, times and risk of nearby obstacles, and the window's worst values.
//!
//! Nothing after the window is used, neither directly nor through the route along which lanes are followed.

use super::ego_centric::{OWN, own, relative};
use super::motion_words;
use super::options::{Form, Options};
use super::parts::{NO_EGO, ego_drives, heading, name, no_obstacles, on_lanelets, sizes, subject};
use super::seen::direction;
use super::table::{self, Cell, Column, WHEN_AND_WHO, column};
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

/// Values of one obstacle at one step beside its relation: column, words of the prose before and after.
const SAID: &[(Column, &str, &str)] = &[
    (column("distance [m]", "distance"), "distance ", " m"),
    (
        column("ttc long [s]", "ttc_long"),
        "time to close the gap longitudinal ",
        " s",
    ),
    (column("ttc lat [s]", "ttc_lat"), "lateral ", " s"),
    (column("ttc [s]", "ttc"), "time to collision ", " s"),
    (column("time gap [s]", "time_gap"), "time gap ", " s"),
    (
        column("drac [m/s²]", "drac"),
        "deceleration needed ",
        " m/s²",
    ),
    (column("risk", "risk"), "risk score ", ""),
];

/// The measures whose worst values over the window are given: id and words.
const WORST: &[(&str, &str, &str)] = &[
    ("distance", "smallest distance ", " m"),
    ("ttc", "smallest time to collision ", " s"),
    ("drac", "largest deceleration needed ", " m/s²"),
    ("risk", "lowest risk score ", ""),
];

/// Columns of [`WORST`].
const WORST_COLUMNS: &[Column] = &[
    column("min distance [m]", "distance"),
    column("at step", "step"),
    column("min ttc [s]", "ttc"),
    column("at step", "step"),
    column("max drac [m/s²]", "drac"),
    column("at step", "step"),
    column("min risk", "risk"),
    column("at step", "step"),
];

/// The subject: a scene that ends with the window, and the obstacles near in it.
struct Described<'c, 's> {
    scene: &'s Scene,
    /// Knows nothing but the window.
    context: &'c Context<'s>,
    window: &'c Window,
    options: &'c Options,
}

pub(super) fn describe(w: &mut Writer, context: &Context<'_>, window: &Window, options: &Options) {
    let scene = context.scene();
    let everyone = options.everyone(scene, window);
    let described = Described {
        scene,
        context: &context.during(window),
        window,
        options,
    };
    sizes(w, scene, &everyone);
    match options.form {
        Form::Prose => described.prose(w, &everyone),
        Form::Compact => described.compact(w, &everyone),
    }
}

impl Described<'_, '_> {
    fn encounter(&self, participant: &Participant<'_>, step: i64) -> Option<Encounter<'_>> {
        let id = participant.obstacle.id;
        let mut all = self.context.participants().iter();
        let place = all.position(|p| p.obstacle.id == id)?;
        self.context.encounter(place, step)
    }

    fn prose(&self, w: &mut Writer, everyone: &[Participant<'_>]) {
        for step in self.options.steps(self.window) {
            heading(w, self.scene, step);
            let Some(ego) = self.scene.ego.track.at(step) else {
                w.words(NO_EGO);
                continue;
            };
            ego_drives(w, self.scene, ego, step);
            let near = self.options.near(self.scene, step);
            if near.is_empty() {
                no_obstacles(w, self.options.radius);
            }
            for (participant, motion) in near {
                let Some(encounter) = self.encounter(&participant, step) else {
                    continue;
                };
                let relation = encounter.relation();
                w.about(subject(&participant), Some(step)).words("  ");
                name(w, &participant);
                w.words(" (")
                    .words(direction(&encounter, &relation, self.options).name())
                    .words(", ");
                on_lanelets(w, self.scene, motion);
                w.words("): ");
                relative(w, &relation);
                for (place, (column, before, after)) in SAID.iter().enumerate() {
                    // The two times to close gaps belong together.
                    let between = if column.quantity == "ttc_lat" {
                        ", "
                    } else {
                        "; "
                    };
                    w.words(if place == 0 { "; " } else { between })
                        .words(before);
                    match read(column.quantity, &encounter) {
                        Some(value) => said(w, column.quantity, value).words(after),
                        None => w.words("none"),
                    };
                }
                w.words(". ")
                    .words(&motion_words::describe_motion(
                        &relation,
                        self.options.contact,
                    ))
                    .words("\n");
            }
        }
        if everyone.is_empty() {
            return;
        }
        w.about(Subject::Scene, None)
            .words("\nWorst values from step ")
            .whole("step", self.window.first())
            .words(" to ")
            .whole("step", self.window.last())
            .words(":\n");
        for participant in everyone {
            w.about(subject(participant), None).words("  ");
            name(w, participant);
            for (place, (id, before, after)) in WORST.iter().enumerate() {
                w.words(if place == 0 { ": " } else { "; " }).words(before);
                let Some((value, step)) = self.worst(participant, id) else {
                    w.words("none");
                    continue;
                };
                w.about(subject(participant), Some(step));
                said(w, id, value)
                    .words(after)
                    .words(" at step ")
                    .whole("step", step);
            }
            w.words(".\n");
        }
    }

    fn compact(&self, w: &mut Writer, everyone: &[Participant<'_>]) {
        let measures: Vec<Column> = SAID
            .iter()
            .map(|(c, ..)| column(c.title, c.quantity))
            .collect();
        table::titles(w, WHEN_AND_WHO, &[OWN, RELATION, &measures]);
        for step in self.options.steps(self.window) {
            table::begin(w, self.scene, step, None);
            let ego = self
                .scene
                .ego
                .track
                .at(step)
                .map(|ego| own(self.scene, ego));
            table::cells(w, OWN, ego.as_ref().map_or(&[], |c| c));
            table::cells(w, RELATION, &[]);
            table::cells(w, &measures, &[]);
            w.words("\n");
            for (participant, motion) in self.options.near(self.scene, step) {
                let Some(encounter) = self.encounter(&participant, step) else {
                    continue;
                };
                let relation = encounter.relation();
                table::begin(w, self.scene, step, Some(&participant));
                table::cells(w, OWN, &[Cell::lanelets(self.scene, motion)]);
                let cells = [
                    Cell::Words(direction(&encounter, &relation, self.options).name()),
                    Cell::Real(relation.gap_long),
                    Cell::Real(relation.gap_lat),
                    Cell::Real(relation.velocity.x),
                    Cell::Real(relation.velocity.y),
                ];
                table::cells(w, RELATION, &cells);
                let cells: Vec<Cell> = measures
                    .iter()
                    .map(|c| cell(c.quantity, read(c.quantity, &encounter)))
                    .collect();
                table::cells(w, &measures, &cells);
                w.words("\n");
            }
        }
        if everyone.is_empty() {
            return;
        }
        w.about(Subject::Scene, None)
            .words("\nWorst values from step ")
            .whole("step", self.window.first())
            .words(" to ")
            .whole("step", self.window.last())
            .words(":\n");
        table::titles(w, "who", &[WORST_COLUMNS]);
        for participant in everyone {
            w.about(subject(participant), None);
            name(w, participant);
            for (place, (id, ..)) in WORST.iter().enumerate() {
                let worst = self.worst(participant, id);
                w.about(subject(participant), worst.map(|(_, step)| step));
                let cells = match worst {
                    Some((value, step)) => vec![cell(id, Some(value)), Cell::Whole(step)],
                    None => Vec::new(),
                };
                table::cells(w, &WORST_COLUMNS[2 * place..2 * place + 2], &cells);
            }
            w.words("\n");
        }
    }

    /// The most dangerous value of a measure in the window, and its first step.
    fn worst(&self, participant: &Participant<'_>, id: &str) -> Option<(f64, i64)> {
        let danger = measure(id)?.danger;
        let values = self.window.steps().filter_map(|step| {
            let encounter = self.encounter(participant, step)?;
            Some((read(id, &encounter)?, step))
        });
        values.min_by(|a, b| danger.compare(a.0, b.0))
    }
}

fn read(id: &str, encounter: &Encounter<'_>) -> Option<f64> {
    (measure(id)?.compute)(encounter).value()
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
