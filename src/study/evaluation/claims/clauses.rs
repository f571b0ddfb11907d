//! The clauses of a sentence: whom each is about, and whether it states, supposes, plans or remembers.

use std::ops::Range;

use super::references::{Named, Reference};
use super::tokens::Token;
use super::verbs::{VERBS, is_property};

/// Whom a clause is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Who {
    /// These obstacles, each.
    Obstacles(Vec<i64>),
    /// The ego.
    Ego,
    /// Someone who is not known, or several.
    Unknown,
}

/// Of whom a sentence speaks where it does not say.
pub struct Spoken {
    /// Whom it is about.
    pub current: Who,
    /// Whom "the obstacle" means.
    pub noun: Option<i64>,
    /// Whom "both obstacles" means.
    pub both: Option<[i64; 2]>,
}

impl Spoken {
    /// Of one obstacle.
    pub fn of(id: i64) -> Self {
        Self {
            current: Who::Obstacles(vec![id]),
            noun: Some(id),
            both: None,
        }
    }
}

/// How a clause says what it says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mood {
    /// As it is.
    Said,
    /// As it was at some time before.
    Past,
    /// As it will be.
    Future,
    /// As it may be, should be, or is asked to be.
    Supposed,
}

/// A clause.
#[derive(Debug, Clone, PartialEq)]
pub struct Clause {
    /// Its tokens.
    pub at: Range<usize>,
    /// The tokens of the label that it is the value of; empty where there is none.
    pub label: Range<usize>,
    /// Whom it is about.
    pub who: Who,
    /// Another obstacle that it names, not to compare with: of the ego, the one that it meets.
    pub object: Option<i64>,
    /// Whether it names the ego other than as its subject.
    pub names_ego: bool,
    /// Whether it is a label: what stands before a colon.
    pub is_label: bool,
    /// Whom the sentence was about before it, where that is one.
    pub topic: Option<i64>,
    /// How it is said.
    pub mood: Mood,
}

/// Words that begin a clause.
const OPENERS: [&str; 33] = [
    "but",
    "while",
    "whereas",
    "although",
    "though",
    "because",
    "since",
    "so",
    "thus",
    "therefore",
    "hence",
    "which",
    "who",
    "yet",
    "however",
    "when",
    "if",
    "unless",
    "indicating",
    "suggesting",
    "meaning",
    "making",
    "posing",
    "resulting",
    "until",
    "once",
    "where",
    "with",
    "given",
    "implying",
    "despite",
    "leaving",
    "whose",
];

/// Words with which a clause supposes, guesses, plans or asks.
const SUPPOSING: &str = "ready prepare prepared preparing if unless would could might may can should must potential potentially \
        possible possibly likely unlikely probably suppose imagine whether assuming assume assumed hypothetically \
        needs need let plan intend want please avoid avoids avoiding prevent until once when typically usually \
        threshold limit example either or";

const PAST: &str =
    "was were had initially previously earlier originally ago formerly came did began";

