//! Times mentioned in a text, and the steps they denote.

use super::find::{MentionContext, ends_with_word};
use super::number::{Number, Unit, numbers};
use super::place::has_word;

/// The time that a text speaks of.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum MentionedTime {
    #[default]
    Unsaid,
    Step(i64),
    /// Several times, or one that is no time step.
    Unclear,
}

/// Which numbers are times, and the step that they name.
pub fn times(
    lower: &str,
    all: &[Number],
    world: &MentionContext<'_>,
) -> (Vec<usize>, MentionedTime) {
    let mut places = Vec::new();
    let mut when = MentionedTime::Unsaid;
    for (place, number) in all.iter().enumerate() {
        let before =
            lower[..number.span.start].trim_end_matches(['*', ' ', '`', ':', '=', '(', '~', '"']);
        let counted = ["step", "timestep", "time_step", "steps"]
            .iter()
            .any(|word| ends_with_word(before, word));
        // "- 4.8 s: longitudinal 3.75 m"
        let leads = before.chars().all(|c| !c.is_alphanumeric())
            && lower[number.span.end..].starts_with(':');
        let timed = counted
            || leads
            || ["at", "t", "time", "at around", "at about", "by"]
                .iter()
                .any(|word| ends_with_word(before, word));
        let named = match number.unit {
            Unit::Second if timed => step_at(number.value, world),
            Unit::None if counted && number.decimals == 0 => {
                number.whole().filter(|s| world.steps.contains(s))
            }
            Unit::None if counted => step_at(number.value, world),
            _ => continue,
        };
        places.push(place);
        when = match (when, named) {
            (MentionedTime::Unsaid, Some(step)) => MentionedTime::Step(step),
            (MentionedTime::Step(now), Some(step)) if now == step => when,
            _ => MentionedTime::Unclear,
        };
    }
    (places, when)
}

/// The time that a heading sets for what stands under it; `now` is that of the heading before.
pub fn heading_time(
    lower: &str,
    line: &str,
    world: &MentionContext<'_>,
    now: MentionedTime,
) -> MentionedTime {
    let all = numbers(line);
    let (_, when) = times(lower, &all, world);
    let seconds: Vec<&Number> = all.iter().filter(|n| n.unit == Unit::Second).collect();
    match when {
        // "timestep 6.5s - 7.3s", "timesteps 3 to 9"
        _ if seconds.len() > 1 || has_word(lower, "timesteps") => MentionedTime::Unclear,
        MentionedTime::Unsaid if lower.contains("step") => match seconds.as_slice() {
            // "most recent timestep (0.9 seconds)"
            [one] => step_at(one.value, world).map_or(MentionedTime::Unclear, MentionedTime::Step),
            _ if ["summary", "conclusion"]
                .iter()
                .any(|word| lower.contains(word)) =>
            {
                MentionedTime::Unsaid
            }
            _ => now,
        },
        MentionedTime::Unsaid
            if ["summary", "conclusion", "json"]
                .iter()
                .any(|word| lower.contains(word)) =>
        {
            MentionedTime::Unsaid
        }
        MentionedTime::Unsaid => now,
        said => said,
    }
}

/// The step at a time, seconds; nothing between steps and outside the recording.
fn step_at(seconds: f64, world: &MentionContext<'_>) -> Option<i64> {
    let step = (seconds / world.dt).round();
    let near = (step * world.dt - seconds).abs() < 0.1 * world.dt;
    Some(step as i64).filter(|s| near && world.steps.contains(s))
}
