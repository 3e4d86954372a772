//! Consistency of the keys of a machine file.

mod binning;

use super::{
    FeatureSource, Fetch, GsuImpl, Overlap, PixelSource, StereoImpl, Termination, TileWise, VruImpl,
};
use crate::machine::check::{Contradiction, Found, RECORD_MAX, SIZE_MAX};
use crate::workload::STORAGE_BLOCK;
use powergs_base::quantity::Bytes;
use powergs_frame::scene::ShDegree;
use powergs_frame::splat::Intersection;

/// The largest side of a sort group, pixels.
const SORT_GROUP_MAX: u32 = 512;

/// Every contradiction.
pub(super) fn problems(machine: &TileWise) -> Vec<Contradiction> {
    let mut found = Found::default();
    geometry(machine, &mut found);
    records(machine, &mut found);
    colours(machine, &mut found);
    features(machine, &mut found);
    numbers(machine, &mut found);
    pitches(machine, &mut found);
    sizes(machine, &mut found);
    words(machine, &mut found);
    order(machine, &mut found);
    kept_lists(machine, &mut found);
    organisation(machine, &mut found);
    late_colours(machine, &mut found);
    stereo(machine, &mut found);
    pixels(machine, &mut found);
    gradients(machine, &mut found);
    clusters(machine, &mut found);
    binning::check(machine, &mut found);
    codebook(machine, &mut found);
    if found.is_empty() {
        fits(machine, &mut found);
    }
    found.all()
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

/// Units that are divided over sub-tiles, or go from one to the next.
fn organisation(m: &TileWise, found: &mut Found) {
    let (g, vru) = (&m.geometry, &m.vru);
    if g.subtile == 0 || g.tile < g.subtile {
        return;
    }
    let (units, subtiles) = (vru.units_per_core, g.subtiles());
    lanes(m, found);
    let is_divided = matches!(vru.implementation, VruImpl::Parallel | VruImpl::Leaders);
    if is_divided && !units.is_multiple_of(subtiles) {
        let message = format!(
            "`vru.impl` = \"{}\" divides `vru.units-per-core` = {units} over \
             the {subtiles} sub-tiles of a tile (`geometry.tile` = {}, `geometry.subtile` = {}): \
             it must be a multiple of {subtiles}",
            vru.implementation.name(),
            g.tile,
            g.subtile
        );
        found.add("vru.units-per-core", message);
        found.ends_with("vru.units-per-core", units.next_multiple_of(subtiles));
    }
    if vru.implementation == VruImpl::Scan
        && matches!(vru.termination, Termination::Tile | Termination::None)
    {
        let message = format!(
            "`vru.impl` = \"scan\" contradicts `vru.termination` = \"{}\": units that scan one \
             sub-tile after the other stop with the sub-tile; set `vru.termination` = \"subtile\"",
            vru.termination.name()
        );
        found.add("vru.impl", message);
        found.ends_with("vru.termination", "subtile");
    }
    if vru.termination == Termination::Pixel
        && vru.implementation.has_subtiles()
        && vru.pixels_per_unit != 4
    {
        let message = format!(
            "`vru.termination` = \"pixel\" contradicts `vru.pixels-per-unit` = {}: pixels stop one \
             by one in units that rotate through 2x2 of them; set `vru.pixels-per-unit` = 4 or \
             `vru.termination` = \"subtile\"",
            vru.pixels_per_unit
        );
        found.add("vru.termination", message);
        found.ends_with("vru.pixels-per-unit", 4);
    }
    if !(1..=RECORD_MAX.0).contains(&vru.pixel_state.0) {
        let message = format!(
            "`vru.pixel-state` = {} must be from 1 B to {RECORD_MAX}: transmittance and colour of \
             a pixel",
            vru.pixel_state
        );
        found.add("vru.pixel-state", message);
    }
}

/// Without an order nothing is known to be hidden.
fn order(m: &TileWise, found: &mut Found) {
    let (gsu, vru) = (&m.gsu, &m.vru);
    if !gsu.sorts() && vru.termination != Termination::None {
        let message = format!(
            "`gsu.impl` = \"none\" contradicts `vru.termination` = \"{}\": without an order no \
             pixel knows that the rest is hidden; set `vru.termination` = \"none\"",
            vru.termination.name()
        );
        found.add("gsu.impl", message);
        found.ends_with("vru.termination", "none");
    }
    let g = &m.geometry;
    if !gsu.sorts() && g.sort_group != g.tile {
        let message = format!(
            "`gsu.impl` = \"none\" contradicts `geometry.sort-group` = {}: nobody looks through \
             the list of a group; set `geometry.sort-group` = {}",
            g.sort_group, g.tile
        );
        found.add("gsu.impl", message);
        found.ends_with("geometry.sort-group", g.tile);
    }
}

/// Lists that frames take over as they are.
fn kept_lists(m: &TileWise, found: &mut Found) {
    if !m.gsu.keeps_lists() {
        return;
    }
    let mut excludes = |key: &'static str, value: String, remedy: &str, set: String| {
        let message = format!(
            "`gsu.impl` = \"{}\" contradicts `{key}` = {value}: {remedy}; set `{key}` = {set}, or \
             `gsu.impl` = \"merge\"",
            m.gsu.implementation.name()
        );
        found.add("gsu.impl", message);
        found.ends_with("gsu.impl", "merge");
    };
    let g = &m.geometry;
    if g.sort_group != g.tile {
        let remedy = "lists are kept tile by tile";
        excludes("geometry.sort-group", g.sort_group.to_string(), remedy, g.tile.to_string());
    }
    if m.record.entry_bitmap {
        let remedy = "sub-tiles of the frame before would be those of splats that have moved";
        excludes("record.entry-bitmap", "true".to_owned(), remedy, "false".to_owned());
    }
    if m.fovea.accumulators > 0 {
        let remedy = "how levels are kept is not known";
        excludes("fovea.accumulators", m.fovea.accumulators.to_string(), remedy, "0".to_owned());
    }
}

