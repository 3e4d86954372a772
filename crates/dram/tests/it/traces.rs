//! Address traces: every form, and what is wrong with others.

use powergs_dram::address_trace::Requests;
use powergs_dram::drive::Access;
use proptest::prelude::*;

use super::streams::as_text;

fn read(text: &[u8]) -> Result<Vec<Access>, String> {
    Requests::new(text).collect::<Result<_, _>>().map_err(|e| e.to_string())
}

#[test]
fn all_forms_are_read() {
    let text = "\u{feff}# a trace\r\n\nR 0x1F40 64\r\nw 8000 32 // half\nLD 0x40\nst 128\n\
                0x12345680 R\n4096 W\n  \t\nR 0xffffffffffffffff 1048576";
    let wanted = [
        (false, 0x1f40, 64),
        (true, 8000, 32),
        (false, 0x40, 64),
        (true, 128, 64),
        (false, 0x1234_5680, 64),
        (true, 4096, 64),
        (false, u64::MAX, 1 << 20),
    ];
    let wanted = wanted.map(|(write, address, bytes)| Access { write, address, bytes });
    assert_eq!(read(text.as_bytes()).expect("a trace"), wanted);
}

#[test]
fn traces_of_dramsim3_are_read_without_their_cycles() {
    let mut requests = Requests::new(&b"0x0 WRITE 0\n0x40 READ 10\n0x80 read 20\n0xc0 R\n"[..]);
    let found: Vec<Access> = requests.by_ref().collect::<Result<_, _>>().expect("a trace");
    let wanted = [(true, 0), (false, 0x40), (false, 0x80), (false, 0xc0)];
    assert_eq!(found, wanted.map(|(write, address)| Access { write, address, bytes: 64 }));
    assert_eq!(requests.with_cycles(), 3);
    refused(b"0x40 READ", &["line 1", "no cycle"]);
    refused(b"0x40 READ x", &["`x` is not a cycle", "`0x1f40 READ 10`"]);
    refused(b"0x40 READ 3 4", &["`4` is too much"]);
}

#[track_caller]
fn refused(text: &[u8], parts: &[&str]) {
    let error = read(text).expect_err("a broken trace");
    assert!(parts.iter().all(|p| error.contains(p)), "{error}");
}

#[test]
fn broken_lines_are_named() {
    refused(b"R 0x40 64\nR 0x80\n", &["line 2", "no size", "`0x80`", "write `R 0x1f40 64`"]);
    refused(b"X 0x40 64", &["line 1", "`X` is not an address"]);
    refused(b"0x40", &["line 1", "alone"]);
    refused(b"0x40 Q", &["neither R nor W"]);
    refused(b"0x40 LD", &["neither R nor W"]);
    refused(b"R", &["no address after `R`"]);
    refused(b"R 0x 64", &["`0x` is not an address"]);
    refused(b"R -5 64", &["`-5` is not an address"]);
    refused(b"R +5 64", &["`+5` is not an address"]);
    refused(b"R 0,1,2,3,4 64", &["is not an address"]);
    refused(b"R 0x10000000000000000 64", &["more than 64 bits"]);
    refused(b"R 0x40 0", &["0 bytes"]);
    refused(b"R 0x40 1048577", &["at most 1048576"]);
    refused(b"R 0x40 99999999999999999999", &["at most 1048576"]);
    refused(b"R 0x40 64 now", &["`now` is too much"]);
    refused(b"R 0x40 \xff\n", &["line 1", "no text"]);
    refused(b"R 0x40 64\n\0\0", &["line 2"]);
    refused(&[b' '; 5000], &["longer than 1024 bytes"]);
    refused(b"", &["no request in 0 lines"]);
    refused(b"# nothing\n\n", &["no request in 2 lines"]);
}

#[test]
fn after_an_error_there_is_nothing() {
    let mut requests = Requests::new(&b"?\nR 0 64\n"[..]);
    assert!(requests.next().is_some_and(|r| r.is_err()));
    assert!(requests.next().is_none());
}

proptest! {
    #[test]
    fn any_bytes_are_requests_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let _ = read(&bytes);
    }

    #[test]
    fn almost_right_lines_never_panic(text in "(R|W|LD|ST|0x1f|7|-|#|,| |\n|\r|x|ff){0,40}") {
        if let Ok(all) = read(text.as_bytes()) {
            prop_assert!(all.iter().all(|a| (1..=1 << 20).contains(&a.bytes)));
        }
    }

    #[test]
    fn what_is_written_is_read(seed in 0u64..1000) {
        let all = super::streams::traffic(seed, 50, 4);
        let text = as_text(&all);
        prop_assert_eq!(read(text.as_bytes()).expect("a trace"), all);
    }
}
