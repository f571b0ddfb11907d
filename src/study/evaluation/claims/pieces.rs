//! The parts of a sentence that may be clauses: between marks, and from words that begin one.

use std::ops::Range;

use super::clauses::PURPOSES;
use super::references::{Named, Reference};
use super::tokens::Token;
use super::verbs::VERBS;

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

/// Verbs whose "to" belongs to them: "needs to pass".
const TAKES_TO: &str = "need needs needed want wants able going about ready have has had likely unlikely ought used due continue \
        continues begin begins began start starts started manage manages managed";

/// The parts between marks and words that begin clauses, with the mark behind each.
pub(super) fn pieces<'t>(
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
            && !has_unit
            && after.is_some_and(|a| a.is("and"))
            && before.is_some_and(|b| b.number.is_some())
            && tokens.get(at + 2).is_some_and(|t| t.number.is_some());
        // "304, 44 m ahead".
        let is_measured = after.is_some_and(|a| a.word.contains(char::is_alphabetic));
        let is_id = is_measured
            && references
                .iter()
                .any(|r| r.at.end == at && r.who != Named::Ego);
        let is_pair_of = both_numbers && !has_unit && !is_id && token.is(", - – —");
        if is_mark && !is_list && !is_pair_of {
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
                    && tokens[at - 2].number.is_some()
                    && !tokens[at - 2].word.contains(char::is_alphabetic);
                // "Obstacle 7 and obstacle 8 are", "both the ego and the obstacle are".
                let first = references.iter().find(|r| r.at.end == at);
                let second = { references.iter() }
                    .find(|r| r.at.start == at + 1 || r.who == Named::Ego && r.at.start == at + 2);
                let is_one =
                    |who: Named| matches!(who, Named::Obstacle(_) | Named::It | Named::Ego);
                let is_listed = first.zip(second).is_some_and(|(first, second)| {
                    let is_ego = first.who == Named::Ego || second.who == Named::Ego;
                    let is_id = matches!(second.who, Named::Obstacle(_));
                    let begins = first.at.start <= from + 1
                        || second.who == Named::Ego && matches!(first.who, Named::Obstacle(_))
                        || first.who == Named::Ego
                            && is_id
                            && before.is_some_and(|b| b.is("ego vehicle"));
                    // "The ego brakes, and 7 and the ego are close".
                    let ends = second.who != Named::Ego
                        || tokens.get(second.at.end).is_some_and(|t| {
                            t.is("are were is share both remain collide collided touch touched")
                        });
                    begins
                        && ends
                        && is_one(first.who)
                        && is_one(second.who)
                        && (!is_ego || first.who != second.who)
                });
                let names =
                    |r: &Reference| r.at.start == at + 1 && matches!(r.who, Named::Obstacle(_));
                let is_pair = both_numbers
                    || is_listed
                    || is_last
                    || axis(after)
                    || axis(before) && before.is_some_and(|b| b.is("longitudinal lateral"))
                    || place(before)
                        && side
                        && !after.is_some_and(|a| a.is("a an is are was has"))
                        && !references.iter().any(names)
                    || at < depth_between;
                !is_pair
            }
            // "A collision with 7" is one.
            "with" => {
                const JOINED: [&str; 22] = [
                    "intersect",
                    "sidesw",
                    "sideswip",
                    "up",
                    "pace",
                    "line",
                    "align",
                    "touch",
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
                // "No collision will occur with 7".
                let meets = references
                    .iter()
                    .any(|r| (at + 1..at + 3).contains(&r.at.start));
                let back = if meets { 5 } else { 2 };
                !(at.saturating_sub(back)..at).any(|i| JOINED.contains(&tokens[i].stem.as_str()))
            }
            "that" => after.is_some_and(|a| a.is("is was has will does came cut just had")),
            "as" => {
                after.is_some_and(|a| a.is("it the he she they we i"))
                    && !before.is_some_and(|b| b.is("as same well such near close"))
                    && !(from.max(at.saturating_sub(3))..at).any(|i| tokens[i].is("same as"))
            }
            // What it is for: "I brake to let it pass".
            "to" => {
                at > from
                    && after.is_some_and(|a| a.is(PURPOSES))
                    && !before.is_some_and(|b| b.is(TAKES_TO))
            }
            "since" | "before" | "after" => {
                after.is_some_and(|a| a.number.is_none())
                    || references.iter().any(|r| r.at.start == at + 1)
            }
            "yet" => !before.is_some_and(|b| b.is("not")),
            "so" => !before.is_some_and(|b| b.is("or not")),
            // "The pedestrian who came from the left is ahead".
            "is" | "are" | "was" | "will" | "has" => {
                let is_aside = tokens[from].is("who which") || tokens[from].is("that") && from > 0;
                is_aside
                    && at > from + 2
                    && (from + 1..at).any(|i| {
                        VERBS.at(tokens, i).is_some() || tokens[i].is("is are was has had")
                    })
                    && !before.is_some_and(|b| b.is("and or but not it he she that which who"))
                    && !references
                        .iter()
                        .any(|r| r.at.end == at && r.at.start > from)
            }
            "until" => !after.is_some_and(|a| a.is("then now")),
            word => {
                // "Not indicating a collision".
                OPENERS.contains(&word) && !before.is_some_and(|b| b.is("not"))
                    || is_thought(tokens, references, (from, at))
                    || is_participle(tokens, references, at)
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

/// Whether a participle behind a participant that is not what its clause is about begins at a token: "I pass a car parked there".
pub(super) fn is_participle(tokens: &[Token], references: &[Reference], at: usize) -> bool {
    let token = &tokens[at];
    let ends = token.word.ends_with("ing") || token.word.ends_with("ed");
    if !ends
        || !tokens[at].is_word()
        || VERBS.at(tokens, at).is_none() && !token.is("waiting coming doing")
    {
        return false;
    }
    let bare = tokens[..at].iter().rposition(|t| !t.is_filler());
    let Some(one) = bare.and_then(|last| references.iter().find(|r| r.at.end == last + 1)) else {
        return false;
    };
    // Of "301 braking" it is the verb.
    let from = tokens[..one.at.start].iter().rposition(|t| t.is(", ; : ("));
    let from = from.map_or(0, |i| i + 1);
    let has_verb = (from..one.at.start)
        .any(|i| tokens[i].is("is are am have see there") || VERBS.at(tokens, i).is_some());
    let is_thought = is_thought(tokens, references, (from, one.at.start));
    one.who != Named::Ego && has_verb && !is_thought
}
