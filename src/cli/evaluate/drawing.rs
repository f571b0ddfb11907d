//! Shows progress while the windows of a batch are drawn, for which all recordings are read.

use super::truth::say_each;
use crate::progress::LateProgress;
use crate::{Failure, output};
use nearmiss_drive::planner::Cancel;
use nearmiss_workflow::batch::{BatchError, BatchPlan, PlanningEvent};

/// Plans a batch, then says what is doubtful about its truth and which scenarios are left out.
pub fn planned(
    plan: impl FnOnce(&Cancel, &mut dyn FnMut(PlanningEvent)) -> Result<Option<BatchPlan>, BatchError>,
) -> Result<BatchPlan, Failure> {
    let progress = LateProgress::new("recordings read");
    let mut shown = 0;
    let plan = plan(
        &Cancel::default(),
        &mut |PlanningEvent::Read { done, of }| {
            (shown..done).for_each(|_| progress.step(of));
            shown = done;
        },
    );
    drop(progress);
    // Nothing cancels it: Ctrl-C ends the program.
    let plan = plan
        .map_err(Failure::input)?
        .ok_or_else(|| Failure::interrupted(""))?;
    say_each(&plan.doubts);
    if let Some(words) = &plan.left_out {
        output::say(&format!("nearmiss: {words}"));
    }
    Ok(plan)
}
