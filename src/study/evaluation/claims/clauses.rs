//! The clauses of a sentence: whom each is about, and whether it states, supposes, plans or remembers.

use std::ops::Range;

use super::pieces::{is_participle, pieces};
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
    /// Whether it says something more of someone: "301, which is braking".
    pub is_aside: bool,
    /// Whether it is a label: what stands before a colon.
    pub is_label: bool,
    /// Whom the sentence was about before it, where that is one.
    pub topic: Option<i64>,
    /// How it is said.
    pub mood: Mood,
}

/// What something is done for, behind "to".
pub(super) const PURPOSES: &str =
    "avoid prevent let overtake pass match keep make give allow get see wait";

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
    // Whom the sentence was about before a clause that says something more of someone: "305, which brakes, …".
    let mut main: Option<Who> = None;
    // The last obstacle that a clause was about.
    let mut told: Option<i64> = None;
    let all = pieces(tokens, references);
    last = dangling(tokens, references, &all).or(last);
    for (at, end_mark) in all {
        // "Laterally, it recedes".
        let is_axis = at.len() == 1 && tokens[at.start].is("laterally longitudinally");
        if end_mark == Some(":") || is_axis && end_mark == Some(",") {
            label = at.clone();
        }
        let words = &tokens[at.clone()];
        if tokens[..at.start].last().is_some_and(|t| t.is(";")) {
            is_conditional = false;
        }
        // "It hits us if we go on, whereas 8 is behind" has two halves.
        if words.first().is_some_and(|t| t.is("whereas while but")) {
            is_conditional = false;
        }
        is_conditional |= words.iter().any(|t| t.is("if unless suppose imagine"));
        let own: Vec<&Reference> = { references.iter() }
            .filter(|r| at.contains(&r.at.start) && !r.is_compared)
            .collect();
        let begins_anew = at.start > 0
            && (tokens[at.start - 1].is(", )") || tokens[at.start].is("is are was will has"));
        let has_subject = own.iter().any(|r| r.who != Named::Ego || !r.is_governed);
        if !has_subject && begins_anew && !is_relative(tokens, at.start + 1) {
            last = main.take().or(last);
        }
        let owner = owner(tokens, references, at.start).and_then(|who| match who {
            Named::Obstacle(id) => Some(Who::Obstacles(vec![id])),
            Named::It => Some(it.map_or(Who::Unknown, |id| Who::Obstacles(vec![id]))),
            Named::Ego => Some(Who::Ego),
            Named::Both => spoken.both.map(|both| Who::Obstacles(both.into())),
            Named::Nobody | Named::Other => Some(Who::Unknown),
        });
        let (mut who, object) = match owner {
            Some(who) => {
                main = main.or(last.clone());
                let other = own.iter().find_map(|r| match r.who {
                    Named::Obstacle(id) if who != Who::Obstacles(vec![id]) => Some(id),
                    _ => None,
                });
                (who, other)
            }
            None => {
                if !own.is_empty() {
                    main = None;
                }
                {
                    let before = Before {
                        last: last.as_ref(),
                        it,
                        noun,
                        both: spoken.both,
                    };
                    subject(tokens, &at, &own, &before)
                }
            }
        };
        // "I have not reacted yet, so the gap shrinks": that to whom it was about before.
        let is_paired = own.is_empty() && who == Who::Ego && is_gap(words);
        if is_paired && let Some(id) = it.or(told) {
            who = Who::Obstacles(vec![id]);
        }
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
        // "The truck, which I have passed": that is whom I passed.
        let object = match object {
            None if who == Who::Ego && is_relative(tokens, at.start) => it,
            object => object,
        };
        // "7 and 8 …, both behind".
        if own.is_empty() && words.iter().take(2).any(|t| t.is("both neither")) {
            who = two_before(references, at.start).unwrap_or(who);
        }
        let is_aside = is_relative(tokens, at.start);
        let names_ego = own.iter().any(|r| r.who == Named::Ego) && who != Who::Ego;
        // "If I had gone on I would have hit 301, which is 2 m ahead".
        let is_said_of =
            is_aside && begins_anew && !tokens[at.clone()].iter().any(|t| t.is("if unless"));
        let mood = if is_conditional && !is_said_of {
            Mood::Supposed
        } else {
            mood(words, &who)
        };
        // What is only compared with does not go on.
        let is_likened = compared.is_some();
        if let Who::Obstacles(ids) = &who {
            told = <[i64; 1]>::try_from(ids.as_slice()).ok().map(|[id]| id);
        }
        match &who {
            _ if is_likened => {}
            Who::Obstacles(ids) => noun = <[i64; 1]>::try_from(ids.as_slice()).ok().map(|[id]| id),
            Who::Ego => noun = object.or(noun),
            Who::Unknown => {}
        }
        match &who {
            _ if is_likened => {}
            Who::Obstacles(ids) if ids.len() == 1 => it = ids.first().copied(),
            Who::Obstacles(_) => it = None,
            Who::Ego => it = object.or(it).filter(|_| object.is_some() || own.is_empty()),
            Who::Unknown => {}
        }
        if !words.is_empty() && !is_likened {
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
            is_aside,
            is_label,
            topic,
            mood,
        });
    }
    found
}

