//! Which windows are asked about, and what counts as a yes: the program's own rules, or those of the paper.

use strum::{IntoStaticStr, VariantArray};

use super::Scored;

/// The rules of an evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Protocol {
    /// Dangerous windows at a lead before the contact, and safe windows like them.
    #[default]
    Matched,
    /// Those of "From Words to Collisions": one window of each recording ([`Labelled::paper_window`]), and a yes of the
    /// safety task counts only if it names the obstacle that collides ([`Scored::require_naming`]).
    ///
    /// [`Labelled::paper_window`]: crate::evaluation::Labelled::paper_window
    /// [`Scored::require_naming`]: crate::evaluation::Scored::require_naming
    Paper,
}

impl Protocol {
    /// Makes an answer what counts as one.
    pub fn count(self, answer: &mut Scored) {
        if self == Self::Paper {
            answer.require_naming();
        }
    }
}

nearmiss_record::named!(Protocol, "protocol");
