//! A hash of everything that the numbers of a campaign depend on.

use serde::Serialize;
use xxhash_rust::xxh3::Xxh3;

use powergs_base::TOOL_VERSION;
use powergs_core::run::identity::content_id;
use powergs_core::sim::MODEL_VERSION;
use powergs_frame::fovea::ScreenWidth;
use powergs_scene::{Camera, Gaussians};

use super::Campaign;
use crate::adam::Group;
use crate::request::Foveation;
use crate::settings::Settings;

/// Values by their bytes: what they are called does not matter.
struct Hash(Xxh3);

impl Hash {
    fn add(&mut self, value: &impl Serialize) {
        let bytes = postcard::to_stdvec(value).expect("numbers, text and lists");
        // Lengths keep values apart that have the same bytes in a row.
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(&bytes);
    }

    fn add_scene(&mut self, scene: &Gaussians) {
        self.add(&(scene.sh_degree, scene.len()));
        if scene.antialiased {
            self.add(&"antialiased");
        }
        for group in Group::ALL {
            self.0.update(bytemuck::cast_slice(group.of(scene)));
        }
    }

    fn add_cameras(&mut self, cameras: &[Camera]) {
        self.add(&cameras.len());
        for camera in cameras {
            // What a file says about the split is in that of the campaign.
            let Camera {
                name,
                width,
                height,
                fx,
                fy,
                cx,
                cy,
                world_to_camera,
                centre,
                split: _,
                eye,
            } = camera;
            self.add(&(name, width, height, fx, fy, cx, cy, world_to_camera, centre));
            if let Some(eye) = eye {
                self.add(&eye.name());
            }
        }
    }
}

impl Campaign {
    /// A hash of everything that numbers depend on: runs that agree in it have the same jobs,
    /// outcomes and models, and one goes on where the other stopped.
    pub fn fingerprint(&self) -> u128 {
        let mut hash = Hash(Xxh3::new());
        hash.add(&self.inputs());
        hash.add(&(&self.plan, self.oracle.id()));
        hash.add_cameras(&self.power_views);
        let display = &self.display;
        hash.add(&(&display.name, content_id(display).expect("numbers and text")));
        if let Some(Foveation { clock, filter, .. }) = &self.foveation {
            hash.add(&crate::oracle::PowerOracle::id(clock));
            hash.add(&(filter.flops, filter.flop_pj, filter.flops_per_cycle));
        }
        hash.0.digest128()
    }

    /// A hash of everything that the models of a run and their quality depend on, but for what
    /// power is and what they are compared with.
    pub fn inputs(&self) -> u128 {
        let mut hash = Hash(Xxh3::new());
        hash.add(&self.sources());
        hash.add(&self.split);
        hash.add_cameras(&self.cameras);
        hash.add(&self.references.images().digest());
        hash.0.digest128()
    }

    /// The same but for the size in which quality is measured, which is that of the power: where
    /// it agrees, models can be priced anew.
    pub fn sources(&self) -> u128 {
        let Campaign {
            name,
            dense,
            externals,
            cameras,
            references: _,
            background,
            split: _,
            given,
            judged: _,
            power_views: _,
            priced: _,
            renderer,
            oracle: _,
            display: _,
            counted: _,
            settings,
            plan,
            ratio_study: _,
            foveation,
            lpips,
            keep_all: _,
        } = self;
        let mut hash = Hash(Xxh3::new());
        hash.add(&(TOOL_VERSION, MODEL_VERSION, name, renderer.id()));
        // When checkpoints are written changes no number.
        hash.add(&Settings { checkpoint_every: 0, ..settings.clone() });
        hash.add(&(&plan.variants, plan.holds_out, plan.levels));
        hash.add(&(background, &given.split, given.photos));
        if let Some(Foveation { screens, .. }) = foveation {
            // The fields of view of cameras are in those.
            let fov_deg = match screens.width {
                ScreenWidth::OfCamera => None,
                ScreenWidth::Degrees(degrees) => Some(degrees),
            };
            hash.add(&(fov_deg, screens.pooling_rate));
        }
        hash.add(&lpips.as_ref().map(|(_, file)| file));
        hash.add_cameras(&cameras[..given.count]);
        hash.add_scene(dense);
        externals.iter().for_each(|(_, scene)| hash.add_scene(scene));
        hash.0.digest128()
    }
}
