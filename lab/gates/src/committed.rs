//! The netlists that come with the program.

use crate::netlist::Netlist;

/// Libraries that the units are mapped to, by the name that users give: node, name of the library.
pub const LIBRARIES: [(&str, &str); 2] = [("45nm", "nangate45"), ("7nm", "asap7")];

/// Unit, library, file.
type File = (&'static str, &'static str, &'static [u8]);

macro_rules! file {
    ($unit:literal, $library:literal) => {
        (
            $unit,
            $library,
            include_bytes!(concat!("../../../rtl/netlists/", $unit, "-", $library, ".gates")),
        )
    };
}

const FILES: [File; 14] = [
    file!("ccu", "nangate45"),
    file!("ccu", "asap7"),
    file!("qsu", "nangate45"),
    file!("qsu", "asap7"),
    file!("bsu", "nangate45"),
    file!("bsu", "asap7"),
    file!("vrc", "nangate45"),
    file!("vrc", "asap7"),
    file!("vrc-e5m6", "nangate45"),
    file!("vrc-e5m6", "asap7"),
    file!("vrc-e4m3", "nangate45"),
    file!("vrc-e4m3", "asap7"),
    file!("vru", "nangate45"),
    file!("vru", "asap7"),
];

/// The netlist of a unit in a library (`45nm` or `nangate45`); `None` if there is none.
///
/// # Panics
/// When a committed file is damaged, which the tests of this crate rule out.
pub fn netlist(unit: &str, library: &str) -> Option<Netlist> {
    let node = LIBRARIES.iter().find(|(node, _)| *node == library);
    let library = node.map_or(library, |(_, library)| library);
    let file = FILES.iter().find(|(name, of, _)| *name == unit && *of == library)?;
    Some(Netlist::from_bytes(file.0, file.2).expect("a committed netlist is whole"))
}
