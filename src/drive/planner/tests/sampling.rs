//! Tests that profiles, offsets and samples begin and end where they should.

use super::guide;
use crate::planner::pace::Pace;
use crate::planner::profile::{Lateral, Profile};
use crate::planner::settings::{Level, Sampler, start};
use crate::planner::{Body, Polynomial, Settings, Traffic};
use nearmiss_base::geometry::{Footprint, Shape};

fn near(a: [f64; 3], b: [f64; 3]) {
    for (a, b) in a.into_iter().zip(b) {
        assert!((a - b).abs() < 1e-8 * (1.0 + b.abs()), "{a} for {b}");
    }
}

#[test]
fn a_profile_keeps_its_final_speed() {
    let from = [40.0, 12.0, -1.0];
    let along = Polynomial::quartic(from, [6.0, 0.0], 3.0);
    let profile = Profile::new(along, 3.0, 0.0);
    near(profile.at(0.0), from);
    let [end, v, a] = profile.at(3.0);
    assert!((v - 6.0).abs() < 1e-9 && a.abs() < 1e-9);
    near(profile.at(5.0), [end + 12.0, 6.0, 0.0]);
    // Later, the same way goes on.
    let later = Profile::new(along, 3.0, 0.7);
    for t in [0.0, 1.0, 2.3, 4.0] {
        near(later.at(t), profile.at(t + 0.7));
    }
}

#[test]
fn a_profile_that_reverses_is_not_laid_out() {
    let (guide, dt) = guide("HardBraking");
    let from = [guide.start, 5.0, 0.0];
    let mut stations = Vec::new();
    let stop = Profile::new(Polynomial::quartic(from, [0.0, 0.0], 3.0), 3.0, 0.0);
    let pace = Pace {
        wanted: 8.0,
        bends: &guide.bends,
        legal: None,
        stop: None,
        centre: 0.0,
        now: 5.0,
    };
    let stop = stop.lay(&guide.path, &pace, 40, dt, &mut stations).unwrap();
    assert_eq!(stations.len(), 41);
    assert!(stop.slowest >= 0.0 && stop.slowest < 1e-9);
    for (i, station) in stations.iter().enumerate() {
        let at = guide.path.at(station.s[0]);
        near(station.s, stop.at(i as f64 * dt));
        assert!((station.position - at.position).norm() < 1e-9);
    }
    let back = Polynomial::quintic(from, [guide.start + 1.0, 0.0, 0.0], 3.0);
    let back = Profile::new(back, 3.0, 0.0).lay(&guide.path, &pace, 40, dt, &mut stations);
    assert_eq!((back, stations.len()), (None, 41));
}

#[test]
fn offsets_go_on_from_the_present_and_end_at_the_target() {
    let by_length = [0.4, 0.05, -0.01];
    let along = [100.0, 14.0, -2.0];
    let start = start(by_length, along);
    let over_time = Lateral::over_time(&start, -1.5, 2.0);
    let over_length = Lateral::over_length(&start, -1.5, along[0], 20.0);
    near(over_time.at(0.0, along), by_length);
    near(over_length.at(0.0, along), by_length);
    for lateral in [over_time, over_length] {
        assert_eq!(lateral.at(1e3, [1e5, 5.0, 0.0])[0], -1.5);
        near(lateral.at(2.0, [120.0, 10.0, 0.0]), [-1.5, 0.0, 0.0]);
        near(lateral.at(9.0, [300.0, 10.0, 0.0]), [-1.5, 0.0, 0.0]);
    }
    // Just before the end there is no jump.
    let close = |a: [f64; 3]| {
        near(
            [a[0], a[1], 0.0].map(|x| (x * 1e3).round() / 1e3),
            [-1.5, 0.0, 0.0],
        )
    };
    close(over_time.at(2.0 - 1e-4, [120.0, 10.0, 0.0]));
    close(over_length.at(0.0, [120.0 - 1e-3, 10.0, 0.0]));
}

#[test]
fn an_offset_goes_on_later_as_it_was() {
    let along = |t: f64| [100.0 + 14.0 * t - t * t, 14.0 - 2.0 * t, -2.0];
    let start = start([0.4, 0.05, -0.01], along(0.0));
    for lateral in [
        Lateral::over_time(&start, 1.0, 3.0),
        Lateral::over_length(&start, 1.0, 100.0, 35.0),
    ] {
        let later = lateral.later(0.8);
        for t in [0.0, 0.5, 1.7] {
            near(
                later.at(t, along(t + 0.8)),
                lateral.at(t + 0.8, along(t + 0.8)),
            );
        }
        assert!(later.squared_jerk(4.0, 14.0) >= 0.0);
    }
}

