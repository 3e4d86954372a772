//! Consistency of the keys of a DRAM device.

use super::{Device, Energy, Order, Page, Refresh, Scheduler};
use crate::mapping::layout;
use powergs_base::config::references::is_source;

/// A key and what is wrong with it.
type DeviceFound = Vec<(&'static str, String)>;

/// Banks of a channel that the scheduler can hold.
const BANKS_MAX: u32 = 64;

/// Everything that is wrong with a device.
pub(super) fn problems(device: &Device) -> DeviceFound {
    let mut found = Vec::new();
    if device.clock_period.0 < 0.01 || device.clock_period.0 > 1000.0 {
        found.push(("clock-period", "`clock-period` must lie between 10 ps and 1 us".to_owned()));
    }
    sizes(device, &mut found);
    // Address bits are counted in powers of two: without these there is no mapping to look at.
    if found.is_empty() {
        mapping(device, &mut found);
    }
    timing(device, &mut found);
    controller(device, &mut found);
    energy(&device.energy, &mut found);
    found
}

fn sizes(device: &Device, found: &mut DeviceFound) {
    let o = &device.organisation;
    let counts = [
        ("organisation.channels", u64::from(o.channels)),
        ("organisation.pseudo-channels", u64::from(o.pseudo_channels)),
        ("organisation.bank-groups", u64::from(o.bank_groups)),
        ("organisation.banks", u64::from(o.banks)),
        ("organisation.rows", u64::from(o.rows)),
        ("organisation.row", o.row.0),
        ("organisation.burst", o.burst.0),
        ("mapping.interleave", device.mapping.interleave.0),
    ];
    for (key, value) in counts {
        if !value.is_power_of_two() {
            let message = format!("`{key}` = {value} selects address bits: use a power of two");
            found.push((key, message));
        }
    }
    if o.row < o.burst {
        let message = format!(
            "`organisation.row` ({}) is smaller than `organisation.burst` ({}): a burst comes from \
             one row",
            o.row, o.burst
        );
        found.push(("organisation.row", message));
    }
    if o.burst.0 > 4096 || o.row.0 > 1 << 20 {
        let message = "`organisation.burst` is at most 4 KiB and `organisation.row` at most 1 MiB";
        found.push(("organisation.burst", message.to_owned()));
    }
    let carried = u64::from(o.width) * u64::from(o.beats);
    if o.burst.0.saturating_mul(8) > carried {
        let message = format!(
            "`organisation.burst` ({}) does not fit into `organisation.width` x \
             `organisation.beats` = {} x {} = {carried} bits",
            o.burst, o.width, o.beats
        );
        found.push(("organisation.burst", message));
    }
    if o.pseudo_channels * o.bank_groups * o.banks > BANKS_MAX {
        let message = format!(
            "`organisation.pseudo-channels` x `bank-groups` x `banks` = {} x {} x {} is more than \
             {BANKS_MAX} banks a channel",
            o.pseudo_channels, o.bank_groups, o.banks
        );
        found.push(("organisation.banks", message));
    }
}

fn mapping(device: &Device, found: &mut DeviceFound) {
    let m = &device.mapping;
    let key = match m.order {
        Order::Fields => "mapping.fields",
        Order::RoBaCoCh | Order::Mop | Order::Bg64 => "mapping.interleave",
    };
    if (m.order == Order::Fields) != m.fields.is_some() {
        let message = "`mapping.fields` is there exactly when `mapping.order` is \"fields\"";
        found.push(("mapping.order", message.to_owned()));
    } else if let Err(message) = layout(device) {
        found.push((key, message));
    }
}

fn timing(device: &Device, found: &mut DeviceFound) {
    let t = &device.timing;
    let ordered = [
        ("timing.column-short", t.burst, t.column_short, "timing.burst"),
        ("timing.column-long", t.column_short, t.column_long, "timing.column-short"),
        ("timing.activate-long", t.activate_short, t.activate_long, "timing.activate-short"),
        ("timing.four-activates", t.activate_short, t.four_activates, "timing.activate-short"),
        ("timing.read-data", t.burst, t.read_data, "timing.burst"),
        (
            "timing.write-to-read-long",
            t.write_to_read_short,
            t.write_to_read_long,
            "timing.write-to-read-short",
        ),
        (
            "timing.activate-to-activate",
            t.activate_to_precharge,
            t.activate_to_activate,
            "timing.activate-to-precharge",
        ),
    ];
    for (key, least, value, other) in ordered {
        if value < least {
            found.push((key, format!("`{key}` ({value}) is less than `{other}` ({least})")));
        }
    }
    let busy = t.refresh_all_to_activate + t.precharge_all_to_refresh + t.activate_to_activate;
    if device.controller.refresh == Refresh::AllBank && t.refresh_interval <= busy {
        let message = format!(
            "`timing.refresh-interval` ({}) leaves no time beside `timing.refresh-all-to-activate` \
             ({})",
            t.refresh_interval, t.refresh_all_to_activate
        );
        found.push(("timing.refresh-interval", message));
    }
    let o = &device.organisation;
    let banks = o.pseudo_channels * o.bank_groups * o.banks;
    let each = t.refresh_interval / banks.max(1);
    let busy = t.activate_to_activate + t.precharge_all_to_refresh;
    if device.controller.refresh == Refresh::PerBank && each <= busy {
        let message = format!(
            "`timing.refresh-interval` ({}) shared by {banks} banks leaves no time beside \
             `timing.activate-to-activate` ({})",
            t.refresh_interval, t.activate_to_activate
        );
        found.push(("timing.refresh-interval", message));
    }
    if let Some(split) = &device.split_activate
        && split.second_within > t.activate_to_read.min(t.activate_to_write)
    {
        let message = format!(
            "`split-activate.second-within` ({}) is more than `timing.activate-to-read` ({}) or \
             `timing.activate-to-write` ({})",
            split.second_within, t.activate_to_read, t.activate_to_write
        );
        found.push(("split-activate.second-within", message));
    }
    if device.split_activate.is_some() && device.commands.column_bus {
        let message = "`split-activate` and `commands.column-bus = true` exclude each other";
        found.push(("commands.column-bus", message.to_owned()));
    }
    if device.clock_sync.is_some() && device.commands.column_bus {
        let message = "`clock-sync` and `commands.column-bus = true` exclude each other";
        found.push(("commands.column-bus", message.to_owned()));
    }
}

fn controller(device: &Device, found: &mut DeviceFound) {
    let c = &device.controller;
    if c.write_low >= c.write_high {
        let message = format!(
            "`controller.write-low` ({}) must be below `controller.write-high` ({})",
            c.write_low, c.write_high
        );
        found.push(("controller.write-low", message));
    }
    if c.scheduler == Scheduler::Fcfs && c.page == Page::Closed {
        let message = "`controller.page = \"closed\"` looks at waiting requests, which \
                       `controller.scheduler = \"fcfs\"` does not";
        found.push(("controller.page", message.to_owned()));
    }
    if c.latency.0 > 1e6 {
        found.push(("controller.latency", "`controller.latency` is above 1 ms".to_owned()));
    }
    if c.write_wait.0 > 1e6 {
        found.push(("controller.write-wait", "`controller.write-wait` is above 1 ms".to_owned()));
    }
    let window = device.front_end.window.0;
    if window < device.organisation.burst.0 || window > 16 << 20 {
        let message = format!(
            "`front-end.window` ({}) must hold at least one `organisation.burst` ({}) and at most \
             16 MiB",
            device.front_end.window, device.organisation.burst
        );
        found.push(("front-end.window", message));
    }
}

fn energy(energy: &Energy, found: &mut DeviceFound) {
    if energy.flat.is_some() == energy.actions.is_some() {
        let message = "`energy` needs exactly one of [energy.flat] and [energy.actions]";
        found.push(("energy", message.to_owned()));
    }
    let mut sources = vec![("energy.scale-source", &energy.scale_source)];
    if let Some(flat) = &energy.flat {
        sources.push(("energy.flat", &flat.source));
    }
    if let Some(actions) = &energy.actions {
        sources.extend(actions.commands().map(|(_, p)| ("energy.actions", &p.source)));
        let background = &actions.background;
        sources.extend(background.states().map(|(_, p)| ("energy.actions.background", &p.source)));
        if background.self_refresh_after < background.power_down_after {
            let message = format!(
                "`energy.actions.background.self-refresh-after` ({}) comes before \
                 `power-down-after` ({})",
                background.self_refresh_after, background.power_down_after
            );
            found.push(("energy.actions.background.self-refresh-after", message));
        }
    }
    for (key, source) in sources {
        if !is_source(source) {
            let message = format!(
                "`{key}`: source \"{source}\" is neither a key of references.toml nor an \
                 assumption number (A1, A2, ...)"
            );
            found.push((key, message));
        }
    }
}
