//! The `banked` level gives the same results however it is asked, and goes on giving those of the
//! version that looked at every bank of every channel for each command.

use powergs_dram::banked::{AddressRange, Banked, Rank, Request};
use powergs_dram::{Device, Stats};

use super::device;
use super::streams::Rng;

/// Devices, changed keys, and what their runs give: see [`number`].
const RUNS: [(&str, &[&str], u64); 24] = [
    ("lpddr4-3200-x16x8", &[], 0xB646_5AA9_AEE3_BDDC),
    ("lpddr4-3200-x16x8", &[], 0x637C_F5A3_2AD5_29B7),
    ("lpddr4-3200-x16x8", &[], 0xD423_7214_B734_D06F),
    ("lpddr4-3200-x16x8", &["controller.latency=40 ns"], 0xAAB4_3EAD_69F7_D8CF),
    ("lpddr4-3200-x16x8", &["controller.scheduler=fr-fcfs"], 0xC18F_DA7D_72F1_4773),
    ("lpddr4-3200-x16x8", &["controller.scheduler=fcfs"], 0x7900_9A0C_BC3E_85DF),
    ("lpddr4-3200-x16x8", &["controller.refresh=per-bank"], 0xF92E_EC4C_E13F_473B),
    ("lpddr4-3200-x16x8", &["controller.page=closed"], 0x6B02_BCA4_F046_F79A),
    ("lpddr4-3200-x16x8", &["front-end.window=512 B"], 0x69A1_EA5B_55BC_6395),
    ("lpddr4-3200-x16x8", &["front-end.reads-in-flight=4"], 0x4918_5208_D743_CD79),
    (
        "lpddr4-3200-x16x8",
        &["front-end.acceptances=4", "controller.write-queue=5"],
        0xC916_D1CF_0900_5DD2,
    ),
    ("lpddr4-3200-x16x8", &["mapping.order=mop"], 0x3AFA_673E_94F0_140E),
    ("lpddr4-3200-x16x2", &[], 0x19B0_2CD4_0A64_DEE6),
    ("lpddr4-3200-x16x16", &[], 0xCA9E_4181_F759_8119),
    ("lpddr4-3200-x16x32", &[], 0x2FFE_58C1_DC51_FC2A),
    ("lpddr4-3200-x32x4", &[], 0x0860_5CB9_2DB4_A991),
    ("lpddr5-6400-x16x4", &[], 0x571C_F2FB_2BB9_EA93),
    ("lpddr5-6400-x16x4", &["controller.page=closed"], 0xB2EF_C64B_427C_0AB4),
    ("lpddr5-6400-x16x16", &[], 0x7878_CD93_1FCE_780E),
    ("lpddr5x-8533-x16x8", &[], 0x285B_C8DF_8B55_C874),
    ("lpddr6-10667-x12x4", &[], 0x1DC0_E4EA_D509_07CE),
    ("hbm2-8ch", &[], 0x3609_550C_9AF4_6F0C),
    ("hbm2-8ch", &["controller.page=closed"], 0xFEBC_6DA5_DE6A_EFF9),
    ("hbm2-8ch", &["controller.refresh=per-bank"], 0x4D7B_AB2F_3A3B_6C78),
];

/// Requests of a run: their pieces, and whether they write.
struct Load {
    requests: Vec<(Vec<AddressRange>, bool)>,
    /// Most that are under way.
    ahead: usize,
    /// Most CK from a completion to the arrival of the next request.
    gap: u64,
}

