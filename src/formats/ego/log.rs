//! The `logs.csv` of the planner Frenetix: one row for each planning step, with the chosen trajectory.
//!
//! The facts, from the logger of Frenetix-Motion-Planner and from two published logs: columns are divided by
//! `;`, lists are comma-joined in quotes. `trajectory_number` is the time step (older versions count plans from 0, the
//! same where every step is planned). `x_position_vehicle_m` and `y_position_vehicle_m` are the vehicle's centre at
//! that step; `x_positions_m`, `y_positions_m`, `theta_orientations_rad`, `velocities_mps` and `accelerations_mps2`
//! begin at that step too, also where the plan is an older one that is still followed, and their positions are the
//! rear axle. So the driven state of a step is the first state of its row. Rows whose plans run on for
//! more than one step are recognised by where the next row begins in the plan, and the states between are the plan's.

use super::recording::{USUAL, as_integer};
use super::table::{self, Table, finite, shown};
use super::{EgoError, Lines, assumed};
use nearmiss_base::geometry::{Point, Vector};
use nearmiss_scene::scenario::EgoSource;
use nearmiss_scene::scenario::{Diagnostic, Ego, Sample, Scenario, Severity, Track, VehicleType};

/// Two positions nearer than this, metres, are the same.
const POSITION_TOLERANCE: f64 = 1e-3;

/// Where the columns are.
struct Columns {
    step: usize,
    centre: Option<(usize, usize)>,
    found: Option<usize>,
    lists: [Option<usize>; 5],
}

/// The columns with lists, in the order of [`Row::plan`].
const LISTS: [&str; 5] = [
    "x_positions_m",
    "y_positions_m",
    "theta_orientations_rad",
    "velocities_mps",
    "accelerations_mps2",
];

/// One row: the state at a step and the plan from there on.
struct Row {
    line: u64,
    step: i64,
    centre: Option<Point>,
    /// x and y of the rear axle, heading, velocity, acceleration; as far as they are there.
    plan: [Vec<Option<f64>>; 5],
}

impl Row {
    fn rear_axle(&self, i: usize) -> Option<Point> {
        let value = |list: usize| self.plan[list].get(i).copied().flatten();
        Some(Point::new(value(0)?, value(1)?))
    }

    /// The state that the plan has after `i` steps; its first position is the logged one.
    fn sample(&self, i: usize, step: i64, vehicle: VehicleType) -> Option<Sample> {
        let value = |list: usize| self.plan[list].get(i).copied().flatten();
        let heading = value(2);
        let shifted = || {
            let heading = heading?;
            let forward = Vector::new(heading.cos(), heading.sin());
            Some(self.rear_axle(i)? + forward * vehicle.to_rear_axle())
        };
        let logged = self.centre.filter(|_| i == 0);
        Some(Sample {
            step,
            position: logged.or_else(shifted)?,
            heading,
            velocity: value(3),
            acceleration: value(4),
        })
    }

    /// Whether `next` begins where this plan is after `steps` steps.
    fn leads_to(&self, next: &Row, steps: usize) -> bool {
        let pair = self.rear_axle(steps).zip(next.rear_axle(0));
        pair.is_some_and(|(a, b)| (a - b).norm() < POSITION_TOLERANCE)
    }
}

/// Reads the driven trajectory of a log from `bytes`, with the lines of its steps; `file` names it in errors.
///
/// # Errors
/// Missing columns, values that are not numbers, no rows: with file, line, column and value.
pub(super) fn read(
    bytes: &[u8],
    file: &str,
    scenario: &Scenario,
    planning_problem: Option<i64>,
) -> Result<(Ego, Lines), EgoError> {
    let mut diagnostics = Vec::new();
    let rows = rows(bytes, file, &mut diagnostics)?;
    let problem = match planning_problem {
        Some(id) => scenario.planning_problems.iter().find(|p| p.id == id),
        None => scenario.planning_problems.first(),
    };
    let start = problem.map_or(0, |p| p.initial.time.from);
    if let Some(first) = rows.first().filter(|r| r.step == 0 && start != 0) {
        diagnostics.push(at(
            first.line,
            format!("rows start at 0, the planning problem at step {start}; taken as time steps"),
        ));
    }
    let vehicle = vehicle(&rows, &mut diagnostics);
    let samples = driven(&rows, vehicle, &mut diagnostics);
    let resting = problem.and_then(|p| p.initial.orientation);
    let (first, stride) = (rows.first().map_or(0, |r| r.step), stride(&rows));
    let lines = rows
        .iter()
        .map(|r| (first + (r.step - first) * stride, r.line));
    let lines = Lines::new(lines);
    let ego = Ego {
        id: planning_problem.or(problem.map(|p| p.id)).unwrap_or(0),
        source: EgoSource::Log(file.to_string()),
        footprint: vehicle.footprint(),
        track: Track::new(samples.clone(), scenario.dt(), resting.map(|q| q.middle())),
        recorded: samples,
        diagnostics,
    };
    Ok((ego, lines))
}

