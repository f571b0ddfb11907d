//! What came of a motion or of a refused answer, what is to be better, and both in words to the model.

use std::fmt::Write as _;

use nearmiss_base::geometry::Footprint;
use nearmiss_drive::generation::{
    Attack, AttackSetup, Consequence, Effect, NEAR_MISS, Refusal, summarize,
};
use nearmiss_scene::scenario::{Motion, Scenario, Track};

/// Where two bodies are nearest to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// The first step of it.
    pub step: i64,
    /// Metres between the bodies.
    pub distance: f64,
}

/// Where an obstacle is nearest to an ego from a step on; `None` where the two are never there together.
#[must_use]
pub fn nearest(
    scenario: &Scenario,
    obstacle: i64,
    (body, ego): (&Footprint, &Track),
    from: i64,
) -> Option<Nearest> {
    let obstacle = scenario.obstacle(obstacle)?;
    let together = ego.iter().filter(|(step, _)| *step >= from);
    let apart = together.filter_map(|(step, motion)| {
        let there = obstacle.placed_at(step)?;
        Some(Nearest {
            step,
            distance: body.at(motion.pose).distance(&there),
        })
    });
    apart.min_by(|a, b| a.distance.total_cmp(&b.distance))
}

/// What differs less from the drive without the attack is no answer to it, metres and m/s.
const ASIDE: f64 = 0.2;
const FASTER: f64 = 0.3;

/// Rows of the ego's drive that are told, at most, and the time between two of them, seconds.
const ROWS: usize = 16;
const APART: f64 = 0.5;

/// The drive goes on in the table for so long after the two are nearest, seconds.
const AFTER: f64 = 1.0;

/// Whether a motion is what is wanted: it has an effect, and an ideal driver survives it.
pub(super) fn is_wanted(attack: &Attack) -> bool {
    attack.has_effect() && attack.survivable == Some(true)
}

/// What is told to the model about the drive against its motion.
pub(super) fn driven(ground: &AttackSetup<'_>, attack: &Attack, delay: f64) -> String {
    let Some(effect) = &attack.effect else {
        return "The motion passes all checks, but the ego cannot be driven against it.\n".into();
    };
    let stage = ground.stage;
    let dt = stage.dt();
    let at = |step: i64| format!("t = {:.2} s (step {step})", step as f64 * dt);
    let track = effect.drive.track();
    let near = nearest(
        &effect.scenario,
        effect.main().obstacle,
        (stage.footprint, &track),
        effect.from,
    );
    let mut words = String::from(
        "The motion passes all checks, and the ego was driven against it; it is not yet the encounter that is wanted.\n",
    );
    let mut line = |text: String| {
        let _ = writeln!(words, "- {text}");
    };
    line(reaction(&track, stage.ego, effect.from, &at));
    if let Some(near) = near {
        line(format!(
            "The smallest distance between the two bodies was {:.2} m, at {}{}.",
            near.distance,
            at(near.step),
            where_it_was(effect, &track, near.step)
        ));
    }
    if let Some(score) = effect.lowest_after() {
        line(format!(
            "The lowest risk score of the attacker was {score}; {NEAR_MISS} or below is wanted."
        ));
    }
    line(verdict(attack, effect, delay, &at));
    words.push_str(&table(&track, effect.from, near, dt));
    words
}

/// What the ego did otherwise than without the attack.
fn reaction(track: &Track, before: &Track, from: i64, at: &dyn Fn(i64) -> String) -> String {
    let pairs: Vec<(i64, &Motion, &Motion)> = track
        .iter()
        .filter(|(step, _)| *step >= from)
        .filter_map(|(step, now)| Some((step, now, before.at(step)?)))
        .collect();
    let aside = |now: &Motion, then: &Motion| then.pose.to_local(&now.pose.position).y;
    let differs = |(_, now, then): &&(i64, &Motion, &Motion)| {
        (now.velocity - then.velocity).abs() > FASTER || aside(now, then).abs() > ASIDE
    };
    let Some((began, ..)) = pairs.iter().find(differs) else {
        return "The ego drove as it did without the attack: it had no reason to react.".into();
    };
    let mut said = format!("The ego answered from {} on", at(*began));
    let slower = pairs
        .iter()
        .max_by(|a, b| (a.2.velocity - a.1.velocity).total_cmp(&(b.2.velocity - b.1.velocity)));
    if let Some((step, now, then)) =
        slower.filter(|(_, now, then)| then.velocity - now.velocity > FASTER)
    {
        let _ = write!(
            said,
            "; it slowed down to {:.2} m/s at {} (without the attack {:.2} m/s)",
            now.velocity,
            at(*step),
            then.velocity
        );
    }
    let side = |pair: &&(i64, &Motion, &Motion)| aside(pair.1, pair.2).abs();
    let off = pairs.iter().max_by(|a, b| side(a).total_cmp(&side(b)));
    if let Some((step, now, then)) = off.filter(|pair| side(pair) > ASIDE) {
        let off = aside(now, then);
        let left = if off > 0.0 { "left" } else { "right" };
        let _ = write!(
            said,
            "; it moved {:.2} m to the {left} of its way by {}",
            off.abs(),
            at(*step)
        );
    }
    said + "."
}

