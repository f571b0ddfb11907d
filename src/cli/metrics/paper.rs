//! The table of the paper's convention: published columns in their order, the risk score, and identifying columns.

use crate::output::{self, Cell, Column, Kind};
use nearmiss_scene::metrics::paper::{Relation, Row, rows as measured};
use nearmiss_scene::scenario::Scene;
use nearmiss_workflow::tables::RowFile;

/// A column and its values in the rows of a scenario.
struct PaperColumn {
    column: Column,
    values: Get,
}

/// How to get a value from a row.
enum Get {
    Text(fn(&Row) -> &'static str),
    Integer(fn(&Row) -> i64),
    Number(fn(&Row) -> f64),
    Time(fn(&Relation) -> Option<f64>),
}

const fn column(
    name: &'static str,
    unit: &'static str,
    source: &'static str,
    values: Get,
) -> PaperColumn {
    let kind = match values {
        Get::Text(_) => Kind::Text,
        Get::Integer(_) => Kind::Integer,
        Get::Number(_) | Get::Time(_) => Kind::Float,
    };
    PaperColumn {
        column: Column::new(name, kind, unit, source),
        values,
    }
}

const GAP: &str = "centre to centre in the ego's frame, two decimals";
const ADJUSTED: &str = "the same less one length of 4.508 m or width of 1.610 m, 0 within it";
const V_REL: &str = "ego frame, two decimals";
const A_REL: &str = "axes of the map, two decimals";
const TTC: &str = "adjusted gap over closing speed, 0 within one length or width";
const DSC: &str = "grade of the adjusted gap: 0.3, 0.8, 1.3, 3 and 5 m";
const TSC: &str = "grade of the time: 0.15, 0.65, 1.15, 3 and 5 s";
const MIXED: &str = "both grades, weighted";

/// Up to `ttc_lat` as in `relative_metrics.csv`; from `wdominant` to `risk_score` as in `risk_scores_*.csv`;
/// `distance` as in `close_dynamic_obstacles.csv`. The scenario and its file are last, so that the published columns come first.
const COLUMNS: &[PaperColumn] = &[
    column(
        "timestep",
        "",
        "time step of the scenario",
        Get::Integer(|r| r.timestep),
    ),
    column(
        "obstacle_id",
        "",
        "id in the scenario",
        Get::Integer(|r| r.obstacle),
    ),
    column(
        "relative_direction",
        "",
        "where the obstacle's centre is, against one length and one width",
        Get::Text(|r| r.relation.direction.name()),
    ),
    column("d_long", "m", GAP, Get::Number(|r| r.relation.d_long)),
    column("d_lat", "m", GAP, Get::Number(|r| r.relation.d_lat)),
    column(
        "adjusted_d_long",
        "m",
        ADJUSTED,
        Get::Number(|r| r.relation.adjusted_d_long),
    ),
    column(
        "adjusted_d_lat",
        "m",
        ADJUSTED,
        Get::Number(|r| r.relation.adjusted_d_lat),
    ),
    column(
        "v_rel_long",
        "m/s",
        V_REL,
        Get::Number(|r| r.relation.v_rel_long),
    ),
    column(
        "v_rel_lat",
        "m/s",
        V_REL,
        Get::Number(|r| r.relation.v_rel_lat),
    ),
    column(
        "a_rel_long",
        "m/s²",
        A_REL,
        Get::Number(|r| r.relation.a_rel_long),
    ),
    column(
        "a_rel_lat",
        "m/s²",
        A_REL,
        Get::Number(|r| r.relation.a_rel_lat),
    ),
    column("ttc_long", "s", TTC, Get::Time(|r| r.ttc_long)),
    column("ttc_lat", "s", TTC, Get::Time(|r| r.ttc_lat)),
    column(
        "motion_long",
        "",
        "relative motion along the ego's heading",
        Get::Text(|r| r.relation.motion_long.text()),
    ),
    column(
        "motion_lat",
        "",
        "relative motion across the ego's heading",
        Get::Text(|r| r.relation.motion_lat.text()),
    ),
    column(
        "wdominant",
        "",
        "weight of the longitudinal grades, by direction",
        Get::Number(|r| r.risk.wdominant),
    ),
    column(
        "long_dsc",
        "",
        DSC,
        Get::Integer(|r| r.risk.long_dsc.into()),
    ),
    column("lat_dsc", "", DSC, Get::Integer(|r| r.risk.lat_dsc.into())),
    column("dsc", "", MIXED, Get::Number(|r| r.risk.dsc)),
    column(
        "long_tsc",
        "",
        TSC,
        Get::Integer(|r| r.risk.long_tsc.into()),
    ),
    column("lat_tsc", "", TSC, Get::Integer(|r| r.risk.lat_tsc.into())),
    column("tsc", "", MIXED, Get::Number(|r| r.risk.tsc)),
    column(
        "risk_score",
        "",
        "0 (collision) to 5 (negligible): half the sum of dsc and tsc, without its fraction",
        Get::Integer(|r| r.risk.risk_score.into()),
    ),
    column(
        "distance",
        "m",
        "centre to centre, not rounded",
        Get::Number(|r| r.distance),
    ),
];

pub fn columns() -> Vec<Column> {
    let columns = COLUMNS.iter().map(|c| match c.values {
        Get::Time(_) => c.column.clone().optional(),
        _ => c.column.clone(),
    });
    columns.chain(RowFile::COLUMNS).collect()
}

/// The rows of the obstacles whose centre is within `radius` metres of the ego's.
pub fn rows(
    file: &RowFile,
    scene: &Scene,
    radius: Option<f64>,
) -> Result<Vec<output::Row>, String> {
    let mut rows = measured(scene).map_err(|error| error.to_string())?;
    rows.retain(|row| radius.is_none_or(|radius| row.distance <= radius));
    let cells = |row: &Row| -> output::Row {
        let cells = COLUMNS.iter().map(|c| match c.values {
            Get::Text(get) => get(row).into(),
            Get::Integer(get) => Cell::Integer(get(row)),
            Get::Number(get) => Cell::finite(get(row)),
            Get::Time(get) => {
                get(&row.relation).map_or(Cell::Infinite("not approaching"), Cell::finite)
            }
        });
        cells.chain(file.cells()).collect()
    };
    Ok(rows.iter().map(cells).collect())
}