/// Of whom the next clause is about where a sentence begins with a participle: "braking at 3 m/s², the ego stops".
fn dangling(
    tokens: &[Token],
    references: &[Reference],
    all: &[(Range<usize>, Option<&str>)],
) -> Option<Who> {
    let [(first, Some(",")), (next, _), ..] = all else {
        return None;
    };
    let is_verb = tokens[first.start].word.ends_with("ing")
        && (VERBS.at(tokens, first.start).is_some() || tokens[first.start].is("having being"));
    let has_own = references.iter().any(|r| {
        r.at.start == first.start
            || first.contains(&r.at.start) && matches!(r.who, Named::Obstacle(_))
    });
    if !is_verb || has_own {
        return None;
    }
    let own: Vec<&Reference> = { references.iter() }
        .filter(|r| next.contains(&r.at.start) && !r.is_compared)
        .collect();
    let before = Before {
        last: None,
        it: None,
        noun: None,
        both: None,
    };
    let who = subject(tokens, next, &own, &before).0;
    Some(who).filter(|who| *who != Who::Unknown)
}

/// Whether a clause is about what lies between two: "so the gap shrinks".
fn is_gap(words: &[Token]) -> bool {
    const PAIRED: &str = "gap distance separation clearance ttc spacing";
    let noun = words.iter().take(4).position(|t| t.is(PAIRED));
    noun.is_some_and(|noun| {
        let mut before = words[..noun].iter();
        before.all(|t| t.is("so and but the this that because since as while"))
    })
}

/// The two obstacles that are named before a token; nothing where there are more or fewer.
fn two_before(references: &[Reference], at: usize) -> Option<Who> {
    let before = references.iter().filter(|r| r.at.end <= at);
    let mut pair: Vec<i64> = before
        .filter_map(|r| match r.who {
            Named::Obstacle(id) => Some(id),
            _ => None,
        })
        .collect();
    pair.dedup();
    (pair.len() == 2).then_some(Who::Obstacles(pair))
}

/// Whether a word begins a relative clause.
fn is_relative(tokens: &[Token], at: usize) -> bool {
    tokens.get(at).is_some_and(|t| t.is("which who whose"))
}

