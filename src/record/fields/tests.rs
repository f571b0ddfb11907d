//! Tests of tables of fields.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use super::*;

/// Colours.
#[derive(Debug, Clone, Copy, PartialEq, strum::IntoStaticStr, strum::VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Colour {
    /// Red.
    Red,
    /// Blue.
    Blue,
}

crate::named!(Colour, "colour");

crate::fields! {
    /// A part.
    pub struct Part {
        "part" {
            /// Its share.
            share [required]: f64, Takes::Between(0.0, 1.0);
            /// Its seed.
            seed: u64 = 1;
            /// Its colour.
            colour [required]: Colour = Colour::Red;
        }
    }
}

crate::fields! {
    /// All kinds of fields.
    pub struct Kinds {
        "kinds" {
            /// A line
            /// of text.
            title: Option<String>;
            /// Colours.
            colours [required, grows]: Vec<Colour>;
            /// Heat, or several.
            heat: OneOrMore<f64>, Takes::Number(0.0, 2.0);
            /// Samples.
            samples: u32 = 1, Takes::Whole(1, 9);
            /// Length.
            length: Option<f64>, Takes::Above(0.0, 10.0), "m";
            /// Whether.
            whether: bool;
        }
        "below" {
            /// A part.
            part: Option<Part>;
            /// By name.
            named: BTreeMap<String, OneOrMore<String>>;
        }
    }
}

const FILE: &str = "title = \"T\"\ncolours = [\"red\", \"blue\", \"red\"]\nheat = [0, 0.5]\nlength = 2\nwhether = true\n\n\
    [part]\nshare = 0.5\nseed = 1\ncolour = \"red\"\n\n[named]\na = \"x\"\nb = [\"x\", \"y\"]\n";

fn read(text: &str) -> Result<Kinds, String> {
    let mut layers = Layers::default();
    layers.file("k.toml", text);
    layers.require();
    layers.read()
}

#[test]
fn a_file_is_read_and_written_and_read_the_same() {
    let kinds = read(FILE).unwrap();
    assert_eq!(kinds.colours, Colour::ALL);
    assert!(kinds.heat.is_axis() && kinds.heat.one().is_none());
    assert_eq!(
        kinds.part,
        Some(Part {
            share: 0.5,
            seed: 1,
            colour: Colour::Red
        })
    );
    assert_eq!(
        read(&kinds.to_toml()).unwrap(),
        kinds,
        "{}",
        kinds.to_toml()
    );
    let json = Json::Object(kinds.to_json());
    let table: Table = serde_json::from_value(json).unwrap();
    assert_eq!(Kinds::from_table(&table).unwrap(), kinds);
    assert_eq!(kinds.text("length").unwrap(), "2 m");
    assert_eq!(kinds.text("heat").unwrap(), "0, 0.5");
    assert_eq!(kinds.text("samples"), None, "it is the default");
    assert_eq!(Kinds::row("title").unwrap().doc(), "A line of text.");
}

#[test]
fn every_mistake_has_its_line_and_says_what_is_allowed() {
    let text = "colours = [\n\"red\",\n\"bleu\"]\nheat = [1, 3]\nsamples = 0\nlenght = 1\nlength = 0\nwhether = 1\npart = { seed = 2 }\n";
    let said = read(text).unwrap_err();
    let said: Vec<&str> = said.lines().collect();
    assert_eq!(
        said,
        [
            "k.toml:3: colours: unknown colour `bleu`; did you mean `blue`?",
            "k.toml:4: heat: 3: expected a number from 0 to 2, or a list of them",
            "k.toml:5: samples = 0: expected a whole number from 1 to 9",
            "k.toml:6: unknown key `lenght`; did you mean `length`?",
            "k.toml:7: length = 0: expected a number above 0, at most 10 m",
            "k.toml:8: whether = 1: expected true or false",
            "k.toml:9: part: share is missing: Its share.",
        ]
    );
    assert!(
        read("title = 1")
            .unwrap_err()
            .contains("colours is missing")
    );
    assert!(read("title = [").unwrap_err().starts_with("k.toml:1: "));
}

#[test]
fn what_is_said_later_holds() {
    let mut layers = Layers::<Kinds>::default();
    layers.fields(
        "config.toml: ",
        &Kinds {
            samples: 3,
            whether: true,
            ..Kinds::default()
        },
    );
    layers.file("k.toml", FILE);
    layers.word("--set colours", "colours", "blue");
    layers.word("--set heat", "heat", "0.7");
    layers.word("--set part.share", "part.share", "0.25");
    let kinds = layers.read().unwrap();
    assert_eq!((kinds.samples, kinds.whether), (3, true));
    assert_eq!(kinds.colours, [Colour::Blue]);
    assert_eq!(kinds.heat.one(), Some(0.7));
    assert_eq!(kinds.part.as_ref().unwrap().share, 0.25);
    assert_eq!(
        kinds.differences(&read(FILE).unwrap()),
        ["colours", "heat", "samples", "part"]
    );
    layers.word("--set samples", "samples", "many");
    layers.word("--set x", "x", "1");
    assert_eq!(
        layers.read().unwrap_err(),
        "--set x: unknown key `x`; available: title, colours, heat, samples, length, whether, part, named\n\
         --set samples = \"many\": expected a whole number from 1 to 9"
    );
}

#[test]
fn the_schema_says_what_is_read() {
    let schema = Kinds::json_schema();
    let properties = &schema["properties"];
    assert_eq!(properties["samples"]["maximum"], 9);
    assert_eq!(
        properties["colours"]["items"]["enum"],
        serde_json::json!(["red", "blue"])
    );
    assert_eq!(
        properties["part"]["required"],
        serde_json::json!(["share", "colour"])
    );
    assert_eq!(schema["required"], serde_json::json!(["colours"]));
}
