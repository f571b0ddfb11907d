//! What happened: the moment that matters of a recording in at most four sentences, each of facts with numbers.
//!
//! A fact says no more than what can be recomputed from the recorded states of the ego and of the other road user: where
//! they are, how fast, how much they turn and brake, when their ways overlap, how near they come. It is told from 5 s
//! before the moment to 2 s after it; lowest and nearest are of the whole recording. `Story::sentences` has the facts as
//! data with their words, for pages, maps and programs.

mod motion;
mod words;

use nearmiss_base::geometry::angle_between;
use serde::Serialize;

use crate::metrics::{Context, CriticalMoment, Direction, Encounter, Headline, Measure, measure};
use crate::scenario::{ObstacleType, Window};
use motion::{Drive, Slowing};

/// So long before the moment a story begins, seconds.
const BEFORE: f64 = 5.0;

/// So long after it a story ends, seconds.
const AFTER: f64 = 2.0;

/// Who is slower stands, m/s.
const STANDING: f64 = 0.5;

/// A time to collision from here on is short, seconds.
const SHORT: f64 = 3.0;

/// Who changes its heading by more than this turns, radians: 25°, as in manoeuvres.
const TURN: f64 = 0.436;

/// What happened around the moment that matters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Story {
    /// Id of the ego.
    pub ego: i64,
    /// Id of the other road user.
    pub obstacle: i64,
    /// Its type.
    pub kind: ObstacleType,
    /// At most four.
    pub sentences: Vec<Sentence>,
}

/// A sentence and what it says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sentence {
    /// In plain English.
    pub text: String,
    /// Its facts, in the order of the text.
    pub facts: Vec<Fact>,
}

/// Whom a fact is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Who {
    /// The ego.
    Ego,
    /// The other road user.
    Other,
}

/// Where the other moves to, seen from the ego's heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Course {
    /// What is there is a region that it may be in, which has no motion.
    Region,
    /// It stands.
    Stands,
    /// Within 45° of the ego's heading.
    SameWay,
    /// Within 45° of the opposite.
    Towards,
    /// In between, to the left.
    ToTheLeft,
    /// In between, to the right.
    ToTheRight,
}

/// A fact with its numbers: seconds since time step 0, metres, m/s, m/s², degrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "fact", rename_all = "snake_case")]
pub enum Fact {
    /// How both move at a time.
    Begin {
        /// When.
        time: f64,
        /// Speed of the ego.
        ego_speed: f64,
        /// Speed of the other.
        other_speed: f64,
        /// Distance of the bodies.
        distance: f64,
        /// Where the other is, seen from the ego's body.
        #[serde(serialize_with = "direction_name")]
        place: Direction,
        /// Where the other moves to.
        course: Course,
    },
    /// One turns.
    Turn {
        /// Who.
        who: Who,
        /// By so many degrees, to the left; negative to the right.
        degrees: f64,
        /// From then on.
        from: f64,
        /// Until then.
        to: f64,
    },
    /// One slows down: its speed falls with at least 1 m/s² all the time.
    Brake {
        /// Who.
        who: Who,
        /// From then on.
        from: f64,
        /// Until then.
        to: f64,
        /// Speed at the beginning.
        from_speed: f64,
        /// Speed at the end.
        to_speed: f64,
        /// The most, over 0.4 s.
        most: f64,
    },
    /// One never slows down with 1 m/s² between these times.
    NoBrake {
        /// Who.
        who: Who,
        /// From then on.
        from: f64,
        /// Until then.
        to: f64,
    },
    /// One goes on with speeds between these.
    Speeds {
        /// Who.
        who: Who,
        /// The lowest.
        low: f64,
        /// The highest.
        high: f64,
        /// From then on.
        from: f64,
        /// Until then.
        to: f64,
    },
    /// One leaves the place where both ways overlap before the other comes there.
    Pass {
        /// Who is there first.
        first: Who,
        /// When it leaves.
        left: f64,
        /// When the other comes.
        entered: f64,
    },
    /// The lowest time to collision of the recording.
    LowestTtc {
        /// When.
        time: f64,
        /// Seconds.
        seconds: f64,
    },
    /// Between these times the time to collision is at most 3 s, and it is not at the step before.
    ShortTtc {
        /// From then on.
        time: f64,
        /// Until it is lowest.
        until: f64,
    },
    /// At no step both would touch within 10 s if they went straight on.
    NoCourse,
    /// The first contact.
    Contact {
        /// When.
        time: f64,
        /// The speed of one relative to the other.
        closing_speed: f64,
        /// Whether what is touched is a region that the other may be in.
        is_possible: bool,
    },
    /// The smallest distance of the recording, at a step.
    Nearest {
        /// When.
        time: f64,
        /// Of the bodies.
        distance: f64,
        /// Where the other is, seen from the ego's body.
        #[serde(serialize_with = "direction_name")]
        place: Direction,
    },
}

// The signature is serde's.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn direction_name<S: serde::Serializer>(place: &Direction, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(place.name())
}

