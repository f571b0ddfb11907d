//! Rows of the list, their order, and how their windows are indexed.

use std::cmp::Ordering;
use std::sync::Arc;

use crate::features::scenarios::state::{Filter, List};
use crate::loaded::{Facts, StandInEgo, country_code};
use nearmiss_formats::Entry;
use nearmiss_scene::corpus::CorpusIndex;
use nearmiss_scene::metrics::{CriticalMoment, Danger, Headline, Measure, measure};
use nearmiss_workflow::{Agreement, Filterable, HEADLINE, Indexed, Number, Property, nearest};

/// By what the list is sorted; scenarios of which that is not known come last.
#[derive(Debug, Clone, Copy, Default)]
pub enum Order {
    /// As they were found: by path, the bundled ones as they are.
    #[default]
    Found,
    /// By name.
    Name,
    /// By the moment that matters, the most severe first.
    Severity,
    /// By the most dangerous value of a measure, the most dangerous one first.
    Measure(&'static Measure),
    /// By the number of obstacles, the most first.
    Obstacles,
    /// By their length, the longest first.
    Duration,
    /// By how many stored answers differ from the built-in judge, the most first.
    Verdicts,
}

/// The moment that matters of a scenario.
fn worst(row: &Row) -> Option<&CriticalMoment> {
    row.headline()?.worst()
}

impl PartialEq for Order {
    fn eq(&self, other: &Self) -> bool {
        self.id() == other.id()
    }
}

impl Order {
    /// Every one but the measures.
    pub const PLAIN: [Self; 6] = [
        Self::Found,
        Self::Name,
        Self::Severity,
        Self::Obstacles,
        Self::Duration,
        Self::Verdicts,
    ];

    /// A word for it.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Self::Found => "found",
            Self::Name => "name",
            Self::Severity => "severity",
            Self::Measure(measure) => measure.id,
            Self::Obstacles => "obstacles",
            Self::Duration => "duration",
            Self::Verdicts => "verdicts",
        }
    }

    /// The one with an id.
    #[must_use]
    pub fn parse(id: &str) -> Option<Self> {
        let mut plain = Self::PLAIN.into_iter();
        plain
            .find(|order| order.id() == id)
            .or_else(|| measure(id).map(Self::Measure))
    }

    /// Describes which scenarios come first; for measures, their name.
    #[must_use]
    pub fn doc(self) -> &'static str {
        match self {
            Self::Found => "by path",
            Self::Name => "by name, ignoring folders",
            Self::Severity => {
                "the most severe moment first: 0 contact, courses to contact, close passes, 5 none"
            }
            Self::Measure(measure) => measure.name,
            Self::Obstacles => "the most obstacles first",
            Self::Duration => "the longest first",
            Self::Verdicts => "most disagreements with the built-in judge first",
        }
    }

    /// The unit of what it sorts by.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Measure(measure) => measure.unit,
            Self::Duration => "s",
            _ => "",
        }
    }

    /// Whether it needs facts known only after a scenario was read.
    #[must_use]
    pub fn needs_facts(self) -> bool {
        !matches!(self, Self::Found | Self::Name)
    }

    /// Orders two scenarios; what is not known comes last, also where the order is turned around.
    #[must_use]
    pub fn compare(self, turned: bool, a: &Row, b: &Row) -> Ordering {
        let turn = |order: Ordering| if turned { order.reverse() } else { order };
        let numbers = |of: &dyn Fn(&Row) -> Option<f64>, danger: Danger| match (of(a), of(b)) {
            (Some(x), Some(y)) => turn(danger.compare(x, y)),
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (None, None) => Ordering::Equal,
        };
        match self {
            Self::Found => turn(a.rank.cmp(&b.rank)),
            Self::Name => turn(a.entry.name.cmp(&b.entry.name)),
            Self::Severity => match (worst(a), worst(b)) {
                (Some(x), Some(y)) => turn(x.compare_across(y)),
                (Some(_), None) => Ordering::Less,
                (None, Some(_)) => Ordering::Greater,
                (None, None) => Ordering::Equal,
            },
            Self::Measure(m) => numbers(&|row| row.value_of(m).flatten(), m.danger),
            Self::Obstacles => numbers(&|row| Some(row.facts()?.obstacles as f64), Danger::High),
            Self::Duration => numbers(&Row::seconds, Danger::High),
            Self::Verdicts => {
                let differ = |row: &Row| Some(row.facts()?.tally()).filter(|t| t.count() > 0);
                let part = |row: &Row| differ(row).map(|t| f64::from(t.differ));
                let count = |row: &Row| differ(row).map(|t| f64::from(t.count()));
                numbers(&part, Danger::High).then_with(|| numbers(&count, Danger::High))
            }
        }
        .then(a.rank.cmp(&b.rank))
    }
}

