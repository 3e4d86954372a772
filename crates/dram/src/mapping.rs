//! From addresses to channels, banks and rows.
//!
//! An address is a burst number and an offset inside the burst. The bits of the burst number are
//! dealt to fields from the bottom. Addresses beyond the capacity wrap.

use super::device::{Device, Order};

/// A kind of address field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MappingField {
    /// Which channel.
    Channel,
    /// Which pseudo channel of it.
    PseudoChannel,
    /// Which bank group of that.
    BankGroup,
    /// Which bank of the group.
    Bank,
    /// Which row of the bank.
    Row,
    /// Which burst of the row.
    Column,
}

impl MappingField {
    /// All fields.
    pub(crate) const ALL: [MappingField; 6] = [
        MappingField::Channel,
        MappingField::PseudoChannel,
        MappingField::BankGroup,
        MappingField::Bank,
        MappingField::Row,
        MappingField::Column,
    ];

    /// Its name in `mapping.fields`.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            MappingField::Channel => "channel",
            MappingField::PseudoChannel => "pseudo-channel",
            MappingField::BankGroup => "bank-group",
            MappingField::Bank => "bank",
            MappingField::Row => "row",
            MappingField::Column => "column",
        }
    }

    /// Address bits that it has in a device.
    pub(crate) fn bits(self, device: &Device) -> u32 {
        let o = &device.organisation;
        match self {
            MappingField::Channel => o.channels.trailing_zeros(),
            MappingField::PseudoChannel => o.pseudo_channels.trailing_zeros(),
            MappingField::BankGroup => o.bank_groups.trailing_zeros(),
            MappingField::Bank => o.banks.trailing_zeros(),
            MappingField::Row => o.rows.trailing_zeros(),
            MappingField::Column => (o.row.0 / o.burst.0.max(1)).trailing_zeros(),
        }
    }
}

/// Where a burst lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Channel.
    pub channel: u32,
    /// Bank in its channel: pseudo channel, group and bank from the top.
    pub bank: u32,
    /// Row in its bank.
    pub row: u32,
}

/// A run of address bits that becomes a run of bits of a field.
#[derive(Debug, Clone, Copy, Default)]
struct Segment {
    from: u32,
    mask: u64,
    to: u32,
}

/// A field gathered from at most four runs of address bits, the first `runs` of these.
#[derive(Debug, Clone, Copy, Default)]
struct Gather {
    segments: [Segment; 4],
    runs: usize,
}

impl Gather {
    #[inline]
    fn of(&self, burst: u64) -> u64 {
        let part = |s: &Segment| ((burst >> s.from) & s.mask) << s.to;
        // Mostly there is one.
        let first = part(&self.segments[0]);
        if self.runs < 2 {
            return first;
        }
        self.segments[1..].iter().fold(first, |field, s| field | part(s))
    }
}

/// The exclusive-or of the `mop` order, by widths in bits.
#[derive(Debug, Clone, Copy)]
struct MappingHash {
    pseudo_channel: u32,
    group: u32,
    bank: u32,
    row: u32,
}

/// Finds the place of a burst.
#[derive(Debug, Clone)]
pub struct Decoder {
    /// log2 of the bytes of a burst.
    pub shift: u32,
    mask: u64,
    channel: Gather,
    bank: Gather,
    row: Gather,
    column: Gather,
    hash: Option<MappingHash>,
}

impl Decoder {
    /// The decoder of a checked device.
    pub fn new(device: &Device) -> Self {
        let runs = layout(device).unwrap_or_default();
        let [bank, group] = [MappingField::Bank, MappingField::BankGroup].map(|f| f.bits(device));
        // One flat bank number: pseudo channel, group, bank from the top.
        let flat = |f: MappingField| match f {
            MappingField::Bank => Some(0),
            MappingField::BankGroup => Some(bank),
            MappingField::PseudoChannel => Some(bank + group),
            MappingField::Channel | MappingField::Row | MappingField::Column => None,
        };
        let only = |wanted: MappingField| move |f: MappingField| (f == wanted).then_some(0);
        let total: u32 = runs.iter().map(|r| r.1).sum();
        let hash = MappingHash {
            pseudo_channel: MappingField::PseudoChannel.bits(device),
            group,
            bank,
            row: MappingField::Row.bits(device),
        };
        Self {
            shift: device.organisation.burst.0.trailing_zeros(),
            mask: low(total),
            channel: gather(&runs, only(MappingField::Channel)),
            bank: gather(&runs, flat),
            row: gather(&runs, only(MappingField::Row)),
            column: gather(&runs, only(MappingField::Column)),
            hash: (device.mapping.order == Order::Mop).then_some(hash),
        }
    }

    /// The number of the burst that holds a byte, below the capacity.
    #[inline]
    pub fn burst(&self, address: u64) -> u64 {
        (address >> self.shift) & self.mask
    }

    /// Channel, bank, row and column of a burst.
    #[inline]
    pub fn place(&self, burst: u64) -> Place {
        let mut bank = self.bank.of(burst);
        let mut row = self.row.of(burst);
        if let Some(h) = self.hash {
            // Strides that would meet one bank again and again are spread by bits of the column.
            let column = self.column.of(burst);
            let pc = column & low(h.pseudo_channel);
            let group = (column >> h.pseudo_channel) & low(h.group);
            let in_group = (column >> (h.pseudo_channel + h.group)) & low(h.bank);
            bank ^= in_group | group << h.bank | pc << (h.bank + h.group);
            row ^= (column >> (h.pseudo_channel + h.group + h.bank)) & low(h.row);
        }
        let channel = self.channel.of(burst) as u32;
        Place { channel, bank: bank as u32, row: row as u32 }
    }
}