impl Story {
    /// The story of the moment that matters; nothing where nobody is ever there with the ego.
    #[must_use]
    pub fn new(context: &Context<'_>) -> Option<Self> {
        let headline = Headline::from_context(context);
        Self::of_moment(context, headline.worst()?)
    }

    /// The story of a moment.
    #[must_use]
    pub fn of_moment(context: &Context<'_>, moment: &CriticalMoment) -> Option<Self> {
        let mut all = context.participants().iter();
        let participant = all.position(|other| other.obstacle.id == moment.obstacle)?;
        let told = Telling::new(context, participant, moment.step)?;
        let kind = context.participants()[participant].obstacle.kind;
        let subject = words::name(kind, moment.obstacle);
        let facts = [told.begin(), told.other(), told.nearness(), told.ego()];
        let sentences = facts.into_iter().filter(|facts| !facts.is_empty());
        Some(Self {
            ego: context.scene().ego.id,
            obstacle: moment.obstacle,
            kind,
            sentences: sentences
                .map(|facts| Sentence {
                    text: words::sentence(&subject, &facts),
                    facts,
                })
                .collect(),
        })
    }

    /// All sentences, a space between two.
    #[must_use]
    pub fn text(&self) -> String {
        let texts = self.sentences.iter().map(|sentence| sentence.text.as_str());
        texts.collect::<Vec<_>>().join(" ")
    }
}

/// What a story is told of.
struct Telling<'c, 's> {
    context: &'c Context<'s>,
    participant: usize,
    /// The steps at which both are there.
    common: Vec<i64>,
    /// Those of them that the story is about, without a gap.
    window: Window,
    ego: Drive,
    other: Drive,
}

impl<'c, 's> Telling<'c, 's> {
    fn new(context: &'c Context<'s>, participant: usize, moment: i64) -> Option<Self> {
        let scene = context.scene();
        let there = |step: &i64| context.encounter(participant, *step).is_some();
        let common: Vec<i64> = context.steps().filter(there).collect();
        let dt = scene.scenario.dt();
        let count = |seconds: f64| (seconds / dt).round() as i64;
        let (before, after) = (count(BEFORE), count(AFTER));
        // A contact ends what is worth telling.
        let contact = context.contacts(participant).first();
        let end = contact.map_or(moment + after, |contact| contact.step.max(moment));
        let first = (moment - before..=moment).rev().take_while(there).last()?;
        let last = (moment..=end).take_while(there).last()?;
        let window = Window::within(&(first..last + 1), last, usize::MAX);
        let other = context.participants()[participant];
        let drive = |motion: &dyn Fn(i64) -> Option<crate::scenario::Motion>| {
            Drive::new(
                window
                    .steps()
                    .filter_map(|step| Some((step, motion(step)?))),
                dt,
            )
        };
        let drives = (
            drive(&|step| scene.ego.track.at(step).copied()),
            drive(&|step| other.at(step).copied()),
        );
        Some(Self {
            context,
            participant,
            common,
            window,
            ego: drives.0,
            other: drives.1,
        })
    }