/// A scenario in the list.
#[derive(Debug)]
pub struct Row {
    /// The scenario.
    pub entry: Entry,
    /// Its facts, once known.
    pub facts: Option<Result<Facts, String>>,
    /// What matters with the ego that stood in for a recorded one in this session, in the workbench or for the order.
    pub stand_in: Option<StandInEgo>,
    /// The most dangerous value of the measure by which the list is sorted; the outer one is whether it is known.
    pub value: Option<Option<f64>>,
    /// The user's own tags.
    pub own_tags: Vec<String>,
    /// What the index says of it.
    pub indexed: Indexed,
    /// Its place in the list as it was found.
    pub rank: usize,
}

impl Row {
    /// A scenario of which nothing is known yet.
    #[must_use]
    pub fn new(entry: Entry, rank: usize) -> Self {
        Self {
            entry,
            facts: None,
            stand_in: None,
            value: None,
            own_tags: Vec::new(),
            indexed: Indexed::Unknown,
            rank,
        }
    }

    /// Looks it up in an index, once it was read.
    pub fn look_up(&mut self, index: Option<&CorpusIndex>) {
        self.indexed = match (index, &self.facts) {
            (Some(index), Some(Ok(facts))) => index.find(&facts.hash, &self.entry.name).into(),
            (Some(_), Some(Err(_))) => Indexed::Missing,
            (None, _) | (_, None) => Indexed::Unknown,
        };
    }

    /// Its facts, if it could be read.
    #[must_use]
    pub fn facts(&self) -> Option<&Facts> {
        self.facts.as_ref()?.as_ref().ok()
    }

    /// The ego that stands in, where it was read and none is recorded.
    #[must_use]
    pub fn stand_in(&self) -> Option<&StandInEgo> {
        let recorded = self.facts()?.headline.is_some();
        self.stand_in.as_ref().filter(|_| !recorded)
    }

    /// What matters with its recorded ego, or else with the one that stands in.
    #[must_use]
    pub fn headline(&self) -> Option<&Headline> {
        let recorded = self.facts()?.headline.as_ref();
        recorded.or(self.stand_in().map(|ego| &ego.headline))
    }

    /// How long it is, seconds: the motion of the ego that stands in, where there is one.
    #[must_use]
    pub fn seconds(&self) -> Option<f64> {
        let stand_in = self.stand_in().map(|ego| ego.seconds);
        stand_in.or(Some(self.facts()?.seconds))
    }

    /// Whether it was read, and has no ego, recorded or standing in.
    #[must_use]
    pub fn lacks_ego(&self) -> bool {
        self.facts().is_some() && self.headline().is_none()
    }

    /// Its tags: the file's, then the user's.
    pub fn tags(&self) -> impl Iterator<Item = &str> {
        let of_file = self.facts().into_iter().flat_map(|facts| &facts.tags);
        of_file.chain(&self.own_tags).map(String::as_str)
    }

    /// Three letters for its country: by its benchmark id, before it was read by its name; may be empty.
    #[must_use]
    pub fn country(&self) -> &str {
        match self.facts() {
            Some(facts) if !facts.country.is_empty() => &facts.country,
            _ => country_code(&self.entry.name),
        }
    }

    /// The most dangerous value of a measure; the outer one is whether it is known.
    #[must_use]
    pub fn value_of(&self, measure: &Measure) -> Option<Option<f64>> {
        if !HEADLINE.contains(&measure.id) {
            return self.value;
        }
        self.facts.as_ref()?;
        let nearest = self
            .headline()
            .and_then(|headline| nearest(headline, measure));
        Some(nearest.map(|n| n.value))
    }
}

