//! Traces of the models of a campaign over its power views.

use std::io::{self, Write};

use powergs_base::TOOL_VERSION;
use powergs_core::run::frames::eyes;
use powergs_frame::trace::{EncodedFrame, Frame, TraceHeader, Writer};
use powergs_raster::{Canvas, Detail, Options, render_foveated};
use powergs_scene::{Camera, Foveated, Gaussians, StorageOrder};

use super::Campaign;
use crate::foveated::looking;

impl Campaign {
    /// Writes a trace of `scene` over the power views.
    ///
    /// # Errors
    /// Those of `to`.
    pub fn write_trace(&self, scene: &Gaussians, to: &mut dyn Write) -> io::Result<()> {
        let (mut canvas, options) = (Canvas::new(), self.counting());
        self.write(to, "optimised", scene.len(), |_, camera| {
            Ok(canvas.frame(scene, camera, &options))
        })
    }

    /// Writes a trace of a foveated model over the power views, with the gazes that it was measured
    /// at; of nothing without foveation.
    ///
    /// # Errors
    /// Those of `to`.
    pub fn write_foveated_trace(&self, model: &Foveated, to: &mut dyn Write) -> io::Result<()> {
        let Some(foveation) = &self.foveation else { return Ok(()) };
        let options = self.counting();
        let eyes = eyes(&self.power_views);
        self.write(to, "foveated", model.len(), |i, camera| {
            let gaze = looking(foveation.screens, i / eyes, camera);
            let frame = render_foveated(model, camera, &gaze, &options);
            Ok(frame.map_err(io::Error::other)?.into_frame(camera, self.background))
        })
    }

    fn counting(&self) -> Options {
        Options { background: self.background, ..Options::reference(Detail::Counters) }
    }

    fn write(
        &self,
        to: &mut dyn Write,
        what: &str,
        points: usize,
        mut frame: impl FnMut(usize, &Camera) -> io::Result<Frame>,
    ) -> io::Result<()> {
        let header = TraceHeader {
            generator: format!("powergs-sim {TOOL_VERSION}"),
            scene: format!("{}-{what}", self.name),
            points: points as u64,
            order: StorageOrder::Storage,
        };
        let mut writer = Writer::new(to, &header).map_err(io::Error::other)?;
        for (i, camera) in self.power_views.iter().enumerate() {
            let encoded = EncodedFrame::encode(&frame(i, camera)?).map_err(io::Error::other)?;
            writer.write_encoded(encoded).map_err(io::Error::other)?;
        }
        writer.finish().map(drop).map_err(io::Error::other)
    }
}
