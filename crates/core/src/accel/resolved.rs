//! Resolved unit parameters: a machine as its units, with the share of each buffer that one unit or
//! core has to itself.

use super::bank::Banks;
use super::bsu::Bsu;
use super::ccu::Ccu;
use super::colour::Colour;
use super::dram::Dram;
use super::machine::{BinningMethod, BufferSpec, Machine};
use super::qsu::Qsu;
use super::rules::UnitRules;
use super::subtiles::Discipline;
use super::vru::Vru;
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
        let can = !is_foveated || machine.fovea.accumulators > 0;
        assert!(can, "a machine without accumulators for levels got a foveated frame");
        Self::of(machine, is_foveated, workload.sh_degree)
    }

    fn of(machine: &Machine, is_foveated: bool, degree: ShDegree) -> Self {
        let (ccu, gsu, vru) = (&machine.ccu, &machine.gsu, &machine.vru);
        for (key, value) in [
            ("geometry.chunk", machine.geometry.chunk),
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
            ("fovea.level-tests", machine.fovea.level_tests),
        ] {
            assert!(value > 0, "a machine with {key} = 0 passed its check");
        }
        let share = |buffer: &BufferSpec, n: u32| buffer.capacity.0 / u64::from(n);
        let (buffers, state) = (&machine.buffers, machine.state_bytes().0);
        let shares = Shares {
            gaussian_in: share(&buffers.gaussian_in, ccu.units),
            tile_list: share(&buffers.tile_list, ccu.units),
            sorting: share(&buffers.sorting, vru.cores),
            feature: share(&buffers.feature, vru.cores),
            pixel_out: share(&buffers.pixel_out, vru.cores).saturating_sub(state),
        };
        let sorting = Banks::new(&buffers.sorting);
        let (subtiles, pixels) = (machine.geometry.subtiles(), Banks::new(&buffers.pixel_out));
        let swapped = pixels.words(state / u64::from(subtiles));
        let swap = pixels.excess(swapped, swapped, 0);
        let subtile_pixels = machine.geometry.subtile.pow(2);
        let (key, chunk) = (machine.list_entry(), u64::from(machine.geometry.chunk));
        let binning = &machine.binning;
        let lists = [&binning.pointers, &binning.combining].map(|spec| {
            let is_there = binning.method != BinningMethod::Free && spec.capacity.0 > 0;
            is_there.then(|| Banks::new(spec))
        });
        let record = machine.record.of(degree, &machine.codebook);
        let converter = Ccu::new(
            ccu.clone(),
            (record, machine.codebook.of_degree(degree), degree, key),
            is_foveated.then(|| machine.fovea.clone()),
            shares.gaussian_in,
            Banks::new(&buffers.gaussian_in),
            Banks::new(&buffers.tile_list),
        );
        Self {
            ccu: converter.with_lists(lists, binning.pointer_size.0),
            qsu: Qsu { spec: gsu.clone(), chunk, key, share: shares.sorting, banks: sorting },
            bsu: Bsu { spec: gsu.clone(), chunk, key, banks: sorting },
            colour: Colour::of(machine, degree),
            vru: Vru {
                spec: vru.clone(),
                subtile: machine.geometry.subtile,
                feature: machine.record.feature.0,
                pixel: machine.record.pixel.0,
                fovea: machine.fovea.clone(),
                features: Banks::new(&buffers.feature),
                pixels,
                subtiles,
                swapped,
                discipline: Discipline::of(vru, subtiles, subtile_pixels, swap),
            },
            dram: Dram::new(&machine.dram, machine.dram_peak(), machine.clock),
            shares,
            cache_word: machine.cache.word.0,
            rules: machine.rules.clone(),
        }
    }
}
