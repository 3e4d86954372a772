//! Measurements beside the timing: order of the lists, feature cache, sort reuse.

use super::{List, count, real};
use crate::flow::{KernelSummary, PixelSummary, StepSummary, gpu, resident, tile_wise};
use crate::sim::statistics::Key;
use crate::sim::{CacheSummary, FrameReport, ListOrder, OrderSummary, StereoSummary};
use crate::workload::reuse::ReuseSummary;

/// A share of two counts; `None` where there is nothing to share.
fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

fn sorted(frame: &FrameReport) -> Option<&OrderSummary> {
    match frame.cycle()?.lists.as_ref()? {
        ListOrder::Sorted(order) => Some(order),
        ListOrder::Reused(_) => None,
    }
}

fn reused(frame: &FrameReport) -> Option<&ReuseSummary> {
    match frame.cycle()?.lists.as_ref()? {
        ListOrder::Sorted(_) => None,
        ListOrder::Reused(reuse) => Some(reuse),
    }
}

fn cached(frame: &FrameReport) -> Option<&CacheSummary> {
    frame.cycle()?.cache.as_ref()
}

pub(super) fn order(list: &mut List) {
    let of = |f: &FrameReport, field: fn(&OrderSummary) -> u64| sorted(f).map(field);
    let text = "Neighbours in the lists that were sorted with the machine's keys.";
    count(list, "order.neighbours", "1", text, move |f| of(f, |o| o.neighbours));
    let text = "Neighbours that came out in the wrong order of depth.";
    count(list, "order.out_of_order", "1", text, move |f| of(f, |o| o.out_of_order));
    let text = "Neighbours whose keys are equal although their depths are not.";
    count(list, "order.equal_keys", "1", text, move |f| of(f, |o| o.equal_keys));
    let text = "Pairs of the same list, neighbours or not, that came out in the wrong order.";
    count(list, "order.inversions", "1", text, move |f| of(f, |o| o.inversions));
    let text = "Share of the neighbours that came out in the wrong order, 0 to 1.";
    real(list, "order.out_of_order_frac", "1", text, |f, _| {
        let o = sorted(f)?;
        share(o.out_of_order, o.neighbours)
    });
}

pub(super) fn cache(list: &mut List) {
    let of = |f: &FrameReport, field: fn(&CacheSummary) -> u64| cached(f).map(field);
    let text = "Feature records that were found in the feature cache.";
    count(list, "cache.hits", "1", text, move |f| of(f, |c| c.hits));
    let text = "Feature records that had to be read from DRAM.";
    count(list, "cache.misses", "1", text, move |f| of(f, |c| c.misses));
    let text = "Share of the feature records that were found in the feature cache, 0 to 1.";
    real(list, "cache.hit_frac", "1", text, |f, _| {
        let c = cached(f)?;
        share(c.hits, c.hits + c.misses)
    });
}

pub(super) fn stereo(list: &mut List) {
    fn of(f: &FrameReport) -> Option<&StereoSummary> {
        f.cycle()?.stereo.as_ref()
    }
    let text = "Pairs of splats and tiles that the first eye handed on to the second one.";
    count(list, "stereo.handed_on", "1", text, |f| of(f).map(|s| s.handed_on));
    let text = "Entries of the lists of the second eye, which are made of these.";
    count(list, "stereo.kept", "1", text, |f| of(f).map(|s| s.kept));
    let text = "Share of the entries of its own lists that the second eye needs, 0 to 1.";
    real(list, Key::SecondEyeKept, "1", text, |f, _| of(f).and_then(|s| share(s.kept, s.entries)));
    let text = "Share of the blends of the second eye that it loses, because their splats blend \
                nowhere under them in the first eye, 0 to 1.";
    real(list, "stereo.lost_blends_frac", "1", text, |f, _| {
        of(f).and_then(|s| share(s.lost_blends, s.blends))
    });
    let text = "Share of the pixels of the second eye whose colour may change by a step of eight \
                bits or more by that, 0 to 1: the weights of what is lost add up to 1/255.";
    real(list, Key::SecondEyeChanged, "1", text, |f, _| {
        of(f).and_then(|s| share(s.changed_pixels, s.pixels))
    });
    let text = "The part of them that changes because disparities are beyond `stereo.lag`, 0 to 1.";
    real(list, Key::SecondEyeCutOff, "1", text, |f, _| {
        of(f).and_then(|s| share(s.cut_off_pixels, s.pixels))
    });
    let text = "Largest disparity of a splat that was handed on, in pixels.";
    real(list, "stereo.largest_disparity", "1", text, |f, _| {
        of(f).map(|s| f64::from(s.largest_disparity))
    });
}

