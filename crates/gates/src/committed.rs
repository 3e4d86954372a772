//! The netlists that come with the program.

use crate::netlist::Netlist;

/// Libraries that the units are mapped to, by the name that users give: node, name of the library.
pub const LIBRARIES: [(&str, &str); 2] = [("45nm", "nangate45"), ("7nm", "asap7")];

/// Unit, library, file.
const FILES: [(&str, &str, &[u8]); 6] = [
    ("qsu", "nangate45", include_bytes!("../../../rtl/netlists/qsu-nangate45.gates")),
    ("qsu", "asap7", include_bytes!("../../../rtl/netlists/qsu-asap7.gates")),
    ("bsu", "nangate45", include_bytes!("../../../rtl/netlists/bsu-nangate45.gates")),
    ("bsu", "asap7", include_bytes!("../../../rtl/netlists/bsu-asap7.gates")),
    ("vrc", "nangate45", include_bytes!("../../../rtl/netlists/vrc-nangate45.gates")),
    ("vrc", "asap7", include_bytes!("../../../rtl/netlists/vrc-asap7.gates")),
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
