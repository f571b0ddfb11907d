//! The table of encounters: recorded contacts, conflicts and near misses, and which drivers avoid them.

use nearmiss_base::system::counted;
use nearmiss_drive::driver::{DRIVERS, PreventabilityRecord};
use nearmiss_formats::Entry;
use nearmiss_record::{Cell, Column, Kind, Row, Table};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::{
    Context, CriticalMoment, SEVERITY_NAMES, Thresholds, critical_moments,
};
use nearmiss_scene::scenario::Scene;

use super::{RowFile, WHEN, integer, meanings, rounded, text, when};
use crate::VariantOrigin;

/// The most severe grade that is no encounter.
const NEAR_MISS: u8 = 2;

/// A contact, conflict or near miss of the ego.
#[derive(Debug, Clone)]
pub struct Encounter {
    /// How severe it is, 0 (contact) to 2 (near miss).
    pub severity: u8,
    /// Who avoids it.
    pub drivers: PreventabilityRecord,
}

impl Encounter {
    /// That of a moment of a scene; `is_certified`: a certificate says that the ideal driver avoids it. `None` where the moment is
    /// no contact, conflict or near miss, begins with the recording, or follows a contact with another road user.
    #[must_use]
    pub fn at(scene: &Scene, moment: &CriticalMoment, is_certified: bool) -> Option<Self> {
        let severity = moment.grade.number();
        (severity <= NEAR_MISS).then_some(())?;
        let drivers = PreventabilityRecord::of(scene, moment.obstacle, moment.step, is_certified)?;
        Some(Self { severity, drivers })
    }
}

/// The encounters in the scene of an entry, the most severe first, and how many more begin with the recording or follow a
/// contact with another road user: there is no time in which a driver could drive before these.
///
/// # Errors
/// As of [`VariantOrigin::read`].
pub fn encounters(
    entry: &Entry,
    scene: &Scene,
    thresholds: &Thresholds,
) -> Result<(Vec<Encounter>, usize), String> {
    let moments = critical_moments(&Context::under(scene, thresholds));
    let severe = { moments.iter() }.filter(|moment| moment.grade.number() <= NEAR_MISS);
    let is_certified = severe.clone().next().is_some() && VariantOrigin::certified(entry, scene)?;
    let judged = { severe.clone() }.filter_map(|moment| Encounter::at(scene, moment, is_certified));
    let judged: Vec<Encounter> = judged.collect();
    let without = severe.count() - judged.len();
    Ok((judged, without))
}

/// That no driver is judged in so many encounters.
#[must_use]
pub fn left_out(without: usize) -> Option<String> {
    let encounters = counted(without, "encounter");
    (without > 0).then(|| {
        format!("no driver is judged in {encounters}: at the begin of the recording, after another contact, or on a way that the ego drives back")
    })
}

/// That the time steps of a scenario, seconds, are too long for drivers.
#[must_use]
pub fn too_coarse(file: &str, dt: f64) -> Option<String> {
    (dt > COARSE).then(|| {
        format!(
            "nearmiss: {}: time steps of {dt} s are too coarse for drivers: delays are whole steps, and they brake late",
            visible(file)
        )
    })
}

/// Delays of drivers are 0.35 s and more, and whole time steps, seconds.
const COARSE: f64 = 0.2;

/// The table: of each driver what comes of it, how fast its contact is, and how long before the encounter it could still
/// take over.
#[must_use]
pub fn encounter_table() -> Table {
    let fixed = [
        text("encounter", "contact, conflict or near miss"),
        integer("obstacle", "id of the other road user"),
        Column::new(
            "closing_speed",
            Kind::Number,
            "m/s",
            "closing speed at the ego's own contact",
        )
        .optional(),
        integer("avoided", "drivers that avoid contact"),
        integer(
            "decided",
            "drivers that decide: made for it and not hit from behind by who does not see them",
        ),
        text("not_made_for", "what other drivers are not made for").optional(),
    ];
    let drivers = DRIVERS.iter().flat_map(|driver| {
        let number = |what: &str, unit, source| Column {
            name: format!("{}_{what}", driver.id).into(),
            ..Column::new("", Kind::Number, unit, source).optional()
        };
        [
            Column::new(driver.id, Kind::Text, "", driver.name),
            number("closing_speed", "m/s", "closing speed at its contact"),
            number(
                "last_moment",
                "s",
                "how long before the encounter it could still take over and avoid contact",
            ),
        ]
    });
    let columns = { RowFile::COLUMNS.into_iter() }
        .chain(WHEN)
        .chain(fixed)
        .chain(drivers);
    let mut table = Table::new("encounters", columns.collect());
    table.metadata = vec![
        ("version", env!("CARGO_PKG_VERSION").into()),
        ("columns", meanings(&table).to_string()),
    ];
    table
}

/// The rows of a scene's encounters.
#[must_use]
pub fn encounter_rows(file: &RowFile, scene: &Scene, encounters: &[Encounter]) -> Vec<Row> {
    let count = |n: usize| Cell::Integer(i64::try_from(n).unwrap_or(i64::MAX));
    let number = |value: Option<f64>| value.map_or(Cell::None(""), |v| Cell::finite(rounded(v)));
    let row = |one: &Encounter| {
        let found = &one.drivers;
        let fixed = [
            SEVERITY_NAMES[usize::from(one.severity)].into(),
            Cell::Integer(found.obstacle),
            number(found.closing_speed),
            count(found.avoided),
            count(found.decided),
            found.not_made_for().map_or(Cell::None(""), Cell::from),
        ];
        let drivers = found.drivers.iter().flat_map(|verdict| {
            let before = verdict
                .last_moment_step
                .map(|last| (found.step - last) as f64 * scene.scenario.dt());
            [
                verdict.result.name().into(),
                number(verdict.closing_speed),
                number(before),
            ]
        });
        let cells = file
            .cells()
            .into_iter()
            .chain(when(scene, found.step))
            .chain(fixed);
        cells.chain(drivers).collect()
    };
    encounters.iter().map(row).collect()
}
