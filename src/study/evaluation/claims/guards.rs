//! What the grammar does not read and would change what a claim says: claims beside it are left out.

use std::ops::Range;
use std::sync::LazyLock;

use super::clauses::Clause;
use super::number::{Number, Unit};
use super::references::{Named, Reference};
use super::tokens::{Lexicon, Token};
use super::{Claim, ClaimedValue, Extent, Predicate, Quantity};

/// How much is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reach {
    /// All that the sentence says.
    Sentence,
    /// All that its clause says.
    Clause,
    /// The numbers of its clause.
    Numbers,
    /// Contacts of its clause: from which side is not checked.
    Contacts,
}

static GUARDS: LazyLock<Lexicon<Reach>> = LazyLock::new(|| {
    use Reach::{Clause, Contacts, Numbers, Sentence};
    Lexicon::new(&[
        // It is said of a sentence, or of something that is not so.
        ("wrong|incorrect|untrue|false|mistaken that", Sentence),
        ("=incorrectly|=falsely|=hopefully|=allegedly", Sentence),
        ("deny|denies|refute|dispute that", Sentence),
        ("is =false|=wrong|=untrue|=incorrect", Sentence),
        ("as though|if", Sentence),
        ("in event that|of", Sentence),
        ("=hope|=hopes|=wish|=wishes", Sentence),
        ("had better", Sentence),
        ("supposed|ought to", Sentence),
        // All but some.
        ("apart|aside from", Sentence),
        ("other than", Sentence),
        ("=except|=besides|=excluding", Sentence),
        ("=followed|=tailgated by", Sentence),
        (
            "=fourth|=next closest|nearest|fastest|slowest|furthest|farthest|largest|smallest",
            Sentence,
        ),
        ("not =a single", Sentence),
        ("not =always|=constantly|=permanently|=continuously", Clause),
        ("hardly any", Sentence),
        // Times and extremes that are not looked up.
        ("=initial|=average|=mean", Numbers),
        (
            "=safe|=desired|=required|=recommended|=legal distance|gap|speed|headway|ttc|limit",
            Numbers,
        ),
        ("=doubled|=halved|=tripled", Clause),
        // Parts and multiples.
        ("half|=double|=twice|=triple of|the|as|that", Numbers),
        (
            "=double|=twice|=triple|=plus|=hundred|=thousand|=ft|=feet",
            Numbers,
        ),
        ("no less|fewer than", Numbers),
        ("above|below|over|under limit", Numbers),
        ("too short|long", Numbers),
        (
            "=stop|=stops|=stopped turning|accelerating|braking|approaching|moving",
            Clause,
        ),
        ("=leaving|=leaves|=leave me|us behind", Clause),
        ("=reversing", Clause),
        // Where it is hit.
        ("from behind|=front|=rear|=left|=right|=side", Contacts),
        (
            "=my|=our|=its =front|=rear|=left|=right|=side|=bumper",
            Contacts,
        ),
    ])
});

/// A sentence whose claims are to be guarded.
pub struct Guarded<'a> {
    pub tokens: &'a [Token],
    pub references: &'a [Reference],
    pub clauses: &'a [Clause],
    pub numbers: &'a [Number],
    pub lower: &'a str,
    /// Where it begins in the text.
    pub start: usize,
}

