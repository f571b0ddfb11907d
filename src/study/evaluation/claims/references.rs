//! Whom the words of a sentence mean: an obstacle by its id, a pronoun or a description, the ego, nobody, or someone else.

use std::ops::Range;
use std::sync::LazyLock;

use nearmiss_scene::scenario::ObstacleType;

use super::cast::{Cast, Description};
use super::mentions::Mention;
use super::places::{PLACES, Placed};
use super::tokens::{Lexicon, Token};
use super::verbs::{Act, VERBS};
use super::{Predicate, Side};

/// Who is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Named {
    /// An obstacle.
    Obstacle(i64),
    /// Whoever was spoken of before.
    It,
    /// The ego.
    Ego,
    /// No one: "no vehicle".
    Nobody,
    /// The only two obstacles that the text names: "both obstacles".
    Both,
    /// Someone or something else, or several.
    Other,
}

/// A reference in a sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Its tokens.
    pub at: Range<usize>,
    /// Who is meant.
    pub who: Named,
    /// Whether a preposition stands before it, or it is possessive: "to the ego", "its".
    pub is_governed: bool,
    /// Whether something is only compared with it.
    pub is_compared: bool,
    /// What a description says of it, with the tokens that do.
    pub says: Vec<(Described, Range<usize>)>,
    /// Whether it is described as the nearest.
    pub is_nearest: bool,
    /// Whether it is one that is known: "the car", not "a car".
    pub is_definite: bool,
    /// Of a description that fits several, who they are, the nearest first.
    pub candidates: Vec<i64>,
}

/// What a description says of whom it means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Described {
    /// Where it is.
    At(Side),
    /// That it stands.
    Stands,
    /// Something else.
    Is(Predicate),
}

/// What nouns call a participant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Noun {
    /// Any obstacle.
    Any,
    /// One of two types.
    Of(ObstacleType, ObstacleType),
    /// Who drives ahead.
    Leader,
    /// Who drives behind.
    Follower,
}

static NOUNS: LazyLock<Lexicon<Noun>> = LazyLock::new(|| {
    use Noun::{Any, Follower, Leader, Of};
    use ObstacleType as Type;
    let of = |kind| Of(kind, kind);
    Lexicon::new(&[
        ("obstacle|object|agent|participant|actor|target", Any),
        ("road user", Any),
        ("vehicle|guy|driver", Any),
        ("leader", Leader),
        ("follower", Follower),
        ("car|sedan|suv|hatchback", Of(Type::Car, Type::Taxi)),
        ("taxi|cab", of(Type::Taxi)),
        ("truck|lorry|van|semi|trailer", of(Type::Truck)),
        ("bus|coach", of(Type::Bus)),
        (
            "pedestrian|person|walker|man|woman|child|kid",
            of(Type::Pedestrian),
        ),
        ("cyclist|bicycle|bicyclist", of(Type::Bicycle)),
        ("bike|rider", Of(Type::Bicycle, Type::Motorcycle)),
        (
            "motorcycle|motorcyclist|motorbike|scooter",
            of(Type::Motorcycle),
        ),
        ("train|tram", of(Type::Train)),
        ("somebody|someone|something", Any),
        ("one|breakdown", Any),
    ])
});

/// What stands before a noun and tells which one is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Adjective {
    Says(Described),
    Nearest,
    /// That it is the most dangerous, which is for a sentence to say.
    Extreme,
    Another,
    /// It tells nothing that is known here.
    Empty,
}

