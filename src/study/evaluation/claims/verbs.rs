//! What a clause says in words: how its participant moves, in which lane it is, where it is, and whether it touches the ego.

use std::ops::Range;
use std::sync::LazyLock;

use super::clauses::{Clause, Mood, Who};
use super::phrases::{NOTHING, axis_before};
use super::places::{PLACES, Placed};
use super::references::{Described, Named, Reference};
use super::tokens::{Lexicon, Token};
use super::number::{Number, Unit};
use super::{ClaimedValue, Compared, Counted, Dimension, Predicate, Quantity, Side};

/// What a verb or a phrase does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Act {
    /// The distance between them shrinks (true) or grows.
    Nears(bool),
    /// The same, where what is near must be the ego: "approaching".
    Approaches,
    /// Of one's own motion.
    Own(Predicate),
    /// Of one of the two, seen from the other: lane and direction.
    Pair(Predicate),
    /// The same, where a clause begins with it.
    Note(Predicate),
    /// It stands.
    Stands,
    /// It moves.
    Moves,
    /// It drives behind the other.
    Follows,
    /// It touches the other.
    Touches,
    /// "Collision", "contact".
    Contact,
    /// A verb that claims nothing.
    Other,
}

/// Verbs and phrases, the longest first.
pub static VERBS: LazyLock<Lexicon<Act>> = LazyLock::new(|| {
    use Act::{Approaches, Contact, Follows, Moves, Nears, Note, Other, Own, Pair, Stands, Touches};
    use Predicate as P;
    Lexicon::new(&[
        // Distance.
        ("approaches|=approaching|=approached|converges|=nearing|=nears", Approaches),
        ("=closing|=closes ?in ?on", Approaches),
        ("close in ?on", Nears(true)),
        ("gains on", Nears(true)),
        ("catches|=catching|=caught up", Nears(true)),
        ("get|come|move|draw|goes|edge|drift|creep|inch closer|nearer", Nears(true)),
        ("=coming|=comes|creep up", Nears(true)),
        ("move|drive|head|travel|come|goes|ride|walk|run|drift|race|speed|roll ?straight ?right toward|towards|at ego|us|me|you", Nears(true)),
        ("=closing|=closes|=closed|reduce|shorten|decrease|narrow|shrink|eat|lessen distance|gap|separation|space|spacing", Nears(true)),
        ("close gap", Nears(true)),
        ("velocity|motion|movement|directed|moving|travelling|traveling toward|towards ego|us|me", Nears(true)),
        ("high|positive|continued|continuing|rapid|significant|fast|strong ?longitudinal|lateral =closing speed|velocity|rate", Nears(true)),
        ("rate of closure", Nears(true)),
        ("recede|diverge|=retreating", Nears(false)),
        ("move|drive|pull|drift|head|goes|travel|walk|get|run|ride|roll|draw|creep|edge|slide|slip ?further|farther away|off", Nears(false)),
        ("fall|drop back", Nears(false)),
        ("increase|widen|grow|open|lengthen ?up distance|gap|separation|spacing", Nears(false)),
        ("get|move|drift further|farther|apart", Nears(false)),
        // Speed.
        ("=braking|=brakes|=braked|=brake|=stopping", Own(P::Braking)),
        ("brake|braking harder", Other),
        ("decelerates|=slowing|=slows|=slowed ?down", Own(P::Braking)),
        ("show|exhibit|display|indicate|despite|with|under ?steady|significant|strong|slight|rapid|constant|consistent|positive deceleration", Own(P::Braking)),
        ("show|exhibit|display|indicate|with|under ?steady|significant|strong|slight|rapid|constant|consistent ?positive acceleration", Own(P::Accelerating)),
        ("slow down", Own(P::Braking)),
        ("get|become|grow slower", Own(P::Braking)),
        ("shed|lose|losing|reduce|cut|scrub|decrease ?its|my|our|his speed|velocity|pace", Own(P::Braking)),
        ("=on ?my|our brakes", Own(P::Braking)),
        ("=getting|=get on ?my|our brakes", Own(P::Braking)),
        ("hit|slam|apply|press|touch|step|tap ?on ?my|our|its|his brakes|brake", Own(P::Braking)),
        ("accelerates|=speeding|=speeds|=sped ?up", Own(P::Accelerating)),
        ("speed up", Own(P::Accelerating)),
        ("gain|pick|build|increase|add ?up ?its|my|our|his speed|velocity|pace", Own(P::Accelerating)),
        ("get|become faster", Own(P::Accelerating)),
        ("constant|steady|unchanged|uniform|stable|unvarying speed|velocity|pace", Own(P::Steady)),
        ("keep|maintain|hold|cruise ?at ?its|my|our|his ?current|own speed|pace|velocity", Own(P::Steady)),
        ("keep|maintain|hold ?its|my|our|his|at constant|steady speed|pace|velocity", Own(P::Steady)),
        ("speed|velocity|pace is|stays|remains|keeps constant|steady|unchanged|stable", Own(P::Steady)),
        ("stationary|static|motionless|immobile|parked|=halted|stalled|=idling|=stopped|=stops", Stands),
        ("stand|sit|lie still", Stands),
        ("=standing|=stands", Stands),
        ("at standing still", Stands),
        ("at rest", Stands),
        ("at ?complete|full halt|stop", Stands),
        ("to ?complete|full halt|stop", Other),
        ("stop|cease walking|moving|rolling|driving|riding", Stands),
        ("zero|no ?own speed|velocity|motion|movement", Stands),
        ("come|coming to ?full|complete ?dead halt|stop|rest", Stands),
        ("=moving|=moves|=rolling|=rolls|=driving|=drives|=travelling|=traveling|=travels|=riding|=rides|=walking|=walks|=running|=runs", Moves),
        ("in|on|under motion", Moves),
        ("turn|bend|steer|veer left", Own(P::Turning(true))),
        ("turn|bend|steer|veer =right", Own(P::Turning(false))),
        // Lanes.
        ("change|changing|switch ?its|my ?ego|our|own lane|lanes", Own(P::ChangesLane)),
        ("change|merge|move|pull|drift|swerve|shift|cut|goes|get|come ?over|back|out|across into|to|onto|on ?our|my|ego|same|left|right|its|adjacent|next|own|oncoming|neighbouring|neighboring ?'s ?hand lane", Own(P::ChangesLane)),
        ("=merging|=merges|=merged in|into", Own(P::ChangesLane)),
        ("lane change", Own(P::ChangesLane)),
        ("cut ?in|across|off ?on|of ?ego|us|me", Pair(P::CutsIn)),
        ("merge|move|pull|swerve|drift|change|come into|to|in ?front ?of ego|our|my|us|me lane|vehicle", Pair(P::CutsIn)),
        ("pull|swerve|move|merge in front ?of", Pair(P::CutsIn)),
        ("=crossing|=crosses|=crossed|=cross", Own(P::Crossing)),
        ("in|on|within|along|share|occupies|us|keep|inside|down same|our|my|your|ego ?vehicle ?'s ?own ?driving|travel lane", Pair(P::SameLane)),
        ("same lane as ego|us|me", Pair(P::SameLane)),
        ("same lane", Note(P::SameLane)),
        ("same lanelet", Note(P::SameLanelet)),
        ("different|another|other|adjacent|separate|neighboring|neighbouring lane|lanes", Note(P::OtherLane)),
        ("different|another|other|adjacent|separate|neighboring|neighbouring lanelet|lanelets", Note(P::OtherLanelet)),
        ("in|on|within|along|share|occupies|us|same same|our|my|your|ego ?vehicle ?'s ?own lanelet", Pair(P::SameLanelet)),
        ("in|on|within|along|occupies different|another|other|adjacent|separate|neighboring|neighbouring|next|parallel|own lane", Pair(P::OtherLane)),
        ("in|on|within|along|occupies different|another|other|adjacent|separate|neighboring|neighbouring|next lanelet", Pair(P::OtherLanelet)),
        ("in|on|within|along|occupies ?our|my|its|adjacent|neighbouring|neighboring|next =left ?hand|most lane", Pair(P::NeighbourLane(true))),
        ("in|on|within|along|occupies ?our|my|its|adjacent|neighbouring|neighboring|next =right ?hand|most lane", Pair(P::NeighbourLane(false))),
        ("in|on ?adjacent|neighbouring|next lane to|on ?our|my|ego left", Pair(P::NeighbourLane(true))),
        ("in|on ?adjacent|neighbouring|next lane to|on ?our|my|ego =right", Pair(P::NeighbourLane(false))),
        ("one lane to|on ?our|my left", Pair(P::NeighbourLane(true))),
        ("one lane to|on ?our|my =right", Pair(P::NeighbourLane(false))),
        // Directions.
        ("same direction|way|heading", Pair(P::SameWay)),
        ("opposite|opposing|other ?way|direction|heading", Other),
        ("opposite|opposing direction|way|heading", Pair(P::Oncoming)),
        ("in|on opposite|opposing|oncoming ?direction|lane|traffic", Pair(P::Oncoming)),
        ("oncoming", Pair(P::Oncoming)),
        ("head on", Pair(P::Oncoming)),
        ("faster|quicker than ego|us|me|we|our|my|i|you", Pair(P::FasterThanEgo)),
        ("slower than ego|us|me|we|our|my|i|you", Pair(P::SlowerThanEgo)),
        ("=follows|=following|=follow|=followed|=trails|=trailing|=tails|=tailing|tailgate|=chasing", Follows),
        // Contact.
        ("touch|collide|crash|hit|=hits|struck|strike|=bumps|=bumped|=rammed|=rams", Touches),
        ("run|ran|smash|slam|bump|drove|plow into", Touches),
        ("rear ended", Touches),
        ("overlap", Touches),
        ("collision|contact|crash|impact|accident", Contact),
        // What claims nothing by itself.
        ("pass|overtake|leave|enter|wait|yield|stay|remain|pose|require|need|need|reach|behave|become|appear|seem|show|continue|allow|mean|give|suggest|indicate", Other),
        ("risk of|for ?imminent|potential|direct collision|contact|crash|impact", Other),
        ("collision risk|avoidance|threat|warning|probability|score|check|detection|likelihood|status|danger", Other),
        ("time to|until collision|contact|impact", Other),
        ("brake|braking|stopping|stop distance|light|lights|sign|line|signal", Other),
        ("turn signal|indicator|lane", Other),
        ("lane change|merging maneuver|manoeuvre|trajectory", Other),
        ("left|right turn", Other),
    ])
});

