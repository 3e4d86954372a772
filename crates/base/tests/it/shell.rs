//! A shell takes a quoted line apart into the words that it was made of.

use powergs_base::shell::{line, quoted};

#[test]
fn plain_words_stay_plain() {
    for word in ["replay", "traces/demo.bin", "--set", "vru.cores=8", "0..1", "a,b", "50%"] {
        assert_eq!(quoted(word), word);
    }
    assert_eq!(line(["a", "b c"]), "a 'b c'");
}

#[test]
fn nothing_leaves_its_quotes() {
    assert_eq!(quoted(""), "''");
    assert_eq!(quoted("a;touch here;.bin"), "'a;touch here;.bin'");
    assert_eq!(quoted("it's"), r"'it'\''s'");
    assert_eq!(quoted("$(x) `y` \\ \"z\""), "'$(x) `y` \\ \"z\"'");
    assert_eq!(quoted("~/a*"), "'~/a*'");
    assert_eq!(quoted("=ls"), "'=ls'");
}