static ADJECTIVES: LazyLock<Lexicon<Adjective>> = LazyLock::new(|| {
    use Adjective::{Another, Empty, Extreme, Nearest, Says};
    use Described::{At, Is, Stands};
    let along = |front| {
        Says(At(Side {
            front: Some(front),
            left: None,
        }))
    };
    let across = |left| {
        Says(At(Side {
            front: None,
            left: Some(left),
        }))
    };
    Lexicon::new(&[
        ("lead|=leading|preceding|front", along(true)),
        ("=following|trailing|tailing|rear", along(false)),
        ("=left", across(true)),
        ("=right", across(false)),
        (
            "parked|=stopped|=standing|=waiting|stranded|disabled|stationary|static|stalled",
            Says(Stands),
        ),
        ("broken down", Says(Stands)),
        ("oncoming|opposing", Says(Is(Predicate::Oncoming))),
        ("=crossing", Says(Is(Predicate::Crossing))),
        (
            "=braking|=slowing|decelerating",
            Says(Is(Predicate::Braking)),
        ),
        ("=accelerating", Says(Is(Predicate::Accelerating))),
        ("slower", Says(Is(Predicate::SlowerThanEgo))),
        ("faster", Says(Is(Predicate::FasterThanEgo))),
        ("struck", Empty),
        ("nearest|closest", Nearest),
        ("most dangerous|critical|relevant|risky|important", Extreme),
        ("other|another|second|third|next", Another),
        (
            "same|said|given|slow|fast|big|large|small|motor|relevant|critical|huge",
            Empty,
        ),
        (
            "=last|=first|passenger|delivery|=merging|=turning|=approaching|=moving|=passing",
            Empty,
        ),
        (
            "lone|single|only|priority|heavy|dynamic|pickup|police",
            Empty,
        ),
        ("red|white|black|blue|grey|gray|silver|dark", Empty),
    ])
});

/// Words for the ego.
const EGO: &str = "ego i we me us my our mine ours you your myself ourselves av";

/// Words for one that was spoken of, for several, and that own what follows.
const IT: &str = "it its itself he his him she her";
const OTHERS: &str = "they their them others everyone everybody everything traffic";
const OWNERS: &str = "my our your its his her their mine ours";

/// Words before a noun that single it out, and those that make it several.
const DETERMINERS: &str = "the a an this that such our my said";
const SEVERAL: &str = "all every each any some one several many few these those two three four five six seven eight nine ten eleven twelve multiple";

/// Prepositions that make what follows no subject.
const PREPOSITIONS: [&str; 37] = [
    "to",
    "from",
    "of",
    "with",
    "for",
    "behind",
    "ahead",
    "at",
    "in",
    "on",
    "into",
    "between",
    "than",
    "toward",
    "towards",
    "against",
    "by",
    "near",
    "beside",
    "past",
    "around",
    "over",
    "off",
    "relative",
    "as",
    "vs",
    "versus",
    "like",
    "unlike",
    "about",
    "regarding",
    "before",
    "after",
    "above",
    "alongside",
    "via",
    "among",
];

/// The references of a sentence; `ids` are those that [`super::mentions::mentions`] has found in it.
pub fn references(tokens: &[Token], ids: &[Mention], cast: Cast<'_>) -> Vec<Reference> {
    let reader = Reader { tokens, ids, cast };
    let mut found: Vec<Reference> = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        let Some(mut one) = reader.reference(at) else {
            at += 1;
            continue;
        };
        at = one.at.end;
        reader.place(&mut one, &found);
        found.push(one);
    }
    found
}

/// Reads the references of a sentence.
struct Reader<'a> {
    tokens: &'a [Token],
    ids: &'a [Mention],
    cast: Cast<'a>,
}

/// The two types that a noun at a place calls participants by; `None` of nouns for all of them.
pub(super) fn types_at(tokens: &[Token], at: Range<usize>) -> Option<(ObstacleType, ObstacleType)> {
    let nouns = NOUNS.all(tokens, at);
    nouns.into_iter().find_map(|(noun, _)| match noun {
        Noun::Of(one, other) => Some((one, other)),
        _ => None,
    })
}

impl<'a> Reader<'a> {
    fn is(&self, at: usize, words: &str) -> bool {
        self.tokens.get(at).is_some_and(|token| token.is(words))
    }

    /// The obstacle whose id a token is.
    fn id(&self, at: usize) -> Option<Mention> {
        let token = self.tokens.get(at)?;
        token.number?;
        let inside = |m: &&Mention| token.span.contains(&m.span.start);
        if let Some(one) = self.ids.iter().find(inside) {
            return Some(one.clone());
        }
        // Named again; a short number may be another one.
        let id = token.word.parse::<i64>().ok().filter(|id| *id >= 100)?;
        let again = self.ids.iter().find(|m| m.id == Some(id))?;
        Some(Mention {
            span: token.span.clone(),
            compared: false,
            ..again.clone()
        })
    }

