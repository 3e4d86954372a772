//! Machines and workloads for the tests of the accelerator.

use powergs_core::flow::Tables;
use powergs_core::flow::over::levels::LevelsSpec;
use powergs_core::flow::tile_wise::{DepthUpdate, PixelsSpec, StereoSpec};
use powergs_core::machine::{
    BufferSpec, DramModel, DramSpec, GatingSpec, Machine, MasterSpec, MemoryOwner, NO_DEVICE,
    Ports, Priority,
};
use std::collections::BTreeMap;
use std::sync::LazyLock;

use powergs_base::config::embedded::DRAM;
use powergs_base::quantity::{Bytes, BytesPerSecond, Hertz, Nanoseconds};
use powergs_core::flow::tile_wise::*;
use powergs_core::workload::binning::ListWrites;
use powergs_core::workload::reuse::ListReuse;
use powergs_core::workload::{
    ChunkWork, FoveaWork, FrameWorkload, Geometry, GroupWork, PairWork, STORAGE_BLOCK,
    StoragePrefix, TileWork,
};
use powergs_dram::Device;
use powergs_dram::device::Order;
use powergs_frame::fovea::{Screen, ScreenGaze};
use powergs_frame::splat::{Counters, FoveaCounters};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A buffer that is never in the way of itself.
pub fn buffer(capacity: Bytes) -> BufferSpec {
    BufferSpec { capacity, word: Bytes(1), banks: 1024, ports: Ports::ReadAndWrite }
}

/// Operations of a conversion as `powergs` counts them.
fn operations() -> CcuOperations {
    CcuOperations { cull: 47, project: 208, obb_prepare: 38, sh_colour: 133 }
}

/// A machine with the published unit counts of GSCore, and record sizes of the PowerGS model.
pub fn gscore() -> Machine {
    let mut machine = unlinked();
    machine.link(device("lpddr4-3200-x16x8")).expect("a device of this machine");
    machine
}

/// A device that comes with the program.
pub fn device(name: &str) -> &'static Device {
    static DEVICES: LazyLock<BTreeMap<&str, Device>> = LazyLock::new(|| {
        DRAM.iter().map(|f| (f.name, Device::parse(f.text).expect("a good file"))).collect()
    });
    &DEVICES[name]
}

/// The machine with another peak rate of its memory, bytes per second, where it is a mere rate:
/// with the models of a device it stays what it is.
pub fn set_rate(machine: &mut Machine, rate: f64) {
    if machine.dram.model == DramModel::Bandwidth {
        machine.device = None;
        machine.dram.device = NO_DEVICE.into();
        machine.dram.bandwidth = Some(BytesPerSecond(rate));
    }
}

