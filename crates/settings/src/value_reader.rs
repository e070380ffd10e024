//! Reads a parsed TOML document into the type that describes it.
//!
//! `toml` has a deserialiser, too. It gives the path of an error only as a text without the items of lists, and it is
//! compiled anew, with all kinds of values, for every type of settings: nearly half of the code of the crates that have many.
//! This one accepts only what a type asks for.

use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error as _, Expected, IntoDeserializer, MapAccess, SeqAccess,
    Unexpected, VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;
use toml::Spanned;
use toml::de::{DeInteger, DeString, DeValue};

use crate::fault::{Fault, Step};

/// One value of a document. Its faults get their place from the table or list that contains it.
#[derive(Clone, Copy)]
pub(crate) struct ValueReader<'a>(&'a DeValue<'a>);

type Entry<'a> = (&'a Spanned<DeString<'a>>, &'a Spanned<DeValue<'a>>);

impl<'a> ValueReader<'a> {
    pub(crate) fn new(value: &'a DeValue<'a>) -> Self {
        Self(value)
    }

    /// The fault of a value that is not of the kind that was asked for.
    fn mismatch(self, expected: &dyn Expected) -> Fault {
        let number;
        let found = match self.0 {
            DeValue::String(text) => Unexpected::Str(text),
            DeValue::Integer(digits) => match integer(digits) {
                Ok(Integer::Signed(value)) => Unexpected::Signed(value),
                Ok(Integer::Unsigned(value)) => Unexpected::Unsigned(value),
                Err(fault) => return fault,
            },
            DeValue::Float(digits) => {
                number = digits.as_str().parse().unwrap_or(f64::NAN);
                Unexpected::Float(number)
            }
            DeValue::Boolean(value) => Unexpected::Bool(*value),
            DeValue::Datetime(_) => Unexpected::Other("date"),
            DeValue::Array(_) => Unexpected::Seq,
            DeValue::Table(_) => Unexpected::Map,
        };
        Fault::invalid_type(found, expected)
    }

    fn number<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            DeValue::Integer(digits) => match integer(digits) {
                Ok(Integer::Signed(value)) => visitor.visit_i64(value),
                Ok(Integer::Unsigned(value)) => visitor.visit_u64(value),
                Err(fault) => Err(fault),
            },
            DeValue::Float(digits) => float(digits.as_str()).and_then(|value| visitor.visit_f64(value)),
            _ => Err(self.mismatch(&visitor)),
        }
    }

    fn text<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            DeValue::String(text) => visitor.visit_str(text),
            _ => Err(self.mismatch(&visitor)),
        }
    }

    fn items<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        let DeValue::Array(items) = self.0 else { return Err(self.mismatch(&visitor)) };
        let mut access = Items { items, next: 0 };
        let value = visitor.visit_seq(&mut access)?;
        access.all_read().map(|()| value)
    }

    fn entries<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        let DeValue::Table(table) = self.0 else { return Err(self.mismatch(&visitor)) };
        let mut entries = table.iter();
        let access = Entries { entries: &mut entries, value: None };
        visitor.visit_map(access)
    }
}

/// A whole number.
enum Integer {
    Signed(i64),
    /// Above the largest signed one.
    Unsigned(u64),
}

fn integer(digits: &DeInteger<'_>) -> Result<Integer, Fault> {
    let (text, radix) = (digits.as_str(), digits.radix());
    match (i64::from_str_radix(text, radix), u64::from_str_radix(text, radix)) {
        (Ok(value), _) => Ok(Integer::Signed(value)),
        (_, Ok(value)) => Ok(Integer::Unsigned(value)),
        _ => Err(Fault::custom(format_args!("the number {digits} has too many digits"))),
    }
}

fn float(digits: &str) -> Result<f64, Fault> {
    let value: f64 = digits.parse().map_err(|_| Fault::custom(format_args!("{digits} is not a number")))?;
    if value.is_infinite() && !digits.contains("inf") {
        return Err(Fault::custom(format_args!("the number {digits} is too large")));
    }
    Ok(value)
}