/// The clauses of a sentence in order.
pub fn clauses(tokens: &[Token], references: &[Reference], spoken: &Spoken) -> Vec<Clause> {
    let is_of_ego = spoken.current == Who::Ego;
    let current = match &spoken.current {
        Who::Obstacles(ids) => ids.first().copied(),
        Who::Ego | Who::Unknown => None,
    };
    let mut found: Vec<Clause> = Vec::new();
    let mut is_conditional = false;
    let mut label = 0..0;
    // Whom the last clause was about, and who "it" is: before anyone is spoken of, the only one that is named further on.
    let mut last: Option<Who> = is_of_ego.then_some(Who::Ego);
    let mut named: Vec<i64> = { references.iter() }
        .filter_map(|r| match r.who {
            Named::Obstacle(id) if !r.is_compared => Some(id),
            _ => None,
        })
        .collect();
    named.sort_unstable();
    named.dedup();
    let only = <[i64; 1]>::try_from(named).ok().map(|[id]| id);
    let mut it = current.or(only);
    let mut noun = it.or(spoken.noun);
    let mut met: Option<i64> = None;
    for (at, end_mark) in pieces(tokens, references) {
        // "Laterally, it recedes".
        let is_axis = at.len() == 1 && tokens[at.start].is("laterally longitudinally");
        if end_mark == Some(":") || is_axis && end_mark == Some(",") {
            label = at.clone();
        }
        let words = &tokens[at.clone()];
        if tokens[..at.start].last().is_some_and(|t| t.is(";")) {
            is_conditional = false;
        }
        is_conditional |= words.iter().any(|t| t.is("if unless suppose imagine"));
        let own: Vec<&Reference> = { references.iter() }
            .filter(|r| at.contains(&r.at.start) && !r.is_compared)
            .collect();
        let before = Before {
            last: last.as_ref(),
            it,
            noun,
            both: spoken.both,
        };
        let (mut who, object) = subject(tokens, &at, &own, &before);
        // "Faster (28 m/s) than the ego (24 m/s)".
        let is_bracket = at.start > 0 && tokens[at.start - 1].is("(");
        let compared = references
            .iter()
            .find(|r| r.is_compared && r.at.end + 1 == at.start && is_bracket);
        match compared.map(|r| r.who) {
            Some(Named::Ego) => who = Who::Ego,
            Some(Named::Obstacle(id)) => who = Who::Obstacles(vec![id]),
            _ => {}
        }
        // "The ego hits 7, with 36 km/h".
        let object = if own.is_empty() && who == Who::Ego {
            met
        } else {
            object
        };
        met = object;
        let topic = it;
        let names_ego = own.iter().any(|r| r.who == Named::Ego) && who != Who::Ego;
        let mood = if is_conditional {
            Mood::Supposed
        } else {
            mood(words, &who)
        };
        // What is only compared with does not go on.
        let is_aside = compared.is_some();
        match &who {
            _ if is_aside => {}
            Who::Obstacles(ids) => noun = <[i64; 1]>::try_from(ids.as_slice()).ok().map(|[id]| id),
            Who::Ego => noun = object.or(noun),
            Who::Unknown => {}
        }
        match &who {
            _ if is_aside => {}
            Who::Obstacles(ids) if ids.len() == 1 => it = ids.first().copied(),
            Who::Obstacles(_) => it = None,
            Who::Ego => it = object.or(it).filter(|_| object.is_some() || own.is_empty()),
            Who::Unknown => {}
        }
        if !words.is_empty() && !is_aside {
            last = Some(who.clone());
        }
        let (labelled, clause_end) = (label.clone(), at.end);
        let is_label =
            end_mark == Some(":") && !words.iter().any(|t| t.is("is are am has have was were"));
        // "Lateral TTC: 3 m/s with a gap of 2 m".
        let goes_on = end_mark.is_none() && tokens.get(clause_end).is_some_and(|t| t.is("with"));
        if end_mark != Some(":") && end_mark != Some(",") && end_mark != Some("(") && !goes_on {
            label = 0..0;
        }
        found.push(Clause {
            label: if labelled == at { 0..0 } else { labelled },
            at,
            who,
            object,
            names_ego,
            is_label,
            topic,
            mood,
        });
    }
    found
}

