//! The picture of the rendering hardware against its lists spelled out, and against f32.

use powergs_base::picture::Picture;
use powergs_datapath::{Entry, Form, NumberFormat, Pixel, Record, Vrc, Vru};
use powergs_frame::splat::project::colours;
use powergs_lab::{FrontEnd, render_datapath, render_hardware};
use powergs_raster::{Detail, Options, render};
use powergs_testkit::scenes::{front_camera, random_scene};

use crate::naive;

fn options() -> Options {
    Options { background: [0.2, 0.4, 0.9], ..Options::reference(Detail::Image) }
}

/// Every pixel through every splat of the list of its tile, none left out.
#[test]
fn a_picture_is_what_the_core_makes_of_every_list() {
    let format = NumberFormat::FP16;
    let vrc = Vrc::new(format).expect("enough exponent");
    let (options, camera) = (options(), front_camera(72, 51));
    for seed in 0..3 {
        let scene = random_scene(seed, 250, 0);
        let drawn = render_datapath(&scene, &camera, &options, &vrc, Some(format));
        let mut splats = render(&scene, &camera, &options).splats;
        splats.sort_by_key(|splat| (format.from_f32(splat.depth), splat.index));
        let colours = colours(&scene, camera.centre.as_vec3().to_array(), options.level);
        for (i, drawn) in drawn.pixels.iter().enumerate() {
            let (x, y) = (i as u32 % camera.width, i as u32 / camera.width);
            let (tx, ty) = (x / 16, y / 16);
            let mut pixel = Pixel::open(format, true);
            for splat in &splats {
                if !naive::accepted(splat, &camera, &options, tx, ty) {
                    continue;
                }
                let middle = [tx, ty].map(|t| 16.0 * f64::from(t) + 7.5);
                let mean = [0, 1].map(|k| f64::from(splat.mean[k]) - middle[k]);
                let colour = colours[splat.index as usize];
                let record = Record::new(format, mean, splat.cov, splat.opacity, colour);
                let record = record.expect("an ellipse");
                vrc.blend(&mut pixel, &record, x % 16, y % 16);
            }
            let behind = format.to_f32(pixel.transmittance);
            let expected =
                [0, 1, 2].map(|c| format.to_f32(pixel.colour[c]) + behind * options.background[c]);
            assert_eq!(*drawn, expected, "seed {seed}, pixel ({x}, {y})");
        }
    }
}

fn psnr(a: &Picture, b: &Picture) -> f64 {
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    let square = |(a, b): (&f32, &f32)| f64::from(a.clamp(0.0, 1.0) - b.clamp(0.0, 1.0)).powi(2);
    let values = 3 * a.pixels.len();
    -10.0 * (pairs.map(square).sum::<f64>() / values as f64).log10()
}

/// Thin splats that lie askew: the terms of a conic cancel, those of its root less so.
#[test]
fn forms_that_cancel_less_are_better() {
    let (options, camera) = (options(), front_camera(160, 120));
    let mut scene = random_scene(4, 2000, 0);
    for scales in &mut scene.log_scales {
        *scales = [scales[0] + 1.0, scales[1] - 4.0, scales[2] - 4.0];
    }
    let exact = render(&scene, &camera, &options).picture;
    let vrc = Vrc::new(NumberFormat::FP16).expect("enough exponent");
    let measure = |form| {
        psnr(&render_datapath(&scene, &camera, &options, &vrc.with_form(form), None), &exact)
    };
    let (local, root) = (measure(Form::Local), measure(Form::Root));
    let conic = measure(Form::Conic);
    assert!(local > root + 3.0 && root > conic + 6.0, "{local}, {root} and {conic} dB");
    assert!(root > 40.0, "{root} dB");
}

#[test]
fn fp16_is_above_40_db_and_fewer_bits_are_worse() {
    let (options, camera) = (options(), front_camera(160, 120));
    let scene = random_scene(9, 2000, 1);
    let exact = render(&scene, &camera, &options).picture;
    let measure = |name: &str| {
        let format: NumberFormat = name.parse().expect("a format");
        let vrc = Vrc::new(format).expect("enough exponent");
        psnr(&render_datapath(&scene, &camera, &options, &vrc, Some(NumberFormat::FP16)), &exact)
    };
    let db = ["e5m10", "e5m8", "e5m6", "e5m4", "e5m2"].map(measure);
    assert!(db[0] > 40.0, "{db:?}");
    assert!(db.is_sorted_by(|more, fewer| more > fewer), "{db:?}");
}

/// All units together: what the culling and conversion unit hands over, in the order of its depths,
/// is drawn by rendering units.
#[test]
fn the_hardware_draws_what_its_units_make_of_a_scene() {
    let format = NumberFormat::FP16;
    let vrc = Vrc::new(format).expect("enough exponent");
    let (options, camera) = (options(), front_camera(72, 51));
    for seed in 0..3 {
        let scene = random_scene(seed, 250, 1);
        let drawn = render_hardware(&scene, &camera, &options, &vrc).expect("enough exponent");
        let front = FrontEnd::new(&scene, &camera, format).expect("enough exponent");
        let mut lists = vec![Vec::new(); 5 * 4];
        for i in 0..scene.len() {
            let work = front.work(i);
            let Some((splat, walk)) = front.unit.splat(&front.settings, &work.gaussian) else {
                continue;
            };
            let colour = front.unit.colour(front.degree, &splat.direction, &work.coefficients);
            for pair in walk.pairs(format) {
                let (root, opacity) = (splat.root, splat.opacity);
                let record = Record { mean: pair.local, root, opacity, colour };
                let entry = Entry { splat: record, bitmap: pair.subtiles as u8 };
                lists[(5 * pair.tile[1] + pair.tile[0]) as usize].push((splat.depth, entry));
            }
        }
        let unit = Vru { vrc, split: true, queue: 2 };
        for (tile, list) in (0..).zip(&mut lists) {
            // Stable: ties stay in the order of the scene.
            list.sort_by_key(|(depth, _)| *depth);
            let entries: Vec<Entry> = list.iter().map(|(_, entry)| *entry).collect();
            let first = [16 * (tile % 5), 16 * (tile / 5)];
            let size = [(72 - first[0]).min(16), (51 - first[1]).min(16)];
            for (i, pixel) in (0..).zip(&unit.tile(&entries, size).pixels) {
                // Sub-tiles of 8 x 8, in them cores of 4 x 4, in them pixels.
                let at = |axis: u32| {
                    let bit = |n: u32| n >> axis & 1;
                    8 * bit(i / 64) + 4 * bit(i / 16) + (i >> (2 * axis) & 3)
                };
                let (x, y) = (first[0] + at(0), first[1] + at(1));
                if x >= 72 || y >= 51 {
                    continue;
                }
                let behind = format.to_f32(pixel.transmittance);
                let expected = [0, 1, 2]
                    .map(|c| format.to_f32(pixel.colour[c]) + behind * options.background[c]);
                let drawn = drawn.pixels[(y * 72 + x) as usize];
                assert_eq!(drawn, expected, "seed {seed}, pixel ({x}, {y})");
            }
        }
        let exact = render(&scene, &camera, &options).picture;
        let db = psnr(&drawn, &exact);
        assert!(db > 40.0, "seed {seed}: {db} dB");
    }
}
