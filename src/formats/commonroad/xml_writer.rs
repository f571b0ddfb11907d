//! An XML writer: elements, leaves, references, numbers, points, the location of a scenario.

use std::borrow::Cow;

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::Location;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};

use super::elements::{UNKNOWN_DEGREES, UNKNOWN_ID};
use super::writer::WriteError;

pub(crate) type Attributes<'a> = [(&'a str, String)];

/// The XML being written.
pub(crate) struct XmlWriter {
    pub xml: Writer<Vec<u8>>,
}

impl XmlWriter {
    /// A document in UTF-8 that begins with its declaration.
    pub fn begun() -> Result<Self, WriteError> {
        let mut out = Self {
            xml: Writer::new_with_indent(Vec::new(), b' ', 2),
        };
        out.event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        Ok(out)
    }

    /// The document.
    pub fn finished(self) -> Vec<u8> {
        let mut bytes = self.xml.into_inner();
        bytes.push(b'\n');
        bytes
    }

    /// A remark; it must not have `--` in it.
    pub fn comment(&mut self, text: &str) -> Result<(), WriteError> {
        self.event(Event::Comment(BytesText::new(text)))
    }

    pub fn event(&mut self, event: Event<'_>) -> Result<(), WriteError> {
        Ok(self.xml.write_event(event)?)
    }

    pub fn start<'a>(name: &'a str, attributes: &'a Attributes<'a>) -> BytesStart<'a> {
        let mut start = BytesStart::new(name);
        for (key, value) in attributes {
            start.push_attribute((*key, &*allowed(value)));
        }
        start
    }

    pub fn element(
        &mut self,
        name: &str,
        attributes: &Attributes<'_>,
        inside: impl FnOnce(&mut Self) -> Result<(), WriteError>,
    ) -> Result<(), WriteError> {
        self.event(Event::Start(Self::start(name, attributes)))?;
        inside(self)?;
        self.event(Event::End(BytesEnd::new(name)))
    }

    pub fn empty(&mut self, name: &str, attributes: &Attributes<'_>) -> Result<(), WriteError> {
        self.event(Event::Empty(Self::start(name, attributes)))
    }

    pub fn leaf(&mut self, name: &str, text: &str) -> Result<(), WriteError> {
        self.event(Event::Start(BytesStart::new(name)))?;
        self.event(Event::Text(BytesText::new(&allowed(text))))?;
        self.event(Event::End(BytesEnd::new(name)))
    }

    pub fn references(&mut self, name: &str, ids: &[i64]) -> Result<(), WriteError> {
        ids.iter()
            .try_for_each(|id| self.empty(name, &[("ref", id.to_string())]))
    }
}

/// Text with the characters that XML has no place for, not even escaped, replaced.
pub(crate) fn allowed(text: &str) -> Cow<'_, str> {
    let forbidden = |c: char| {
        (c < ' ' && !matches!(c, '\t' | '\n' | '\r')) || matches!(c, '\u{fffe}' | '\u{ffff}')
    };
    if text.contains(forbidden) {
        Cow::Owned(text.replace(forbidden, "\u{fffd}"))
    } else {
        Cow::Borrowed(text)
    }
}

/// The shortest text that reads back as the same number; plain decimals, as the schema wants them.
pub(crate) fn number(value: f64) -> String {
    let text = value.to_string();
    if text.contains('.') {
        text
    } else {
        format!("{text}.0")
    }
}

pub(crate) fn id(id: i64) -> [(&'static str, String); 1] {
    [("id", id.to_string())]
}

pub(crate) fn point(
    out: &mut XmlWriter,
    at: &Point,
    height: Option<f64>,
) -> Result<(), WriteError> {
    out.element("point", &[], |out| {
        out.leaf("x", &number(at.x))?;
        out.leaf("y", &number(at.y))?;
        height.map_or(Ok(()), |z| out.leaf("z", &number(z)))
    })
}

/// The children of a location.
pub(super) fn write(out: &mut XmlWriter, location: &Location) -> Result<(), WriteError> {
    let id = location.geo_name_id.unwrap_or(UNKNOWN_ID);
    let degrees = |known: Option<f64>| number(known.unwrap_or(UNKNOWN_DEGREES));
    out.leaf("geoNameId", &id.to_string())?;
    out.leaf("gpsLatitude", &degrees(location.latitude))?;
    out.leaf("gpsLongitude", &degrees(location.longitude))?;
    if let Some(transformation) = &location.transformation {
        out.element("geoTransformation", &[], |out| {
            if let Some(reference) = &transformation.reference {
                out.leaf("geoReference", reference)?;
            }
            let parts = [
                ("xTranslation", transformation.x),
                ("yTranslation", transformation.y),
                ("zRotation", transformation.rotation),
                ("scaling", transformation.scaling),
            ];
            if parts.iter().all(|(_, value)| value.is_none()) {
                return Ok(());
            }
            out.element("additionalTransformation", &[], |out| {
                let mut said = parts
                    .iter()
                    .filter_map(|(name, value)| Some((name, (*value)?)));
                said.try_for_each(|(name, value)| out.leaf(name, &number(value)))
            })
        })?;
    }
    let Some(environment) = &location.environment else {
        return Ok(());
    };
    out.element("environment", &[], |out| {
        let words = [
            ("time", &environment.time),
            ("timeOfDay", &environment.time_of_day),
            ("weather", &environment.weather),
            ("underground", &environment.underground),
        ];
        let mut said = words
            .iter()
            .filter_map(|(name, word)| Some((name, word.as_ref()?)));
        said.try_for_each(|(name, word)| out.leaf(name, word))
    })
}