/// The parts between marks and words that begin clauses, with the mark behind each.
fn pieces<'t>(
    tokens: &'t [Token],
    references: &[Reference],
) -> Vec<(Range<usize>, Option<&'t str>)> {
    let mut found = Vec::new();
    let mut from = 0;
    let mut depth_between = 0;
    for at in 0..tokens.len() {
        let token = &tokens[at];
        let (before, after) = (at.checked_sub(1).map(|i| &tokens[i]), tokens.get(at + 1));
        let is_mark = token.is(", ; ( ) : — – | [ ] { }")
            || token.is("-") && before.is_none_or(|b| b.span.end < token.span.start);
        if token.is("between") {
            depth_between = at + 8;
        }
        let both_numbers =
            before.is_some_and(|b| b.number.is_some()) && after.is_some_and(|a| a.number.is_some());
        // "(1.2, 3.4)", "3–5 m".
        let has_unit = before.is_some_and(|b| b.word.contains(char::is_alphabetic));
        // "7, 8, and 9".
        let is_list = token.is(",")
            && after.is_some_and(|a| a.is("and"))
            && before.is_some_and(|b| b.number.is_some())
            && tokens.get(at + 2).is_some_and(|t| t.number.is_some());
        if is_mark && !is_list && !(both_numbers && !has_unit && token.is(", - – —")) {
            if at > from {
                found.push((from..at, Some(token.word.as_str())));
            }
            from = at + 1;
            continue;
        }
        let axis = |t: Option<&Token>| {
            t.is_some_and(|t| t.stem.starts_with("later") || t.stem.starts_with("longitudinal"))
        };
        let place = |t: Option<&Token>| {
            t.is_some_and(|t| t.is("ahead front behind left right rear closer nearer"))
        };
        let opens = match token.word.as_str() {
            "and" => {
                let side = (at + 1..at + 5).any(|i| place(tokens.get(i)));
                let is_last = before.is_some_and(|b| b.is(","))
                    && after.is_some_and(|a| a.number.is_some())
                    && at > 1
                    && tokens[at - 2].number.is_some();
                // "Obstacle 7 and obstacle 8 are", "both the ego and the obstacle are".
                let first = references.iter().find(|r| r.at.end == at);
                let second = references.iter().find(|r| r.at.start == at + 1);
                let is_one =
                    |who: Named| matches!(who, Named::Obstacle(_) | Named::It | Named::Ego);
                let is_listed = first.zip(second).is_some_and(|(first, second)| {
                    let is_ego = first.who == Named::Ego || second.who == Named::Ego;
                    let is_id = matches!(second.who, Named::Obstacle(_));
                    let begins = first.at.start <= from + 1
                        || first.who == Named::Ego
                            && is_id
                            && before.is_some_and(|b| b.is("ego vehicle"));
                    // "The ego brakes, and 7 and the ego are close".
                    let ends = second.who != Named::Ego
                        || tokens
                            .get(second.at.end)
                            .is_some_and(|t| t.is("are is share both remain"));
                    begins
                        && ends
                        && is_one(first.who)
                        && is_one(second.who)
                        && (!is_ego || first.who != second.who)
                });
                let is_pair = both_numbers
                    || is_listed
                    || is_last
                    || axis(after)
                    || axis(before) && before.is_some_and(|b| b.is("longitudinal lateral"))
                    || place(before) && side && !after.is_some_and(|a| a.is("a an"))
                    || at < depth_between;
                !is_pair
            }
            // "A collision with 7" is one.
            "with" => {
                const JOINED: [&str; 16] = [
                    "intersect",
                    "align",
                    "collision",
                    "contact",
                    "crash",
                    "collid",
                    "overlap",
                    "impact",
                    "respect",
                    "compar",
                    "level",
                    "parallel",
                    "imminent",
                    "shar",
                    "together",
                    "even",
                ];
                !(at.saturating_sub(2)..at).any(|i| JOINED.contains(&tokens[i].stem.as_str()))
            }
            "that" => after.is_some_and(|a| a.is("is was has will does came cut just had")),
            "as" => {
                after.is_some_and(|a| a.is("it the he she they we i"))
                    && !before.is_some_and(|b| b.is("as same well such near close"))
            }
            "since" | "before" | "after" => {
                after.is_some_and(|a| a.number.is_none())
                    || references.iter().any(|r| r.at.start == at + 1)
            }
            "yet" => !before.is_some_and(|b| b.is("not")),
            "so" => !before.is_some_and(|b| b.is("or not")),
            // "Not indicating a collision".
            word => {
                OPENERS.contains(&word) && !before.is_some_and(|b| b.is("not"))
                    || is_thought(tokens, references, (from, at))
            }
        };
        if opens && at > from {
            found.push((from..at, None));
            from = at;
        }
    }
    if from < tokens.len() {
        found.push((from..tokens.len(), None));
    }
    found
}

