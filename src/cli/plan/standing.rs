//! Where planners stand beside each other and beside baselines: outcomes and harm, paired with the first one.

use nearmiss_drive::simulation::{CollisionKind, Outcome};
use nearmiss_study::evaluation::statistics::PairedTest;
use nearmiss_workflow::drive::DrivenScenario;
use schemars::JsonSchema;
use serde::Serialize;

use crate::output::Align::{Left, Right};
use crate::output::{self, line};

/// What one drive counts for.
#[derive(Debug, Clone, Copy)]
pub struct DriveFigures {
    is_goal: bool,
    is_collision: bool,
    ran_into: bool,
    rear_ended: bool,
    unharmed: bool,
    /// Serious injuries that are expected; nothing where no curve tells.
    harm: Option<f64>,
}

impl From<&DrivenScenario> for DriveFigures {
    fn from(driven: &DrivenScenario) -> Self {
        let collision = driven.collision();
        Self {
            is_goal: matches!(driven.outcome(), Outcome::Goal(_)),
            is_collision: collision.is_some(),
            ran_into: collision.is_some_and(|c| c.kind() == CollisionKind::RanInto),
            rear_ended: collision.is_some_and(|c| c.kind() == CollisionKind::RearEnded),
            unharmed: driven.unharmed(),
            harm: driven.p_serious(),
        }
    }
}

/// All drives of one planner, a scenario each.
#[derive(Debug)]
pub struct Standing {
    /// Its name.
    pub name: String,
    /// Whether it is a baseline that was not named.
    pub is_baseline: bool,
    /// In the order of scenarios, the same for all.
    pub drives: Vec<DriveFigures>,
}

/// Where one planner stands.
#[derive(Debug, Serialize, JsonSchema)]
pub struct StandingRecord {
    /// The planner.
    planner: String,
    /// Whether it drives as a baseline, without being named.
    baseline: bool,
    /// Drives that reach the goal.
    goal: usize,
    /// Drives that end in a collision.
    collision: usize,
    /// Of these, the ego's front into another.
    ran_into: usize,
    /// Of these, another's front into the ego's rear: traffic that follows its recording does not see it brake.
    rear_ended: usize,
    /// Serious injuries that are expected of its collisions, those without a published curve left out.
    p_serious: f64,
    /// Its share of collisions minus that of the first planner, paired.
    collision_difference: Option<f64>,
    /// 95 % interval of that difference.
    collision_interval: Option<(f64, f64)>,
    /// Its share of goals minus that of the first planner, paired.
    goal_difference: Option<f64>,
    /// 95 % interval of that difference.
    goal_interval: Option<(f64, f64)>,
}

/// Scenarios that a lane follower does not solve.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub struct BeyondBaselines {
    /// Scenarios in which every baseline ends otherwise than at the goal or out of time.
    scenarios: usize,
    /// Of these, scenarios in which the first planner ends at the goal or out of time.
    first_unharmed: usize,
}

/// The difference of a figure from the first planner's, and its interval.
fn difference(
    one: &Standing,
    first: &Standing,
    figure: fn(&DriveFigures) -> bool,
) -> (Option<f64>, Option<(f64, f64)>) {
    let as_number = |drive| f64::from(u8::from(figure(drive)));
    let pairs = first.drives.iter().zip(&one.drives);
    let differences: Vec<f64> = pairs.map(|(a, b)| as_number(a) - as_number(b)).collect();
    let test = (differences.len() > 1)
        .then(|| PairedTest::of_differences(&differences))
        .flatten();
    let interval = test.as_ref().and_then(|test| test.interval);
    (
        test.map(|test| 0.0 - test.difference),
        interval.map(|i| (0.0 - i.high, 0.0 - i.low)),
    )
}

/// Where all stand; the first is what the others are compared with.
pub fn records(all: &[Standing]) -> Vec<StandingRecord> {
    let record = |(place, one): (usize, &Standing)| {
        let count =
            |figure: fn(&DriveFigures) -> bool| one.drives.iter().filter(|d| figure(d)).count();
        let paired = |figure| match place {
            0 => (None, None),
            _ => difference(one, &all[0], figure),
        };
        let (collision_difference, collision_interval) = paired(|d| d.is_collision);
        let (goal_difference, goal_interval) = paired(|d| d.is_goal);
        StandingRecord {
            planner: one.name.clone(),
            baseline: one.is_baseline,
            goal: count(|d| d.is_goal),
            collision: count(|d| d.is_collision),
            ran_into: count(|d| d.ran_into),
            rear_ended: count(|d| d.rear_ended),
            p_serious: one.drives.iter().filter_map(|d| d.harm).sum(),
            collision_difference,
            collision_interval,
            goal_difference,
            goal_interval,
        }
    };
    all.iter().enumerate().map(record).collect()
}

/// Scenarios that no baseline solves, and what the first planner makes of them.
pub fn beyond(all: &[Standing]) -> BeyondBaselines {
    let baselines: Vec<&Standing> = all.iter().filter(|one| one.is_baseline).collect();
    let mut found = BeyondBaselines::default();
    for (place, drive) in all
        .first()
        .iter()
        .flat_map(|first| first.drives.iter().enumerate())
    {
        if baselines.iter().all(|one| !one.drives[place].unharmed) {
            found.scenarios += 1;
            found.first_unharmed += usize::from(drive.unharmed);
        }
    }
    found
}

/// The table for people.
pub fn words(all: &[Standing]) -> String {
    let names = all
        .iter()
        .map(|one| one.name.chars().count() + if one.is_baseline { 11 } else { 0 });
    let width = names.max().unwrap_or(0).max("planner".len());
    let columns = [
        Left(width),
        Right(5),
        Right(9),
        Right(8),
        Right(10),
        Right(9),
        Left(24),
    ];
    let header = [
        "planner",
        "goal",
        "collision",
        "ran into",
        "rear-ended",
        "serious",
        "collisions to the first, %",
    ];
    let mut out = line("  ", &columns, &header);
    for record in records(all) {
        let name = if record.baseline {
            format!("{} (baseline)", record.planner)
        } else {
            record.planner.clone()
        };
        let percent = |value: f64| format!("{:+.1}", 100.0 * value);
        let difference = match (record.collision_difference, record.collision_interval) {
            (Some(difference), Some((low, high))) => {
                format!(
                    "{} ({} to {})",
                    percent(difference),
                    percent(low),
                    percent(high)
                )
            }
            (Some(difference), None) => percent(difference),
            (None, _) => String::new(),
        };
        let cells = [
            name,
            record.goal.to_string(),
            record.collision.to_string(),
            record.ran_into.to_string(),
            record.rear_ended.to_string(),
            format!("{:.3}", record.p_serious),
            difference,
        ];
        out += &line("  ", &columns, &cells);
    }
    let BeyondBaselines {
        scenarios,
        first_unharmed,
    } = beyond(all);
    let drives = all.first().map_or(0, |first| first.drives.len());
    let of = output::counted(drives, "scenario");
    out + &format!(
        "no baseline solves {scenarios} of {of}; of these, {} solves {first_unharmed}\n",
        all.first().map_or("", |first| &first.name)
    )
}