/// Bounds that are tested before records are read.
fn clusters(m: &TileWise, found: &mut Found) {
    let (size, bytes) = (m.ccu.clusters, m.ccu.cluster);
    let block = STORAGE_BLOCK as u32;
    if !size.is_multiple_of(block) {
        let message = format!(
            "`ccu.clusters` = {size} must be a multiple of {block}, or 0 for none: who survives is \
             known of {block} Gaussians together"
        );
        found.add("ccu.clusters", message);
        found.ends_with("ccu.clusters", size.next_multiple_of(block));
    }
    if size > 0 && !(1..=RECORD_MAX.0).contains(&bytes.0) {
        let message = format!("`ccu.cluster` = {bytes} must be from 1 B to {RECORD_MAX}");
        found.add("ccu.cluster", message);
    }
    if size > 0 && m.stereo.implementation == StereoImpl::Shared {
        let message = format!(
            "`ccu.clusters` = {size} contradicts `stereo.impl` = \"shared\": the second eye goes \
             through what the first one has converted, not through the scene; set `ccu.clusters` \
             = 0, or `stereo.impl` = \"separate\""
        );
        found.add("ccu.clusters", message);
        found.ends_with("ccu.clusters", 0);
    }
}

/// Second views that are made of first ones.
fn stereo(m: &TileWise, found: &mut Found) {
    let (way, buffer) = (m.stereo.implementation, &m.stereo.buffer);
    if way == StereoImpl::Separate {
        return;
    }
    let mut excludes = |key: &'static str, value: String, remedy: &str, set: &str| {
        let message = format!(
            "`stereo.impl` = \"{}\" contradicts `{key}` = {value}: {remedy}; set `{key}` = {set}, \
             or `stereo.impl` = \"separate\"",
            way.name()
        );
        found.add("stereo.impl", message);
        found.ends_with("stereo.impl", "separate");
    };
    if m.fovea.accumulators > 0 {
        let remedy = "how levels are handed on is not known";
        excludes("fovea.accumulators", m.fovea.accumulators.to_string(), remedy, "0");
    }
    if m.gsu.implementation == GsuImpl::Update || m.gsu.keeps_lists() {
        let remedy = "an order is kept for each eye, and the second one has none";
        excludes("gsu.impl", format!("\"{}\"", m.gsu.implementation.name()), remedy, "\"split\"");
    }
    if m.ccu.fetch != Fetch::VisibleColour {
        let remedy = "both eyes have the colours that were converted before sorting";
        let value = serde_json::to_string(&m.ccu.fetch).unwrap_or_default();
        excludes("ccu.fetch", value, remedy, "\"visible-colour\"");
    }
    let is_wrong = buffer.word == Bytes(0) || buffer.word > buffer.capacity;
    if way == StereoImpl::Derived && is_wrong {
        let message = format!(
            "`stereo.buffer.word` = {} must be from 1 B to the capacity, {}",
            buffer.word, buffer.capacity
        );
        found.add("stereo.buffer.word", message);
    }
    if buffer.capacity > SIZE_MAX {
        let message = format!("`stereo.buffer.capacity` = {} is above {SIZE_MAX}", buffer.capacity);
        found.add("stereo.buffer.capacity", message);
    }
}