/// Whether a participant is what someone thinks or sees something of: "I know 7 is braking".
fn is_thought(tokens: &[Token], references: &[Reference], (from, at): (usize, usize)) -> bool {
    const THINKS: &str = "know think believe guess infer conclude assume observe notice expect sure certain aware \
        says show shows showing means confirm confirms indicates indicate suggests suggest implies";
    // "This indicates the ego brakes".
    let is_seen = tokens[from].is("this that which it");
    let other = |r: &Reference| r.at.start == at && (r.who != Named::Ego || is_seen);
    let before = (from..at)
        .rev()
        .find(|i| !tokens[*i].is("that the a an of"));
    references.iter().any(other) && before.is_some_and(|i| tokens[i].is(THINKS))
}

/// Of whom the clauses before one speak.
struct Before<'a> {
    /// Whom the last one was about.
    last: Option<&'a Who>,
    /// Who "it" is.
    it: Option<i64>,
    /// Who "the obstacle" is, also behind a clause about the ego.
    noun: Option<i64>,
    /// Who "both obstacles" are.
    both: Option<[i64; 2]>,
}

/// Whom a clause is about, and which other obstacle it names.
fn subject(
    tokens: &[Token],
    at: &Range<usize>,
    own: &[&Reference],
    before: &Before<'_>,
) -> (Who, Option<i64>) {
    let &Before {
        last,
        it,
        noun,
        both,
    } = before;
    let one = |id: i64| Who::Obstacles(vec![id]);
    let id_of = |r: &Reference| match r.who {
        Named::Obstacle(id) => Some(id),
        Named::It if is_noun(&tokens[r.at.clone()]) => it.or(noun),
        Named::It => it,
        _ => None,
    };
    let inherited = || match last {
        // The distance is one to whom all of it is about.
        Some(Who::Ego) | None if is_relational(&tokens[at.clone()]) => {
            it.or(noun).map_or(Who::Unknown, one)
        }
        Some(who) => who.clone(),
        None => it.map_or(Who::Unknown, one),
    };
    if tokens[at.start].is("whose") {
        return (Who::Unknown, None);
    }
    if own.is_empty() {
        return (
            if has_own_noun(tokens, at) {
                Who::Unknown
            } else {
                inherited()
            },
            None,
        );
    }
    let mut ids: Vec<i64> = own.iter().filter_map(|r| id_of(r)).collect();
    ids.dedup();
    // "The nearest car is 7": it is about 7.
    if let [first, second, ..] = own
        && first.is_nearest
        && let Named::Obstacle(id) = second.who
        && tokens[first.at.end..second.at.start]
            .iter()
            .any(|t| t.is("is"))
    {
        return (one(id), None);
    }
    let verb = at
        .clone()
        .find(|i| VERBS.at(tokens, *i).is_some() || tokens[*i].is("is are has am"));
    // "Closest obstacle, 3 m" in a field.
    if let [first] = own
        && first.is_nearest
        && verb.is_none()
        && let Some(id) = it
        && first.at.start <= at.start + 1
    {
        return (one(id), None);
    }
    let there = tokens[at.clone()]
        .iter()
        .take(2)
        .any(|t| t.is("there here see have got"));
    // "With 306, the truck, ahead".
    if let ([first], Some(who)) = (own, last)
        && first.at == *at
        && !tokens[at.clone()].iter().any(|t| t.number.is_some())
        && matches!(who, Who::Obstacles(_))
        && tokens.get(at.end).is_some_and(|t| t.is(", )"))
    {
        return (who.clone(), None);
    }
    let is_before_verb = |r: &&&Reference| verb.is_none_or(|verb| r.at.start < verb) || there;
    let is_first = |r: &&&Reference| {
        let next = at.start + 1;
        tokens[at.start].is("with")
            && !tokens.get(r.at.end).is_some_and(|t| t.is("'s"))
            && (r.at.start == next || r.at.start == next + 1 && tokens[next].is("the"))
    };
    // "The ego and 7 are in one lane".
    if let [first, second, ..] = own
        && first.who == Named::Ego
        && !first.is_governed
        && let Some(id) = id_of(second)
        && tokens[first.at.end..second.at.start]
            .iter()
            .all(|t| t.is("and"))
    {
        return (one(id), None);
    }
    // "We have a car on the left".
    let has = tokens[at.clone()]
        .iter()
        .take(4)
        .any(|t| t.is("have got see notice spot"));
    if let [first, second, ..] = own
        && has
        && first.who == Named::Ego
        && let Named::Obstacle(id) = second.who
    {
        return (one(id), None);
    }
    let nominal = own
        .iter()
        .find(|r| (!r.is_governed || is_first(r)) && is_before_verb(r));
    let others = |but: Option<i64>| {
        let mut rest = own
            .iter()
            .filter_map(|r| id_of(r))
            .filter(|id| Some(*id) != but);
        let first = rest.next();
        first.filter(|first| rest.all(|id| id == *first))
    };
    match nominal.map(|r| r.who) {
        Some(Named::Both) => (
            both.map_or(Who::Unknown, |both| Who::Obstacles(both.into())),
            None,
        ),
        Some(Named::Obstacle(_) | Named::It) => {
            let Some(id) = nominal.and_then(|r| id_of(r)) else {
                let is_ego = last == Some(&Who::Ego)
                    && nominal.is_some_and(|r| tokens[r.at.start].is("it its itself"));
                return (if is_ego { Who::Ego } else { Who::Unknown }, None);
            };
            // "7, 8 and 9 are behind": of each.
            let listed: Vec<i64> = own
                .iter()
                .filter(|r| !r.is_governed && verb.is_none_or(|verb| r.at.start < verb))
                .filter_map(|r| id_of(r))
                .collect();
            if listed.len() > 1 {
                return (Who::Obstacles(listed), None);
            }
            (one(id), others(Some(id)))
        }
        Some(Named::Ego) => (Who::Ego, others(None)),
        Some(Named::Nobody | Named::Other) => (Who::Unknown, None),
        None => {
            let is_subject = |r: &&&Reference| verb.is_none_or(|verb| r.at.start < verb);
            let has_others = own
                .iter()
                .filter(is_subject)
                .any(|r| matches!(r.who, Named::Nobody | Named::Other | Named::Both));
            let before = verb.unwrap_or(at.end);
            let has_property = tokens[at.start..before].iter().any(is_property);
            // "My speed", "the ego's braking".
            let is_of_ego = own[0].who == Named::Ego
                && own[0].at.end <= before.max(at.start + 2)
                && (tokens[own[0].at.start].is("my our your")
                    || tokens.get(own[0].at.end).is_some_and(|t| t.is("'s")))
                && tokens[own[0].at.end..at.end]
                    .iter()
                    .take(4)
                    .any(|t| t.is("speed velocity acceleration deceleration heading braking pace"))
                && tokens[at.start..own[0].at.start].iter().all(|t| {
                    !t.is_word() || t.is("the and but while with at so reflects simply only of")
                });
            // "The velocity of the ego".
            let of = (at.start..own[0].at.start).rfind(|i| tokens[*i].is("of"));
            let is_of_ego = is_of_ego
                || own[0].who == Named::Ego
                    && own[0].at.end <= before
                    && ids.is_empty()
                    && of.is_some_and(|of| {
                        of > at.start
                            && of + 2 >= own[0].at.start
                            && tokens[of - 1]
                                .is("speed velocity acceleration deceleration heading orientation position")
                    });
            match ids.as_slice() {
                _ if is_of_ego => (Who::Ego, others(None)),
                [] if has_others => (Who::Unknown, None),
                // "In front of the ego": whoever was spoken of.
                [] => (
                    if has_own_noun(tokens, at) {
                        Who::Unknown
                    } else {
                        inherited()
                    },
                    None,
                ),
                // "Following 7 at 20 m/s".
                [id] if last.is_none()
                    && verb == Some(at.start)
                    && tokens[at.start].word.ends_with("ing") =>
                {
                    (Who::Ego, Some(*id))
                }
                // "I brake and drop back behind 7".
                [id] if !has_property && verb.is_some_and(|verb| verb <= at.start + 1) => {
                    match last {
                        Some(Who::Ego) => (Who::Ego, Some(*id)),
                        Some(Who::Obstacles(all)) if all.as_slice() != [*id] => {
                            (Who::Obstacles(all.clone()), Some(*id))
                        }
                        _ => (one(*id), None),
                    }
                }
                [id] => (one(*id), None),
                _ => (Who::Unknown, None),
            }
        }
    }
}

