//! Laws of the memory: causality, order, bounds in closed form.

use powergs_dram::banked::{AddressRange, Banked, Rank, Request};
use powergs_dram::drive::{Access, banked};
use powergs_dram::stream::run_stream;
use powergs_dram::{Device, Mode};

use super::device;
use super::streams::traffic;

/// Completions of requests that all arrive where they say, and the statistics.
fn completions(device: &Device, requests: &[(u64, Access)], step: u64) -> Vec<(u64, u32)> {
    let mut memory = Banked::new(device);
    for (ticket, (arrival, access)) in requests.iter().enumerate() {
        let (ticket, arrival) = (ticket as u32, *arrival);
        memory.push(Request { ticket, write: access.write, class: 1, arrival, rank: Rank::InTurn });
    }
    let mut left: Vec<Option<Access>> = requests.iter().map(|r| Some(r.1)).collect();
    let mut pieces = |ticket: u32| {
        let access = left[ticket as usize].take()?;
        Some(access.range())
    };
    let mut done = Vec::new();
    let mut until = step;
    while done.len() < requests.len() {
        match memory.advance(until, &mut pieces) {
            Some((time, ticket)) => {
                assert!(time <= until);
                done.push((time, ticket));
            }
            None => until = until.saturating_add(step),
        }
    }
    done
}

fn spaced(seed: u64, n: usize, gap: u64) -> Vec<(u64, Access)> {
    traffic(seed, n, 3).into_iter().enumerate().map(|(i, a)| (i as u64 * gap, a)).collect()
}

#[test]
fn small_steps_give_what_one_large_step_gives() {
    for name in ["lpddr4-3200-x16x4", "lpddr5-6400-x16x2", "lpddr6-10667-x12x4", "hbm2-8ch"] {
        let device = device(name, &[]);
        let requests = spaced(1, 400, 11);
        let whole = completions(&device, &requests, u64::MAX);
        assert_eq!(whole.len(), requests.len());
        assert!(whole.windows(2).all(|w| w[0] < w[1]), "by time, then by ticket");
        assert_eq!(whole, completions(&device, &requests, 7), "{name}");
        assert_eq!(whole, completions(&device, &requests, 1000), "{name}");
    }
}

#[test]
fn the_future_does_not_change_the_past() {
    let device = device("lpddr4-3200-x16x2", &[]);
    let requests = spaced(2, 600, 9);
    let all = completions(&device, &requests, u64::MAX);
    for n in [1, 50, 333] {
        let arrival = requests[n].0;
        let some = completions(&device, &requests[..n], u64::MAX);
        let before = |c: &&(u64, u32)| c.0 < arrival;
        assert!(some.iter().filter(before).eq(all.iter().filter(before)), "{n} requests");
    }
}

#[test]
fn a_request_pushed_when_another_completed_enters_after_it() {
    let device = device("lpddr4-3200-x16x2", &["controller.refresh=none"]);
    let mut memory = Banked::new(&device);
    let mut address = 0;
    let mut pieces = move |_: u32| {
        address += 64;
        (address % 128 == 64).then_some(AddressRange { address, bytes: 64 })
    };
    let read =
        |ticket, arrival| Request { ticket, write: false, class: 0, arrival, rank: Rank::InTurn };
    memory.push(read(0, 0));
    let (first, _) = memory.advance(u64::MAX, &mut pieces).expect("a read");
    memory.push(read(1, 0));
    let (second, ticket) = memory.advance(u64::MAX, &mut pieces).expect("a read");
    assert_eq!(ticket, 1);
    let t = &device.timing;
    assert!(second > first + u64::from(t.read_data), "{first} {second}");
    assert_eq!(memory.advance(u64::MAX, &mut pieces), None);
}

#[test]
fn requests_without_pieces_complete_at_their_arrival() {
    let device = device("lpddr4-3200-x16x8", &[]);
    let mut memory = Banked::new(&device);
    for ticket in [3, 1, 2] {
        memory.push(Request {
            ticket,
            write: ticket == 2,
            class: 3,
            arrival: 50,
            rank: Rank::InTurn,
        });
    }
    let mut none = |_: u32| None;
    assert_eq!(memory.advance(49, &mut none), None);
    let done: Vec<_> = std::iter::from_fn(|| memory.advance(60, &mut none)).collect();
    assert_eq!(done, [(50, 1), (50, 2), (50, 3)]);
    assert_eq!(memory.stats().total.bursts, 0);
}