fn columns(
    table: &mut Table<'_>,
    file: &str,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<Columns, EgoError> {
    let mut column = |name| table.column(name, diagnostics);
    let missing = |column| EgoError::LogColumn {
        file: file.to_string(),
        column,
    };
    let centre = column("x_position_vehicle_m")?.zip(column("y_position_vehicle_m")?);
    let mut lists = [None; 5];
    for (place, name) in lists.iter_mut().zip(LISTS) {
        *place = column(name)?;
    }
    if centre.is_none()
        && let Some(place) = lists[..3].iter().position(Option::is_none)
    {
        return Err(missing(LISTS[place]));
    }
    Ok(Columns {
        step: column("trajectory_number")?.ok_or_else(|| missing("trajectory_number"))?,
        centre,
        found: column("optimal_trajectory")?,
        lists,
    })
}

/// The rows in order of time, each step once.
fn rows(bytes: &[u8], file: &str, diagnostics: &mut Vec<Diagnostic>) -> Result<Vec<Row>, EgoError> {
    let mut table = Table::begin(bytes, file, b';')?;
    let columns = columns(&mut table, file, diagnostics)?;
    let (mut rows, mut planless, mut widest) = (Vec::new(), Vec::new(), 0);
    while let Some(record) = table.next()? {
        let line = record.line;
        // In such a row the columns before this one are left out, so it stands too far left.
        let no_plan = [Some(2), columns.found].into_iter().flatten();
        if no_plan.into_iter().any(|c| record.text(c) == "False") {
            planless.push(line);
            continue;
        }
        let fields = match widest {
            0 => table.header().len(),
            widest => widest,
        };
        if table.is_cut_off(&record, fields) {
            if rows.is_empty() {
                return Err(table.cut_off(&record));
            }
            let message = "the file is truncated within this row, which was left out; is the end of the drive missing?";
            diagnostics.push(at(line, message.into()));
            continue;
        }
        widest = widest.max(record.len());
        rows.push(row(&record, &columns, &table, file)?);
    }
    if let Some(first) = planless.first() {
        let message = format!(
            "{} row(s) without a trajectory were left out",
            planless.len()
        );
        diagnostics.push(at(*first, message));
    }
    if rows.is_empty() {
        return Err(EgoError::Empty {
            file: file.to_string(),
        });
    }
    diagnostics.extend(table.unused(rows.len()));
    let steps: Vec<i64> = rows.iter().map(|r: &Row| r.step).collect();
    diagnostics.extend(super::order(&steps, |row| rows[row].line));
    rows.sort_by_key(|r| r.step);
    match rows.windows(2).find(|w| w[0].step == w[1].step) {
        Some(pair) => Err(EgoError::Repeated {
            file: file.to_string(),
            line: pair[0].line.max(pair[1].line),
            step: pair[0].step,
        }),
        None => Ok(rows),
    }
}

fn row(
    record: &table::Row,
    columns: &Columns,
    table: &Table<'_>,
    file: &str,
) -> Result<Row, EgoError> {
    let line = record.line;
    let value = |place: usize, column: &'static str| {
        if place >= record.len() {
            return table.short(record, place);
        }
        EgoError::Value {
            file: file.to_string(),
            line,
            column,
            value: shown(record.text(place)),
        }
    };
    let number = |place: usize, column: &'static str| {
        let number = finite(record.text(place)).ok_or_else(|| value(place, column))?;
        super::plausible_number(number, file, line, column)
    };
    let step = finite(record.text(columns.step))
        .and_then(as_integer)
        .ok_or_else(|| EgoError::Step {
            file: file.to_string(),
            line,
            column: "trajectory_number",
            value: shown(record.text(columns.step)),
        })?;
    let centre = match columns.centre {
        Some((x, y)) => Some(Point::new(
            number(x, "x_position_vehicle_m")?,
            number(y, "y_position_vehicle_m")?,
        )),
        None => None,
    };
    let mut plan: [Vec<Option<f64>>; 5] = Default::default();
    for ((place, column), list) in columns.lists.iter().zip(LISTS).zip(&mut plan) {
        let Some(place) = *place else { continue };
        *list = record.text(place).split(',').map(finite).collect();
        // Only what was driven has to be right; a plan may end in anything.
        if list.first().is_none_or(Option::is_none) {
            return Err(value(place, column));
        }
        if let Some(Some(first)) = list.first() {
            super::plausible_number(*first, file, line, column)?;
        }
        // Implausible planned states are dropped.
        for value in list.iter_mut().skip(1) {
            *value = value.filter(|v| super::plausible_number(*v, file, line, column).is_ok());
        }
    }
    Ok(Row {
        line,
        step,
        centre,
        plan,
    })
}