impl<'de> Deserializer<'de> for ValueReader<'_> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            DeValue::String(_) => self.text(visitor),
            DeValue::Integer(_) | DeValue::Float(_) => self.number(visitor),
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            DeValue::Datetime(date) => visitor.visit_string(date.to_string()),
            DeValue::Array(_) => self.items(visitor),
            DeValue::Table(_) => self.entries(visitor),
        }
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            _ => Err(self.mismatch(&visitor)),
        }
    }

    fn deserialize_i64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.number(visitor)
    }

    fn deserialize_u8<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.number(visitor)
    }

    fn deserialize_u16<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.number(visitor)
    }

    fn deserialize_u32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.number(visitor)
    }

    fn deserialize_u64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.number(visitor)
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.number(visitor)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.number(visitor)
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.text(visitor)
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.text(visitor)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.items(visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _length: usize, visitor: V) -> Result<V::Value, Fault> {
        self.items(visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.entries(visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        self.entries(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        let fault = || Fault::custom("expected a word or a table with one key");
        match self.0 {
            DeValue::String(text) => visitor.visit_enum(IntoDeserializer::<Fault>::into_deserializer(text.as_ref())),
            DeValue::Table(table) if table.len() == 1 => {
                visitor.visit_enum(OneEntry(table.iter().next().ok_or_else(fault)?))
            }
            _ => Err(fault()),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _name: &'static str, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_unit()
    }

    forward_to_deserialize_any! {
        i8 i16 i32 i128 u128 char bytes byte_buf unit unit_struct tuple_struct identifier
    }
}

/// The items of a list.
struct Items<'a> {
    items: &'a [Spanned<DeValue<'a>>],
    next: usize,
}

impl Items<'_> {
    fn all_read(&self) -> Result<(), Fault> {
        if self.next < self.items.len() {
            let expected = format!("{} items", self.next);
            return Err(Fault::invalid_length(self.items.len(), &expected.as_str()));
        }
        Ok(())
    }
}

impl<'de> SeqAccess<'de> for &mut Items<'_> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Fault> {
        let Some(item) = self.items.get(self.next) else { return Ok(None) };
        let index = self.next;
        self.next += 1;
        let read = seed.deserialize(ValueReader(item.get_ref()));
        read.map(Some).map_err(|fault| fault.at(item.span().start).within(Step::Index(index)))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.items.len() - self.next)
    }
}

/// The entries of a table.
struct Entries<'a, 'b> {
    entries: &'b mut dyn Iterator<Item = Entry<'a>>,
    value: Option<Entry<'a>>,
}

impl<'de> MapAccess<'de> for Entries<'_, '_> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        self.value = self.entries.next();
        let Some((key, _)) = self.value else { return Ok(None) };
        let text: &str = key.get_ref();
        seed.deserialize(text.into_deserializer()).map(Some).map_err(|fault: Fault| fault.at(key.span().start))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        let entry = self.value.take().ok_or_else(|| Fault::custom("a value was read before its key"))?;
        seed.deserialize(ValueReader(entry.1.get_ref())).map_err(|fault| located(fault, entry))
    }
}

/// A table with one entry: the variant of an enum and its content.
struct OneEntry<'a>(Entry<'a>);

impl<'de, 'a> EnumAccess<'de> for OneEntry<'a> {
    type Error = Fault;
    type Variant = Content<'a>;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Content<'a>), Fault> {
        let (key, _) = self.0;
        let text: &str = key.get_ref();
        let variant = seed.deserialize(text.into_deserializer()).map_err(|fault: Fault| fault.at(key.span().start))?;
        Ok((variant, Content(self.0)))
    }
}

/// The content of an enum's variant.
struct Content<'a>(Entry<'a>);

impl<'a> Content<'a> {
    fn read<T>(&self, read: impl FnOnce(ValueReader<'a>) -> Result<T, Fault>) -> Result<T, Fault> {
        read(ValueReader(self.0.1.get_ref())).map_err(|fault| located(fault, self.0))
    }
}

impl<'de> VariantAccess<'de> for Content<'_> {
    type Error = Fault;

    fn unit_variant(self) -> Result<(), Fault> {
        self.read(|value| Err(value.mismatch(&"no value")))
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Fault> {
        self.read(|value| seed.deserialize(value))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _length: usize, visitor: V) -> Result<V::Value, Fault> {
        self.read(|value| value.items(visitor))
    }

    fn struct_variant<V: Visitor<'de>>(self, _fields: &'static [&'static str], visitor: V) -> Result<V::Value, Fault> {
        self.read(|value| value.entries(visitor))
    }
}

/// The fault of the value of an entry, with its place.
fn located(fault: Fault, (key, value): Entry<'_>) -> Fault {
    fault.at(value.span().start).within(Step::key(key.get_ref()))
}

#[cfg(test)]
mod tests;
