//! Claims about obstacles in the free text of an answer, extracted, counted, and checked against the geometry.
//!
//! Only unambiguous claims are extracted: an obstacle, a measure that is named or clear from the unit, and a value with
//! its unit; no bounds, ranges, suppositions or steps of a calculation. What is not extracted is not called right.

mod above;
mod cast;
mod check;
mod clauses;
mod compared;
mod consistency;
mod contacts;
mod ego;
mod excuses;
mod find;
mod guards;
mod labelled;
mod lanelets;
mod language;
mod lengths;
mod located;
mod measured;
mod mentions;
mod number;
mod phrases;
mod pieces;
mod places;
mod plans;
mod quantity;
mod reading;
mod record;
mod references;
mod score;
mod second_reader;
mod sentence;
mod sentences;
mod speech;
mod speeds;
mod stated;
mod tables;
mod tokens;
mod traces;
mod truth;
mod verbs;
mod windowed;
mod worded;

use std::collections::BTreeSet;
use std::ops::Range;

use nearmiss_scene::description::{has_relative_times, visible};
use nearmiss_scene::metrics::RiskAspect;
use nearmiss_scene::scenario::{ObstacleType, Scene, Window};
use nearmiss_scene::verdict::{ReasonedAnswer, reasons_first};
use nearmiss_store::ClaimCounts;

pub use check::{CheckedClaim, ClaimBasis, Judgement, TOLERANCES, check};
pub use labelled::{AgreementRow, agreement};
pub use language::{samples, written};
pub use record::{ClaimRecord, SentenceRecord};
pub use second_reader::{Untranslated, translation_schema, untranslated};
use sentences::sentences_with;
pub use sentences::{CheckedSentence, SentenceOutcome, sentences};
pub use traces::{Trace, TraceError, TruthRow, sentences_of, truth_table, waypoints};

/// The quantity a claim states about an obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    /// Distance to the ego, metres.
    Distance,
    /// The least distance that is left, by some measure, metres: "MDC".
    LeastDistance,
    /// The smallest distance in the window, metres.
    MinDistance,
    /// Free distance along the ego's heading, metres.
    GapLong,
    /// Free distance across it, metres.
    GapLat,
    /// Free distance ahead or behind, metres: along the ego's heading or in all.
    DistanceAlong,
    /// Free distance to a side, metres: across the ego's heading or in all.
    DistanceAcross,
    /// Time to collision, seconds; which one is not said.
    Ttc,
    /// Time to close the gap along the ego's heading, seconds.
    TtcLong,
    /// Time to close the gap across it, seconds.
    TtcLat,
    /// Velocity minus the ego's along its heading, m/s.
    VelocityLong,
    /// Velocity minus the ego's across its heading, m/s.
    VelocityLat,
    /// Acceleration minus the ego's along its heading, m/s².
    AccelerationLong,
    /// Acceleration minus the ego's across its heading, m/s².
    AccelerationLat,
    /// How fast the distance shrinks, m/s; which one is not said.
    ClosingSpeed,
    /// Time headway, seconds.
    Headway,
    /// Its heading on the map or seen from the ego, degrees.
    Heading,
    /// Its own speed, m/s.
    Speed,
    /// Its own acceleration, m/s².
    Acceleration,
    /// Where it is, seen from the ego.
    Side,
    /// That it touches the ego at a step.
    Contact,
    /// When something of it happened.
    Time,
    /// What it does: how its distance or its speed changes.
    Motion,
    /// Where it goes and in which lane it is.
    Way,
    /// How it compares with another one, or with all.
    Comparison,
    /// How many are somewhere or do something.
    Count,
    /// What the ego is said to do next, held against the trajectory that came with it.
    Plan,
    /// Its risk score, 0 to 5.
    Risk,
    /// Where it is on the map.
    Position,
    /// A calculation.
    Arithmetic,
}