/// Whether words name an obstacle by a noun, not by a pronoun.
fn is_noun(words: &[Token]) -> bool {
    words
        .iter()
        .any(|t| t.is("obstacle object participant actor them"))
}

/// Whether a clause begins with what is between two: "the distance is".
fn is_relational(words: &[Token]) -> bool {
    const BETWEEN: &str =
        "distance distances gap ttc separation clearance relative closing lateral longitudinal";
    let mut head = words.iter().skip_while(|t| {
        t.is("and but while so thus hence as because since with the a an this its current overall now")
            || t.word.ends_with("ly")
    });
    head.next().is_some_and(|t| t.is(BETWEEN))
}

/// Whether a clause begins with a noun of its own that is no property of a participant: "the road is wet".
fn has_own_noun(tokens: &[Token], at: &Range<usize>) -> bool {
    let words = &tokens[at.clone()];
    let start = words
        .iter()
        .position(|t| t.is("the a an this that these all any every each"));
    let Some(start) = start else { return false };
    let verb = at
        .clone()
        .find(|i| VERBS.at(tokens, *i).is_some() || tokens[*i].is("is are has"));
    let stop = verb.map_or(words.len(), |verb| verb - at.start);
    if stop <= start
        || words[..start]
            .iter()
            .any(|t| t.is_word() && !t.is("and but while so thus hence as because since at"))
    {
        return false;
    }
    let head = &words[start + 1..stop.max(start + 1)];
    let is_known = head.is_empty() || head.iter().any(is_property);
    !is_known && verb.is_some()
}

