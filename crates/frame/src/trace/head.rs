//! The two records of fixed layout: the trace header and the facts of a frame.

use glam::{DMat3, DVec3};

use super::column::ColumnCounts;
use super::error::FrameFault;
use super::{Frame, FrameFacts, POINTS_MAX};
use crate::scene::{Camera, Eye, ShDegree, Split, StorageOrder};

/// The header of a trace file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraceHeader {
    /// The program that wrote it, with its version; at most 65,535 bytes.
    pub generator: String,
    /// Name of the scene; at most 65,535 bytes.
    pub scene: String,
    /// Gaussians in the scene, at most [`POINTS_MAX`]; the same in every frame.
    pub points: u64,
    /// How the Gaussians were sorted when the model was loaded: indices are addresses. Files before
    /// 2.2 do not say it, which reads as the order of the file.
    pub order: StorageOrder,
}

impl TraceHeader {
    pub(super) fn to_bytes(&self) -> Result<Vec<u8>, &'static str> {
        if self.points > POINTS_MAX {
            return Err("a scene has at most 2^32 - 1 Gaussians; reduce it");
        }
        let mut out = self.points.to_le_bytes().to_vec();
        put_text(&mut out, &self.generator)?;
        put_text(&mut out, &self.scene)?;
        out.push(self.order as u8);
        Ok(out)
    }

    pub(super) fn parse(bytes: &[u8]) -> Result<TraceHeader, String> {
        let mut fields = Fields(bytes);
        let points = fields.u64()?;
        if points > POINTS_MAX {
            return Err(format!("the header promises {points} Gaussians, 2^32 - 1 are allowed"));
        }
        let (generator, scene) = (fields.text()?, fields.text()?);
        // What later minor versions add behind it is left out.
        let order = match fields.0.first() {
            None => StorageOrder::Storage,
            Some(code) => *StorageOrder::ALL
                .get(usize::from(*code))
                .ok_or_else(|| format!("there is no storage order {code}"))?,
        };
        Ok(TraceHeader { generator, scene, points, order })
    }
}

/// The facts of a frame, in front of its columns.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameHead {
    /// Number of the frame, from 0.
    pub number: u64,
    /// Column blocks that follow.
    pub blocks: u32,
    /// Bytes of those blocks, headers included.
    pub bytes: u64,
    /// Visible splats.
    pub splats: u32,
    /// Gaze of a foveated frame, fraction of width and height.
    pub gaze: Option<[f32; 2]>,
    /// The facts.
    pub facts: FrameFacts,
}

const HAS_SPLIT: u8 = 1;
const IS_TEST: u8 = 2;
const HAS_MEAN: u8 = 4;
const HAS_GAZE: u8 = 8;
const IS_ANTIALIASED: u8 = 16;
const HAS_EYE: u8 = 32;
const IS_RIGHT: u8 = 64;
const ALL_FLAGS: u8 = 127;

impl FrameHead {
    pub(super) fn of(frame: &Frame) -> FrameHead {
        FrameHead {
            number: 0,
            blocks: 0,
            bytes: 0,
            splats: frame.splats.len() as u32,
            gaze: frame.fovea.as_ref().map(|f| f.gaze),
            facts: frame.facts.clone(),
        }
    }

    pub(super) fn counts(&self) -> ColumnCounts {
        let camera = &self.facts.camera;
        ColumnCounts {
            splats: u64::from(self.splats),
            pixels: u64::from(camera.width) * u64::from(camera.height),
            points: self.facts.points,
        }
    }

    /// Facts that can be checked without the columns.
    pub(super) fn check(&self, trace: &TraceHeader) -> Result<(), FrameFault> {
        if self.facts.points != trace.points {
            let what = "the number of Gaussians differs from that of the trace header";
            return Err(FrameFault::Facts { what });
        }
        self.facts.check()
    }

    fn flags(&self) -> u8 {
        let mut flags = match self.facts.camera.split {
            None => 0,
            Some(Split::Train) => HAS_SPLIT,
            Some(Split::Test) => HAS_SPLIT | IS_TEST,
        };
        if self.facts.mean_linear_rgb.is_some() {
            flags |= HAS_MEAN;
        }
        if self.gaze.is_some() {
            flags |= HAS_GAZE;
        }
        if self.facts.antialiased {
            flags |= IS_ANTIALIASED;
        }
        flags |= match self.facts.camera.eye {
            None => 0,
            Some(Eye::Left) => HAS_EYE,
            Some(Eye::Right) => HAS_EYE | IS_RIGHT,
        };
        flags
    }

