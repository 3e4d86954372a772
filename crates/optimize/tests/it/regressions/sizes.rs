//! Watts of one size next to decibels of another.

use powergs_base::picture::Picture;
use powergs_core::run::{MemoryStore, RunError};
use powergs_optimize::campaign::{Campaign, Finished};
use powergs_optimize::judged::JudgedSize;
use powergs_optimize::photos::Photo;
use powergs_optimize::references::{Reference, ReferenceImages, References};
use powergs_optimize::request::Request;
use powergs_optimize::settings::{GateSize, Settings};
use powergs_optimize::views::PowerCameras;
use powergs_quality::likeness;
use powergs_raster::{Detail, Options, render};
use powergs_scene::camera::edit::resized;
use powergs_scene::{Camera, Gaussians};

use super::super::campaign::{open, request};

/// The short campaign, whose views are of 48x36, shown at another size.
fn shown(size: (u32, u32)) -> Request {
    let asked = request();
    let views = asked.cameras.iter().map(|c| resized(c, size.0, size.1)).collect();
    Request { power_cameras: PowerCameras::Shown(views), ..asked }
}

fn run(campaign: &Campaign) -> Finished {
    campaign.run(&MemoryStore::new(), &()).unwrap().expect("nobody cancels")
}

fn size(camera: &Camera) -> [u32; 2] {
    [camera.width, camera.height]
}

/// Mean PSNR of a model against the dense one, as `views` show them.
fn psnr_db(dense: &Gaussians, model: &Gaussians, views: &[&Camera]) -> f64 {
    let options = Options::reference(Detail::Image);
    let one = |camera: &&Camera| {
        let shown = |scene: &Gaussians| render(scene, camera, &options).picture;
        // As references are kept.
        let mut reference = Picture::default();
        Reference::new(&shown(dense)).write_to(&mut reference);
        likeness(&shown(model), &reference).psnr_db
    };
    views.iter().map(one).sum::<f64>() / views.len() as f64
}

#[test]
fn models_were_judged_at_the_size_of_their_training_and_priced_at_another() {
    let campaign = open(shown((96, 72)));
    let judged = JudgedSize { trained: [48, 36], judged: [96, 72], is_priced: true };
    assert_eq!(campaign.judged, judged);
    assert_eq!(judged.note().as_deref(), Some("trained at 48x36"));
    let of = |views: &[usize]| views.iter().map(|&v| &campaign.cameras[v]).collect::<Vec<_>>();
    let split = &campaign.split;
    assert!(of(&split.train).iter().all(|camera| size(camera) == [48, 36]));
    let (gate, test) = (of(&split.validation), of(&split.test));
    assert!(gate.iter().chain(&test).all(|camera| size(camera) == [96, 72]));
    // The same views as before, by their names.
    let given = &campaign.given;
    let name = |view: &usize| campaign.cameras[*view].name.clone();
    let names = |views: &[usize]| views.iter().map(name).collect::<Vec<String>>();
    assert_eq!(names(&split.test), names(&given.split.test));
    let finished = run(&campaign);
    let result = finished.results.model(finished.result.as_ref().unwrap()).unwrap();
    let model = finished.model.as_ref().unwrap();
    for (said, views) in [(result.gate.psnr_db, &gate), (result.test.psnr_db, &test)] {
        let is = psnr_db(&campaign.dense, model, views);
        assert!((said.unwrap() - is).abs() < 0.01, "{said:?} dB said, {is} dB seen");
    }
    assert_eq!(finished.results.judged, Some(judged));
    assert_eq!(finished.results.priced.as_ref().unwrap().size, [96, 72]);
}

#[test]
fn made_gate_views_were_as_small_as_those_that_train() {
    let campaign = open(Request { least_gate: 6, ..shown((96, 72)) });
    let split = &campaign.split;
    assert!(split.made > 0);
    assert!(split.validation.iter().all(|&view| size(&campaign.cameras[view]) == [96, 72]));
    // As many as at the size of the training: those that show little are told by their share.
    let small = open(Request { least_gate: 6, ..request() });
    assert_eq!(split.made, small.split.made);
}

#[test]
fn the_size_of_the_training_judges_where_that_is_asked_for_and_it_is_told() {
    let asked = shown((96, 72));
    let settings = Settings { gate_size: GateSize::Trained, ..asked.settings };
    let campaign = open(Request { settings, ..asked });
    let judged = JudgedSize { trained: [48, 36], judged: [48, 36], is_priced: false };
    assert_eq!(campaign.judged, judged);
    assert_eq!(judged.note().as_deref(), Some("quality at 48x36"));
    assert_eq!(campaign.cameras.len(), campaign.given.count);
}

