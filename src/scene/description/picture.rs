//! What a picture of a window shows, under the rules of the text frames, and the words that are needed to read it.

use super::Frame;
use super::ego_centric::relative;
use super::options::{Near, Options};
use super::parts::{left_out, name, subject};
use super::writer::{Subject, Writer};
use crate::metrics::Encounter;
use crate::scenario::{Participant, Scene, Window};

/// A moment of a picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PictureMoment {
    /// The time step.
    pub step: i64,
    /// The ids of the obstacles that are shown, nearest first.
    pub obstacles: Vec<i64>,
}

/// Moments of a picture at most, beside the close-up of the last one, and at most where the user states the steps between them.
const MAX_MOMENTS: (usize, usize) = (5, 11);

/// The moments that a picture of a window shows, in order: steps as the text frames have them, the last of the window
/// always and none after it, but not more than can be looked at in one picture; and obstacles within the radius, and that
/// of the trajectory frame however far away it is. Those farther away would make all others too small to be seen: words
/// tell of them.
#[must_use]
pub fn picture_moments(
    scene: &Scene,
    frame: Frame,
    window: &Window,
    options: &Options,
) -> Vec<PictureMoment> {
    let few = Options {
        radius: if frame.is_of_one_obstacle() {
            f64::INFINITY
        } else {
            options.radius
        },
        reach: None,
        ..few(options)
    };
    let moment = |step| PictureMoment {
        step,
        obstacles: ids(&few.near(scene, step)),
    };
    few.steps(window).into_iter().map(moment).collect()
}

/// The options with no more times than can be looked at in one picture.
fn few(options: &Options) -> Options {
    let most = if options.stride > 1 {
        MAX_MOMENTS.1
    } else {
        MAX_MOMENTS.0
    };
    Options {
        most_times: Some(options.most_times.map_or(most, |times| times.min(most))),
        ..*options
    }
}

fn ids(near: &[Near<'_>]) -> Vec<i64> {
    near.iter().map(|(other, _)| other.obstacle.id).collect()
}

/// How the picture is to be read, and who is on it.
pub(super) fn describe(
    w: &mut Writer,
    scene: &Scene,
    frame: Frame,
    window: &Window,
    options: &Options,
) {
    let dt = scene.scenario.dt();
    let moments = picture_moments(scene, frame, window, options);
    if frame.words().is_none() {
        w.relative_to(window.last());
    } else {
        w.text("\n");
    }
    w.about(Subject::Scene, Some(window.last()));
    match moments.len() {
        1 => drop(w.text("The picture shows the scene from above at t = ")),
        n => {
            w.text("The picture shows the scene from above at ")
                .integer("panels", n as i64)
                .text(" times, one panel each, row by row from left to right: t = ");
        }
    }
    for (place, moment) in moments.iter().enumerate() {
        w.text(if place == 0 { "" } else { ", " })
            .about(Subject::Scene, Some(moment.step))
            .time(moment.step, dt);
    }
    w.text(" s; the last panel is a close-up of the last of them. The ego, blue, is in the middle of each panel");
    w.text(if frame.is_on_the_map() {
        "; the x axis of the map points to the right, the y axis up.\n"
    } else {
        " and heads up.\n"
    });
    w.text(
        "Bodies have their real sizes and headings, and an arrow head inside at their front. A bar shows the scale, which is the same in all panels but the close-up. A line behind a body is its way since the beginning of the window; an arrow from its front is the way that it would go in 0.5 s at its present velocity.\n",
    );
    if options.contact {
        w.text("A red ring marks where the ego touches another body. ");
    }
    if frame.is_of_one_obstacle() {
        let chosen = scene
            .participants()
            .find(|p| Some(p.obstacle.id) == options.obstacle);
        w.text("Of the obstacles it shows only this one, with its id, however far away it is: ");
        if let Some(chosen) = chosen {
            w.about(subject(&chosen), None);
            name(w, &chosen);
        }
        w.text(".\n");
        return;
    }
    w.text("Obstacles whose centre is within ")
        .about(Subject::Scene, None)
        .number("radius", options.radius)
        .text(" m of the ego's are shown, with their ids, and the nearest ones in colours of their own: ");
    let shown = shown(scene, &moments);
    if shown.is_empty() {
        w.text("there are none");
    }
    for (place, participant) in shown.iter().enumerate() {
        w.text(if place == 0 { "" } else { ", " })
            .about(subject(participant), None);
        name(w, participant);
    }
    w.text(".\n");
    let beyond = beyond(scene, options, &moments, &shown);
    farther_away(w, scene, frame, &beyond);
    if frame.words().is_none() {
        let beyond = beyond.into_iter().map(|(_, other)| other);
        let told: Vec<Participant<'_>> = shown.into_iter().chain(beyond).collect();
        left_out(w, scene, window, &told);
    }
}

/// Who is not shown since it is too far away, and would be described in words; with the last of the moments at which it
/// would.
fn beyond<'s>(
    scene: &'s Scene,
    options: &Options,
    moments: &[PictureMoment],
    shown: &[Participant<'_>],
) -> Vec<(i64, Participant<'s>)> {
    let mut found: Vec<(i64, Participant<'s>)> = Vec::new();
    for moment in moments.iter().rev() {
        for (other, _) in options.near(scene, moment.step) {
            let is_it = |known: &Participant<'_>| known.obstacle.id == other.obstacle.id;
            if !shown.iter().any(is_it) && !found.iter().any(|(_, known)| is_it(known)) {
                found.push((moment.step, other));
            }
        }
    }
    found
}

/// Tells of those that are too far away for the picture; where and how they move where no other words do.
fn farther_away(w: &mut Writer, scene: &Scene, frame: Frame, beyond: &[(i64, Participant<'_>)]) {
    let dt = scene.scenario.dt();
    for (place, (step, other)) in beyond.iter().enumerate() {
        w.text(match place {
            0 => "Farther away, not in the picture: ",
            _ => "; ",
        });
        w.about(subject(other), Some(*step));
        name(w, other);
        let encounter = Encounter::at(scene, other, *step);
        if let (None, Some(encounter)) = (frame.words(), encounter) {
            w.text(" at t = ").time(*step, dt).text(" s: ");
            relative(w, &encounter.relation());
        }
    }
    if !beyond.is_empty() {
        w.text(".\n");
    }
}

/// Everyone who is shown, in the order in which they come near.
fn shown<'s>(scene: &'s Scene, moments: &[PictureMoment]) -> Vec<Participant<'s>> {
    let mut all: Vec<i64> = Vec::new();
    for id in moments.iter().flat_map(|moment| &moment.obstacles) {
        if !all.contains(id) {
            all.push(*id);
        }
    }
    let found = |id| scene.participants().find(|p| p.obstacle.id == id);
    all.into_iter().filter_map(found).collect()
}
