//! Gaze streams.

use powergs_frame::fovea::{GazeStream, StreamError};
use powergs_frame::scene::Eye;

#[test]
fn the_last_gaze_is_held_for_a_while() {
    let text = "time_s,x,y\n0.0,0.5,0.5\n0.1,0.6,0.4\n0.2,,\n0.5,0.1,1\n";
    let stream = GazeStream::parse(text).expect("a stream");
    let at = |time: f64| stream.at(time, Eye::Left, 0.15);
    assert_eq!(at(0.05), Ok([0.5, 0.5]));
    assert_eq!(at(0.1), Ok([0.6, 0.4]));
    assert_eq!(at(0.24), Ok([0.6, 0.4]), "a blink");
    assert!(matches!(at(0.3), Err(StreamError::Gap { .. })), "closed for too long");
    assert!(matches!(at(-0.1), Err(StreamError::Gap { .. })), "before the first");
    assert_eq!(at(0.6), Ok([0.1, 1.0]));
    assert!(at(0.8).unwrap_err().to_string().contains("the last one is of 0.500 s"));
}

#[test]
fn eyes_have_their_own_columns() {
    let text = "time_s,left_x,left_y,right_x,right_y\n0,0.1,0.2,0.3,0.4\n1,,,0.5,0.5\n";
    let stream = GazeStream::parse(text).expect("a stream");
    assert_eq!(stream.at(1.0, Eye::Left, 2.0), Ok([0.1, 0.2]));
    assert_eq!(stream.at(1.0, Eye::Right, 2.0), Ok([0.5, 0.5]));
}

#[test]
fn mistakes_have_their_line() {
    for (text, says) in [
        ("", "line 1"),
        ("t,x,y\n0,1,1\n", "time_s,x,y"),
        ("time_s,x,y\n", "no samples"),
        ("time_s,x,y\n0,0.5,0.5\n0,0.5,0.5\n", "line 3: times must ascend"),
        ("time_s,x,y\n0,1.5,0.5\n", "line 2: gaze 1.5,0.5"),
        ("time_s,x,y\n0,NaN,0.5\n", "line 2: `NaN` is not a number"),
        ("time_s,x,y\n0,0.5\n", "line 2: 2 cells"),
        ("time_s,x,y\n0,0.5,\n", "line 2: a gaze with one number"),
        ("time_s,x,y\ninf,0.5,0.5\n", "line 2"),
    ] {
        let error = GazeStream::parse(text).expect_err(text).to_string();
        assert!(error.contains(says), "{text:?}: {error}");
    }
}
