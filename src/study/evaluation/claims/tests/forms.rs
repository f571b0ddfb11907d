//! Further forms of claims: without a number, without a unit, in formulas, of several obstacles, under subheadings.

use super::*;

#[test]
fn a_formula_has_its_result_as_a_claim() {
    let (a, _) = ids();
    let text = format!(
        "#### Obstacle {a}:\n- **TTC Calculations:**\n  - Calculated TTC for longitudinal approach: \\(1.24 \\, \\text{{m}} / 7.46 \\, \\text{{m/s}} \\approx 0.17 \\, \\text{{seconds}}\\)."
    );
    let found = found(&text);
    let said: Vec<(i64, Quantity)> = found.iter().map(|claim| (claim.0, claim.1)).collect();
    assert!(said.contains(&(a, Quantity::TtcLong)), "{found:?}");
    assert!(said.contains(&(a, Quantity::GapLong)), "{found:?}");
}

#[test]
fn a_named_quantity_needs_no_unit_and_a_direction_no_word_relative() {
    let (a, _) = ids();
    for (text, claims) in [
        (
            format!("Obstacle {a} has a velocity of 8.34 and an acceleration (1.25)."),
            vec![
                format!("{a} speed: 8.34"),
                format!("{a} acceleration: 1.25"),
            ],
        ),
        (
            format!("Obstacle {a}: DTClat is 0.0, DTClong is 4.2m."),
            vec![
                format!("{a} gap lateral: 0.0"),
                format!("{a} gap longitudinal: 4.2m"),
            ],
        ),
        (
            format!("Obstacle {a}: Velocities: longitudinal -2.90m/s, lateral 0.10m/s"),
            vec![
                format!("{a} relative velocity longitudinal: -2.90m/s"),
                format!("{a} relative velocity lateral: 0.10m/s"),
            ],
        ),
        (
            format!("Obstacle {a}: Relative velocity: 0m/s in both dimensions"),
            vec![
                format!("{a} relative velocity longitudinal: 0m/s"),
                format!("{a} relative velocity lateral: 0m/s"),
            ],
        ),
        (
            format!("Obstacle {a} is approaching from behind at 3.20 m longitudinally."),
            vec![
                format!("{a} motion: approaching"),
                format!("{a} direction: behind"),
                format!("{a} gap longitudinal: 3.20 m"),
            ],
        ),
    ] {
        assert_eq!(brief(&text), claims, "{text}");
    }
}

#[test]
fn a_speed_at_which_it_drives_is_its_own() {
    let (a, _) = ids();
    for (text, claims) in [
        (
            format!("Obstacle {a} drives at 2.0 m/s."),
            vec![format!("{a} speed: 2.0 m/s")],
        ),
        (
            format!("Obstacle {a} closes in at 2.0 m/s."),
            vec![
                format!("{a} motion: closes in"),
                format!("{a} closing speed: 2.0 m/s"),
            ],
        ),
        (
            format!("Obstacle {a} drives towards the ego at 2.0 m/s."),
            vec![format!("{a} motion: drives towards the ego")],
        ),
    ] {
        assert_eq!(brief(&text), claims, "{text}");
    }
}

#[test]
fn a_length_away_or_from_the_ego_is_the_distance() {
    let (a, b) = ids();
    for (text, claims) in [
        (
            format!("Obstacle {a} is 99.0 m away."),
            vec![format!("{a} distance: 99.0 m")],
        ),
        (
            format!("Obstacle {a} is 18.6 m from the ego at t = 0.00 s."),
            vec![format!("{a} distance: 18.6 m @0")],
        ),
        (
            format!("Obstacle {a} drives ahead, 9.00 m away and a little faster than the ego."),
            vec![format!("{a} distance: 9.00 m")],
        ),
        (
            format!("The distance between the ego and car {a} is 18.6 m."),
            vec![format!("{a} distance: 18.6 m")],
        ),
        (
            format!("The gap between car {a} and the ego is 18.6 m at t = 0.00 s."),
            vec![format!("{a} distance: 18.6 m @0")],
        ),
        (
            format!("The distance between the ego and car {a} is between 3.0 and 5.0 m."),
            vec![format!("{a} distance: 5.0 m")],
        ),
        (
            format!("The distance between {b} and {a} is 3.0 m."),
            vec![],
        ),
        (
            format!("Car {a} is 5.98 m away from the ego. The distance to car {b} is 2.43 m."),
            vec![
                format!("{a} distance: 5.98 m"),
                format!("{b} distance: 2.43 m"),
            ],
        ),
        (
            format!("The smallest distance is 2.43 m to car {b}."),
            vec![
                format!("{b} comparison: smallest distance"),
                format!("{b} minimum distance: 2.43 m"),
            ],
        ),
        (format!("Obstacle {a} is 3.0 m away from the kerb."), vec![]),
        (format!("Obstacle {a} is 3.0 m away from {b}."), vec![]),
        (
            format!("Obstacle {a} stops 3.0 m from the ego's front."),
            vec![],
        ),
    ] {
        let distances: Vec<String> = brief(&text)
            .into_iter()
            .filter(|claim| claim.contains("distance"))
            .collect();
        assert_eq!(distances, claims, "{text}");
    }
}

#[test]
fn places_in_brackets_both_axes_and_lists_of_obstacles() {
    let (a, b) = ids();
    for (text, claims) in [
        (
            format!("**Obstacle {a} (Behind):**"),
            vec![format!("{a} direction: Behind")],
        ),
        (
            format!(
                "Obstacle {a} is primarily behind and slightly to the left of the ego vehicle."
            ),
            vec![format!(
                "{a} direction: behind and slightly to the left of the ego vehicle"
            )],
        ),
        (
            format!("Obstacle {a} is in front of the ego vehicle, moving closer."),
            vec![
                format!("{a} direction: in front of the ego vehicle"),
                format!("{a} motion: moving closer"),
            ],
        ),
        (
            format!("Obstacles {a} and {b} are behind the ego vehicle."),
            vec![
                format!("{a} direction: behind the ego vehicle"),
                format!("{b} direction: behind the ego vehicle"),
            ],
        ),
        (
            format!("Obstacle {a} is approaching from behind the ego."),
            vec![
                format!("{a} motion: approaching"),
                format!("{a} direction: behind the ego"),
            ],
        ),
    ] {
        assert_eq!(brief(&text), claims, "{text}");
    }
}

#[test]
fn a_subheading_keeps_the_obstacle_of_the_heading_above_and_a_summary_does_not() {
    let (a, b) = ids();
    let text = format!(
        "### Obstacle {a}\n**Calculations:**\n- The distance is 3.2 m.\n**Summary:**\n- The distance is 9.9 m.\n\nObstacle {b} is far."
    );
    assert_eq!(brief(&text), [format!("{a} distance: 3.2 m")]);
}

#[test]
fn a_standstill_and_a_contact_are_held_against_the_geometry() {
    let scene = scene();
    let (a, _, window) = cast(&scene);
    let subject = Subject::new(&scene, TimeOrigin::Recording, Some(window));
    for text in [
        format!("Obstacle {a} is stationary."),
        format!("Obstacle {a} has collided with the ego vehicle."),
    ] {
        let all = checked(&text, &subject);
        assert_eq!(all.len(), 1, "{text}: {all:?}");
        assert_eq!(all[0].judgement, Judgement::Wrong, "{text}: {all:?}");
    }
    let counts = count("", &format!("Obstacle {a} is stationary."), &subject);
    assert_eq!(counts.known(), Some([0, 1, 0]));
    assert_eq!(count("", "", &subject).known(), Some([0, 0, 0]));
}