impl Quantity {
    /// Its name for people.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Distance | Self::DistanceAlong | Self::DistanceAcross => "distance",
            Self::LeastDistance => "least distance",
            Self::MinDistance => "minimum distance",
            Self::ClosingSpeed => "closing speed",
            Self::Headway => "time headway",
            Self::Heading => "heading",
            Self::Comparison => "comparison",
            Self::Count => "count",
            Self::Plan => "plan",
            Self::GapLong => "gap longitudinal",
            Self::GapLat => "gap lateral",
            Self::Ttc => "TTC",
            Self::TtcLong => "TTC longitudinal",
            Self::TtcLat => "TTC lateral",
            Self::VelocityLong => "relative velocity longitudinal",
            Self::VelocityLat => "relative velocity lateral",
            Self::AccelerationLong => "relative acceleration longitudinal",
            Self::AccelerationLat => "relative acceleration lateral",
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
            Self::Side => "direction",
            Self::Contact => "contact",
            Self::Time => "time",
            Self::Motion => "motion",
            Self::Way => "way",
            Self::Risk => "risk score",
            Self::Position => "position",
            Self::Arithmetic => "arithmetic",
        }
    }

    /// Its unit; empty for what is no number.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Distance
            | Self::DistanceAlong
            | Self::DistanceAcross
            | Self::LeastDistance
            | Self::MinDistance
            | Self::GapLong
            | Self::GapLat => "m",
            Self::Ttc | Self::TtcLong | Self::TtcLat | Self::Headway => "s",
            Self::VelocityLong | Self::VelocityLat | Self::Speed | Self::ClosingSpeed => "m/s",
            Self::Heading => "°",
            Self::AccelerationLong | Self::AccelerationLat | Self::Acceleration => "m/s²",
            Self::Side
            | Self::Contact
            | Self::Time
            | Self::Motion
            | Self::Way
            | Self::Comparison
            | Self::Count
            | Self::Plan
            | Self::Risk
            | Self::Position
            | Self::Arithmetic => "",
        }
    }
}

/// Claimed position of an obstacle: along the ego's heading, across it, or both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Side {
    /// In front (true) or behind (false), if that is said.
    pub front: Option<bool>,
    /// Left (true) or right (false), if that is said.
    pub left: Option<bool>,
}

impl std::fmt::Display for Side {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match (self.front, self.left) {
            (Some(true), None) => "in front",
            (Some(false), None) => "behind",
            (None, Some(true)) => "left",
            (None, Some(false)) => "right",
            (Some(true), Some(true)) => "front left",
            (Some(true), Some(false)) => "front right",
            (Some(false), Some(true)) => "rear left",
            (Some(false), Some(false)) => "rear right",
            (None, None) => "nowhere",
        })
    }
}

/// The claimed value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClaimedValue {
    /// A number in the quantity's unit.
    Number {
        /// The number.
        value: f64,
        /// Digits behind the point.
        decimals: u8,
        /// Whether it is said to be rough.
        rough: bool,
        /// Whether it is a magnitude: a closing speed, a braking.
        magnitude: bool,
    },
    /// A number in the quantity's unit between two, its sign apart; `None` where there is no bound on that side.
    Bounds {
        /// Not less than this.
        from: Option<f64>,
        /// Not more than this.
        to: Option<f64>,
        /// Digits behind the point.
        decimals: u8,
    },
    /// A place.
    Side(Side),
    /// That the bodies touch.
    Contact,
    /// That it happened at the step of the claim.
    Event(Event),
    /// What is said in words.
    Word {
        /// What.
        predicate: Predicate,
        /// Whether it is denied.
        is_denied: bool,
    },
    /// A risk score, 0 to 5.
    Score {
        /// The score.
        score: u8,
        /// What it is of.
        of: RiskAspect,
    },
    /// That so many are there of which something holds.
    Count {
        /// How many.
        number: u8,
        /// What is said of each.
        of: Counted,
        /// Of which two types; `None` of all.
        types: Option<(ObstacleType, ObstacleType)>,
    },
    /// From one number to another one, with digits behind the point of both.
    Change {
        /// Before.
        from: f64,
        /// After.
        to: f64,
        /// Digits behind the point.
        decimals: u8,
        /// Whether they are said to be rough.
        rough: bool,
    },
    /// A place on the map, metres, with digits behind the point.
    Place(f64, f64, u8),
    /// The result of a division that the sentence writes down: dividend, divisor and result, each with digits behind the point.
    Quotient([(f64, u8); 3]),
}