    /// Who a reference that begins at a token names, and where it ends.
    fn reference(&self, at: usize) -> Option<Reference> {
        let plain = |who, end| {
            Some(Reference {
                at: at..end,
                who,
                is_governed: false,
                is_compared: false,
                says: Vec::new(),
                is_nearest: false,
                is_definite: true,
                candidates: Vec::new(),
            })
        };
        let token = &self.tokens[at];
        if let Some(mention) = self.id(at) {
            let mut one = plain(mention.id.map_or(Named::Other, Named::Obstacle), at + 1)?;
            one.is_compared = mention.compared;
            return Some(one);
        }
        let noun = "vehicle car agent driver truck";
        // "I.e."
        if token.is("i") && self.is(at + 1, "e") {
            return None;
        }
        if token.is(EGO) {
            // "Our lead car" is not ours.
            if token.is("my our your")
                && let Some(other) = self.described(at + 1)
                && !other.says.is_empty()
            {
                return Some(Reference {
                    at: at..other.at.end,
                    ..other
                });
            }
            let own = if token.is("my our your") && self.is(at + 1, "own") {
                at + 2
            } else {
                at + 1
            };
            return plain(Named::Ego, own + usize::from(self.is(own, noun)));
        }
        if token.is("host autonomous own subject test") && self.is(at + 1, noun) {
            return plain(Named::Ego, at + 2);
        }
        if token.is("self") && self.is(at + 1, "driving") && self.is(at + 2, noun) {
            return plain(Named::Ego, at + 3);
        }
        if token.is(IT) {
            return plain(Named::It, at + 1);
        }
        if token.is("them") && at > 0 && self.is(at - 1, "between") {
            return plain(Named::It, at + 1);
        }
        if token.is(OTHERS) {
            return plain(Named::Other, at + 1);
        }
        if token.is("both") {
            let next = (at + 1..at + 4).find(|i| !self.is(*i, "of the these"))?;
            let end = next + usize::from(self.is(next, "obstacles objects"));
            return plain(Named::Both, end).filter(|_| end > next);
        }
        let is_nothing = token.is("nothing")
            && self.is(
                at + 1,
                "is are was remains drives in within behind ahead on",
            );
        if token.is("nobody none") || is_nothing {
            return plain(Named::Nobody, at + 1);
        }
        if token.is("no") && self.is(at + 1, "one body") {
            return plain(Named::Nobody, at + 2);
        }
        self.described(at)
    }