/// Of whom a clause says more that begins at a token: "305, which brakes", "a car parked on the left".
fn owner(tokens: &[Token], references: &[Reference], at: usize) -> Option<Named> {
    let bare = tokens[..at]
        .iter()
        .rposition(|t| !t.is(", ) (") && !t.is_filler());
    let end = bare? + 1;
    let one = references.iter().find(|r| r.at.end == end)?;
    let has_owner = is_relative(tokens, at)
        || tokens[at].is("that") && end == at
        || is_participle(tokens, references, at);
    // "Whose trailer" is something else.
    let is_its = !tokens[at].is("whose")
        || tokens
            .get(at + 1)
            .is_some_and(|t| is_property(t) || t.is("driver rider"));
    (has_owner && is_its).then_some(one.who)
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
    const OWN: &str = "speed velocity acceleration deceleration heading braking pace";
    let verb = at
        .clone()
        .find(|i| VERBS.at(tokens, *i).is_some() || tokens[*i].is("is are has am was were"));
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
    let has = |second: &Reference| {
        (at.start..at.start + 4).any(|i| {
            tokens
                .get(i)
                .is_some_and(|t| t.is("have got see notice spot"))
                && (i..i + 4).contains(&second.at.start)
        })
    };
    if let [first, second, ..] = own
        && has(second)
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
            // "7 is the nearest vehicle ahead": one and the same.
            if let [first, second] = own
                && first.at.end < second.at.start
                && verb.is_some_and(|verb| verb >= second.at.start)
                && tokens[first.at.end].is("is was remains")
            {
                return (one(id), None);
            }
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
                    .any(|t| t.is(OWN))
                && tokens[at.start..own[0].at.start].iter().all(|t| {
                    !t.is_word() || t.is("the and but while with at so reflects simply only of during throughout over whole entire window interval")
                });
            // "The speed of the ego".
            let governor = (at.start..own.first().map_or(at.start, |r| r.at.start))
                .rfind(|i| !tokens[*i].is("the"));
            let is_of_ego = is_of_ego
                || own[0].who == Named::Ego
                    && governor.is_some_and(|i| {
                        tokens[i].is("of")
                            && i > at.start
                            && (tokens[i - 1].is(OWN) || tokens[i - 1].is("orientation position"))
                    })
                    && !tokens[at.clone()].iter().any(|t| t.is("relative"));
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
                [id] if !has_property && verb.is_some_and(|verb| leads(tokens, at.start..verb)) => {
                    match last {
                        Some(Who::Ego) => (Who::Ego, Some(*id)),
                        Some(Who::Obstacles(all)) if all.as_slice() != [*id] => {
                            (Who::Obstacles(all.clone()), Some(*id))
                        }
                        _ => (one(*id), None),
                    }
                }
                [id] => (one(*id), None),
                // "No contact with 7 or 8".
                ids if are_listed(tokens, own) => (Who::Obstacles(ids.to_vec()), None),
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

/// Whether all that a clause names are one list: "with 7, 8 or 9".
fn are_listed(tokens: &[Token], own: &[&Reference]) -> bool {
    own.windows(2).all(|two| {
        let between = &tokens[two[0].at.end..two[1].at.start];
        !between.is_empty() && between.iter().all(|t| t.is("and or nor , with the to"))
    })
}

/// Whether nothing but small words stands before a verb: "and did not touch".
fn leads(tokens: &[Token], before: Range<usize>) -> bool {
    const SMALL: &str = "and but so then yet or also not never did do does have has had just still already again now will";
    tokens[before.clone()]
        .iter()
        .all(|t| t.is(SMALL) || t.is_filler())
        || before.len() <= 1
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
            // "No contact with 7 or 8".
            && !(t.is("or") && words[..i].iter().any(|t| t.is("no not never neither without")))
            // "As hard as I can".
            && !(t.is("can could possible possibly") && words[i.saturating_sub(2)..i].iter().any(|t| t.is("as")))
            // "When 305 was 69 m away".
            && !(t.is("when") && words.iter().any(|t| t.is("was were had")))
            && !(t.is("until") && words.get(i + 1).is_some_and(|t| t.is("then now")))
            // "TTC is below the 1 s threshold" is said.
            && !(t.is("threshold limit") && words[..i].iter().any(|t| t.is("below above under over within than exceeds")))
    });
    let advises = words
        .first()
        .is_some_and(|t| t.is("should had assume consider is are does do"))
        && words.len() > 3
        && !matches!(who, Who::Obstacles(_));
    let is_purpose = words.len() > 1 && words[0].is("to") && words[1].is(PURPOSES);
    if supposes
        || is_purpose
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
