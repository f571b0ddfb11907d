//! Tests of which obstacles texts are about.

use super::*;

#[test]
fn a_mention_inside_a_sentence_does_not_change_the_subject() {
    let (a, b) = ids();
    let text = format!(
        "**Obstacle {a} Analysis:**\n\n\
         - **Position and Motion:**\n\
         \x20 - Recent Position: Rear-right of the ego with longitudinal distance of -12.11 m and lateral distance of -0.53 m.\n\
         \x20 - Relative Velocity: Longitudinal: 2.23 m/s toward ego, Lateral: 0.63 m/s toward ego.\n\
         - **Risk:**\n\
         \x20 - **Longitudinal:** The distance is large (-12.11 m), a lower risk compared to Obstacle {b}. It is 9 m.\n\
         \x20 - **TTC:** Longitudinal: |12.11 m| / 2.23 m/s = ~5.43 seconds\n\n\
         **Obstacle {b} Analysis:**\n- Longitudinal distance: 4.5 m"
    );
    let all = brief(&text);
    for claim in [
        format!("{a} gap longitudinal: -12.11 m"),
        format!("{a} gap lateral: -0.53 m"),
        format!("{a} relative velocity longitudinal: 2.23 m/s"),
        format!("{a} relative velocity lateral: 0.63 m/s"),
        format!("{a} TTC longitudinal: 5.43 seconds"),
    ] {
        assert!(all.contains(&claim), "{claim}: {all:#?}");
    }
    let of_b: Vec<_> = all
        .iter()
        .filter(|c| c.starts_with(&b.to_string()))
        .collect();
    assert_eq!(of_b, [&format!("{b} gap longitudinal: 4.5 m")]);
}

#[test]
fn after_an_aside_the_heading_counts_and_where_two_are_meant_nobody() {
    let (a, b) = ids();
    let text = format!(
        "### Obstacle {a}\n- Obstacle {b} is closer.\n- Lateral distance: 3.25 m\n\
         - It cuts in front of the path of obstacle {b}:\n  - Lateral distance: 7 m\n"
    );
    assert_eq!(brief(&text), [format!("{a} gap lateral: 3.25 m")]);
    let text = format!(
        "Obstacle {a} is near. Although it closes in (longitudinal gap 5.5 m), the risk is lower than that of obstacle \
         {b}. The lateral gap is 2 m.\n\nFor obstacle {b} the longitudinal gap is 8.25 m."
    );
    assert_eq!(
        brief(&text),
        [
            format!("{a} gap longitudinal: 5.5 m"),
            format!("{a} gap lateral: 2 m"),
            format!("{b} gap longitudinal: 8.25 m"),
        ]
    );
}

#[test]
fn what_may_mean_something_else_cannot_be_told() {
    let scene = scene();
    let (a, b, window) = cast(&scene);
    let subject = Subject {
        scene: &scene,
        times: TimeOrigin::Recording,
        window: Some(window),
    };
    let (mine, other) = (relation(&scene, a, window.1), relation(&scene, b, window.1));
    assert!((mine.gap_long - other.gap_long).abs() > 1.0);
    let judged = |text: String| checked(&text, &subject).remove(0).judgement;
    let heading = format!(
        "### Obstacle {a}\n- Longitudinal gap: {:.2} m",
        other.gap_long
    );
    assert_eq!(
        judged(heading),
        Judgement::Unknown("true for another obstacle")
    );
    let named = format!("Obstacle {a}: longitudinal gap {:.2} m", other.gap_long);
    assert_eq!(judged(named), Judgement::Wrong, "it says whom it is about");
}
