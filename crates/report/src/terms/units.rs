//! Units of the machine and stages of a frame.

use super::{Term, term};

pub(super) const UNITS: &[Term] = &[
    term(
        &["GSU", "gaussian sorting unit"],
        "",
        "Gaussian Sorting Unit: sorts the list of a tile by depth. It is made of quick sorting \
         units (QSU) and bitonic sorting units (BSU). Keys: `gsu`.",
    ),
    term(
        &["VRC", "volume rendering core"],
        "",
        "Volume Rendering Core: one pipeline of the VRU, which blends `vru.pixels-per-unit` pixels \
         in turn; a core has `vru.units-per-core` of them.",
    ),
    term(
        &["core", "rendering core"],
        "",
        "A GSU, a feature buffer and `vru.units-per-core` rendering pipelines; it renders one tile \
         at a time.",
    ),
    term(
        &["preprocessing"],
        "",
        "First stage of a frame: culling, projection and tile lists, done by the CCUs.",
    ),
    term(&["sorting"], "", "Second stage: the list of every tile is sorted by depth (GSU)."),
    term(&["rendering"], "", "Third stage: the sorted list of every tile is blended (VRU)."),
    term(
        &["standby"],
        "",
        "What is paid whether or not there is work: leakage of the chip, background and refresh of \
         the DRAM.",
    ),
    term(
        &["OBB", "oriented bounding box"],
        "",
        "Oriented Bounding Box: the rectangle along the axes of a projected Gaussian. With \
         `geometry.test = \"obb\"` a tile takes a Gaussian if the box overlaps it; fewer pairs \
         than with the axis-aligned box (`aabb`), more than with the exact `ellipse`.",
    ),
    term(
        &["AABB", "axis-aligned bounding box"],
        "",
        "Axis-Aligned Bounding Box: the upright rectangle around a projected Gaussian, the \
         cheapest \
         and loosest test of which tiles it overlaps (`geometry.test = \"aabb\"`).",
    ),
    term(
        &["pair", "tile pair"],
        "",
        "A Gaussian and a tile that it overlaps: one entry of the tile's list.",
    ),
    term(
        &["precision", "number format", "fp16", "fp32"],
        "",
        "There is no key for number formats. What a narrower format saves in bytes is set by the \
         sizes of the records (`record.feature`, `record.colour`, `record.geometry` and their \
         pitches); energy per operation and area are those of the energy table and have to be \
         changed there; the error of the picture is not modelled.",
    ),
];
