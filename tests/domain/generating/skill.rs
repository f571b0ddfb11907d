//! A model of middling skill: its waypoints are off by up to 10 %, and it errs less when it is told what came of them.

use std::sync::Mutex;

use serde_json::{Value, json};

use super::bench::{ATTACKER, Written, driven, on_ground, scene, through, written_by};

/// Numbers from -1 to 1 that look like chance (Numerical Recipes' linear congruential generator).
fn chance(seed: &mut u32) -> f64 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    f64::from(*seed >> 8) / f64::from(1_u32 << 23) - 1.0
}

/// Waypoints whose displacements, turns and speeds are off by up to a share.
fn off(points: &Value, share: f64, mut seed: u32) -> Value {
    let points = points.as_array().unwrap();
    let number = |point: &Value, key: &str| point[key].as_f64().unwrap();
    let mut written = vec![points[0].clone()];
    for pair in points.windows(2) {
        let before = written.last().unwrap().clone();
        let mut next = pair[1].clone();
        let stretched = 1.0 + share * chance(&mut seed);
        for key in ["x", "y"] {
            let moved = (number(&pair[1], key) - number(&pair[0], key)) * stretched;
            next[key] = json!(((number(&before, key) + moved) * 100.0).round() / 100.0);
        }
        let turned = number(&pair[1], "heading") - number(&pair[0], "heading");
        let turned = turned * (1.0 + share * chance(&mut seed));
        next["heading"] = json!(((number(&before, "heading") + turned) * 1000.0).round() / 1000.0);
        let speed = number(&pair[1], "velocity") * (1.0 + share * chance(&mut seed));
        next["velocity"] = json!((speed * 100.0).round() / 100.0);
        written.push(next);
    }
    written.into()
}

/// Six conversations with it.
async fn asked(feedback: bool) -> Written {
    let (plan, begun) = (driven(2), Mutex::new(Vec::<String>::new()));
    let answering = move |_: usize, request: &super::support::server::Recorded| {
        let body = request.json();
        let messages = body["messages"].as_array().unwrap();
        let turns = (messages.len() - 2) / 2;
        let mut begun = begun.lock().unwrap();
        // A conversation is known by its first answer.
        let known = messages.get(2).and_then(|m| m["content"].as_str());
        let which = known
            .and_then(|first| begun.iter().position(|one| one == first))
            .unwrap_or(begun.len());
        let share = 0.1 * 0.5_f64.powi(turns as i32);
        let points = off(&plan, share, 7 + 31 * which as u32 + turns as u32);
        if turns == 0 {
            let answer = json!({
                "obstacle": ATTACKER, "waypoints": points, "manoeuvre": null, "justification": "It leaves no room.",
            });
            begun.push(answer.to_string());
        }
        Some(through(ATTACKER, &points))
    };
    let mut asked = written_by(answering, |author| {
        author.attacker = Some(ATTACKER);
        author.method.samples = 6;
        author.method.feedback = feedback;
    })
    .await;
    let authored = asked.outcome.as_mut().unwrap();
    on_ground(&scene(), |ground| {
        assert!(authored.drive_watched(ground, 0.5, &mut |_| true));
    });
    asked
}

#[tokio::test]
async fn retries_and_the_outcome_of_the_drive_make_a_middling_model_effective() {
    let (before, after) = (asked(false).await, asked(true).await);
    let (before, after) = (before.authored().tries(), after.authored().tries());
    println!("without the outcome of the drive {before:?}, with it {after:?}");
    assert_eq!((before.conversations, after.conversations), (6, 6));
    // The first answers are the same.
    assert_eq!(before.first_admitted, after.first_admitted);
    assert!(after.first_effective < after.effective, "{after:?}");
    assert!(after.effective >= before.effective, "{before:?} {after:?}");
}
