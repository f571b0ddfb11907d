//! An obstacle whose motion follows from parameters: their declarations, and the places of its trajectory.

use super::formula::Formula;
use crate::commonroad::WriteError;
use crate::commonroad::writer::{XmlWriter, number};

/// The motion of an obstacle that follows from parameters; it is there in one stretch.
#[derive(Debug, Clone, PartialEq)]
pub struct VariedMotion {
    /// Its id.
    pub obstacle: i64,
    /// In the places of its formulas.
    pub parameters: Vec<VariedParameter>,
    /// In order of their steps.
    pub vertices: Vec<VariedVertex>,
}

/// A parameter of a scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct VariedParameter {
    /// Its name.
    pub name: &'static str,
    /// What it is, with its unit.
    pub meaning: String,
    /// The value that it has in the file.
    pub value: f64,
    /// The least and the greatest value that it is for.
    pub range: [f64; 2],
}

/// A place of a trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct VariedVertex {
    /// Its step, before it is shifted.
    pub step: i64,
    /// By how much its time is shifted, seconds.
    pub later: Formula,
    /// Metres.
    pub x: Formula,
    /// Metres.
    pub y: Formula,
    /// Radians.
    pub heading: Formula,
}

impl VariedMotion {
    /// Its parameters, as the document declares them.
    pub(super) fn declare(&self, out: &mut XmlWriter) -> Result<(), WriteError> {
        out.element("ParameterDeclarations", &[], |out| {
            self.parameters.iter().try_for_each(|parameter| {
                out.comment(&format!(" {} ", parameter.meaning))?;
                let declared = [
                    ("name", parameter.name.to_owned()),
                    ("parameterType", "double".into()),
                    ("value", number(parameter.value)),
                ];
                let [least, most] = parameter.range;
                out.element("ParameterDeclaration", &declared, |out| {
                    out.element("ConstraintGroup", &[], |out| {
                        let ends = [("greaterOrEqual", least), ("lessOrEqual", most)];
                        ends.into_iter().try_for_each(|(rule, value)| {
                            let limit = [("rule", rule.into()), ("value", number(value))];
                            out.empty("ValueConstraint", &limit)
                        })
                    })
                })
            })
        })
    }
}
