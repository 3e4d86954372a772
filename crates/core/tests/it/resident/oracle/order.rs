//! An order unit, counting down.

use powergs_core::flow::resident::Resident;

use super::{World, digit};
use crate::oracle_memory::Ticket;

enum Where {
    Read(Ticket),
    Pass(u64),
    Out(Ticket),
    Back(Ticket),
    Write(Ticket),
}

struct List {
    region: usize,
    at: Where,
    /// Passes that it still needs.
    passes: u64,
}

pub struct Order {
    list: Option<List>,
    share: u64,
}

impl Order {
    pub fn new(m: &Resident) -> Order {
        Order { list: None, share: m.stores.keys.capacity.0 / u64::from(m.order.units) }
    }

    pub fn step(&mut self, world: &mut World) {
        while self.go_on(world) {}
    }

    /// Whether something happened.
    fn go_on(&mut self, world: &mut World) -> bool {
        let Some(list) = &mut self.list else { return self.take(world) };
        let region = world.frame.regions[list.region];
        let (first, keys) = (u64::from(region.start), u64::from(region.entries));
        let bytes = keys * world.m.gaussian.entry.0;
        let beyond = bytes.saturating_sub(self.share);
        match list.at {
            Where::Pass(left) if left > 0 => return false,
            Where::Read(ticket)
            | Where::Out(ticket)
            | Where::Back(ticket)
            | Where::Write(ticket)
                if !world.is_done(ticket) =>
            {
                return false;
            }
            Where::Pass(_) => {
                list.passes -= 1;
                if list.passes > 0 && beyond > 0 {
                    let place = world.memory.layout.pass(first, beyond);
                    list.at = Where::Out(world.write("passes-out", beyond, place));
                    return true;
                }
            }
            Where::Out(_) => {
                let place = world.memory.layout.pass(first, beyond);
                list.at = Where::Back(world.read("passes-in", beyond, place));
                return true;
            }
            Where::Write(_) => {
                world.in_order[list.region] = true;
                self.list = None;
                return true;
            }
            Where::Read(_) | Where::Back(_) => {}
        }
        list.at = match list.passes {
            0 => {
                let place = world.memory.layout.ordered(first, bytes);
                Where::Write(world.write("ordered", bytes, place))
            }
            _ => Where::Pass(world.m.order.cycles(keys)),
        };
        true
    }

    fn take(&mut self, world: &mut World) -> bool {
        let number = world.next_region;
        let Some(region) = world.frame.regions.get(number) else { return false };
        world.next_region += 1;
        let keys = u64::from(region.entries);
        if keys == 0 {
            world.in_order[number] = true;
            return true;
        }
        let bytes = keys * world.m.gaussian.entry.0;
        let place = world.memory.layout.list(u64::from(region.start), bytes);
        let at = Where::Read(world.read("lists", bytes, place));
        self.list = Some(List { region: number, at, passes: world.m.order.passes(keys) });
        true
    }

    pub fn tick(&mut self) {
        if let Some(List { at: Where::Pass(left), .. }) = &mut self.list {
            *left -= 1;
        }
    }

    pub fn symbol(&self) -> char {
        match &self.list {
            None => '.',
            Some(list) => match list.at {
                Where::Read(_) => 'l',
                Where::Pass(_) => digit(list.region as u32),
                Where::Out(_) | Where::Back(_) => 's',
                Where::Write(_) => 'o',
            },
        }
    }
}
