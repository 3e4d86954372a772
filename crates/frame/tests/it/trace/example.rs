//! The worked example of `docs/trace-format.md` is true.

use glam::{DMat3, DVec3};
use powergs_frame::scene::{Camera, ShDegree, StorageOrder};
use powergs_frame::splat::Splat;
use powergs_frame::trace::{Frame, FrameFacts, PixelColumns, TraceHeader, Writer};
use powergs_testkit::traces::read_all;

fn example() -> Vec<u8> {
    let frame = Frame {
        facts: FrameFacts {
            camera: Camera {
                name: "v".into(),
                width: 1,
                height: 1,
                fx: 1.0,
                fy: 1.0,
                cx: 0.5,
                cy: 0.5,
                world_to_camera: DMat3::IDENTITY,
                centre: DVec3::ZERO,
                split: None,
                eye: None,
            },
            points: 2,
            survivors: 1,
            sh_degree: Some(ShDegree::ZERO),
            antialiased: false,
            background: [0.0; 3],
            mean_linear_rgb: None,
        },
        splats: vec![Splat {
            index: 1,
            depth: 2.0,
            mean: [0.0, -0.25],
            cov: [1.0, 0.0, 1.5],
            opacity: 0.5,
        }],
        survivor_bits: None,
        frustum_bits: None,
        pixels: PixelColumns { stop_rank: vec![u32::MAX], blended: vec![1] },
        fovea: None,
        preview: None,
    };
    let header = TraceHeader {
        generator: "doc".into(),
        scene: "s".into(),
        points: 2,
        order: StorageOrder::Storage,
    };
    let mut writer = Writer::new(Vec::new(), &header).unwrap();
    writer.write_frame(&frame).unwrap();
    writer.finish().unwrap()
}

/// The bytes as in the documentation: lines `offset  hex bytes  comment`.
fn documented() -> Vec<u8> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/trace-example.hex");
    let text = std::fs::read_to_string(path).unwrap();
    let mut bytes = Vec::new();
    for line in text.lines() {
        let (offset, rest) = line.trim_start().split_once("  ").unwrap();
        assert_eq!(offset.parse(), Ok(bytes.len()), "{line}");
        let hex = rest.split("  ").next().unwrap().split(' ').filter(|h| !h.is_empty());
        bytes.extend(hex.map(|h| u8::from_str_radix(h, 16).unwrap()));
    }
    bytes
}

#[test]
fn the_documented_bytes_are_written_and_read() {
    let written = example();
    assert_eq!(documented(), written);
    assert_eq!(read_all(&written).unwrap()[0].splats[0].index, 1);
}
