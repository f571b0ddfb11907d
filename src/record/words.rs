//! Enumerations of words: strum derives the words, lists, options, files and the store take them from there.

/// Gives an enumeration that derives `strum::IntoStaticStr` and `strum::VariantArray` its list `ALL`, its word `name` and
/// the way back, `parse`; with a noun, options, files, schemas and [`fields`](mod@crate::fields) have the same words.
///
/// ```
/// use strum::{IntoStaticStr, VariantArray};
///
/// /// What the others do.
/// #[derive(Debug, Clone, Copy, PartialEq, IntoStaticStr, VariantArray)]
/// #[strum(serialize_all = "snake_case")]
/// enum Traffic {
///     AsRecorded,
///     Reactive,
/// }
/// nearmiss_record::named!(Traffic, "traffic");
///
/// assert_eq!(Traffic::ALL.map(Traffic::name), ["as_recorded", "reactive"]);
/// assert_eq!(Traffic::parse("reactive"), Some(Traffic::Reactive));
/// assert_eq!(serde_json::to_string(&Traffic::Reactive)?, "\"reactive\"");
/// # Ok::<(), serde_json::Error>(())
/// ```
#[macro_export]
macro_rules! named {
    ($type:ident) => {
        impl $type {
            /// Every one, in the order of lists.
            pub const ALL: [Self; <Self as $crate::strum::VariantArray>::VARIANTS.len()] =
                *<Self as $crate::strum::VariantArray>::VARIANTS
                    .first_chunk()
                    .expect("as many as there are");

            /// The word for it, in options, tables, documents and the store.
            #[must_use]
            pub fn name(self) -> &'static str {
                self.into()
            }

            /// The one after it; after the last one the first.
            #[must_use]
            pub fn next(self) -> Self {
                Self::ALL[(self as usize + 1) % Self::ALL.len()]
            }

            /// The one that this word is for.
            #[must_use]
            pub fn parse(word: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|one| one.name() == word)
            }
        }
    };
    ($type:ident, $noun:literal) => {
        $crate::named!($type);
        $crate::word!($type, $noun);

        impl std::str::FromStr for $type {
            type Err = String;

            fn from_str(word: &str) -> Result<Self, String> {
                <Self as $crate::fields::Word>::of_word(word)
            }
        }

        impl $crate::serde::Serialize for $type {
            fn serialize<S: $crate::serde::Serializer>(
                &self,
                serializer: S,
            ) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $type {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> Result<Self, D::Error> {
                let word = <String as $crate::serde::Deserialize>::deserialize(deserializer)?;
                word.parse().map_err($crate::serde::de::Error::custom)
            }
        }

        impl $crate::schemars::JsonSchema for $type {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($type).into()
            }

            fn json_schema(_: &mut $crate::schemars::SchemaGenerator) -> $crate::schemars::Schema {
                $crate::schemars::json_schema!({ "type": "string", "enum": Self::ALL.map(Self::name).as_slice() })
            }
        }
    };
}
