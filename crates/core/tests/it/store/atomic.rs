//! Files that appear whole or not at all.

use powergs_core::run::store::atomic::{remove_leftovers, write_atomically};

#[cfg(unix)]
#[test]
fn a_device_is_written_and_not_replaced() {
    let device = std::path::Path::new("/dev/null");
    write_atomically(device, |w| w.write_all(b"text")).unwrap();
    assert!(!device.is_file() && !device.is_dir());
}

#[test]
fn what_a_killed_process_left_is_removed_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    for name in [".powergs-sim-Abc123", "results.csv", ".powergs"] {
        std::fs::write(folder.path().join(name), "text").unwrap();
    }
    std::fs::create_dir(folder.path().join(".powergs-sim-folder")).unwrap();
    remove_leftovers(folder.path()).unwrap();
    let left = std::fs::read_dir(folder.path()).unwrap();
    let mut left: Vec<_> = left.map(|e| e.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, [".powergs", ".powergs-sim-folder", "results.csv"]);
}

#[test]
fn a_failed_write_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    write_atomically(&path, |w| w.write_all(b"first")).unwrap();
    let broken = write_atomically(&path, |w| {
        w.write_all(b"second")?;
        Err(std::io::Error::other("disk full"))
    });
    assert!(broken.unwrap_err().to_string().contains("disk full"));
    assert_eq!(std::fs::read(&path).unwrap(), b"first");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing left behind");
}
