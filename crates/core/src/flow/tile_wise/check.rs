//! Consistency of the keys of a machine file.

use super::{FeatureSource, Fetch, TileWise};
use crate::machine::check::{Found, RECORD_MAX, SIZE_MAX};
use powergs_base::quantity::Bytes;
use powergs_frame::splat::Intersection;

/// The largest side of a sort group, pixels.
const SORT_GROUP_MAX: u32 = 512;

/// Adds what is wrong with keys that no unit has to itself.
pub(super) fn check(machine: &TileWise, found: &mut Found) {
    geometry(machine, found);
    pixels(machine, found);
    records(machine, found);
    colours(machine, found);
    features(machine, found);
    pitches(machine, found);
    sizes(machine, found);
    words(machine, found);
    if found.is_empty() {
        fits(machine, found);
    }
}

fn geometry(m: &TileWise, found: &mut Found) {
    let g = &m.geometry;
    let powers = [
        ("geometry.tile", g.tile),
        ("geometry.subtile", g.subtile),
        ("gsu.bsu-width", m.gsu.bsu_width),
    ];
    for (key, n) in powers.into_iter().filter(|(_, n)| !n.is_power_of_two()) {
        let (below, above) = (1 << n.ilog2(), n.next_power_of_two());
        found.add(key, format!("`{key}` = {n} must be a power of two: {below} or {above}"));
        found.ends_with(key, above);
    }
    if g.subtile > g.tile || !g.tile.is_multiple_of(g.subtile) {
        let message = format!(
            "`geometry.subtile` = {} does not divide `geometry.tile` = {}: a tile is a whole \
             number of sub-tiles",
            g.subtile, g.tile
        );
        found.add("geometry.subtile", message);
        if g.subtile > g.tile {
            found.ends_with("geometry.subtile", g.tile);
        }
    }
    let is_group = |n: u32| n.is_power_of_two() && (g.tile..=SORT_GROUP_MAX).contains(&n);
    if g.tile.is_power_of_two() && !is_group(g.sort_group) {
        let message = format!(
            "`geometry.sort-group` = {} must be `geometry.tile` = {} or a power of two above it, \
             at most {SORT_GROUP_MAX}: a group is a square of tiles",
            g.sort_group, g.tile
        );
        found.add("geometry.sort-group", message);
        found.ends_with("geometry.sort-group", g.tile);
    }
}

/// Pixels are tested by the units that test boxes.
fn pixels(m: &TileWise, found: &mut Found) {
    if m.pixels.filters() && m.geometry.test != Intersection::Aabb {
        let message = "`pixels.filter` contradicts `geometry.test`: the units that test boxes test \
                       pixels; set `geometry.test` = \"aabb\"";
        found.add("pixels.filter", message.to_owned());
        found.ends_with("pixels.filter", false);
    }
}

fn records(m: &TileWise, found: &mut Found) {
    let r = &m.record;
    let all = [
        ("record.position", r.position, 1),
        ("record.geometry", r.geometry, 0),
        ("record.colour", r.colour, 0),
        ("record.colour-extra", r.colour_extra, 0),
        ("record.projected", r.projected, 0),
        ("record.feature", r.feature, 1),
        ("record.pixel", r.pixel, 1),
        ("fovea.record", m.fovea.record, 0),
        ("fovea.feature", m.fovea.feature, 0),
    ];
    for (key, size, least) in all {
        if size < Bytes(least) {
            found.add(key, format!("`{key}` must be at least {} B", least));
        }
        if size > RECORD_MAX {
            found.add(key, format!("`{key}` = {size} is above {RECORD_MAX}: a typing error?"));
        }
    }
}

/// What of a colour record is not its coefficients is a part of it.
fn colours(m: &TileWise, found: &mut Found) {
    let r = &m.record;
    if r.colour_extra > r.colour {
        let message = format!(
            "`record.colour-extra` = {} is more than `record.colour` = {}: it is the part of it \
             that does not depend on the SH degree",
            r.colour_extra, r.colour
        );
        found.add("record.colour-extra", message);
    }
}

/// Records in DRAM do not overlap, and their addresses stay below 2^64.
fn pitches(m: &TileWise, found: &mut Found) {
    let r = &m.record;
    let all = [
        ("record.feature-pitch", r.feature_pitch, "record.feature", r.feature),
        ("record.colour-pitch", r.colour_pitch, "record.colour", r.colour),
    ];
    for (key, pitch, record, size) in all {
        if pitch < size || pitch == Bytes(0) {
            let message = format!("`{key}` = {pitch} must be at least `{record}` = {size}");
            found.add(key, message);
            found.ends_with(key, size);
        }
        if pitch > RECORD_MAX {
            found.add(key, format!("`{key}` = {pitch} is above {RECORD_MAX}: a typing error?"));
        }
    }
}

/// A word is a part of a bank: an access reads it whole.
fn words(m: &TileWise, found: &mut Found) {
    let keys = [
        "buffers.gaussian-in.word",
        "buffers.tile-list.word",
        "buffers.sorting.word",
        "buffers.feature.word",
        "buffers.pixel-out.word",
    ];
    let buffers = keys.into_iter().zip(m.buffers.all().map(|b| (b.word, b.capacity)));
    let b = &m.binning;
    let optional = [
        ("cache.word", m.cache.word, m.cache.capacity),
        ("binning.pointers.word", b.pointers.word, b.pointers.capacity),
        ("binning.combining.word", b.combining.word, b.combining.capacity),
    ];
    let optional = optional
        .into_iter()
        .filter(|(key, _, capacity)| capacity.0 > 0 && (*key != "cache.word" || m.cache.ways > 0));
    for (key, (word, capacity)) in buffers.chain(optional.map(|(key, w, c)| (key, (w, c)))) {
        if word == Bytes(0) || word > capacity {
            let message = format!("`{key}` = {word} must be from 1 B to the capacity, {capacity}");
            found.add(key, message);
            if word > capacity {
                found.ends_with(key, capacity);
            }
        }
    }
    for (key, size) in [
        ("cache.capacity", m.cache.capacity),
        ("binning.pointers.capacity", b.pointers.capacity),
        ("binning.combining.capacity", b.combining.capacity),
    ] {
        if size > SIZE_MAX {
            found.add(key, format!("`{key}` = {size} is above {SIZE_MAX}: a typing error?"));
        }
    }
}