/// Pixels that are not rendered.
fn pixels(m: &TileWise, found: &mut Found) {
    let (p, g) = (&m.pixels, &m.geometry);
    if p.source == PixelSource::All {
        return;
    }
    let mut excludes = |key: &'static str, value: String, remedy: &str, set: String| {
        let message = format!(
            "`pixels.impl` = \"{}\" contradicts `{key}` = {value}: {remedy}; set `{key}` = {set}, \
             or `pixels.impl` = \"all\"",
            p.source.name()
        );
        found.add("pixels.impl", message);
        found.ends_with("pixels.impl", "all");
    };
    let quoted = |name: &str| format!("\"{name}\"");
    if m.fovea.accumulators > 0 {
        let remedy = "pixels of a foveated frame have two levels";
        excludes("fovea.accumulators", m.fovea.accumulators.to_string(), remedy, "0".into());
    }
    if m.stereo.implementation != StereoImpl::Separate {
        let remedy = "the second eye needs all that blends in the first one";
        let value = quoted(m.stereo.implementation.name());
        excludes("stereo.impl", value, remedy, quoted("separate"));
    }
    if g.sort_group != g.tile {
        let remedy = "tiles that are not rendered have no part in the list of a group";
        excludes("geometry.sort-group", g.sort_group.to_string(), remedy, g.tile.to_string());
    }
    if m.vru.termination == Termination::None {
        let remedy = "pixels that never stop do not know what they see first";
        excludes("vru.termination", quoted("none"), remedy, quoted("subtile"));
    }
    let keeps = m.gsu.keeps_lists() && p.source != PixelSource::Cached;
    if m.gsu.implementation == GsuImpl::Update || keeps {
        let remedy = "a list that is kept is that of a tile which is rendered in each frame";
        excludes("gsu.impl", quoted(m.gsu.implementation.name()), remedy, quoted("split"));
    }
    if p.source == PixelSource::Cached && !p.region.is_multiple_of(g.tile) {
        let message = format!(
            "`pixels.region` = {} is no multiple of `geometry.tile` = {}: a tile is in one region",
            p.region, g.tile
        );
        found.add("pixels.region", message);
        found.ends_with("pixels.region", p.region.next_multiple_of(g.tile));
    }
    if p.source == PixelSource::Warped && p.period == 0 {
        let message = "`pixels.period` = 0: the first frame is rendered whole; 1 renders all, 5 \
                       one in five";
        found.add("pixels.period", message.to_owned());
        found.ends_with("pixels.period", 5);
    }
    if !(0.0..=1.0).contains(&p.holes) {
        found.add("pixels.holes", format!("`pixels.holes` = {} must be from 0 to 1", p.holes));
    }
    for (key, bytes) in [("pixels.depth", p.depth), ("pixels.entry", p.entry)] {
        if !(1..=RECORD_MAX.0).contains(&bytes.0) {
            found.add(key, format!("`{key}` = {bytes} must be from 1 B to {RECORD_MAX}"));
        }
    }
    let b = &p.buffer;
    let least = match p.source {
        PixelSource::Cached => p.entry.0.saturating_mul(p.ways.into()),
        _ => 1,
    };
    if p.source.has_unit() && (b.capacity.0 < least || b.capacity > SIZE_MAX) {
        let message = format!(
            "`pixels.buffer.capacity` = {} must be from {}, a set of the cache, to {SIZE_MAX}",
            b.capacity,
            Bytes(least)
        );
        found.add("pixels.buffer.capacity", message);
    }
    if p.source.has_unit() && !(1..=b.capacity.0).contains(&b.word.0) {
        let message = format!(
            "`pixels.buffer.word` = {} must be from 1 B to the capacity, {}",
            b.word, b.capacity
        );
        found.add("pixels.buffer.word", message);
    }
}

