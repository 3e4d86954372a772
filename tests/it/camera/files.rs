//! Opening camera files: folders, sizes of images beside the file, what is missing.

use std::fs;

use powergs_sim::scene::files::open_cameras;
use powergs_testkit::camera_files::binary_files;

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
fn blender_sizes_come_from_the_first_image() {
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
