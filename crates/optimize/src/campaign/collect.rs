//! The views of a campaign with what they should look like, while it is opened.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use powergs_base::picture::Picture;
use powergs_core::run::RunError;
use powergs_scene::{Camera, Gaussians};

use crate::between::between;
use crate::judged::{JudgedSize, MOST_JUDGED, has_size_of};
use crate::references::{Reference, ReferenceImages};
use crate::renderer::Renderer;
use crate::settings::Gate;
use crate::views::{ViewSplit, area, largest, pixels};
use crate::watch::CampaignWatch;

/// Views and references so far.
pub(super) struct Collected<'a> {
    /// What renders.
    pub renderer: &'a dyn Renderer,
    /// The dense model.
    pub dense: &'a Gaussians,
    /// Behind everything, sRGB.
    pub background: [f32; 3],
    /// Who is told.
    pub watch: &'a dyn CampaignWatch,
    /// All views so far, first those of the request.
    pub cameras: Vec<Camera>,
    /// What they should look like.
    pub references: ReferenceImages,
    /// In how many pixels each view of the request shows anything, once they were looked at.
    pub seen: Vec<usize>,
}

impl Collected<'_> {
    /// Looks at the dense model from every camera of the request. Where references are its own
    /// renders, this is where they are made.
    pub fn look(&mut self) -> Result<(), RunError> {
        if self.references.is_own() {
            self.watch.rendering(self.cameras.len() as u64);
        }
        for camera in &self.cameras {
            let picture = self.renderer.look(self.dense, camera, self.background);
            if let ReferenceImages::OwnRenders(sink) = &mut self.references {
                sink.push(Reference::new(&picture))?;
                self.watch.rendered();
            }
            self.seen.push(shown(&picture, self.background));
        }
        Ok(())
    }

    /// Lets the views that gate and test do so as `judged` has them, which are all views of the
    /// request in the size of their power. They stand behind the others, which train.
    pub fn judge(
        &mut self,
        split: &mut ViewSplit,
        gate: Gate,
        judged: &[Camera],
    ) -> Result<JudgedSize, RunError> {
        let all = largest(&self.cameras);
        if pixels(judged) > pixels(&self.cameras) {
            let (gate, test) = (split.validation.len(), split.test.len());
            split.sample(MOST_JUDGED);
            let (looks, reports) = (split.validation.len(), split.test.len());
            if (looks, reports) != (gate, test) {
                self.watch.note(&format!(
                    "{looks} of {gate} views gate and {reports} of {test} test, evenly spaced: \
                     looks at views that are larger than those that train take long"
                ));
            }
        }
        let gates = match gate {
            Gate::Validation => &split.validation[..],
            // Views of a validation that does not gate train.
            Gate::Test => &[],
        };
        let views: BTreeSet<usize> = gates.iter().chain(&split.test).copied().collect();
        if self.references.is_own() {
            self.watch.rendering(views.len() as u64);
        }
        let (mut places, mut is_priced) = (BTreeMap::new(), true);
        for view in views {
            let wanted = &judged[view];
            if has_size_of(wanted, &self.cameras[view]) {
                continue;
            }
            let added = match &mut self.references {
                ReferenceImages::OwnRenders(sink) => {
                    let picture = self.renderer.look(self.dense, wanted, self.background);
                    sink.push(Reference::new(&picture))?;
                    self.watch.rendered();
                    Some(wanted.clone())
                }
                ReferenceImages::Photos(images) => images.push_at(view, wanted)?,
            };
            // Photos may have fewer pixels than the screen.
            is_priced &= added.as_ref().is_some_and(|camera| has_size_of(camera, wanted));
            if let Some(camera) = added {
                places.insert(view, self.cameras.len());
                self.cameras.push(camera);
            }
        }
        split.judge_by(&places);
        let added = &self.cameras[self.seen.len()..];
        let judged = if added.is_empty() { all } else { largest(added) };
        Ok(JudgedSize { trained: all, judged, is_priced })
    }

    /// Where references are the dense model's own renders: `missing` views between those of
    /// `from`, which are those of the request in some size, with their references; their places. A
    /// view that shows less than half of what its neighbours do is somewhere else, and left out:
    /// inside of things, or beside them.
    pub fn make(
        &mut self,
        from: Option<&[Camera]>,
        missing: usize,
    ) -> Result<Range<usize>, RunError> {
        let first = self.cameras.len();
        let given = self.seen.len();
        let made = match self.references.is_own() {
            true => between(from.unwrap_or(&self.cameras[..given]), missing),
            false => Vec::new(),
        };
        for (camera, [a, b]) in made {
            let ReferenceImages::OwnRenders(sink) = &mut self.references else { continue };
            let picture = self.renderer.look(self.dense, &camera, self.background);
            // As shares of the pixels, because the views of the request may have fewer.
            let least = self.seen[a].min(self.seen[b]).max(1) as u64 * area(&camera);
            if 2 * shown(&picture, self.background) as u64 * area(&self.cameras[a]) >= least {
                sink.push(Reference::new(&picture))?;
                self.cameras.push(camera);
            }
        }
        Ok(first..self.cameras.len())
    }
}

/// Pixels that show something.
fn shown(picture: &Picture, background: [f32; 3]) -> usize {
    picture.pixels.iter().filter(|pixel| **pixel != background).count()
}
