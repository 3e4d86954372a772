//! Point clouds: what a training starts from.

/// Points with colours; both lists have one entry a point.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointCloud {
    /// Places, world units.
    pub positions: Vec<[f32; 3]>,
    /// Colours, sRGB 0 to 1.
    pub colours: Vec<[f32; 3]>,
}

impl PointCloud {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Adds a point; the colour is in steps of 1/255.
    pub(crate) fn push(&mut self, position: [f64; 3], colour: [u8; 3]) {
        self.positions.push(position.map(|v| v as f32));
        self.colours.push(colour.map(|v| f32::from(v) / 255.0));
    }
}