/// Where the attacker was to the ego at a step.
fn where_it_was(effect: &Effect, track: &Track, step: i64) -> String {
    let attacker = effect.scenario.obstacle(effect.main().obstacle);
    let there = attacker.and_then(|attacker| attacker.track().at(step).copied());
    let (Some(there), Some(ego)) = (there, track.at(step)) else {
        return String::new();
    };
    let local = ego.pose.to_local(&there.pose.position);
    let (ahead, left) = (local.x, local.y);
    let along = if ahead < 0.0 { "behind" } else { "ahead of" };
    let side = if left < 0.0 { "right" } else { "left" };
    format!(
        ", where the attacker's centre was {:.2} m {along} the ego's and {:.2} m to the {side}, at {:.2} m/s, the ego at {:.2} m/s",
        ahead.abs(),
        left.abs(),
        there.velocity,
        ego.velocity
    )
}

/// Why that is not what is wanted, and what would be better.
fn verdict(attack: &Attack, effect: &Effect, delay: f64, at: &dyn Fn(i64) -> String) -> String {
    if let Consequence::PlannerError(error) = effect.consequence {
        return format!(
            "The ego's planner failed at {}, so nothing is known of the ego. Try another motion.",
            at(error.step)
        );
    }
    let nothing = effect.consequence == Consequence::NoEffect;
    match effect.contact.filter(|_| nothing) {
        Some(collision) if effect.is_hit_from_behind() => format!(
            "Obstacle {} ran into the ego from behind at {}, which is no test of the ego. Meet it from the front or the side.",
            collision.with,
            at(collision.step)
        ),
        Some(collision) => format!(
            "The ego touched obstacle {} at {}, and not the attacker.",
            collision.with,
            at(collision.step)
        ),
        None if attack.has_effect() => {
            let what = match effect.consequence {
                Consequence::Collision(collision) => format!("The ego was touched at {}", at(collision.step)),
                _ => "That is a near miss".into(),
            };
            format!(
                "{what}, but no manoeuvre was found with which even a good driver, reacting {delay} s after the motion departs from the recorded one, avoids contact. Leave a little more time or room."
            )
        }
        None => "The ego avoided the danger. Leave it less time or room: be nearer, be in its way earlier, or let it see the danger later, within the limits.".into(),
    }
}

/// The ego's drive, so that the next motion can aim at it.
fn table(track: &Track, from: i64, near: Option<Nearest>, dt: f64) -> String {
    let apart = ((APART / dt).round() as i64).max(1);
    let last = near.map_or(i64::MAX, |near| near.step + (AFTER / dt).round() as i64);
    let rows: Vec<(i64, &Motion)> = track
        .iter()
        .filter(|(step, _)| *step >= from && *step <= last && (*step - from) % apart == 0)
        .collect();
    let kept = &rows[rows.len().saturating_sub(ROWS)..];
    if kept.is_empty() {
        return String::new();
    }
    let mut text = String::from(
        "\nThe ego's drive against this motion:\nstep,t [s],x [m],y [m],heading [rad],v [m/s]\n",
    );
    for (step, motion) in kept {
        let place = motion.pose.position;
        let _ = writeln!(
            text,
            "{step},{:.2},{:.2},{:.2},{:.3},{:.2}",
            *step as f64 * dt,
            place.x,
            place.y,
            motion.pose.heading,
            motion.velocity
        );
    }
    text
}

/// Most kinds of reasons that are told.
const MAX_REFUSALS: usize = 12;

/// Most characters of an answer that are sent back with the reasons: who rambled is not to pay for it twice.
pub(super) const ANSWER: usize = 8000;

/// The reasons, and the renewed request. `start` is the recorded state of the obstacle at a step.
pub(super) fn refused(attacker: i64, refusals: &[Refusal], start: Option<(i64, Motion)>) -> String {
    let mut words = String::from("This motion cannot be used:\n");
    let all = summarize(refusals);
    for one in all.iter().take(MAX_REFUSALS) {
        words.push_str(&format!("- {one}\n"));
    }
    if all.len() > MAX_REFUSALS {
        words.push_str(&format!(
            "- and {} more reasons\n",
            all.len() - MAX_REFUSALS
        ));
    }
    words.push_str(&again(attacker, "to which none of this applies", start));
    words
}

/// What came of the drive, and the renewed request.
pub(super) fn not_wanted(attacker: i64, drive: &str, start: Option<(i64, Motion)>) -> String {
    let again = again(
        attacker,
        "that is better and still keeps every limit",
        start,
    );
    format!("{drive}{again}")
}

fn again(attacker: i64, motion: &str, start: Option<(i64, Motion)>) -> String {
    let mut words = format!(
        "\nGive the whole answer again for obstacle {attacker}, in the same form, with a motion {motion}."
    );
    if let Some((step, motion)) = start {
        let at = motion.pose.position;
        words.push_str(&format!(
            " At step {step} the obstacle is recorded at ({:.2}, {:.2}) m with heading {:.3} rad and velocity {:.2} m/s.",
            at.x, at.y, motion.pose.heading, motion.velocity
        ));
    }
    words
}

/// The answer as it is sent back.
pub(super) fn shortened(answer: &str) -> String {
    match answer.char_indices().nth(ANSWER) {
        Some((end, _)) => format!("{} …", &answer[..end]),
        None => answer.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_drive::generation::Reason;

    #[test]
    fn the_gate_is_quoted_and_ramblings_are_cut() {
        let refusal = Refusal::at(7, Reason::Jump).with(10.7, 2.5);
        let words = refused(12, &[refusal], None);
        assert!(words.contains("- step 7: jump 10.7000 m, at most 2.5000\n"));
        assert!(words.contains("for obstacle 12,"));
        let long = "ä".repeat(ANSWER + 1);
        assert_eq!(shortened(&long).chars().count(), ANSWER + 2);
        assert_eq!(shortened("no"), "no");
    }
}