#[test]
fn whoever_stands_does_not_move_sideways() {
    let start = start([0.5, 0.0, 0.0], [100.0, 0.0, 0.0]);
    let lateral = Lateral::over_length(&start, 0.0, 100.0, 0.0);
    for t in [0.0, 1.0, 4.0] {
        near(lateral.at(t, [100.0, 0.0, 0.0]), [0.5, 0.0, 0.0]);
    }
}

#[test]
fn refined_levels_are_denser_and_keep_the_path_itself() {
    let sampling = Settings::default().sampling;
    let mut before = 0;
    for refinement in 0..3 {
        let level = Level::new(&sampling, refinement);
        let offsets: Vec<f64> = level.offsets(3.5, 0.25).collect();
        let durations: Vec<f64> = level.durations(4.0).collect();
        assert!(offsets.contains(&0.0) && offsets.contains(&0.25) && offsets.contains(&-3.5));
        assert!(offsets.iter().all(|d| d.abs() <= 3.5));
        assert!(durations.iter().all(|t| (0.5..=4.0).contains(t)));
        assert_eq!(durations.last(), Some(&4.0));
        assert!(level.changes(4.0).all(|t| (1.5..=4.0).contains(&t)));
        let count = offsets.len() * durations.len();
        assert!(count > before);
        before = count;
    }
    // Who is on the path already has it once.
    let level = Level::new(&sampling, 0);
    assert_eq!(level.offsets(3.5, 0.0).filter(|d| *d == 0.0).count(), 1);
}

/// Profiles from 15 m/s with an obstacle in front at `ahead` metres and 8 m/s, or without one.
fn profiles(ahead: Option<f64>) -> (Vec<Profile>, [f64; 3]) {
    let (guide, dt) = guide("HardBraking");
    let settings = Settings::default();
    let steps = settings.steps(dt);
    let mut traffic = Traffic::new(steps);
    if let Some(ahead) = ahead {
        let car = Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap();
        let body = traffic.add(Body {
            id: 1,
            likelihood: 1.0,
            avoided: true,
        });
        for step in 0..=steps {
            let s = guide.start + ahead + 8.0 * step as f64 * dt;
            traffic.occupy(body, step, &car, &guide.path.pose_at(s), 8.0);
        }
    }
    let sampler = Sampler {
        settings: &settings,
        limits: &settings.limits(),
        guide: &guide,
        traffic: &traffic,
        wanted: 13.0,
        stop: None,
        dt,
    };
    let from = [guide.start, 15.0, -0.5];
    let mut profiles = Vec::new();
    sampler.profiles(Level::new(&settings.sampling, 0), from, &mut profiles);
    (profiles, from)
}

#[test]
fn profiles_begin_now_and_include_stopping_holding_and_what_is_wanted() {
    let (profiles, from) = profiles(None);
    for profile in &profiles {
        near(profile.at(0.0), from);
        let speed = profile.at(profile.duration)[1];
        assert!((0.0..=Settings::default().limits().speed).contains(&(speed + 1e-9)));
    }
    for wanted in [0.0, 13.0, 15.0] {
        let there = |p: &&Profile| p.duration == 4.0 && (p.at(4.0)[1] - wanted).abs() < 1e-6;
        assert!(profiles.iter().any(|p| there(&p)), "{wanted}");
    }
}

#[test]
fn somebody_in_front_is_followed() {
    let (alone, _) = profiles(None);
    let (following, from) = profiles(Some(40.0));
    assert_eq!(following.len(), alone.len() + 4);
    let behind = following.iter().filter(|p| {
        let [s, v, a] = p.at(p.duration);
        let gap = from[0] + 40.0 + 8.0 * p.duration - 2.0 - s;
        // His speed, and a gap of 3 m and 0.8 s between the bumpers.
        let front = Settings::default().limits().rear_to_centre + 4.508 / 2.0;
        (v - 8.0).abs() < 1e-6 && a.abs() < 1e-6 && (gap - front - 3.0 - 0.8 * 8.0).abs() < 0.2
    });
    assert_eq!(behind.count(), 4);
}