#[test]
fn latency_of_the_controller_is_added_to_reads() {
    let run = |latency: &str| {
        let device = device("lpddr4-3200-x16x8", &["controller.refresh=none", latency]);
        banked(
            &device,
            Mode::Idle,
            (0..100).map(|i| Access { write: false, address: i * 64, bytes: 64 }),
        )
    };
    let (without, with) = (run("controller.latency=0 ns"), run("controller.latency=50 ns"));
    assert_eq!(with.stats.latency.mean(), without.stats.latency.mean() + 80.0);
    assert_eq!(with.cycles, without.cycles + 100 * 80);
}

#[test]
fn one_read_takes_activate_and_read() {
    for (name, expected) in [("lpddr4-3200-x32x4", 29 + 42), ("hbm2-8ch", 15 + 16)] {
        let device = device(name, &[]);
        let one = [Access { write: false, address: 1 << 20, bytes: 32 }];
        assert_eq!(banked(&device, Mode::Saturated, one).cycles, expected, "{name}");
    }
}

#[test]
fn four_activates_bound_random_reads() {
    // One channel, all banks random: never more than 4 activates in tFAW.
    let sets = ["organisation.channels=1", "mapping.order=RoBaCoCh", "controller.refresh=none"];
    for faw in [64, 120, 240] {
        let faw_set = format!("timing.four-activates={faw}");
        let device = device("lpddr4-3200-x16x8", &[&sets[..], &[&faw_set]].concat());
        let mut r = super::streams::Rng::new(9);
        let accesses: Vec<Access> = (0..4000)
            .map(|_| Access { write: false, address: r.below(1 << 24) * 32, bytes: 32 })
            .collect();
        let run = banked(&device, Mode::Saturated, accesses);
        let least = run.stats.activates * faw / 4;
        assert!(run.cycles + 2 * faw >= least);
        // With 32 candidates in 8 banks the limit is nearly reached.
        assert!((run.cycles as f64) < 1.25 * least as f64, "{faw}: {} {least}", run.cycles);
    }
}

#[test]
fn refresh_costs_what_it_takes_away() {
    let time = |refresh: &str| {
        let device = device("lpddr4-3200-x16x8", &[refresh]);
        let reads = (0..40_000).map(|i| Access { write: false, address: i * 64, bytes: 64 });
        banked(&device, Mode::Saturated, reads).cycles as f64
    };
    let tax = time("controller.refresh=all-bank") / time("controller.refresh=none");
    // 286 + 34 of 6246 CK, and what waits for the refresh to begin.
    assert!(tax > 1.0 + 320.0 / 6246.0 && tax < 1.09, "{tax}");
}

#[test]
fn a_long_sleep_is_skipped_but_counted() {
    let device = device("lpddr4-3200-x16x8", &[]);
    let read = |address| Access { write: false, address, bytes: 64 };
    let requests = [(0, read(0)), (10_000_000_000, read(64))];
    let done = completions(&device, &requests, u64::MAX);
    assert!(done[1].0 >= 10_000_000_000 && done[1].0 < 10_000_000_700, "{done:?}");
}

#[test]
fn writes_to_a_waiting_write_are_absorbed_and_reads_answered() {
    let device = device("lpddr4-3200-x16x8", &["front-end.acceptances=4"]);
    let same = |write| Access { write, address: 4096, bytes: 32 };
    let run = banked(&device, Mode::Saturated, [same(true), same(true), same(false)]);
    assert_eq!(run.stats.total.absorbed_writes, 1);
    assert_eq!(run.stats.total.forwarded_reads, 1);
    assert_eq!((run.stats.writes, run.stats.reads), (1, 0));
}

#[test]
fn runs_are_the_same_every_time() {
    let device = device("lpddr5-6400-x16x4", &[]);
    let accesses = traffic(7, 3000, 4);
    let run = || banked(&device, Mode::Parallel(16), accesses.iter().copied());
    assert_eq!(run(), run());
}

