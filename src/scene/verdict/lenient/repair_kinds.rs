//! Repairs of malformed JSON.

use std::fmt;

/// A departure from JSON whose meaning is plain all the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::verdict) enum Repair {
    /// `//`, `/* */` or `#`.
    Comments,
    /// A comma before a bracket, or two commas.
    ExtraCommas,
    /// No comma between two entries.
    MissingCommas,
    /// `{{` and `}}`, as templates escape braces.
    DoubledBraces,
    /// `'…'` or typographic quotation marks.
    OtherQuotes,
    /// A quotation mark is missing.
    MissingQuotes,
    /// Quotation marks inside a string, without a backslash.
    InnerQuotes,
    /// A key without quotation marks.
    BareKeys,
    /// Text without quotation marks.
    BareWords,
    /// `None`, `True`, `False` and the like.
    Literals,
    /// NaN or an infinity.
    NotANumber,
    /// `+1`, `.5`, `1.`, `007`.
    Numbers,
    /// Line breaks or other control characters in a string.
    ControlCharacters,
    /// A backslash before something that needs none.
    Escapes,
    /// A key without a value.
    MissingValues,
    /// `(…)` for a list, or a bracket of one kind closed by another or not at all.
    Brackets,
    /// A duplicate key with different values.
    DoubledKeys,
}

impl fmt::Display for Repair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Comments => "comments were skipped",
            Self::ExtraCommas => "superfluous commas were skipped",
            Self::MissingCommas => "missing commas were added",
            Self::DoubledBraces => "doubled braces were read as single ones",
            Self::OtherQuotes => "other quotation marks were read as \"",
            Self::MissingQuotes => "missing quotation marks were added",
            Self::InnerQuotes => "quotation marks inside strings were kept",
            Self::BareKeys => "unquoted keys were read",
            Self::BareWords => "unquoted strings were read",
            Self::Literals => "None, True or False were read as null, true or false",
            Self::NotANumber => "invalid numbers were read as null",
            Self::Numbers => "numbers in other notations were read",
            Self::ControlCharacters => "line breaks inside strings were kept",
            Self::Escapes => "unknown escapes were kept",
            Self::MissingValues => "missing values were read as null",
            Self::Brackets => "brackets were corrected",
            Self::DoubledKeys => "for duplicate keys the last value was used",
        })
    }
}
