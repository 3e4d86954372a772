//! `trace info`: header, frames, sizes on disk.

use powergs_base::format::counted;
use powergs_report::document::{Cell, Column, Document, Table};
use std::path::Path;

use serde_json::{Map, Value, json};

use super::{open, printable};
use crate::cli::{Context, Exit, Failure, OrExit, out};
use powergs_frame::scene::{ShDegree, StorageOrder};
use powergs_frame::trace::{ColumnGroup, FrameInfo, TraceHeader};

/// Frames that are listed unless all are asked for.
const LISTED: usize = 12;

/// Runs `trace info`.
pub(super) fn run(path: &Path, all: bool, context: &Context) -> Result<Exit, Failure> {
    let mut reader = open(path)?;
    let mut sizes = Vec::new();
    for k in 0..reader.len() {
        let info = reader.info(k).or_exit(Exit::BadInput, path.display())?;
        sizes.push(Sizes::of(&info));
        if context.is_cancelled() {
            return Ok(Exit::Interrupted);
        }
    }
    let trace = Trace {
        file: path.display().to_string(),
        version: reader.version(),
        header: reader.header().clone(),
        bytes: reader.bytes(),
        frames: sizes,
    };
    if context.global.json {
        out::json(&trace.json())?
    } else {
        out::document(&trace.document(all))?
    }
    Ok(Exit::Done)
}

struct Trace {
    file: String,
    version: (u16, u16),
    header: TraceHeader,
    bytes: u64,
    frames: Vec<Sizes>,
}

/// What is reported of a frame, or of all together.
#[derive(Debug, Clone, Default)]
struct Sizes {
    view: String,
    width: u64,
    height: u64,
    pixels: u64,
    splats: u64,
    survivors: u64,
    sh_degree: Option<ShDegree>,
    antialiased: bool,
    gaze: Option<[f32; 2]>,
    columns: Vec<(&'static str, u64, u64)>,
    bytes: u64,
    splat_bytes: u64,
    pixel_bytes: u64,
    raw_bytes: u64,
}

impl Sizes {
    fn of(info: &FrameInfo) -> Sizes {
        let (facts, camera) = (&info.head.facts, &info.head.facts.camera);
        let known = |c: &powergs_frame::trace::ColumnInfo| {
            (c.column.map_or("unknown", |k| k.name), c.raw_bytes, c.stored_bytes)
        };
        Sizes {
            view: printable(&camera.name),
            width: camera.width.into(),
            height: camera.height.into(),
            pixels: facts.pixels(),
            splats: info.head.splats.into(),
            survivors: facts.survivors,
            sh_degree: facts.sh_degree,
            antialiased: facts.antialiased,
            gaze: info.head.gaze,
            columns: info.columns.iter().map(known).collect(),
            bytes: info.bytes,
            splat_bytes: info.stored_bytes(ColumnGroup::Splat),
            pixel_bytes: info.stored_bytes(ColumnGroup::Pixel),
            raw_bytes: info.columns.iter().map(|c| c.raw_bytes).sum(),
        }
    }

    fn add(&mut self, other: &Sizes) {
        self.pixels += other.pixels;
        self.splats += other.splats;
        self.survivors += other.survivors;
        self.bytes += other.bytes;
        self.splat_bytes += other.splat_bytes;
        self.pixel_bytes += other.pixel_bytes;
        self.raw_bytes += other.raw_bytes;
    }

    fn other_bytes(&self) -> u64 {
        self.bytes - self.splat_bytes - self.pixel_bytes
    }

    fn bytes_per_splat(&self) -> Option<f64> {
        (self.splats > 0).then(|| self.splat_bytes as f64 / self.splats as f64)
    }

    fn bytes_per_pixel(&self) -> f64 {
        self.pixel_bytes as f64 / self.pixels.max(1) as f64
    }

    fn ratio(&self) -> f64 {
        self.raw_bytes as f64 / self.bytes.max(1) as f64
    }

    /// A row of the table; counts are divided by `n` frames.
    fn row(&self, first: String, view: &str, n: u64) -> [Cell; 8] {
        let mean = |sum: u64| Cell::Count((sum as f64 / n as f64).round() as u64);
        [
            first.into(),
            view.into(),
            mean(self.splats),
            mean(self.survivors),
            self.bytes_per_splat().into(),
            self.bytes_per_pixel().into(),
            mean(self.other_bytes()),
            self.ratio().into(),
        ]
    }

    /// The shared names of a frame and of the mean; counts are divided by `n` frames.
    fn json(&self, n: u64) -> Map<String, Value> {
        let mean = |sum: u64| match n {
            1 => json!(sum),
            n => json!(sum as f64 / n as f64),
        };
        let fields = [
            ("visible_splats", mean(self.splats)),
            ("survivors", mean(self.survivors)),
            ("pixels", mean(self.pixels)),
            ("bytes", mean(self.bytes)),
            ("splat_bytes", mean(self.splat_bytes)),
            ("pixel_bytes", mean(self.pixel_bytes)),
            ("other_bytes", mean(self.other_bytes())),
            ("raw_bytes", mean(self.raw_bytes)),
            ("bytes_per_visible_splat", json!(self.bytes_per_splat())),
            ("bytes_per_pixel", json!(self.bytes_per_pixel())),
            ("compression_ratio", json!(self.ratio())),
        ];
        fields.map(|(name, value)| (name.to_owned(), value)).into_iter().collect()
    }
}

impl Trace {
    fn total(&self) -> Sizes {
        let mut total = Sizes::default();
        self.frames.iter().for_each(|f| total.add(f));
        total
    }

