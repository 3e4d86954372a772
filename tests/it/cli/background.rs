//! The `--background` flag.

use powergs_sim::cli::background::Background;

#[test]
fn colours_are_read_and_others_refused() {
    assert_eq!("white".parse(), Ok(Background([1.0; 3])));
    assert_eq!("0, 0.5,1".parse(), Ok(Background([0.0, 0.5, 1.0])));
    for bad in ["", "blue", "1,1", "0,0,2", "nan,0,0", "1,1,1,1", "0,x,0,0"] {
        assert!(bad.parse::<Background>().is_err(), "{bad}");
    }
}
