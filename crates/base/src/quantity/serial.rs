//! Quantities in files: read from and written as strings with their unit, described to editors as
//! such.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{
    Bytes, BytesPerSecond, Hertz, Nanometres, Nanoseconds, Picojoules, PicojoulesPerByte, Quantity,
    QuantityError, SquareMillimetres, Volts, Watts,
};

struct SerialText<Q>(PhantomData<Q>);

fn bare<Q: Quantity, E: Error>(text: String) -> E {
    E::custom(QuantityError::Bare { kind: Q::KIND, example: Q::EXAMPLE, text })
}

impl<Q: Quantity> Visitor<'_> for SerialText<Q> {
    type Value = Q;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} with its unit, e.g. \"{}\"", Q::KIND, Q::EXAMPLE)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Q, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_i64<E: Error>(self, n: i64) -> Result<Q, E> {
        Err(bare::<Q, E>(format!("the bare number {n}")))
    }

    fn visit_u64<E: Error>(self, n: u64) -> Result<Q, E> {
        Err(bare::<Q, E>(format!("the bare number {n}")))
    }

    fn visit_f64<E: Error>(self, n: f64) -> Result<Q, E> {
        Err(bare::<Q, E>(format!("the bare number {n}")))
    }
}

macro_rules! serial {
    ($($t:ident),*) => {$(
        impl<'de> Deserialize<'de> for $t {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.deserialize_any(SerialText(PhantomData))
            }
        }

        impl Serialize for $t {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl JsonSchema for $t {
            fn schema_name() -> Cow<'static, str> {
                stringify!($t).into()
            }

            fn inline_schema() -> bool {
                true
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                let units = Self::unit_names().replace(", ", "|");
                json_schema!({
                    "type": "string",
                    "pattern": format!("^ *[0-9]+(\\.[0-9]+)?([eE][+-]?[0-9]+)? *({units}) *$"),
                    "examples": [Self::EXAMPLE],
                    "x-unit": format!("{} ({})", Self::KIND, Self::unit_names()),
                })
            }
        }
    )*};
}
serial!(
    Bytes,
    BytesPerSecond,
    Hertz,
    Nanometres,
    Nanoseconds,
    Picojoules,
    PicojoulesPerByte,
    SquareMillimetres,
    Volts,
    Watts
);