/// What happens at a moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// The bodies touch for the first time.
    Contact,
    /// They are as close as never else in the window.
    Closest,
    /// One passes the other.
    Passing,
}

impl std::fmt::Display for Event {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Contact => "first contact",
            Self::Closest => "closest",
            Self::Passing => "passing",
        })
    }
}

/// At which steps of the window a claim is to hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Extent {
    /// At its step.
    #[default]
    Moment,
    /// Its number is the least of the window.
    Least,
    /// Its number is the greatest of the window.
    Most,
    /// At all of them.
    All,
}

/// What is said of an obstacle in words. An axis is that along (true) or across the ego's heading, where one is named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Predicate {
    /// Its distance shrinks.
    Approaching(Option<bool>),
    /// Its distance grows.
    Receding(Option<bool>),
    /// It gets slower.
    Braking,
    /// It gets faster.
    Accelerating,
    /// It brakes (true) or accelerates hard.
    Hard(bool),
    /// It brakes (true) or accelerates a little.
    Gentle(bool),
    /// It keeps its speed.
    Steady,
    /// Its distance stays the same.
    KeepsDistance(Option<bool>),
    /// Faster than the ego.
    FasterThanEgo,
    /// Slower than the ego.
    SlowerThanEgo,
    /// It drives in the ego's direction.
    SameWay,
    /// It drives in the opposite direction.
    Oncoming,
    /// It drives in one of both.
    Parallel,
    /// It is not at rest.
    Moving,
    /// It comes to a stop.
    Stops,
    /// Its relative velocity along (true) or across the ego's heading has this sign: true for positive.
    Signed(bool, bool),
    /// It turns to the left (true) or right.
    Turning(bool),
    /// Its way crosses that of the ego.
    Crossing,
    /// It goes from one lane into another.
    ChangesLane,
    /// It comes into the ego's lane, ahead of it.
    CutsIn,
    /// Its body and the ego's overlap along the ego's heading.
    Beside,
    /// It is there.
    At(Side),
    /// It was there at first.
    CameFrom(Side),
    /// In the lane to the left (true) or right of the ego's.
    NeighbourLane(bool),
    /// More or less than another one, or than all.
    Compared(Compared),
    /// In the ego's lane, ahead of it or behind.
    SameLane,
    /// In another one.
    OtherLane,
    /// On the ego's lanelet.
    SameLanelet,
    /// On another one.
    OtherLanelet,
    /// On the lanelet with this id.
    OnLanelet(i64),
    /// It touches the ego.
    Touches,
    /// It will.
    WillTouch,
}

/// What is counted: those of whom this holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Counted {
    /// What is said in words.
    Word(Predicate),
    /// Two such things.
    Both(Predicate, Predicate),
    /// That the distance is at most so much, metres.
    Within(f64),
    /// That it is there at all.
    There,
    /// That it is in the lane to the left (true) or right of the ego's, and not far.
    Near(bool),
}

impl std::fmt::Display for Counted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Word(predicate) => predicate.fmt(f),
            Self::Both(one, other) => write!(f, "{one} and {other}"),
            Self::Within(metres) => write!(f, "within {metres} m"),
            Self::There => f.write_str("there"),
            Self::Near(left) => write!(f, "{}", Predicate::NeighbourLane(*left)),
        }
    }
}

/// What two are compared by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// Distance to the ego.
    Distance,
    /// Speed.
    Speed,
    /// Time to collision.
    Ttc,
    /// Risk: the lower the score, the more.
    Risk,
    /// How hard it brakes.
    Braking,
}

/// A comparison of an obstacle with another one, or with all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Compared {
    /// By what.
    pub of: Dimension,
    /// Whether it is more, not less.
    pub is_more: bool,
    /// Than which; `None` for all others.
    pub than: Option<i64>,
    /// Of all, how many are before it: 1 for "the second closest".
    pub rank: u8,
}