impl Load {
    /// Requests at random: of one piece or of hundreds, rare or more than fit the window.
    fn new(seed: u64) -> Load {
        let mut r = Rng::new(seed);
        let most = [1, 3, 60, 400][r.below(4) as usize];
        let (writes, local) = (r.below(5), r.below(3));
        let most_ahead = [6, 200][r.below(2) as usize];
        let ahead = 1 + r.below(most_ahead) as usize;
        let gap = [0, 3, 60, 5000, 40_000][r.below(5) as usize];
        let mut at = 0;
        let mut piece = |r: &mut Rng| {
            if local == 0 || r.below(8) < local * 3 {
                at = r.below(1 << 22) * 32;
            }
            let bytes = [16, 32, 64, 200, 0, 3000][r.below(6) as usize];
            at += bytes;
            AddressRange { address: at - bytes, bytes }
        };
        let requests = (0..100).map(|_| {
            let pieces = r.below(most + 1);
            ((0..pieces).map(|_| piece(&mut r)).collect(), r.below(5) < writes)
        });
        Load { requests: requests.collect(), ahead, gap }
    }

    /// Completions and activity, where nothing is asked for more than `step` CK at once.
    fn run(&self, device: &Device, step: u64) -> (Vec<(u64, u32)>, Stats) {
        let mut memory = Banked::new(device);
        let mut taken = vec![0; self.requests.len()];
        let mut pieces = |ticket: u32| {
            let ticket = ticket as usize;
            taken[ticket] += 1;
            self.requests[ticket].0.get(taken[ticket] - 1).copied()
        };
        let mut r = Rng::new(1);
        let (mut done, mut pushed, mut now, mut until) = (Vec::new(), 0, 0, step);
        while done.len() < self.requests.len() {
            while pushed < self.requests.len().min(done.len() + self.ahead) {
                let arrival = now + r.below(self.gap + 1);
                let (ticket, write) = (pushed as u32, self.requests[pushed].1);
                memory.push(Request {
                    ticket,
                    write,
                    class: (pushed % 4) as u8,
                    arrival,
                    rank: Rank::InTurn,
                });
                pushed += 1;
            }
            match memory.advance(until, &mut pieces) {
                Some(found) => {
                    assert!(found.0 <= until, "{found:?} after {until}");
                    now = found.0;
                    done.push(found);
                }
                None => until = until.saturating_add(step),
            }
        }
        (done, memory.stats())
    }
}

/// All results of a run in one number (FNV-1a).
fn number((done, stats): &(Vec<(u64, u32)>, Stats)) -> u64 {
    let Stats { active, power_down, self_refresh, until, busy_max, latency, .. } = stats;
    let times = [*active, *power_down, *self_refresh, *until, *busy_max, latency.max()];
    let counts = stats.classes[..4].iter().flat_map(|t| {
        let merged = [t.absorbed_writes, t.forwarded_reads, t.bursts, t.moved_bytes];
        let first = [t.row_hits, t.row_misses, t.row_conflicts, t.latency];
        merged.into_iter().chain(first)
    });
    let all = done.iter().flat_map(|(time, ticket)| [*time, u64::from(*ticket)]);
    let all = all.chain(stats.commands().map(|c| c.1)).chain(times).chain(counts);
    all.fold(0xCBF2_9CE4_8422_2325, |hash, word| (hash ^ word).wrapping_mul(0x0000_0100_0000_01B3))
}

#[test]
fn results_depend_on_no_way_of_asking_and_stay() {
    for (seed, (name, sets, expected)) in RUNS.iter().enumerate() {
        let load = Load::new(seed as u64);
        // That version let writes wait for ever; the limit of the device, and one that is reached.
        for wait in ["0 ns", "", "100 ns"] {
            let wait = format!("controller.write-wait={wait}");
            let more = if wait.ends_with('=') { &[][..] } else { &[wait.as_str()] };
            let device = device(name, &[sets, more].concat());
            let whole = load.run(&device, u64::MAX);
            for step in [1000, 37] {
                let same = load.run(&device, step) == whole;
                assert!(same, "{name} {sets:?} {more:?}: other results in steps of {step} CK");
            }
            if wait.ends_with("=0 ns") {
                assert_eq!(number(&whole), *expected, "{name} {sets:?}");
            }
        }
    }
}
