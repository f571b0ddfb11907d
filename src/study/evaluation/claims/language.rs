//! The claim language: a claim as a sentence that the rules read back as the same claim.

use nearmiss_scene::metrics::RiskAspect;
use nearmiss_scene::scenario::ObstacleType;

use super::{
    Claim, ClaimedValue, Compared, Counted, Dimension, Event, Extent, Predicate, Quantity, Side,
};

/// A claim as a sentence of the claim language. Its time is that of [`Claim::step`], as a step of the recording.
#[must_use]
pub fn written(claim: &Claim) -> String {
    let who = if claim.is_of_ego {
        "the ego".to_owned()
    } else {
        format!("obstacle {}", claim.obstacle)
    };
    let said = said(claim, &who);
    let mut letters = said.chars();
    match (claim.step, letters.next()) {
        (Some(step), _) => format!("At step {step}, {said}."),
        (None, Some(first)) => format!("{}{}.", first.to_uppercase(), letters.as_str()),
        (None, None) => String::new(),
    }
}

fn said(claim: &Claim, who: &str) -> String {
    let unit = claim.quantity.unit();
    let noun = noun(claim.quantity);
    match claim.stated {
        ClaimedValue::Number { value, .. } if value.is_infinite() => {
            format!("the {noun} of {who} is infinite")
        }
        ClaimedValue::Number {
            value,
            decimals,
            rough,
            ..
        } => {
            let about = if rough { "about " } else { "" };
            let number = format!("{about}{value:.*} {unit}", usize::from(decimals));
            match claim.quantity {
                Quantity::DistanceAlong if value < 0.0 => {
                    format!("{who} is {} behind the ego", number.replace('-', ""))
                }
                Quantity::DistanceAlong => format!("{who} is {number} ahead of the ego"),
                Quantity::DistanceAcross if value < 0.0 => {
                    format!(
                        "{who} is {} to the right of the ego",
                        number.replace('-', "")
                    )
                }
                Quantity::DistanceAcross => format!("{who} is {number} to the left of the ego"),
                _ => format!("the {noun} of {who} is {number}"),
            }
        }
        ClaimedValue::Bounds { from, to, decimals } => {
            let decimals = usize::from(decimals);
            let bounds = match (from, to) {
                (Some(from), Some(to)) => {
                    format!("between {from:.decimals$} {unit} and {to:.decimals$} {unit}")
                }
                (Some(from), None) => format!("more than {from:.decimals$} {unit}"),
                (None, to) => format!("less than {:.decimals$} {unit}", to.unwrap_or(0.0)),
            };
            format!("the {noun} of {who} is {bounds}")
        }
        ClaimedValue::Change {
            from,
            to,
            decimals,
            rough,
        } => {
            let decimals = usize::from(decimals);
            let about = if rough { "about " } else { "" };
            format!(
                "the {noun} of {who} changes from {about}{from:.decimals$} {unit} to {to:.decimals$} {unit}"
            )
        }
        ClaimedValue::Side(side) => format!("{who} is {}", place(side)),
        ClaimedValue::Contact | ClaimedValue::Event(Event::Contact) => {
            format!("{who} touches the ego")
        }
        ClaimedValue::Event(Event::Closest) => {
            format!("the minimum distance of {who} is reached")
        }
        ClaimedValue::Event(Event::Passing) => format!("{who} passes the ego"),
        ClaimedValue::Word {
            predicate,
            is_denied,
        } => word(predicate, is_denied, who),
        ClaimedValue::Score { score, of } => {
            let of = match of {
                RiskAspect::Overall => String::new(),
                RiskAspect::Distance(axis) => format!("{}distance ", axis_word(axis)),
                RiskAspect::Time(axis) => format!("{}time ", axis_word(axis)),
            };
            format!("the {of}risk score of {who} is {score}")
        }
        ClaimedValue::Count { number, of, types } => count(number, of, types),
        ClaimedValue::Place(x, y, decimals) => {
            let decimals = usize::from(decimals);
            format!("the position of {who} is ({x:.decimals$}, {y:.decimals$})")
        }
        ClaimedValue::Quotient(parts) => {
            let [a, b, c] =
                parts.map(|(value, decimals)| format!("{value:.*}", usize::from(decimals)));
            format!("the TTC of {who} is {a} m / {b} m/s = {c} s")
        }
    }
}