/// Steps of training.
fn gradients(m: &TileWise, found: &mut Found) {
    if m.pixels.filters() && m.geometry.test != Intersection::Aabb {
        let message = "`pixels.filter` contradicts `geometry.test`: the units that test boxes test \
                       pixels; set `geometry.test` = \"aabb\"";
        found.add("pixels.filter", message.to_owned());
        found.ends_with("pixels.filter", false);
    }
    let (t, g) = (&m.training, &m.gradients);
    if t.interval == 0 {
        return;
    }
    let mut excludes = |key: &'static str, value: String, remedy: &str, set: &str| {
        let message = format!(
            "`training.interval` = {} contradicts `{key}` = {value}: {remedy}; set `{key}` = \
             {set}, or `training.interval` = 0",
            t.interval
        );
        found.add("training.interval", message);
        found.ends_with("training.interval", 0);
    };
    let quoted = |name: &str| format!("\"{name}\"");
    if m.stereo.implementation != StereoImpl::Separate {
        let value = quoted(m.stereo.implementation.name());
        excludes("stereo.impl", value, "a step has one view", "\"separate\"");
    }
    if !matches!(m.pixels.source, PixelSource::All | PixelSource::Sampled) {
        let value = quoted(m.pixels.source.name());
        excludes("pixels.impl", value, "pixels without blends have no gradients", "\"all\"");
    }
    if m.schedule.overlap == Overlap::Frames {
        let remedy = "a step begins with what the one before has updated";
        excludes("schedule.overlap", quoted("frames"), remedy, "\"tiles\"");
    }
    if m.gsu.keeps_lists() || m.gsu.period() > 1 || !m.gsu.sorts() {
        let remedy = "a step goes through lists of its own, in depth order";
        excludes("gsu.impl", quoted(m.gsu.implementation.name()), remedy, "\"split\"");
    }
    if m.vru.termination == Termination::None {
        excludes("vru.termination", quoted("none"), "gradients need an order", "\"subtile\"");
    }
    let sizes =
        [("training.state", t.state), ("training.record", t.record), ("gradients.kept", g.kept)];
    for (key, bytes) in sizes {
        if !(1..=RECORD_MAX.0).contains(&bytes.0) {
            found.add(key, format!("`{key}` = {bytes} must be from 1 B to {RECORD_MAX}"));
        }
    }
    let buffers = [
        ("gradients.buffer.capacity", "gradients.buffer.word", &g.buffer),
        ("gradients.cache.capacity", "gradients.cache.word", &g.cache),
    ];
    for (capacity, word, buffer) in buffers {
        // Without a cache there are no sums on chip.
        let least = u64::from(capacity != "gradients.cache.capacity");
        if !(least..=SIZE_MAX.0).contains(&buffer.capacity.0) {
            let message =
                format!("`{capacity}` = {} must be from {least} B to {SIZE_MAX}", buffer.capacity);
            found.add(capacity, message);
        } else if buffer.capacity.0 > 0 && !(1..=buffer.capacity.0).contains(&buffer.word.0) {
            let message = format!(
                "`{word}` = {} must be from 1 B to the capacity, {}",
                buffer.word, buffer.capacity
            );
            found.add(word, message);
        }
    }
}

