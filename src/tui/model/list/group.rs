//! Grouping of the list: by country, folder, tag or verdicts of stored answers.

use super::Row;
use nearmiss_workflow::{Agreement, Filterable};

/// By what the list is grouped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Grouping {
    /// By nothing.
    #[default]
    None,
    /// By country.
    Country,
    /// By folder.
    Folder,
    /// By tag; a scenario is under each of its tags.
    Tag,
    /// By what stored answers say.
    Verdict,
}

impl Grouping {
    /// Every one.
    pub const ALL: [Self; 5] = [
        Self::None,
        Self::Country,
        Self::Folder,
        Self::Tag,
        Self::Verdict,
    ];

    /// The one after it; after the last one, none.
    #[must_use]
    pub fn next(self) -> Self {
        match self {
            Self::None => Self::Country,
            Self::Country => Self::Folder,
            Self::Folder => Self::Tag,
            Self::Tag => Self::Verdict,
            Self::Verdict => Self::None,
        }
    }

    /// A word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "nothing",
            Self::Country => "country",
            Self::Folder => "folder",
            Self::Tag => "tag",
            Self::Verdict => "verdict",
        }
    }

    /// The one with a name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|one| one.name() == name)
    }

    /// Whether it needs facts known only after a scenario was read.
    #[must_use]
    pub fn needs_facts(self) -> bool {
        matches!(self, Self::Country | Self::Tag | Self::Verdict)
    }

    /// The groups that a scenario is in: their place and their name, both for sorting.
    pub fn groups_of(self, row: &Row) -> Vec<(u8, String)> {
        const KNOWN: u8 = 0;
        const NOTHING: u8 = 8;
        const UNREAD: u8 = 9;
        let unread = || vec![(UNREAD, "not read yet".to_string())];
        let or = |name: &str, nothing: &str| match name {
            "" => vec![(NOTHING, nothing.to_string())],
            name => vec![(KNOWN, name.to_string())],
        };
        match self {
            Self::None => Vec::new(),
            Self::Country => match (row.country(), &row.facts) {
                ("", None) => unread(),
                (country, _) => or(country, "no country"),
            },
            Self::Folder => or(&row.entry.group, "no folder"),
            Self::Tag => {
                let mut tags: Vec<_> = row.tags().map(|tag| (KNOWN, tag.to_string())).collect();
                tags.sort();
                tags.dedup();
                match (tags.is_empty(), &row.facts) {
                    (false, _) => tags,
                    (true, None) => unread(),
                    (true, Some(_)) => vec![(NOTHING, "no tags".to_string())],
                }
            }
            Self::Verdict => match row.agreement() {
                Some(Agreement::Differ) => vec![(1, "answers differ".to_string())],
                Some(Agreement::Agree) => vec![(2, "answers agree".to_string())],
                Some(Agreement::Nothing) => vec![(NOTHING, "no answers".to_string())],
                None => unread(),
            },
        }
    }
}

/// A group that is shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// How many scenarios are in it.
    pub count: usize,
    /// Whether they are hidden.
    pub shut: bool,
}
