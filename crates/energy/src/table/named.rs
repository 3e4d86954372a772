//! Prices by the name of what they are for: which names there are is what stages declare.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value, json};

use super::keys::{AreaPrice, Overhead, RestArea};
use super::parts::PartShare;
use crate::hardware::{Catalogue, Does};

/// Which names a table has.
pub trait Names: 'static {
    /// Each with what it is the price of.
    fn names() -> Vec<(String, String)>;
}

/// Work of all units.
pub struct Works<C>(PhantomData<C>);

/// Units of all kinds that have prices of their own.
pub struct Units<C>(PhantomData<C>);

impl<C: Catalogue> Names for Works<C> {
    fn names() -> Vec<(String, String)> {
        let name = |does| match does {
            Does::Work(_, work) => Some((work.key.to_owned(), work.means.to_owned())),
            _ => None,
        };
        C::hardware().actions().filter_map(|(_, does)| name(does)).collect()
    }
}

impl<C: Catalogue> Names for Units<C> {
    fn names() -> Vec<(String, String)> {
        let units = C::hardware().units().filter(|(_, unit)| unit.counted_in.is_none());
        units
            .map(|(_, unit)| (unit.key.to_owned(), format!("One of the {}.", unit.words)))
            .collect()
    }
}

/// A table with a key for each of some names, none of which has to be there.
pub struct Named<N, V> {
    all: BTreeMap<String, V>,
    names: PhantomData<fn() -> N>,
}

impl<N, V> From<BTreeMap<String, V>> for Named<N, V> {
    fn from(all: BTreeMap<String, V>) -> Self {
        Named { all, names: PhantomData }
    }
}

impl<N, V> FromIterator<(String, V)> for Named<N, V> {
    fn from_iter<I: IntoIterator<Item = (String, V)>>(all: I) -> Self {
        Named::from(all.into_iter().collect::<BTreeMap<_, _>>())
    }
}

impl<N, V> Deref for Named<N, V> {
    type Target = BTreeMap<String, V>;

    fn deref(&self) -> &BTreeMap<String, V> {
        &self.all
    }
}

impl<N, V> DerefMut for Named<N, V> {
    fn deref_mut(&mut self) -> &mut BTreeMap<String, V> {
        &mut self.all
    }
}

impl<N, V: fmt::Debug> fmt::Debug for Named<N, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.all.fmt(f)
    }
}

impl<N, V: Clone> Clone for Named<N, V> {
    fn clone(&self) -> Self {
        Named::from(self.all.clone())
    }
}

impl<N, V: PartialEq> PartialEq for Named<N, V> {
    fn eq(&self, other: &Self) -> bool {
        self.all == other.all
    }
}

impl<N, V: Serialize> Serialize for Named<N, V> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.all.serialize(to)
    }
}

impl<'de, N, V: Deserialize<'de>> Deserialize<'de> for Named<N, V> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        BTreeMap::deserialize(from).map(Named::from)
    }
}

impl<N: Names, V: JsonSchema> JsonSchema for Named<N, V> {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        format!("{}_by_name", V::schema_name()).into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let each = N::names().into_iter();
        object(each.map(|(key, means)| (key, described::<V>(generator, &means))), &[])
    }
}

/// The schema of `T` with another description.
fn described<T: JsonSchema>(generator: &mut SchemaGenerator, means: &str) -> Value {
    let mut schema = generator.subschema_for::<T>().to_value();
    if let Some(object) = schema.as_object_mut() {
        object.insert("description".to_owned(), means.into());
    }
    schema
}

/// The schema of a table with these keys and no others.
fn object(keys: impl Iterator<Item = (String, Value)>, required: &[&str]) -> Schema {
    let keys: Map<String, Value> = keys.collect();
    let mut schema = json!({ "type": "object", "properties": keys, "additionalProperties": false });
    if !required.is_empty() {
        schema["required"] = required.into();
    }
    Schema::try_from(schema).expect("an object is a schema")
}

/// The `[area]` table, per unit; buffers come from `[sram]`.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitArea<C> {
    /// One unit of each kind.
    pub units: Named<Units<C>, AreaPrice>,
    /// Factor on the areas of `[sram]`: what a macro takes beyond its cells and periphery.
    pub sram_overhead: Overhead,
    /// Everything that is neither unit nor buffer.
    pub rest: RestArea,
}

const SRAM_OVERHEAD: &str = "sram-overhead";
const REST: &str = "rest";

impl<C> Serialize for UnitArea<C> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(self.units.len() + 2))?;
        for (unit, price) in self.units.iter() {
            map.serialize_entry(unit, price)?;
        }
        map.serialize_entry(SRAM_OVERHEAD, &self.sram_overhead)?;
        map.serialize_entry(REST, &self.rest)?;
        map.end()
    }
}

/// Takes a table key by key, so that errors know their place.
struct Keys<T, F>(&'static str, PhantomData<T>, F);

/// What takes the value of a key out of a table.
trait TakeKey<'de, T> {
    fn take<A: MapAccess<'de>>(&mut self, key: String, map: &mut A) -> Result<(), A::Error>;
    fn end<E: serde::de::Error>(self) -> Result<T, E>;
}

impl<'de, T, F: TakeKey<'de, T>> Visitor<'de> for Keys<T, F> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut map: A) -> Result<T, A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            self.2.take(key, &mut map)?;
        }
        self.2.end()
    }
}