    /// A noun with what stands before and behind it: "the car ahead of us", "obstacle 7", "another vehicle".
    fn described(&self, from: usize) -> Option<Reference> {
        let (mut at, mut asked) = (from, Description::default());
        let mut says: Vec<(Described, Range<usize>)> = Vec::new();
        let is_none = self.is(at, "no");
        let is_number = self.id(at).is_none() && { self.tokens.get(at) }
            .is_some_and(|t| t.number.is_some() && t.word.bytes().all(|b| b.is_ascii_digit()));
        let is_several = self.is(at, SEVERAL) || is_number;
        let is_this = self.is(at, "this that");
        let has_determiner = self.is(at, DETERMINERS);
        let is_indefinite = self.is(at, "a an");
        // "It is a truck" names no one.
        let before = from.checked_sub(1);
        let is_there = before
            .and_then(|i| i.checked_sub(1))
            .is_some_and(|i| self.is(i, "there"));
        if is_indefinite && !is_there && before.is_some_and(|i| self.is(i, "is as be")) {
            return None;
        }
        if is_none || is_several || has_determiner {
            at += 1;
            if self.is(at, "the of") {
                at += 1 + usize::from(self.is(at + 1, "the"));
            }
        }
        let mut is_another = false;
        let mut is_extreme = false;
        let mut is_same = is_this;
        while let Some((adjective, end)) = ADJECTIVES.at(self.tokens, at) {
            // "Following car 7" is a verb.
            if !has_determiner && self.is(at, "following") {
                return None;
            }
            match adjective {
                Adjective::Says(said) => {
                    if let Described::At(side) = said {
                        asked.side = Some(side);
                    } else {
                        asked.says.push(said);
                    }
                    says.push((said, at..end));
                }
                Adjective::Nearest => asked.is_nearest = true,
                Adjective::Extreme => is_extreme = true,
                Adjective::Another => is_another = true,
                Adjective::Empty => is_same |= self.is(at, "same said given"),
            }
            at = end;
        }
        // "The oncoming 305".
        if has_determiner
            && !says.is_empty()
            && let Some(mention) = self.id(at)
        {
            return Some(Reference {
                at: from..at + 1,
                who: mention.id.map_or(Named::Other, Named::Obstacle),
                is_governed: false,
                is_compared: mention.compared,
                says,
                is_nearest: false,
                is_definite: true,
                candidates: Vec::new(),
            });
        }
        let (mut noun, mut end) = NOUNS.at(self.tokens, at)?;
        // "The pedestrian on the right and the one on the left".
        if self.is(at, "one")
            && let Some((called, _)) = NOUNS.all(self.tokens, 0..from).pop()
            && matches!(called, Noun::Of(..))
        {
            noun = called;
        }
        // "On the left someone is near", "something like 15 m".
        let is_like = self.is(at, "something") && self.is(at + 1, "like of");
        if is_like || at > from && self.is(at, "somebody someone something") {
            return None;
        }
        // "Lane 3 vehicle" counts nothing.
        if is_number && !self.tokens[end - 1].word.ends_with('s') {
            return None;
        }
        // "One of them", "one second".
        if self.is(at, "one") && !has_determiner && !is_another && says.is_empty() {
            return None;
        }
        // "The delivery truck driver".
        while let Some((_, further)) = NOUNS.at(self.tokens, end) {
            end = further;
        }
        asked.noun = Some(noun);
        let last = &self.tokens[end - 1];
        let is_plural = last.word.ends_with('s') && last.word != last.stem && !last.is("bus");
        let is_nearest = asked.is_nearest || is_extreme;
        let reference = |who, end, says| {
            Some(Reference {
                at: from..end,
                who,
                is_governed: false,
                is_compared: false,
                says,
                is_nearest,
                is_definite: has_determiner && !is_indefinite,
                candidates: Vec::new(),
            })
        };
        if let Noun::Leader | Noun::Follower = noun {
            let side = Side {
                front: Some(noun == Noun::Leader),
                left: None,
            };
            asked.side = Some(side);
            says.push((Described::At(side), at..end));
        }
        // "Obstacle 7", "vehicle (id 7)", "car #7".
        let id_at = (end..end + 3)
            .take_while(|i| *i == end || self.is(i - 1, "id ( number no : ids"))
            .find_map(|i| Some((i, self.id(i)?)));
        if let Some((place, mention)) = id_at {
            let is_other = |id: i64| {
                let kind = self.cast.kind(id);
                matches!(noun, Noun::Of(one, other) if one != ObstacleType::Car
                    && kind.is_some_and(|kind| kind != one && kind != other))
            };
            let who = match mention.id {
                // "The bicycle 7" that is a truck.
                Some(id) if !is_other(id) => Named::Obstacle(id),
                _ => Named::Other,
            };
            let mut one = reference(who, place + 1, says)?;
            one.is_compared = mention.compared;
            return Some(one);
        }
        if is_none {
            return reference(Named::Nobody, end, Vec::new());
        }
        if is_several || is_plural || is_extreme || self.is_restricted(end) {
            return reference(Named::Other, end, Vec::new());
        }
        // Without an article only the beginning of a note: "Car ahead brakes", "oncoming bus".
        let is_someone = self.is(from, "somebody someone something");
        // "Both ego and obstacle are", "(obstacle behind)".
        let is_joined = self.is(from, "obstacle")
            && before.is_some_and(|i| self.is(i, "and ( while as , :"))
            && end == from + 1;
        if is_joined {
            return reference(Named::It, end, Vec::new());
        }
        // "Leader in my lane": what a note says of whom it is about.
        let is_noted = from == 0 || self.is(from - 1, ", : ; (");
        if !has_determiner
            && is_noted
            && let Noun::Leader | Noun::Follower = noun
        {
            let side = Side {
                front: Some(noun == Noun::Leader),
                left: None,
            };
            return reference(Named::It, end, vec![(Described::At(side), at..end)]);
        }
        if !has_determiner && from != 0 && says.is_empty() && !is_someone && !is_another {
            return None;
        }
        // "Stationary obstacle": what a note says of whom it is about.
        if !has_determiner && matches!(noun, Noun::Any) && asked.side.is_none() && !is_someone {
            let stop = self.behind(end, &mut asked, &mut says);
            return reference(Named::It, stop, says);
        }
        let stop = self.behind(end, &mut asked, &mut says);
        // "That oncoming car" is looked for.
        is_same &= stop == end && (!is_this || asked.says.is_empty());
        let is_described = asked.side.is_some()
            || asked.lane.is_some()
            || !asked.says.is_empty()
            || asked.is_nearest
            || asked.origin.is_some()
            || matches!(noun, Noun::Of(..) if !is_same);
        let is_any = matches!(noun, Noun::Any | Noun::Of(ObstacleType::Car, _));
        // "The car that just cut in" is one of all.
        let is_only = (from..at).any(|i| self.is(i, "only"));
        let is_told = self.is(stop, "that who") && !self.is(stop + 1, "the") && !is_only;
        let is_new = is_indefinite || is_someone || is_another;
        let mut candidates = Vec::new();
        // "That bus" where there is only one.
        let only = match noun {
            Noun::Of(one, _) if is_this && one != ObstacleType::Car => {
                <[i64; 1]>::try_from(self.cast.find(&asked).1).ok()
            }
            _ => None,
        };
        let who = if let Some([id]) = only {
            Named::Obstacle(id)
        } else if (is_same || !is_described) && !is_new && !is_told {
            Named::It
        } else {
            let (found, all) = self.cast.find(&asked);
            match found {
                Some(id) if !is_another && is_described && (!is_told || all.len() == 1) => {
                    Named::Obstacle(id)
                }
                None if is_any
                    && says.is_empty()
                    && asked.origin.is_none()
                    && !is_new
                    && !is_told
                    && !asked.is_nearest =>
                {
                    Named::It
                }
                _ => {
                    candidates = all;
                    Named::Other
                }
            }
        };
        let mut one = reference(who, stop, says)?;
        one.candidates = candidates;
        Some(one)
    }

