//! Parameters of a document, or of an entry of a catalog: their values in the places where they are used.

use super::expression::{Values, replaced};
use crate::commonroad::ReadError;
use crate::recordings::opendrive::tree::Node;

/// The document with the values of its parameters in their places.
pub fn filled(mut root: Node) -> Result<Node, ReadError> {
    let values = declared(&root)?;
    root.change_values(&|value| replaced(value, &values));
    Ok(root)
}

/// An entry of a catalog with the values that a reference assigns, or its own.
pub fn assigned(mut entry: Node, reference: &Node) -> Result<Node, ReadError> {
    let mut values = declared(&entry)?;
    for assignment in reference.within("ParameterAssignment") {
        let name = assignment.needed("parameterRef")?.trim_start_matches('$');
        let value = assignment.text("value").unwrap_or_default();
        values.insert(name.to_string(), value.to_string());
    }
    entry.change_values(&|value| replaced(value, &values));
    Ok(entry)
}

fn declared(of: &Node) -> Result<Values, ReadError> {
    let mut values = Values::new();
    for parameter in of.within("ParameterDeclaration") {
        let name = parameter.needed("name")?.trim_start_matches('$');
        let value = parameter.text("value").unwrap_or_default();
        // A value may be told by parameters before it.
        let value = replaced(value, &values).unwrap_or_else(|| value.to_string());
        values.insert(name.to_string(), value);
        // Its type says nothing more; limits were checked by whoever chose the value.
        parameter.skip();
    }
    Ok(values)
}
