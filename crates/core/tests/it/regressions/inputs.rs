//! Files that are named in files, runs of other simulators, prices.

use std::fs;
use std::io::{Cursor, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use powergs_core::flow::recorded::{RecordedRun, RecordedSpec};
use powergs_core::machine::Machine;
use powergs_core::run::files::{DiskFiles, Files};
use powergs_core::run::{
    Change, FileKind, MemoryFrames, Session, Subject, System, SystemSpec, Watch,
};

use crate::recorded::MACHINE;
use crate::workload::support::small_frame;

const RUN: &str = "\
frame,what,count,cycle,needed,address,phase
00000000000000ab,cycles,1000,,,,
00000000000000ab,alpha,30000,,,,rendering
00000000000000ab,sram-read.raster-in,32000,,,,
00000000000000ab,dram-read,64,10,20,4096,
00000000000000ab,dram-write,32,900,,0,
";

fn read(text: &str) -> Result<RecordedRun, String> {
    RecordedRun::read(text.as_bytes())
}

#[test]
fn counters_that_wrapped_gave_gigawatts() {
    for count in ["18446744073709551600", "9007199254740993", "1e17"] {
        let text = RUN.replace("30000", count);
        let said = read(&text).expect_err(count);
        let wanted = "line 3: `count` must be a whole number up to 9007199254740992";
        assert!(said.contains(wanted), "{said}");
    }
    // The largest ones in all phases have a sum.
    let most = RUN.replace("alpha,30000,,,,rendering", "alpha,9007199254740992,,,,sorting");
    let most = most + "00000000000000ab,alpha,9007199254740992,,,,preprocessing\n";
    let mut machine = Machine::parse(MACHINE).expect("a machine");
    let attached = machine
        .flow()
        .attach(&mut machine, &mut |_| Ok(Box::new(Cursor::new(most.clone().into_bytes()))));
    assert_eq!(attached, Ok(()));
    let spec: &RecordedSpec = machine.of_type();
    let doubt = spec.run.get().and_then(|run| run.doubt(spec)).expect("a doubt");
    for part in ["run.csv: frame 00000000000000ab has `alpha` = 18014398509481984", "32000 in its"]
    {
        assert!(doubt.contains(part), "{doubt}");
    }
    // What the units and banks can do is no matter.
    let plain = read(RUN).expect("a run");
    assert_eq!(plain.doubt(spec), None);
}

/// How another program writes a cell: its column and its text.
type CellForm = dyn Fn(usize, &str) -> String;

#[test]
fn tables_of_r_and_pandas_were_no_runs() {
    let plain = read(RUN).expect("a run");
    let row = |line: &str, cell: &CellForm| {
        let cells = line.split(',').enumerate().map(|(i, text)| cell(i, text));
        cells.collect::<Vec<_>>().join(",")
    };
    let floats = |i: usize, text: &str| match (2..=5).contains(&i) && text.parse::<u64>().is_ok() {
        true => format!("{text}.0"),
        false => text.to_owned(),
    };
    let quotes = |i: usize, text: &str| match i < 2 || text.parse::<u64>().is_err() {
        true => format!("\"{text}\""),
        false => text.to_owned(),
    };
    let gaps = |_: usize, text: &str| match text {
        "" => "NA".to_owned(),
        "30000" => "3e+04".to_owned(),
        text => text.to_owned(),
    };
    let forms: [&CellForm; 3] = [&floats, &quotes, &gaps];
    for form in forms {
        let lines: Vec<String> = RUN.lines().map(|line| row(line, form)).collect();
        let text = lines.join("\r\n");
        let same = read(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert_eq!(same.frames, plain.frames, "{text}");
    }
    for wrong in ["1000.5", "-1000.0", "inf", "nan"] {
        let said = read(&RUN.replace("cycles,1000", &format!("cycles,{wrong}")));
        assert!(said.is_err_and(|e| e.contains("line 2: `count` must be")), "{wrong}");
    }
    let numbered = RUN.replace("frame,what", ",frame,what");
    assert!(read(&numbered).is_err_and(|e| e.contains("numbers of rows?")));
    // Lines within a text that does not end are not kept.
    let begins = format!("{RUN}\"");
    let endless = begins.as_bytes().chain(std::io::repeat(b'\n'));
    let said = RecordedRun::read(endless).expect_err("no end");
    assert!(said.contains("quotes do not end"), "{said}");
}

#[test]
fn parts_of_a_recorded_unit_were_asked_for_one_by_one() {
    let text = MACHINE.replace("[recorded.units.raster]", "[recorded.units.vru]");
    let text = text.replace("parts.lanes = 16\n", "");
    let said = Machine::parse(&text).expect_err("no parts").to_string();
    for part in ["blend", "pixels", "recurrence"] {
        assert!(said.contains(&format!("`recorded.units.vru.parts.{part}`")), "{part}: {said}");
    }
}

/// Wants the run until it was asked so often.
struct Patient {
    asked: AtomicU32,
}

impl Watch for Patient {
    fn is_cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) > 3
    }
}