impl Predicate {
    /// Of what kind it is.
    #[must_use]
    pub fn quantity(self) -> Quantity {
        match self {
            Self::Approaching(_)
            | Self::Receding(_)
            | Self::Braking
            | Self::Accelerating
            | Self::Hard(_)
            | Self::Gentle(_)
            | Self::KeepsDistance(_)
            | Self::Steady
            | Self::Moving
            | Self::Stops
            | Self::Turning(_)
            | Self::Crossing
            | Self::ChangesLane
            | Self::CutsIn
            | Self::FasterThanEgo
            | Self::SlowerThanEgo => Quantity::Motion,
            Self::Signed(true, _) => Quantity::VelocityLong,
            Self::Signed(false, _) => Quantity::VelocityLat,
            Self::At(_) | Self::CameFrom(_) | Self::Beside => Quantity::Side,
            Self::Compared(_) => Quantity::Comparison,
            Self::NeighbourLane(_)
            | Self::SameWay
            | Self::Oncoming
            | Self::Parallel
            | Self::SameLane
            | Self::OtherLane
            | Self::SameLanelet
            | Self::OtherLanelet
            | Self::OnLanelet(_) => Quantity::Way,
            Self::Touches | Self::WillTouch => Quantity::Contact,
        }
    }
}

impl std::fmt::Display for Predicate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let along = |axis: &Option<bool>| match axis {
            None => "",
            Some(true) => " longitudinally",
            Some(false) => " laterally",
        };
        match self {
            Self::Approaching(axis) => write!(f, "approaching{}", along(axis)),
            Self::Receding(axis) => write!(f, "moving away{}", along(axis)),
            Self::Braking => f.write_str("braking"),
            Self::Accelerating => f.write_str("accelerating"),
            Self::Hard(true) => f.write_str("braking hard"),
            Self::Hard(false) => f.write_str("accelerating hard"),
            Self::Gentle(true) => f.write_str("braking gently"),
            Self::Gentle(false) => f.write_str("accelerating gently"),
            Self::KeepsDistance(axis) => write!(f, "keeping its distance{}", along(axis)),
            Self::Steady => f.write_str("at constant speed"),
            Self::FasterThanEgo => f.write_str("faster than the ego"),
            Self::SlowerThanEgo => f.write_str("slower than the ego"),
            Self::Moving => f.write_str("moving"),
            Self::Stops => f.write_str("stopping"),
            Self::Signed(_, true) => f.write_str("positive"),
            Self::Signed(_, false) => f.write_str("negative"),
            Self::Turning(left) => write!(f, "turning {}", if *left { "left" } else { "right" }),
            Self::Crossing => f.write_str("crossing"),
            Self::ChangesLane => f.write_str("changing lanes"),
            Self::CutsIn => f.write_str("cutting in"),
            Self::Beside => f.write_str("beside"),
            Self::At(side) => side.fmt(f),
            Self::CameFrom(side) => write!(f, "from {side}"),
            Self::NeighbourLane(left) => {
                write!(f, "in the {} lane", if *left { "left" } else { "right" })
            }
            Self::Compared(Compared {
                of,
                is_more,
                than,
                rank,
            }) => {
                let of = match of {
                    Dimension::Distance => "distance",
                    Dimension::Speed => "speed",
                    Dimension::Ttc => "TTC",
                    Dimension::Risk => "risk",
                    Dimension::Braking => "braking",
                };
                if *rank > 0 {
                    write!(f, "{}. ", rank + 1)?;
                }
                match (than, is_more) {
                    (Some(id), true) => write!(f, "more {of} than {id}"),
                    (Some(id), false) => write!(f, "less {of} than {id}"),
                    (None, true) => write!(f, "most {of}"),
                    (None, false) => write!(f, "least {of}"),
                }
            }
            Self::SameWay => f.write_str("in the same direction"),
            Self::Oncoming => f.write_str("in the opposite direction"),
            Self::Parallel => f.write_str("parallel to the ego"),
            Self::SameLane => f.write_str("in the ego's lane"),
            Self::OtherLane => f.write_str("in another lane"),
            Self::SameLanelet => f.write_str("on the ego's lanelet"),
            Self::OtherLanelet => f.write_str("on another lanelet"),
            Self::OnLanelet(id) => write!(f, "on lanelet {id}"),
            Self::Touches => f.write_str("contact"),
            Self::WillTouch => f.write_str("contact to come"),
        }
    }
}

