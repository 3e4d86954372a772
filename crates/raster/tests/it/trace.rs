//! Rendered frames in trace files.

use powergs_frame::trace::{ColumnGroup, Writer};
use powergs_raster::{Detail, Options, render};
use powergs_testkit::scenes::{front_camera, random_scene};
use powergs_testkit::traces::{header, read_all};

#[test]
fn sizes_add_up_and_rendered_frames_are_small() {
    let scene = random_scene(3, 20_000, 0);
    let view = front_camera(320, 200);
    let rendered = render(&scene, &view, &Options::reference(Detail::Counters));
    let frame = rendered.into_frame(&view, [0.0; 3]);
    let mut writer = Writer::new(Vec::new(), &header(20_000)).unwrap();
    let before = writer.len();
    let info = writer.write_frame(&frame).unwrap();
    assert_eq!((before, writer.len()), (0, 1));
    let groups = [ColumnGroup::Splat, ColumnGroup::Pixel, ColumnGroup::Other];
    let stored: u64 = groups.iter().map(|&g| info.stored_bytes(g)).sum();
    assert_eq!(stored, info.head.bytes);
    assert_eq!(info.raw_bytes(ColumnGroup::Splat), 32 * frame.splats.len() as u64);
    assert_eq!(info.raw_bytes(ColumnGroup::Pixel), 8 * 320 * 200);
    // Uniformly random Gaussians are harder than trained ones (about 23 bytes); raw are 32.
    let per_splat = info.stored_bytes(ColumnGroup::Splat) as f64 / frame.splats.len() as f64;
    assert!(per_splat < 26.0, "{per_splat} bytes a splat");
    assert_eq!(read_all(&writer.finish().unwrap()).unwrap(), [frame]);
}