fn sizes(m: &TileWise, found: &mut Found) {
    let keys = [
        "buffers.gaussian-in.capacity",
        "buffers.tile-list.capacity",
        "buffers.sorting.capacity",
        "buffers.feature.capacity",
        "buffers.pixel-out.capacity",
    ];
    for (key, size) in keys.into_iter().zip(m.buffers.all().map(|b| b.capacity)) {
        if size == Bytes(0) {
            found.add(key, format!("`{key}` must be above zero"));
        }
        if size > SIZE_MAX {
            found.add(key, format!("`{key}` = {size} is above {SIZE_MAX}: a typing error?"));
        }
    }
}

/// Least capacity of one buffer: bytes, and the reason.
struct Need {
    key: &'static str,
    capacity: Bytes,
    bytes: u128,
    because: String,
}

fn fits(m: &TileWise, found: &mut Found) {
    for need in needs(m).into_iter().filter(|n| u128::from(n.capacity.0) < n.bytes) {
        let shown = u64::try_from(need.bytes).map_or("more".into(), |b| Bytes(b).to_string());
        let message = format!(
            "`{}` = {} is too small: {} need {shown}; enlarge it or shrink one of them",
            need.key, need.capacity, need.because
        );
        found.add(need.key, message);
        if need.bytes <= u128::from(SIZE_MAX.0) {
            found.ends_with(need.key, Bytes(need.bytes as u64));
        }
    }
}

fn needs(m: &TileWise) -> Vec<Need> {
    let (g, r, b) = (&m.geometry, &m.record, &m.buffers);
    let product = |factors: &[u64]| factors.iter().map(|&n| u128::from(n)).product();
    let (cores, chunk) = (u64::from(m.vru.cores), u64::from(g.chunk));
    let (units, entry) = (u64::from(m.ccu.units), m.list_entry());
    let read = match m.ccu.fetch {
        Fetch::Everything | Fetch::GeometryFirst | Fetch::VisibleColour => {
            r.position + r.geometry + r.colour
        }
        Fetch::LazyColour => r.position + r.geometry,
    };
    vec![
        Need {
            key: "buffers.gaussian-in.capacity",
            capacity: b.gaussian_in.capacity,
            bytes: product(&[2, units, read.0]),
            because: format!(
                "two records per unit (2 x `ccu.units` {units} x {} B that `ccu.fetch` reads)",
                read.0
            ),
        },
        Need {
            key: "buffers.tile-list.capacity",
            capacity: b.tile_list.capacity,
            bytes: product(&[2, units, entry]),
            because: format!(
                "two entries per unit (2 x `ccu.units` {units} x entries of {entry} B: \
                 `record.entry-bitmap`, `record.id-bits`)"
            ),
        },
        Need {
            key: "buffers.sorting.capacity",
            capacity: b.sorting.capacity,
            bytes: product(&[cores, chunk, entry]),
            because: format!(
                "the list entries of one chunk per core (`vru.cores` {cores} x `geometry.chunk` \
                 {chunk} x entries of {entry} B: `record.entry-bitmap`, `record.id-bits`)"
            ),
        },
        Need {
            key: "buffers.feature.capacity",
            capacity: b.feature.capacity,
            bytes: product(&[2, cores, chunk, r.feature.0]),
            because: format!(
                "two chunks per core (2 x `vru.cores` {cores} x `geometry.chunk` {chunk} x \
                 `record.feature` {} B)",
                r.feature.0
            ),
        },
        Need {
            key: "buffers.pixel-out.capacity",
            capacity: b.pixel_out.capacity,
            bytes: product(&[2, cores, u64::from(g.subtile).pow(2), r.pixel.0])
                + product(&[cores, m.state_bytes().0]),
            because: format!(
                "two sub-tiles per core (2 x `vru.cores` {cores} x `geometry.subtile` {0} x {0} x \
                 `record.pixel` {1} B){2}",
                g.subtile,
                r.pixel.0,
                state(m)
            ),
        },
    ]
}

/// What the pixel state of tiles adds to a need; empty where the pixel buffer holds none.
fn state(m: &TileWise) -> String {
    match m.state_bytes() {
        Bytes(0) => String::new(),
        bytes => format!(
            " and the pixel state of a tile per core (`vru.impl` = \"{}\": {bytes}, \
             `vru.pixel-state` {} for each pixel of `geometry.tile` {2} x {2})",
            m.vru.implementation.name(),
            m.vru.pixel_state,
            m.geometry.tile
        ),
    }
}

/// Every byte that rendering reads was written by somebody, or the machine says that it was not.
fn features(m: &TileWise, found: &mut Found) {
    let r = &m.record;
    if r.feature_source == FeatureSource::Nobody {
        return;
    }
    if r.projected != r.feature {
        let message = format!(
            "`record.feature-source` = \"ccu\": a CCU writes `record.projected` = {} of a splat \
             and `record.feature` = {} are read: set both to the same, or \
             `record.feature-source` = \"nobody\"",
            r.projected, r.feature
        );
        found.add("record.feature-source", message);
        found.ends_with("record.projected", r.feature);
    }
}
