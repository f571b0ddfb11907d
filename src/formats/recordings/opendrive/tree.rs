//! An XML document as a tree whose elements know their lines, and what of them was read.

use std::cell::Cell;
use std::rc::Rc;

use crate::commonroad::ReadError;
use crate::commonroad::xml::{Element, Xml, decoded};
use nearmiss_scene::scenario::plausibility::refused_coordinate;

/// An element with its attributes and children. Asking for one of them reads it: what was not asked for is
/// [unused](Node::unused).
#[derive(Debug, Clone, Default)]
pub struct Node {
    pub name: String,
    /// From 1.
    pub line: usize,
    /// Names of the elements around it, and its own.
    pub path: String,
    attributes: Vec<Attribute>,
    children: Vec<Node>,
    file: Rc<str>,
    is_read: Cell<bool>,
}

#[derive(Debug, Clone)]
struct Attribute {
    name: String,
    value: String,
    is_read: Cell<bool>,
}

/// No document has more elements.
const MOST_NODES: usize = 5_000_000;

/// No document is deeper.
const MAX_DEPTH: usize = 60;

/// Reads a document whose root has this name.
pub fn read(bytes: &[u8], file: &str, root: &str) -> Result<Node, ReadError> {
    let text = decoded(bytes, file)?;
    let mut xml = Xml::new(&text, file);
    let name: Rc<str> = file.into();
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
    file: &Rc<str>,
) -> Result<Node, ReadError> {
    *count += 1;
    if *count > MOST_NODES {
        return Err(xml.fail(element.at, format!("more than {MOST_NODES} elements")));
    }
    if depth > MAX_DEPTH {
        return Err(xml.fail(
            element.at,
            format!("elements within more than {MAX_DEPTH} others"),
        ));
    }
    let attributes: Vec<Attribute> = xml
        .attributes(element)
        .map(|(name, value)| Attribute {
            name: name.to_string(),
            value: value.into_owned(),
            is_read: Cell::new(false),
        })
        .collect();
    // Paths of the outer elements tell enough.
    let shown = attributes
        .iter()
        .find(|a| (a.name == "id" || a.name == "name") && a.value.len() <= 30)
        .map_or_else(
            || element.name.to_string(),
            |a| format!("{}#{}", element.name, a.value),
        );
    let path = match depth {
        0 => element.name.to_string(),
        1 => shown,
        _ => format!("{above}/{shown}"),
    };
    let mut node = Node {
        name: element.name.to_string(),
        line: xml.line_of(element.at),
        path,
        attributes,
        children: Vec::new(),
        file: file.clone(),
        is_read: Cell::new(false),
    };
    while let Some(child) = xml.next()? {
        let child = self::node(xml, child, &node.path, depth + 1, count, file)?;
        node.children.push(child);
    }
    Ok(node)
}

impl Attribute {
    /// Whether it is a label or a schema, or its value is that of an attribute that is not there: nothing, zero or false.
    fn tells_nothing(&self) -> bool {
        let value = self.value.trim();
        let is_label =
            self.name == "name" || self.name.starts_with("xmlns") || self.name.starts_with("xsi:");
        is_label || value.is_empty() || value == "false" || value.parse() == Ok(0.0)
    }
}

