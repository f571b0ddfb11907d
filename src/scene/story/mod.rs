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
use crate::scenario::{ObstacleType, Track, Window};
use motion::{Change, Drive, NOTABLE};

/// So long before the moment a story begins, seconds.
const BEFORE: f64 = 5.0;

/// So long after it a story ends, seconds.
const AFTER: f64 = 2.0;

/// That one does not brake is told of at least so long, seconds.
const WHILE: f64 = 0.5;

/// A braking so long before the time to collision gets short still belongs to it, seconds.
const SHORTLY: f64 = 1.0;

/// Speeds are told to rise from here on where there is more to tell, m/s.
const RISE: f64 = 1.5;

/// Who is slower stands, m/s.
const STANDING: f64 = 0.5;

/// A time to collision from here on is short, seconds.
const SHORT: f64 = 3.0;

/// Who changes its heading by more than this turns, radians: 25°, as in manoeuvres.
const TURN: f64 = 0.436;

/// Directions that are nearer to each other do not cross, radians: 30°.
const CROSSING: f64 = 0.524;

/// Whose speed has fallen by more brakes already, m/s.
const SLOWED: f64 = 0.3;

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
    /// One brakes: its speed falls with at least 1 m/s² over 0.4 s, with breaks of at most 1 s.
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
        /// The most, over 0.4 s, or over all of it where that is more.
        most: f64,
    },
    /// One gets faster: the largest rise of its speed without a fall of 0.5 m/s in it.
    SpeedUp {
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
    },
    /// One gets slower and does not brake: the largest fall of its speed without a rise of 0.5 m/s in it.
    SlowDown {
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
    },
    /// One never slows down with 1 m/s² between these times, nor in the second before.
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
        /// Whether the story is of that time, too.
        is_told: bool,
    },
    /// Between these times the time to collision is at most 3 s.
    ShortTtc {
        /// From then on; it is not at the step before, if there is one.
        time: f64,
        /// Until it is lowest.
        until: f64,
    },
    /// At no step both would touch within 10 s if they went straight on.
    NoCourse,
    /// The first contact.
    Contact {
        /// When: the first step at which they touch, or on the way to which.
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
        /// Whether the story is of that time, too.
        is_told: bool,
    },
}

// The signature is serde's.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn direction_name<S: serde::Serializer>(place: &Direction, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(place.name())
}