#[test]
fn a_stream_ends_with_its_first_error_or_a_cancellation() {
    let device = device("lpddr4-3200-x16x8", &[]);
    let run = |is_cancelled: fn() -> bool| {
        let stream = traffic(3, 9000, 3).into_iter().map(Ok::<_, ()>);
        run_stream(&device, Mode::Idle, stream, is_cancelled).expect("no errors")
    };
    let expected = banked(&device, Mode::Idle, traffic(3, 9000, 3));
    assert_eq!(run(|| false).expect("not cancelled").run, expected);
    assert!(run(|| true).is_none(), "cancelled");
    let broken = traffic(3, 9, 3).into_iter().map(Ok).chain([Err("line 10")]);
    let broken = run_stream(&device, Mode::Saturated, broken, || false);
    assert_eq!(broken.map(|_| ()), Err("line 10"));
}

#[test]
fn writes_end_when_none_is_left_even_where_their_end_is_no_part_of_the_queue() {
    let device = device("lpddr4-3200-x16x2", &["controller.write-low=0.0"]);
    let run = banked(&device, Mode::Saturated, traffic(5, 2000, 3));
    assert_eq!(run.stats.total.requests, 2000);
}

/// Requests of one channel: a write after 100 reads, and reads that keep the memory busy for long.
fn a_write_among_reads(reads: u64) -> Vec<(u64, Access)> {
    let at = |i: u64| Access { write: i == 100, address: i * 64, bytes: 64 };
    (0..reads).map(|i| (0, at(i))).collect()
}

/// When the only write of some requests is done, and when all are.
fn written(device: &Device, requests: &[(u64, Access)]) -> (u64, u64) {
    let done = completions(device, requests, u64::MAX);
    let write = requests.iter().position(|(_, access)| access.write).expect("a write");
    let of_write = done.iter().find(|d| d.1 as usize == write).expect("done").0;
    (of_write, done.last().expect("requests").0)
}

#[test]
fn a_write_beside_reads_waits_no_longer_than_the_limit() {
    // Its row may have to be opened, and the reads that were activated go first.
    const THEN: u64 = 300;
    for name in ["lpddr4-3200-x16x2", "lpddr5-6400-x16x2", "lpddr6-10667-x12x4", "hbm2-8ch"] {
        for scheduler in ["fr-fcfs-row-hit", "fr-fcfs", "fcfs"] {
            let scheduler = format!("controller.scheduler={scheduler}");
            let of = |wait: &str| {
                let sets = ["organisation.channels=1", "controller.refresh=none", &scheduler, wait];
                device(name, &sets)
            };
            let [never, late, early] =
                ["0 ns", "1 us", "200 ns"].map(|wait| of(&format!("controller.write-wait={wait}")));
            let requests = a_write_among_reads(6000);
            let (waits, end) = written(&never, &requests);
            assert!(waits + 1000 > end, "{name}: without a limit it waits for all reads");
            for (device, ns) in [(&late, 1000.0), (&early, 200.0)] {
                let wait = (ns / device.clock_period.0).round() as u64;
                let (at, _) = written(device, &requests);
                // It was accepted behind a hundred reads, at most as many as wait.
                let (first, _) = written(device, &requests[..101]);
                assert!(at < first + wait + THEN, "{name}, {scheduler}: {at}, {first} + {wait}");
                assert!(at >= wait, "{name}, {scheduler}: {at} is before the limit of {wait}");
            }
        }
    }
}

#[test]
fn writes_that_waited_go_together() {
    // Sixteen writes wait beside reads without end: one turn to writes and one back.
    let device = device("lpddr4-3200-x16x2", &["organisation.channels=1"]);
    let mut requests: Vec<(u64, Access)> = a_write_among_reads(6000);
    for (i, (_, access)) in requests.iter_mut().enumerate().take(116).skip(100) {
        *access = Access { write: true, address: i as u64 * 64, bytes: 32 };
    }
    let done = completions(&device, &requests, u64::MAX);
    let of = |i: u32| done.iter().find(|d| d.1 == i).expect("done").0;
    let times: Vec<u64> = (100..116).map(of).collect();
    let (first, last) = (times.iter().min().expect("some"), times.iter().max().expect("some"));
    assert!(last - first < 16 * 8 + 120, "{times:?}");
}
