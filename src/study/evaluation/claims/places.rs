//! Words for places around the ego.

use std::sync::LazyLock;

use super::Side;
use super::tokens::Lexicon;

/// What words say of a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Placed {
    /// Seen from the ego.
    At(Side),
    /// Next to it.
    Beside,
    /// A word that is a place where a field asks for one, and nothing elsewhere.
    Field(Side),
}

/// Words along the ego's heading, and whether they stand only in fields.
const ALONG: [(&str, bool, bool); 12] = [
    ("in front", true, false),
    ("=ahead", true, false),
    ("up front", true, false),
    ("far back", false, false),
    ("further up ?down road", true, false),
    ("at|to|towards front", true, false),
    ("=behind", false, false),
    ("to|at|in rear|back", false, false),
    ("front", true, true),
    ("forward", true, true),
    ("rear", false, true),
    ("back", false, true),
];

/// Words across it.
const ACROSS: [(&str, bool, bool); 6] = [
    (
        "to|on|at ?our|my|your|ego|ego's ?vehicle ?'s left ?hand ?side|flank",
        true,
        false,
    ),
    (
        "to|on|at ?our|my|your|ego|ego's ?vehicle ?'s =right ?hand ?side|flank",
        false,
        false,
    ),
    ("left of ego|us|me|you ?vehicle|car", true, false),
    ("=right of ego|us|me|you ?vehicle|car", false, false),
    ("left ?hand ?side", true, true),
    ("=right ?hand ?side", false, true),
];

/// Places, the longest match first.
pub static PLACES: LazyLock<Lexicon<Placed>> = LazyLock::new(|| {
    let mut all: Vec<(String, Placed)> = Vec::new();
    let of_ego = " ?of ?ego|us|me|you|our|my ?vehicle|car";
    for (along, front, in_field) in ALONG {
        let front = Side {
            front: Some(front),
            left: None,
        };
        let place = if in_field {
            Placed::Field(front)
        } else {
            Placed::At(front)
        };
        all.push((along.into(), place));
        if !in_field {
            all.push((
                format!("{along} of ego|us|me|you|our|my ?vehicle|car"),
                place,
            ));
        }
        for (across, left, _) in ACROSS {
            let both = Placed::At(Side {
                left: Some(left),
                ..front
            });
            all.push((format!("{along} ?and|but {across}{of_ego}"), both));
            all.push((format!("{across} ?and|but {along}{of_ego}"), both));
        }
    }
    all.push((
        "=behind ego|us|me|you ?vehicle|car".into(),
        Placed::At(Side {
            front: Some(false),
            left: None,
        }),
    ));
    for (across, left, in_field) in ACROSS {
        let side = Side {
            front: None,
            left: Some(left),
        };
        let place = if in_field {
            Placed::Field(side)
        } else {
            Placed::At(side)
        };
        all.push((across.into(), place));
        if !in_field && !across.contains(" of ego") {
            all.push((format!("{across} of ego|us|me|you ?vehicle|car"), place));
        }
    }
    for beside in [
        "beside|alongside ?ego|us|me|you ?vehicle|car",
        "level with",
        "level with ego|us|me|you ?vehicle|car",
        "next to ego|us|me|you ?vehicle|car",
        "side by side",
        "abreast",
    ] {
        all.push((beside.into(), Placed::Beside));
    }
    let all: Vec<(&str, Placed)> = all
        .iter()
        .map(|(text, place)| (text.as_str(), *place))
        .collect();
    Lexicon::new(&all)
});
