//! A codebook of colours: a look-up for every colour, and what that costs.

use powergs_base::quantity::Bytes;
use powergs_core::run::{Change, MemoryFrames, Session, System};
use powergs_core::sim::FrameReport;
use powergs_core::stage::{DRAM_READ, buffer_id, sram_read, sram_write, work_id};

use powergs_frame::scene::ShDegree;
use powergs_frame::trace::Frame;
use powergs_raster::{Detail, Options, render};
use powergs_testkit::scenes::{front_camera, random_scene};

/// A record with three constant coefficients and a number of two bytes, and the entries.
const BOOK: [&str; 5] = [
    "record.colour=8 B",
    "record.colour-extra=8 B",
    "record.colour-pitch=8 B",
    "codebook.entries=4096",
    "codebook.entry=90 B",
];

fn system(machine: &str, sets: &[&str]) -> System {
    let changes: Vec<Change> = sets.iter().map(|s| s.parse().unwrap()).collect();
    System::named(machine).unwrap().with(&changes).unwrap()
}

/// The views of a scene of this SH degree.
fn frame(degree: u8) -> Frame {
    let (camera, options) = (front_camera(64, 48), Options::reference(Detail::Counters));
    let mut frame =
        render(&random_scene(3, 900, 0), &camera, &options).into_frame(&camera, [0.0; 3]);
    frame.facts.sh_degree = ShDegree::new(degree);
    frame
}

fn replayed(machine: &str, sets: &[&str]) -> FrameReport {
    of_degree(3, machine, sets)
}

fn of_degree(degree: u8, machine: &str, sets: &[&str]) -> FrameReport {
    let mut frames = MemoryFrames::new("scene", [frame(degree)]);
    let systems = [system(machine, sets)];
    Session::new(&mut frames, &()).reports(&systems).unwrap().remove(0).remove(0)
}

#[test]
fn every_colour_reads_an_entry_and_spares_its_coefficients() {
    // Colours by CCUs before sorting, and by cores when a tile first loads a splat.
    for machine in ["gscore", "gscore-powergs"] {
        let (without, with) = (replayed(machine, &[]), replayed(machine, &BOOK));
        let colours = with.actions.total(work_id("sh-colour"));
        assert!(colours > 0 && colours == without.actions.total(work_id("sh-colour")));
        // 90 B are three words of 32 B.
        let looked_up = |r: &FrameReport| r.actions.total(sram_read(buffer_id("codebook")));
        assert_eq!([looked_up(&without), looked_up(&with)], [0, 96 * colours], "{machine}");
        assert_eq!(with.actions.total(sram_write(buffer_id("codebook"))), 0, "it stays");
        // Constant colours have no entries.
        assert_eq!(looked_up(&of_degree(0, machine, &BOOK)), 0, "{machine}");
        let read = |r: &FrameReport| r.actions.total(DRAM_READ);
        let record = system(machine, &[]).machine().tiles().record.colour.0;
        assert_eq!(read(&without) - read(&with), (record - 8) * colours, "{machine}");
    }
}

#[test]
fn a_machine_with_entries_has_the_record_of_them() {
    // Three numbers of FP16 and twelve bits: 60 bits.
    for machine in ["gscore", "gscore-powergs"] {
        let said = replayed(machine, &[&BOOK[3..], &["record.colour-extra=0 B"]].concat());
        assert_eq!(said.actions, replayed(machine, &BOOK).actions, "{machine}");
    }
    // Without coefficients in the record its bytes are what they are.
    let read = |sets: &[&str]| replayed("gscore", sets).actions.total(DRAM_READ);
    let fixed = ["record.colour-extra=96 B"];
    assert_eq!(read(&[&fixed[..], &BOOK[3..]].concat()), read(&fixed));
}

#[test]
fn each_unit_has_a_copy_with_area_and_leakage() {
    let book = |sets: &[&str]| {
        let memory =
            |system: &System| system.machine().inventory().memories[buffer_id("codebook").index()];
        memory(&system("gscore", &[&BOOK, sets].concat()))
    };
    let without = system("gscore", &[]).machine().inventory();
    assert_eq!(without.memories[buffer_id("codebook").index()].banks, 0);
    let one = book(&[]);
    let units = system("gscore", &[]).machine().tiles().ccu.units;
    // 4096 entries of three words of 32 B.
    assert_eq!((one.bank, one.banks), (Bytes(4096 * 96), units));
    let four = book(&["codebook.banks=4"]);
    assert_eq!((four.bank, four.banks), (Bytes(1024 * 96), 4 * units));
    let area = |sets: &[&str]| replayed("gscore", sets).area.unwrap().total().0;
    assert!(area(&BOOK) > area(&BOOK[..3]), "it takes area");
}

#[test]
fn few_banks_hold_colours_up() {
    let slow = ["codebook.word=1 B", "ccu.operations-per-cycle=4096"];
    let cycles = |more: &[&str]| {
        let report = replayed("gscore", &[&BOOK[..], &slow, more].concat());
        report.timing().unwrap().frame
    };
    let (one, many) = (cycles(&[]), cycles(&["codebook.banks=90"]));
    assert!(one > many, "{one} cycles with one bank, {many} with 90");
}

#[test]
fn a_codebook_that_cannot_be_is_refused() {
    let refused = |set: &str| {
        let set: Change = set.parse().unwrap();
        let on: Change = "codebook.entries=1048576".parse().unwrap();
        System::named("gscore").unwrap().with(&[on, set]).unwrap_err().to_string()
    };
    assert!(refused("codebook.entry=0 B").contains("`codebook.entry` = 0 B"));
    assert!(refused("codebook.entry=64 KiB").contains("typing error"));
    assert!(refused("codebook.word=0 B").contains("`codebook.word` = 0 B"));
}
