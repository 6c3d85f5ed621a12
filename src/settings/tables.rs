//! Reads tables as tables only. Serde also takes a list for a struct, its fields in their order: a file of settings with
//! `weights = [1, 2, 3]` would set whatever comes first.

use core::fmt;

use serde::de::{
    Deserialize, DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, Error, MapAccess,
    SeqAccess, Unexpected, VariantAccess, Visitor,
};

/// Reads a TOML text, in which no list stands for a table.
///
/// # Errors
/// The text is no TOML, or not that of the type.
#[doc(hidden)]
pub fn read_toml<T: DeserializeOwned>(text: &str) -> Result<T, toml::de::Error> {
    T::deserialize(Tables(toml::Deserializer::parse(text)?))
}

/// As [`read_toml`], of a table that was read before.
pub(crate) fn read_table<T: DeserializeOwned>(table: toml::Table) -> Result<T, toml::de::Error> {
    T::deserialize(Tables(toml::Value::Table(table)))
}

/// Reads a JSON text, in which no list stands for an object.
///
/// # Errors
/// The text is no JSON, or not that of the type.
#[doc(hidden)]
pub fn read_json<'de, T: Deserialize<'de>>(text: &'de str) -> serde_json::Result<T> {
    let mut json = serde_json::Deserializer::from_str(text);
    let value = T::deserialize(Tables(&mut json))?;
    json.end()?;
    Ok(value)
}

/// A deserializer, or a part of one, whose structs are tables.
struct Tables<T>(T);

/// The visitor of a value; `is_struct` for one that serde also reads from a list.
struct TableVisitor<V> {
    visitor: V,
    is_struct: bool,
}

const fn of_any<V>(visitor: V) -> TableVisitor<V> {
    TableVisitor { visitor, is_struct: false }
}

const fn of_struct<V>(visitor: V) -> TableVisitor<V> {
    TableVisitor { visitor, is_struct: true }
}

macro_rules! forward_deserialize {
    ($($method:ident($($name:ident: $kind:ty),*) $visitor:ident;)+) => {$(
        fn $method<V: Visitor<'de>>(self, $($name: $kind,)* visitor: V) -> Result<V::Value, D::Error> {
            self.0.$method($($name,)* $visitor(visitor))
        }
    )+};
}

