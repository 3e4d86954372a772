//! The words of reports: heads of columns, names of rows, abbreviations. What is a statistic or a
//! key of a file has its definition there; everything else that a page or a table prints is here,
//! and `explain` knows it.

/// A word with its meaning.
#[derive(Debug, Clone, Copy)]
pub struct Term {
    /// How reports write it, the usual way first.
    pub names: &'static [&'static str],
    /// Unit; empty where it has none.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
}

const fn term(names: &'static [&'static str], unit: &'static str, meaning: &'static str) -> Term {
    Term { names, unit, meaning }
}

/// All words.
pub fn terms() -> impl Iterator<Item = &'static Term> {
    [UNITS, CYCLES, POWER, TABLES, COMPARED, SWEEPS, SENSITIVITY, MORE, OPTIMIZER, PICTURES, INPUTS]
        .into_iter()
        .flatten()
}

const UNITS: &[Term] = &[
    term(
        &["CCU", "culling and conversion unit"],
        "",
        "Culling and Conversion Unit: reads the records of Gaussians, culls, projects to the \
         screen, tests which tiles each one overlaps and writes the list of every tile \
         (preprocessing). Keys: `ccu`.",
    ),
    term(
        &["GSU", "gaussian sorting unit"],
        "",
        "Gaussian Sorting Unit: sorts the list of a tile by depth. It is made of quick sorting \
         units (QSU) and bitonic sorting units (BSU). Keys: `gsu`.",
    ),
    term(
        &["QSU", "quick sorting unit"],
        "",
        "Quick Sorting Unit of the GSU: splits a list at pivots into chunks that are small enough \
         to sort in one go.",
    ),
    term(
        &["BSU", "bitonic sorting unit"],
        "",
        "Bitonic Sorting Unit of the GSU: sorts the rows of a chunk in a network of comparators.",
    ),
    term(
        &["VRU", "volume rendering unit"],
        "",
        "Volume Rendering Unit: blends the sorted Gaussians of a tile into its pixels, sub-tile by \
         sub-tile. It is an array of volume rendering cores (VRC); `vru x64` counts those of the \
         whole machine. Keys: `vru`.",
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

const CYCLES: &[Term] = &[
    term(
        &["% of cycles", "cycles"],
        "%",
        "What the units of a kind did, averaged over them: busy, waiting for one of the causes in \
         the columns, or idle. A row adds up to the frame.",
    ),
    term(
        &["busy", "ccu busy", "qsu busy", "bsu busy", "vru busy"],
        "%",
        "Share of the frame in which the unit works.",
    ),
    term(
        &["records"],
        "%",
        "The unit waits because records of Gaussians are still in DRAM or on the way.",
    ),
    term(
        &["list"],
        "%",
        "The unit waits because the list of a tile is still in DRAM or on the way.",
    ),
    term(
        &["spill"],
        "%",
        "The unit waits for keys that did not fit the sorting buffer: they go to DRAM and back \
         in every pass.",
    ),
    term(
        &["features", "feature loads"],
        "%",
        "The unit waits because features or colours of a chunk are still in DRAM or on the way.",
    ),
    term(&["input"], "%", "The unit waits for the unit upstream: its input is not ready yet."),
    term(
        &["output"],
        "%",
        "The unit waits because the buffer behind it is full: the unit downstream is slower.",
    ),
    term(
        &["bank", "bank conflicts"],
        "%",
        "The unit waits because the banks that it wants are serving other accesses.",
    ),
    term(
        &["idle", "without work"],
        "%",
        "The unit has nothing to do: its phase has not begun, or is over.",
    ),
    term(
        &["bottleneck", "bound"],
        "",
        "Every cycle of a frame is given to the unit that leads: in preprocessing the CCU, then \
         the \
         busiest of QSU, BSU and VRU. What that unit does (works, waits, has no work) adds up to \
         the frame. `VRU-bound 80 %`: the VRUs lead and work for 80 % of it.",
    ),
    term(
        &["lanes at work"],
        "%",
        "Share of the pixels of a busy core whose Gaussian contributes and has not stopped.",
    ),
    term(&["DRAM bus busy"], "%", "Share of the frame in which the DRAM transfers data."),
];

const POWER: &[Term] = &[
    term(
        &["mW at the display rate", "power at the display rate", "W at the display rate"],
        "mW",
        "Power of the accelerator and its DRAM while it renders one frame per display period \
         (`--fps`): the energy of that work, and standby all the time. The power to compare \
         designs with.",
    ),
    term(
        &["power at full rate"],
        "mW",
        "Power while frames are rendered back to back, as fast as the machine can.",
    ),
    term(
        &["energy per frame", "mJ per frame", "energy"],
        "mJ",
        "Energy of one frame at full rate: its accesses and operations, and standby for the time \
         that the frame takes. At the display rate a frame also pays standby while the machine \
         waits for the next one, so this times the display rate is less than the power.",
    ),
    term(
        &["frame time", "ms per frame"],
        "ms",
        "Time from the first cycle of a frame to the last.",
    ),
    term(
        &["frame rate", "frames per second", "FPS", "throughput_fps"],
        "frames per second",
        "Frames per second if they are rendered back to back.",
    ),
    term(
        &["deadline"],
        "ms",
        "The display period, 1 / `--fps`; a frame that takes longer has missed it.",
    ),
    term(
        &["display power", "display"],
        "mW",
        "Power of the panel for the pictures of the trace (`--display`), beside the accelerator.",
    ),
    term(
        &["accelerator and display", "accelerator + display"],
        "mW",
        "Power at the display rate and the display's own power together.",
    ),
    term(&["dram"], "", "Energy or power of DRAM accesses, without its standby."),
    term(&["sram"], "", "Energy or power of accesses to the buffers on the chip."),
    term(&["flop"], "", "Energy or power of arithmetic."),
    term(&["leakage"], "", "Leakage of units and buffers, paid all the time."),
    term(&["background"], "", "DRAM that is on and idle, paid all the time."),
    term(&["refresh"], "", "Refresh of the DRAM, paid all the time."),
    term(&["total"], "", "Sum of the row or column."),
];

const TABLES: &[Term] = &[
    term(
        &["doubled", "if doubled", "one step", "what if", "what_if", "what-if"],
        "",
        "The what-if experiment: some frames are simulated again with each resource doubled. The \
         row `nothing` is the machine as it is.",
    ),
    term(
        &["change", "%", "frame time: %", "power: %", "area: %", "merit: %"],
        "%",
        "Relative change against the first row or column.",
    ),
    term(&["frame time: ms"], "ms", "Mean frame time of the frames that were tried."),
    term(&["area: mm²"], "mm²", "Area of the chip with the resource doubled."),
    term(
        &["merit: FPS/mm²", "FPS/mm²"],
        "1/s/mm²",
        "Frames per second, back to back, per mm² of chip: what `next` goes by.",
    ),
    term(&["difference"], "", "Value of a side minus that of the first."),
    term(
        &["buffer"],
        "",
        "A buffer of the machine, with the name that it has in the machine file.",
    ),
    term(&["KiB"], "KiB", "Capacity of the buffer, all cores together."),
    term(&["peak %", "peak"], "%", "The fullest that the buffer ever was, of its capacity."),
    term(&["mean %"], "%", "How full the buffer is on average over the frame."),
    term(&["filled"], "B", "Bytes written into the buffer in a frame."),
    term(&["consumed"], "B", "Bytes of it that a unit has read."),
    term(
        &["discarded"],
        "B",
        "Bytes that were fetched and never read: the tile was finished before.",
    ),
    term(&["effect"], "", "Something that real hardware has and the model leaves out."),
    term(
        &["simulated time is", "bias"],
        "",
        "Which way the frame time is wrong for a missing effect: optimistic (real frames take \
         longer), pessimistic (less long), either.",
    ),
    term(&["see"], "", "The assumption that says more: powergs-sim explain A21."),
    term(&["statistic"], "", "A measured number; powergs-sim explain NAME defines each of them."),
    term(&["mean"], "", "Arithmetic mean over the frames."),
    term(&["p50", "median"], "", "Half of the frames are at or below this value."),
    term(&["p95"], "", "95 % of the frames are at or below this value (nearest rank)."),
    term(
        &["p99"],
        "",
        "99 % of the frames are at or below this value (nearest rank); with fewer than 100 frames \
         it is the maximum.",
    ),
    term(&["max"], "", "The largest value of all frames."),
    term(&["min"], "", "The smallest value of all frames."),
    term(
        &["region", "region, a frame", "R1", "R2", "R3", "R4"],
        "",
        "Of a foveated frame: R1 is the part around the gaze, R4 the outermost; each is drawn with \
         its own level of the model.",
    ),
    term(&["tiles"], "", "Tiles of the image that belong to the row."),
    term(&["splats loaded"], "", "Splats that were fetched for the tiles of the row."),
    term(&["VRU cycles"], "cycles", "Cycles in which the rendering units worked on the row."),
    term(&["block"], "", "A unit or buffer of the chip."),
    term(
        &["area", "area mm2", "area mm²"],
        "mm²",
        "Area of the chip, or of a block, without DRAM.",
    ),
    term(
        &["peak mW"],
        "mW",
        "Power of a block that works in every cycle. A frame never has all blocks at their peak.",
    ),
    term(
        &["row"],
        "",
        "In results.csv: `frame`, or the aggregate `mean`, `p50`, `p95`, `p99`, `max`.",
    ),
    term(&["frame"], "", "Position of the frame in its trace, from 0."),
    term(&["name"], "", "Name of the view, of the statistic or of the row."),
    term(
        &["kind"],
        "",
        "In compare.csv: `measure` (of the first table) or `mean` (of a statistic).",
    ),
    term(&["incomplete"], "", "Whether the run was interrupted before its last frame."),
    term(
        &["roofline"],
        "FLOP/s",
        "Operations per DRAM byte against operations per second, under the peak rates of the \
         machine.",
    ),
];

const COMPARED: &[Term] = &[
    term(
        &["speed-up", "speedup"],
        "",
        "Frame rate over that of the first machine on the same trace; over several traces the \
         geometric mean.",
    ),
    term(
        &["energy gain", "energy_gain"],
        "",
        "Energy per frame of the first machine over that of this one on the same trace; over \
         several traces the geometric mean.",
    ),
    term(&["ratio"], "", "Value of a side over that of the first."),
    term(
        &["FPS per W", "FPS per W (frames per J)", "fps_per_w"],
        "1/J",
        "Frame rate over power at full rate: frames per joule.",
    ),
    term(&["FPS per mm2", "FPS per mm²", "fps_per_mm2"], "FPS/mm²", "Frame rate over area."),
    term(
        &["FPS per GB/s of peak", "fps_per_gb_s"],
        "FPS per GB/s",
        "Frame rate over the peak rate of the DRAM.",
    ),
    term(
        &["FPS at the area of the first", "iso_area_fps"],
        "FPS",
        "Frame rate times the area of the first side over its own, as if performance grew in \
         proportion to area. No simulation.",
    ),
    term(
        &["FPS at the GB/s of the first", "iso_bandwidth_fps"],
        "FPS",
        "Frame rate times the peak DRAM rate of the first side over its own, as if performance \
         grew in proportion to bandwidth. No simulation.",
    ),
    term(
        &["DRAM", "DRAM MB per frame", "dram_mb_per_frame"],
        "MB",
        "Bytes read and written in DRAM for a frame.",
    ),
    term(
        &["DRAM peak", "dram_peak_gb_s"],
        "GB/s",
        "Peak rate of the DRAM: all channels, every beat.",
    ),
    term(&["frame_time_p99_ms"], "ms", "99 % of the frames take at most this long."),
    term(&["energy_per_frame_mj"], "mJ", "Energy of one frame at full rate."),
    term(
        &["waits", "ccu waits", "qsu waits", "bsu waits", "vru waits"],
        "%",
        "Share of the frame in which a unit with work waits for the cause behind the colon.",
    ),
];

const SWEEPS: &[Term] = &[
    term(
        &["design"],
        "",
        "One machine of a sweep: a number (#12) for a point of the space, or the baseline.",
    ),
    term(&["baseline"], "", "The base machine of a sweep as it is, without any axis."),
    term(
        &["front", "Pareto front"],
        "",
        "The designs that no other design beats in all objectives at once.",
    ),
    term(
        &["knee"],
        "",
        "The design of the front with the smallest merit: the best compromise if every objective \
         counts the same between its best and its worst value on the front.",
    ),
    term(
        &["merit"],
        "",
        "Mean of the objectives of a design, each scaled so that the best value on the front is 0 \
         and the worst is 1. The knee has the smallest. In a what-if table: frames per second \
         and mm².",
    ),
    term(&["objective"], "", "What a front makes small or large: any column of the results."),
    term(&["settings"], "", "Values of the axes of a design."),
    term(&["axis"], "", "What a sweep varies: one key, several together, or named sets of keys."),
    term(&["values"], "", "How many values the axis has."),
    term(
        &["main effect", "main effect, %"],
        "%",
        "How far the mean over all designs moves between the values of the axis, relative to the \
         mean of all.",
    ),
    term(
        &["alone at most", "alone at most, %"],
        "%",
        "The largest change between two designs that differ in this axis only.",
    ),
    term(&["dead"], "", "The axis moves none of the objectives."),
    term(
        &["ranked under"],
        "",
        "The energy table, the trace or the price of DRAM that the ranking is repeated under.",
    ),
    term(
        &["Kendall τ", "kendall", "τ"],
        "",
        "Agreement of two rankings from -1 to 1: the share of pairs of designs in the same \
         order, minus the share in the opposite one.",
    ),
    term(
        &["Spearman ρ", "spearman"],
        "",
        "Correlation of the ranks of two rankings, from -1 to 1.",
    ),
    term(&["fronts"], "", "On how many of the fronts the design is."),
    term(
        &["kept", "front kept", "top kept"],
        "",
        "How many designs of the front, or of the best, stay there under another table, trace or \
         price.",
    ),
    term(&["break the condition"], "", "Designs that no longer meet the condition."),
    term(
        &["marginal value", "marginal"],
        "",
        "What the next mm² or mW buys from one design of the front to the next.",
    ),
    term(
        &["display rate", "misses_display_rate"],
        "",
        "Whether every frame of a design is ready within a display period: met, or missed.",
    ),
    term(
        &["same as", "same_as"],
        "",
        "Designs that are equal in every objective but for noise (`--epsilon`).",
    ),
    term(&["role"], "", "In pareto.csv: `knee`, `front`, or the design that `--design` names."),
    term(
        &[".si"],
        "",
        "A column KEY.si has the value of a key as a number in base units (bytes, Hz, bytes per \
         second); KEY has it as it is written.",
    ),
    term(&["energy table"], "", "The energy table that a row was priced with."),
];

const SENSITIVITY: &[Term] = &[
    term(&["file"], "", "Which file has the key: machine, energy table or DRAM device."),
    term(&["key", "keys"], "", "A key of that file; powergs-sim explain KEY defines it."),
    term(&["value"], "", "What the key has."),
    term(
        &["step", "step, %", "near"],
        "%",
        "The small step down and up that elasticities are measured with.",
    ),
    term(&["far"], "", "The large step: half and double of the value."),
    term(&["other"], "", "Another name that the key can have."),
    term(
        &[
            "elasticity",
            "elasticity_fps",
            "elasticity_energy",
            "elasticity_power",
            "elasticity_area",
        ],
        "",
        "d ln y / d ln x: by how many percent a result changes when the key changes by one \
         percent.",
    ),
    term(
        &["low", "low .. high", "high"],
        "",
        "Results, or values, at the lower and at the higher step.",
    ),
    term(&["fps"], "", "Frame rate, or its change or elasticity."),
    term(&["power"], "", "Power at the display rate, or its change or elasticity."),
    term(
        &["assumption"],
        "",
        "A modelling choice of this program, numbered A1, A2, ...: powergs-sim explain A1.",
    ),
    term(&["knob"], "", "The keys that vary an assumption."),
    term(&["base"], "", "The value that the machine has."),
    term(
        &["levels"],
        "",
        "The values that a key takes in the experiment; of a foveated model: its levels.",
    ),
    term(&["trace"], "", "The trace, or its label."),
    term(&["frames"], "", "How many frames were simulated."),
    term(
        &["ST", "S1", "ST low", "ST high", "S1 low", "S1 high"],
        "",
        "Sobol indices: the share of the variance that a key causes alone (S1) and together with \
         all others (ST), with confidence intervals.",
    ),
    term(
        &["mu*", "μ*", "μ", "mu_percent", "mu_star_percent", "sigma_percent", "sigma", "σ", "mu"],
        "",
        "Of Morris: mean absolute elementary effect (how much a key matters) and its spread (how \
         much that depends on the others).",
    ),
    term(&["status"], "", "Whether the key or the row has a result, or why it has none."),
    term(
        &["reach"],
        "",
        "In sensitivity.csv: which step the row is: near or far, down or up, or another name.",
    ),
    term(&["reason", "refused", "why"], "", "Why there is no result."),
    term(&["dead on these frames"], "", "Keys that move nothing here, by the reason."),
    term(
        &["elasticity_sides"],
        "",
        "Which steps the elasticity is from: both sides, or only the one that is a valid machine.",
    ),
    term(
        &["elasticity_shape"],
        "",
        "Whether the frame rate is alike on both sides of the value (smooth), at least twice as \
         steep on one of them (kinked), or known on one side only (one-sided).",
    ),
    term(
        &["far_change"],
        "",
        "The largest change of any result at half or at double, or by another name, relative.",
    ),
    term(&["largest_change"], "", "The largest change of any result of the key, relative."),
    term(
        &[
            "fps_change",
            "fps_change_low",
            "fps_change_high",
            "energy_change",
            "energy_change_low",
            "energy_change_high",
            "power_change",
            "power_change_low",
            "power_change_high",
            "area_change",
            "area_change_low",
            "area_change_high",
        ],
        "",
        "Relative change of the result; with `_low` and `_high`: at the lower and the higher far \
         step.",
    ),
    term(&["power_display_rate_w"], "W", "Power at the display rate."),
];

const MORE: &[Term] = &[
    term(
        &["at the display rate"],
        "mW",
        "Power at the display rate, or its change: see `power at the display rate`.",
    ),
    term(&["ms", "mm²"], "", "The value of the group of columns, in milliseconds or in mm²."),
    term(
        &["state", "state_l1", "state_l2", "state_l3", "state_l4"],
        "",
        "How the fine-tune of a level ended: whether it passed, or why there is none.",
    ),
    term(
        &["W", "mW", "µW", "watts", "joules_per_frame"],
        "",
        "Power of the row at the display rate (watt, 10⁻³ W, 10⁻⁶ W), or the energy of one frame.",
    ),
    term(
        &["first", "first_low", "first_high", "total_low", "total_high"],
        "",
        "Of Sobol indices: the share of the variance that a key causes alone (first) and together \
         with the others (total), with the ends of the 95 % interval. In a ranking: the best \
         design.",
    ),
    term(&["measure"], "", "The result that the row is about: fps, energy, power or area."),
    term(
        &["misses_display_rate"],
        "",
        "Whether the design has fewer frames per second than the display shows.",
    ),
    term(
        &["same_as"],
        "",
        "An earlier design of the front that differs from this one by noise only.",
    ),
    term(
        &["side"],
        "",
        "Of an assumption: the lower or the higher value; of a comparison: a machine or a report.",
    ),
    term(
        &["with"],
        "",
        "Settings without which the keys of an assumption move nothing; its row is compared with \
         the machine that has them.",
    ),
    term(&["machine"], "", "The machine file, by its name."),
    term(
        &["invalid configuration"],
        "",
        "Values that contradict each other or a range: there is no such machine, and nothing is \
         simulated.",
    ),
];

const OPTIMIZER: &[Term] = &[
    term(
        &["rho", "ρ", "pruned", "pruned, %", "pruned share"],
        "",
        "Share of the Gaussians of the dense model that has been pruned, 0 to 1.",
    ),
    term(
        &["lambda", "λ", "lambda_per_w"],
        "1/W",
        "Weight of the display power in the loss of a fine-tune; a controller raises it until the \
         quality is just above the target.",
    ),
    term(&["dense"], "", "The model as it was given."),
    term(
        &["held-out"],
        "",
        "The dense model trained on without the views that decide on quality: they are then not \
         known from training, and a target that is a share means a share of this one.",
    ),
    term(&["sample"], "", "A pruned model that is fine-tuned to the target quality at one ρ."),
    term(
        &["gate", "gate views"],
        "",
        "Views that decide whether a model meets the target; λ follows them.",
    ),
    term(
        &["test", "test views"],
        "",
        "Views that are only reported: nothing is selected or trained on them.",
    ),
    term(
        &["gate PSNR", "gate_psnr_db", "test PSNR", "test_psnr_db", "psnr_db", "PSNR"],
        "dB",
        "Peak signal-to-noise ratio against the reference, over the views that the name says.",
    ),
    term(
        &["gate SSIM", "gate_ssim", "test SSIM", "test_ssim", "ssim"],
        "",
        "Structural similarity against the reference, 1 for equal pictures, over the views that \
         the name says.",
    ),
    term(
        &["FLIP", "test FLIP", "flip_test"],
        "",
        "Difference as an observer sees it who alternates between both pictures, 0 to 1; small \
         is good.",
    ),
    term(
        &["LPIPS", "test LPIPS", "lpips_test"],
        "",
        "Perceptual distance by a trained network, whose weights you bring; small is good.",
    ),
    term(
        &[
            "HVSQ",
            "HVSQ of L1 to L4",
            "target_hvsq",
            "test_hvsq",
            "hvsq_l1",
            "hvsq_l2",
            "hvsq_l3",
            "hvsq_l4",
            "hvsq_r1",
            "hvsq_r2",
            "hvsq_r3",
            "hvsq_r4",
        ],
        "",
        "Difference in the periphery of sight: of means and variances in pools that grow with \
         eccentricity; small is good.",
    ),
    term(
        &["model"],
        "",
        "A model of the run, with the name that it has in charts, tables and files.",
    ),
    term(
        &[
            "Gaussians",
            "Gaussians of L1 to L4",
            "survivors",
            "gaussians_l1",
            "gaussians_l2",
            "gaussians_l3",
            "gaussians_l4",
        ],
        "",
        "How many Gaussians the model, or a level of it, has left.",
    ),
    term(&["passed", "gate_passed"], "", "Whether the gate views meet the target."),
    term(
        &["render", "render_w", "R"],
        "W",
        "Rendering power at the display rate, mean over the views of the power.",
    ),
    term(
        &["display_w", "D", "gate_display_w"],
        "W",
        "Display power, mean over the views of the power.",
    ),
    term(&["total_w", "ours_w"], "W", "Rendering and display power together."),
    term(&["display_to_render"], "", "Display power over rendering power of the dense model."),
    term(&["display_scale"], "", "Factor on the power of the panel."),
    term(
        &["saved_over_render_only", "saved_over_display_only", "saved_over_dense"],
        "",
        "Share of the total power that is saved against that model.",
    ),
    term(&["job"], "", "A part of a run: dense, held-out, a sample, the final model, a baseline."),
    term(&["role of a model", "source"], "", "What a model is in the run, or where it came from."),
    term(
        &["iteration", "iterations"],
        "",
        "Optimisation steps of a fine-tune; one training view each.",
    ),
    term(&["kept_at"], "", "Iteration of the fine-tune that the kept model is from."),
    term(&["view"], "", "The view: its name or its number."),
    term(
        &["loss", "l1"],
        "",
        "0.8 L1 + 0.2 (1 - SSIM) + λ P_display of the training view; `l1` is its first part.",
    ),
    term(&["gate_hvsq"], "", "HVSQ of the gate views."),
    term(
        &["method"],
        "",
        "How the foveated frames were made: ours, or one of the methods compared.",
    ),
    term(&["variant"], "", "The quality target of the row: H, M or L."),
    term(
        &["level"],
        "",
        "A level of a foveated model: 1 for the fovea to 4 for the far periphery.",
    ),
    term(&["foveated"], "", "The foveated model or method of the row."),
    term(
        &["of that filter", "filter_w"],
        "W",
        "The part of the power that the D22 colour filter takes.",
    ),
    term(&["target"], "", "What was asked for."),
    term(
        &["claim", "published", "expected", "here", "agrees"],
        "",
        "A statement of the PowerGS publication, its number there, what has to come out here, the \
         number of this run, and whether it agrees.",
    ),
    term(&["fovea"], "", "The part of sight around the gaze that sees sharply."),
    term(
        &["gaze"],
        "",
        "Where the viewer looks, as shares of width and height from the upper left corner.",
    ),
    term(
        &["D22"],
        "",
        "The colour filter of Duinkharjav et al. 2022: cheaper colours outside of the fovea.",
    ),
];

const PICTURES: &[Term] = &[
    term(
        &["red_w", "green_w", "blue_w", "static_w"],
        "W",
        "Parts of the display power: the light of a channel, and what the panel takes for black.",
    ),
    term(&["MSE"], "", "Mean squared error of sRGB values from 0 to 1."),
];

const INPUTS: &[Term] = &[
    term(&["survivors of culling"], "", "Splats that are in front of the camera and in the image."),
    term(&["visible"], "", "Splats of a frame that survive culling and overlap a tile."),
    term(&["B/splat", "bytes a visible splat"], "B", "Bytes in the trace file per visible splat."),
    term(&["B/pixel", "bytes a pixel"], "B", "Bytes in the trace file per pixel."),
    term(&["other B"], "B", "Bytes of a frame that are neither splats nor pixels."),
    term(
        &["SH degree"],
        "",
        "Degree of the spherical harmonics of the colour, 0 to 3: 1, 4, 9 or 16 coefficients a \
         channel.",
    ),
];