    fn document(&self, all: bool) -> Document {
        let foveated = self.frames.iter().filter(|f| f.gaze.is_some()).count();
        let mut sizes: Vec<_> = self.frames.iter().map(|f| (f.width, f.height)).collect();
        sizes.sort_unstable();
        sizes.dedup();
        let resolution = match sizes.as_slice() {
            [] => "none".into(),
            [(w, h)] => format!("{w}x{h}"),
            [(w, h), .., (w2, h2)] => {
                format!("{} sizes, {w}x{h} to {w2}x{h2}", sizes.len())
            }
        };
        let (major, minor) = self.version;
        let (generator, scene) = (printable(&self.header.generator), printable(&self.header.scene));
        let (frames, points) = (self.frames.len(), self.header.points);
        let mut page = Document::new();
        page.facts([
            ("file", format!("{}, {:.2} MB, complete", self.file, self.bytes as f64 * 1e-6)),
            ("format", format!("version {major}.{minor}, written by {generator}")),
            ("scene", format!("{scene}, {points} Gaussians{}", self.kind())),
            ("SH degree", self.sh_degree()),
            ("frames", format!("{frames}, {foveated} of them foveated")),
            ("resolution", resolution),
        ]);
        if self.frames.is_empty() {
            return page;
        }
        let mut table = Table::new([
            Column::count("frame"),
            Column::text("view").at_most(20).cut_in_the_middle(),
            Column::count("visible"),
            Column::count("survivors"),
            Column::fixed("B/splat", 2),
            Column::fixed("B/pixel", 3),
            Column::count("other B"),
            Column::fixed("ratio", 2),
        ]);
        let shown = if all { frames } else { frames.min(LISTED) };
        for (k, frame) in self.frames[..shown].iter().enumerate() {
            table.row(frame.row(k.to_string(), &frame.view, 1));
        }
        table.row(self.total().row("mean".into(), "", frames as u64));
        if shown < frames {
            table.more = format!("... {} more: --all", counted(frames - shown, "frame"));
        }
        page.table(table);
        page.paragraph(
            "Visible: splats. Bytes per splat and pixel: their compressed columns; other: survivor \
             bits, preview, facts. Ratio: columns before compression over bytes of the frame.",
        );
        page
    }

    /// What is to know of the model.
    fn kind(&self) -> String {
        let order = match self.header.order {
            StorageOrder::Storage => String::new(),
            order => format!(" in {} order", order.name()),
        };
        let filtered = self.frames.iter().any(|frame| frame.antialiased);
        order + if filtered { ", anti-aliased" } else { "" }
    }

    /// The SH degree of the scene in all frames.
    fn sh_degree(&self) -> String {
        let mut degrees: Vec<Option<ShDegree>> = self.frames.iter().map(|f| f.sh_degree).collect();
        degrees.sort_unstable();
        degrees.dedup();
        let name = |degree: &Option<ShDegree>| match degree {
            Some(degree) => degree.to_string(),
            None => format!(
                "not in the trace (format {}.{}): counts as {}",
                self.version.0,
                self.version.1,
                ShDegree::MAX
            ),
        };
        match degrees.as_slice() {
            [] => "no frame".into(),
            all => all.iter().map(name).collect::<Vec<_>>().join(", "),
        }
    }

    fn json(&self) -> Value {
        let frame = |(k, f): (usize, &Sizes)| {
            let columns: Map<String, Value> = f
                .columns
                .iter()
                .map(|(name, raw, stored)| {
                    let sizes = json!({ "raw_bytes": raw, "stored_bytes": stored });
                    ((*name).to_owned(), sizes)
                })
                .collect();
            let mut object = Map::new();
            object.insert("frame".into(), json!(k));
            object.insert("view".into(), json!(f.view));
            object.insert("width_px".into(), json!(f.width));
            object.insert("height_px".into(), json!(f.height));
            object.insert("sh_degree".into(), json!(f.sh_degree.map(ShDegree::get)));
            object.insert("antialiased".into(), json!(f.antialiased));
            object.insert("foveated".into(), json!(f.gaze.is_some()));
            object.insert("gaze".into(), json!(f.gaze));
            object.extend(f.json(1));
            object.insert("columns".into(), Value::Object(columns));
            Value::Object(object)
        };
        let n = self.frames.len() as u64;
        json!({
            "file": self.file,
            "format_version": format!("{}.{}", self.version.0, self.version.1),
            "generator": self.header.generator,
            "scene": self.header.scene,
            "points": self.header.points,
            "storage_order": self.header.order.name(),
            "complete": true,
            "bytes": self.bytes,
            "frame_count": n,
            "mean": if n > 0 { Value::Object(self.total().json(n)) } else { Value::Null },
            "frames": self.frames.iter().enumerate().map(frame).collect::<Vec<_>>(),
        })
    }
}