/// How distances and speeds are said to change, with the noun before the verb: "the gap is closing".
static TRENDS: LazyLock<Lexicon<bool>> = LazyLock::new(|| {
    Lexicon::new(&[
        ("increases|grows|widens|rises|climbs|=up", true),
        ("gets|becomes larger|bigger|longer|wider", true),
        ("=opening|=opens", true),
        ("decreases|shrinks|narrows|drops|falls|reduces|diminishes|tightens|shortens|declines|=closes|=closing|=down", false),
        ("gets|becomes smaller|shorter|tighter|less", false),
    ])
});

static NOUNS: LazyLock<Lexicon<Dimension>> = LazyLock::new(|| {
    Lexicon::new(&[
        ("distance|gap|separation|clearance|spacing|dtc", Dimension::Distance),
        ("speed|velocity", Dimension::Speed),
        ("ttc", Dimension::Ttc),
        ("braking|stopping|safe|following|safety distance|gap", Dimension::Risk),
    ])
});

/// Comparatives, and whether they say more; those of all say the most.
static COMPARATIVES: LazyLock<Lexicon<(Dimension, bool, bool)>> = LazyLock::new(|| {
    use Dimension::{Distance, Risk, Speed, Ttc};
    Lexicon::new(&[
        ("closer|nearer", (Distance, false, false)),
        ("farther|further ?away ?from", (Distance, true, false)),
        ("more distant", (Distance, true, false)),
        ("faster|quicker", (Speed, true, false)),
        ("slower", (Speed, false, false)),
        ("smaller|shorter|lower distance|gap", (Distance, false, false)),
        ("larger|greater|longer|bigger distance|gap", (Distance, true, false)),
        ("smaller|shorter|lower ttc", (Ttc, false, false)),
        ("larger|greater|longer|higher ttc", (Ttc, true, false)),
        ("higher|greater|larger speed|velocity", (Speed, true, false)),
        ("lower|smaller speed|velocity", (Speed, false, false)),
        ("more|much dangerous|critical|risky|threatening|relevant", (Risk, true, false)),
        ("less dangerous|critical|risky|threatening", (Risk, false, false)),
        ("higher|greater|riskier|larger ?risk|danger|threat", (Risk, true, false)),
        ("lower|smaller risk|danger|threat", (Risk, false, false)),
        ("closest|nearest", (Distance, false, true)),
        ("closest|nearest approach|point|distance|gap", (Distance, false, false)),
        ("farthest|furthest", (Distance, true, true)),
        ("fastest|quickest", (Speed, true, true)),
        ("slowest", (Speed, false, true)),
        ("most dangerous|critical|risky|threatening", (Risk, true, true)),
        ("highest|greatest|riskiest|biggest ?risk|danger|threat", (Risk, true, true)),
        ("smallest|shortest|lowest|minimum ttc", (Ttc, false, true)),
        ("smallest|shortest|lowest distance|gap|clearance", (Distance, false, true)),
    ])
});

