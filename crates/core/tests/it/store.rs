//! Stores: atomic writes, journals, locks; a folder and memory behave alike.

mod atomic;
mod journal;

use std::io::Write;

use powergs_core::run::store::{FileStore, MemoryStore, Sharing, Store};

/// The same checks on both kinds of store.
fn on_both(check: impl Fn(&dyn Store)) {
    check(&MemoryStore::new());
    let folder = tempfile::tempdir().unwrap();
    check(&FileStore::new(folder.path().join("store")));
}

#[test]
fn a_file_appears_when_it_is_whole() {
    on_both(|store| {
        assert_eq!(store.read("a.txt").unwrap(), None);
        let mut file = store.create("a.txt").unwrap();
        file.write_all(b"first").unwrap();
        assert_eq!(store.read("a.txt").unwrap(), None);
        assert!(store.list("").unwrap().is_empty());
        file.commit().unwrap();
        drop(store.create("a.txt").unwrap());
        assert_eq!(store.read_text("a.txt").unwrap().as_deref(), Some("first"));
        store.write("b/c.txt", b"second").unwrap();
        assert_eq!(store.list("").unwrap(), ["a.txt", "b"]);
        assert_eq!(store.list("b").unwrap(), ["c.txt"]);
        store.remove("b").unwrap();
        assert_eq!(store.list("").unwrap(), ["a.txt"]);
    });
}

#[test]
fn a_lock_is_held_alone_or_shared() {
    on_both(|store| {
        let beside = store.lock("lock", Sharing::Beside).unwrap();
        let other = store.lock("lock", Sharing::Beside).unwrap();
        assert!(store.lock("lock", Sharing::Alone).is_err());
        drop((beside, other));
        let alone = store.lock("lock", Sharing::Alone).unwrap();
        assert!(store.lock("lock", Sharing::Beside).is_err());
        drop(alone);
        store.lock("lock", Sharing::Alone).unwrap();
    });
}

#[test]
fn journals_keep_the_first_record_of_a_key_and_survive_a_torn_line() {
    on_both(|store| {
        let mut journals = store.journals("records", Some("one")).unwrap();
        journals.append(1, "{\"a\":1}").unwrap();
        journals.append(1, "{\"a\":2}").unwrap();
        journals.append(2, "{}").unwrap();
        assert!(store.journals("records", Some("one")).is_err(), "one process writes");
        assert_eq!(journals.get(1).unwrap().as_deref(), Some("{\"a\":1}"));
        journals.sync().unwrap();
        drop(journals);
        let whole = store.read("records/one.jsonl").unwrap().unwrap();
        store.write("records/one.jsonl", &whole[..whole.len() - 3]).unwrap();
        let mut journals = store.journals("records", Some("one")).unwrap();
        assert_eq!((journals.keys(), journals.damaged()), (vec![1], 1));
        journals.append(3, "{\"b\":3}").unwrap();
        drop(journals);
        let mut other = store.journals("records", Some("two")).unwrap();
        other.append(2, "{\"c\":2}").unwrap();
        drop(other);
        let mut all = store.journals("records", None).unwrap();
        assert_eq!(all.keys(), [1, 2, 3]);
        assert_eq!(all.get(3).unwrap().as_deref(), Some("{\"b\":3}"));
        assert_eq!(all.get(4).unwrap(), None);
    });
}