/// The vehicle whose rear axle is as far behind its centre as the log says.
fn vehicle(rows: &[Row], diagnostics: &mut Vec<Diagnostic>) -> VehicleType {
    let both = |r: &Row| r.centre.zip(r.rear_axle(0)).map(|(c, a)| (c - a).norm());
    let offset = rows.iter().find_map(both);
    let known = offset.and_then(|offset| {
        let all = VehicleType::ALL.iter().copied();
        all.into_iter()
            .find(|v| (v.to_rear_axle() - offset).abs() < POSITION_TOLERANCE)
    });
    let message = match known {
        Some(vehicle) => {
            format!("no size given; assuming the vehicle with this rear axle, {vehicle}")
        }
        None => format!("no size given; assuming the default vehicle, {USUAL}"),
    };
    diagnostics.push(assumed(Severity::Note, message));
    known.unwrap_or(USUAL)
}

/// The driven states: the first of every row, and those of the plan between rows that are farther apart.
fn driven(rows: &[Row], vehicle: VehicleType, diagnostics: &mut Vec<Diagnostic>) -> Vec<Sample> {
    let stride = stride(rows);
    let first = rows.first().map_or(0, |r| r.step);
    let step_of = |row: &Row| first + (row.step - first) * stride;
    if stride > 1 {
        let message = format!(
            "rows count plans, not steps: each starts where the previous plan is after {stride} steps, so {stride} states of every plan were driven"
        );
        diagnostics.push(assumed(Severity::Warning, message));
    }
    let mut samples = Vec::new();
    let (mut between, mut breaks) = (0, Vec::new());
    for (i, row) in rows.iter().enumerate() {
        let step = step_of(row);
        samples.extend(row.sample(0, step, vehicle));
        let Some(next) = rows.get(i + 1) else {
            continue;
        };
        let apart = usize::try_from(step_of(next) - step).unwrap_or(usize::MAX);
        if row.leads_to(next, apart) {
            for later in 1..apart {
                let planned = row.sample(later, step + later as i64, vehicle);
                between += usize::from(planned.is_some());
                samples.extend(planned);
            }
        } else if row.rear_axle(0).is_some() {
            breaks.push(next.line);
        }
    }
    if between > 0 {
        let message = format!("{between} steps without their own row use the previous plan");
        diagnostics.push(assumed(Severity::Note, message));
    }
    if let Some(line) = breaks.first() {
        let message = format!(
            "{} row(s) do not start where the previous plan ends; the logged positions are used",
            breaks.len()
        );
        diagnostics.push(at(*line, message));
    }
    samples
}

/// How many steps of each plan were driven: 1, unless rows number plans and all begin as far into the one before.
fn stride(rows: &[Row]) -> i64 {
    let pairs = || rows.windows(2).map(|w| (&w[0], &w[1]));
    if pairs().any(|(a, b)| b.step - a.step != 1) {
        return 1;
    }
    let odd = pairs().find(|(a, b)| !a.leads_to(b, 1));
    let longer = odd.and_then(|(a, b)| (2..a.plan[0].len()).find(|n| a.leads_to(b, *n)));
    match longer {
        Some(n) if pairs().all(|(a, b)| a.leads_to(b, n)) => i64::try_from(n).unwrap_or(1),
        _ => 1,
    }
}

fn at(line: u64, message: String) -> Diagnostic {
    Diagnostic {
        severity: Severity::Warning,
        line: usize::try_from(line).unwrap_or(0),
        element: String::new(),
        message,
    }
}