/// Whether a word names a property of a participant: "distance", "speed".
pub fn is_property(token: &Token) -> bool {
    const STEMS: [&str; 40] = [
        "distanc", "gap", "ttc", "spe", "speed", "velocity", "acceleration", "deceleration", "risk", "scor", "motion",
        "position", "location", "direction", "tim", "collision", "separation", "clearanc", "head", "heading", "lan",
        "lanelet", "trajectory", "path", "movement", "relativ", "longitudinal", "lateral", "clos", "minimum", "headway",
        "contact", "reason", "sid", "safety", "valu", "measur", "danger", "threat", "mdc",
    ];
    STEMS.contains(&token.stem.as_str())
}

/// A claim in words: where it stands, of whom, and what.
#[derive(Debug, Clone, PartialEq)]
pub struct Said {
    /// Its tokens.
    pub at: Range<usize>,
    /// Of whom; `None` for the ego.
    pub of: Option<i64>,
    pub quantity: Quantity,
    pub stated: ClaimedValue,
    /// Whether it is said of a time before.
    pub is_past: bool,
}

/// A sentence for its claims in words.
pub struct Speech<'a> {
    pub tokens: &'a [Token],
    pub references: &'a [Reference],
    /// The words of what it stands under, in lower case.
    pub above: &'a str,
    /// Whether it is a field or a cell that asks for a place.
    pub asks_place: bool,
    pub lower: &'a str,
}