/// What the number of a quantity is called.
fn noun(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::LeastDistance => "MDC",
        Quantity::MinDistance => "minimum distance",
        Quantity::GapLong | Quantity::DistanceAlong => "longitudinal distance",
        Quantity::GapLat | Quantity::DistanceAcross => "lateral distance",
        Quantity::TtcLong => "longitudinal TTC",
        Quantity::TtcLat => "lateral TTC",
        Quantity::VelocityLong => "relative longitudinal velocity",
        Quantity::VelocityLat => "relative lateral velocity",
        Quantity::AccelerationLong => "relative longitudinal acceleration",
        Quantity::AccelerationLat => "relative lateral acceleration",
        other => other.name(),
    }
}

fn axis_word(axis: Option<bool>) -> &'static str {
    super::worded::axis_word(axis)
}

fn place(side: Side) -> &'static str {
    match (side.front, side.left) {
        (Some(true), None) => "ahead of the ego",
        (Some(false), None) => "behind the ego",
        (None, Some(true)) => "to the left of the ego",
        (None, Some(false)) => "to the right of the ego",
        (Some(true), Some(true)) => "ahead and to the left of the ego",
        (Some(true), Some(false)) => "ahead and to the right of the ego",
        (Some(false), Some(true)) => "behind and to the left of the ego",
        (Some(false), Some(false)) => "behind and to the right of the ego",
        (None, None) => "there",
    }
}

/// What is said in words, or its denial.
fn word(predicate: Predicate, is_denied: bool, who: &str) -> String {
    let axis = |axis: Option<bool>| match axis {
        None => "",
        Some(true) => " longitudinally",
        Some(false) => " laterally",
    };
    // After "is", or "is not".
    let being = match predicate {
        Predicate::Approaching(of) => format!("approaching the ego{}", axis(of)),
        Predicate::Receding(of) => format!("moving away from the ego{}", axis(of)),
        Predicate::Braking => "braking".into(),
        Predicate::Accelerating => "accelerating".into(),
        Predicate::Hard(brakes) | Predicate::Gentle(brakes) => {
            let verb = if brakes { "braking" } else { "accelerating" };
            let is_hard = matches!(predicate, Predicate::Hard(_));
            format!("{verb} {}", if is_hard { "hard" } else { "gently" })
        }
        Predicate::FasterThanEgo => "faster than the ego".into(),
        Predicate::SlowerThanEgo => "slower than the ego".into(),
        Predicate::SameWay => "driving in the same direction as the ego".into(),
        Predicate::Oncoming => "driving in the opposite direction".into(),
        Predicate::Parallel => "moving parallel to the ego".into(),
        Predicate::Moving => "moving".into(),
        Predicate::Turning(left) => format!("turning {}", if left { "left" } else { "right" }),
        Predicate::Crossing => "crossing the path of the ego".into(),
        Predicate::ChangesLane => "changing lanes".into(),
        Predicate::CutsIn => "cutting in".into(),
        Predicate::Beside => "beside the ego".into(),
        Predicate::At(side) => place(side).into(),
        Predicate::NeighbourLane(left) => {
            format!("in the {} lane", if left { "left" } else { "right" })
        }
        Predicate::SameLane => "in the same lane as the ego".into(),
        Predicate::OtherLane => "in a different lane".into(),
        Predicate::SameLanelet => "on the same lanelet as the ego".into(),
        Predicate::OtherLanelet => "on a different lanelet".into(),
        Predicate::OnLanelet(id) => format!("on lanelet {id}"),
        Predicate::Compared(compared) => return comparison(compared, is_denied, who),
        Predicate::KeepsDistance(of) => {
            let keeps = if is_denied { "does not keep" } else { "keeps" };
            let along = match of {
                None => "",
                Some(true) => "longitudinal ",
                Some(false) => "lateral ",
            };
            return format!("{who} {keeps} its {along}distance");
        }
        Predicate::Signed(long, positive) => {
            let has = if is_denied { "does not have" } else { "has" };
            let sign = if positive { "positive" } else { "negative" };
            let axis = if long { "longitudinal" } else { "lateral" };
            return format!("{who} {has} a {sign} relative {axis} velocity");
        }
        Predicate::Stops if is_denied => return format!("{who} does not stop"),
        Predicate::Stops => return format!("{who} comes to a stop"),
        Predicate::Steady if is_denied => return format!("{who} does not keep its speed"),
        Predicate::Steady => return format!("{who} keeps its speed"),
        Predicate::CameFrom(side) => {
            let comes = if is_denied { "does not come" } else { "comes" };
            return format!("{who} {comes} from {side}");
        }
        Predicate::Touches if is_denied => return format!("{who} does not touch the ego"),
        Predicate::Touches => return format!("{who} touches the ego"),
        Predicate::WillTouch if is_denied => return format!("{who} will not collide with the ego"),
        Predicate::WillTouch => return format!("{who} will collide with the ego"),
    };
    format!("{who} is {}{being}", if is_denied { "not " } else { "" })
}