#[test]
fn one_size_adds_no_views() {
    let same = open(request());
    assert_eq!((same.cameras.len(), same.judged.note()), (same.given.count, None));
    // Nor do views that are shown as they train, though they are given again.
    let again = open(shown((48, 36)));
    assert_eq!((again.cameras.len(), again.judged.note()), (again.given.count, None));
    assert_eq!(again.inputs(), same.inputs());
}

/// Photos that have more pixels than the views train with, but no more than `most` a side.
struct PhotoShelf {
    images: Vec<Reference>,
    dense: Gaussians,
    most: u32,
}

impl References for PhotoShelf {
    fn write_to(&self, view: usize, picture: &mut Picture) {
        self.images.write_to(view, picture);
    }

    fn digest(&self) -> u128 {
        self.images.digest()
    }

    fn push_at(&mut self, _: usize, camera: &Camera) -> Result<Option<Camera>, RunError> {
        let width = camera.width.min(self.most);
        let camera = resized(camera, width, width * camera.height / camera.width);
        let options = Options::reference(Detail::Image);
        self.images.push(Reference::new(&render(&self.dense, &camera, &options).picture));
        Ok(Some(camera))
    }
}

#[test]
fn photos_judge_in_the_size_that_is_shown_or_in_their_own() {
    let with_photos = |most: u32| {
        let asked = shown((96, 72));
        let options = Options::reference(Detail::Image);
        let photo = |c: &Camera| Reference::new(&render(&asked.dense, c, &options).picture);
        let images: Vec<Reference> = asked.cameras.iter().map(photo).collect();
        let shelf = PhotoShelf { images, dense: asked.dense.clone(), most };
        open(Request { references: ReferenceImages::Photos(Box::new(shelf)), ..asked })
    };
    let whole = with_photos(96);
    assert_eq!((whole.judged.judged, whole.judged.is_priced), ([96, 72], true));
    let small = with_photos(64);
    assert_eq!((small.judged.judged, small.judged.is_priced), ([64, 48], false));
    assert_eq!(small.judged.note().as_deref(), Some("quality at 64x48"));
    assert_eq!(whole.sources(), small.sources(), "what they train on is the same");
    assert_ne!(whole.inputs(), small.inputs());
    // References that have no other size judge in that which they have.
    let asked = shown((96, 72));
    let options = Options::reference(Detail::Image);
    let photo = |c: &Camera| Reference::new(&render(&asked.dense, c, &options).picture);
    let images: Vec<Reference> = asked.cameras.iter().map(photo).collect();
    let alone = open(Request { references: ReferenceImages::Photos(Box::new(images)), ..asked });
    assert_eq!((alone.judged.judged, alone.judged.is_priced), ([48, 36], false));
}

#[test]
fn a_photo_is_shown_at_the_height_of_the_screen_and_never_larger_than_it_is() {
    let camera = resized(&request().cameras[0], 400, 300);
    let photo = Photo::new((400, 300), &camera, None, Some((100, 75))).unwrap();
    let at =
        |width: u32, height: u32| size(&photo.in_size_of(&resized(&camera, width, height)).view);
    assert_eq!(at(200, 150), [200, 150]);
    assert_eq!(at(100, 150), [200, 150], "another aspect");
    assert_eq!(at(800, 600), [400, 300]);
    assert_eq!(at(900, 240), [320, 240]);
}

#[test]
fn priced_anew_at_another_size_models_kept_the_quality_of_before() {
    let store = MemoryStore::new();
    let small = open(request());
    let first = small.run(&store, &()).unwrap().unwrap();
    let mut large = open(shown((192, 144)));
    assert_eq!(small.sources(), large.sources());
    assert_ne!(small.inputs(), large.inputs());
    let to = MemoryStore::new();
    let again = large.reprice(&store, &to, false, &()).unwrap().unwrap().priced().unwrap();
    assert_eq!(again.outcomes.len(), first.outcomes.len());
    assert_eq!(again.results.judged.unwrap().judged, [192, 144]);
    for (now, then) in again.outcomes.iter().zip(&first.outcomes).skip(1) {
        assert_ne!(now.gate.quality, then.gate.quality, "{}", then.name);
        assert_ne!(now.test.quality, then.test.quality, "{}", then.name);
        assert_eq!(now.passed, now.gate.quality.psnr_db >= 20.0, "{}", then.name);
    }
    let campaign = open(shown((192, 144)));
    let gate: Vec<&Camera> =
        campaign.split.validation.iter().map(|&view| &campaign.cameras[view]).collect();
    if let (Some(name), Some(model)) = (&again.result, &again.model) {
        let said = again.results.model(name).unwrap().gate.psnr_db.unwrap();
        let is = psnr_db(&campaign.dense, model, &gate);
        assert!((said - is).abs() < 0.01, "{said} dB said, {is} dB seen");
    }
}