/// The frame takes 8.6 s of a memory with another user: minutes of simulation.
#[test]
fn a_long_frame_could_not_be_interrupted() {
    let home = tempfile::tempdir().expect("a folder");
    let path = home.path().join("mine.toml");
    let machine = MACHINE.replace("\"bandwidth\"", "\"banked\"");
    let machine = machine + "[dram.second-master]\nrate = \"5 GB/s\"\n";
    fs::write(&path, machine).expect("a file");
    let frame = small_frame(0);
    let run = RUN.replace("00000000000000ab", &format!("{:016x}", frame.id()));
    let run = run.replace("cycles,1000", "cycles,8589934592");
    fs::write(home.path().join("run.csv"), run).expect("a file");
    let system = System::named(&path.display().to_string()).expect("a machine");
    let mut frames = MemoryFrames { name: "one".to_owned(), frames: vec![Arc::new(frame)] };
    let watch = Patient { asked: AtomicU32::new(0) };
    let subjects = [Subject::of(&system)];
    let folded = Session::new(&mut frames, &watch).fold(&subjects, |_| (), |(), _| ());
    let folded = folded.expect("no error");
    assert!(!folded.is_complete && folded.frames == 0);
}

/// A file that both the folder of a file and the working folder might have.
const HERE: &str = "Cargo.toml";

#[test]
fn a_file_of_the_working_folder_was_taken_for_one_beside() {
    let home = tempfile::tempdir().expect("a folder");
    let read = |name: &str| DiskFiles.read(FileKind::Energy, name, Some(home.path()));
    let said = read(HERE).expect_err("not there").to_string();
    assert!(said.contains("in the working folder is not taken"), "{said}");
    assert!(said.contains(&home.path().display().to_string()), "{said}");
    let opened = DiskFiles.open(HERE, Some(home.path()));
    assert!(opened.is_err_and(|e| e.contains("in the working folder is not taken")));
    // What comes with the program is found from anywhere, and so is what has a whole path.
    assert!(read("gscore-28nm").is_ok());
    let mine = home.path().join("mine.toml");
    fs::write(&mine, "base = \"gscore-28nm\"\nname = \"mine\"\n").expect("a file");
    assert!(read("mine.toml").is_ok() && read(&mine.display().to_string()).is_ok());
    let unknown = read("gscore-28").expect_err("no such name").to_string();
    assert!(unknown.contains("did you mean `gscore-28nm`?"), "{unknown}");
}

#[test]
fn what_a_base_names_was_looked_for_beside_the_file_on_it() {
    let home = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = home.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(&path, text).expect("a file");
        path.display().to_string()
    };
    let table = |name: &str| format!("base = \"gscore-28nm\"\nname = \"{name}\"\n");
    write("bases/mine.toml", &table("of-the-base"));
    write("mine.toml", &table("of-the-file"));
    let base = "base = \"gscore\"\nname = \"base\"\nenergy = \"mine.toml\"\n";
    write("bases/base.toml", base);
    let plain = "base = \"bases/base.toml\"\nname = \"plain\"\n";
    let (plain, own) = (
        write("plain.toml", plain),
        write("own.toml", &format!("{plain}energy = \"mine.toml\"\n")),
    );
    let named = |path: &str| System::named(path).expect(path).energy_table().name.clone();
    assert_eq!([named(&plain), named(&own)], ["of-the-base", "of-the-file"]);
    // What is typed is of the working folder.
    let sets = vec!["energy=mine.toml".to_owned()];
    let typed = System::load(&SystemSpec { sets, ..SystemSpec::named(&own) }, &DiskFiles);
    assert!(typed.is_err_and(|e| e.to_string().starts_with("mine.toml: ")));
    write("other.toml", &table("other"));
    let change: Change = "energy=other.toml".parse().expect("a change");
    let plain = System::named(&plain).expect("a machine");
    assert!(plain.with(&[change]).is_err_and(|e| e.to_string().starts_with("other.toml: ")));
}

#[test]
fn prices_in_joules_were_believed() {
    let base = System::named("gscore").expect("a machine");
    let with = |price: &str| {
        let price = format!("energy:dram.flat.read.energy={price}");
        let changes = ["energy=gscore-28nm-flat", price.as_str()]
            .map(|change| change.parse::<Change>().expect("a change"));
        base.with(&changes).expect("a machine").doubts()
    };
    assert_eq!(with("50 pJ/B"), Vec::<String>::new());
    let doubts = with("8e-12 pJ/B").join("\n");
    for part in ["gscore-28nm-flat", "costs 8e-12 pJ", "in joules"] {
        assert!(doubts.contains(part), "{doubts}");
    }
}
