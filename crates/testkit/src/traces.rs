//! Small traces.

use std::io::Cursor;

use glam::{DMat3, DVec3};
use powergs_frame::fovea::Screen;
use powergs_frame::scene::{Camera, ShDegree, Split, StorageOrder};
use powergs_frame::splat::Splat;
use powergs_frame::trace::{
    Fovea, Frame, FrameFacts, NEVER, PixelColumns, Preview, Reader, TraceError, TraceHeader, Writer,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

pub fn header(points: u64) -> TraceHeader {
    TraceHeader {
        generator: "test 1".into(),
        scene: "scène".into(),
        points,
        order: StorageOrder::Storage,
    }
}

/// The bytes of a trace of these frames; all have the points of the first.
pub fn written(frames: &[Frame]) -> Vec<u8> {
    let points = frames.first().map_or(7, |f| f.facts.points);
    let mut writer = Writer::new(Vec::new(), &header(points)).unwrap();
    for frame in frames {
        writer.write_frame(frame).unwrap();
    }
    writer.finish().unwrap()
}

/// Opens the trace and reads every frame, and every frame's sizes.
pub fn read_all(bytes: &[u8]) -> Result<Vec<Frame>, TraceError> {
    let mut reader = Reader::open(Cursor::new(bytes))?;
    (0..reader.len())
        .map(|k| {
            reader.info(k)?;
            reader.frame(k)
        })
        .collect()
}

pub fn camera(width: u32, height: u32) -> Camera {
    Camera {
        name: "view 0".into(),
        width,
        height,
        fx: 100.5,
        fy: 99.25,
        cx: 1.5,
        cy: 2.5,
        world_to_camera: DMat3::from_rotation_y(0.3) * DMat3::from_rotation_x(-0.7),
        centre: DVec3::new(1.0, -2.0, 3.5),
        split: Some(Split::Test),
        eye: None,
    }
}

/// What a random frame has.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    pub points: u32,
    pub splats: u32,
    pub width: u32,
    pub height: u32,
    pub foveated: bool,
    pub extras: bool,
}

pub const SMALL: Shape =
    Shape { points: 21, splats: 9, width: 5, height: 3, foveated: true, extras: true };

/// A random frame that keeps the rules. Floats are arbitrary finite bit patterns.
pub fn frame(seed: u64, shape: Shape) -> Frame {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let splats = splats(&mut rng, shape);
    let pixels = (shape.width * shape.height) as usize;
    let (mut stop_rank, mut blended) = (Vec::new(), Vec::new());
    for _ in 0..pixels {
        let never = shape.splats == 0 || rng.random_bool(0.4);
        let stop = if never { NEVER } else { rng.random_range(0..shape.splats) };
        stop_rank.push(stop);
        blended.push(rng.random_range(0..=if never { shape.splats } else { stop + 1 }));
    }
    let mut counts = |n: usize| (0..n).map(|_| rng.random_range(0..=shape.splats)).collect();
    let fovea = shape.foveated.then(|| Fovea {
        gaze: [0.25, 0.75],
        screen: if seed < 1000 {
            Screen::PUBLISHED
        } else {
            Screen { fov_deg: 99.5, pooling_rate: 0.125 }
        },
        highest_level: (0..shape.splats).map(|r| (r % 4) as u8).collect(),
        stop_rank_2: stop_rank.iter().rev().copied().collect(),
        extra_alpha: counts(pixels),
        blended_2: counts(pixels),
    });
    let (survivors, bits) = survivors(&splats, shape.points);
    let rgb: Vec<u8> = (0..18).map(|i: u64| i.wrapping_mul(seed) as u8).collect();
    Frame {
        facts: FrameFacts {
            camera: camera(shape.width, shape.height),
            points: u64::from(shape.points),
            survivors,
            sh_degree: ShDegree::new((seed % 4) as u8).filter(|_| shape.extras),
            antialiased: shape.extras && seed.is_multiple_of(3),
            background: [0.0, 0.5, 1.0],
            mean_linear_rgb: shape.extras.then_some([0.1, 0.2, 1e-9]),
        },
        splats,
        frustum_bits: shape.extras.then(|| bits.iter().map(|b| b & 0x5B).collect()),
        survivor_bits: shape.extras.then_some(bits),
        pixels: PixelColumns { stop_rank, blended },
        fovea,
        preview: shape.extras.then_some(Preview { width: 3, height: 2, rgb }),
    }
}

fn splats(rng: &mut Pcg64Mcg, shape: Shape) -> Vec<Splat> {
    let mut indices: Vec<u32> = (0..shape.points).collect();
    let mut splats = Vec::new();
    for _ in 0..shape.splats {
        let index = indices.swap_remove(rng.random_range(0..indices.len()));
        let mut float = || loop {
            let value = f32::from_bits(rng.random());
            if value.is_finite() {
                return value;
            }
        };
        let (mean, cov) = ([float(), float()], [float(), float(), float()]);
        // Few depths, so that ties occur; the smallest and the largest float among them.
        let depths = [f32::from_bits(1), 0.25, 0.25f32.next_up(), 1.0, f32::MAX];
        let depth = depths[rng.random_range(0..depths.len())];
        let opacity = [0.0, -0.0, 1.0, rng.random()][rng.random_range(0..4)];
        splats.push(Splat { index, depth, mean, cov, opacity });
    }
    splats.sort_by_key(|s| s.order_key());
    splats
}

/// Every splat survives, and the last point.
fn survivors(splats: &[Splat], points: u32) -> (u64, Vec<u8>) {
    let mut bits = vec![0u8; points.div_ceil(8) as usize];
    let last = points.checked_sub(1);
    for index in splats.iter().map(|s| s.index).chain(last) {
        bits[index as usize / 8] |= 1 << (index % 8);
    }
    (bits.iter().map(|b| u64::from(b.count_ones())).sum(), bits)
}

/// Small files for the fuzz targets: target, name, bytes.
pub fn seeds() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let tiny = Shape { points: 2, splats: 1, width: 1, height: 1, foveated: false, extras: false };
    let files = [
        ("empty", written(&[])),
        ("tiny", written(&[frame(1, tiny)])),
        ("foveated", written(&[frame(2, SMALL)])),
        ("two", written(&[frame(3, SMALL), frame(4, Shape { foveated: false, ..SMALL })])),
    ];
    let targets = ["trace", "trace_sealed"];
    targets
        .into_iter()
        .flat_map(|target| files.iter().map(move |(name, bytes)| (target, *name, bytes.clone())))
        .collect()
}
