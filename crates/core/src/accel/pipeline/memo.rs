//! What preprocessing leaves behind, kept for machines that preprocess alike.
//!
//! With `schedule.overlap = "none"` cores begin when all CCUs have ended (A28). With the
//! `bandwidth` model nothing about the memory depends on addresses. So on one frame everything up
//! to that cycle follows from the CCUs, their buffers, the records and the rate of the memory:
//! machines that differ elsewhere share it.

use std::sync::{Arc, Mutex, PoisonError};

use super::preprocess::Converter;
use super::{Agents, Shared};
use crate::accel::Machine;
use crate::accel::bank::Banks;
use crate::accel::design::Design;
use crate::accel::dram::{Channel, Dram};
use crate::accel::machine::{CcuSpec, DramModel, FoveaSpec, Overlap, RecordSpec};
use crate::accel::timeline::Observer;
use crate::accel::traffic::Traffic;

/// Most that is kept; machines beyond that are preprocessed each for itself.
const KEPT_MAX: usize = 4096;

/// The preprocessing of one frame on machines that were met before.
#[derive(Debug, Default)]
pub struct Memo(Mutex<Vec<(Key, Arc<Left>)>>);

/// Everything that preprocessing depends on, beside the frame.
#[derive(Debug, PartialEq)]
struct Key {
    ccu: CcuSpec,
    record: RecordSpec,
    /// Further bytes of records and look-ups a cycle in foveated frames.
    fovea: FoveaSpec,
    batch: u32,
    banks: [Banks; 2],
    shares: [u64; 2],
    dram: Dram,
}

/// What is there when preprocessing ends.
#[derive(Debug)]
struct Left {
    converters: Vec<Converter>,
    channel: Channel,
    traffic: Traffic,
}

impl Memo {
    /// What machines have in common that share their preprocessing on a frame; `None` for one that
    /// always preprocesses for itself.
    pub fn shared_by(machine: &Machine) -> Option<String> {
        let is_apart = machine.schedule.overlap == Overlap::None
            && machine.dram.model == DramModel::Bandwidth
            && machine.gsu.reuse_period == 1;
        is_apart.then(|| format!("{:?}", Key::of(&Design::new(machine))))
    }

    fn find(&self, key: &Key) -> Option<Arc<Left>> {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().find(|(k, _)| k == key).map(|(_, left)| Arc::clone(left))
    }

    fn keep(&self, key: Key, left: Left) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() < KEPT_MAX && !kept.iter().any(|(k, _)| *k == key) {
            kept.push((key, Arc::new(left)));
        }
    }
}

impl Key {
    fn of(design: &Design) -> Key {
        Key {
            ccu: design.ccu.spec.clone(),
            record: design.ccu.record.clone(),
            fovea: design.vru.fovea.clone(),
            batch: design.ccu.batch,
            banks: [design.ccu.input, design.ccu.output],
            shares: [design.shares.gaussian_in, design.shares.tile_list],
            dram: design.dram,
        }
    }
}

/// Whether what a machine leaves may be kept: not with another overlap or memory model, and not
/// where lists are updated, which changes what CCUs write.
pub(super) fn is_apart<O: Observer>(machine: &Machine, shared: &Shared<O>) -> bool {
    machine.schedule.overlap == Overlap::None
        && shared.memory.flat().is_some()
        && shared.given.reuse.is_none()
}

/// Preprocesses, or takes over what a machine that preprocesses alike has left.
pub(super) fn preprocess<O: Observer>(
    agents: &mut Agents,
    shared: &mut Shared<O>,
    memo: Option<&Memo>,
) {
    let units = agents.converters.len();
    let Some(memo) = memo else { return agents.drive(0..units, 0, shared) };
    let key = Key::of(shared.design);
    if let Some(left) = memo.find(&key) {
        agents.converters.clone_from(&left.converters);
        shared.memory.set_flat(left.channel.clone(), left.traffic);
        return;
    }
    agents.drive(0..units, 0, shared);
    if let Some((channel, traffic)) = shared.memory.flat() {
        let converters = agents.converters.clone();
        memo.keep(key, Left { converters, channel: channel.clone(), traffic });
    }
}
