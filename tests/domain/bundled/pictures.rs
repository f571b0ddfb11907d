//! What a picture of a scene shows, and the words beside it.

use nearmiss::description::{Frame, Options, describe as in_frame, picture_moments};
use nearmiss::formats::bundled;
use nearmiss::scenario::{Scene, Window};

#[test]
fn a_picture_has_few_panels_and_always_the_last_step() {
    let entry = &bundled()[0];
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    let scene = Scene::new(scenario, ego);
    let steps = |history, options: &Options| -> Vec<i64> {
        let window = Window::ending_at(&scene, 30, history);
        let moments = picture_moments(&scene, Frame::Picture, &window, options);
        moments.iter().map(|moment| moment.step).collect()
    };
    let usual = Options::default();
    assert_eq!(steps(10, &usual), [22, 24, 26, 28, 30]);
    assert_eq!(steps(1, &usual), [30]);
    let strided = Options { stride: 2, ..usual };
    assert_eq!(steps(21, &strided).len(), 11);
    assert_eq!(steps(31, &strided).len(), 11, "at most eleven");
    let few = Options {
        most_times: Some(3),
        ..usual
    };
    assert_eq!(steps(10, &few), [22, 26, 30]);
}

#[test]
fn the_words_name_the_times_and_everyone_on_it() {
    let entry = &bundled()[0];
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    let scene = Scene::new(scenario, ego);
    let window = Window::ending_at(&scene, 30, 10);
    let options = Options::default();
    let alone = in_frame(&scene, Frame::Picture, &window, &options).unwrap();
    assert!(
        alone
            .text
            .contains("t = -0.80, -0.60, -0.40, -0.20, 0.00 s"),
        "{}",
        alone.text
    );
    assert!(
        !alone.text.contains("red ring"),
        "contact is not told unless it is to be"
    );
    for moment in picture_moments(&scene, Frame::Picture, &window, &options) {
        for id in moment.obstacles {
            assert!(alone.text.contains(&id.to_string()));
        }
    }
    let both = in_frame(&scene, Frame::EgoPicture, &window, &options).unwrap();
    let words = in_frame(&scene, Frame::Ego, &window, &options).unwrap();
    assert!(both.text.starts_with(&words.text));
    let obstacle = scene.participants().next().map(|p| p.obstacle.id);
    let one = Options {
        obstacle,
        radius: 0.5,
        ..options
    };
    let both_of_one = in_frame(&scene, Frame::TrajectoryPicture, &window, &one).unwrap();
    let words_of_one = in_frame(&scene, Frame::Trajectory, &window, &one).unwrap();
    let more = both_of_one
        .text
        .strip_prefix(words_of_one.text.as_str())
        .unwrap();
    for part in [
        "t = 2.20, 2.40, 2.60, 2.80, 3.00 s",
        "only this one, with its id, however far away it is",
        "the x axis of the map points to the right",
    ] {
        assert!(more.contains(part), "{part}: {more}");
    }
    let moments = picture_moments(&scene, Frame::TrajectoryPicture, &window, &one);
    assert!(moments.iter().all(|m| m.obstacles == [obstacle.unwrap()]));
    for span in &both.spans {
        assert!(both.text.get(span.range()).is_some());
    }
}
