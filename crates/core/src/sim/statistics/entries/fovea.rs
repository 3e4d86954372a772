//! Foveated frames: the gaze, the cost of blending levels, and each region's share.

use super::{List, count, real};
use crate::sim::statistics::Key;
use crate::sim::{FoveaSummary, FrameReport, RegionReport};
use powergs_frame::fovea::REGIONS;

/// A count of a foveated frame: name, definition, field.
type Field = (&'static str, &'static str, fn(&FoveaSummary) -> u64);

const FIELDS: [Field; 9] = [
    ("blending_tiles", "Tiles that blend two levels.", |f| f.blending_tiles),
    ("level_lookups", "Tests of a splat against the level of a tile (P_tile_ecc_accesses).", |f| {
        f.counters.lookups
    }),
    (
        "extra_alpha",
        "Entries that pixels iterate while both of their levels are open (T_extra_alpha).",
        |f| f.counters.extra_alpha,
    ),
    (
        "blends_2",
        "Entries blended for the second level, without the terminating ones (T_used2).",
        |f| f.counters.blends_2,
    ),
    ("points_1", "Fetched splats that need the colour of one level.", |f| levels(f, 0)),
    ("points_2", "Fetched splats that need the colours of two levels.", |f| levels(f, 1)),
    ("points_3", "Fetched splats that need the colours of three levels.", |f| levels(f, 2)),
    ("points_4", "Fetched splats that need the colours of all four levels.", |f| levels(f, 3)),
    ("tiles", "Tiles of the frame.", |f| f.tiles),
];

fn levels(f: &FoveaSummary, k: usize) -> u64 {
    f.counters.points_by_levels[k]
}

/// A measure of a region: key, unit, definition, field.
type FoveaMeasure = (fn(usize) -> Key, &'static str, &'static str, fn(&RegionReport) -> u64);

const MEASURES: [FoveaMeasure; 3] = [
    (Key::RegionTiles, "1", "Tiles of region", |r| r.tiles),
    (Key::RegionEntries, "1", "List entries that are loaded for tiles of region", |r| r.entries),
    (
        Key::RegionCycles,
        "cycles",
        "Cycles for which the rendering units of a core work, without draining, on region",
        |r| r.cycles,
    ),
];

pub(super) fn fovea(list: &mut List) {
    for (i, axis) in ["x", "y"].into_iter().enumerate() {
        let text = format!("Gaze in a foveated frame, share of the image along {axis}.");
        let gaze = move |f: &FrameReport| f.fovea().map(|v| f64::from(v.gaze[i]));
        real(list, format!("fovea.gaze_{axis}"), "1", text, move |f, _| gaze(f));
    }
    for (name, text, field) in FIELDS {
        let read = move |f: &FrameReport| f.fovea().map(field);
        count(list, format!("fovea.{name}"), "1", text, read);
    }
    for (k, region) in REGIONS.into_iter().enumerate() {
        for (of, unit, text, field) in MEASURES {
            let text = format!("{text} {region} of a foveated frame.");
            let read = move |f: &FrameReport| f.regions().map(|all| field(&all[k]));
            count(list, of(k), unit, text, read);
        }
        let text = format!(
            "Energy of sorting and rendering the tiles of region {region} of a foveated frame; \
             preprocessing and what is paid for time belong to no region."
        );
        let read = move |f: &FrameReport, _| f.regions().map(|all| all[k].energy_pj);
        real(list, Key::RegionEnergy(k), "pJ", text, read);
    }
}
