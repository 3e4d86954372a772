//! The statistics of a reference picture, kept for comparisons.

use rayon::prelude::*;

use super::axis::Axis;
use super::plane::Plane;
use super::pool::{PoolGrid, PoolScratch, pooled};
use super::pyramid::Pyramid;
use super::{LEVELS, MAPS};

/// The statistics of a picture at the poolings of a measure.
#[derive(Debug)]
pub struct Reference {
    maps: Vec<MapReference>,
    lowest: [Plane; 3],
    poolings: usize,
}

/// The statistics of one map.
#[derive(Debug)]
pub(crate) struct MapReference {
    /// The map, where some pooling changes nothing.
    map: Option<Plane>,
    /// Per pooling; `None` where it changes nothing.
    grids: Vec<Option<PoolGrid>>,
}

impl MapReference {
    /// The statistics at a pooling, `None` where it changes nothing.
    pub(crate) fn pooled(&self, pooling: usize) -> Option<&PoolGrid> {
        self.grids[pooling].as_ref()
    }

    /// The map.
    pub(crate) fn map(&self) -> &Plane {
        self.map.as_ref().expect("kept where a pooling changes nothing")
    }
}

impl Reference {
    pub(super) fn of(pyramid: &Pyramid, axes: &[[[Axis; 2]; LEVELS]]) -> Reference {
        let maps = (0..3 * MAPS)
            .into_par_iter()
            .map_init(PoolScratch::default, |scratch, i| {
                let (level, map) = pyramid.map(i);
                let grids: Vec<_> = axes
                    .iter()
                    .map(|a| &a[level])
                    .map(|a| {
                        let same = a.iter().all(|axis| axis.is_identity);
                        (!same).then(|| pooled(map, a, scratch))
                    })
                    .collect();
                let map = grids.iter().any(Option::is_none).then(|| map.clone());
                MapReference { map, grids }
            })
            .collect();
        let lowest = std::array::from_fn(|c| pyramid.lowest(c).clone());
        Reference { maps, lowest, poolings: axes.len() }
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        let plane = |p: &Plane| size_of::<f32>() * p.values.capacity();
        let of_map = |m: &MapReference| {
            m.map.as_ref().map_or(0, plane)
                + m.grids.iter().flatten().map(PoolGrid::bytes).sum::<usize>()
        };
        self.maps.iter().map(of_map).sum::<usize>() + self.lowest.iter().map(plane).sum::<usize>()
    }

    pub(super) fn map(&self, i: usize) -> &MapReference {
        &self.maps[i]
    }

    pub(super) fn lowest(&self, channel: usize) -> &Plane {
        &self.lowest[channel]
    }

    /// Number of poolings.
    pub(super) fn poolings(&self) -> usize {
        self.poolings
    }
}