impl Story {
    /// The story of the moment that matters; nothing where no other road user is ever there with the ego.
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
        // Who never moves is at any step; what it does is told of its track, which ends.
        let other = context.participants()[participant].obstacle.track();
        let told = window.first()..=window.last();
        let drive = |track: &Track| {
            let ends = |step: &i64| contact.is_none() || *step <= end;
            let motion = |step| track.at(Some(step).filter(ends)?).copied();
            Drive::new(motion, told.clone(), dt)
        };
        let drives = (drive(&scene.ego.track), drive(other));
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
            course: self.course(&encounter),
        }]
    }

    /// Where the other moves to, as seen from the ego.
    fn course(&self, encounter: &Encounter<'_>) -> Course {
        use std::f64::consts::FRAC_PI_4;
        if encounter.is_with_occupancy() {
            return Course::Region;
        }
        if encounter.other.velocity.abs() < STANDING {
            return Course::Stands;
        }
        // Headings of one that creeps may be those of noise.
        let way = self.other.next_way();
        let way = way.unwrap_or_else(|| encounter.other.velocity_vector());
        let angle = angle_between(encounter.ego.pose.heading, way.y.atan2(way.x));
        match angle.abs() {
            angle if angle <= FRAC_PI_4 => Course::SameWay,
            angle if angle >= 3.0 * FRAC_PI_4 => Course::Towards,
            _ if angle > 0.0 => Course::ToTheLeft,
            _ => Course::ToTheRight,
        }
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
        if self.other.speeds().1 < STANDING {
            return Vec::new();
        }
        let who = Who::Other;
        let brake = largest(self.brakings(&self.other, self.window.last()));
        let mut facts: Vec<Fact> = self.turn(who, &self.other).into_iter().collect();
        let brake = brake.map(|change| self.brake(who, &change));
        let rise = rise(&self.other).map(|change| self.speed_up(who, &change));
        facts.extend(in_order(brake.into_iter().chain(rise).collect()));
        facts.extend(self.pass());
        if facts.is_empty() {
            facts.extend(self.speeds(who, &self.other));
        }
        facts
    }

    /// How the speed of one who does nothing else changes, if it moves.
    fn speeds(&self, who: Who, drive: &Drive) -> Option<Fact> {
        let (from, to) = self.span();
        let (low, high) = drive.speeds();
        if high < STANDING || !is_while(from, to) {
            return None;
        }
        let changes = [drive.rise(), drive.fall()];
        let change = largest(changes.into_iter().flatten().collect());
        let change = change.filter(|change| is_change(change.gain().abs(), high));
        Some(match change {
            Some(change) if change.gain() > 0.0 => self.speed_up(who, &change),
            Some(change) => self.slow_down(who, &change),
            None => Fact::Speeds {
                who,
                low,
                high,
                from,
                to,
            },
        })
    }

    /// How near they come.
    fn nearness(&self) -> Vec<Fact> {
        let contact = self.context.contacts(self.participant).first();
        let ttc = self.lowest_ttc();
        let other = self.context.participants()[self.participant].obstacle;
        if let Some(contact) = contact {
            let touched = self.time(contact.step);
            let before = ttc.filter(|(step, _)| *step <= contact.step);
            let short = before.and_then(|(step, _)| self.short_since(step));
            // Where they touch it is short.
            let short = short.filter(|(since, _)| is_while(self.time(*since), touched));
            let short = short.map(|(since, until)| self.short_ttc(since, until));
            let contact = Fact::Contact {
                time: touched,
                closing_speed: contact.closing_speed,
                is_possible: contact.is_possible,
            };
            return short.into_iter().chain([contact]).collect();
        }
        let lowest = match ttc {
            Some((step, seconds)) => Some(Fact::LowestTtc {
                time: self.time(step),
                seconds,
                is_told: self.window.steps().contains(&step),
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
            is_told: self.window.steps().contains(&step),
        });
        lowest.into_iter().chain(nearest).collect()
    }

    /// What the ego does: where the time to collision gets short, what it does then.
    fn ego(&self) -> Vec<Fact> {
        let who = Who::Ego;
        let whole = (self.window.first(), self.window.last());
        let short = self
            .lowest_ttc()
            .and_then(|(lowest, _)| self.short_since(lowest));
        let short = short.filter(|(since, until)| {
            self.window.steps().contains(since) && is_while(self.time(*since), self.time(*until))
        });
        let (since, until) = short.unwrap_or(whole);
        let mut facts: Vec<Fact> = self.turn(who, &self.ego).into_iter().collect();
        // The braking that leads to the moment, and that of the time in which it is short where it is another one.
        let brakings = self.brakings(&self.ego, until);
        let last = brakings.last().copied();
        let last = last.filter(|change| short.is_some() && change.steps.1 > since);
        let told = [largest(brakings.clone()), last];
        let told = brakings
            .iter()
            .filter(|change| told.contains(&Some(**change)));
        let mut told: Vec<Fact> = told.map(|change| self.brake(who, change)).collect();
        let late = match brakings[..] {
            [only] => short.and_then(|short| self.reaction(only.steps.0, short)),
            _ => None,
        };
        let rise = rise(&self.ego);
        told.extend(self.no_brake(rise, (since, until)));
        told.extend(rise.map(|change| self.speed_up(who, &change)));
        // The reaction is said right after the braking.
        for fact in in_order(told) {
            facts.push(fact);
            if matches!(fact, Fact::Brake { .. }) {
                facts.extend(late);
            }
        }
        if facts.is_empty() {
            facts.extend(self.speeds(who, &self.ego));
        }
        facts
    }

    /// That the ego does not brake between two steps, or in most of it where it gets faster; nothing where it brakes or has
    /// done so shortly before.
    fn no_brake(&self, rise: Option<Change>, (since, until): (i64, i64)) -> Option<Fact> {
        let rises = rise.map_or((until, until), |rise| rise.steps);
        let rests = [(since, rises.0.min(until)), (rises.1.max(since), until)];
        let (from, to) = rests.into_iter().max_by_key(|(from, to)| to - from)?;
        let times = (self.time(from), self.time(to));
        let is_long = times.1 - times.0 >= WHILE && 2 * (to - from) >= until - since;
        let ego = &self.context.scene().ego.track;
        let moves = |step| ego.at(step).is_some_and(|at| at.velocity.abs() >= STANDING);
        let brakes = |change: &Change| {
            change.steps.0 <= until && self.time(change.steps.1) > times.0 - SHORTLY
        };
        let is_told = is_long && (from..=to).any(moves) && !self.ego.brakings().iter().any(brakes);
        is_told.then_some(Fact::NoBrake {
            who: Who::Ego,
            from: times.0,
            to: times.1,
        })
    }

    /// When the time to collision got short, where the ego begins to brake at a step while it is.
    fn reaction(&self, step: i64, (since, until): (i64, i64)) -> Option<Fact> {
        // The recording tells when it got short, and the ego did not slow down before.
        self.encounter(since - 1)?;
        let is_reaction = is_while(self.time(since), self.time(step))
            && step <= until
            && step > self.window.first()
            && self.ego.fallen_before(step) < SLOWED;
        is_reaction.then(|| self.short_ttc(since, until))
    }

    fn speed_up(&self, who: Who, change: &Change) -> Fact {
        Fact::SpeedUp {
            who,
            from: self.time(change.steps.0),
            to: self.time(change.steps.1),
            from_speed: change.speeds.0,
            to_speed: change.speeds.1,
        }
    }

    fn slow_down(&self, who: Who, change: &Change) -> Fact {
        Fact::SlowDown {
            who,
            from: self.time(change.steps.0),
            to: self.time(change.steps.1),
            from_speed: change.speeds.0,
            to_speed: change.speeds.1,
        }
    }

    fn brake(&self, who: Who, change: &Change) -> Fact {
        Fact::Brake {
            who,
            from: self.time(change.steps.0),
            to: self.time(change.steps.1),
            from_speed: change.speeds.0,
            to_speed: change.speeds.1,
            most: change.most,
        }
    }

    /// The brakings of what is told that begin by a step; not those of which only the end is told.
    fn brakings(&self, drive: &Drive, until: i64) -> Vec<Change> {
        let (first, begin) = (self.window.first(), self.span().0);
        let is_told = |change: &Change| {
            let (from, to) = change.steps;
            from <= until && (from >= first || self.time(to) - begin >= WHILE)
        };
        drive.brakings().into_iter().filter(is_told).collect()
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

    /// Who leaves first the place where both ways overlap.
    fn pass(&self) -> Option<Fact> {
        let passing = self.context.passing(self.participant)?;
        // Ways of who follows overlap all along.
        let step = (passing.left / self.context.scene().scenario.dt()).round() as i64;
        let encounter = self.encounter(step)?;
        let [ego, other] = [encounter.ego, encounter.other].map(|motion| motion.pose.heading);
        if angle_between(ego, other).abs() < CROSSING {
            return None;
        }
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

    /// Since which step the time to collision is short until another one; nothing where it is not.
    fn short_since(&self, until: i64) -> Option<(i64, i64)> {
        let is_short = |step: &i64| self.ttc(*step).is_some_and(|seconds| seconds <= SHORT);
        let since = { (i64::MIN..=until).rev() }.take_while(is_short).last()?;
        Some((since, until))
    }

    fn short_ttc(&self, since: i64, until: i64) -> Fact {
        Fact::ShortTtc {
            time: self.time(since),
            until: self.time(until),
        }
    }
}

/// Facts in the order of their times.
fn in_order(mut facts: Vec<Fact>) -> Vec<Fact> {
    let from = |fact: &Fact| match fact {
        Fact::Brake { from, .. } | Fact::NoBrake { from, .. } | Fact::SpeedUp { from, .. } => *from,
        _ => 0.0,
    };
    facts.sort_by(|a, b| from(a).total_cmp(&from(b)));
    facts
}

/// The change by most.
fn largest(changes: Vec<Change>) -> Option<Change> {
    let all = changes.into_iter();
    all.max_by(|a, b| a.gain().abs().total_cmp(&b.gain().abs()))
}

/// A rise of the speed that is told beside other things.
fn rise(drive: &Drive) -> Option<Change> {
    drive.rise().filter(|change| change.gain() >= RISE)
}

/// Whether who has up to such a speed does more than keep on where it changes by so much, m/s.
fn is_change(by: f64, high: f64) -> bool {
    by >= NOTABLE.max(0.1 * high)
}

/// Whether times differ as they are told.
fn is_while(from: f64, to: f64) -> bool {
    to - from >= 0.1
}

fn ttc_measure() -> Option<&'static Measure> {
    measure("ttc")
}