    fn encounter(&self, step: i64) -> Option<Encounter<'_>> {
        self.context.encounter(self.participant, step)
    }

    fn time(&self, step: i64) -> f64 {
        self.context.scene().time_of(step)
    }

    fn span(&self) -> (f64, f64) {
        (
            self.time(self.window.first()),
            self.time(self.window.last()),
        )
    }

    /// How both move at the first step.
    fn begin(&self) -> Vec<Fact> {
        let Some(encounter) = self.encounter(self.window.first()) else {
            return Vec::new();
        };
        vec![Fact::Begin {
            time: self.span().0,
            ego_speed: encounter.ego.velocity.abs(),
            other_speed: encounter.other.velocity.abs(),
            distance: encounter.distance(),
            place: encounter.relation().direction,
            course: course(&encounter),
        }]
    }

    /// What the other does.
    fn other(&self) -> Vec<Fact> {
        // A region has no motion.
        if self.context.participants()[self.participant]
            .obstacle
            .is_set_based()
        {
            return Vec::new();
        }
        let (from, to) = self.span();
        let (low, high) = self.other.speeds();
        if high < STANDING {
            return Vec::new();
        }
        let turn = self.turn(Who::Other, &self.other);
        let brake = self.brake(Who::Other, &self.other);
        let pass = self.pass();
        let mut facts: Vec<Fact> = turn.into_iter().chain(brake).chain(pass).collect();
        if facts.is_empty() {
            let who = Who::Other;
            facts.push(Fact::Speeds {
                who,
                low,
                high,
                from,
                to,
            });
        }
        facts
    }

    /// How near they come.
    fn nearness(&self) -> Vec<Fact> {
        let contact = self.context.contacts(self.participant).first();
        let ttc = self.lowest_ttc();
        let other = self.context.participants()[self.participant].obstacle;
        if let Some(contact) = contact {
            let before = ttc.filter(|(step, _)| *step <= contact.step);
            let short = before.and_then(|(step, _)| self.short_since(step));
            let contact = Fact::Contact {
                time: contact.time,
                closing_speed: contact.closing_speed,
                is_possible: contact.is_possible,
            };
            return short.into_iter().chain([contact]).collect();
        }
        let lowest = match ttc {
            Some((step, seconds)) => Some(Fact::LowestTtc {
                time: self.time(step),
                seconds,
            }),
            // A region does not go straight on.
            None => (!other.is_set_based()).then_some(Fact::NoCourse),
        };
        let distances = self
            .common
            .iter()
            .filter_map(|step| self.encounter(*step).map(|e| (*step, e)));
        let nearest = distances.min_by(|a, b| a.1.distance().total_cmp(&b.1.distance()));
        let nearest = nearest.map(|(step, encounter)| Fact::Nearest {
            time: self.time(step),
            distance: encounter.distance(),
            place: encounter.relation().direction,
        });
        lowest.into_iter().chain(nearest).collect()
    }

    /// What the ego does.
    fn ego(&self) -> Vec<Fact> {
        let (from, to) = self.span();
        let turn = self.turn(Who::Ego, &self.ego);
        let mut facts: Vec<Fact> = turn.into_iter().collect();
        match self.brake(Who::Ego, &self.ego) {
            Some(brake) => {
                facts.push(brake);
                facts.extend(self.reaction(&brake));
            }
            None if self.ego.speeds().1 >= STANDING => {
                facts.push(Fact::NoBrake {
                    who: Who::Ego,
                    from,
                    to,
                });
            }
            None => {}
        }
        facts
    }

    /// When the time to collision got short, where the ego begins to brake while it is.
    fn reaction(&self, brake: &Fact) -> Option<Fact> {
        let (lowest, _) = self.lowest_ttc()?;
        let short = self.short_since(lowest)?;
        match (short, brake) {
            // Who brakes at first may have begun before.
            (Fact::ShortTtc { time, until }, Fact::Brake { from, .. })
                if (time..=until).contains(from) && *from > self.span().0 =>
            {
                Some(short)
            }
            _ => None,
        }
    }

    fn turn(&self, who: Who, drive: &Drive) -> Option<Fact> {
        let (from, to) = self.span();
        let turned = drive.turned()?;
        (turned.abs() >= TURN).then(|| Fact::Turn {
            who,
            degrees: turned.to_degrees(),
            from,
            to,
        })
    }

    fn brake(&self, who: Who, drive: &Drive) -> Option<Fact> {
        let Slowing {
            steps,
            speeds,
            most,
        } = drive.hardest_slowing()?;
        Some(Fact::Brake {
            who,
            from: self.time(steps.0),
            to: self.time(steps.1),
            from_speed: speeds.0,
            to_speed: speeds.1,
            most,
        })
    }

    /// Who leaves first the place where both ways overlap.
    fn pass(&self) -> Option<Fact> {
        let passing = self.context.passing(self.participant)?;
        Some(Fact::Pass {
            first: if passing.ego_first {
                Who::Ego
            } else {
                Who::Other
            },
            left: passing.left,
            entered: passing.entered,
        })
    }

    fn ttc(&self, step: i64) -> Option<f64> {
        // Regions do not go straight on.
        let encounter = self.encounter(step).filter(|e| !e.is_with_occupancy())?;
        ttc_measure()?.evaluate(&encounter).value()
    }

    /// The step of the lowest time to collision of the recording, the first of several.
    fn lowest_ttc(&self) -> Option<(i64, f64)> {
        let steps = self.common.iter();
        let readings = steps.filter_map(|step| Some((*step, self.ttc(*step)?)));
        readings.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Since when the time to collision is short until a step; nothing where the recording does not tell.
    fn short_since(&self, until: i64) -> Option<Fact> {
        let is_short = |step: &i64| self.ttc(*step).is_some_and(|seconds| seconds <= SHORT);
        let since = { (i64::MIN..=until).rev() }.take_while(is_short).last()?;
        // At the first step it may have been short before.
        self.encounter(since - 1)?;
        Some(Fact::ShortTtc {
            time: self.time(since),
            until: self.time(until),
        })
    }
}

fn ttc_measure() -> Option<&'static Measure> {
    measure("ttc")
}

/// Where the other moves to.
fn course(encounter: &Encounter<'_>) -> Course {
    use std::f64::consts::FRAC_PI_4;
    if encounter.is_with_occupancy() {
        return Course::Region;
    }
    if encounter.other.velocity.abs() < STANDING {
        return Course::Stands;
    }
    let way = encounter.other.velocity_vector();
    let angle = angle_between(encounter.ego.pose.heading, way.y.atan2(way.x));
    match angle.abs() {
        angle if angle <= FRAC_PI_4 => Course::SameWay,
        angle if angle >= 3.0 * FRAC_PI_4 => Course::Towards,
        _ if angle > 0.0 => Course::ToTheLeft,
        _ => Course::ToTheRight,
    }
}