    /// Whether what stands behind a noun makes it one that is not looked up: "the car behind 7", "the truck we overtook".
    fn is_restricted(&self, end: usize) -> bool {
        let stop = match PLACES.at(self.tokens, end) {
            Some((_, stop)) => stop,
            None if self.is(end, "near beside past between") => end + 1,
            None => {
                return self.is(end, "we i you")
                    && self.is(end + 1, "just overtook passed met hit saw had have");
            }
        };
        let at = stop
            + usize::from(self.is(stop, "of"))
            + usize::from(self.is(stop + usize::from(self.is(stop, "of")), "the"));
        let Some(token) = self.tokens.get(at) else {
            return false;
        };
        let is_number = token.number.is_some() && token.word.bytes().all(|b| b.is_ascii_digit());
        is_number
            || self.is(at, "it him her them")
            || self.described(at).is_some() && !self.is(at, EGO)
    }

    /// What stands behind a noun and tells where it is: "ahead of us", "on the left", "in the right lane".
    fn behind(
        &self,
        end: usize,
        asked: &mut Description,
        says: &mut Vec<(Described, Range<usize>)>,
    ) -> usize {
        let mut at = end;
        while self.tokens.get(at).is_some_and(|t| {
            t.is("directly right just immediately currently now straight up out over further")
                && !self.is(at + 1, "lane of")
        }) {
            at += 1;
        }
        if self.measured(at, asked) {
            return end;
        }
        if let Some(stop) = self.coming(at, asked, says) {
            return stop.unwrap_or(end);
        }
        if self.is(at, "in on") {
            let side = (at + 1..at + 4).find(|i| self.is(*i, "left right"));
            if let Some(place) = side
                && self.is(place + 1, "lane")
            {
                let left = self.is(place, "left");
                asked.lane = Some(left);
                says.push((Described::Is(Predicate::NeighbourLane(left)), at..place + 2));
                return place + 2;
            }
        }
        if let Some((Placed::At(side), stop)) = PLACES.at(self.tokens, at)
            && asked.side.is_none()
            // "The car behind 7" is another one.
            && !(self.is(stop, "of") || self.id(stop).is_some() || self.described(stop).is_some())
        {
            asked.side = Some(side);
            says.push((Described::At(side), at..stop));
            // "Behind me on the left".
            let mut end = stop;
            if let Some((Placed::At(other), stop)) = PLACES.at(self.tokens, stop)
                && (side.front.is_none(), side.left.is_none())
                    == (other.front.is_some(), other.left.is_some())
            {
                asked.side = Some(Side {
                    front: side.front.or(other.front),
                    left: side.left.or(other.left),
                });
                says.push((Described::At(other), end..stop));
                end = stop;
            }
            // "The one behind us in our lane".
            return self.lane(end, asked, says).unwrap_or(end);
        }
        self.lane(at, asked, says).unwrap_or(end)
    }