pub(super) fn pixels(list: &mut List) {
    fn of(f: &FrameReport) -> Option<&PixelSummary> {
        f.cycle()?.pixels.as_ref()
    }
    let first = list.len();
    let of_all = |f: &FrameReport, n: fn(&PixelSummary) -> u64| {
        of(f).and_then(|pixels| share(n(pixels), pixels.pixels))
    };
    let text = "Share of the pixels that are rendered, 0 to 1, where not all are.";
    real(list, Key::PixelsRendered, "1", text, move |f, _| of_all(f, |p| p.rendered));
    let text = "Share of the pixels that are moved from the frame before, 0 to 1.";
    real(list, "pixels.warped_frac", "1", text, move |f, _| of_all(f, |p| p.taken));
    let text = "Share of the pixels that are filled in from their neighbours, 0 to 1.";
    real(list, "pixels.filled_frac", "1", text, move |f, _| of_all(f, |p| p.filled));
    let text = "Share of the pixels that look up the first Gaussians that they blend, 0 to 1.";
    real(list, "pixels.looked_up_frac", "1", text, move |f, _| of_all(f, |p| p.lookups));
    let text = "Share of these whose colour is known by them, 0 to 1.";
    real(list, Key::PixelsKnown, "1", text, |f, _| of(f).and_then(|p| share(p.hits, p.lookups)));
    let flows = || vec![tile_wise::FLOW.flow.key()];
    list[first..].iter_mut().for_each(|statistic| statistic.flows = flows());
}

pub(super) fn kernels(list: &mut List) {
    fn of(f: &FrameReport) -> Option<&KernelSummary> {
        f.cycle()?.kernels.as_ref()
    }
    let first = list.len();
    let ms = |f: &FrameReport, cycles: fn(&KernelSummary) -> u64| -> Option<f64> {
        Some(cycles(of(f)?) as f64 / f.cycle()?.clock.0 * 1e3)
    };
    let mut time = |name: &str, text: &str, cycles: fn(&KernelSummary) -> u64| {
        real(list, format!("kernels.{name}_ms"), "ms", text, move |f, _| ms(f, cycles));
    };
    time("convert", "Time of the kernel that converts Gaussians.", |k| k.parts[0]);
    time("pairs", "Time of the kernels that count pairs and write them.", |k| k.parts[1]);
    time("sort", "Time of the kernels that sort pairs and find those of a tile.", |k| k.parts[2]);
    time("blend", "Time of the kernel that blends tiles.", |k| k.parts[3]);
    time("launch", "Time between kernels.", |k| k.launching);
    let text = "Share of the lanes of evaluating warps whose pixel has not stopped, 0 to 1.";
    real(list, "kernels.live_lanes_frac", "1", text, |f, _| {
        of(f).and_then(|k| share(k.live, k.slots))
    });
    let text = "Share of the Gaussians read by blocks that the L2 cache has, 0 to 1.";
    real(list, "kernels.l2_hit_frac", "1", text, |f, _| {
        of(f).and_then(|k| share(k.hits, k.hits + k.misses))
    });
    list[first..].iter_mut().for_each(|statistic| statistic.flows = vec![gpu::FLOW.flow.key()]);
}

pub(super) fn step(list: &mut List) {
    let ms = |f: &FrameReport, cycles: fn(&StepSummary) -> u64| -> Option<f64> {
        let cycle = f.cycle()?;
        Some(cycles(cycle.step.as_ref()?) as f64 / cycle.clock.0 * 1e3)
    };
    let first = list.len();
    let mut time = |name: &str, text: &str, cycles: fn(&StepSummary) -> u64| {
        real(list, format!("step.{name}_ms"), "ms", text, move |f, _| ms(f, cycles));
    };
    time("loss", "Time in which the picture is compared with the photo.", |s| s.loss);
    time("reverse", "Time in which lists are gone through in reverse.", |s| s.reverse);
    time("chain", "Time in which gradients by parameters are found.", |s| s.chain);
    time("update", "Time in which parameters are updated.", |s| s.update);
    let text = "Share of the additions to sums of Gaussians whose sum is in the cache, 0 to 1.";
    real(list, "step.sum_hit_frac", "1", text, |f, _| {
        let [additions, found] = f.cycle()?.step.as_ref()?.sums;
        share(found, additions)
    });
    let flows = || [gpu::FLOW, resident::FLOW, tile_wise::FLOW].map(|own| own.flow.key()).to_vec();
    list[first..].iter_mut().for_each(|statistic| statistic.flows = flows());
}

pub(super) fn reuse(list: &mut List) {
    let of = |f: &FrameReport, field: fn(&ReuseSummary) -> u64| reused(f).map(field);
    let text = "List entries whose place was taken over from the frame before.";
    count(list, "reuse.kept", "1", text, move |f| of(f, |r| r.kept));
    let text = "List entries that the frame before did not have.";
    count(list, "reuse.added", "1", text, move |f| of(f, |r| r.new));
    let text = "Entries of the frame before that are gone.";
    count(list, "reuse.gone", "1", text, move |f| of(f, |r| r.gone));
    let text = "Neighbours out of order because an old order was kept.";
    count(list, "reuse.out_of_order", "1", text, move |f| of(f, |r| r.out_of_order));
    let text =
        "List entries of the frame that the lists of before, taken as they are, do not have.";
    count(list, "reuse.missing", "1", text, move |f| of(f, |r| r.missing));
    let text = "Share of the list entries whose place was taken over, 0 to 1.";
    real(list, "reuse.kept_frac", "1", text, |f, _| {
        let r = reused(f)?;
        share(r.kept, r.kept + r.new)
    });
}