impl Speech<'_> {
    /// What a clause says in words.
    pub fn said(&self, clause: &Clause) -> Vec<Said> {
        let mut found = Vec::new();
        // "It is ahead of the ego: false".
        if self.is(clause.at.end, &[":"]) && self.is(clause.at.end + 1, &["false", "no", "not"]) {
            return found;
        }
        if clause.mood != Mood::Supposed {
            self.described(clause, &mut found);
        }
        if clause.mood != Mood::Supposed && !clause.is_label {
            self.places(clause, &mut found);
        }
        self.acts(clause, &mut found);
        if !matches!(clause.mood, Mood::Supposed | Mood::Future) {
            self.trends(clause, &mut found);
            self.lanes(clause, &mut found);
            self.listed(clause, &mut found);
            self.comparisons(clause, &mut found);
        }
        found
    }

    /// How many a clause says there are of which something holds: "nobody is ahead of us", "two cars are braking".
    pub fn count(&self, clause: &Clause, numbers: &[Number]) -> Option<(Range<usize>, ClaimedValue)> {
        let says = |words: &[&str]| clause.at.clone().any(|i| self.is(i, words));
        // "At any step or between two" supposes nothing.
        let is_said = clause.mood == Mood::Said
            || says(&["or"]) && !says(&["if", "would", "could", "should", "might", "may", "can", "must", "likely", "possible"]);
        if !is_said || clause.mood == Mood::Future || clause.is_label {
            return None;
        }
        const NUMBERS: [&str; 6] = ["one", "two", "three", "four", "five", "six"];
        let (number, who) = self.references.iter().find_map(|r| {
            let own = clause.at.contains(&r.at.start) && !r.is_governed && !r.is_compared;
            let first = &self.tokens[r.at.start];
            let number = match r.who {
                Named::Nobody => Some(0),
                Named::Other => NUMBERS.iter().position(|word| first.is(&[word])).map(|i| i + 1),
                _ => None,
            };
            Some((number.filter(|_| own)?, r.at.clone()))
        })?;
        // Of whom else it speaks must be the ego.
        let others = self.references.iter().filter(|r| clause.at.contains(&r.at.start) && r.at != who);
        if !{ others }.all(|r| r.who == Named::Ego) {
            return None;
        }
        let said = |at: Range<usize>, of: Counted| {
            let from = self.tokens[who.start.min(at.start)].span.start;
            let to = self.tokens[at.end.max(who.end) - 1].span.end;
            let number = u8::try_from(number).unwrap_or(u8::MAX);
            Some((from..to, ClaimedValue::Count { number, of }))
        };
        let denies = (clause.at.start..clause.at.end).any(|i| self.is(i, &["not", "never", "except", "only", "other", "else"]));
        if denies {
            return None;
        }
        let within = clause.at.clone().find_map(|i| {
            let number = &numbers[self.tokens[i].number?];
            let is_within = i > 0 && self.is(i - 1, &["within"]) || i > 1 && self.is(i - 1, &["than"]) && self.is(i - 2, &["closer", "nearer"]);
            (is_within && number.unit == Unit::Metre).then_some((i, number.value))
        });
        if let Some((at, metres)) = within {
            return said(at..at + 1, Counted::Within(metres));
        }
        let acts = VERBS.all(self.tokens, clause.at.clone());
        let act = { acts.iter() }.find_map(|(act, at)| {
            let predicate = match act {
                Act::Touches => Predicate::Touches,
                Act::Own(predicate) | Act::Pair(predicate) => *predicate,
                Act::Approaches | Act::Nears(true) => Predicate::Approaching(None),
                Act::Nears(false) => Predicate::Receding(None),
                _ => return None,
            };
            Some((at.clone(), predicate))
        });
        if let Some((at, predicate)) = act {
            // One thing is counted, not two.
            return said(at, Counted::Word(predicate)).filter(|_| acts.len() == 1);
        }
        let places = PLACES.all(self.tokens, clause.at.clone());
        match places.as_slice() {
            [(Placed::At(side), at)] => said(at.clone(), Counted::Word(Predicate::At(*side))),
            _ => None,
        }
    }

    fn is(&self, at: usize, words: &[&str]) -> bool {
        self.tokens.get(at).is_some_and(|token| token.is(words))
    }

    fn reference_at(&self, at: usize) -> Option<&Reference> {
        self.references.iter().find(|r| r.at.contains(&at))
    }

    /// Of whom something holds that is said of a pair: an obstacle and the ego.
    fn pair(&self, clause: &Clause) -> Vec<i64> {
        match &clause.who {
            Who::Obstacles(_) if clause.object.is_some() && !clause.names_ego => Vec::new(),
            Who::Obstacles(ids) => ids.clone(),
            Who::Ego => clause.object.into_iter().collect(),
            Who::Unknown => Vec::new(),
        }
    }

    /// Of whom something holds that is said of its own motion.
    fn own(clause: &Clause) -> Vec<Option<i64>> {
        match &clause.who {
            Who::Obstacles(ids) => ids.iter().copied().map(Some).collect(),
            Who::Ego => vec![None],
            Who::Unknown => Vec::new(),
        }
    }

    /// Whether words before a place in a clause deny it; `None` where that cannot be told.
    fn denial(&self, clause: &Clause, at: usize) -> Option<bool> {
        const DENIALS: [&str; 8] = ["not", "no", "never", "without", "neither", "nor", "none", "nobody"];
        const UNCLEAR: [&str; 18] = [
            "hardly", "barely", "rarely", "scarcely", "seldom", "fails", "fail", "refrains", "refrain", "ceases", "ceased",
            "instead", "than", "nothing", "excluded", "only", "almost", "nearly",
        ];
        let mut denials = 0;
        for place in (self.begins(clause)..at).rev() {
            let token = &self.tokens[place];
            const ENDS: [&str; 11] = ["and", "but", "due", "because", "since", "despite", "given", "as", "for", "applicable", "with"];
            if token.is(&ENDS) {
                break;
            }
            if token.is(&["nearly", "almost"]) {
                continue;
            }
            if token.is(&UNCLEAR) && !(token.is(&["only"]) && place + 1 < at) {
                return None;
            }
            // "Neither … nor" is one.
            let is_second = token.is(&["neither"]) && denials > 0;
            if token.is(&DENIALS) && !self.is(place + 1, &["only", "doubt"]) && !is_second {
                denials += 1;
            }
        }
        (denials < 2).then_some(denials == 1)
    }

    /// Where a clause begins that goes on behind brackets: "neither 7 (2 m) touches the ego".
    fn begins(&self, clause: &Clause) -> usize {
        let mut from = clause.at.start;
        while from > 0 && self.is(from - 1, &[")"]) {
            let open = (0..from).rfind(|i| self.is(*i, &["("]));
            let Some(open) = open else { break };
            let before = (0..open).rfind(|i| self.is(*i, &[",", ";", ":", "(", ")"]));
            let start = before.map_or(0, |i| i + 1);
            if start >= from {
                break;
            }
            from = start;
        }
        from
    }

    fn push(&self, found: &mut Vec<Said>, clause: &Clause, at: Range<usize>, of: Option<i64>, word: (Predicate, bool)) {
        let (predicate, is_denied) = word;
        found.push(Said {
            is_past: self.is_past(clause, &at),
            at,
            of,
            quantity: predicate.quantity(),
            stated: ClaimedValue::Word {
                predicate,
                is_denied,
            },
        });
    }

    /// Whether a verb speaks of a time before: "braked", "has braked".
    fn is_past(&self, clause: &Clause, at: &Range<usize>) -> bool {
        let verb = &self.tokens[at.start];
        let is_participle = (clause.at.start..at.start).any(|i| self.is(i, &["is", "are", "am", "be", "being"]));
        clause.mood == Mood::Past || verb.word.ends_with("ed") && verb.stem != verb.word && !is_participle
    }

    /// The verbs of a clause.
    fn acts(&self, clause: &Clause, found: &mut Vec<Said>) {
        const NO_NOUN: [&str; 29] = [
            "distance", "distances", "light", "lights", "sign", "line", "signal", "rate", "trajectory", "path",
            "speed", "velocity", "time", "behavior", "behaviour", "capability", "force", "maneuver", "manoeuvre", "vehicles",
            "traffic", "obstacles", "cars", "threshold", "phase", "objects", "gap", "lane", "lanes",
        ];
        for (act, at) in VERBS.all(self.tokens, clause.at.clone()) {
            if act == Act::Other || clause.is_label {
                continue;
            }
            // A description is no verb: "the parked car".
            if self.references.iter().any(|r| r.at.contains(&at.start) && r.at.contains(&(at.end - 1))) {
                continue;
            }
            let is_stated = clause.mood != Mood::Supposed;
            if matches!(act, Act::Touches | Act::Contact) {
                if is_stated {
                    self.contact(clause, act, at, found);
                }
                continue;
            }
            if !is_stated || clause.mood == Mood::Future {
                continue;
            }
            let next = self.tokens.get(at.end);
            if next.is_some_and(|t| t.is(&NO_NOUN)) {
                continue;
            }
            // "The rate of closing", "from approaching".
            let before = at.start.checked_sub(1).filter(|i| *i >= clause.at.start);
            let begins = before.and_then(|i| i.checked_sub(1)).is_some_and(|i| {
                let stems = ["begin", "began", "start", "continu", "keep", "kept", "begun"];
                self.is(i + 1, &["to"]) && stems.contains(&self.tokens[i].stem.as_str())
            });
            if before.is_some_and(|i| self.is(i, &["of", "from", "for", "by", "avoid", "to"]))
                && !self.is(at.start, &["in", "on", "at", "same"])
                && !begins
            {
                continue;
            }
            // "The brake", "its brake".
            if self.is(at.start, &["brake"]) && before.is_some_and(|i| self.is(i, &["the", "a", "its", "emergency", "my", "full"])) {
                continue;
            }
            let Some(is_denied) = self.denial(clause, at.start) else {
                continue;
            };
            let pair = self.pair(clause);
            match act {
                Act::Nears(_) | Act::Approaches => {
                    if act == Act::Approaches && !self.is_of_ego(at.end, clause) {
                        continue;
                    }
                    let nears = !matches!(act, Act::Nears(false));
                    // "I am pulling away again".
                    if clause.who == Who::Ego && clause.object.is_none() && self.tokens[at.start].stem == "pull" {
                        self.push(found, clause, at, None, (Predicate::Accelerating, is_denied));
                        continue;
                    }
                    for axis in self.axes(clause, &at) {
                        let predicate = if nears {
                            Predicate::Approaching(axis)
                        } else {
                            Predicate::Receding(axis)
                        };
                        for id in &pair {
                            self.push(found, clause, at.clone(), Some(*id), (predicate, is_denied));
                        }
                    }
                }
                Act::Own(predicate) => {
                    for of in Self::own(clause) {
                        self.push(found, clause, at.clone(), of, (predicate, is_denied));
                    }
                }
                Act::Note(_) if at.start != clause.at.start => {}
                Act::Pair(predicate) | Act::Note(predicate) => {
                    // "They are in the same lane": it and the ego.
                    let are_both = clause.who == Who::Unknown
                        && self.is(clause.at.start, &["they", "both"])
                        && predicate.quantity() == Quantity::Way;
                    let pair = if are_both { clause.topic.into_iter().collect() } else { pair };
                    for id in pair {
                        self.push(found, clause, at.clone(), Some(id), (predicate, is_denied));
                    }
                }
                Act::Stands | Act::Moves => self.stands(clause, act, at, is_denied, found),
                Act::Follows => {
                    let front = match &clause.who {
                        Who::Ego => clause.object.map(|id| (id, true)),
                        Who::Obstacles(ids)
                            if clause.object.is_none()
                                && (clause.names_ego || self.is(at.end, &["at", "closely", "behind", "close"])) =>
                        {
                            ids.first().map(|id| (*id, false))
                        }
                        _ => None,
                    };
                    if let Some((id, front)) = front.filter(|_| !is_denied) {
                        let side = Side {
                            front: Some(front),
                            left: None,
                        };
                        found.push(Said {
                            is_past: self.is_past(clause, &at),
                            at,
                            of: Some(id),
                            quantity: Quantity::Side,
                            stated: ClaimedValue::Side(side),
                        });
                    }
                }
                Act::Touches | Act::Contact | Act::Other => {}
            }
        }
    }

    /// Whether what follows "approaching" is the ego, or says how.
    fn is_of_ego(&self, at: usize, clause: &Clause) -> bool {
        const HOW: [&str; 36] = [
            "from", "at", "rapidly", "quickly", "slowly", "steadily", "gradually", "slightly", "fast", "directly", "head",
            "longitudinally", "laterally", "and", "but", "while", "with", "in", "on", "as", "us", "again", "very", "both",
            "along", "closely", "now", "further", "each", "by", "over", "during", "throughout", "since", "within", "for",
        ];
        if at >= clause.at.end {
            return true;
        }
        self.is(at, &HOW)
            || self.tokens[at].word.ends_with("ly")
            || !self.tokens[at].is_word()
            || (at..at + 3).any(|i| self.reference_at(i).is_some_and(|r| matches!(r.who, Named::Ego | Named::Obstacle(_))))
            || self.is(at, &["the"]) && (at..at + 4).any(|i| self.is(i, &["distance", "gap"]))
    }

    /// The axes along which a clause speaks: those that it names, or that its label or what it stands under does.
    fn axes(&self, clause: &Clause, at: &Range<usize>) -> Vec<Option<bool>> {
        let named = |range: Range<usize>| {
            let words = self.tokens.get(range).unwrap_or_default();
            let long = words.iter().any(|t| t.stem.starts_with("longitudinal"));
            let lat = words.iter().any(|t| t.word.starts_with("lateral"));
            match (long, lat) {
                (true, true) => vec![Some(true), Some(false)],
                (true, false) => vec![Some(true)],
                (false, true) => vec![Some(false)],
                _ => Vec::new(),
            }
        };
        let own = named(clause.at.clone());
        let words = &self.tokens[clause.at.clone()];
        let says = |word: &str| words.iter().any(|t| t.is(&[word]));
        match own.as_slice() {
            [one] => return vec![*one],
            [_, _] if says("both") || says("and") => return own,
            [_, _] => return Vec::new(),
            _ => {}
        }
        let is_both = words.windows(2).any(|t| {
            t[0].is(&["both"]) && t[1].is(&["axes", "dimensions", "directions"]) || t[0].is(&["in"]) && t[1].is(&["both"])
        });
        if is_both {
            return vec![Some(true), Some(false)];
        }
        let labelled = named(clause.label.clone());
        if let [one] = labelled.as_slice() {
            return vec![*one];
        }
        // "Lateral 2 m (approaching)": the part before the bracket.
        if clause.at.start > 0 && self.is(clause.at.start - 1, &["("]) && at.start == clause.at.start {
            let part = &self.tokens[..clause.at.start - 1];
            let from = part.iter().rposition(|t| t.is(&[",", ";"])).map_or(0, |i| i + 1);
            if let [one] = named(from..clause.at.start - 1).as_slice() {
                return vec![*one];
            }
        }
        vec![super::number::axis(self.above)]
    }

    /// That a body stands, or does not move along an axis.
    fn stands(&self, clause: &Clause, act: Act, at: Range<usize>, is_denied: bool, found: &mut Vec<Said>) {
        let is_motion = act == Act::Moves;
        let next = self.tokens.get(at.end).filter(|_| at.end < clause.at.end);
        let is_bare = next.is_none_or(|t| t.is(&["at", "now", "anymore", "yet", "any", "and"]) || t.word.ends_with("ly"));
        let words = &self.tokens[clause.at.clone()];
        let has_axis = words.iter().any(|t| t.word.starts_with("lateral") || t.stem.starts_with("longitudinal"));
        let is_relative = words.iter().any(|t| t.is(&["relative"]));
        // "No longitudinal velocity" is read by [`super::phrases`].
        if has_axis || is_relative || is_motion && !is_bare {
            return;
        }
        if self.is(at.end, &[":"]) || words.iter().any(|t| t.is(&["becomes", "became"])) {
            return;
        }
        let says_zero = self.is(at.start, &["no", "zero"]);
        let stands = is_motion == is_denied || says_zero;
        // "Longitudinal velocity: 0.0 m/s (stationary)" is the velocity along that axis.
        let before = &self.lower[..self.tokens[at.start].span.start];
        let axis = axis_before(before).filter(|_| stands);
        if is_motion && !is_denied && !(next.is_none() || self.is(at.end, &["now"])) {
            return;
        }
        let is_rough = (at.start.saturating_sub(2).max(clause.at.start)..at.start).any(|i| {
            self.is(i, &["almost", "nearly", "basically", "practically", "virtually", "close"])
        });
        for of in Self::own(clause) {
            let is_past = clause.mood == Mood::Past;
            let (quantity, stated) = if stands && is_rough {
                let slow = ClaimedValue::Bounds {
                    from: None,
                    to: Some(1.0),
                    decimals: 0,
                };
                (Quantity::Speed, slow)
            } else if stands {
                (axis.unwrap_or(Quantity::Speed), NOTHING)
            } else {
                let word = ClaimedValue::Word {
                    predicate: Predicate::Moving,
                    is_denied: false,
                };
                (Quantity::Motion, word)
            };
            found.push(Said {
                at: at.clone(),
                of,
                quantity,
                stated,
                is_past,
            });
        }
    }

    /// Contact, denied, past or to come.
    fn contact(&self, clause: &Clause, act: Act, at: Range<usize>, found: &mut Vec<Said>) {
        const NOT_A_CONTACT: [&str; 17] = [
            "potential", "possible", "imminent", "near", "avoid", "prevent", "risk", "chance", "likelihood", "possibility",
            "any", "eye", "close", "threat", "danger", "avoiding", "future",
        ];
        const OCCURS: [&str; 12] = [
            "occurs", "occurred", "happens", "happened", "detected", "occurring", "took", "exists", "happening", "present",
            "confirmed", "observed",
        ];
        let words = &self.tokens[clause.at.clone()];
        let says = |all: &[&str]| words.iter().any(|t| t.is(all));
        let before = |all: &[&str]| (at.start.saturating_sub(3).max(clause.at.start)..at.start).any(|i| self.is(i, all));
        let after = |all: &[&str]| (at.end..(at.end + 5).min(clause.at.end)).any(|i| self.is(i, all));
        let Some(mut is_denied) = self.denial(clause, at.start) else {
            return;
        };
        // "It did not brake before the impact".
        if act == Act::Contact {
            is_denied &= before(&["no", "not", "without", "any", "never", "nor", "zero"]);
        }
        if act == Act::Touches && self.is(at.start, &["overlap", "overlaps"]) && after(&["along", "in", "across", "laterally", "longitudinally"]) {
            return;
        }
        let is_coming = clause.mood == Mood::Future
            || says(&["imminent", "unavoidable", "inevitable", "upcoming", "impending"])
            || self.is(at.end, &["course"]);
        if before(&["risk", "chance", "likelihood", "possibility", "danger", "threat", "avoid", "prevent", "potential", "possible", "near", "close", "eye", "avoiding", "future"]) {
            return;
        }
        let _ = NOT_A_CONTACT;
        let will = is_coming || says(&["expected", "predicted", "ahead", "soon", "happen"]) && act == Act::Contact;
        if act == Act::Contact
            && self.is(at.end, &["scenario", "condition", "situation", "event", "path", "point", "state"])
        {
            return;
        }
        if act == Act::Contact && !is_denied && !will {
            let is_stated = OCCURS.iter().any(|word| after(&[*word]))
                || before(&["in", "is", "has", "indicating", "indicates", "confirming", "confirms"])
                || clause.at.len() == at.len()
                    && self.tokens[clause.label.clone()].iter().any(|t| t.is(&["location", "position", "direction", "state", "status"]))
                || after(&["at"]) && before(&["there", "a", "the"]);
            if !is_stated {
                return;
            }
            // "No collision is detected" comes with its denial before, "a collision is not detected" with it behind.
            if (at.end..clause.at.end).any(|i| self.is(i, &["not", "never"])) {
                is_denied = true;
            }
        }
        // "Hit the brakes".
        if act == Act::Touches && !self.meets_ego(clause, at.end) {
            return;
        }
        let predicate = if will { Predicate::WillTouch } else { Predicate::Touches };
        for id in self.pair(clause) {
            if !is_denied && !will {
                found.push(Said {
                    at: at.clone(),
                    of: Some(id),
                    quantity: Quantity::Contact,
                    stated: ClaimedValue::Contact,
                    is_past: self.is_past(clause, &at),
                });
            } else {
                self.push(found, clause, at.clone(), Some(id), (predicate, is_denied));
            }
        }
    }

    /// Whether a verb of contact is about the ego and the obstacle, and not "hits the brakes".
    fn meets_ego(&self, clause: &Clause, at: usize) -> bool {
        let next = (at..clause.at.end.min(at + 6)).find(|i| !self.is(*i, &["with", "the", "into", "by", "each", "side", "rear", "back", "front", "of", "a"]));
        match next {
            None => true,
            Some(i) => {
                let met = self.reference_at(i).map(|r| r.who);
                let is_met = match met {
                    Some(Named::Ego) => clause.who != Who::Ego,
                    Some(_) => clause.who == Who::Ego,
                    None => false,
                };
                is_met
                    || self.is(i, &["at", "other", "and", "in", "during", "on"])
                    || !self.tokens[i].is_word()
                    || self.tokens[i].word.ends_with("ly")
            }
        }
    }

    /// Those that a field lists: "standing: 7, 8".
    fn listed(&self, clause: &Clause, found: &mut Vec<Said>) {
        let (label, at) = (clause.label.clone(), clause.at.clone());
        let is_list = !at.is_empty() && at.clone().all(|i| self.reference_at(i).is_some() || self.is(i, &["and", ","]));
        let Some((act, end)) = VERBS.at(&self.tokens[..label.end], label.start).filter(|_| is_list) else {
            return;
        };
        if end != label.end {
            return;
        }
        for of in Self::own(clause) {
            match act {
                Act::Stands => found.push(Said {
                    at: at.clone(),
                    of,
                    quantity: Quantity::Speed,
                    stated: NOTHING,
                    is_past: false,
                }),
                Act::Own(predicate) => self.push(found, clause, at.clone(), of, (predicate, false)),
                Act::Approaches => {
                    self.push(found, clause, at.clone(), of, (Predicate::Approaching(None), false));
                }
                _ => {}
            }
        }
    }

    /// The value of a field that asks for a lane: "lane: same".
    fn lanes(&self, clause: &Clause, found: &mut Vec<Said>) {
        let label = &self.tokens[clause.label.clone()];
        if !label.iter().any(|t| t.is(&["lane"])) || clause.at.len() > 3 {
            return;
        }
        let word = &self.tokens[clause.at.start];
        let predicate = match word.word.as_str() {
            "same" | "ego" | "own" => Predicate::SameLane,
            "other" | "adjacent" | "different" | "neighbouring" | "neighboring" | "next" => Predicate::OtherLane,
            "left" => Predicate::NeighbourLane(true),
            "right" => Predicate::NeighbourLane(false),
            "opposite" | "oncoming" => Predicate::Oncoming,
            _ => return,
        };
        if found.iter().any(|said| said.at.contains(&clause.at.start)) {
            return;
        }
        for id in self.pair(clause) {
            self.push(found, clause, clause.at.clone(), Some(id), (predicate, false));
        }
    }

    /// Where the obstacle is said to be.
    fn places(&self, clause: &Clause, found: &mut Vec<Said>) {
        let mut at = clause.at.start;
        let mut own: Vec<(Side, Range<usize>, bool)> = Vec::new();
        let mut origins: Vec<Range<usize>> = Vec::new();
        while at < clause.at.end {
            let Some((place, end)) = PLACES.at(&self.tokens[..clause.at.end], at) else {
                at += 1;
                continue;
            };
            let here = at..end;
            at = end;
            let inside = |(_, s): &(_, Range<usize>)| s.start < here.end && here.start < s.end;
            if self.references.iter().any(|r| r.says.iter().any(inside)) {
                continue;
            }
            let before = here.start.checked_sub(1);
            let is_before = |words: &[&str]| before.is_some_and(|i| self.is(i, words));
            let is_origin = is_before(&["from"])
                || is_before(&["the", "directly", "our", "my"])
                    && before.and_then(|i| i.checked_sub(1)).is_some_and(|i| self.is(i, &["from"]));
            const ELSEWHERE: [&str; 19] = [
                "look", "looking", "turn", "turns", "turning", "road", "way", "steer", "lane", "path", "drifting", "moves",
                "toward", "towards", "view", "change", "keep", "pull", "moving",
            ];
            let is_elsewhere = is_before(&ELSEWHERE) && !(place == Placed::Beside && is_before(&["moving"]));
            // "Moving away to the left".
            let is_course = self.is(here.start, &["to"])
                && VERBS.all(self.tokens, clause.at.start..here.start).iter().any(|(act, _)| {
                    matches!(act, Act::Nears(_) | Act::Approaches | Act::Moves | Act::Own(Predicate::ChangesLane))
                });
            let is_explained = self.tokens[clause.at.clone()].iter().any(|t| t.is(&["negative", "positive"]));
            if is_elsewhere
                || is_course
                || is_explained
                || self.is(end, &["lane", "lanelet", "turn", "turning", "hand", "side", "axis"])
                || self.is(end, &["of"]) && !self.is_ego(end + 1)
            {
                continue;
            }
            let side = match place {
                Placed::At(side) => side,
                Placed::Field(side) if is_origin || self.is_field(clause, &here) => side,
                Placed::Beside => {
                    for id in self.pair(clause) {
                        if let Some(is_denied) = self.denial(clause, here.start) {
                            self.push(found, clause, here.clone(), Some(id), (Predicate::Beside, is_denied));
                        }
                    }
                    continue;
                }
                Placed::Field(_) => continue,
            };
            if is_origin {
                origins.push(here.clone());
            }
            // "Behind 7": of another one.
            let met = self.references.iter().find(|r| r.at.start >= end && r.at.start <= end + 2 && clause.at.contains(&r.at.start)
                && self.tokens[end..r.at.start].iter().all(|t| t.is(&["the", "of", "a"])));
            let is_mirrored = clause.who == Who::Ego;
            match met.map(|r| r.who) {
                Some(Named::Ego) | None if !is_mirrored => own.push((side, here, false)),
                Some(Named::Obstacle(_) | Named::It) if is_mirrored && side.left.is_none() => own.push((side, here, true)),
                _ => {}
            }
        }
        // "From left to right".
        if !origins.is_empty() {
            own.retain(|(_, here, _)| origins.contains(here));
        }
        // Two places say nothing certain.
        if own.iter().any(|(side, _, _)| own.iter().any(|(other, _, _)| side.front.zip(other.front).is_some_and(|(a, b)| a != b) || side.left.zip(other.left).is_some_and(|(a, b)| a != b))) {
            return;
        }
        for (mut side, here, is_mirrored) in own {
            if is_mirrored {
                side.front = side.front.map(|front| !front);
            }
            let Some(is_denied) = self.denial(clause, here.start) else { continue };
            if clause.mood == Mood::Future {
                continue;
            }
            for id in self.pair(clause) {
                let stated = if origins.contains(&here) {
                    ClaimedValue::Word { predicate: Predicate::CameFrom(side), is_denied }
                } else if is_denied {
                    ClaimedValue::Word { predicate: Predicate::At(side), is_denied }
                } else {
                    ClaimedValue::Side(side)
                };
                found.push(Said {
                    at: here.clone(),
                    of: Some(id),
                    quantity: Quantity::Side,
                    stated,
                    is_past: clause.mood == Mood::Past && !origins.contains(&here),
                });
            }
        }
    }

    /// Whether an obstacle is named beside a description of it.
    fn names(&self, id: i64, description: &Reference) -> bool {
        let others = self.references.iter().filter(|r| r.at != description.at);
        { others }.any(|r| matches!(r.who, Named::Obstacle(other) if other == id) || r.who == Named::It)
    }

    fn is_ego(&self, at: usize) -> bool {
        (at..at + 2).any(|i| self.reference_at(i).is_some_and(|r| r.who == Named::Ego))
    }

    /// Whether a bare word is a place: the value of a field that asks for one, or in brackets behind a name or a length.
    fn is_field(&self, clause: &Clause, here: &Range<usize>) -> bool {
        const ASKS: [&str; 8] = ["direction", "position", "location", "place", "side", "where", "relation", "placement"];
        let words = &self.tokens[clause.label.clone()];
        let is_asked = self.asks_place || words.iter().any(|t| t.is(&ASKS));
        let starts = here.start == clause.at.start;
        let ends = here.end == clause.at.end || self.is(here.end, &["of"]) || self.tokens.get(here.end).is_some_and(|t| t.number.is_some());
        let bracket = starts && clause.at.start > 1 && self.is(clause.at.start - 1, &["("]) && {
            let before = &self.tokens[clause.at.start - 2];
            before.number.is_some() || self.reference_at(clause.at.start - 2).is_some()
        };
        // "1.6 m left".
        let length = starts && false || here.start > clause.at.start && self.tokens[here.start - 1].number.is_some() && self.tokens[here.start - 1].word.ends_with(['m', 's']) && ends;
        let inline = length || is_asked && here.start > clause.at.start && (clause.at.start..here.start).any(|i| self.is(i, &ASKS));
        // "Motorcycle directly left".
        let is_note = ends
            && (clause.at.start..here.start).all(|i| {
                self.reference_at(i).is_some() || self.tokens[i].is_filler() || self.tokens[i].number.is_some()
            })
            && here.start > clause.at.start;
        let names = |i: usize| self.reference_at(i).is_some_and(|r| matches!(r.who, Named::Obstacle(_)));
        let is_named = clause.label.clone().any(names);
        starts && ends && (is_asked || bracket || is_named) || inline || is_note
    }

    /// What descriptions say: "the car ahead".
    fn described(&self, clause: &Clause, found: &mut Vec<Said>) {
        let own = self.references.iter().filter(|r| clause.at.contains(&r.at.start));
        for reference in own {
            let id = match (reference.who, &clause.who) {
                (Named::Obstacle(id), _) => id,
                (Named::It, Who::Obstacles(ids)) if ids.len() == 1 => ids[0],
                _ => continue,
            };
            for (said, at) in &reference.says {
                let (quantity, stated) = match said {
                    Described::At(side) => (Quantity::Side, ClaimedValue::Side(*side)),
                    Described::Stands => (Quantity::Speed, NOTHING),
                    Described::Is(predicate) => {
                        self.push(found, clause, at.clone(), Some(id), (*predicate, false));
                        continue;
                    }
                };
                found.push(Said {
                    at: at.clone(),
                    of: Some(id),
                    quantity,
                    stated,
                    is_past: clause.mood == Mood::Past,
                });
            }
        }
    }

    /// How a distance or a speed is said to change.
    fn trends(&self, clause: &Clause, found: &mut Vec<Said>) {
        let nouns = NOUNS.all(self.tokens, clause.at.clone());
        let trends = TRENDS.all(self.tokens, clause.at.clone());
        let [(grows, verb)] = trends.as_slice() else {
            return;
        };
        // "Gap 4.4 m, opening".
        let earlier = match verb.start == clause.at.start {
            true => NOUNS.all(self.tokens, clause.at.start.saturating_sub(5)..clause.at.start),
            false => Vec::new(),
        };
        let before = nouns.iter().rfind(|(_, noun)| noun.end <= verb.start);
        let Some((dimension, noun)) = before.or_else(|| nouns.first()).or_else(|| earlier.last()) else {
            return;
        };
        let is_near = verb.start >= noun.end && verb.start - noun.end <= 8
            || noun.start >= verb.end && noun.start - verb.end <= 2;
        // "Increasing the distance" is a verb of its own.
        let is_taken = found.iter().any(|s| s.at.start < verb.end && verb.start < s.at.end);
        if !is_near || is_taken {
            return;
        }
        let Some(is_denied) = self.denial(clause, verb.start) else { return };
        let at = noun.start.min(verb.start)..noun.end.max(verb.end);
        match dimension {
            Dimension::Distance => {
                for axis in self.axes(clause, &at) {
                    let predicate = if *grows { Predicate::Receding(axis) } else { Predicate::Approaching(axis) };
                    for id in self.pair(clause) {
                        self.push(found, clause, at.clone(), Some(id), (predicate, is_denied));
                    }
                }
            }
            Dimension::Speed => {
                let is_relative = self.tokens[clause.at.clone()].iter().any(|t| t.is(&["relative", "closing", "longitudinal", "lateral", "approach"]));
                if !is_relative {
                    let predicate = if *grows { Predicate::Accelerating } else { Predicate::Braking };
                    for of in Self::own(clause) {
                        self.push(found, clause, at.clone(), of, (predicate, is_denied));
                    }
                }
            }
            Dimension::Ttc | Dimension::Risk => {}
        }
    }

    /// Comparisons with another obstacle, and with all.
    fn comparisons(&self, clause: &Clause, found: &mut Vec<Said>) {
        for ((of, is_more, is_most), at) in COMPARATIVES.all(self.tokens, clause.at.clone()) {
            // "The ego is faster": the other is slower.
            if clause.who == Who::Ego && of == Dimension::Speed && !is_most {
                let than = self.references.iter().find(|r| r.at.start > at.start && clause.at.contains(&r.at.start));
                let other = than.and_then(|r| match r.who {
                    Named::Obstacle(id) => Some(id),
                    _ => clause.topic,
                });
                let other = other.or(clause.topic);
                if let (Some(id), Some(is_denied)) = (other, self.denial(clause, at.start)) {
                    let predicate = if is_more { Predicate::SlowerThanEgo } else { Predicate::FasterThanEgo };
                    self.push(found, clause, at, Some(id), (predicate, is_denied));
                }
                continue;
            }
            let Who::Obstacles(ids) = &clause.who else { continue };
            let [id] = ids.as_slice() else { continue };
            let Some(is_denied) = self.denial(clause, at.start) else { continue };
            // "Car 7: nearest at step 47" tells when.
            if is_most && self.is(at.end, &["at", "in", "within"]) {
                continue;
            }
            let than = if is_most {
                // "The nearest car brakes" names it, and "7 is the nearest" says so.
                let naming = self.reference_at(at.start);
                if naming.is_some_and(|r| !r.says.is_empty() || r.who == Named::Obstacle(*id) && !self.names(*id, r)) {
                    continue;
                }
                None
            } else {
                let limit = (at.end + 8).min(self.tokens.len());
                let Some(than) = (at.end..limit).find(|i| self.is(*i, &["than"])) else {
                    // "It is way faster".
                    if of == Dimension::Speed && at.end == clause.at.end {
                        let predicate = if is_more { Predicate::FasterThanEgo } else { Predicate::SlowerThanEgo };
                        self.push(found, clause, at, Some(*id), (predicate, is_denied));
                    }
                    continue;
                };
                let next = self.references.iter().find(|r| r.at.start > than && r.at.start <= than + 3);
                match next.map(|r| r.who) {
                    Some(Named::Obstacle(other)) if other != *id => Some(other),
                    _ => continue,
                }
            };
            let predicate = Predicate::Compared(Compared { of, is_more, than });
            self.push(found, clause, at, Some(*id), (predicate, is_denied));
        }
        // "Its TTC of 1 s is the smallest".
        let all = NOUNS.all(self.tokens, clause.at.clone());
        let bare = clause.at.clone().find(|i| self.is(*i, &["smallest", "shortest", "lowest", "minimum", "least"]));
        if let ([(of @ (Dimension::Ttc | Dimension::Distance), noun), ..], Some(at)) = (all.as_slice(), bare)
            && at > noun.start
            && (noun.start..at).any(|i| self.is(i, &["is"]))
            && let Who::Obstacles(ids) = &clause.who
            && let [id] = ids.as_slice()
            && let Some(is_denied) = self.denial(clause, at)
        {
            let predicate = Predicate::Compared(Compared { of: *of, is_more: false, than: None });
            self.push(found, clause, at..at + 1, Some(*id), (predicate, is_denied));
        }
        // "Most dangerous: 304".
        if let (Some(((of, is_more, true), _)), Who::Obstacles(ids)) =
            (COMPARATIVES.all(self.tokens, clause.label.clone()).first().copied_first(), &clause.who)
            && let [id] = ids.as_slice()
            && self.tokens[clause.at.clone()].len() <= 4
        {
            let predicate = Predicate::Compared(Compared { of, is_more, than: None });
            self.push(found, clause, clause.at.clone(), Some(*id), (predicate, false));
        }
    }
}

/// The first of what was found.
trait First<T> {
    fn copied_first(self) -> Option<T>;
}

impl<T: Copy> First<(T, Range<usize>)> for Option<&(T, Range<usize>)> {
    fn copied_first(self) -> Option<(T, Range<usize>)> {
        self.map(|(said, at)| (*said, at.clone()))
    }
}