    /// Whether a length with a place stands there, which the clause says: "a car 37 m behind".
    fn measured(&self, at: usize, asked: &mut Description) -> bool {
        let is_length = |i: &usize| {
            let token = self.tokens.get(*i);
            token.is_some_and(|t| t.number.is_some() && t.word.ends_with(['m', 's']))
        };
        let length = (at..at + 3)
            .take_while(|i| *i == at || self.is(i - 1, "about some just only roughly around"))
            .find(is_length);
        let place = length.and_then(|length| PLACES.at(self.tokens, length + 1));
        if let Some((Placed::At(side), stop)) = place
            && asked.side.is_none()
        {
            asked.side = Some(side);
            self.lane(stop, asked, &mut Vec::new());
        }
        length.is_some()
    }

    /// Whether it is told from where it comes, and where a description ends that says so: "from the right", "coming the other way".
    fn coming(
        &self,
        at: usize,
        asked: &mut Description,
        says: &mut Vec<(Described, Range<usize>)>,
    ) -> Option<Option<usize>> {
        let verb = at + usize::from(self.is(at, "coming approaching crossing arriving"));
        if verb > at && self.is(verb, "towards toward at the") {
            let is_way = self.is(verb, "the") && self.is(verb + 1, "other opposite");
            if is_way || !self.is(verb, "the") {
                asked.says.push(Described::Is(Predicate::Oncoming));
            }
            if is_way {
                says.push((Described::Is(Predicate::Oncoming), at..verb + 3));
            }
            return Some(is_way.then_some(verb + 3));
        }
        if !self.is(verb, "from") {
            return None;
        }
        let place = (verb + 1..verb + 4).find(|i| self.is(*i, "left right ahead behind"));
        // Who was in a lane before is looked for among all.
        if place.is_some_and(|place| self.is(place + 1, "lane")) {
            asked.origin = Some(Side {
                front: None,
                left: None,
            });
        } else if let Some(place) = place.filter(|place| !self.is(place + 1, "of")) {
            let is_along = self.is(place, "ahead behind");
            asked.origin = Some(Side {
                front: is_along.then(|| self.is(place, "ahead")),
                left: (!is_along).then(|| self.is(place, "left")),
            });
        }
        Some(None)
    }

    /// Where the words end that put it in the ego's lane or in one beside it.
    fn lane(
        &self,
        at: usize,
        asked: &mut Description,
        says: &mut Vec<(Described, Range<usize>)>,
    ) -> Option<usize> {
        if !self.is(at, "in") {
            return None;
        }
        let (act, end) = VERBS.at(self.tokens, at)?;
        let Act::Pair(lane @ (Predicate::SameLane | Predicate::NeighbourLane(_))) = act else {
            return None;
        };
        match lane {
            Predicate::NeighbourLane(left) => asked.lane = Some(left),
            _ => asked.is_in_lane = true,
        }
        says.push((Described::Is(lane), at..end));
        Some(end)
    }

    /// Whether a preposition stands before a reference.
    fn place(&self, one: &mut Reference, found: &[Reference]) {
        let at = one.at.start;
        let limit = found.last().map_or(0, |last| last.at.end).min(at);
        let before = self.tokens[limit..at].iter().rev();
        let word = { before }
            .find(|t| !t.is("the a an that this = id # right directly"))
            .map(|t| t.word.as_str());
        // "Between the ego and 7": so is the second one.
        let is_second = word == Some("and")
            && found
                .last()
                .is_some_and(|last| last.is_governed && last.at.end + 2 >= at);
        let is_owner = self.is(at, OWNERS)
            || self.is(one.at.end, "'s")
            || matches!(one.who, Named::Obstacle(_))
                && self.tokens[one.at.end - 1].word.ends_with("'s");
        // "As the ego is braking" begins a clause.
        let is_opened = matches!(word, Some("as" | "before" | "after"))
            && self.is(one.at.end, "is are has was will");
        one.is_governed = is_owner && (one.says.is_empty() || !self.is(at, OWNERS))
            || is_second
            || word.is_some_and(|word| PREPOSITIONS.contains(&word)) && !is_opened;
        let compares = at > 1
            && (at.saturating_sub(3)..at)
                .any(|i| self.is(i, "compared comparison") && self.is(i + 1, "to with"));
        one.is_compared |= word == Some("than") || compares;
    }
}
