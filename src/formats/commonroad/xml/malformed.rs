//! Messages for malformed XML.

use quick_xml::errors::{Error, SyntaxError};

/// The syntax error, and a hint if the file is truncated.
pub(super) fn words(error: &Error) -> String {
    let advice = match error {
        Error::Syntax(SyntaxError::UnclosedTag) => "; the file is truncated",
        Error::Syntax(SyntaxError::InvalidBangMarkup) => "",
        // All others of this kind are noticed at the end of the file, too.
        Error::Syntax(_) => "; the file is truncated, or this is not closed",
        _ => "",
    };
    format!("not well-formed XML: {error}{advice}")
}