impl Guarded<'_> {
    fn is(&self, at: usize, words: &str) -> bool {
        self.tokens.get(at).is_some_and(|token| token.is(words))
    }

    fn number(&self, at: usize) -> Option<&Number> {
        let place = self.tokens.get(at)?.number?;
        self.numbers.get(place)
    }

    fn names(&self, at: usize) -> bool {
        self.references.iter().any(|r| r.at.start == at)
    }

    /// Leaves out the claims that something unread beside them changes.
    pub fn keep(&self, claims: &mut Vec<Claim>) {
        if self.is_all_changed() {
            claims.clear();
            return;
        }
        for clause in self.clauses {
            let Some(own) = self.span(&clause.at) else {
                continue;
            };
            claims.retain(|claim| {
                !own.contains(&claim.span.start) || !self.is_changed(clause, claim)
            });
        }
    }

    /// The bytes of tokens, in the text.
    fn span(&self, at: &Range<usize>) -> Option<Range<usize>> {
        let (first, last) = (self.tokens.get(at.start)?, self.tokens.get(at.end - 1)?);
        Some(self.start + first.span.start..self.start + last.span.end)
    }

    /// Whether a sentence says other than its clauses.
    fn is_all_changed(&self) -> bool {
        let all = self.tokens.len();
        let says = GUARDS.all(self.tokens, 0..all);
        // "Nothing is wrong" denies no sentence.
        let is_said =
            |at: &Range<usize>| at.start > 0 && self.is(at.start - 1, "nothing something what");
        if { says.iter() }.any(|(reach, at)| *reach == Reach::Sentence && !is_said(at)) {
            return true;
        }
        // "Were 7 braking", "in 0.8 s, 7 touches us".
        let later = self.is(0, "in after")
            && self.number(1).is_some_and(|n| n.unit == Unit::Second)
            && self.is(2, ", the vehicle obstacle car it we i ego");
        let opens = self.is(0, "were provided whenever assuming example");
        // "Nobody but 7", "just 7", "7 alone".
        let excepts = (0..all).any(|i| {
            let next = self.names(i + 1) && !self.is(i + 1, "it we i");
            let denies = (i.saturating_sub(4)..i)
                .any(|k| self.is(k, "no none nobody every all any each everyone"));
            self.is(i, "but") && next && denies
                || self.is(i, "just") && i == 0 && next
                || self.is(i, "alone")
        });
        // Signs that numbers are not read with: "15 m ± 2 m", "1,250 m", "1.6e3 m", digits of other scripts.
        let is_odd = |c: char| matches!(c, '±' | '\u{200b}'..='\u{200f}' | '\u{ff10}'..='\u{ff5e}' | '\u{feff}');
        let bytes = self.lower.as_bytes();
        let digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
        let grouped = (1..bytes.len()).any(|at| {
            let three = (1..4).all(|i| digit(at + i)) && !digit(at + 4);
            let one = digit(at - 1) && !(at > 3 && (1..5).all(|i| digit(at - i)));
            bytes[at] == b',' && one && three && bytes.get(at + 4) == Some(&b' ')
                || bytes[at] == b'e' && digit(at - 1) && digit(at + 1)
        });
        later || opens || excepts || grouped || self.lower.contains(is_odd)
    }

    /// Whether what a clause says beside a claim changes it.
    fn is_changed(&self, clause: &Clause, claim: &Claim) -> bool {
        let says = |words: &str| clause.at.clone().any(|i| self.is(i, words));
        let is_number = matches!(
            claim.stated,
            ClaimedValue::Number { .. } | ClaimedValue::Bounds { .. } | ClaimedValue::Change { .. }
        );
        let is_change = matches!(claim.stated, ClaimedValue::Change { .. });
        let is_contact = claim.quantity == Quantity::Contact;
        let guards = GUARDS.all(self.tokens, clause.at.clone());
        let is_guarded = guards.iter().any(|(reach, _)| match reach {
            Reach::Sentence | Reach::Clause => true,
            Reach::Numbers => is_number,
            Reach::Contacts => is_contact,
        });
        // "7 and 999 are behind": one is not known.
        let is_unknown = { self.references.iter() }.any(|r| {
            clause.at.contains(&r.at.start)
                && r.who == Named::Other
                && self.tokens[r.at.end - 1].number.is_some()
        });
        // "7 approaches from behind, 39 from ahead".
        let at = clause.at.start;
        let is_bare = !self.names(at)
            && self.number(at).is_some_and(|n| n.unit == Unit::None)
            && self.is(at + 1, "from at in on behind ahead left right");
        // "7 and 999 are behind", where nobody is 999.
        let is_unknown = is_unknown || { clause.at.clone() }.any(|i| {
            self.is(i, "and")
                && self.references.iter().any(|r| r.at.end == i)
                && !self.names(i + 1)
                && self.number(i + 1).is_some_and(|n| n.unit == Unit::None)
                && self.is(i + 2, "is are drive move approach brake")
        });
        // "A second ago", "over the last 0.3 s", "0.3 s longer than".
        let near = |i: usize| self.number(i).is_some_and(|n| n.unit == Unit::Second);
        let ago = { clause.at.clone() }
            .any(|i| self.is(i, "ago") && i > 0 && self.number(i - 1).is_none());
        let span = { clause.at.clone() }
            .any(|i| self.is(i, "last past previous") && (near(i + 1) || near(i + 2)));
        let more = clause
            .at
            .clone()
            .any(|i| self.is(i, "longer shorter") && i > 0 && self.number(i - 1).is_some());
        // "Not 20 m behind".
        let is_metres = |i: usize| self.number(i).is_some_and(|n| n.unit == Unit::Metre);
        let denied = (is_number || claim.quantity == Quantity::Side) && { clause.at.clone() }
            .any(|i| self.is(i, "not") && is_metres(i + 1));
        // "A lane change to the left is not safe".
        let is_noun = |i: usize| {
            self.is(i, "lane")
                && self.is(i + 1, "change")
                && i <= clause.at.start + 2
                && (clause.at.start..i).all(|k| !self.names(k) && self.tokens[k].is_filler())
        };
        let noun = matches!(
            claim.stated,
            ClaimedValue::Word {
                predicate: Predicate::ChangesLane,
                ..
            }
        ) && clause.at.clone().any(is_noun);
        // "Heading slightly to the left" is no place.
        let turned = claim.quantity == Quantity::Side
            && (says("heading headed facing oriented pointing angled degrees")
                || self.lower.contains('°'));
        // "Hits us at 7.5 m/s" is the speed then; "a stationary queue" is not whom the clause is about.
        let then = is_number
            && matches!(claim.quantity, Quantity::Speed | Quantity::ClosingSpeed)
            && claim.step.is_none()
            && says("hits hit strikes touches collides crashes impact");
        let of_another =
            claim.is_of_ego && claim.quantity == Quantity::Speed && { clause.at.clone() }.any(
                |i| {
                    self.is(i, "stationary standing stopped parked")
                        && !self.is(i + 1, "still")
                        && i > 0
                        && self.is(i - 1, "a the some")
                },
            );
        let smallest = is_number && { clause.at.clone() }
            .any(|i| self.is(i, "lowest smallest shortest highest largest") && !says("to of for"));
        is_guarded
            || is_unknown
            || is_bare
            || ago
            || span && is_number && !is_change
            || more
            || denied
            || noun
            || turned
            || then
            || of_another
            || smallest && !claim.named && claim.extent == Extent::Moment
    }
}
