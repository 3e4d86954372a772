//! What a frame of a machine is: a picture for a display, or a step of training or tracking.

use std::fmt;

use super::over::pixels::{PixelSource, PixelsSpec};
use super::steps::Updated;

/// What a frame of a machine is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Task {
    /// What is made.
    pub kind: TaskKind,
    /// One pixel in this number is rendered.
    pub one_in: u32,
}

/// What is made of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TaskKind {
    /// A picture, which a display shows.
    Render,
    /// A step of training: a picture, its loss, gradients, and the update of some Gaussians.
    Train(Updated),
    /// A step of tracking: a picture, its loss, and gradients by the pose of the camera.
    Track,
}

impl Task {
    /// A picture for a display.
    pub const RENDER: Task = Task { kind: TaskKind::Render, one_in: 1 };

    /// That of a machine that trains as `update` says, or does not, and renders the pixels of
    /// `pixels`.
    pub fn new(update: Option<Updated>, pixels: &PixelsSpec) -> Task {
        let kind = match update {
            None => TaskKind::Render,
            Some(Updated::Pose) => TaskKind::Track,
            Some(update) => TaskKind::Train(update),
        };
        let is_sampled = pixels.source == PixelSource::Sampled;
        let one_in = if is_sampled { pixels.stride.saturating_mul(pixels.stride) } else { 1 };
        Task { kind, one_in }
    }

    /// Whether a display shows what is made. Nobody waits for a step by a display period.
    pub const fn is_shown(self) -> bool {
        matches!(self.kind, TaskKind::Render)
    }

    /// Whether it changes Gaussians by whole pictures, as the training of a model does.
    pub const fn updates_models(self) -> bool {
        matches!(self.kind, TaskKind::Train(Updated::All | Updated::Visible)) && self.one_in == 1
    }

    /// What one of them is called.
    pub const fn noun(self) -> &'static str {
        if self.is_shown() { "frame" } else { "step" }
    }

    /// The unit of how many there are in a second.
    pub const fn per_second(self) -> &'static str {
        if self.is_shown() { "FPS" } else { "steps/s" }
    }

    /// How it is written in records and tables: `render`, `train all`, `track, 1 pixel in 256`.
    pub fn name(self) -> String {
        let kind = match self.kind {
            TaskKind::Render => "render",
            TaskKind::Train(Updated::All) => "train all",
            TaskKind::Train(Updated::Visible) => "train visible",
            TaskKind::Train(Updated::None | Updated::Pose) => "gradients",
            TaskKind::Track => "track",
        };
        match self.one_in {
            1 => kind.to_owned(),
            n => format!("{kind}, 1 pixel in {n}"),
        }
    }

    /// The same for narrow columns: `train`, `track 1/256`.
    pub fn short(self) -> String {
        let kind = match self.kind {
            TaskKind::Render => "render",
            TaskKind::Train(_) => "train",
            TaskKind::Track => "track",
        };
        match self.one_in {
            1 => kind.to_owned(),
            n => format!("{kind} 1/{n}"),
        }
    }

    /// The task of a name, as [`Task::name`] writes it.
    pub fn named(name: &str) -> Option<Task> {
        let (kind, one_in) = match name.split_once(", 1 pixel in ") {
            Some((kind, n)) => (kind, n.parse().ok()?),
            None => (name, 1),
        };
        let all = [
            TaskKind::Render,
            TaskKind::Train(Updated::All),
            TaskKind::Train(Updated::Visible),
            TaskKind::Train(Updated::None),
            TaskKind::Track,
        ];
        let mut all = all.into_iter().map(|kind| Task { kind, one_in: 1 });
        let found = all.find(|task| task.name() == kind)?;
        Some(Task { one_in, ..found })
    }
}

impl fmt::Display for Task {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name())
    }
}
