//! The words that sentences are read by: phrases and what each means.

use std::sync::LazyLock;

use super::words::{Token, stem};

/// What a phrase means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meaning {
    /// A term `key:value`; values of one key are joined.
    Term(&'static str, &'static str),
    /// Two terms at once: who stands where.
    Terms(&'static [(&'static str, &'static str)]),
    /// A whole term.
    Whole(&'static str),
    /// A name of a severity, which needs a word such as risk beside it: its score.
    Level(u8),
    /// Risk, severity: what levels and scores are of.
    Risk,
    /// A measure or another number, with the unit of its values.
    Measure(&'static str, Unit),
    /// How a number compares: sign, and the measure that is meant where none is named.
    Compare(&'static str, Option<&'static str>),
    /// Worse than a level.
    Worse,
    /// Behind a number or level: it is included, and so is what is beyond it in this direction.
    OrMore,
    /// The same for what is below it.
    OrLess,
    /// Behind a level: and what is worse.
    OrWorse,
    /// From a number to another.
    Between,
    /// A unit: how much of the base unit it is.
    Unit(Unit, f64),
    /// Not what follows.
    Not,
    /// Joins two things.
    And,
    /// A key whose value is the next word.
    Key(&'static str),
    /// Nothing that narrows down.
    Filler,
}

/// Base units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Seconds.
    Seconds,
    /// Metres.
    Metres,
    /// m/s².
    Acceleration,
    /// Without unit.
    None,
}

use Meaning::*;

/// Phrases, separated by `|`. A word with `=` before it is meant in this form alone, others in all their forms.
const PHRASES: &[(&str, Meaning)] = &[
    (
        "cut in|cut ins|cutin|cut off|pull in front of|chang into our lane|chang into the ego lane|chang into my lane|move into our lane",
        Term("manoeuvre", "cut_in"),
    ),
    (
        "lane change|change lane|changing lane|ego change lane|we change lane",
        Term("manoeuvre", "lane_change"),
    ),
    ("merge|merge in|zip together", Term("manoeuvre", "merging")),
    (
        "=following|car following|ego follow|we follow|vehicle ahead|lead vehicle|drive behind|behind",
        Term("manoeuvre", "following"),
    ),
    (
        "=followed|followed by|follow us|follow the ego|tailgate|tailgate us|from behind|approach from behind|rear approach",
        Term("manoeuvre", "followed"),
    ),
    (
        "parallel|parallel drive|side by side|alongside|next to|drive next to|drive alongside",
        Term("manoeuvre", "parallel"),
    ),
    (
        "oncoming|oncoming traffic|head on|opposite direction|contraflow",
        Term("manoeuvre", "oncoming"),
    ),
    (
        "cross|cross traffic|cross our path|cross the road|step onto the road|step into the road|step out|run into the road",
        Term("manoeuvre", "crossing"),
    ),
    (
        "turn across|turn across path|turn across our lane|turn across our path|turn across oncoming traffic|turn in front of us",
        Term("manoeuvre", "turning_across"),
    ),
    (
        "stationary|stationary obstacle|standing obstacle|=standing|=parked|=parked vehicle|=parked vehicles|static obstacle|static object",
        Term("manoeuvre", "standing"),
    ),
    (
        "=parked car|=parked cars",
        Terms(&[
            ("manoeuvre", "standing"),
            ("actor", "car"),
            ("actor", "parked_vehicle"),
        ]),
    ),
    (
        "pedestrian|people on foot|walker",
        Term("actor", "pedestrian"),
    ),
    (
        "cyclist|bicycle|bike|bicyclist|pedal cycle",
        Term("actor", "bicycle"),
    ),
    (
        "motorcycle|motorbike|motorcyclist|biker|powered two wheeler",
        Term("actor", "motorcycle"),
    ),
    (
        "truck|lorry|hgv|heavy goods vehicle",
        Term("actor", "truck"),
    ),
    ("bus|coach", Term("actor", "bus")),
    ("car|passenger car", Term("actor", "car")),
    ("taxi|cab", Term("actor", "taxi")),
    ("train|tram|streetcar", Term("actor", "train")),
    (
        "emergency vehicle|ambulance|fire engine|police car|priority vehicle",
        Term("actor", "priority_vehicle"),
    ),
    (
        "construction zone|roadworks|road works",
        Term("actor", "construction_zone"),
    ),
    (
        "vulnerable road user|vru|vrus",
        Terms(&[
            ("actor", "pedestrian"),
            ("actor", "bicycle"),
            ("actor", "motorcycle"),
        ]),
    ),
    (
        "two wheeler",
        Terms(&[("actor", "bicycle"), ("actor", "motorcycle")]),
    ),
    (
        "motorway|highway|freeway|autobahn|interstate|expressway",
        Term("road", "highway"),
    ),
    (
        "ramp|on ramp|off ramp|slip road|motorway entry|motorway exit",
        Term("road", "ramp"),
    ),
    (
        "urban|city|town|downtown|urban road|urban street|city street|inner city|built up area",
        Term("road", "urban"),
    ),
    (
        "country road|rural|rural road|countryside",
        Term("road", "country"),
    ),
    (
        "intersection|junction|crossroad|crossroads",
        Term("road", "intersection"),
    ),
    ("off road", Term("road", "off_road")),
    ("untyped road", Term("road", "untyped")),
    ("collision|crash|accident", Term("severity", "collision")),
    ("near miss|near collision", Term("severity", "extreme")),
    ("critical|safety critical", Term("severity", "critical")),
    ("extreme", Level(1)),
    ("high", Level(2)),
    ("medium|moderate", Level(3)),
    ("low", Level(4)),
    ("negligible", Level(5)),
    ("risk|risk score|severity|danger|risk level", Risk),
    (
        "ttc|time to collision|time to contact|to collision",
        Measure("ttc", Unit::Seconds),
    ),
    (
        "ttc along the lane|time to collision along the lane|lane ttc",
        Measure("ttc_lane", Unit::Seconds),
    ),
    (
        "worst case ttc|worst case time to collision|wttc",
        Measure("wttc", Unit::Seconds),
    ),
    ("pet|post encroachment time", Measure("pet", Unit::Seconds)),
    ("encroachment time", Measure("et", Unit::Seconds)),
    ("time gap", Measure("time_gap", Unit::Seconds)),
    ("time headway|headway|thw", Measure("thw", Unit::Seconds)),
    (
        "drac|required deceleration|deceleration to avoid a crash|need to brake|have to brake|had to brake|brake need|must brake|brake",
        Measure("drac", Unit::Acceleration),
    ),
    (
        "brake threat|brake threat number|btn",
        Measure("btn", Unit::None),
    ),
    (
        "steer threat|steer threat number|stn",
        Measure("stn", Unit::None),
    ),
    ("rss margin", Measure("rss_margin", Unit::Metres)),
    (
        "distance|gap|apart|clearance|room|between us|spacing",
        Measure("distance", Unit::Metres),
    ),
    (
        "closest encounter|distance of the closest encounter|dce",
        Measure("dce", Unit::Metres),
    ),
    (
        "rss violation|violate rss|rss is violated|rss breach",
        Whole("rss_margin<0"),
    ),
    (
        "obstacle|road user|other|vehicle",
        Measure("obstacles", Unit::None),
    ),
    ("duration|length", Measure("duration", Unit::Seconds)),
    ("answer", Measure("answers", Unit::None)),
    (
        "<|under|below|less than|lower than|smaller than|fewer than",
        Compare("<", None),
    ),
    ("closer than|nearer than", Compare("<", Some("distance"))),
    ("shorter than", Compare("<", Some("duration"))),
    (
        "<=|at most|no more than|not more than|up to|max|maximum|maximum of",
        Compare("<=", None),
    ),
    ("within|come within", Compare("<=", Some("distance"))),
    (
        ">|over|above|more than|greater than|higher than|exceed|harder than",
        Compare(">", None),
    ),
    ("longer than", Compare(">", Some("duration"))),
    ("farther than|further than", Compare(">", Some("distance"))),
    (
        ">=|at least|no less than|not less than|minimum|minimum of",
        Compare(">=", None),
    ),
    ("=|exactly|equal to|equal", Compare("=", None)),
    ("worse than", Worse),
    ("or more|or above|or longer|and above", OrMore),
    ("or less|or lower|or below|or shorter|or closer", OrLess),
    ("or worse|or higher", OrWorse),
    ("between", Between),
    ("s|sec|second", Unit(Unit::Seconds, 1.0)),
    ("ms|millisecond", Unit(Unit::Seconds, 0.001)),
    ("minute|min", Unit(Unit::Seconds, 60.0)),
    ("m|metre|meter", Unit(Unit::Metres, 1.0)),
    ("cm|centimetre|centimeter", Unit(Unit::Metres, 0.01)),
    ("km|kilometre|kilometer", Unit(Unit::Metres, 1000.0)),
    (
        "m/s2|metre per second squared|meter per second squared",
        Unit(Unit::Acceleration, 1.0),
    ),
    (
        "not|no|without|except|but not|not with|outside|exclude|other than|neither|nor",
        Not,
    ),
    ("and|or|plus|as well as", And),
    (
        "tagged|tag|tagged as|tagged with|with tag|with the tag",
        Key("tag"),
    ),
    (
        "folder|in folder|in the folder|from folder|from the folder",
        Key("folder"),
    ),
    ("my tagged|my tag|with my tag", Whole("has:tags")),
    (
        "disagree|disagree with the judge|model disagree|differ from the judge|judge disagree|wrong answer",
        Whole("verdict:differ"),
    ),
    (
        "agree with the judge|model agree|right answer",
        Whole("verdict:agree"),
    ),
    (
        "=not asked|not asked about|not asked about yet|never asked|never asked about|unasked|without answer|no answer",
        Whole("no:answers"),
    ),
    (
        "already asked|asked about|with answer",
        Whole("has:answers"),
    ),
    (
        "could not be read|cannot be read|can not be read|unreadable|broken",
        Whole("has:error"),
    ),
    ("no ego|without ego|without an ego", Whole("no:ego")),
    ("with an ego|with ego|has an ego", Whole("has:ego")),
    // Words around what is meant.
    (
        "a|an|the|all|any|anything|every|each|some|somebody|someone|something|it|they|them|there|this|these|those|that|which|who|what|where|when|while|with|in|on|at|of|to|by|for|from|is|are|was|were|be|been|being|has|have|had|do|does|did|us|we|our|my|i|me|you|ego|our path|of the ego|to the ego|the ego vehicle|ego vehicle",
        Filler,
    ),
    (
        "show|show me|find|give me|give|list|search|look for|get|please|time|every time|but|then|yet|only|just|during|come|came|driv|path|into|onto|the road|street|road|lane|model|judge",
        Filler,
    ),
    (
        "scenario|scene|recording|file|window|encounter|situation|manoeuvre|maneuver|conflict|event|interaction|case|traffic",
        Filler,
    ),
];

/// A phrase, ready to be compared.
struct Phrase {
    words: Vec<Word>,
    meaning: Meaning,
}

enum Word {
    Exact(String),
    Stem(String),
}

impl Word {
    fn is(&self, token: &Token) -> bool {
        match self {
            Self::Exact(word) => token.small == *word,
            Self::Stem(word) => token.stem == *word,
        }
    }
}

static LEXICON: LazyLock<Vec<Phrase>> = LazyLock::new(|| {
    let mut all = Vec::new();
    for (forms, meaning) in PHRASES {
        for form in forms.split('|') {
            let words = form.split(' ').map(|word| match word.strip_prefix('=') {
                Some(exact) if !exact.is_empty() => Word::Exact(exact.to_string()),
                _ => Word::Stem(stem(word)),
            });
            all.push(Phrase {
                words: words.collect(),
                meaning: *meaning,
            });
        }
    }
    all
});

/// The longest phrase at the beginning of these words, exact forms first: how many words it has and what it means.
#[must_use]
pub fn phrase(tokens: &[Token]) -> Option<(usize, Meaning)> {
    let fits = |phrase: &&Phrase| {
        phrase.words.len() <= tokens.len()
            && phrase
                .words
                .iter()
                .zip(tokens)
                .all(|(word, token)| word.is(token))
    };
    let exact = |phrase: &Phrase| phrase.words.iter().any(|w| matches!(w, Word::Exact(_)));
    let found = LEXICON.iter().filter(fits);
    // Of equal ones the first in the table.
    let best = found
        .rev()
        .max_by_key(|phrase| (phrase.words.len(), exact(phrase)))?;
    Some((best.words.len(), best.meaning))
}

/// The phrases for each meaning that narrows down, for documentation: words, and an example of what they give.
#[must_use]
pub fn documented() -> Vec<(String, String)> {
    let shown = PHRASES.iter().filter_map(|(forms, meaning)| {
        let gives = match meaning {
            Term(key, value) => format!("{key}:{value}"),
            Terms(terms) => {
                let all: Vec<String> = terms.iter().map(|(k, v)| format!("{k}:{v}")).collect();
                all.join(" ")
            }
            Whole(term) => (*term).to_string(),
            Measure(id, _) => (*id).to_string(),
            _ => return None,
        };
        Some((forms.replace('=', "").replace('|', ", "), gives))
    });
    shown.collect()
}