    pub(super) fn to_bytes(&self) -> Result<Vec<u8>, &'static str> {
        let (facts, camera) = (&self.facts, &self.facts.camera);
        let mut out = Vec::with_capacity(288);
        for value in [self.number, self.bytes, facts.points, facts.survivors] {
            out.extend(value.to_le_bytes());
        }
        for value in [self.blocks, self.splats, camera.width, camera.height] {
            out.extend(value.to_le_bytes());
        }
        put_doubles(&mut out, &[camera.fx, camera.fy, camera.cx, camera.cy]);
        put_doubles(&mut out, &camera.world_to_camera.transpose().to_cols_array());
        put_doubles(&mut out, &camera.centre.to_array());
        put_doubles(&mut out, &facts.mean_linear_rgb.unwrap_or_default());
        let gaze = self.gaze.unwrap_or_default();
        facts.background.iter().chain(&gaze).for_each(|v| out.extend(v.to_le_bytes()));
        out.extend([self.flags(), facts.sh_degree.map_or(0, |degree| degree.get() + 1)]);
        put_text(&mut out, &camera.name)?;
        Ok(out)
    }

    /// Reads the record. Its values are checked with the frame.
    pub(super) fn parse(bytes: &[u8]) -> Result<FrameHead, String> {
        let mut f = Fields(bytes);
        let (number, bytes, points, survivors) = (f.u64()?, f.u64()?, f.u64()?, f.u64()?);
        let (blocks, splats, width, height) = (f.u32()?, f.u32()?, f.u32()?, f.u32()?);
        let [fx, fy, cx, cy] = f.doubles()?;
        let rotation = DMat3::from_cols_array(&f.doubles()?).transpose();
        let centre = DVec3::from_array(f.doubles()?);
        let mean: [f64; 3] = f.doubles()?;
        let (background, gaze): ([f32; 3], [f32; 2]) = (f.floats()?, f.floats()?);
        let [flags, degree] = f.take()?;
        let split = match flags & (HAS_SPLIT | IS_TEST) {
            0 => None,
            HAS_SPLIT => Some(Split::Train),
            IS_TEST => return Err("flag 2 of a frame needs flag 1".into()),
            _ => Some(Split::Test),
        };
        let eye = match flags & (HAS_EYE | IS_RIGHT) {
            0 => None,
            HAS_EYE => Some(Eye::Left),
            IS_RIGHT => return Err("flag 64 of a frame needs flag 32".into()),
            _ => Some(Eye::Right),
        };
        if flags > ALL_FLAGS {
            return Err(format!("the frame has unknown flags ({flags})"));
        }
        let sh_degree = match degree.checked_sub(1) {
            None => None,
            Some(degree) => Some(
                ShDegree::new(degree)
                    .ok_or_else(|| format!("the frame has SH degree {degree}; 0 to 3 are known"))?,
            ),
        };
        let name = f.text()?;
        f.end()?;
        let mean_linear_rgb = (flags & HAS_MEAN != 0).then_some(mean);
        let gaze = (flags & HAS_GAZE != 0).then_some(gaze);
        let world_to_camera = rotation;
        let camera =
            Camera { name, width, height, fx, fy, cx, cy, world_to_camera, centre, split, eye };
        let antialiased = flags & IS_ANTIALIASED != 0;
        let facts = FrameFacts {
            camera,
            points,
            survivors,
            sh_degree,
            antialiased,
            background,
            mean_linear_rgb,
        };
        Ok(FrameHead { number, blocks, bytes, splats, gaze, facts })
    }
}

fn put_text(out: &mut Vec<u8>, text: &str) -> Result<(), &'static str> {
    let length = u16::try_from(text.len()).map_err(|_| "a name is longer than 65,535 bytes")?;
    out.extend(length.to_le_bytes());
    out.extend(text.as_bytes());
    Ok(())
}

fn put_doubles(out: &mut Vec<u8>, values: &[f64]) {
    values.iter().for_each(|v| out.extend(v.to_le_bytes()));
}

/// Reads little-endian fields one after the other.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn slice(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (head, rest) = self.0.split_at_checked(n).ok_or("a record is too short")?;
        self.0 = rest;
        Ok(head)
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let bytes = self.slice(N)?;
        Ok(std::array::from_fn(|i| bytes[i]))
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.take().map(u64::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.take().map(u32::from_le_bytes)
    }

    fn doubles<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = f64::from_le_bytes(self.take()?);
        }
        Ok(values)
    }

    fn floats<const N: usize>(&mut self) -> Result<[f32; N], String> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = f32::from_le_bytes(self.take()?);
        }
        Ok(values)
    }

    fn text(&mut self) -> Result<String, String> {
        let length = u16::from_le_bytes(self.take()?);
        let bytes = self.slice(usize::from(length))?;
        String::from_utf8(bytes.to_vec()).map_err(|_| "a name is not UTF-8".into())
    }

    fn end(self) -> Result<(), String> {
        if self.0.is_empty() {
            return Ok(());
        }
        Err(format!("a record has {} bytes too many", self.0.len()))
    }
}