/// More or less than another one, or than all.
fn comparison(compared: Compared, is_denied: bool, who: &str) -> String {
    let (more, most) = match (compared.of, compared.is_more) {
        (Dimension::Distance, true) => ("farther from the ego", "farthest from the ego"),
        (Dimension::Distance, false) => ("closer to the ego", "closest to the ego"),
        (Dimension::Speed, true) => ("faster", "fastest"),
        (Dimension::Speed, false) => ("slower", "slowest"),
        (Dimension::Ttc, true) => ("a longer TTC", "longest TTC"),
        (Dimension::Ttc, false) => ("a shorter TTC", "shortest TTC"),
        (Dimension::Risk, true) => ("a higher risk", "highest risk"),
        (Dimension::Risk, false) => ("a lower risk", "lowest risk"),
        // Nobody is said to brake less.
        (Dimension::Braking, _) => ("braking harder", "braking the hardest"),
    };
    let is_own = matches!(compared.of, Dimension::Ttc | Dimension::Risk);
    let verb = match (is_own, is_denied) {
        (true, false) => "has",
        (true, true) => "does not have",
        (false, false) => "is",
        (false, true) => "is not",
    };
    let rank = match compared.rank {
        0 => "",
        1 => "second ",
        _ => "third ",
    };
    match compared.than {
        Some(id) => format!("{who} {verb} {more} than obstacle {id}"),
        None if compared.of == Dimension::Braking => format!("{who} {verb} {most}"),
        None => format!("{who} {verb} the {rank}{most}"),
    }
}

/// How many there are of which something holds.
fn count(number: u8, of: Counted, types: Option<(ObstacleType, ObstacleType)>) -> String {
    let noun = match types {
        None => "vehicle",
        Some((ObstacleType::Pedestrian, _)) => "pedestrian",
        Some((ObstacleType::Bicycle, _)) => "cyclist",
        Some((ObstacleType::Truck, _)) => "truck",
        Some((ObstacleType::Bus, _)) => "bus",
        Some((ObstacleType::Motorcycle, _)) => "motorcycle",
        Some(_) => "car",
    };
    let (noun, is) = match number {
        1 => (noun.to_owned(), "is"),
        _ if noun == "bus" => ("buses".into(), "are"),
        _ => (format!("{noun}s"), "are"),
    };
    let counted = format!("{number} {noun}");
    let of_them =
        |predicate| word(predicate, false, &counted).replacen(" is ", &format!(" {is} "), 1);
    match of {
        Counted::There => format!("there {is} {counted} around the ego"),
        Counted::Near(left) => {
            format!("the {} lane is free", if left { "left" } else { "right" })
        }
        Counted::Both(one, other) => {
            let first = of_them(one);
            let second = of_them(other);
            format!(
                "{first} {}",
                second.replacen(&format!("{counted} {is} "), "", 1)
            )
        }
        Counted::Within(metres) => format!("{number} {noun} {is} within {metres} m of the ego"),
        Counted::Word(predicate) => of_them(predicate),
    }
}