impl Node {
    /// Its children of this name.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Node> + 'a {
        let all = self.children.iter().filter(move |c| c.name == name);
        all.map(Node::read)
    }

    /// The first child of this name.
    pub fn child(&self, name: &str) -> Option<&Node> {
        self.first(|c| c.name == name)
    }

    /// The first child for which this holds.
    pub fn first(&self, holds: impl Fn(&Node) -> bool) -> Option<&Node> {
        self.children.iter().find(|c| holds(c)).map(Node::read)
    }

    /// Whether it has a child of this name, which is not read by that.
    pub fn has(&self, name: &str) -> bool {
        self.children.iter().any(|c| c.name == name)
    }

    /// All its children, whatever their names.
    pub fn children(&self) -> impl Iterator<Item = &Node> {
        self.children.iter().map(Node::read)
    }

    /// The element that a path of names leads to.
    pub fn at(&self, path: &[&str]) -> Option<&Node> {
        path.iter().try_fold(self, |node, name| node.child(name))
    }

    /// All elements within it of this name, however deep, outermost first; those around them count as read.
    pub fn within<'a>(&'a self, name: &str) -> Vec<&'a Node> {
        let mut found = Vec::new();
        let mut around: Vec<&Node> = Vec::new();
        let mut open: Vec<(&Node, usize)> = self.children.iter().rev().map(|c| (c, 0)).collect();
        while let Some((node, depth)) = open.pop() {
            around.truncate(depth);
            if node.name == name {
                around.iter().for_each(|n| n.is_read.set(true));
                found.push(node.read());
            }
            around.push(node);
            open.extend(node.children.iter().rev().map(|c| (c, depth + 1)));
        }
        found
    }

    fn read(&self) -> &Self {
        self.is_read.set(true);
        self
    }

    /// Takes it and all within it as read: it is known to hold nothing that a scenario has, or another file has it.
    pub fn skip(&self) {
        self.is_read.set(true);
        self.attributes.iter().for_each(|a| a.is_read.set(true));
        self.children.iter().for_each(Node::skip);
    }

    /// Elements and attributes within it that were not asked for, as `lane@direction` and `lane/userData`, with their lines; of
    /// an element that was not read, only the element. `groups` are names of elements that only hold others. Attributes
    /// that tell no more than their absence would are left out.
    pub fn unused(&self, groups: &[&str]) -> Vec<(String, usize)> {
        let mut all = Vec::new();
        let mut open = vec![self];
        while let Some(node) = open.pop() {
            let unread = node.attributes.iter().filter(|a| !a.is_read.get());
            let telling = unread.filter(|a| !a.tells_nothing());
            all.extend(telling.map(|a| (format!("{}@{}", node.name, a.name), node.line)));
            for child in node.children.iter().rev() {
                if child.is_read.get() || groups.contains(&child.name.as_str()) {
                    open.push(child)
                } else {
                    all.push((format!("{}/{}", node.name, child.name), child.line))
                }
            }
        }
        all.sort_by_key(|(_, line)| *line);
        all
    }

    /// Its first child of this name, alone.
    pub fn into_child(self, name: &str) -> Option<Self> {
        self.children.into_iter().find(|c| c.name == name)
    }

    /// Its children, alone.
    pub fn into_children(self) -> Vec<Self> {
        self.children
    }

    /// An attribute.
    pub fn text(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|a| a.name == name)?;
        found.is_read.set(true);
        Some(&found.value)
    }

    /// Takes these attributes as read.
    pub fn skip_attributes(&self, names: &[&str]) {
        let known = |a: &&Attribute| names.contains(&a.name.as_str());
        self.attributes
            .iter()
            .filter(known)
            .for_each(|a| a.is_read.set(true));
    }

    /// Whether an attribute has this value; it is read only then.
    pub fn takes(&self, name: &str, value: &str) -> bool {
        let found = self
            .attributes
            .iter()
            .find(|a| a.name == name)
            .filter(|a| a.value == value);
        found.map(|a| a.is_read.set(true)).is_some()
    }

    /// The values of its attributes and of those within it, for changing them.
    pub fn change_values(&mut self, change: &impl Fn(&str) -> Option<String>) {
        for attribute in &mut self.attributes {
            if let Some(changed) = change(&attribute.value) {
                attribute.value = changed;
            }
        }
        self.children
            .iter_mut()
            .for_each(|c| c.change_values(change));
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
        let value = text
            .trim()
            .parse::<f64>()
            .ok()
            .filter(|v| v.is_finite())
            .ok_or_else(|| {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_nobody_asked_for_is_unused() {
        let text = r#"<A one="1" zero="0.0" no="false" empty="" name="n" xmlns:x="y">
<B two="2"/>
<B two="2"><C three="3"><D four="4"/></C></B>
<E><F><G five="5"/></F></E>
<H/>
</A>"#;
        let root = read(text.as_bytes(), "x", "A").unwrap();
        let kinds = |root: &Node| -> Vec<String> {
            let all = root.unused(&["E"]).into_iter();
            all.map(|(kind, line)| format!("{line} {kind}")).collect()
        };
        assert_eq!(
            kinds(&root),
            ["1 A@one", "2 A/B", "3 A/B", "4 E/F", "5 A/H"]
        );
        assert!(root.has("H") && root.text("one").is_some());
        assert_eq!(root.all("B").count(), 2);
        assert_eq!(root.within("G").len(), 1);
        // Those around what was looked for count as read, those beside it do not.
        assert_eq!(
            kinds(&root),
            ["2 B@two", "3 B@two", "3 B/C", "4 G@five", "5 A/H"]
        );
        assert!(root.within("G")[0].takes("five", "5"));
        assert!(!root.within("D")[0].takes("four", "5"));
        assert_eq!(
            kinds(&root),
            ["2 B@two", "3 B@two", "3 C@three", "3 D@four", "5 A/H"]
        );
        root.skip();
        assert!(kinds(&root).is_empty());
    }

    #[test]
    fn reading_takes_as_much_longer_as_there_are_more_elements() {
        let seconds = |count: usize| {
            // On one line, as some programs write.
            let text = format!("<A>{}</A>", "<B one=\"1\"/>".repeat(count));
            let mut tries = (0..5).map(|_| {
                let begin = std::time::Instant::now();
                assert_eq!(
                    read(text.as_bytes(), "x", "A").unwrap().all("B").count(),
                    count
                );
                begin.elapsed().as_secs_f64()
            });
            let first = tries.next().unwrap();
            tries.fold(first, f64::min)
        };
        let ratio = seconds(32_000) / seconds(2_000);
        // 16 where it is linear, 256 where it is quadratic.
        assert!(ratio < 64.0, "{ratio}");
    }
}
