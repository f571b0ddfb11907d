//! What a clause says in words: how its participant moves, in which lane it is, where it is, and whether it touches the ego.

use std::sync::LazyLock;

use super::Predicate;
use super::tokens::{Lexicon, Token};

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
    /// Its speed and the distance change: it accelerates towards (true) the other, or away.
    Drives(Predicate, bool),
    /// What it does not do, said without a word that denies: "keeps its lane".
    Never(Predicate),
    /// It passes the other.
    Passes,
    /// It touches the other.
    Touches,
    /// "Collision", "contact".
    Contact,
    /// A verb that claims nothing.
    Other,
}

/// Verbs and phrases, the longest first.
pub static VERBS: LazyLock<Lexicon<Act>> = LazyLock::new(|| {
    use Act::{
        Approaches, Contact, Drives, Follows, Moves, Nears, Never, Note, Other, Own, Pair, Passes,
        Stands, Touches,
    };
    use Predicate as P;
    Lexicon::new(&[
        // Distance.
        (
            "approaches|=approaching|=approached|converges|=nearing|=nears",
            Approaches,
        ),
        ("=closing|=closes ?in ?on", Approaches),
        ("close in ?on", Nears(true)),
        ("gains on", Nears(true)),
        ("catches|=catching|=caught up", Nears(true)),
        (
            "get|come|move|draw|goes|edge|drift|creep|inch closer|nearer",
            Nears(true),
        ),
        ("=coming|=comes|creep up", Nears(true)),
        ("=coming|=comes from behind", Nears(true)),
        (
            "move|drive|head|travel|come|goes|ride|walk|run|drift|race|steer|swerve|veer|roll ?left|right ?straight ?right toward|towards|at ego|us|me|you",
            Nears(true),
        ),
        (
            "move|drive|head|come|goes|drift|steer|swerve|veer ?left|right toward|towards our|my ?ego lane|path",
            Nears(true),
        ),
        (
            "accelerate toward|towards ego|us|me",
            Drives(P::Accelerating, true),
        ),
        ("speed toward|towards|at ego|us|me", Nears(true)),
        ("accelerate|speed away|off", Drives(P::Accelerating, false)),
        (
            "=closing|=closes|=closed|reduce|shorten|decrease|narrow|shrink|eat|lessen distance|gap|separation|space|spacing",
            Nears(true),
        ),
        ("close gap", Nears(true)),
        ("move|drive|head|travel|come toward|towards", Approaches),
        (
            "=closing|=approaching ?longitudinal|lateral trend|motion|movement|pattern|action|tendency|trajectory|trajectories",
            Nears(true),
        ),
        (
            "=no|=zero ?active|significant|further|relative ?longitudinal|lateral =closing ?longitudinal|lateral|relative velocity|speed|rate",
            Nears(true),
        ),
        (
            "=no|=without ?immediate|significant longitudinal|lateral convergence",
            Nears(true),
        ),
        (
            "=no|=without ?immediate|significant convergence longitudinally|laterally",
            Nears(true),
        ),
        (
            "velocity|motion|movement|directed|moving|travelling|traveling toward|towards ego|us|me",
            Nears(true),
        ),
        (
            "high|positive|continued|continuing|rapid|significant|fast|strong ?longitudinal|lateral =closing speed|velocity|rate",
            Nears(true),
        ),
        ("rate of closure", Nears(true)),
        ("recede|diverge|=retreating", Nears(false)),
        (
            "move|drive|pull|drift|head|goes|travel|walk|get|run|ride|roll|draw|creep|edge|slide|slip ?further|farther away|off",
            Nears(false),
        ),
        ("fall|drop back|behind", Pair(P::Signed(true, false))),
        (
            "increase|widen|grow|open|lengthen ?up distance|gap|separation|spacing",
            Nears(false),
        ),
        ("get|move|drift further|farther|apart", Nears(false)),
        ("=away longitudinally|laterally", Nears(false)),
        // Speed.
        ("=braking|=brakes|=braked|=brake|=stopping", Own(P::Braking)),
        ("brake|braking harder", Other),
        ("decelerates|=slowing|=slows|=slowed ?down", Own(P::Braking)),
        (
            "show|exhibit|display|indicate|despite|with|under ?steady|significant|strong|slight|rapid|constant|consistent|positive deceleration",
            Own(P::Braking),
        ),
        (
            "show|exhibit|display|indicate|with|under ?steady|significant|strong|slight|rapid|constant|consistent ?positive acceleration",
            Own(P::Accelerating),
        ),
        ("slow down", Own(P::Braking)),
        (
            "sign|signs|hint of braking|slowing|stopping|deceleration ?down",
            Own(P::Braking),
        ),
        ("=easing|=ease|=eases|=eased off|up", Own(P::Braking)),
        ("get|become|grow slower", Own(P::Braking)),
        (
            "shed|lose|losing|reduce|cut|scrub|decrease ?its|my|our|his speed|velocity|pace",
            Own(P::Braking),
        ),
        ("=on ?my|our|its brakes", Own(P::Braking)),
        ("=getting|=get on ?my|our brakes", Own(P::Braking)),
        (
            "hit|slam|apply|press|touch|step|tap|slamming ?on ?my|our|its|his brakes|brake",
            Own(P::Braking),
        ),
        ("accelerates", Own(P::Accelerating)),
        ("=speeding|=speeds|=sped|speed up", Own(P::Accelerating)),
        (
            "gain|pick|build|increase|add ?up ?its|my|our|his speed|velocity|pace",
            Own(P::Accelerating),
        ),
        ("get|become faster", Own(P::Accelerating)),
        (
            "constant|steady|unchanged|uniform|stable|unvarying speed|velocity|pace",
            Own(P::Steady),
        ),
        (
            "keep|kept|maintain|hold|held|cruise ?at ?its|my|our|his ?current|own speed|pace|velocity",
            Own(P::Steady),
        ),
        (
            "keep|kept|maintain|hold|held ?its|my|our|his|at constant|steady speed|pace|velocity",
            Own(P::Steady),
        ),
        (
            "speed|velocity|pace is|stays|remains|keeps constant|steady|unchanged|stable",
            Own(P::Steady),
        ),
        (
            "stationary|static|motionless|immobile|parked|=halted|stalled|=idling|=stopped|=stops",
            Stands,
        ),
        ("=stop", Own(P::Stops)),
        ("stand|sit|lie|stood|sat still", Stands),
        ("=standing|=stands", Stands),
        ("at standing still", Stands),
        ("at rest", Stands),
        ("at ?complete|full halt|stop", Stands),
        ("to ?complete|full halt|stop", Other),
        ("stop|cease walking|moving|rolling|driving|riding", Stands),
        ("zero|no ?own speed|velocity|motion|movement", Stands),
        ("come|coming to ?full|complete ?dead halt|stop|rest", Stands),
        (
            "=moving|=moves|=rolling|=rolls|=driving|=drives|=travelling|=traveling|=travels|=riding|=rides|=walking|=walks|=running|=runs",
            Moves,
        ),
        ("in|on|under motion", Moves),
        (
            "stay|remain|keep|kept|hold|held|continue ?in|to ?its|my|our|own|same ?own lane",
            Never(P::ChangesLane),
        ),
        ("turn|bend|steer|veer left", Own(P::Turning(true))),
        ("turn|bend|steer|veer =right", Own(P::Turning(false))),
        // Lanes.
        (
            "change|changing|switch ?its|my ?ego|our|own lane|lanes",
            Own(P::ChangesLane),
        ),
        (
            "change|merge|move|pull|drift|swerve|shift|cut|goes|get|come ?over|back|out|across ?left|right into|to|onto|on ?our|my|ego|same|left|right|its|adjacent|next|own|oncoming|opposite|neighbouring|neighboring ?'s ?hand lane",
            Own(P::ChangesLane),
        ),
        ("=merging|=merges|=merged in|into", Own(P::ChangesLane)),
        ("=coming|=comes|=came over ?into|to", Own(P::ChangesLane)),
        ("lane change", Own(P::ChangesLane)),
        ("cut ?in|across|off ?on|of ?ego|us|me", Pair(P::CutsIn)),
        (
            "merge|move|pull|swerve|drift|change|come into|to|in ?front ?of ego|our|my|us|me lane|vehicle",
            Pair(P::CutsIn),
        ),
        ("pull|swerve|move|merge in front ?of", Pair(P::CutsIn)),
        ("=crossing|=crosses|=crossed|=cross", Own(P::Crossing)),
        ("zebra|pedestrian crossing", Other),
        ("across our|my|ego path|way|course", Own(P::Crossing)),
        (
            "step|walk|run on|onto|into ?to road|street|crossing|crosswalk|carriageway",
            Own(P::Crossing),
        ),
        ("at|on|before|to|over crossing", Other),
        (
            "in|on|within|along|share|occupies|us|keep|inside|down same|our|my|your|ego ?vehicle ?'s ?own ?driving|travel lane",
            Pair(P::SameLane),
        ),
        ("same lane as ego|us|me", Pair(P::SameLane)),
        ("same lane", Note(P::SameLane)),
        ("=left ?hand lane", Note(P::NeighbourLane(true))),
        ("=right ?hand lane", Note(P::NeighbourLane(false))),
        ("same lanelet", Note(P::SameLanelet)),
        (
            "different|another|other|adjacent|separate|neighboring|neighbouring lane|lanes",
            Note(P::OtherLane),
        ),
        (
            "different|another|other|adjacent|separate|neighboring|neighbouring lanelet|lanelets",
            Note(P::OtherLanelet),
        ),
        (
            "in|on|within|along|share|occupies|us|same same|our|my|your|ego ?vehicle ?'s ?own lanelet",
            Pair(P::SameLanelet),
        ),
        (
            "in|on|within|along|occupies different|another|other|adjacent|separate|neighboring|neighbouring|next|parallel|own lane",
            Pair(P::OtherLane),
        ),
        (
            "in|on|within|along|occupies different|another|other|adjacent|separate|neighboring|neighbouring|next lanelet",
            Pair(P::OtherLanelet),
        ),
        (
            "in|on|within|along|occupies ?our|my|its|adjacent|neighbouring|neighboring|next =left ?hand|most lane",
            Pair(P::NeighbourLane(true)),
        ),
        (
            "in|on|within|along|occupies ?our|my|its|adjacent|neighbouring|neighboring|next =right ?hand|most lane",
            Pair(P::NeighbourLane(false)),
        ),
        (
            "in|on ?adjacent|neighbouring|next lane to|on ?our|my|ego left",
            Pair(P::NeighbourLane(true)),
        ),
        (
            "in|on ?adjacent|neighbouring|next lane to|on ?our|my|ego =right",
            Pair(P::NeighbourLane(false)),
        ),
        ("one lane to|on ?our|my left", Pair(P::NeighbourLane(true))),
        (
            "one lane to|on ?our|my =right",
            Pair(P::NeighbourLane(false)),
        ),
        // Directions.
        ("same direction|way|heading", Pair(P::SameWay)),
        (
            "move|drive|travel|goes|run|head|ride|walk parallel ?to|with ?ego|us|me",
            Pair(P::Parallel),
        ),
        ("parallel to|with ego|us|me", Pair(P::Parallel)),
        (
            "on|in|with|along|maintain|follow parallel trajectory|path|course",
            Pair(P::Parallel),
        ),
        ("opposite|opposing|other ?way|direction|heading", Other),
        ("opposite|opposing direction|way|heading", Pair(P::Oncoming)),
        (
            "come|coming|drive|travel|move ?in|from other way|direction",
            Pair(P::Oncoming),
        ),
        (
            "in|on opposite|opposing|oncoming ?direction|lane|traffic",
            Pair(P::Oncoming),
        ),
        ("oncoming", Pair(P::Oncoming)),
        ("head on", Pair(P::Oncoming)),
        (
            "faster|quicker than ego|us|me|we|our|my|i|you",
            Pair(P::FasterThanEgo),
        ),
        (
            "slower than ego|us|me|we|our|my|i|you",
            Pair(P::SlowerThanEgo),
        ),
        (
            "higher|greater speed|velocity than ego|us|me|our|my",
            Pair(P::FasterThanEgo),
        ),
        (
            "lower|smaller speed|velocity than ego|us|me|our|my",
            Pair(P::SlowerThanEgo),
        ),
        (
            "speed|velocity is|remains|stays higher|greater than ego|our|my",
            Pair(P::FasterThanEgo),
        ),
        (
            "speed|velocity is|remains|stays lower|smaller than ego|our|my",
            Pair(P::SlowerThanEgo),
        ),
        ("speed|velocity exceeds ego|our|my", Pair(P::FasterThanEgo)),
        (
            "=follows|=following|=follow|=followed|=trails|=trailed|=trailing|=tails|=tailing|tailgate|=chasing",
            Follows,
        ),
        // Contact.
        (
            "touch|collide|crash|hit|=hits|struck|strike|=bumps|=bumped|=rammed|=rams",
            Touches,
        ),
        ("run|ran|smash|slam|bump|drove|plow into", Touches),
        ("rear ended", Touches),
        ("overlap", Touches),
        ("collision|contact|crash|impact|accident|sideswipe", Contact),
        (
            "=passes|=passed|=passing|overtake|=overtook|=met|=meets",
            Passes,
        ),
        ("goes|went|go|slip|slipped|drive|move by|past", Passes),
        // What claims nothing by itself.
        ("=pass", Other),
        (
            "leave|enter|wait|yield|stay|remain|pose|require|need|need|reach|behave|become|appear|seem|show|continue|allow|mean|give|suggest|indicate",
            Other,
        ),
        (
            "risk of|for ?imminent|potential|direct collision|contact|crash|impact",
            Other,
        ),
        (
            "collision risk|avoidance|threat|warning|probability|score|check|detection|likelihood|status|danger",
            Other,
        ),
        ("time to|until collision|contact|impact", Other),
        (
            "brake|braking|stopping|stop distance|light|lights|sign|line|signal",
            Other,
        ),
        ("turn signal|indicator|lane", Other),
        (
            "lane change|changing|merging maneuver|manoeuvre|trajectory|possibility|probability|likelihood|intention|potential",
            Other,
        ),
        ("left|right turn", Other),
    ])
});

/// Whether a word names a property of a participant: "distance", "speed".
pub fn is_property(token: &Token) -> bool {
    const STEMS: [&str; 40] = [
        "distanc",
        "gap",
        "ttc",
        "spe",
        "speed",
        "velocity",
        "acceleration",
        "deceleration",
        "risk",
        "scor",
        "motion",
        "position",
        "location",
        "direction",
        "tim",
        "collision",
        "separation",
        "clearanc",
        "head",
        "heading",
        "lan",
        "lanelet",
        "trajectory",
        "path",
        "movement",
        "relativ",
        "longitudinal",
        "lateral",
        "clos",
        "minimum",
        "headway",
        "contact",
        "reason",
        "sid",
        "safety",
        "valu",
        "measur",
        "danger",
        "threat",
        "mdc",
    ];
    STEMS.contains(&token.stem.as_str())
}
