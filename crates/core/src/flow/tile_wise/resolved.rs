//! Resolved unit parameters: a machine as its units, with the share of each buffer that one unit or
//! core has to itself.

use crate::flow::tile_wise::BinningImpl;
use crate::flow::tile_wise::STREAMS;
use crate::flow::tile_wise::bsu::Bsu;
use crate::flow::tile_wise::ccu::Ccu;
use crate::flow::tile_wise::colour::Colour;
use crate::flow::tile_wise::gradients::GradientUnits;
use crate::flow::tile_wise::qsu::Qsu;
use crate::flow::tile_wise::rules::UnitRules;
use crate::flow::tile_wise::subtiles::Discipline;
use crate::flow::tile_wise::vru::Vru;
use crate::kernel::bank::Banks;
use crate::kernel::dram::Dram;
use crate::machine::{BufferSpec, Machine};
use crate::workload::FrameWorkload;
use powergs_frame::scene::ShDegree;

/// Bytes of each buffer that one unit or core has to itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shares {
    /// Of one CCU.
    pub gaussian_in: u64,
    /// Of one CCU.
    pub tile_list: u64,
    /// Of one core.
    pub sorting: u64,
    /// Of one core.
    pub feature: u64,
    /// Of one core, without the pixel state that it keeps there.
    pub pixel_out: u64,
}

/// The units of a machine with their resolved parameters.
#[derive(Debug, Clone)]
pub struct ResolvedUnits {
    /// One of the `ccu.spec.units` culling and conversion units.
    pub ccu: Ccu,
    /// The quick sorting units of one core.
    pub qsu: Qsu,
    /// The bitonic sorting units of one core.
    pub bsu: Bsu,
    /// The colour unit of one core; `None` where the CCUs evaluate colours.
    pub colour: Option<Colour>,
    /// The rendering units of one core.
    pub vru: Vru,
    /// The shared memory.
    pub dram: Dram,
    /// The buffers.
    pub shares: Shares,
    /// Bytes of a word of the feature cache.
    pub cache_word: u64,
    /// What gradient units do; `None` on machines that do not train.
    pub gradients: Option<GradientUnits>,
    /// The rules of the units.
    pub rules: UnitRules,
}

impl ResolvedUnits {
    /// Resolves a checked machine, with the records of scenes of SH degree 3.
    ///
    /// # Panics
    /// When a count, width or interval is zero: checks of machine files refuse that.
    pub fn new(machine: &Machine) -> Self {
        Self::of(machine, false, ShDegree::MAX)
    }

    /// Resolves a checked machine for a frame: foveated frames have further records, scenes of a
    /// lower SH degree smaller ones.
    ///
    /// # Panics
    /// As [`ResolvedUnits::new`]; when the machine cannot show a foveated frame.
    pub fn for_frame(machine: &Machine, workload: &FrameWorkload) -> Self {
        let is_foveated = workload.fovea.is_some();
        let can = !is_foveated || machine.tiles().fovea.accumulators > 0;
        assert!(can, "a machine without accumulators for levels got a foveated frame");
        Self::of(machine, is_foveated, workload.sh_degree)
    }

    fn of(machine: &Machine, is_foveated: bool, degree: ShDegree) -> Self {
        let (ccu, gsu, vru) = (&machine.tiles().ccu, &machine.tiles().gsu, &machine.tiles().vru);
        for (key, value) in [
            ("geometry.chunk", machine.tiles().geometry.chunk),
            ("ccu.units", ccu.units),
            ("ccu.operations-per-cycle", ccu.operations_per_cycle),
            ("ccu.intersection-units", ccu.intersection_units),
            ("ccu.batch", ccu.batch),
            ("ccu.queue", ccu.queue),
            ("gsu.queue", gsu.queue),
            ("gsu.qsu-per-core", gsu.qsu_per_core),
            ("gsu.pivots", gsu.pivots),
            ("gsu.keys-per-cycle", gsu.keys_per_cycle),
            ("gsu.bsu-per-core", gsu.bsu_per_core),
            ("gsu.bsu-width", gsu.bsu_width),
            ("vru.cores", vru.cores),
            ("vru.units-per-core", vru.units_per_core),
            ("vru.pixels-per-unit", vru.pixels_per_unit),
            ("vru.subtile-queue", vru.subtile_queue),
            ("fovea.level-tests", machine.tiles().fovea.level_tests),
        ] {
            assert!(value > 0, "a machine with {key} = 0 passed its check");
        }
        let share = |buffer: &BufferSpec, n: u32| buffer.capacity.0 / u64::from(n);
        let (buffers, state) = (&machine.tiles().buffers, machine.tiles().state_bytes().0);
        let shares = Shares {
            gaussian_in: share(&buffers.gaussian_in, ccu.units),
            tile_list: share(&buffers.tile_list, ccu.units),
            sorting: share(&buffers.sorting, vru.cores),
            feature: share(&buffers.feature, vru.cores),
            pixel_out: share(&buffers.pixel_out, vru.cores).saturating_sub(state),
        };
        let sorting = Banks::new(&buffers.sorting);
        let (subtiles, pixels) =
            (machine.tiles().geometry.subtiles(), Banks::new(&buffers.pixel_out));
        // The state of one sub-tile is written and another one is read, through all banks (A86).
        let swapped = pixels.words(state / u64::from(subtiles));
        let swap = pixels.excess(swapped, swapped, 0);
        let subtile_pixels = machine.tiles().geometry.subtile.pow(2);
        let (key, chunk) =
            (machine.tiles().list_entry(), u64::from(machine.tiles().geometry.chunk));
        let binning = &machine.tiles().binning;
        let lists = [&binning.pointers, &binning.combining].map(|spec| {
            let is_there = binning.implementation != BinningImpl::Free && spec.capacity.0 > 0;
            is_there.then(|| Banks::new(spec))
        });
        let record = machine.tiles().record.of(degree, &machine.tiles().codebook);
        let converter = Ccu::new(
            ccu.clone(),
            (record, machine.tiles().codebook.of_degree(degree), degree, key),
            is_foveated.then(|| machine.tiles().fovea.clone()),
            shares.gaussian_in,
            Banks::new(&buffers.gaussian_in),
            Banks::new(&buffers.tile_list),
        );
        Self {
            ccu: converter
                .with_lists(lists, binning.pointer_size.0)
                .with_filter(machine.tiles().pixels.filters()),
            qsu: Qsu {
                spec: gsu.clone(),
                chunk,
                key,
                depth: u64::from(machine.tiles().record.depth_bits.div_ceil(8)),
                share: shares.sorting,
                banks: sorting,
            },
            bsu: Bsu { spec: gsu.clone(), chunk, key, banks: sorting },
            colour: Colour::of(machine, degree),
            vru: Vru {
                spec: vru.clone(),
                subtile: machine.tiles().geometry.subtile,
                feature: machine.tiles().record.feature.0,
                pixel: machine.tiles().record.pixel.0 + machine.tiles().pixels.kept().0,
                fovea: machine.tiles().fovea.clone(),
                features: Banks::new(&buffers.feature),
                pixels,
                subtiles,
                swapped,
                weights: (!gsu.sorts()).then_some(gsu.weights_per_cycle),
                discipline: Discipline::of(vru, subtiles, subtile_pixels, swap),
            },
            dram: Dram::new(&machine.dram, machine.dram_peak(), machine.clock, &STREAMS),
            shares,
            cache_word: machine.tiles().cache.word.0,
            gradients: GradientUnits::of(machine),
            rules: machine.tiles().rules.clone(),
        }
    }
}