fn unlinked() -> Machine {
    let buffer = |kib: u64| buffer(Bytes(kib * 1024));
    Machine {
        name: "test".into(),
        description: "for tests".into(),
        clock: Hertz(1e9),
        energy: "test".into(),
        tables: Tables::new(TileWise {
            stereo: StereoSpec::default(),
            pixels: PixelsSpec::default(),
            levels: LevelsSpec::default(),
            training: TrainingSpec::default(),
            gradients: GradientsSpec::default(),
            geometry: Geometry::REFERENCE,
            record: RecordSpec {
                position: Bytes(6),
                geometry: Bytes(12),
                colour: Bytes(103),
                colour_extra: Bytes(7),
                projected: Bytes(10),
                depth_bits: 16,
                id_bits: 16,
                id_check: false,
                entry_bitmap: false,
                feature: Bytes(19),
                numbers: None,
                feature_source: FeatureSource::Nobody,
                pixel: Bytes(3),
                feature_pitch: Bytes(32),
                colour_pitch: Bytes(128),
            },
            codebook: CodebookSpec::default(),
            ccu: CcuSpec {
                units: 4,
                operations_per_cycle: 426,
                cull_operations_per_cycle: 0,
                colour_operations_per_cycle: 0,
                operations: operations(),
                intersection_units: 1,
                latency: 128,
                batch: 32,
                queue: 64,
                fetch: Fetch::LazyColour,
                clusters: 0,
                cluster: Bytes(16),
            },
            gsu: GsuSpec {
                qsu_per_core: 2,
                pivots: 7,
                keys_per_cycle: 1,
                qsu_latency: 64,
                bsu_per_core: 1,
                bsu_width: 16,
                bsu_latency: 4,
                queue: 1,
                spill: Spill::Overflow,
                pivot_rule: PivotRule::Range,
                depth: DepthKey::Fp16,
                implementation: GsuImpl::Split,
                fan_in: 2,
                margin: 16,
                reuse_period: 2,
                depth_update: DepthUpdate::Deferred,
                weights_per_cycle: 256,
            },
            vru: VruSpec {
                cores: 4,
                units_per_core: 16,
                pixels_per_unit: 4,
                latency: 192,
                recurrence: 4,
                subtile_skipping: true,
                termination: Termination::Subtile,
                blend_stall: 0,
                speculation: 0,
                tile_overlap: false,
                implementation: VruImpl::Serial,
                leaders_per_cycle: 8,
                spiky_from: 3,
                divisions_per_cycle: 4,
                subtile_queue: 16,
                entries_per_cycle: 1,
                pixel_state: Bytes(8),
                stop_latency: 0,
                colour_operations_per_cycle: 133,
                colour_latency: 2,
            },
            fovea: FoveaSpec {
                accumulators: 1,
                level_tests: 4,
                record: Bytes(19),
                feature: Bytes(8),
            },
            buffers: BufferSpecs {
                gaussian_in: buffer(8),
                tile_list: buffer(32),
                sorting: buffer(64),
                feature: buffer(128),
                pixel_out: buffer(16),
            },
            binning: BinningSpec {
                implementation: BinningImpl::Free,
                pointer_size: Bytes(4),
                pointers: buffer(32),
                combining: buffer(64),
                line: Bytes(32),
                partial: PartialWrite::Masked,
                block: Bytes(1024),
            },
            cache: CacheSpec {
                capacity: Bytes(0),
                ways: 4,
                eviction: Eviction::Lru,
                distance_bits: 8,
                word: Bytes(32),
                banks: 1,
            },
            schedule: ScheduleSpec {
                order: TileOrder::Raster,
                assignment: Assignment::Greedy,
                merge_below: 0,
                overlap: Overlap::None,
            },
            rules: UnitRules::default(),
        }),
        dram: DramSpec {
            model: DramModel::Bandwidth,
            bandwidth: None,
            efficiency: 1.0,
            latency: Nanoseconds(100.0),
            device: "test".into(),
            channels: 8,
            mapping: Order::RoBaCoCh,
            controller_latency: Nanoseconds(40.0),
            owner: MemoryOwner::Chip,
            standby_share: None,
            second_master: MasterSpec::default(),
            third_master: MasterSpec::default(),
            fourth_master: MasterSpec::default(),
        },
        gating: GatingSpec { units: false, residual: 0.1 },
        device: None,
    }
}

/// Lists of tiles, each a list of (entries, sub-tile pairs) of chunks; `unfetched` entries follow.
pub struct TilePlan {
    pub chunks: Vec<(u32, u32)>,
    pub unfetched: u32,
    pub pixels: u32,
}

/// A workload of `plan`, with `points` Gaussians of which all survive and none is tested. Without
/// points the frame begins with its tiles: nothing is converted.
pub fn workload(geometry: Geometry, points: u64, plan: &[TilePlan]) -> FrameWorkload {
    let mut w = FrameWorkload {
        geometry,
        width: geometry.tile * plan.len().max(1) as u32,
        height: geometry.tile,
        tiles_x: plan.len() as u32,
        tiles_y: 1,
        counters: Counters { points, survivors: points, ..Counters::default() },
        ..FrameWorkload::empty(geometry)
    };
    for tile in plan {
        let loaded: u32 = tile.chunks.iter().map(|c| c.0).sum();
        w.tiles.push(TileWork {
            list_start: w.counters.tile_pairs as u32,
            entries: loaded + tile.unfetched,
            loaded,
            chunk_start: w.chunks.len() as u32,
            chunks: tile.chunks.len() as u32,
            pixels: tile.pixels,
            alpha_evaluations: u64::from(loaded * tile.pixels),
            blends: u64::from(loaded),
            ..TileWork::default()
        });
        w.counters.tile_pairs += u64::from(loaded + tile.unfetched);
        w.counters.tile_loads += u64::from(loaded);
        w.counters.alpha_evaluations += u64::from(loaded * tile.pixels);
        w.counters.blends += u64::from(loaded);
        for &(entries, pairs) in &tile.chunks {
            w.chunks.push(ChunkWork {
                entries,
                skipping: PairWork {
                    subtile_pairs: pairs,
                    live_evaluations: pairs,
                    ..PairWork::default()
                },
                unskipped: PairWork {
                    subtile_pairs: pairs.max(entries * geometry.subtiles()),
                    ..PairWork::default()
                },
                first_loads: entries / 2,
                ..ChunkWork::default()
            });
            w.counters.fetched_points += u64::from(entries / 2);
        }
    }
    w.counters.intersecting_points = points.min(w.counters.tile_pairs);
    (w.list, w.index, w.slot) = (vec![0; w.counters.tile_pairs as usize], vec![0], vec![0]);
    if points == 0 {
        w.counters.tile_pairs = 0;
    }
    w
}