fn low(bits: u32) -> u64 {
    if bits >= 64 { u64::MAX } else { (1 << bits) - 1 }
}

/// Gathers the runs for which `base` gives the lowest bit of the field in the result. [`layout`]
/// sees to it that four runs are enough.
fn gather(runs: &[(MappingField, u32)], base: impl Fn(MappingField) -> Option<u32>) -> Gather {
    let mut segments: Vec<Segment> = Vec::new();
    let mut at = 0;
    let mut used = [0; 6];
    for &(field, bits) in runs {
        let done = &mut used[field as usize];
        if let Some(base) = base(field).filter(|_| bits > 0) {
            segments.push(Segment { from: at, mask: low(bits), to: base + *done });
        }
        *done += bits;
        at += bits;
    }
    let mut result = Gather { runs: segments.len(), ..Gather::default() };
    for (slot, segment) in result.segments.iter_mut().zip(segments) {
        *slot = segment;
    }
    result
}

/// The fields with their bits, from the lowest above the burst to the highest.
///
/// # Errors
/// The problem of `mapping`, with the key.
pub(crate) fn layout(device: &Device) -> Result<Vec<(MappingField, u32)>, String> {
    let bits = |f: MappingField| f.bits(device);
    let burst = device.organisation.burst.0;
    let column = bits(MappingField::Column);
    let banks = [MappingField::PseudoChannel, MappingField::BankGroup, MappingField::Bank];
    let under_banks = match device.mapping.order {
        Order::Fields => return listed(device),
        Order::RoBaCoCh => column,
        Order::Mop => 2.min(column),
        Order::Bg64 => (64 / burst).checked_ilog2().unwrap_or(0).min(column),
    };
    let mut runs = vec![(MappingField::Column, under_banks)];
    let rest = (MappingField::Column, column - under_banks);
    if device.mapping.order == Order::Bg64 {
        let [pc, group, bank] = banks.map(|f| (f, bits(f)));
        runs.extend([pc, group, rest, bank]);
    } else {
        runs.extend(banks.map(|f| (f, bits(f))));
        runs.push(rest);
    }
    runs.push((MappingField::Row, bits(MappingField::Row)));
    let interleave = device.mapping.interleave.0;
    if interleave < burst {
        let (i, b) = (device.mapping.interleave, device.organisation.burst);
        return Err(format!("`mapping.interleave` ({i}) is less than `organisation.burst` ({b})"));
    }
    let at = (interleave / burst).trailing_zeros();
    if at > column && bits(MappingField::Channel) > 0 {
        let (i, r) = (device.mapping.interleave, device.organisation.row);
        return Err(format!("`mapping.interleave` ({i}) is more than `organisation.row` ({r})"));
    }
    Ok(insert_channel(runs, at, bits(MappingField::Channel)))
}

/// Puts the channel bits above the lowest `at` bits.
fn insert_channel(
    runs: Vec<(MappingField, u32)>,
    at: u32,
    channel: u32,
) -> Vec<(MappingField, u32)> {
    let mut left = at;
    let mut result = Vec::new();
    let mut done = false;
    for (field, bits) in runs {
        if !done && left <= bits {
            result.extend([(field, left), (MappingField::Channel, channel), (field, bits - left)]);
            done = true;
        } else {
            result.push((field, bits));
            left = left.saturating_sub(bits);
        }
    }
    result.retain(|r| r.1 > 0);
    result
}

/// The fields of `mapping.fields`.
fn listed(device: &Device) -> Result<Vec<(MappingField, u32)>, String> {
    let mut runs: Vec<(MappingField, u32)> = Vec::new();
    for text in device.mapping.fields.iter().flatten() {
        let form = || {
            format!("`mapping.fields`: \"{text}\" is not a field with its bits, as in \"column:4\"")
        };
        let (name, bits) = text.split_once(':').ok_or_else(form)?;
        let field =
            MappingField::ALL.into_iter().find(|f| f.name() == name.trim()).ok_or_else(form)?;
        let bits: u32 = bits.trim().parse().ok().filter(|b| *b <= 40).ok_or_else(form)?;
        runs.push((field, bits));
    }
    for field in MappingField::ALL {
        let given: u32 = runs.iter().filter(|r| r.0 == field).map(|r| r.1).sum();
        let wanted = field.bits(device);
        let pieces = runs.iter().filter(|r| r.0 == field && r.1 > 0).count();
        if given != wanted {
            let name = field.name();
            return Err(format!(
                "`mapping.fields` gives {given} bits to {name}, `organisation` has {wanted}"
            ));
        }
        if pieces > 4 {
            return Err(format!("`mapping.fields` cuts {} in more than 4 pieces", field.name()));
        }
    }
    let banks = [MappingField::PseudoChannel, MappingField::BankGroup, MappingField::Bank];
    if runs.iter().filter(|r| banks.contains(&r.0) && r.1 > 0).count() > 4 {
        return Err("`mapping.fields` cuts the bank fields in more than 4 pieces".to_owned());
    }
    Ok(runs)
}
