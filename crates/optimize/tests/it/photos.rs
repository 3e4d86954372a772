//! Photos as references: other sizes, lenses.

use powergs_base::picture::Picture;
use powergs_optimize::photos::{Photo, PhotoError};
use powergs_optimize::references::Reference;
use powergs_quality::likeness;
use powergs_scene::Camera;
use powergs_scene::camera::lens::Lens;

fn camera(width: u32, height: u32) -> Camera {
    Camera {
        name: "view".into(),
        width,
        height,
        fx: 0.85 * f64::from(width),
        fy: 1.1 * f64::from(height),
        cx: 0.48 * f64::from(width),
        cy: 0.5 * f64::from(height),
        world_to_camera: glam::DMat3::IDENTITY,
        centre: glam::DVec3::ZERO,
        split: None,
        eye: None,
    }
}

/// What is seen along a ray: smooth, without any symmetry.
fn light([x, y]: [f64; 2]) -> [f32; 3] {
    let wave = |a: f64, b: f64| (0.5 + 0.4 * (a * x + b * y + 0.3 * a).sin()) as f32;
    [wave(9.0, 4.0), wave(-5.0, 11.0), wave(14.0, -7.0)]
}

/// A picture of it: a mean over the area of each pixel.
fn picture(camera: &Camera, lens: Option<&Lens>) -> Picture {
    let pixel = |x: u32, y: u32| {
        let mut sum = [0.0; 3];
        for i in 0..16 {
            let at = |c: u32, k: u32| f64::from(c) + (f64::from(k) + 0.5) / 4.0;
            let (px, py) = (at(x, i % 4), at(y, i / 4));
            let shown = [(px - camera.cx) / camera.fx, (py - camera.cy) / camera.fy];
            let ray = lens.map_or(shown, |lens| straight(lens, shown));
            for (s, v) in sum.iter_mut().zip(light(ray)) {
                *s += v / 16.0;
            }
        }
        sum
    };
    let (width, height) = (camera.width, camera.height);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| pixel(x, y))).collect();
    Picture { width, height, pixels }
}

/// The ray that a lens shows at a place, by iteration.
fn straight(lens: &Lens, shown: [f64; 2]) -> [f64; 2] {
    let mut ray = shown;
    for _ in 0..20 {
        let bent = lens.bent(ray);
        ray = [ray[0] + shown[0] - bent[0], ray[1] + shown[1] - bent[1]];
    }
    ray
}

fn psnr(reference: &Reference, expected: &Picture) -> f64 {
    let mut picture = Picture::default();
    reference.write_to(&mut picture);
    likeness(&picture, expected).psnr_db
}

#[test]
fn photos_are_freed_of_their_lenses() {
    let camera = camera(160, 120);
    let lenses = [
        Lens::Rational { radial: [-0.15, 0.04, 0.0, 0.0, 0.0, 0.0], tangential: [0.003, -0.002] },
        Lens::Rational { radial: [0.12, 0.0, 0.0, 0.0, 0.0, 0.0], tangential: [0.0; 2] },
        Lens::Fisheye([-0.05, 0.01, 0.0, 0.0]),
        Lens::FieldOfView(0.8),
        Lens::ThinPrism {
            radial: [-0.05, 0.0, 0.0, 0.0],
            tangential: [0.001, 0.001],
            prism: [0.001, -0.001],
        },
    ];
    for lens in lenses {
        let taken = picture(&camera, Some(&lens));
        let photo = Photo::new((160, 120), &camera, Some(&lens), None).unwrap();
        let expected = picture(&photo.view, None);
        let freed = psnr(&photo.reference(&taken), &expected);
        assert!(freed > 55.0, "{lens:?}: {freed:.1} dB");
        // Without that it would cost what nobody would look for here.
        let ignored = Photo::new((160, 120), &camera, None, None).unwrap();
        let bent = psnr(&ignored.reference(&taken), &picture(&ignored.view, None));
        assert!(bent < 35.0, "{lens:?}: {bent:.1} dB");
    }
}

#[test]
fn photos_of_other_sizes_make_the_same_view() {
    let camera = camera(120, 90);
    let of = |size: (u32, u32), wanted, lens: Option<&Lens>| {
        let photo = Photo::new(size, &camera, lens, wanted).unwrap();
        let taken = powergs_scene::camera::edit::stretched(&camera, size.0, size.1);
        let got = psnr(&photo.reference(&picture(&taken, lens)), &picture(&photo.view, None));
        (photo.view, got)
    };
    let lens = Lens::Rational { radial: [0.1, 0.0, 0.0, 0.0, 0.0, 0.0], tangential: [0.0; 2] };
    for lens in [None, Some(&lens)] {
        let (whole, db) = of((120, 90), None, lens);
        assert!(db > if lens.is_some() { 55.0 } else { 90.0 }, "{db:.1} dB");
        // Larger photos are averaged down to their cameras.
        let (view, db) = of((360, 270), None, lens);
        assert_eq!((view.width, view.height), (whole.width, whole.height));
        assert!(db > 50.0, "{db:.1} dB");
        // Smaller ones are taken as they are, whatever was rounded.
        let (view, db) = of((41, 31), None, lens);
        assert!(view.width <= 41 && view.width > 30 && db > 40.0, "{view:?} {db:.1} dB");
        let (view, db) = of((360, 270), Some((60, 45)), lens);
        assert_eq!((view.width, view.height), (60, 45));
        assert!(db > 45.0, "{db:.1} dB");
    }
}

#[test]
fn what_is_no_photo_of_a_camera_is_refused() {
    let camera = camera(200, 150);
    let new = |size, lens: Option<&Lens>, wanted| Photo::new(size, &camera, lens, wanted);
    let aspect = new((200, 140), None, None).unwrap_err();
    assert!(matches!(aspect, PhotoError::Aspect { is_turned: false, .. }), "{aspect}");
    let turned = new((150, 200), None, None).unwrap_err();
    assert!(turned.to_string().contains("turned?"), "{turned}");
    let larger = new((200, 150), None, Some((400, 300))).unwrap_err();
    assert!(larger.to_string().contains("at most 200x150"), "{larger}");
    let other = new((200, 150), None, Some((100, 60))).unwrap_err();
    assert!(other.to_string().contains("for this height 80x60"), "{other}");
    let lens = Lens::Rational { radial: [f64::NAN; 6], tangential: [0.0; 2] };
    let broken = new((200, 150), Some(&lens), None).unwrap_err();
    assert_eq!(broken, PhotoError::Lens);
    assert!(broken.to_string().contains("20 %"), "{broken}");
}
