//! Names of machines.

use powergs_codesign::pricing::Row;

fn row(columns: &[&str], axes: usize, settings: &[&str]) -> Row {
    let texts = |all: &[&str]| all.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
    Row {
        columns: texts(columns),
        axes,
        settings: [(Some(7), texts(settings))].into(),
        ..Row::default()
    }
}

#[test]
fn a_machine_is_called_by_its_axes() {
    let columns = ["vru.cores", "clock", "clock.si", "sorters", "buffers.sorting.capacity"];
    let machine = row(&columns, 4, &["2", "500 MHz", "500000000", "low power", "32 KiB"]);
    assert_eq!(machine.name(Some(7)), "cores=2 clock=500MHz sorters=low power");
    assert_eq!(machine.axes(), [(0, "vru.cores"), (1, "clock"), (3, "sorters")]);
    assert_eq!(machine.name(Some(8)), "", "a machine that is not there");
    assert_eq!(Row::default().name(None), "");
}

#[test]
fn keys_that_could_be_others_are_whole() {
    let columns = ["ccu.units", "vru.units-per-core", "gsu.fill", "vru.fill", "display:scale"];
    let machine = row(&columns, 5, &["1", "8", "3", "", "0.3"]);
    assert_eq!(machine.name(Some(7)), "ccu.units=1 units-per-core=8 gsu.fill=3 scale=0.3");
}