/// Units that do not work on whole sub-tiles, and pixels that never stop.
fn lanes(m: &TileWise, found: &mut Found) {
    let (g, vru) = (&m.geometry, &m.vru);
    let (way, termination) = (vru.implementation, vru.termination);
    let (name, stop) = (way.name(), termination.name());
    if let Some(own) = way.stops()
        && ![own, Termination::None].contains(&termination)
    {
        let message = format!(
            "`vru.impl` = \"{name}\" contradicts `vru.termination` = \"{stop}\": such units stop \
             with the {0}; set `vru.termination` = \"{0}\", or \"none\" where nothing stops",
            own.name()
        );
        found.add("vru.termination", message);
        found.ends_with("vru.termination", own.name());
    }
    if way == VruImpl::Leaders && matches!(termination, Termination::Pixel | Termination::Quad) {
        let message = format!(
            "`vru.impl` = \"leaders\" contradicts `vru.termination` = \"{stop}\": its mini-tiles \
             stop whole; set `vru.termination` = \"subtile\" or \"tile\""
        );
        found.add("vru.termination", message);
        found.ends_with("vru.termination", "subtile");
    }
    if way == VruImpl::Leaders && g.subtile == g.tile {
        let message = format!(
            "`vru.impl` = \"leaders\" contradicts `geometry.subtile` = {} and `geometry.tile` = \
             {}: a test unit looks at 2x2 sub-tiles; set `geometry.subtile` = {} or less",
            g.subtile,
            g.tile,
            g.tile / 2
        );
        found.add("geometry.subtile", message);
        found.ends_with("geometry.subtile", g.tile / 2);
    }
    if !way.has_subtiles() && g.subtile != g.tile {
        let message = format!(
            "`vru.impl` = \"{name}\" contradicts `geometry.subtile` = {} and `geometry.tile` = {}: \
             such units have no sub-tiles; set `geometry.subtile` = {1}",
            g.subtile, g.tile
        );
        found.add("geometry.subtile", message);
        found.ends_with("geometry.subtile", g.tile);
    }
    if way == VruImpl::Rows && vru.units_per_core > g.tile {
        let message = format!(
            "`vru.units-per-core` = {} contradicts `vru.impl` = \"rows\": a tile has \
             `geometry.tile` = {} rows for them; set `vru.units-per-core` = {1} or less",
            vru.units_per_core, g.tile
        );
        found.add("vru.units-per-core", message);
        found.ends_with("vru.units-per-core", g.tile);
    }
    let shows_levels = m.fovea.accumulators > 0;
    if shows_levels && (way.needs_pixels() || termination == Termination::None) {
        let (key, value) = match way.needs_pixels() {
            true => ("vru.impl", name),
            false => ("vru.termination", stop),
        };
        let message = format!(
            "`fovea.accumulators` = {} contradicts `{key}` = \"{value}\": how such units blend two \
             levels is not known; set `fovea` = \"none\"",
            m.fovea.accumulators
        );
        found.add(key, message);
        found.ends_with("fovea.accumulators", 0);
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

/// Numbers of a feature record: its form, three; its place, two; opacity; colour.
const FEATURE_NUMBERS: u64 = 9;

/// A feature record holds the numbers that rendering units read.
fn numbers(m: &TileWise, found: &mut Found) {
    let Some(format) = m.record.numbers else { return };
    let least = Bytes((FEATURE_NUMBERS * u64::from(format.bits())).div_ceil(8));
    if m.record.feature < least {
        let message = format!(
            "`record.numbers` = \"{format}\" and `record.feature` = {} contradict each other: \
             nine numbers of {} bits have {least}; set `record.feature` to that, or `numbers` to \
             a shorter format",
            m.record.feature,
            format.bits()
        );
        found.add("record.numbers", message);
        found.ends_with("record.feature", least);
    }
    if format.exponent_bits() < 4 {
        let message = format!(
            "`record.numbers` = \"{format}\": places in a tile need four bits of exponent, as in \
             e4m3"
        );
        found.add("record.numbers", message);
    }
}

/// Every byte that rendering reads was written by somebody, or the machine says that it was not.
fn features(m: &TileWise, found: &mut Found) {
    let r = &m.record;
    if r.feature_source == FeatureSource::Nobody {
        return;
    }
    if m.ccu.fetch == Fetch::LazyColour {
        let message = "`record.feature-source` = \"ccu\" needs colours before the lists are \
                       rendered, and `ccu.fetch` = \"lazy-colour\" reads them later: set \
                       `ccu.fetch` = \"visible-colour\", or `record.feature-source` = \"nobody\"";
        found.add("record.feature-source", message.into());
        found.ends_with("record.feature-source", "nobody");
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

/// Colours that are read late are evaluated by somebody.
fn late_colours(m: &TileWise, found: &mut Found) {
    if m.ccu.fetch == Fetch::LazyColour && m.vru.colour_operations_per_cycle == 0 {
        let message = "`vru.colour-operations-per-cycle` = 0 contradicts `ccu.fetch` = \
                       \"lazy-colour\", with which cores read colours and evaluate them: give it \
                       the operations a cycle of their colour units, e.g. 133, or set \
                       `ccu.fetch` = \"visible-colour\"";
        found.add("vru.colour-operations-per-cycle", message.to_owned());
        found.ends_with("ccu.fetch", "visible-colour");
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

/// A table of colours has words, and is no larger than any other buffer.
fn codebook(m: &TileWise, found: &mut Found) {
    let book = &m.codebook;
    if book.entries == 0 {
        return;
    }
    if book.entry == Bytes(0) || book.entry > RECORD_MAX {
        let message = format!("`codebook.entry` = {} must be 1 B to {RECORD_MAX}", book.entry);
        found.add("codebook.entry", message);
        return;
    }
    if book.word == Bytes(0) || book.word > RECORD_MAX {
        let message = format!("`codebook.word` = {} must be 1 B to {RECORD_MAX}", book.word);
        found.add("codebook.word", message);
        return;
    }
    // Entries are whole words.
    let copy = u64::from(book.entries).saturating_mul(book.words()).saturating_mul(book.word.0);
    if copy > SIZE_MAX.0 {
        let message = format!(
            "`codebook.entries` = {} of {} are above {SIZE_MAX}: a typing error?",
            book.entries, book.entry
        );
        found.add("codebook.entries", message);
    }
    let (record, pitch) = (m.record.of(ShDegree::MAX, book).colour, m.record.colour_pitch);
    if record > pitch {
        let message = format!(
            "`record.colour-pitch` = {pitch} is less than the {record} of a record with the number \
             of one of {} entries",
            book.entries
        );
        found.add("record.colour-pitch", message);
        found.ends_with("record.colour-pitch", record);
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
