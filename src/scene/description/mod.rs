//! Text descriptions of scenes for language models, with the meaning of each number.

mod cartesian;
mod ego_centric;
mod ego_lane;
mod nearby;
mod options;
mod parts;
mod picture;
mod road;
mod safety_metrics;
mod trajectory;
mod writer;

use crate::metrics::Context;
use crate::scenario::{Participant, Scene, Window};

pub use nearby::VELOCITY_TOLERANCE;
pub use nearmiss_base::system::{disguises, escaped_json, escaped_xml, visible};
pub use options::{EgoAxes, Form, Frame, OF_ONE_FRAME, Options, STANDS_FAR};
pub use picture::{PictureMoment, picture_moments};
pub use safety_metrics::measure_column;
pub use writer::{Description, Span, Subject, Value, has_relative_times};

use writer::Writer;

/// Why a scene cannot be described.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DescriptionError {
    /// The trajectory frame is about one obstacle, and none is named.
    #[error("the trajectory frame describes one obstacle: choose which")]
    NoObstacle,
    /// No obstacle with a shape has this id.
    #[error("no obstacle with a body has the id {id}; there are {known}")]
    UnknownObstacle {
        /// The id asked for.
        id: i64,
        /// Some that exist.
        known: String,
    },
    /// The obstacle is absent.
    #[error("obstacle {id} is not there from step {first} to {last}")]
    NotThere {
        /// Which one.
        id: i64,
        /// First step that would be described.
        first: i64,
        /// The last one.
        last: i64,
    },
}

/// Describes the scene during `window`, using only what is known by the end of the window.
///
/// ```
/// use nearmiss_scene::description::{Frame, Options, describe};
/// use nearmiss_formats::bundled;
/// use nearmiss_scene::scenario::{Scene, Window};
///
/// # let entry = &bundled()[0];
/// # let scenario = entry.read()?;
/// # let ego = entry.recorded_ego(&scenario)?.expect("recorded beside it");
/// # let scene = Scene::new(scenario, ego);
/// let window = Window::ending_at(&scene, 20, 10);
/// let described = describe(&scene, Frame::Ego, &window, &Options::default())?;
/// assert!(described.text.contains("m/s"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The obstacle named in the options or needed by the frame is absent.
pub fn describe(
    scene: &Scene,
    frame: Frame,
    window: &Window,
    options: &Options,
) -> Result<Description, DescriptionError> {
    describe_in(&Context::new(scene), frame, window, options)
}

/// As [`describe`], measured as `context` measures.
///
/// # Errors
/// As [`describe`].
pub fn describe_in(
    context: &Context<'_>,
    frame: Frame,
    window: &Window,
    options: &Options,
) -> Result<Description, DescriptionError> {
    let scene = context.scene();
    let chosen = options
        .obstacle
        .map(|id| participant(scene, id))
        .transpose()?;
    let mut writer = Writer::new(options.precision);
    let w = &mut writer;
    match frame.words() {
        None => {}
        Some(words) => {
            in_words(w, context, words, chosen, window, options)?;
            parts::describe(w, context, window, options);
        }
    }
    if frame.has_picture() {
        picture::describe(w, scene, frame, window, options);
    }
    Ok(writer.finish())
}

/// Describes it in a frame that is words alone.
fn in_words(
    w: &mut Writer,
    context: &Context<'_>,
    frame: Frame,
    chosen: Option<Participant<'_>>,
    window: &Window,
    options: &Options,
) -> Result<(), DescriptionError> {
    let scene = context.scene();
    match frame {
        Frame::Cartesian => cartesian::describe(w, scene, window, options),
        Frame::Ego if options.axes != EgoAxes::Heading => {
            ego_lane::describe(w, scene, window, options)
        }
        Frame::Ego => ego_centric::describe(w, scene, window, options),
        Frame::Metrics => safety_metrics::describe(w, context, window, options),
        Frame::Trajectory => {
            let who = chosen.ok_or(DescriptionError::NoObstacle)?;
            let there = |s| who.at(s).is_some() && !who.obstacle.is_occupancy_at(s);
            if !options.steps(window).iter().any(|&s| there(s)) {
                return Err(DescriptionError::NotThere {
                    id: who.obstacle.id,
                    first: window.first(),
                    last: window.last(),
                });
            }
            trajectory::describe(w, scene, &who, window, options);
        }
        // They are no words.
        Frame::Picture
        | Frame::EgoPicture
        | Frame::CartesianPicture
        | Frame::MetricsPicture
        | Frame::TrajectoryPicture => {}
    }
    Ok(())
}

fn participant(scene: &Scene, id: i64) -> Result<Participant<'_>, DescriptionError> {
    let found = scene.participants().find(|p| p.obstacle.id == id);
    found.ok_or_else(|| {
        let all: Vec<i64> = scene.participants().map(|p| p.obstacle.id).collect();
        let mut known: Vec<String> = all.iter().take(12).map(i64::to_string).collect();
        match all.len() {
            0 => known.push("none".into()),
            13.. => known.push("…".into()),
            _ => {}
        }
        DescriptionError::UnknownObstacle {
            id,
            known: known.join(", "),
        }
    })
}
