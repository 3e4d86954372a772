//! A hash of everything that the numbers of a campaign depend on.

use serde::Serialize;
use xxhash_rust::xxh3::Xxh3;

use powergs_base::TOOL_VERSION;
use powergs_core::run::identity::content_id;
use powergs_core::sim::MODEL_VERSION;
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
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(&bytes);
    }

    fn add_scene(&mut self, scene: &Gaussians) {
        self.add(&(scene.sh_degree, scene.len()));
        for group in Group::ALL {
            self.0.update(bytemuck::cast_slice(group.of(scene)));
        }
    }

    fn add_cameras(&mut self, cameras: &[Camera]) {
        self.add(&cameras.len());
        for camera in cameras {
            // What a file says about the split is in that of the campaign.
            let Camera { name, width, height, fx, fy, cx, cy, world_to_camera, centre, split: _ } =
                camera;
            self.add(&(name, width, height, fx, fy, cx, cy, world_to_camera, centre));
        }
    }
}

impl Campaign {
    /// A hash of everything that numbers depend on: runs that agree in it have the same jobs,
    /// outcomes and models, and one goes on where the other stopped.
    pub fn fingerprint(&self) -> u128 {
        let Campaign {
            name,
            dense,
            externals,
            cameras,
            references,
            background,
            split,
            power_views,
            oracle,
            display,
            settings,
            plan,
            ratio_study: _,
            foveation,
            lpips,
        } = self;
        let mut hash = Hash(Xxh3::new());
        hash.add(&(TOOL_VERSION, MODEL_VERSION, name));
        // When checkpoints are written changes no number.
        hash.add(&Settings { checkpoint_every: 0, ..settings.clone() });
        hash.add(&(plan, background, split, oracle.id(), references.is_own()));
        hash.add(&(&display.name, content_id(display).expect("numbers and text")));
        if let Some(Foveation { screen, clock, filter }) = foveation {
            let id = crate::oracle::PowerOracle::id(clock);
            hash.add(&(screen.fov_deg, screen.pooling_rate, id));
            hash.add(&(filter.flops, filter.flop_pj, filter.flops_per_cycle));
        }
        hash.add(&lpips.as_ref().map(|(_, file)| file));
        hash.add_cameras(cameras);
        hash.add_cameras(power_views);
        hash.add_scene(dense);
        externals.iter().for_each(|(_, scene)| hash.add_scene(scene));
        hash.add(&references.images().digest());
        hash.0.digest128()
    }
}