/// A claim of each kind, about these two obstacles: what the language has.
#[must_use]
pub fn samples(id: i64, other: i64, ego: i64) -> Vec<Claim> {
    let claim = |quantity: Quantity, stated: ClaimedValue| Claim {
        span: 0..0,
        obstacle: id,
        is_of_ego: false,
        is_past: false,
        is_described: false,
        named: true,
        quantity,
        stated,
        step: None,
        extent: Extent::Moment,
        is_apart: false,
    };
    let number = |value: f64, decimals: u8| ClaimedValue::Number {
        value,
        decimals,
        rough: false,
        magnitude: false,
    };
    let numbers = [
        (Quantity::Distance, number(12.5, 1)),
        (Quantity::MinDistance, number(7.77, 2)),
        (Quantity::LeastDistance, number(1.25, 2)),
        (Quantity::GapLong, number(-20.7, 1)),
        (Quantity::GapLat, number(3.1, 1)),
        (Quantity::DistanceAlong, number(20.7, 1)),
        (Quantity::DistanceAlong, number(-20.7, 1)),
        (Quantity::DistanceAcross, number(3.1, 1)),
        (Quantity::Ttc, number(2.4, 1)),
        (Quantity::TtcLong, number(2.4, 1)),
        (Quantity::TtcLat, number(2.4, 1)),
        (Quantity::Ttc, number(f64::INFINITY, 0)),
        (Quantity::Headway, number(1.8, 1)),
        (Quantity::VelocityLong, number(-4.2, 1)),
        (Quantity::VelocityLat, number(0.3, 1)),
        (Quantity::AccelerationLong, number(-1.5, 1)),
        (Quantity::AccelerationLat, number(0.2, 1)),
        (Quantity::ClosingSpeed, number(4.2, 1)),
        (Quantity::Speed, number(13.9, 1)),
        (Quantity::Acceleration, number(-2.1, 1)),
        (Quantity::Heading, number(35.0, 0)),
        (Quantity::Position, ClaimedValue::Place(12.3, -4.5, 1)),
    ];
    let bounds = |from, to| ClaimedValue::Bounds {
        from,
        to,
        decimals: 1,
    };
    let bounded = [
        (Quantity::Distance, bounds(None, Some(5.0))),
        (Quantity::Ttc, bounds(Some(2.0), None)),
        (Quantity::GapLong, bounds(Some(2.0), Some(3.0))),
        (
            Quantity::GapLong,
            ClaimedValue::Change {
                from: 9.0,
                to: 7.5,
                decimals: 1,
                rough: false,
            },
        ),
        (
            Quantity::Arithmetic,
            ClaimedValue::Quotient([(12.8, 1), (2.5, 1), (5.12, 2)]),
        ),
    ];
    let scores = [
        RiskAspect::Overall,
        RiskAspect::Distance(None),
        RiskAspect::Time(None),
        RiskAspect::Distance(Some(true)),
        RiskAspect::Time(Some(false)),
    ]
    .map(|of| (Quantity::Risk, ClaimedValue::Score { score: 3, of }));
    let sides = [
        (Some(true), None),
        (Some(false), None),
        (None, Some(true)),
        (None, Some(false)),
        (Some(true), Some(false)),
    ]
    .map(|(front, left)| (Quantity::Side, ClaimedValue::Side(Side { front, left })));
    let mut all: Vec<Claim> = { numbers.into_iter() }
        .chain(bounded)
        .chain(scores)
        .chain(sides)
        .map(|(quantity, stated)| claim(quantity, stated))
        .collect();
    all.push(claim(Quantity::Contact, ClaimedValue::Contact));
    for predicate in predicates(other) {
        let is_denied_too = !matches!(
            predicate,
            Predicate::OtherLane
                | Predicate::OtherLanelet
                | Predicate::CameFrom(_)
                | Predicate::Signed(..)
                | Predicate::CutsIn
                | Predicate::Moving
        );
        for is_denied in [false, true] {
            let is_contact = predicate == Predicate::Touches && !is_denied;
            if is_denied && !is_denied_too || is_contact {
                continue;
            }
            let stated = ClaimedValue::Word {
                predicate,
                is_denied,
            };
            all.push(claim(predicate.quantity(), stated));
        }
    }
    let ahead = Side {
        front: Some(true),
        left: None,
    };
    let truck = Some((ObstacleType::Truck, ObstacleType::Truck));
    for (number, of, types) in [
        (2, Counted::Word(Predicate::At(ahead)), None),
        (2, Counted::Word(Predicate::Braking), truck),
        (2, Counted::Within(10.0), None),
        (2, Counted::There, None),
        (
            2,
            Counted::Both(Predicate::At(ahead), Predicate::SameLane),
            None,
        ),
        (0, Counted::Near(true), None),
    ] {
        let stated = ClaimedValue::Count { number, of, types };
        all.push(Claim {
            obstacle: ego,
            is_of_ego: true,
            ..claim(Quantity::Count, stated)
        });
    }
    let own = [Predicate::Braking, Predicate::Turning(true)].map(|predicate| {
        let stated = ClaimedValue::Word {
            predicate,
            is_denied: false,
        };
        (predicate.quantity(), stated)
    });
    let own = { own.into_iter() }.chain([
        (Quantity::Speed, number(9.1, 1)),
        (Quantity::Position, ClaimedValue::Place(12.3, -4.5, 1)),
    ]);
    all.extend(own.map(|(quantity, stated)| Claim {
        obstacle: ego,
        is_of_ego: true,
        ..claim(quantity, stated)
    }));
    all
}

