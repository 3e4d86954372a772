//! A pinhole camera.

use glam::{DMat3, DVec3};

/// Which part of a data set a view belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Split {
    /// Seen in training.
    Train,
    /// Held out.
    Test,
}

impl Split {
    /// The name in camera files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Split::Train => "train",
            Split::Test => "test",
        }
    }

    /// The split that a camera file names; validation sets (`val`, `eval`) are held out too.
    pub fn from_name(name: &str) -> Option<Split> {
        match name.to_ascii_lowercase().as_str() {
            "train" | "training" => Some(Split::Train),
            "test" | "val" | "validation" | "eval" => Some(Split::Test),
            _ => None,
        }
    }
}

/// Which eye of a viewer a view is for. The two views of a pair follow each other, left first; a
/// display shows both in one period.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Eye {
    /// The left eye.
    Left,
    /// The right eye.
    Right,
}

impl Eye {
    /// Both, in the order of a pair.
    pub const ALL: [Eye; 2] = [Eye::Left, Eye::Right];

    /// The name in camera files, and at the end of the names of views: `NAME_left`.
    pub const fn name(self) -> &'static str {
        match self {
            Eye::Left => "left",
            Eye::Right => "right",
        }
    }

    /// The eye that a camera file names.
    pub fn from_name(name: &str) -> Option<Eye> {
        Eye::ALL.into_iter().find(|eye| eye.name().eq_ignore_ascii_case(name))
    }

    /// The name of a view without that of this eye: `NAME` of `NAME_left`.
    pub fn strip(self, view: &str) -> Option<&str> {
        view.strip_suffix(self.name())?.strip_suffix('_')
    }
}

/// A pinhole camera in OpenCV axes (x right, y down, z forward). Checked: sizes and focal lengths
/// are positive and finite, the rotation is orthonormal.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Name of the view, usually its photo.
    pub name: String,
    /// Image width, pixels.
    pub width: u32,
    /// Image height, pixels.
    pub height: u32,
    /// Focal length in x, pixels.
    pub fx: f64,
    /// Focal length in y, pixels.
    pub fy: f64,
    /// Principal point in x, pixels from the left *edge* (a centred one is `width / 2`).
    pub cx: f64,
    /// Principal point in y, pixels from the top *edge*.
    pub cy: f64,
    /// Rotation from world to camera.
    pub world_to_camera: DMat3,
    /// Camera centre, world units.
    pub centre: DVec3,
    /// The part of the data set, where the file says so.
    pub split: Option<Split>,
    /// The eye that it is for; `None` for a view that is no half of a pair.
    pub eye: Option<Eye>,
}

impl Camera {
    /// Unit vector to the right of the image, world axes.
    pub fn right(&self) -> DVec3 {
        self.world_to_camera.row(0)
    }

    /// Unit vector along the optical axis, world axes.
    pub fn forward(&self) -> DVec3 {
        self.world_to_camera.row(2)
    }

    /// Angle between the left and the right edge of a centred image of this size, radians.
    pub fn horizontal_fov(&self) -> f64 {
        2.0 * (0.5 * f64::from(self.width) / self.fx).atan()
    }

    /// Angle between the top and the bottom edge of a centred image of this size, radians.
    pub fn vertical_fov(&self) -> f64 {
        2.0 * (0.5 * f64::from(self.height) / self.fy).atan()
    }

    /// A camera at `centre` that looks at `target`, with a centred principal point and square
    /// pixels. `up` points to the top of the image; where it is parallel to the viewing direction,
    /// another axis is taken. `vertical_fov` is in radians, the size in pixels.
    pub fn looking_at(
        centre: DVec3,
        target: DVec3,
        up: DVec3,
        vertical_fov: f64,
        (width, height): (u32, u32),
    ) -> Camera {
        let forward = (target - centre).normalize_or(DVec3::Z);
        let up =
            if forward.cross(up).length() > 1e-6 { up } else { forward.any_orthogonal_vector() };
        let right = forward.cross(up).normalize();
        let down = forward.cross(right);
        let focal = 0.5 * f64::from(height) / (0.5 * vertical_fov).tan();
        Camera {
            name: String::new(),
            width,
            height,
            fx: focal,
            fy: focal,
            cx: 0.5 * f64::from(width),
            cy: 0.5 * f64::from(height),
            world_to_camera: DMat3::from_cols(right, down, forward).transpose(),
            centre,
            split: None,
            eye: None,
        }
    }
}

/// Whether views are pairs: left and right eyes in turn, both of one size.
pub fn are_pairs<'a>(views: impl IntoIterator<Item = &'a Camera>) -> bool {
    let mut open = PairOrder::default();
    let mut any = false;
    let in_order = views.into_iter().all(|view| {
        any |= view.eye.is_some();
        open.next(view).is_ok()
    });
    any && in_order && open.end().is_ok()
}

/// The order that views of pairs keep: all of a list or none have an eye, and every left one is
/// followed by a right one of the same size.
#[derive(Debug, Clone, Default)]
pub struct PairOrder {
    begun: bool,
    paired: bool,
    /// Size of a left view whose right one comes next.
    open: Option<(u32, u32)>,
}

impl PairOrder {
    /// Takes the next view.
    ///
    /// # Errors
    /// The rule that it breaks.
    pub fn next(&mut self, view: &Camera) -> Result<(), &'static str> {
        let size = (view.width, view.height);
        if self.begun && self.paired != view.eye.is_some() {
            return Err("some views are eyes of pairs and others are not");
        }
        (self.begun, self.paired) = (true, view.eye.is_some());
        self.open = match (self.open, view.eye) {
            (None, None) => None,
            (None, Some(Eye::Left)) => Some(size),
            (None, Some(Eye::Right)) => return Err("a right eye without the left one before it"),
            (Some(left), Some(Eye::Right)) if left == size => None,
            (Some(_), Some(Eye::Right)) => return Err("the eyes of a pair have different sizes"),
            (Some(_), Some(Eye::Left) | None) => {
                return Err("a left eye without the right one after it");
            }
        };
        Ok(())
    }

    /// The list ends.
    ///
    /// # Errors
    /// A left eye is the last.
    pub fn end(&self) -> Result<(), &'static str> {
        self.open.map_or(Ok(()), |_| Err("a left eye without the right one after it"))
    }
}
