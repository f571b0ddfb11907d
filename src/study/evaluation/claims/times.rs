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
        let after = &lower[number.span.end..];
        // "- 4.8 s: longitudinal 3.75 m"
        let leads = before.chars().all(|c| !c.is_alphanumeric()) && after.starts_with(':');
        let ago = world.now.is_some() && is_ago(after);
        let timed = counted
            || leads
            || ago
            || ["at", "t", "time", "at around", "at about", "by"]
                .iter()
                .any(|word| ends_with_word(before, word));
        let named = match number.unit {
            Unit::Second if ago => step_at(-number.value.abs(), world),
            Unit::Second if timed => step_at(number.value, world),
            // "Step 1" of an answer that was told no time steps is one of its reasoning.
            Unit::None if world.now.is_some() && number.decimals == 0 => continue,
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
    if when == MentionedTime::Unsaid
        && let Some(now) = world.now
        && has_word(lower, "now")
    {
        let elsewhere = ["until now", "from now", "up to now", "by now"];
        when = if elsewhere.iter().any(|words| lower.contains(words)) {
            MentionedTime::Unclear
        } else {
            MentionedTime::Step(now)
        };
    }
    (places, when)
}

/// Whether the words behind a number of seconds say that it lies so long in the past: "0.5 s ago".
fn is_ago(after: &str) -> bool {
    let after = after.trim_start_matches(['*', ' ', '`', ')']);
    ["ago", "before now", "before the end", "before the present"]
        .iter()
        .any(|words| {
            let rest = after.strip_prefix(words);
            rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        })
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

/// The step at a time, seconds; nothing between steps, outside the recording, and after what was described.
fn step_at(seconds: f64, world: &MentionContext<'_>) -> Option<i64> {
    let steps = (seconds / world.dt).round();
    let near = (steps * world.dt - seconds).abs() < 0.1 * world.dt;
    let step = (steps as i64).saturating_add(world.now.unwrap_or(0));
    let told = world.now.is_none_or(|now| step <= now);
    Some(step).filter(|s| near && told && world.steps.contains(s))
}