/// What the language has in words.
fn predicates(other: i64) -> Vec<Predicate> {
    let compared = |of, is_more, than| {
        Predicate::Compared(Compared {
            of,
            is_more,
            than,
            rank: 0,
        })
    };
    let mut all = vec![
        Predicate::Approaching(None),
        Predicate::Approaching(Some(true)),
        Predicate::Approaching(Some(false)),
        Predicate::Receding(None),
        Predicate::Receding(Some(true)),
        Predicate::Braking,
        Predicate::Accelerating,
        Predicate::Hard(true),
        Predicate::Gentle(false),
        Predicate::Steady,
        Predicate::KeepsDistance(None),
        Predicate::KeepsDistance(Some(false)),
        Predicate::Moving,
        Predicate::FasterThanEgo,
        Predicate::SlowerThanEgo,
        Predicate::SameWay,
        Predicate::Oncoming,
        Predicate::Parallel,
        Predicate::Signed(true, false),
        Predicate::Signed(false, true),
        Predicate::Turning(true),
        Predicate::Crossing,
        Predicate::ChangesLane,
        Predicate::CutsIn,
        Predicate::Beside,
        Predicate::NeighbourLane(true),
        Predicate::SameLane,
        Predicate::OtherLane,
        Predicate::SameLanelet,
        Predicate::OtherLanelet,
        Predicate::OnLanelet(42),
        Predicate::CameFrom(Side {
            front: None,
            left: Some(true),
        }),
        Predicate::Touches,
        Predicate::WillTouch,
    ];
    all.extend([
        compared(Dimension::Braking, true, Some(other)),
        compared(Dimension::Braking, true, None),
        Predicate::Compared(Compared {
            of: Dimension::Distance,
            is_more: false,
            than: None,
            rank: 1,
        }),
    ]);
    for of in [
        Dimension::Distance,
        Dimension::Speed,
        Dimension::Ttc,
        Dimension::Risk,
    ] {
        all.extend([
            compared(of, false, Some(other)),
            compared(of, true, Some(other)),
            compared(of, false, None),
            compared(of, true, None),
        ]);
    }
    all
}
