//! The vocabulary of sentences: phrases, and what each means.

use super::lexicon::Bound;
use super::lexicon::Meaning::{self, *};
use super::lexicon::Unit;

/// Phrases, separated by `|`. A word with `=` before it is meant in this form alone, others in all their forms.
pub const PHRASES: &[(&str, Meaning)] = &[
    (
        "cut in|cut ins|cutin|cut in on|cut in front|cut in front of|cut off|cut us off|cut me off|cut the ego off|swerve in front of|swerve into our lane|swerve into my lane|swerve into the ego lane|pull in front of|chang into our lane|chang into the ego lane|chang into my lane|move into our lane",
        Term("manoeuvre", "cut_in"),
    ),
    (
        "lane change|change lane|changing lane|ego change lane|we change lane",
        Term("manoeuvre", "lane_change"),
    ),
    ("merge|zip together", Term("manoeuvre", "merging")),
    (
        "=following|car following|ego follow|we follow|vehicle ahead|lead vehicle|drive behind|behind",
        Term("manoeuvre", "following"),
    ),
    (
        "=followed|followed by|follow us|follow me|follow ego|follow the ego|behind us|behind me|behind ego|behind the ego|from behind us|from behind the ego|drive behind us|tailgate|tailgate us|from behind|approach from behind|rear approach",
        Term("manoeuvre", "followed"),
    ),
    (
        "parallel|parallel drive|side by side|alongside|next to|drive next to|drive alongside",
        Term("manoeuvre", "parallel"),
    ),
    (
        "oncoming|oncoming traffic|head on|opposite direction|contraflow|wrong way|wrong way driver|ghost driver",
        Term("manoeuvre", "oncoming"),
    ),
    (
        "cross|cross traffic|cross our path|cross the road|step onto the road|step into the road|step out|run into the road|cross in front of|cross ahead of|step in front of|walk in front of|run in front of",
        Term("manoeuvre", "crossing"),
    ),
    (
        "turn across|turn vehicle across our path|turn vehicle across our lane|turn traffic across our path|turn across path|turn across our lane|turn across our path|turn across oncoming traffic|turn in front of us",
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
        "rear end",
        Terms(&[("manoeuvre", "following"), ("manoeuvre", "followed")]),
    ),
    (
        "jaywalk",
        Terms(&[("actor", "pedestrian"), ("manoeuvre", "crossing")]),
    ),
    (
        "jaywalker",
        Terms(&[("actor", "pedestrian"), ("manoeuvre", "crossing")]),
    ),
    (
        "in front of us|in front of me|in front of ego|in front of the ego|ahead of us|ahead of me|ahead of ego|ahead of the ego",
        Ahead,
    ),
    (
        "pedestrian|people|person|people on foot|walker",
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
    ("building|wall|house", Term("actor", "building")),
    ("pillar|pole", Term("actor", "pillar")),
    ("median strip", Term("actor", "median_strip")),
    (
        "road boundary|road edge|guard rail|guardrail",
        Term("actor", "road_boundary"),
    ),
    (
        "unknown obstacle|unknown object|unknown type",
        Term("actor", "unknown"),
    ),
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
    (
        "collision|crash|accident|contact",
        Term("severity", "contact"),
    ),
    (
        "near miss|near collision|near crash|near accident",
        Term("severity", "near_miss"),
    ),
    (
        "critical|safety critical|critical or worse|near miss or worse|near collision or worse|dangerous|unsafe|hazardous",
        Term("severity", "critical"),
    ),
    ("extreme", Level(1)),
    ("high", Level(2)),
    ("medium|moderate", Level(3)),
    ("low", Level(4)),
    ("negligible", Level(5)),
    ("risk|risk score|danger|risk level", Risk),
    ("severity", Measure("severity", Unit::None)),
    (
        "ttc|time to collision|time to crash|time to contact|to collision",
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
        "distance headway|headway distance",
        Measure("headway", Unit::Metres),
    ),
    ("time to brake", Measure("ttb", Unit::Seconds)),
    ("time to steer", Measure("tts", Unit::Seconds)),
    ("time to react", Measure("ttr", Unit::Seconds)),
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
        "obstacle|road user|other|vehicle|other vehicle|other road user|other obstacle",
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
        "<=|at most|no more than|not more than|no longer than|up to|max of|maximum of",
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
        ">=|at least|no less than|not less than|no fewer than|min of|minimum of",
        Compare(">=", None),
    ),
    ("=|exactly|equal to|equal", Compare("=", None)),
    (
        "min|minimum|minimal|lowest|smallest|shortest",
        Extreme(Bound::Least),
    ),
    (
        "max|maximum|maximal|highest|largest|peak|greatest",
        Extreme(Bound::Most),
    ),
    ("worst", Extreme(Bound::Worst)),
    ("worse than", Worse),
    (
        "or more|or above|or over|or longer|or higher|or greater|and above|and more|and up",
        OrMore,
    ),
    (
        "or less|or lower|or below|or under|or shorter|or closer|or smaller|or fewer|and less|and below",
        OrLess,
    ),
    ("or worse|and worse", OrWorse),
    ("between", Between),
    ("s|sec|second", Unit(Unit::Seconds, 1.0)),
    ("ms|millisecond", Unit(Unit::Seconds, 0.001)),
    ("minute|mins", Unit(Unit::Seconds, 60.0)),
    ("hour|h", Unit(Unit::Seconds, 3600.0)),
    ("m|metre|meter", Unit(Unit::Metres, 1.0)),
    ("ft|foot|feet", Unit(Unit::Metres, 0.3048)),
    ("mile", Unit(Unit::Metres, 1609.344)),
    ("cm|centimetre|centimeter", Unit(Unit::Metres, 0.01)),
    ("km|kilometre|kilometer", Unit(Unit::Metres, 1000.0)),
    (
        "m/s2|metre per second squared|meter per second squared",
        Unit(Unit::Acceleration, 1.0),
    ),
    ("=g", Unit(Unit::Acceleration, 9.80665)),
    (
        "m/s|metre per second|meter per second",
        Unit(Unit::Speed, 1.0),
    ),
    (
        "km/h|kmh|kph|kilometre per hour|kilometer per hour",
        Unit(Unit::Speed, 1.0 / 3.6),
    ),
    ("mph|mile per hour", Unit(Unit::Speed, 0.44704)),
    (
        "percent|degree|frame|step|time step",
        Unit(Unit::Other, 1.0),
    ),
    (
        "speed|velocity|acceleration|deceleration|jerk|visibility|angle|heading|width|radius|curvature|age|size|weight|lateral distance|lateral gap|lateral clearance|longitudinal distance|longitudinal gap|relative speed|closing speed|reaction time|speed limit",
        Foreign,
    ),
    (
        "zebra|zebra crossing|crosswalk|level crossing|railway crossing|railroad crossing|at pedestrian crossing|at a pedestrian crossing|at the pedestrian crossing|near a pedestrian crossing|on a pedestrian crossing|broken down|cut out|parallel parking|crossing guard",
        NoTerm,
    ),
    (
        "from behind a|from behind an|from behind the|from behind parked|from behind some|occlud by|occlud by a|hidden by|hidden by a|hidden behind|hidden behind a|hidden behind the|conceal by|conceal by a|obscur by|obscur by a|mask by|mask by a",
        NoTermOf,
    ),
    (
        "not|!|no|non|without|except|but not|not with|outside|exclude|other than|neither|nor",
        Not,
    ),
    ("and|plus|as well as", And),
    ("or", Or),
    (
        "tagged|tag|tagged as|tagged with|with tag|with the tag",
        Key("tag"),
    ),
    (
        "folder|in folder|in the folder|from folder|from the folder|folder called|folder named|in the folder called|in the folder named",
        Key("folder"),
    ),
    ("my tagged|my tag|with my tag", Whole("has:tags")),
    ("without tag|no tag|untagged", Whole("no:tags")),
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
        "could not be read|cannot be read|can not be read|unreadable|broken file",
        Whole("has:error"),
    ),
    ("no ego|without ego|without an ego", Whole("no:ego")),
    ("with an ego|with ego|has an ego", Whole("has:ego")),
    ("german", Term("country", "DEU")),
    ("american", Term("country", "USA")),
    ("chinese", Term("country", "CHN")),
    ("british", Term("country", "GBR")),
    ("french", Term("country", "FRA")),
    ("spanish", Term("country", "ESP")),
    ("italian", Term("country", "ITA")),
    ("belgian", Term("country", "BEL")),
    ("croatian", Term("country", "HRV")),
    ("greek", Term("country", "GRC")),
    ("japanese", Term("country", "JPN")),
    // Words around what is meant.
    (
        "a|an|the|all|any|anything|every|each|some|somebody|someone|something|it|they|them|there|this|these|those|that|which|who|what|where|when|while|with|in|on|at|of|to|by|for|from|is|are|was|were|be|been|being|has|have|had|do|does|did|as|into|us|we|our|their|its|whose|my|i|me|you|ego|our path|of the ego|to the ego|the ego vehicle|ego vehicle",
        Filler,
    ),
    (
        "show|show me|everything|look|find|give me|give|list|search|look for|get|please|time|every time|but|then|yet|only|just|single|involv|includ|contain|happen|occur|drop|fall|fell|get|got|go|went|stay|becom|reach|valu|area|section|zone|region|environment|driver|than|away|most|during|come|came|driv|path|onto|the road|street|road|lane|model|judge",
        Filler,
    ),
    (
        "scenario|scene|recording|file|window|encounter|situation|manoeuvre|maneuver|conflict|event|interaction|case|traffic|kind|type",
        Filler,
    ),
];
