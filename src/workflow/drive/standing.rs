//! Where planners stand beside each other and beside baselines: outcomes and harm, paired with the first one.

use nearmiss_base::system::counted;
use nearmiss_drive::simulation::{CollisionKind, Outcome, Policy};
use nearmiss_record::Record;
use nearmiss_study::evaluation::statistics::{Interval, PairedTest, if_enough};
use schemars::JsonSchema;
use serde::Serialize;

use super::DrivenScenario;

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

impl DriveFigures {
    /// Whether it ended at the goal or out of time.
    #[must_use]
    pub fn is_unharmed(&self) -> bool {
        self.unharmed
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
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StandingRecord {
    /// The planner.
    #[schemars(title = "planner")]
    pub planner: String,
    /// Whether it drives as a baseline, without being named.
    pub baseline: bool,
    /// Drives that reach the goal.
    #[schemars(title = "goal")]
    pub goal: usize,
    /// Drives that end in a collision.
    #[schemars(title = "collision")]
    pub collision: usize,
    /// Of these, the ego's front into another.
    #[schemars(title = "ran into")]
    pub ran_into: usize,
    /// Of these, another's front into the ego's rear: traffic that follows its recording does not see it brake.
    #[schemars(title = "rear-ended")]
    pub rear_ended: usize,
    /// Drives that end off the road, infeasible or with an error of the planner: they have no collision any more.
    #[schemars(title = "cut short")]
    pub cut_short: usize,
    /// Serious injuries that are expected of its collisions, those without a published curve left out.
    #[schemars(title = "serious injuries (sum)", extend("decimals" = 3))]
    pub p_serious: f64,
    /// Collisions without a published curve.
    #[schemars(title = "not in the sum", extend("rare" = true))]
    pub without_curve: usize,
    /// Its share of collisions minus that of the first planner, paired.
    #[schemars(title = "collisions minus the first's", extend("decimals" = 2))]
    pub collision_difference: Option<f64>,
    /// 95 % interval of that difference.
    pub collision_difference_ci: Option<(f64, f64)>,
    /// Its share of goals minus that of the first planner, paired.
    #[schemars(title = "goals minus the first's", extend("decimals" = 2))]
    pub goal_difference: Option<f64>,
    /// 95 % interval of that difference.
    pub goal_difference_ci: Option<(f64, f64)>,
}

impl Record for StandingRecord {
    const NAME: &'static str = "plan-standing";
    const TITLE: &'static str = "`plan` with several planners: where one stands";
}

/// Scenarios that no baseline solves: lane followers say nothing about these.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub struct BeyondBaselines {
    /// Scenarios in which every baseline ends otherwise than at the goal or out of time, none of them hit from behind.
    pub scenarios: Vec<String>,
    /// Of these, scenarios in which the first planner ends at the goal or out of time.
    pub first_unharmed: usize,
    /// Scenarios that no baseline solves, and in which traffic that does not see one brake runs into it: undecided.
    pub undecided: usize,
}

impl BeyondBaselines {
    /// What a baseline solves of `of` scenarios, and what `first` makes of the others.
    #[must_use]
    pub fn words(&self, of: usize, first: &str) -> String {
        let beyond = self.scenarios.len();
        let solved = of - beyond - self.undecided;
        let mut words = format!("baselines solve {solved} of {}", counted(of, "scenario"));
        if beyond > 0 {
            words += &format!(
                "; none solves {beyond}, of which {first} solves {}",
                self.first_unharmed
            );
        }
        if self.undecided > 0 {
            words += &format!(
                "; {} undecided: traffic that sees nothing runs into a baseline from behind",
                self.undecided
            );
        }
        words
    }
}

/// The interval of a test, where it tells something: of at least 10 scenarios, and wider than nothing, as the bootstrap
/// cannot vary what is the same everywhere.
#[must_use]
pub fn telling(test: &PairedTest, scenarios: usize) -> Option<Interval> {
    let enough = u32::try_from(scenarios).unwrap_or(u32::MAX);
    if_enough(test.interval, enough).filter(|interval| interval.low < interval.high)
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
    let interval = test
        .as_ref()
        .and_then(|test| telling(test, differences.len()));
    (
        test.map(|test| 0.0 - test.difference),
        interval.map(|i| (0.0 - i.high, 0.0 - i.low)),
    )
}

/// Where all stand; the first is what the others are compared with.
#[must_use]
pub fn standings(all: &[Standing]) -> Vec<StandingRecord> {
    let record = |(place, one): (usize, &Standing)| {
        let count =
            |figure: fn(&DriveFigures) -> bool| one.drives.iter().filter(|d| figure(d)).count();
        let paired = |figure| match place {
            0 => (None, None),
            _ => difference(one, &all[0], figure),
        };
        let (collision_difference, collision_difference_ci) = paired(|d| d.is_collision);
        let (goal_difference, goal_difference_ci) = paired(|d| d.is_goal);
        StandingRecord {
            planner: one.name.clone(),
            baseline: one.is_baseline,
            goal: count(|d| d.is_goal),
            collision: count(|d| d.is_collision),
            ran_into: count(|d| d.ran_into),
            rear_ended: count(|d| d.rear_ended),
            cut_short: count(|d| !d.unharmed && !d.is_collision),
            // An empty sum is -0.
            p_serious: one.drives.iter().filter_map(|d| d.harm).sum::<f64>() + 0.0,
            without_curve: count(|d| d.harm.is_none()),
            collision_difference,
            collision_difference_ci,
            goal_difference,
            goal_difference_ci,
        }
    };
    all.iter().enumerate().map(record).collect()
}

/// Scenarios that no baseline solves, and what the first planner makes of them; `scenarios` has their names.
#[must_use]
pub fn beyond_baselines(all: &[Standing], scenarios: &[String]) -> BeyondBaselines {
    let is_baseline = |one: &&Standing| Policy::BASELINES.iter().any(|p| p.name() == one.name);
    let baselines: Vec<&Standing> = all.iter().filter(is_baseline).collect();
    let mut found = BeyondBaselines::default();
    let drives = all.first().map_or(&[][..], |first| &first.drives);
    for (place, (drive, scenario)) in drives.iter().zip(scenarios).enumerate() {
        let ends = || baselines.iter().map(|one| &one.drives[place]);
        if ends().any(|end| end.unharmed) {
            continue;
        }
        if ends().any(|end| end.rear_ended) {
            found.undecided += 1;
        } else {
            found.scenarios.push(scenario.clone());
            found.first_unharmed += usize::from(drive.unharmed);
        }
    }
    found
}