impl Filterable for Row {
    fn entry(&self) -> &Entry {
        &self.entry
    }

    fn tags(&self) -> impl Iterator<Item = &str> {
        Self::tags(self)
    }

    fn country(&self) -> &str {
        Self::country(self)
    }

    fn has(&self, property: Property) -> Option<bool> {
        match property {
            Property::Tags => Some(!self.own_tags.is_empty()),
            Property::Error => Some(self.facts.as_ref()?.is_err()),
            Property::Index => match self.indexed {
                Indexed::Unknown => None,
                Indexed::Windows(_) => Some(true),
                Indexed::Changed | Indexed::Missing => Some(false),
            },
            property => self.facts()?.has(property),
        }
    }

    fn agreement(&self) -> Option<Agreement> {
        match self.facts.as_ref()? {
            Ok(facts) => Some(facts.agreement()),
            Err(_) => Some(Agreement::Nothing),
        }
    }

    fn number(&self, number: Number) -> Option<f64> {
        match number {
            Number::Of(measure) => self.value_of(measure).flatten(),
            Number::Duration => self.seconds(),
            number => self.facts()?.number(number),
        }
    }

    fn indexed(&self) -> &Indexed {
        &self.indexed
    }
}

/// The index behind terms such as `road:urban`.
#[derive(Debug, Clone, Default)]
pub enum ListIndex {
    /// None was chosen.
    #[default]
    None,
    /// It is being read.
    Reading,
    /// It cannot be read.
    Failed,
    /// It was read.
    Ready(Arc<CorpusIndex>),
}

impl ListIndex {
    /// The index, once it was read.
    #[must_use]
    pub fn ready(&self) -> Option<&Arc<CorpusIndex>> {
        match self {
            Self::Ready(index) => Some(index),
            _ => None,
        }
    }

    /// Why a term that needs an index is an error.
    fn refusal(&self) -> Option<&'static str> {
        match self {
            Self::Ready(_) => None,
            Self::None => Some(
                "needs an index: choose one with `:index FOLDER` or `nearmiss --index FOLDER`; \
                 `nearmiss corpus index PATH… -o FOLDER` makes one",
            ),
            Self::Reading => Some("waits for the index, which is being read"),
            Self::Failed => {
                Some("needs an index, and this one cannot be read; `:index` chooses another")
            }
        }
    }
}

/// How many scenarios of the list an index has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct IndexShare {
    /// The same contents, under any name.
    pub same: usize,
    /// Other contents under the same name.
    pub changed: usize,
    /// Neither.
    pub missing: usize,
    /// Not read yet.
    pub unknown: usize,
}

impl IndexShare {
    /// What is missing, in words; nothing where the index has every scenario.
    #[must_use]
    pub fn summary(&self) -> String {
        let counts = [
            (self.changed, "changed since"),
            (self.missing, "not in the index"),
            (self.unknown, "not read yet"),
        ];
        let said = counts.into_iter().filter(|(count, _)| *count > 0);
        let said: Vec<String> = said
            .map(|(count, words)| format!("{count} {words}"))
            .collect();
        said.join(", ")
    }
}

impl List {
    /// Filters by another index, or by none.
    pub fn set_index(&mut self, index: ListIndex) {
        self.index = index;
        for row in &mut self.rows {
            row.look_up(self.index.ready().map(Arc::as_ref));
        }
        self.read_filter();
        self.arrange(true);
    }

    /// The index.
    #[must_use]
    pub fn index(&self) -> &ListIndex {
        &self.index
    }

    /// How many scenarios the index has.
    #[must_use]
    pub fn index_share(&self) -> IndexShare {
        let mut share = IndexShare::default();
        for row in &self.rows {
            *match row.indexed {
                Indexed::Windows(_) => &mut share.same,
                Indexed::Changed => &mut share.changed,
                Indexed::Missing => &mut share.missing,
                Indexed::Unknown => &mut share.unknown,
            } += 1;
        }
        share
    }

    /// Reads the filter as it is typed.
    pub(super) fn read_filter(&mut self) {
        self.read = Filter::read(&self.filter, self.measure());
        if let Some(why) = self.index.refusal() {
            self.read.refuse_index_terms(why);
        }
    }
}