/// Records that are read where clusters of which nobody survives are not.
fn live_records(w: &FrameWorkload, machine: &Machine) -> Vec<u32> {
    let points = w.counters.points as u32;
    let size = machine.tiles().ccu.clusters;
    if size == 0 || w.storage.is_empty() {
        return (0..points).collect();
    }
    let survivors = |record: u32| match record.div_ceil(STORAGE_BLOCK as u32) {
        0 => 0,
        blocks => w.storage[(blocks as usize).min(w.storage.len()) - 1].survivors,
    };
    let lives = |&record: &u32| {
        let first = record / size * size;
        survivors(first) < survivors((first + size).min(points))
    };
    (0..points).filter(lives).collect()
}

/// A source of small random machines and workloads.
pub struct Dice(Pcg64Mcg);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Dice(Pcg64Mcg::seed_from_u64(seed))
    }

    /// Between `low` and `high`, both possible.
    pub fn roll(&mut self, low: u32, high: u32) -> u32 {
        self.0.random_range(low..=high)
    }

    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.0.random_range(0..from.len())]
    }

    /// Any machine that could pass a check, small enough that every limit is met: buffers that
    /// hold nothing, one item or many, fast and slow memories, few and many units.
    pub fn machine(&mut self) -> Machine {
        let chunk = self.pick(&[1, 3, 4, 8]);
        let mut machine = gscore();
        // Of its own, so that the rest is what it was before there were merges.
        let mut order = Dice(self.0.clone());
        let mut engines = Dice(self.0.clone());
        let (subtile, sort_group) = (self.pick(&[4, 8]), self.pick(&[16, 16, 32, 64]));
        machine.tiles_mut().geometry =
            Geometry { chunk, subtile, sort_group, ..Geometry::REFERENCE };
        let bytes = |dice: &mut Self, most| Bytes(u64::from(dice.roll(0, most)));
        machine.tiles_mut().record = RecordSpec {
            numbers: None,
            position: bytes(self, 6),
            geometry: bytes(self, 12),
            colour: bytes(self, 20),
            colour_extra: Bytes(0),
            projected: bytes(self, 10),
            depth_bits: self.roll(1, 16),
            id_bits: self.roll(1, 16),
            id_check: false,
            entry_bitmap: self.roll(0, 1) == 1,
            feature: bytes(self, 19),
            feature_source: FeatureSource::Nobody,
            pixel: bytes(self, 3),
            feature_pitch: Bytes(32),
            colour_pitch: Bytes(128),
        };
        machine.tiles_mut().ccu = CcuSpec {
            units: self.roll(1, 3),
            operations_per_cycle: self.roll(100, 500),
            cull_operations_per_cycle: engines.pick(&[0, 0, 40]),
            colour_operations_per_cycle: engines.pick(&[0, 0, 90]),
            operations: operations(),
            intersection_units: self.roll(1, 3),
            latency: self.roll(0, 9),
            batch: self.roll(1, 6),
            queue: self.pick(&[1, 2, 64]),
            fetch: self.pick(&[
                Fetch::Everything,
                Fetch::GeometryFirst,
                Fetch::VisibleColour,
                Fetch::LazyColour,
            ]),
            clusters: 0,
            cluster: Bytes(16),
        };
        machine.tiles_mut().gsu = GsuSpec {
            qsu_per_core: self.roll(1, 2),
            pivots: self.roll(1, 3),
            keys_per_cycle: self.roll(1, 2),
            qsu_latency: self.roll(0, 5),
            bsu_per_core: self.roll(1, 2),
            bsu_width: self.pick(&[1, 2, 4]),
            bsu_latency: self.roll(0, 3),
            queue: self.roll(1, 3),
            spill: self.pick(&[Spill::Overflow, Spill::Overflow, Spill::All]),
            pivot_rule: PivotRule::Range,
            depth: DepthKey::Fp16,
            implementation: order.pick(&[GsuImpl::Split, GsuImpl::Merge, GsuImpl::None]),
            fan_in: order.roll(2, 4),
            margin: 16,
            reuse_period: 2,
            depth_update: order.pick(&[DepthUpdate::Deferred, DepthUpdate::Fetched]),
            weights_per_cycle: order.roll(1, 5),
        };
        // Nobody looks through the list of a group then.
        let group = machine.tiles().geometry.sort_group;
        let gsu = &mut machine.tiles_mut().gsu;
        if gsu.implementation == GsuImpl::None && group != Geometry::REFERENCE.tile {
            gsu.implementation = GsuImpl::Merge;
        }
        machine.tiles_mut().vru = VruSpec {
            cores: self.roll(1, 3),
            units_per_core: self.pick(&[1, 4, 16]),
            pixels_per_unit: self.pick(&[1, 4]),
            latency: self.roll(0, 9),
            recurrence: self.pick(&[1, 4, 6]),
            subtile_skipping: self.roll(0, 1) == 1,
            termination: self.pick(&[
                Termination::Pixel,
                Termination::Quad,
                Termination::Subtile,
                Termination::Tile,
            ]),
            blend_stall: self.roll(0, 2),
            speculation: self.roll(0, 3),
            tile_overlap: self.roll(0, 1) == 1,
            ..machine.tiles().vru
        };
        if machine.tiles().vru.termination == Termination::Pixel {
            machine.tiles_mut().vru.pixels_per_unit = 4;
        }
        let buffer = |dice: &mut Self, most| BufferSpec {
            capacity: bytes(dice, most),
            word: Bytes(dice.pick(&[1, 4, 16, 64])),
            banks: dice.pick(&[1, 2, 8]),
            ports: dice.pick(&[Ports::ReadOrWrite, Ports::ReadAndWrite]),
        };
        machine.tiles_mut().schedule = ScheduleSpec {
            order: self.pick(&[TileOrder::Raster, TileOrder::Morton, TileOrder::Hilbert]),
            assignment: self.pick(&[
                Assignment::Static,
                Assignment::Greedy,
                Assignment::Greedy,
                Assignment::LongestFirst,
            ]),
            merge_below: self.pick(&[0, 0, 10, 50]),
            overlap: self.pick(&[Overlap::None, Overlap::None, Overlap::Tiles, Overlap::Frames]),
        };
        machine.tiles_mut().buffers = BufferSpecs {
            gaussian_in: buffer(self, 600),
            tile_list: buffer(self, 400),
            sorting: buffer(self, 150),
            feature: buffer(self, 900),
            pixel_out: buffer(self, 1000),
        };
        let (flat, banked) = (DramModel::Bandwidth, DramModel::Banked);
        let model = self.pick(&[flat, flat, flat, banked]);
        let rate = self.pick(&[3e9, 10e9, 51.2e9, 900e9]);
        machine.dram = DramSpec {
            model,
            bandwidth: None,
            efficiency: self.pick(&[0.6, 1.0]),
            latency: Nanoseconds(f64::from(self.roll(0, 250)) / 10.0),
            device: "test".into(),
            channels: self.pick(&[1, 2, 8]),
            mapping: Order::RoBaCoCh,
            controller_latency: Nanoseconds(f64::from(self.roll(0, 30))),
            owner: MemoryOwner::Chip,
            standby_share: None,
            second_master: MasterSpec::default(),
            third_master: MasterSpec::default(),
            fourth_master: MasterSpec::default(),
        };
        let devices = ["lpddr4-3200-x16x8", "lpddr4-3200-x32x4", "hbm2-8ch"];
        machine.link(device(self.pick(&devices))).expect("a device of this machine");
        set_rate(&mut machine, rate);
        machine
    }

    /// A small workload of a machine's geometry.
    pub fn workload(&mut self, geometry: Geometry) -> FrameWorkload {
        let n_tiles = self.roll(0, 8);
        let most = self.pick(&[1, 5, 12]) * geometry.chunk;
        let plan: Vec<TilePlan> = (0..n_tiles)
            .map(|_| {
                let entries = self.roll(0, 3).min(1) * self.roll(1, most);
                let n_chunks = entries.div_ceil(geometry.chunk);
                let fetched = self.roll(n_chunks.min(1), n_chunks);
                let loaded = (fetched * geometry.chunk).min(entries);
                let chunks = (0..fetched).map(|c| {
                    let entries = geometry.chunk.min(loaded - c * geometry.chunk);
                    (entries, self.roll(0, entries * geometry.subtiles().min(5)))
                });
                let chunks = chunks.collect();
                TilePlan { chunks, unfetched: entries - loaded, pixels: self.roll(1, 256) }
            })
            .collect();
        let points = u64::from(self.pick(&[10, 40, 100]) * self.roll(0, 10) / 10);
        let mut w = workload(geometry, points, &plan);
        let pairs = w.tiles.iter().map(|tile| u64::from(tile.entries)).sum();
        let c = &mut w.counters;
        c.tile_pairs = pairs;
        c.survivors = u64::from(self.roll(0, points as u32));
        c.obb_prepared = u64::from(self.roll(0, c.survivors as u32));
        c.obb_tests = c.obb_prepared * u64::from(self.roll(1, 6));
        c.intersecting_points = c.survivors.min(c.tile_pairs);
        self.group(&mut w);
        self.store(&mut w);
        self.place(&mut w);
        w
    }

    /// What a feature cache has, for every second frame.
    pub fn hits(&mut self, workload: &FrameWorkload) -> Option<Vec<u32>> {
        let has_cache = self.roll(0, 1) == 1;
        has_cache.then(|| workload.chunks.iter().map(|c| self.roll(0, c.entries)).collect())
    }

    /// What tiles keep of the frame before, for every third frame; sort groups keep nothing.
    pub fn reuse(&mut self, workload: &FrameWorkload) -> Option<Vec<ListReuse>> {
        let keeps = self.roll(0, 2) == 0 && workload.groups.is_empty();
        keeps.then(|| {
            let tiles = workload.tiles.iter();
            let of = |tile: &TileWork| {
                let kept = self.roll(0, tile.entries);
                ListReuse {
                    kept,
                    new: tile.entries - kept,
                    gone: self.roll(0, 5),
                    ..ListReuse::default()
                }
            };
            tiles.map(of).collect()
        })
    }

    /// Another model of the memory, or another user of it.
    pub fn memory(&mut self, machine: &mut Machine) {
        if machine.dram.model == DramModel::Banked && self.roll(0, 1) == 0 {
            machine.dram.model = DramModel::Calibrated;
        }
        if machine.dram.model != DramModel::Bandwidth && self.roll(0, 1) == 0 {
            // So much that the accelerator gets somewhere.
            machine.dram.second_master = self.master(machine, &[0.02, 0.1, 0.3]);
            if self.roll(0, 1) == 0 {
                machine.dram.fourth_master = self.master(machine, &[0.01, 0.05]);
            }
        }
    }

    fn master(&mut self, machine: &Machine, shares: &[f64]) -> MasterSpec {
        let rate = machine.dram_peak().0 * self.pick(shares);
        let guaranteed = self.pick(&[0.0, 0.0, 0.5]);
        let mut master = MasterSpec {
            rate: BytesPerSecond(rate),
            request: Bytes(self.pick(&[32, 64, 256])),
            reads: self.pick(&[0.0, 0.5, 1.0]),
            in_flight: self.pick(&[1, 4, 64]),
            priority: self.pick(&[Priority::First, Priority::Equal, Priority::Last]),
            ..MasterSpec::default()
        };
        // What goes first leaves something to the accelerator.
        let ceiling = master.ceiling(machine.device.as_ref().expect("linked"));
        master.rate.0 = master.rate.0.min(0.2 * ceiling);
        master.guaranteed.0 = master.rate.0 * guaranteed;
        master
    }

    /// A feature cache in every second machine; returns whether there is one.
    pub fn cache(&mut self, machine: &mut Machine) -> bool {
        let has_cache = self.roll(0, 1) == 0;
        if has_cache {
            machine.tiles_mut().cache = CacheSpec {
                capacity: Bytes(u64::from(self.roll(1, 64)) * 32),
                ways: self.pick(&[1, 2, 4]),
                eviction: self.pick(&[Eviction::Lru, Eviction::ReuseDistance]),
                ..machine.tiles().cache.clone()
            };
        }
        has_cache
    }

    /// A machine that differs in one key, and needs the same of a frame.
    pub fn another(&mut self, machine: &Machine) -> Machine {
        let mut other = machine.clone();
        let n = self.roll(1, 3);
        let m = other.tiles_mut();
        match self.roll(0, 19) {
            0 => m.ccu.units += n,
            1 => m.ccu.operations_per_cycle += 50 * n,
            2 => m.ccu.intersection_units += n,
            3 => m.ccu.latency += n,
            4 => m.ccu.batch += n,
            5 => m.ccu.queue += n,
            6 => m.record.position.0 += u64::from(n),
            7 => m.record.colour.0 += u64::from(n),
            8 => m.buffers.gaussian_in.capacity.0 += 40 * u64::from(n),
            9 => m.buffers.gaussian_in.banks *= 2,
            10 => m.buffers.tile_list.capacity.0 += 40 * u64::from(n),
            11 => m.buffers.tile_list.word.0 *= 2,
            12 => m.vru.cores += n,
            13 => m.vru.latency += n,
            14 => m.gsu.qsu_latency += n,
            15 => m.buffers.feature.capacity.0 += 100 * u64::from(n),
            16 => m.codebook.banks += n,
            17 => m.codebook.word.0 += u64::from(n),
            18 => other.dram.latency.0 += f64::from(n),
            _ => other.dram.controller_latency.0 += f64::from(n),
        }
        other
    }

    /// Clusters of Gaussians in every third machine, some of which nobody sees.
    pub fn clusters(&mut self, w: &mut FrameWorkload, machine: &mut Machine) {
        if self.roll(0, 2) > 0 || w.counters.survivors == 0 {
            return;
        }
        let m = machine.tiles_mut();
        // Bounds are measured in positions, of which no checked machine has none.
        m.record.position.0 = m.record.position.0.max(1);
        let ccu = &mut m.ccu;
        ccu.clusters = self.pick(&[32, 32, 64, 96]);
        ccu.cluster = Bytes(u64::from(self.roll(1, 40)));
        let Some(&all) = w.storage.last() else { return };
        // Nothing of a block is counted of which nobody survives.
        let (mut before, mut last) = (StoragePrefix::default(), None);
        for (i, block) in w.storage.iter_mut().enumerate() {
            let lives = self.roll(0, 1) == 1;
            match lives && block.survivors > before.survivors {
                true => (before, last) = (*block, Some(i)),
                false => *block = before,
            }
        }
        let last = last.unwrap_or(self.roll(0, w.storage.len() as u32 - 1) as usize);
        w.storage[last..].fill(all);
    }

    /// Lists with pointers in every second frame that can have them.
    pub fn lists(
        &mut self,
        w: &mut FrameWorkload,
        machine: &mut Machine,
        has_order: bool,
    ) -> Option<ListWrites> {
        let (splats, points) = (w.counters.intersecting_points as u32, w.counters.points as u32);
        if has_order || splats == 0 || self.roll(0, 1) == 0 {
            return None;
        }
        let live = live_records(w, machine);
        for rank in 0..w.slot.len() {
            w.slot[rank] = self.roll(0, splats - 1);
            let index = self.roll(0, points - 1);
            // What has a tile is in a cluster of which something survives.
            w.index[rank] =
                if live.contains(&index) { index } else { live[index as usize % live.len()] };
        }
        self.binning(machine);
        machine.tiles().list_shape().map(|shape| ListWrites::new(w, shape))
    }

    /// Lists with pointers.
    pub fn binning(&mut self, machine: &mut Machine) {
        let can_count = machine.tiles().schedule.overlap == Overlap::None;
        let (entry, line) = (machine.tiles().list_entry(), self.pick(&[16, 32, 64]));
        let buffer = |dice: &mut Self, unit: u64| BufferSpec {
            capacity: Bytes(unit * dice.pick(&[0, 1, 3, 100])),
            word: Bytes(dice.pick(&[4, 32])),
            banks: dice.pick(&[1, 4]),
            ports: dice.pick(&[Ports::ReadOrWrite, Ports::ReadAndWrite]),
        };
        let line = line.max(entry.next_power_of_two());
        machine.tiles_mut().binning = BinningSpec {
            implementation: self.pick(&match can_count {
                true => [BinningImpl::Append, BinningImpl::TwoPass],
                false => [BinningImpl::Append; 2],
            }),
            pointer_size: Bytes(4),
            pointers: buffer(self, 4),
            combining: buffer(self, line),
            line: Bytes(line),
            partial: self.pick(&[PartialWrite::Masked, PartialWrite::ReadModifyWrite]),
            block: Bytes(line * self.pick(&[1, 4])),
        };
    }

    /// Sort groups with the lists of their tiles.
    fn group(&mut self, w: &mut FrameWorkload) {
        let side = w.geometry.tiles_per_group_side() as usize;
        if side == 1 {
            return;
        }
        for tiles in w.tiles.chunks(side) {
            let most: u32 = tiles.iter().map(|tile| tile.entries).sum();
            let mut sorted = 0;
            for tile in tiles {
                let mut end = 0;
                for chunk in &mut w.chunks[tile.chunk_start as usize..][..tile.chunks as usize] {
                    end += chunk.entries;
                    let later = end + self.roll(0, most - tile.entries);
                    chunk.group_end = chunk.group_end.max(later).min(most);
                    sorted = sorted.max(chunk.group_end.next_multiple_of(w.geometry.chunk));
                }
                let chunks = &mut w.chunks[tile.chunk_start as usize..][..tile.chunks as usize];
                let mut last = 0;
                for chunk in chunks {
                    last = chunk.group_end.max(last);
                    chunk.group_end = last;
                }
            }
            w.groups.push(GroupWork { entries: most, sorted: sorted.min(most) });
        }
    }

    /// Makes a foveated frame of every second one: some tiles have two levels, and the machine one
    /// or two accumulators.
    pub fn foveate(&mut self, w: &mut FrameWorkload, machine: &mut Machine) {
        if self.roll(0, 1) == 0 {
            return;
        }
        machine.tiles_mut().fovea = FoveaSpec {
            accumulators: self.roll(1, 2),
            level_tests: self.roll(1, 4),
            record: Bytes(u64::from(self.roll(0, 19))),
            feature: Bytes(u64::from(self.roll(0, 8))),
        };
        let mut fovea = FoveaWork {
            gaze: ScreenGaze { point: [0.5; 2], screen: Screen::PUBLISHED },
            regions: w.tiles.iter().map(|_| self.roll(0, 3) as u8).collect(),
            blending_tiles: 0,
            counters: FoveaCounters::default(),
        };
        let lookups = w.counters.obb_tests as u32 + self.roll(0, 40);
        fovea.counters.lookups = u64::from(lookups) * u64::from(w.counters.points > 0);
        let (mut at, blocks) = (0, w.storage.len());
        for (i, block) in w.storage.iter_mut().enumerate() {
            at = if i + 1 == blocks { lookups } else { self.roll(at, lookups) };
            block.lookups = at;
        }
        for tile in &mut w.tiles {
            let blends = self.roll(0, 1) == 1;
            for chunk in &mut w.chunks[tile.chunk_start as usize..][..tile.chunks as usize] {
                chunk.level_loads = self.roll(0, 3 * chunk.first_loads);
                if blends {
                    chunk.seconds = self.roll(0, chunk.entries);
                    // Skipping executes a part of what is executed without.
                    chunk.skipping.both_pairs = self.roll(0, chunk.skipping.subtile_pairs);
                    let least = chunk.skipping.both_pairs;
                    let most = chunk.unskipped.subtile_pairs.max(least);
                    chunk.unskipped.both_pairs = self.roll(least, most);
                }
            }
            if blends {
                tile.mixed = tile.pixels;
                tile.blends_2 = u64::from(self.roll(0, tile.loaded));
                tile.extra_alpha = tile.blends_2;
                fovea.blending_tiles += 1;
            }
            fovea.counters.blends_2 += tile.blends_2;
        }
        w.fovea = Some(fovea);
    }

    /// A colour unit that is fast enough or not.
    pub fn colour(&mut self, machine: &mut Machine) {
        machine.tiles_mut().vru.colour_operations_per_cycle = self.pick(&[7, 50, 133, 4000]);
        machine.tiles_mut().vru.colour_latency = self.pick(&[0, 0, 1, 13]);
        machine.tiles_mut().codebook = CodebookSpec {
            entries: self.pick(&[0, 0, 0, 16]),
            entry: Bytes(u64::from(self.roll(1, 90))),
            word: Bytes(u64::from(self.roll(1, 32))),
            banks: self.roll(1, 3),
        };
    }

    /// Gives every second machine another organisation of its rendering units, and the frame what
    /// that needs.
    pub fn organise(&mut self, w: &mut FrameWorkload, machine: &mut Machine) {
        if self.roll(0, 1) == 0 {
            return;
        }
        let (g, vru) = (machine.tiles().geometry, &mut machine.tiles_mut().vru);
        vru.implementation = self.pick(&[
            VruImpl::Parallel,
            VruImpl::Parallel,
            VruImpl::Serial,
            VruImpl::Swap,
            VruImpl::Scan,
        ]);
        if vru.implementation == VruImpl::Parallel {
            vru.units_per_core = g.subtiles() * self.pick(&[1, 2]);
        }
        if vru.implementation == VruImpl::Scan && vru.termination == Termination::Tile {
            vru.termination = Termination::Subtile;
        }
        vru.subtile_queue = self.pick(&[1, 2, 3, 16, 65536]);
        vru.pixel_state = Bytes(u64::from(self.roll(1, 8)));
        vru.stop_latency = self.pick(&[0, 0, 1, 7, 40]);
        // The last tile is cut off by the edge of the image.
        w.width -= self.roll(0, g.tile - 1).min(w.width);
        w.height -= self.roll(0, g.tile - 1);
        let (entries, bytes) = (w.list.len(), g.subtiles().div_ceil(8) as usize);
        w.bitmaps = vec![0; entries * bytes];
        for tile in 0..w.tiles.len() {
            let work = w.tiles[tile];
            let inside: Vec<usize> = w.subtiles_inside(tile).collect();
            let density = self.pick(&[1, 3, 9]);
            for entry in work.list_start..work.list_start + work.entries {
                for &s in &inside {
                    let bit = u8::from(self.roll(1, 10) <= density);
                    w.bitmaps[entry as usize * bytes + s / 8] |= bit << (s % 8);
                }
            }
            let most = self.roll(0, work.loaded);
            for s in 0..g.subtiles() as usize {
                let mut stops: [u32; 4] = std::array::from_fn(|_| self.roll(0, most));
                stops.sort_unstable_by(|a, b| b.cmp(a));
                w.stops.push(if inside.contains(&s) { stops } else { [0; 4] });
            }
        }
    }

    /// Counters in storage order: of some frames only.
    fn store(&mut self, w: &mut FrameWorkload) {
        if self.roll(0, 2) == 0 || w.counters.points == 0 {
            return;
        }
        let n = w.counters.points.div_ceil(STORAGE_BLOCK);
        let c = w.counters;
        let totals =
            [c.survivors, c.obb_prepared, c.obb_tests, c.intersecting_points, c.tile_pairs];
        let mut at = [0; 5];
        for block in 1..=n {
            for (x, total) in at.iter_mut().zip(totals) {
                *x = if block == n { total as u32 } else { self.roll(*x, total as u32) };
            }
            let [survivors, prepared, tests, splats, pairs] = at;
            let lookups = 0;
            w.storage.push(StoragePrefix { survivors, prepared, tests, splats, pairs, lookups });
        }
        for tile in &mut w.tiles {
            tile.complete_after = self.roll(0, c.intersecting_points as u32);
        }
    }

    /// Lists and addresses.
    fn place(&mut self, w: &mut FrameWorkload) {
        let most = 50;
        w.index = (0..=most).map(|_| self.roll(0, 1000)).collect();
        w.slot = (0..=most).map(|_| self.roll(0, 1000)).collect();
        let entries: u32 = w.tiles.iter().map(|tile| tile.entries).sum();
        w.list = (0..entries).map(|_| self.roll(0, most)).collect();
    }
}
