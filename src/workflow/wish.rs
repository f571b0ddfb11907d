//! Words such as `a cyclist comes from behind the parked van` become a wish for an attack.
//!
//! Phrases of a fixed vocabulary are recognised in any order, the longest first. What is not understood is named, never
//! dropped.

use nearmiss_drive::generation::{AttackPlace, Wish};
use nearmiss_scene::scenario::ObstacleType;
use nearmiss_scene::verdict::ManoeuvreKind;

/// A wish that was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReadWish {
    /// What was understood.
    pub wish: Wish,
    /// Words that were not.
    pub not_understood: Vec<String>,
}

#[derive(Debug, Clone, Copy)]
enum Term {
    Actor(&'static [ObstacleType]),
    Manoeuvre(&'static [ManoeuvreKind]),
    Place(AttackPlace),
    /// Says nothing by itself.
    Filler,
}

use AttackPlace as P;
use ManoeuvreKind as K;
use ObstacleType as T;

/// Phrases, without endings that differ: a word of the sentence matches one that it begins with, where that ends in `*`.
const PHRASES: &[(&str, Term)] = &[
    (
        "from behind a|the|some parked|standing|stopped|waiting car|van|truck|lorry|bus|vehicle",
        Term::Place(P::Hidden),
    ),
    (
        "hidden|occluded by a|the parked|standing|stopped|waiting car|van|truck|lorry|bus|vehicle",
        Term::Place(P::Hidden),
    ),
    (
        "behind a|the parked|standing|stopped|waiting car|van|truck|lorry|bus|vehicle",
        Term::Place(P::Hidden),
    ),
    ("hidden|occluded", Term::Place(P::Hidden)),
    ("from the left lane", Term::Place(P::LeftLane)),
    ("from the right lane", Term::Place(P::RightLane)),
    ("on|in the left lane", Term::Place(P::LeftLane)),
    ("on|in the right lane", Term::Place(P::RightLane)),
    ("on the left", Term::Place(P::LeftLane)),
    ("on the right", Term::Place(P::RightLane)),
    ("from the left", Term::Place(P::FromLeft)),
    ("from the right", Term::Place(P::FromRight)),
    ("from left", Term::Place(P::FromLeft)),
    ("from right", Term::Place(P::FromRight)),
    ("from behind", Term::Place(P::Behind)),
    ("from the rear", Term::Place(P::Behind)),
    ("oncoming", Term::Place(P::Oncoming)),
    ("in|from the opposite direction", Term::Place(P::Oncoming)),
    ("from the front", Term::Place(P::Oncoming)),
    ("in front", Term::Place(P::Ahead)),
    ("ahead", Term::Place(P::Ahead)),
    ("leading", Term::Place(P::Ahead)),
    ("cut* in", Term::Manoeuvre(&[K::CutIn])),
    ("cut-in*|cutin*|merg*", Term::Manoeuvre(&[K::CutIn])),
    ("chang* lane|lanes", Term::Manoeuvre(&[K::CutIn])),
    (
        "brak* hard|suddenly|sharply",
        Term::Manoeuvre(&[K::HardBrake]),
    ),
    ("hard-brak*|brak*", Term::Manoeuvre(&[K::HardBrake])),
    ("hard brak*", Term::Manoeuvre(&[K::HardBrake])),
    ("stop* suddenly|hard", Term::Manoeuvre(&[K::HardBrake])),
    ("drift*|swerv*", Term::Manoeuvre(&[K::Drift])),
    ("leav* its|the|his|her lane", Term::Manoeuvre(&[K::Drift])),
    ("run* the|a red light", Term::Manoeuvre(&[K::RunTheLight])),
    ("run* the|a light", Term::Manoeuvre(&[K::RunTheLight])),
    ("run* red", Term::Manoeuvre(&[K::RunTheLight])),
    ("run-the-light", Term::Manoeuvre(&[K::RunTheLight])),
    (
        "cross* against|at the|a red light",
        Term::Manoeuvre(&[K::RunTheLight]),
    ),
    ("turn* late", Term::Manoeuvre(&[K::LateTurn])),
    ("late turn", Term::Manoeuvre(&[K::LateTurn])),
    ("turn* across", Term::Manoeuvre(&[K::LateTurn])),
    ("turn* left|right", Term::Manoeuvre(&[K::LateTurn])),
    ("late-turn*|turn*", Term::Manoeuvre(&[K::LateTurn])),
    ("cross*", Term::Manoeuvre(&[K::RunTheLight, K::LateTurn])),
    ("door to door", Term::Manoeuvre(&[K::DoorToDoor])),
    ("door-to-door|squeez*", Term::Manoeuvre(&[K::DoorToDoor])),
    ("driv* beside|alongside", Term::Manoeuvre(&[K::DoorToDoor])),
    ("pull* out", Term::Manoeuvre(&[K::PullOut])),
    ("pull-out*", Term::Manoeuvre(&[K::PullOut])),
    ("set* off", Term::Manoeuvre(&[K::PullOut])),
    ("mov* off", Term::Manoeuvre(&[K::PullOut])),
    (
        "cyclist*|bicycle*|bike*|bicyclist*",
        Term::Actor(&[T::Bicycle]),
    ),
    (
        "pedestrian*|person|child*|walker*",
        Term::Actor(&[T::Pedestrian]),
    ),
    (
        "motorcycle*|motorbike*|motorcyclist*|scooter*",
        Term::Actor(&[T::Motorcycle]),
    ),
    ("truck*|lorry|lorries", Term::Actor(&[T::Truck])),
    ("bus|buses", Term::Actor(&[T::Bus])),
    ("taxi*", Term::Actor(&[T::Taxi])),
    ("car|cars|van|vans", Term::Actor(&[T::Car])),
    (
        "vehicle*",
        Term::Actor(&[T::Car, T::Truck, T::Bus, T::Motorcycle, T::Taxi]),
    ),
    ("in front of the ego|me|us", Term::Filler),
    (
        "comes|come|coming|suddenly|a|an|the|and|with|of|to|into|ego|ego's|its|path|lane|way|another|one|that|who|which|is|at|junction|intersection|crossing|or|parked|standing|stopped|waiting",
        Term::Filler,
    ),
];

/// Reads words.
#[must_use]
pub fn read_wish(words: &str) -> ReadWish {
    let lowered = words.to_lowercase();
    let words: Vec<&str> = lowered
        .split(|c: char| c.is_whitespace() || matches!(c, ',' | ';' | '.' | '!'))
        .filter(|word| !word.is_empty())
        .collect();
    let mut read = ReadWish {
        wish: Wish::default(),
        not_understood: Vec::new(),
    };
    let mut at = 0;
    while at < words.len() {
        let longest = { PHRASES.iter() }
            .filter_map(|(phrase, term)| Some((matched(phrase, &words[at..])?, *term)))
            // Of equally long ones the first of the table.
            .rev()
            .max_by_key(|(length, _)| *length);
        let Some((length, term)) = longest else {
            read.not_understood.push(words[at].to_string());
            at += 1;
            continue;
        };
        let wish = &mut read.wish;
        match term {
            Term::Actor(kinds) => extend(&mut wish.actors, kinds),
            Term::Manoeuvre(kinds) => extend(&mut wish.manoeuvres, kinds),
            Term::Place(place) => extend(&mut wish.places, &[place]),
            Term::Filler => {}
        }
        at += length;
    }
    read
}

fn extend<T: Copy + PartialEq>(known: &mut Vec<T>, more: &[T]) {
    for one in more {
        if !known.contains(one) {
            known.push(*one);
        }
    }
}

/// How many of these words a phrase takes, from the first one on.
fn matched(phrase: &str, words: &[&str]) -> Option<usize> {
    let parts: Vec<&str> = phrase.split(' ').collect();
    let fits = |part: &&str, word: &&str| {
        part.split('|').any(|one| match one.strip_suffix('*') {
            Some(stem) => word.starts_with(stem),
            None => one == *word,
        })
    };
    let all = parts.len() <= words.len() && parts.iter().zip(words).all(|(p, w)| fits(p, w));
    all.then_some(parts.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(words: &str) -> String {
        let read = read_wish(words);
        assert!(
            read.not_understood.is_empty(),
            "{words}: {:?}",
            read.not_understood
        );
        read.wish.to_string()
    }

    #[test]
    fn sentences_become_wishes() {
        for (words, wanted) in [
            (
                "a cyclist comes from behind the parked van",
                "bicycle, any manoeuvre, from behind a standing vehicle",
            ),
            (
                "A car cuts in from the left lane.",
                "car, cut-in, on the left",
            ),
            ("the truck ahead brakes hard", "truck, hard-brake, ahead"),
            ("oncoming car turns left", "car, late-turn, oncoming"),
            (
                "a pedestrian crosses from the right",
                "pedestrian, run-the-light or late-turn, from the right",
            ),
            (
                "a vehicle runs the red light from the left",
                "car or truck or bus or motorcycle or taxi, run-the-light, from the left",
            ),
            ("a parked car pulls out", "car, pull-out"),
            (
                "a motorcycle from behind drifts",
                "motorcycle, drift, from behind",
            ),
            ("a bus or a truck merges", "bus or truck, cut-in"),
        ] {
            assert_eq!(said(words), wanted, "{words}");
        }
    }

    #[test]
    fn what_is_not_understood_is_named() {
        assert_eq!(
            read_wish("a car does not cut in").not_understood,
            ["does", "not"]
        );
        let read = read_wish("a giraffe cuts in quietly");
        assert_eq!(read.wish.manoeuvres, [K::CutIn]);
        assert_eq!(read.not_understood, ["giraffe", "quietly"]);
        assert!(read_wish("hello world").wish.is_empty());
        assert!(read_wish("").wish.is_empty());
    }
}
