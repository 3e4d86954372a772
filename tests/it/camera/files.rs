//! Opening camera files: folders, sizes of images beside the file, what is missing.

use std::fs;

use powergs_sim::scene::Split;
use powergs_sim::scene::camera::inria;
use powergs_sim::scene::files::open_cameras;
use powergs_testkit::camera_files::{binary_files, poses};

#[test]
fn colmap_folder_is_found_under_sparse() {
    let folder = tempfile::tempdir().unwrap();
    let failure = open_cameras(folder.path(), None, None).unwrap_err();
    assert!(failure.to_string().contains("no cameras.bin"), "{failure}");
    let model = folder.path().join("sparse/0");
    fs::create_dir_all(&model).unwrap();
    let (cameras, images) = binary_files();
    fs::write(model.join("cameras.bin"), cameras).unwrap();
    let failure = open_cameras(folder.path(), None, None).unwrap_err();
    assert!(failure.to_string().contains("images.bin"), "{failure}");
    fs::write(model.join("images.bin"), images).unwrap();
    assert_eq!(open_cameras(folder.path(), None, None).unwrap().format, "COLMAP binary");
    assert_eq!(open_cameras(&model, None, None).unwrap().cameras.len(), 2);
}

#[test]
fn blender_sizes_come_from_the_images() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("transforms.json");
    let text = r#"{"camera_angle_x": 0.7, "frames": [{"file_path": "./r_0",
        "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}"#;
    fs::write(&file, text).unwrap();
    let failure = open_cameras(&file, None, None).unwrap_err();
    assert!(failure.to_string().contains("size is missing"), "{failure}");
    let image = powergs_pixels::RgbImage::from_fn(12, 8, |_, _| [0; 3]);
    std::fs::write(folder.path().join("r_0.png"), image.png().unwrap()).unwrap();
    let camera = &open_cameras(&file, None, None).unwrap().cameras[0];
    assert_eq!((camera.width, camera.height), (12, 8));
    assert_eq!(open_cameras(&file, Some((40, 30)), None).unwrap().cameras[0].width, 40);
}

#[test]
fn files_that_are_no_text_say_where() {
    let file = tempfile::NamedTempFile::new().unwrap();
    fs::write(file.path(), b"[\n\xff").unwrap();
    let failure = open_cameras(file.path(), None, None).unwrap_err();
    assert!(failure.to_string().contains("byte 2: not UTF-8"), "{failure}");
    let failure = open_cameras("/nowhere/cameras.json".as_ref(), None, None).unwrap_err();
    assert!(failure.to_string().contains("/nowhere/cameras.json"), "{failure}");
}

/// A `transforms.json` of one view, looking along z from `x`.
fn transforms(path: &str, x: f64, extra: &str) -> String {
    format!(
        r#"{{"fl_x": 60, {extra} "frames": [{{"file_path": "{path}",
        "transform_matrix": [[1,0,0,{x}],[0,-1,0,0],[0,0,-1,0],[0,0,0,1]]}}]}}"#
    )
}

const SIZE: &str = r#""w": 64, "h": 48,"#;

#[test]
fn folders_of_trainers_have_their_cameras() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let open = || open_cameras(folder.path(), None, None).unwrap();
    // Blender's scenes, whose pictures are numbered anew in every part.
    write("transforms_train.json", &transforms("./train/r_0", 1.0, SIZE));
    assert_eq!(open().cameras.len(), 1);
    write("transforms_test.json", &transforms("./test/r_0", 2.0, SIZE));
    fs::create_dir(folder.path().join("test")).unwrap();
    write("test/r_0.png", "");
    let cameras = open().cameras;
    let names: Vec<_> = cameras.iter().map(|c| (c.name.as_str(), c.split, c.centre.x)).collect();
    let want = [("train/r_0", Some(Split::Train), 1.0), ("test/r_0.png", Some(Split::Test), 2.0)];
    assert_eq!(names, want);
    // One list for all, as nerfstudio has it.
    write("transforms.json", &transforms("images/a.png", 3.0, SIZE));
    assert_eq!((open().format, open().cameras[0].centre.x), ("NeRF transforms.json", 3.0));
    // That of a run of INRIA's trainer, and of the data itself.
    write("cameras.json", &inria::write(&poses(3)));
    assert_eq!((open().format, open().cameras.len()), ("INRIA cameras.json", 3));
    let (cameras, images) = binary_files();
    fs::write(folder.path().join("cameras.bin"), cameras).unwrap();
    fs::write(folder.path().join("images.bin"), images).unwrap();
    assert_eq!(open().format, "COLMAP binary");
}

#[test]
fn every_view_has_the_size_of_its_image() {
    let folder = tempfile::tempdir().unwrap();
    for (name, (width, height)) in [("a.png", (12, 8)), ("b.png", (8, 12))] {
        let image = powergs_pixels::RgbImage::from_fn(width, height, |_, _| [0; 3]);
        fs::write(folder.path().join(name), image.png().unwrap()).unwrap();
    }
    let frame = |name: &str| {
        format!(r#"{{"file_path": "{name}", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0]]}}"#)
    };
    let file = folder.path().join("transforms.json");
    let text = format!(r#"{{"fl_x": 20, "frames": [{}, {}]}}"#, frame("a.png"), frame("b"));
    fs::write(&file, text).unwrap();
    let cameras = open_cameras(&file, None, None).unwrap().cameras;
    let sizes: Vec<_> = cameras.iter().map(|c| (c.width, c.height)).collect();
    assert_eq!(sizes, [(12, 8), (8, 12)]);
}

#[test]
fn cameras_are_put_where_nerfstudio_put_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let (data, model) = (folder.path().join("data"), folder.path().join("export/splat.ply"));
    fs::create_dir_all(&data).unwrap();
    fs::create_dir_all(model.parent().unwrap()).unwrap();
    fs::write(data.join("transforms.json"), transforms("a.png", 4.0, SIZE)).unwrap();
    let open = |file: &str| open_cameras(&data.join(file), None, Some(&model)).unwrap();
    assert_eq!(open("transforms.json").cameras[0].centre.x, 4.0);
    let text = r#"{"transform": [[1,0,0,-1],[0,1,0,0],[0,0,1,0]], "scale": 0.5}"#;
    let placement = model.with_file_name("dataparser_transforms.json");
    fs::write(&placement, text).unwrap();
    let moved = open("transforms.json");
    assert_eq!(moved.cameras[0].centre.x, 1.5);
    assert!(moved.warnings[0].contains("dataparser_transforms.json"), "{:?}", moved.warnings);
    // Of a camera file alone, where it is beside that.
    let file = data.join("transforms.json");
    assert_eq!(open_cameras(&file, None, None).unwrap().cameras[0].centre.x, 4.0);
    fs::copy(&placement, data.join("dataparser_transforms.json")).unwrap();
    assert_eq!(open_cameras(&file, None, None).unwrap().cameras[0].centre.x, 1.5);
    // What was converted by this program, or made in the viewer, is in its frame already.
    fs::write(data.join("cameras.json"), inria::write(&moved.cameras)).unwrap();
    assert_eq!(open("cameras.json").cameras[0].centre.x, 1.5);
    fs::write(&placement, "{}").unwrap();
    let failure = open_cameras(&file, None, Some(&model)).unwrap_err().to_string();
    assert!(failure.contains("dataparser_transforms.json, key `transform`"), "{failure}");
}