#[derive(Default)]
struct AreaKeys {
    units: BTreeMap<String, AreaPrice>,
    sram_overhead: Option<Overhead>,
    rest: Option<RestArea>,
}

impl<'de, C> TakeKey<'de, UnitArea<C>> for AreaKeys {
    fn take<A: MapAccess<'de>>(&mut self, key: String, map: &mut A) -> Result<(), A::Error> {
        match key.as_str() {
            SRAM_OVERHEAD => self.sram_overhead = Some(map.next_value()?),
            REST => self.rest = Some(map.next_value()?),
            _ => _ = self.units.insert(key, map.next_value()?),
        }
        Ok(())
    }

    fn end<E: serde::de::Error>(self) -> Result<UnitArea<C>, E> {
        let missing = E::missing_field;
        Ok(UnitArea {
            units: Named::from(self.units),
            sram_overhead: self.sram_overhead.ok_or_else(|| missing(SRAM_OVERHEAD))?,
            rest: self.rest.ok_or_else(|| missing(REST))?,
        })
    }
}

impl<'de, C> Deserialize<'de> for UnitArea<C> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_map(Keys("areas", PhantomData, AreaKeys::default()))
    }
}

impl<C: Catalogue> JsonSchema for UnitArea<C> {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "UnitArea".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let units = Units::<C>::names();
        let mut keys: Vec<(String, Value)> = Vec::new();
        for (key, means) in units {
            keys.push((key, described::<AreaPrice>(generator, &means)));
        }
        let means = "Factor on the areas of `[sram]`: what a macro takes beyond its cells and \
                     periphery.";
        keys.push((SRAM_OVERHEAD.into(), described::<Overhead>(generator, means)));
        let means = "Everything that is neither unit nor buffer.";
        keys.push((REST.into(), described::<RestArea>(generator, means)));
        let mut schema = object(keys.into_iter(), &[SRAM_OVERHEAD, REST]);
        schema.insert(
            "description".into(),
            "The `[area]` table, per unit; buffers come from `[sram]`.".into(),
        );
        schema
    }
}

/// The `[parts]` table: what units consist of.
#[derive(Debug, Clone, PartialEq)]
pub struct Parts<C> {
    /// By stage and part.
    pub shares: BTreeMap<String, BTreeMap<String, PartShare>>,
    /// By stages whose area and leakage are counted in the part of another one: those of one of
    /// theirs, over one of the others.
    pub factors: BTreeMap<String, Overhead>,
    catalogue: PhantomData<fn() -> C>,
}

impl<C> Serialize for Parts<C> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(self.shares.len() + self.factors.len()))?;
        for (stage, shares) in &self.shares {
            map.serialize_entry(stage, shares)?;
        }
        for (stage, factor) in &self.factors {
            map.serialize_entry(stage, factor)?;
        }
        map.end()
    }
}

/// Whether a stage has a factor in `[parts]` in place of shares.
fn is_factor<C: Catalogue>(stage: &str) -> bool {
    let mut stages = C::hardware().stages();
    stages.any(|(_, facts)| facts.key == stage && facts.counted_in.is_some())
}

struct PartKeys<C>(Parts<C>);

impl<'de, C: Catalogue> TakeKey<'de, Parts<C>> for PartKeys<C> {
    fn take<A: MapAccess<'de>>(&mut self, key: String, map: &mut A) -> Result<(), A::Error> {
        match is_factor::<C>(&key) {
            true => _ = self.0.factors.insert(key, map.next_value()?),
            false => _ = self.0.shares.insert(key, map.next_value()?),
        }
        Ok(())
    }

    fn end<E: serde::de::Error>(self) -> Result<Parts<C>, E> {
        Ok(self.0)
    }
}

impl<'de, C: Catalogue> Deserialize<'de> for Parts<C> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let (shares, factors) = (BTreeMap::new(), BTreeMap::new());
        let none = Parts { shares, factors, catalogue: PhantomData };
        from.deserialize_map(Keys("parts of units", PhantomData, PartKeys(none)))
    }
}

impl<C: Catalogue> JsonSchema for Parts<C> {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Parts".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let hardware = C::hardware();
        let mut keys: Vec<(String, Value)> = Vec::new();
        for (id, stage) in hardware.stages() {
            if let Some((other, part)) = stage.counted_in {
                let means = format!(
                    "Area and leakage of one of `{part}` of the {}, over one of \
                     `parts.{other}.{part}`.",
                    stage.words
                );
                keys.push((stage.key.to_owned(), described::<Overhead>(generator, &means)));
                continue;
            }
            let own: Vec<_> = hardware.parts().filter(|(_, of, _)| *of == id).collect();
            if own.is_empty() {
                continue;
            }
            let mut shares: Vec<(String, Value)> = Vec::new();
            for (_, _, part) in own {
                shares.push((part.key.to_owned(), described::<PartShare>(generator, part.means)));
            }
            let mut table = object(shares.into_iter(), &[]).to_value();
            table["description"] = format!("Of the {}.", stage.words).into();
            keys.push((stage.key.to_owned(), table));
        }
        let mut schema = object(keys.into_iter(), &[]);
        schema.insert("description".into(), "The `[parts]` table.".into());
        schema
    }
}
