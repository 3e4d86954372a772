//! The foveated model and its file.

use powergs_scene::foveated::ComposeError;
use powergs_scene::{Foveated, Gaussians, OneFile, SceneError, read};
use powergs_testkit::foveated::levels;
use proptest::prelude::*;

fn file(model: &Foveated) -> Vec<u8> {
    let mut bytes = Vec::new();
    model.write(&mut bytes).expect("memory");
    bytes
}

fn parse(bytes: &[u8]) -> Result<Foveated, SceneError> {
    Foveated::read(bytes.into())
}

/// Sets bytes and mends the checksum of the header or of the column that begins at `column`.
fn seal(bytes: &mut [u8], column: usize, len: usize) {
    let crc = crc32fast::hash(&bytes[column..column + len]);
    bytes[column + len..column + len + 4].copy_from_slice(&crc.to_le_bytes());
}

#[test]
fn composed_written_read_and_taken_apart() {
    for degree in 0..=3 {
        let mut parts = levels(u64::from(degree), 40, degree, 0.6);
        parts.iter_mut().for_each(|part| part.antialiased = degree == 1);
        let model = Foveated::compose(&parts).expect("nested levels");
        let again = parse(&file(&model)).expect("a file");
        assert_eq!(again, model);
        assert_eq!(file(&again), file(&model));
        for (k, part) in parts.iter().enumerate() {
            assert_eq!(model.level(k), *part, "level {k}");
        }
        // A reader of scenes takes level 1, and knows no other detail of it.
        let bytes = file(&model);
        let first = read(&OneFile(&bytes), "m.fov", None).expect("a scene");
        assert_eq!(first.gaussians, parts[0]);
        assert_eq!(first.format.name(), "foveated model");
        let other = read(&OneFile(&bytes), "m.fov", Some(1)).expect_err("a single detail");
        assert!(other.to_string().contains("leave it out"), "{other}");
        assert_eq!(model.counts(), [0, 1, 2, 3].map(|k: usize| parts[k].len()));
    }
}

#[test]
fn levels_that_do_not_belong_together() {
    let good = levels(7, 30, 1, 0.7);
    let refused = |change: &dyn Fn(&mut [Gaussians; 4])| {
        let mut parts = good.clone();
        change(&mut parts);
        Foveated::compose(&parts).expect_err("levels that are none")
    };
    let moved = refused(&|p| p[2].means[3][0] += 1e-6);
    let at_three = ComposeError::NotNested { level: 3, index: 3, before: 2, why: "" };
    assert_eq!(moved, at_three);
    let kind = refused(&|p| p[3].antialiased = true);
    assert_eq!(kind, ComposeError::Kind { level: 4 });
    let tinted = refused(&|p| p[1].sh[1] = 9.0);
    assert!(matches!(tinted, ComposeError::NotNested { level: 2, index: 0, .. }), "{tinted}");
    let shuffled = refused(&|p| {
        p[1].means.swap(0, 5);
        p[1].log_scales.swap(0, 5);
        p[1].rotations.swap(0, 5);
        (0..12).for_each(|k| p[1].sh.swap(k, 60 + k));
    });
    assert!(shuffled.to_string().contains("the order differs"), "{shuffled}");
    // A Gaussian that level 2 has and level 3 lacks is back in level 4.
    let back = refused(&|p| p[3] = p[1].clone());
    assert!(matches!(back, ComposeError::NotNested { level: 4, .. }), "{back}");
    let empty = refused(&|p| p[3] = Gaussians::with_capacity(0, 1));
    assert_eq!(empty, ComposeError::Empty { level: 4 });
    let degree = refused(&|p| p[2] = levels(7, 30, 2, 0.7)[2].clone());
    assert!(matches!(degree, ComposeError::Degree { level: 3, found: 2, expected: 1 }), "{degree}");
}

#[test]
fn every_cut_and_every_flipped_bit_is_found() {
    let bytes = file(&Foveated::compose(&levels(3, 4, 0, 0.6)).expect("nested levels"));
    for end in 0..bytes.len() {
        assert!(parse(&bytes[..end]).is_err(), "cut at {end}");
    }
    let longer = [bytes.as_slice(), b"x"].concat();
    assert!(parse(&longer).is_err());
    for bit in 0..8 * bytes.len() {
        let mut bytes = bytes.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(parse(&bytes).is_err(), "bit {bit}");
    }
}

#[test]
fn sealed_nonsense_is_refused() {
    let model = Foveated::compose(&levels(5, 8, 0, 0.6)).expect("nested levels");
    let good = file(&model);
    let refused = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = good.clone();
        change(&mut bytes);
        parse(&bytes).expect_err("nonsense").to_string()
    };
    let promise = |count: u64| {
        refused(&|b| {
            b[12..20].copy_from_slice(&count.to_le_bytes());
            seal(b, 0, 28);
        })
    };
    // Terabytes are refused before they are allocated.
    promise(9);
    for count in [u64::MAX, 1 << 40, 1 << 31, 1 << 30] {
        let error = promise(count);
        assert!(error.contains("foveated model"), "{error}");
    }
    assert!(promise(0).contains("no Gaussians"));
    let version = refused(&|b| {
        b[8] = 2;
        seal(b, 0, 28);
    });
    assert!(version.contains("version 2"), "{version}");
    let (means, column) = (32, 12 * 8);
    let nan = refused(&|b| {
        b[means + 12..means + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        seal(b, means, column);
    });
    assert!(nan.starts_with("Gaussian 1:"), "{nan}");
    let rotations = means + 2 * (column + 4);
    let zero = refused(&|b| {
        b[rotations..rotations + 16].fill(0);
        seal(b, rotations, 16 * 8);
    });
    assert!(zero.contains("length zero"), "{zero}");
    let highest = rotations + 16 * 8 + 4 + 4;
    assert_eq!(&good[highest..highest + 8], model.highest.as_slice());
    let level = refused(&|b| {
        b[highest + 2] = 4;
        seal(b, highest, 8);
    });
    assert!(level.contains("entry 2: 4 is above 3"), "{level}");
    // One level more than there are paints for.
    let more = refused(&|b| {
        let low = (0..8).find(|&i| b[highest + i] < 3).expect("a pruned Gaussian");
        b[highest + low] += 1;
        seal(b, highest, 8);
    });
    assert!(more.contains("cut off or has been changed"), "{more}");
    let first = highest + 8 + 4 + 16 * 8 + 4;
    let paint = refused(&|b| {
        b[first..first + 4].copy_from_slice(&f32::INFINITY.to_le_bytes());
        seal(b, first, 16 * model.counts()[1]);
    });
    assert!(paint.contains("level 2 to 4"), "{paint}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]
    #[test]
    fn no_bytes_panic(noise in proptest::collection::vec(any::<u8>(), 0..200), at in 0usize..600) {
        let mut bytes = file(&Foveated::compose(&levels(1, 5, 0, 0.5)).expect("nested"));
        let at = at % bytes.len();
        let end = (at + noise.len()).min(bytes.len());
        bytes[at..end].copy_from_slice(&noise[..end - at]);
        let head = crc32fast::hash(&bytes[..28]);
        bytes[28..32].copy_from_slice(&head.to_le_bytes());
        let _ = parse(&bytes);
        let _ = parse(&noise);
    }
}