impl<'de, D: Deserializer<'de>> Deserializer<'de> for Tables<D> {
    type Error = D::Error;

    fn is_human_readable(&self) -> bool {
        self.0.is_human_readable()
    }

    forward_deserialize! {
        deserialize_any() of_any;
        deserialize_bool() of_any;
        deserialize_i8() of_any;
        deserialize_i16() of_any;
        deserialize_i32() of_any;
        deserialize_i64() of_any;
        deserialize_i128() of_any;
        deserialize_u8() of_any;
        deserialize_u16() of_any;
        deserialize_u32() of_any;
        deserialize_u64() of_any;
        deserialize_u128() of_any;
        deserialize_f32() of_any;
        deserialize_f64() of_any;
        deserialize_char() of_any;
        deserialize_str() of_any;
        deserialize_string() of_any;
        deserialize_bytes() of_any;
        deserialize_byte_buf() of_any;
        deserialize_option() of_any;
        deserialize_unit() of_any;
        deserialize_unit_struct(name: &'static str) of_any;
        deserialize_newtype_struct(name: &'static str) of_any;
        deserialize_seq() of_any;
        deserialize_tuple(len: usize) of_any;
        deserialize_tuple_struct(name: &'static str, len: usize) of_any;
        deserialize_map() of_any;
        deserialize_struct(name: &'static str, fields: &'static [&'static str]) of_struct;
        deserialize_enum(name: &'static str, variants: &'static [&'static str]) of_any;
        deserialize_identifier() of_any;
        deserialize_ignored_any() of_any;
    }
}

macro_rules! forward_visit {
    ($($method:ident: $kind:ty;)+) => {$(
        fn $method<E: Error>(self, value: $kind) -> Result<V::Value, E> {
            self.visitor.$method(value)
        }
    )+};
}

impl<'de, V: Visitor<'de>> Visitor<'de> for TableVisitor<V> {
    type Value = V::Value;

    fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
        self.visitor.expecting(out)
    }

    forward_visit! {
        visit_bool: bool;
        visit_i8: i8;
        visit_i16: i16;
        visit_i32: i32;
        visit_i64: i64;
        visit_i128: i128;
        visit_u8: u8;
        visit_u16: u16;
        visit_u32: u32;
        visit_u64: u64;
        visit_u128: u128;
        visit_f32: f32;
        visit_f64: f64;
        visit_char: char;
        visit_str: &str;
        visit_borrowed_str: &'de str;
        visit_string: String;
        visit_bytes: &[u8];
        visit_borrowed_bytes: &'de [u8];
        visit_byte_buf: Vec<u8>;
    }

    fn visit_none<E: Error>(self) -> Result<V::Value, E> {
        self.visitor.visit_none()
    }

    fn visit_unit<E: Error>(self) -> Result<V::Value, E> {
        self.visitor.visit_unit()
    }

    fn visit_some<D: Deserializer<'de>>(self, value: D) -> Result<V::Value, D::Error> {
        self.visitor.visit_some(Tables(value))
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(self, value: D) -> Result<V::Value, D::Error> {
        self.visitor.visit_newtype_struct(Tables(value))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<V::Value, A::Error> {
        if self.is_struct {
            return Err(Error::invalid_type(Unexpected::Seq, &self));
        }
        self.visitor.visit_seq(Tables(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<V::Value, A::Error> {
        self.visitor.visit_map(Tables(map))
    }

    fn visit_enum<A: EnumAccess<'de>>(self, data: A) -> Result<V::Value, A::Error> {
        self.visitor.visit_enum(Tables(data))
    }
}

impl<'de, S: DeserializeSeed<'de>> DeserializeSeed<'de> for Tables<S> {
    type Value = S::Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<S::Value, D::Error> {
        self.0.deserialize(Tables(deserializer))
    }
}

impl<'de, A: SeqAccess<'de>> SeqAccess<'de> for Tables<A> {
    type Error = A::Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, A::Error> {
        self.0.next_element_seed(Tables(seed))
    }

    fn size_hint(&self) -> Option<usize> {
        self.0.size_hint()
    }
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Tables<A> {
    type Error = A::Error;

    fn next_key_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, A::Error> {
        self.0.next_key_seed(Tables(seed))
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, A::Error> {
        self.0.next_value_seed(Tables(seed))
    }

    fn size_hint(&self) -> Option<usize> {
        self.0.size_hint()
    }
}

impl<'de, A: EnumAccess<'de>> EnumAccess<'de> for Tables<A> {
    type Error = A::Error;
    type Variant = Tables<A::Variant>;

    fn variant_seed<S: DeserializeSeed<'de>>(
        self,
        seed: S,
    ) -> Result<(S::Value, Self::Variant), A::Error> {
        let (value, variant) = self.0.variant_seed(Tables(seed))?;
        Ok((value, Tables(variant)))
    }
}

impl<'de, A: VariantAccess<'de>> VariantAccess<'de> for Tables<A> {
    type Error = A::Error;

    fn unit_variant(self) -> Result<(), A::Error> {
        self.0.unit_variant()
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, A::Error> {
        self.0.newtype_variant_seed(Tables(seed))
    }

    fn tuple_variant<V: Visitor<'de>>(self, len: usize, visitor: V) -> Result<V::Value, A::Error> {
        self.0.tuple_variant(len, of_any(visitor))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, A::Error> {
        self.0.struct_variant(fields, of_struct(visitor))
    }
}

#[cfg(test)]
mod tests {
    use crate::global::Heuristic;
    use crate::local::Weights;
    use crate::runtime::Config;

    use super::*;

    #[test]
    fn list_is_no_table() {
        for text in [
            "local.weights = [0.1, 0.2, 0.3, 0.4]",
            "[robot]\nlimits = [0.0, 1.0]",
            "robot = []",
            "global.heuristic = { theta = [30] }",
        ] {
            let error = read_toml::<Config>(text).expect_err(text);
            assert!(
                error.message().starts_with("invalid type: sequence, expected struct"),
                "{text}: {error}"
            );
            assert!(error.span().is_some(), "{text}");
            let table = text.parse().expect("TOML");
            assert!(read_table::<Config>(table).is_err(), "{text}");
        }
        assert!(read_json::<Weights>("[1, 2, 3, 4]").is_err());
        assert!(read_json::<Heuristic>("{\"theta\": [30]}").is_err());
    }

    #[test]
    fn tables_lists_and_words_are_read_as_before() {
        let text = Config::documented();
        assert_eq!(read_toml::<Config>(&text).ok(), Some(Config::default()));
        let json = "{\"theta\": {\"degrees\": 30}}";
        assert_eq!(read_json(json).ok(), Some(Heuristic::Theta { degrees: 30.0 }));
        assert!(read_json::<Weights>("{} {}").is_err());
    }
}