/// A claim about an obstacle.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// Where its value stands in the text, bytes.
    pub span: Range<usize>,
    /// Which obstacle, or the ego.
    pub obstacle: i64,
    /// Whether that is the ego.
    pub is_of_ego: bool,
    /// Whether it is said of a time before: at any step up to the present.
    pub is_past: bool,
    /// Whether only a description of whom is meant says it: "the lead car" is one that is ahead.
    pub is_described: bool,
    /// Whether its own sentence names the obstacle, not only what it stands under.
    pub named: bool,
    /// The claimed quantity.
    pub quantity: Quantity,
    /// The claimed value.
    pub stated: ClaimedValue,
    /// The time step that is named; `None` if none is.
    pub step: Option<i64>,
    /// At which steps it is to hold.
    pub extent: Extent,
    /// Whether its clause may speak of another time than the sentences around it: then it contradicts none of them.
    pub is_apart: bool,
}

/// What the times in an answer count from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum TimeOrigin {
    /// Time step 0 of the recording; steps are named, too.
    #[default]
    Recording,
    /// The end of the described window: earlier times are negative.
    WindowEnd,
}

impl TimeOrigin {
    /// Of answers to these messages, or to this description.
    #[must_use]
    pub fn from_messages(messages: &str) -> Self {
        if has_relative_times(messages) {
            Self::WindowEnd
        } else {
            Self::Recording
        }
    }
}

/// Where the ego is to be at a time: of a trajectory that came with a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// Seconds from the present.
    pub time: f64,
    /// Metres, in any frame that does not move.
    pub x: f64,
    /// Metres.
    pub y: f64,
}

/// The scene a text is about.
#[derive(Debug, Clone)]
pub struct Subject<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What its times count from.
    pub times: TimeOrigin,
    /// First and last step that were described; `None` if that is not known.
    pub window: Option<(i64, i64)>,
    /// What the model was shown, where that is known: numbers that are not in it are invented.
    pub prompt: Option<&'a str>,
    /// The trajectory that came with the text; empty if none did.
    pub trajectory: &'a [Waypoint],
}

impl<'a> Subject<'a> {
    /// A scene whose text has times of this origin, and that was described in these steps.
    #[must_use]
    pub fn new(scene: &'a Scene, times: TimeOrigin, window: Option<(i64, i64)>) -> Self {
        Self {
            scene,
            times,
            window,
            prompt: None,
            trajectory: &[],
        }
    }

    /// The step that is meant where none is named: the last of the window, else of the recording.
    #[must_use]
    pub fn present(&self) -> i64 {
        self.window.map_or(self.scene.last_step(), |(_, last)| last)
    }

    /// The window, or one step where it is not known.
    fn steps(&self) -> Window {
        let (first, last) = self.window.unwrap_or((self.present(), self.present()));
        let history = usize::try_from(last.saturating_sub(first)).unwrap_or(0) + 1;
        Window::ending_at(self.scene, last, history)
    }
}

/// The claims in a text, in its order.
#[must_use]
pub fn find(text: &str, subject: &Subject<'_>) -> Vec<Claim> {
    let all = &subject.scene.scenario.obstacles;
    let ids: BTreeSet<i64> = all.iter().map(|o| o.id).collect();
    let world = find::MentionContext {
        subject: Some(subject),
        present: subject.present(),
        has_trajectory: !subject.trajectory.is_empty(),
        ids: &ids,
        ego: subject.scene.ego.id,
        dt: subject.scene.scenario.dt(),
        steps: subject.scene.steps(),
        now: match (subject.times, subject.window) {
            (TimeOrigin::WindowEnd, Some((_, last))) => Some(last),
            _ => None,
        },
    };
    find::claims(text, &world)
}

/// The claims in a text, each checked against the geometry.
#[must_use]
pub fn checked(text: &str, subject: &Subject<'_>) -> Vec<CheckedClaim> {
    let claims = find(text, subject);
    claims.into_iter().map(|c| check(c, subject)).collect()
}

/// The version of finding and checking claims: grows when the same text can give other counts, so that stored ones
/// are counted anew.
pub const CHECK: u32 = 8;

/// The separator between reasoning and answer.
const ANSWER: &str = "── answer ──";

/// The heading of the reasoning.
const REASONING: &str = "── reasoning ──";

