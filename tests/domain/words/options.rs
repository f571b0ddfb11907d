//! Options that one frame has: the road, the axes of the ego frame, and the measures.

use std::sync::Arc;

use nearmiss::description::{EgoAxes, Form, Frame, Options, Span, Subject, Value, describe};
use nearmiss::metrics::{Context, MEASURES, MeasureList};
use nearmiss::scenario::{Scene, Window};

use crate::words::{check_spans, scene};

const CUT_IN: &str = "ZAM_CutIn-1_1_T-1";

/// Text and traced numbers, of which the writing is checked.
fn told(scene: &Scene, frame: Frame, options: &Options) -> (String, Vec<Span>) {
    let window = Window::ending_at(scene, 44, 3);
    let described = describe(scene, frame, &window, options).unwrap();
    check_spans(&described);
    (described.text, described.spans)
}

fn real(span: &Span) -> f64 {
    match span.value {
        Value::Real(value) => value,
        Value::Whole(value) => value as f64,
    }
}

#[test]
fn the_road_has_the_lanelets_near_and_few_points() {
    let scene = scene(CUT_IN);
    for form in Form::ALL {
        let usual = Options {
            form,
            ..Options::default()
        };
        let (without, _) = told(&scene, Frame::Cartesian, &usual);
        let road = Options {
            road: true,
            ..usual
        };
        let (text, spans) = told(&scene, Frame::Cartesian, &road);
        assert!(text.starts_with(&without) && text.contains("simplified to within 0.10 m"));
        let under = scene.ego.track.at(44).unwrap().pose.position;
        for id in scene.scenario.network.lanelets_at(&under) {
            let xs = spans
                .iter()
                .filter(|s| s.of == Subject::Lanelet(id) && s.quantity == "x");
            // Three lines of at least two points each, and not all of the map's.
            assert!((6..=36).contains(&xs.count()), "{form:?} {id}");
        }
        let near = Options {
            radius: 0.01,
            ..road
        };
        let (text, _) = told(&scene, Frame::Cartesian, &near);
        assert!(text.len() < without.len() + 2000, "{text}");
    }
}

#[test]
fn along_the_lane_s_and_d_agree_with_the_gaps() {
    let scene = scene(CUT_IN);
    for form in Form::ALL {
        let lane = Options {
            form,
            axes: EgoAxes::Lane,
            ..Options::default()
        };
        let (text, spans) = told(&scene, Frame::Ego, &lane);
        assert!(
            !text.contains("on no lane") && !text.contains("gap lo"),
            "{text}"
        );
        let moves = "Ahead along the lane, it comes nearer; on the right";
        assert_eq!(text.contains(moves), form == Form::Prose, "{text}");
        let of = |quantity: &str, id: i64| {
            let mut all = spans.iter();
            let found = all.find(|s| {
                s.quantity == quantity && s.of == Subject::Obstacle(id) && s.step == Some(44)
            });
            real(found.unwrap())
        };
        // The road bends little, so that s is nearly the offset along the heading.
        let ego = scene.ego.track.at(44).unwrap();
        let other = scene.participants().find(|p| p.obstacle.id == 301).unwrap();
        let offset = other.at(44).unwrap().pose.position - ego.pose.position;
        let (sin, cos) = ego.pose.heading.sin_cos();
        assert!((of("s", 301) - (offset.x * cos + offset.y * sin)).abs() < 0.3);
        let moving = other.at(44).unwrap();
        let turned = (moving.pose.heading - ego.pose.heading).cos();
        let speed = moving.velocity * turned - ego.velocity;
        assert!(
            (of("v_rel_s", 301) - speed).abs() < 0.2,
            "{}",
            of("v_rel_s", 301)
        );
        let mut own = spans.iter();
        let own = own.find(|s| s.quantity == "d" && s.of == Subject::Ego && s.step == Some(44));
        let across = of("d", 301) - real(own.unwrap());
        assert!(
            (across - (offset.y * cos - offset.x * sin)).abs() < 0.6,
            "{across}"
        );
    }
}

#[test]
fn off_the_lanes_the_axes_are_the_heading_and_that_is_said() {
    let whole = scene(CUT_IN);
    let mut scenario = (*whole.scenario).clone();
    scenario.network = nearmiss::scenario::LaneletNetwork::default();
    let bare = Scene::new(Arc::new(scenario), whole.ego.clone());
    for form in Form::ALL {
        let lane = Options {
            form,
            axes: EgoAxes::Lane,
            ..Options::default()
        };
        let (text, spans) = told(&bare, Frame::Ego, &lane);
        let said = "The ego is on no lane: s and d are along and across its heading.";
        assert_eq!(text.matches(said).count(), 3, "{text}");
        assert!(spans.iter().any(|s| s.quantity == "s"));
        let road = Options {
            form,
            road: true,
            ..Options::default()
        };
        let (text, _) = told(&bare, Frame::Cartesian, &road);
        assert!(text.contains("No lanelet lies within 30.00 m of the ego."));
    }
}

#[test]
fn every_measure_can_be_described_and_is_the_registrys() {
    let scene = scene(CUT_IN);
    let window = Window::ending_at(&scene, 44, 3);
    let whole = Context::new(&scene);
    let context = whole.during(&window);
    for chunk in MEASURES.chunks(MeasureList::MOST) {
        let ids = chunk.iter().map(|measure| measure.id);
        let measures = MeasureList::from_ids(ids).unwrap();
        for form in Form::ALL {
            let options = Options {
                form,
                measures: Some(measures),
                ..Options::default()
            };
            let (text, spans) = told(&scene, Frame::Metrics, &options);
            for measure in chunk {
                let (title, name) = (measure.id.replace('_', " "), measure.name);
                assert!(text.contains(&title) || text.contains(name), "{text}");
            }
            for span in &spans {
                let Some(measure) = chunk.iter().find(|m| m.id == span.quantity) else {
                    continue;
                };
                let (Subject::Obstacle(id), Some(step)) = (span.of, span.step) else {
                    continue;
                };
                let mut all = context.participants().iter();
                let place = all.position(|p| p.obstacle.id == id).unwrap();
                let encounter = context.encounter(place, step).unwrap();
                let value = measure.compute(&encounter).value().unwrap();
                let told = real(span);
                assert!(
                    (value - told).abs() < 1e-9 || measure.id == "risk",
                    "{measure:?}"
                );
            }
        }
    }
}
