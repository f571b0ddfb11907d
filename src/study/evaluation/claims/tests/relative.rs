//! Tests of times that are relative to the end of the window.

use super::*;

/// The steps of the claims in a text about window steps up to `now`, with times relative to it or to the recording.
fn steps(text: &str, times: TimeOrigin, window: (i64, i64)) -> Vec<Option<i64>> {
    let scene = scene();
    let subject = Subject {
        scene: &scene,
        times,
        window: Some(window),
    };
    let claims = find(text, &subject);
    claims.into_iter().map(|claim| claim.step).collect()
}

#[test]
fn times_count_back_from_the_end_of_the_window() {
    let scene = scene();
    let (a, _, (_, end)) = cast(&scene);
    let last = end - 20;
    let window = (last - 9, last);
    let of = |text: String| steps(&text, TimeOrigin::WindowEnd, window);
    for (when, step) in [
        ("At t = -0.50 s", last - 5),
        ("At t = 0.00 s", last),
        ("At -0.3 s", last - 3),
        ("0.5 s ago", last - 5),
        ("0.2 s before the end", last - 2),
    ] {
        let text = format!("{when}, obstacle {a} is at a distance of 7.00 m.");
        assert_eq!(of(text), [Some(step)], "{when}");
    }
    let now = format!("Obstacle {a} is now at a distance of 7.00 m.");
    assert_eq!(of(now), [Some(last)]);
    let heading = format!("### t = -0.90 s\n\nObstacle {a} is at a distance of 7.00 m.");
    assert_eq!(of(heading), [Some(last - 9)]);
    // No time of the recording, and none after the window.
    let later = format!("At t = 0.50 s, obstacle {a} is at a distance of 7.00 m.");
    assert_eq!(of(later), []);
    // A step of the reasoning is no time.
    let reasoning = format!("### Step 1: distances\n\nObstacle {a} is at a distance of 7.00 m.");
    assert_eq!(of(reasoning), [None]);
    let contact = format!("Obstacle {a} collides with the ego at t = -0.10 s.");
    assert_eq!(of(contact), [Some(last - 1)]);
}

#[test]
fn answers_to_descriptions_with_absolute_times_are_read_as_before() {
    let scene = scene();
    let (a, _, window) = cast(&scene);
    let of = |text: String| steps(&text, TimeOrigin::Recording, window);
    let text = format!("At t = 0.50 s, obstacle {a} is at a distance of 7.00 m.");
    assert_eq!(of(text), [Some(5)]);
    let text = format!("Obstacle {a} is now at a distance of 7.00 m.");
    assert_eq!(of(text), [None]);
}

#[test]
fn the_messages_tell_what_times_count_from() {
    let scene = scene();
    let window = Window::ending_at(&scene, 20, 5);
    let told = |frame| {
        let options = nearmiss_scene::description::Options {
            obstacle: scene.participants().next().map(|p| p.obstacle.id),
            ..Default::default()
        };
        let text = nearmiss_scene::description::describe(&scene, frame, &window, &options);
        TimeOrigin::of(&serde_json::json!([{ "content": text.unwrap().text }]).to_string())
    };
    use nearmiss_scene::description::Frame;
    for frame in [Frame::Ego, Frame::Metrics, Frame::Cartesian] {
        assert_eq!(told(frame), TimeOrigin::WindowEnd);
    }
    assert_eq!(told(Frame::Trajectory), TimeOrigin::Recording);
    let old = r#"[{"content": "Step 36, t = 3.60 s:"}]"#;
    assert_eq!(TimeOrigin::of(old), TimeOrigin::Recording);
}
