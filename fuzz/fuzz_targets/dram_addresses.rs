//! Address traces: any bytes are requests or an error that names the line.
#![no_main]

use libfuzzer_sys::fuzz_target;
use powergs_sim::dram::address_trace::Requests;

fuzz_target!(|bytes: &[u8]| {
    for request in Requests::new(bytes) {
        let _ = request;
    }
});