/// An answer as it is read and checked: its reasoning, then its text. Unless it is shown `raw`, the reasons that its JSON
/// begins with are before that JSON, and the fence that all of it stands in is gone. Safe to show on a terminal.
#[must_use]
pub fn shown_text(reasoning: &str, answer: &str, raw: bool) -> String {
    let bare = if raw { answer } else { unfenced(answer) };
    let readable = (!raw).then(|| readable(bare)).flatten();
    let answer = readable.as_deref().unwrap_or(bare);
    match (reasoning.is_empty(), answer.is_empty()) {
        (true, _) => visible(answer).into_owned(),
        // The heading is there from the start, so that nothing moves when the answer begins.
        (false, true) => visible(&format!("{REASONING}\n{reasoning}")).into_owned(),
        (false, false) => {
            let whole = format!("{REASONING}\n{reasoning}\n\n{ANSWER}\n{answer}");
            visible(&whole).into_owned()
        }
    }
}

/// An answer without the fence that encloses all of it, as far as it has arrived; one of code keeps its fence.
fn unfenced(answer: &str) -> &str {
    const TEXTS: [&str; 5] = ["", "json", "markdown", "md", "text"];
    let body = answer.trim_start();
    let (fence, rest) = body.split_at(body.len() - body.trim_start_matches('`').len());
    let letters = rest.bytes().take_while(u8::is_ascii_alphabetic).count();
    let (word, inside) = rest.split_at(letters);
    let inside = inside.trim_start_matches([' ', '\r']);
    let is_text = TEXTS.contains(&word.to_ascii_lowercase().as_str());
    if fence.len() < 3 || !is_text || !(inside.is_empty() || inside.starts_with(['\n', '{'])) {
        return answer;
    }
    let (mut at, mut nested) = (0, 0);
    for line in inside.split_inclusive('\n') {
        match line.trim().strip_prefix(fence) {
            Some("") if nested == 0 => {
                let is_all = inside[at + line.len()..].trim().is_empty();
                let text = inside[..at].trim_start_matches('\n');
                return if is_all { text } else { answer };
            }
            Some("") => nested -= 1,
            Some(_) => nested += 1,
            None => {}
        }
        at += line.len();
    }
    let inside = inside.trim_start_matches('\n').trim_end();
    inside.strip_suffix(fence).unwrap_or(inside)
}

/// An answer with the reasons that its JSON begins with before that JSON, as text.
fn readable(answer: &str) -> Option<String> {
    let ReasonedAnswer { reasons, rest } = reasons_first(answer)?;
    Some(if rest.is_empty() {
        reasons
    } else {
        format!("{reasons}\n\n{rest}")
    })
}

/// How many claims are right, wrong, and cannot be decided.
#[must_use]
pub fn counted(claims: &[CheckedClaim]) -> (usize, usize, usize) {
    let count = |is: fn(&Judgement) -> bool| claims.iter().filter(|c| is(&c.judgement)).count();
    (
        count(|j| *j == Judgement::Right),
        count(|j| *j == Judgement::Wrong),
        count(|j| matches!(j, Judgement::Unknown(_))),
    )
}

/// The claims of an answer, found, checked and counted.
#[must_use]
pub fn count(reasoning: &str, answer: &str, subject: &Subject<'_>) -> ClaimCounts {
    let text = shown_text(reasoning, answer, false);
    let claims = checked(&text, subject);
    let (right, wrong, open) = counted(&claims);
    let sentences = sentences_with(&text, claims, subject);
    let number = |n: usize| u32::try_from(n).ok();
    let of = |is: fn(&CheckedSentence) -> bool| sentences.iter().filter(|one| is(one)).count();
    let invented = sentences.iter().map(|one| one.invented.len()).sum();
    ClaimCounts {
        claims_right: number(right),
        claims_wrong: number(wrong),
        claims_open: number(open),
        claims_invented: subject.prompt.and_then(|_| number(invented)),
        sentences: number(sentences.len()),
        sentences_not_understood: number(of(|one| one.outcome == SentenceOutcome::NotUnderstood)),
        sentences_contradictory: number(of(|one| !one.contradicts.is_empty())),
        claims_check: Some(CHECK),
    }
}

#[cfg(test)]
mod tests;