/// How words say what they say.
fn mood(words: &[Token], who: &Who) -> Mood {
    let says = |all: &str| words.iter().any(|t| t.is(all));
    let pair = |a: &str, b: &str| words.windows(2).any(|two| two[0].is(a) && two[1].is(b));
    let is_bound = pair("or", "less more so fewer");
    let supposes = words.iter().enumerate().any(|(i, t)| {
        t.is(SUPPOSING)
            && !(t.is("or") && is_bound)
            && !(t.is("may") && i == 0)
            // "TTC is below the 1 s threshold" is said.
            && !(t.is("threshold limit") && words[..i].iter().any(|t| t.is("below above under over within than exceeds")))
    });
    let advises = words
        .first()
        .is_some_and(|t| t.is("should had assume consider is are does do"))
        && words.len() > 3
        && !matches!(who, Who::Obstacles(_));
    if supposes
        || advises
        || pair("used", "to")
        || pair("in", "case")
        || words
            .windows(3)
            .any(|t| t[0].is("far") && t[1].is("from") && t[2].word.ends_with("ing"))
    {
        return Mood::Supposed;
    }
    if says("will shall") || pair("going about gonna", "to") || says("gonna soon eventually") {
        return Mood::Future;
    }
    if says(PAST) || pair("at", "first") {
        return Mood::Past;
    }
    Mood::Said
}
