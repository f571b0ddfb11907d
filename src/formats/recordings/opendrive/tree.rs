//! An XML document as a tree whose elements know their lines.

use crate::formats::commonroad::ReadError;
use crate::formats::commonroad::xml::{Element, Xml, decoded};
use crate::scenario::plausibility::limits::refused_coordinate;

/// An element with its attributes and children.
#[derive(Debug, Clone, Default)]
pub struct Node {
    pub name: String,
    /// From 1.
    pub line: usize,
    /// Names of the elements around it, and its own.
    pub path: String,
    attributes: Vec<(String, String)>,
    pub children: Vec<Node>,
    file: std::rc::Rc<str>,
}

/// No document has more elements.
const MOST_NODES: usize = 5_000_000;

/// No document is deeper.
const DEEPEST: usize = 60;

/// Reads a document whose root has this name.
pub fn read(bytes: &[u8], file: &str, root: &str) -> Result<Node, ReadError> {
    let text = decoded(bytes, file)?;
    let mut xml = Xml::new(&text, file);
    let name: std::rc::Rc<str> = file.into();
    let Some(element) = xml.next()?.filter(|e| e.name == root) else {
        return Err(xml.fail(0, format!("its root is not <{root}>")));
    };
    let mut count = 0;
    let node = node(&mut xml, element, "", 0, &mut count, &name)?;
    // What follows the root must be readable too: a cut file ends within it.
    xml.next()?;
    Ok(node)
}

fn node<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    above: &str,
    depth: usize,
    count: &mut usize,
    file: &std::rc::Rc<str>,
) -> Result<Node, ReadError> {
    *count += 1;
    if *count > MOST_NODES {
        return Err(xml.fail(element.at, format!("more than {MOST_NODES} elements")));
    }
    if depth > DEEPEST {
        return Err(xml.fail(
            element.at,
            format!("elements within more than {DEEPEST} others"),
        ));
    }
    let attributes: Vec<(String, String)> = xml
        .attributes(element)
        .map(|(name, value)| (name.to_string(), value.into_owned()))
        .collect();
    // Paths of the outer elements tell enough.
    let shown = attributes
        .iter()
        .find(|(n, v)| (n == "id" || n == "name") && v.len() <= 30)
        .map_or_else(
            || element.name.to_string(),
            |(_, v)| format!("{}#{v}", element.name),
        );
    let path = match depth {
        0 => element.name.to_string(),
        1 => shown,
        _ => format!("{above}/{shown}"),
    };
    let mut node = Node {
        name: element.name.to_string(),
        line: xml.fail(element.at, String::new()).line,
        path,
        attributes,
        children: Vec::new(),
        file: file.clone(),
    };
    while let Some(child) = xml.next()? {
        let child = self::node(xml, child, &node.path, depth + 1, count, file)?;
        node.children.push(child);
    }
    Ok(node)
}

impl Node {
    /// Its children of this name.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Node> + 'a {
        self.children.iter().filter(move |c| c.name == name)
    }

    /// The first child of this name.
    pub fn child(&self, name: &str) -> Option<&Node> {
        self.children.iter().find(|c| c.name == name)
    }

    /// The element that a path of names leads to.
    pub fn at(&self, path: &[&str]) -> Option<&Node> {
        path.iter().try_fold(self, |node, name| node.child(name))
    }

    /// All elements within it of this name, however deep, outermost first.
    pub fn within<'a>(&'a self, name: &str) -> Vec<&'a Node> {
        let mut found = Vec::new();
        let mut open: Vec<&Node> = self.children.iter().rev().collect();
        while let Some(node) = open.pop() {
            if node.name == name {
                found.push(node);
            }
            open.extend(node.children.iter().rev());
        }
        found
    }

    /// An attribute.
    pub fn text(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(n, _)| n == name);
        found.map(|(_, value)| value.as_str())
    }

    /// The same, also for changing it.
    pub fn attributes_mut(&mut self) -> impl Iterator<Item = &mut String> {
        self.attributes.iter_mut().map(|(_, value)| value)
    }

    /// An attribute that must be there.
    pub fn needed(&self, name: &str) -> Result<&str, ReadError> {
        self.text(name)
            .ok_or_else(|| self.fail(format!("no attribute {name}")))
    }

    /// A finite number; nothing where the attribute is not there.
    pub fn number(&self, name: &str) -> Result<Option<f64>, ReadError> {
        let Some(text) = self.text(name) else {
            return Ok(None);
        };
        let value = text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
        let value = value.ok_or_else(|| {
            let shown: String = text.chars().take(40).collect();
            self.fail(format!("{name}=\"{shown}\" is not a number"))
        })?;
        match refused_coordinate(value) {
            Some(why) => Err(self.fail(format!("{name}: {why}"))),
            None => Ok(Some(value)),
        }
    }

    /// A number, 0 where the attribute is not there.
    pub fn or_zero(&self, name: &str) -> Result<f64, ReadError> {
        Ok(self.number(name)?.unwrap_or(0.0))
    }

    /// A number that must be there.
    pub fn needed_number(&self, name: &str) -> Result<f64, ReadError> {
        self.needed(name)?;
        self.or_zero(name)
    }

    /// An error about this element.
    pub fn fail(&self, message: impl Into<String>) -> ReadError {
        ReadError {
            file: self.file.to_string(),
            line: self.line,
            column: 0,
            element: self.path.clone(),
            message: message.into(),
        }
    }
}
