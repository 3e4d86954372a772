//! Consistency of the keys of a machine file.

use super::{ComposePath, FrontOverlap, Resident};
use crate::machine::check::{Found, RECORD_MAX, SIZE_MAX};

/// Adds every contradiction.
pub(super) fn check(m: &Resident, found: &mut Found) {
    sizes(m, found);
    slices(m, found);
    late(m, found);
    if !m.front.batch.is_multiple_of(32) {
        let next = m.front.batch.next_multiple_of(32);
        let message = format!("`front.batch` = {} must be a multiple of 32: {next}", m.front.batch);
        found.add("front.batch", message);
        found.ends_with("front.batch", next);
    }
}

fn sizes(m: &Resident, found: &mut Found) {
    let g = &m.gaussian;
    let records = [
        ("gaussian.position", g.position, 0),
        ("gaussian.shape", g.shape, 0),
        ("gaussian.colour", g.colour, 0),
        ("gaussian.feature", g.feature, 0),
        ("gaussian.entry", g.entry, 1),
        ("gaussian.pixel", g.pixel, 0),
        ("gaussian.colour-pitch", g.colour_pitch, g.colour.0),
        ("gaussian.feature-pitch", g.feature_pitch, g.feature.0),
        ("raster.pixel-state", m.raster.pixel_state, 1),
        ("training.state", m.training.state, 1),
        ("training.record", m.training.record, 1),
    ];
    for (key, bytes, least) in records {
        if !(least..=RECORD_MAX.0).contains(&bytes.0) {
            let message = format!("`{key}` = {bytes} must be from {least} B to {RECORD_MAX}");
            found.add(key, message);
        }
    }
    for (key, store) in m.stores.all() {
        if store.capacity > SIZE_MAX {
            found.add(key, format!("`{key}.capacity` = {} is above {SIZE_MAX}", store.capacity));
        }
        if store.word.0 == 0 {
            found.add(key, format!("`{key}.word` must be above 0 B"));
        }
    }
    let pixels = u64::from(m.region.width) * u64::from(m.region.height);
    let (needed, share) = (pixels.saturating_mul(m.raster.pixel_state.0), m.pixel_share());
    if needed > share {
        let capacity = needed.saturating_mul(u64::from(m.raster.engines));
        found.add(
            "stores.pixels",
            format!(
                "a region of {}x{} pixels takes {needed} B, and each of {} engines has {share} B: \
                 set `stores.pixels.capacity` to at least {capacity} B, or make the region smaller",
                m.region.width, m.region.height, m.raster.engines
            ),
        );
        found.ends_with("stores.pixels.capacity", format!("{capacity} B"));
    }
}

fn slices(m: &Resident, found: &mut Found) {
    let slices = m.region.slices;
    if slices > 1 && m.compose.lanes == 0 {
        let message = format!(
            "`region.slices` = {slices} needs units that put slices together: set `compose.lanes` \
             above 0"
        );
        found.add("region.slices", message);
        found.ends_with("compose.lanes", 16);
    }
    let engines = m.raster.engines;
    if slices > engines && m.compose.through == ComposePath::Stores {
        let message = format!(
            "`region.slices` = {slices} needs as many engines where slices stay in their buffers \
             (`compose.through`): `raster.engines` is {engines}"
        );
        found.add("region.slices", message);
        found.ends_with("region.slices", engines);
    }
    if slices > 1 && (m.raster.saturation || m.tail.share > 0.0) {
        let message = format!(
            "`region.slices` = {slices}: what lies behind does not know when pixels stop; leave \
             out `raster.saturation` and `[tail]`, or set it to 1"
        );
        found.add("region.slices", message);
        found.ends_with("region.slices", 1);
    }
}

fn late(m: &Resident, found: &mut Found) {
    if m.front.lazy && m.front.overlap == FrontOverlap::Frames {
        let message =
            "`front.lazy` converts for the frame at work: set `front.overlap` to \"none\"";
        found.add("front.lazy", message.into());
        found.ends_with("front.overlap", "none");
    }
    if m.tail.share > 0.0 && m.stores.tail.capacity.0 == 0 {
        let store = r#"{ capacity = "32 KiB", word = "64 B", banks = 1, ports = "1rw" }"#;
        let message = format!("`tail.share` needs a buffer: `stores.tail = {store}`");
        found.add("tail.share", message);
        found.ends_with("stores.tail", store);
    }
    if m.front.lazy && (m.raster.engines > 1 || m.tail.share > 0.0) {
        let message = "`front.lazy` converts one chunk after the other, for one engine: set \
                       `raster.engines` to 1, and leave out `[tail]`";
        found.add("front.lazy", message.into());
        found.ends_with("front.lazy", false);
    }
}
