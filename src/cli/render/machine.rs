//! `render --order` and `--pixels`: pictures as a machine makes them, beside the exact ones.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::RenderArgs;
use super::pixels::ShownPictures;
use crate::cli::inputs::{SetArgs, system};
use crate::cli::{Context, Exit, Failure, OrExit, out};
use powergs_base::picture::Picture;
use powergs_core::flow::History;
use powergs_core::flow::tile_wise::blended::{blended_lists, pixel_origins};
use powergs_core::flow::tile_wise::{PixelSource, TileWise};
use powergs_core::machine::Machine;
use powergs_core::workload::{FrameDetail, bin_for, demand::demand};
use powergs_quality::likeness;
use powergs_raster::lists::{ListBlending, PaintedView};
use powergs_raster::{Detail, Options, render};
use powergs_report::document::{Cell, Column, Document, Table};
use powergs_scene::{Camera, Gaussians};

/// What a machine makes of views.
#[derive(Debug, clap::Args)]
pub struct MachineViewArgs {
    /// Blend in the order that a machine has with `gsu.impl` = IMPL (split, merge, update, last,
    /// shared, none), and compare with the exact picture; views are frames one after the other
    #[arg(long, value_name = "IMPL", group = "made_by", help_heading = "As a machine shows it")]
    pub order: Option<String>,
    /// Show the pixels that a machine has with `pixels.impl` = SOURCE (warped, cached), and
    /// compare with the exact picture; views are frames one after the other
    #[arg(long, value_name = "SOURCE", group = "made_by", help_heading = "As a machine shows it")]
    pub pixels: Option<String>,
    /// Machine whose tiles, chunks and keys are meant: a name of `arch list`, or a TOML file
    /// [default: gscore]
    #[arg(
        long,
        value_name = "NAME|FILE",
        requires = "made_by",
        help_heading = "As a machine shows it"
    )]
    pub arch: Option<String>,
    /// Changes of it.
    #[command(flatten)]
    pub changes: SetArgs,
    /// With --order none: entries are weighted by depth to the power of minus P, not by the power
    /// that suits the first view best
    #[arg(long, value_name = "P", requires = "order", help_heading = "As a machine shows it")]
    pub weight_power: Option<f32>,
}

/// Powers that are tried for a view without an order.
const POWERS: [f32; 8] = [0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];

/// A picture beside the exact one.
pub struct MachineView {
    /// Its name.
    name: String,
    psnr_db: f64,
    ssim: f64,
    /// With an order: of all neighbours in lists, those of which the first is farther; of all
    /// entries of its own lists, those that the lists lack. Otherwise: of all pixels, those that
    /// are rendered; those that are filled in.
    shares: [f64; 2],
}

/// Renders views one after the other in the order of a machine.
pub struct MachineRender {
    machine: Machine,
    history: History,
    background: [f32; 3],
    /// The power of depth of weights, where nothing is ordered.
    power: Option<f32>,
    views: Vec<MachineView>,
    /// What was shown, where pixels come from other pictures.
    shown: Option<ShownPictures>,
}

impl MachineViewArgs {
    /// What renders in this order; `None` without `--order`.
    ///
    /// # Errors
    /// Exit code 2: what no machine has, or a machine of another dataflow.
    pub fn open(&self, background: [f32; 3]) -> Result<Option<MachineRender>, Failure> {
        // What these exclude, and no picture shows.
        let mut sets = vec!["fovea=none".to_owned()];
        let mut more = |set: &[&str]| sets.extend(set.iter().map(|set| (*set).to_owned()));
        match (&self.order, &self.pixels) {
            (None, None) => {
                if let Some(set) = self.changes.sets.first() {
                    let what = format!(
                        "--set {set}: of the machine of --order or --pixels, which is not there"
                    );
                    return Err(Failure::new(Exit::Usage, what));
                }
                return Ok(None);
            }
            (Some(order), _) => {
                more(&[&format!("gsu.impl={order}")]);
                match order.as_str() {
                    "update" => more(&["binning.impl=free"]),
                    "last" | "shared" => more(&["record.entry-bitmap=false", "binning.impl=free"]),
                    "none" => more(&["vru.termination=none"]),
                    _ => {}
                }
            }
            (None, Some(source)) => more(&[&format!("pixels.impl={source}")]),
        }
        if self.weight_power.is_some_and(|power| !(0.0..=1000.0).contains(&power)) {
            let what = "--weight-power must be from 0 to 1000";
            return Err(Failure::new(Exit::Usage, what));
        }
        let arch = self.arch.as_deref().unwrap_or("gscore");
        sets.extend(self.changes.sets.iter().cloned());
        let machine = system(arch, &sets, None)?.machine().clone();
        if machine.tables.get::<TileWise>().is_none() {
            let what = format!("--arch {arch}: its dataflow has no lists of tiles to order");
            return Err(Failure::new(Exit::Usage, what));
        }
        let source = machine.tiles().pixels.source;
        if self.pixels.is_some() && matches!(source, PixelSource::All | PixelSource::Sampled) {
            let why = match source {
                PixelSource::All => "all pixels are rendered: leave --pixels out",
                _ => "samples are no picture",
            };
            let what = format!("--pixels {}: {why}; warped and cached have one", source.name());
            return Err(Failure::new(Exit::Usage, what));
        }
        Ok(Some(MachineRender {
            shown: self.pixels.is_some().then(ShownPictures::default),
            machine,
            history: History::default(),
            background,
            power: self.weight_power,
            views: Vec::new(),
        }))
    }
}

impl MachineRender {
    /// The picture of the next view.
    ///
    /// # Errors
    /// Exit code 2: a view that takes more memory than there is.
    pub fn next(
        &mut self,
        scene: &Gaussians,
        camera: &Camera,
        args: &RenderArgs,
        context: &Context,
    ) -> Result<Picture, Failure> {
        let options =
            Options { background: self.background, ..Options::reference(Detail::Counters) };
        let exact = render(scene, camera, &options);
        let picture = exact.picture.clone();
        let frame = exact.into_frame(camera, self.background);
        let tiles = self.machine.tiles();
        let detail = FrameDetail { pixels: true, whole: !tiles.gsu.sorts() };
        let fits = demand(&frame, tiles.geometry, detail, context.global.memory);
        fits.or_exit(Exit::Usage, format!("{}, view {}", args.shown.scene.display(), camera.name))?;
        let workload = bin_for(&frame, tiles.geometry, detail);
        let name = camera.name.clone();
        if let Some(shown) = &mut self.shown {
            tiles.shows(&self.machine.name, &workload).or_exit(Exit::Usage, "--pixels")?;
            let (machine, history) = (&self.machine, &mut self.history);
            let origins = pixel_origins(machine, &workload, camera.eye, history);
            let (made, of) = shown.next(&picture, &origins.unwrap_or_default());
            let like = likeness(&made, &picture);
            let (psnr_db, ssim) = (like.psnr_db, like.ssim);
            self.views.push(MachineView { name, psnr_db, ssim, shares: [of.rendered, of.filled] });
            return Ok(made);
        }
        let lists = blended_lists(&self.machine, &workload, camera.eye, &mut self.history);
        let painted = PaintedView::new(scene, camera, options.level);
        let side = tiles.geometry.tile;
        let blend = |blending| painted.blend(side, &lists.tiles, blending, self.background);
        let (made, like) = if tiles.gsu.sorts() {
            let made = blend(ListBlending::Over);
            let like = likeness(&made, &picture);
            (made, like)
        } else {
            let powers = self.power.map_or(POWERS.to_vec(), |power| vec![power]);
            let tried = powers.into_iter().map(|power| {
                let made = blend(ListBlending::Weighted(power));
                let like = likeness(&made, &picture);
                (power, made, like)
            });
            let best = tried.max_by(|a, b| a.2.psnr_db.total_cmp(&b.2.psnr_db));
            let (power, made, like) = best.expect("a power");
            self.power = Some(power);
            (made, like)
        };
        let entries: usize = lists.tiles.iter().map(Vec::len).sum();
        let own = workload.counters.tile_pairs;
        let missing = lists.taken.map_or(0, |taken| taken.missing);
        self.views.push(MachineView {
            name,
            psnr_db: like.psnr_db,
            ssim: like.ssim,
            shares: [
                lists.out_of_order as f64 / entries.max(1) as f64,
                missing as f64 / own.max(1) as f64,
            ],
        });
        Ok(made)
    }

    /// What was rendered, beside the exact pictures.
    ///
    /// # Errors
    /// Standard output that cannot be written.
    pub fn report(&self, context: &Context, files: &[PathBuf]) -> Result<Exit, Failure> {
        let (gsu, pixels) = (&self.machine.tiles().gsu, &self.machine.tiles().pixels);
        let weights = self.power.filter(|_| !gsu.sorts());
        let (key, value, names) = match &self.shown {
            None => ("gsu.impl", gsu.implementation.name(), ["out of order", "missing"]),
            Some(_) => ("pixels.impl", pixels.source.name(), ["rendered", "filled in"]),
        };
        let machine = &self.machine.name;
        if context.global.json {
            let psnr = |view: &MachineView| view.psnr_db.is_finite().then_some(view.psnr_db);
            let row = |(view, file): (&MachineView, &PathBuf)| {
                let mut row = json!({
                    "name": view.name,
                    "psnr_db": psnr(view),
                    "ssim": view.ssim,
                    "file": file.display().to_string(),
                });
                for (name, share) in names.iter().zip(view.shares) {
                    row[format!("{}_frac", name.replace(' ', "_"))] = share.into();
                }
                row
            };
            let rows: Vec<Value> = self.views.iter().zip(files).map(row).collect();
            let kind = if self.shown.is_some() { "pixels" } else { "order" };
            out::json(&json!({
                kind: value,
                "machine": machine,
                "weight_power": weights,
                "images": rows,
            }))?;
            return Ok(Exit::Done);
        }
        if context.global.quiet {
            return Ok(Exit::Done);
        }
        let mut page = Document::new();
        let share = |name: &str| Column::fixed(format!("{name}, %"), 3);
        let columns = [
            Column::text("view"),
            Column::fixed("PSNR, dB", 2),
            Column::fixed("SSIM", 5),
            share(names[0]),
            share(names[1]),
            Column::text("file").cut_in_the_middle(),
        ];
        let row = |(view, file): (&MachineView, &PathBuf)| {
            let psnr = match view.psnr_db.is_finite() {
                true => Cell::Real(view.psnr_db),
                false => "equal".into(),
            };
            let [first, second] = view.shares.map(|share| Cell::Real(100.0 * share));
            let name = view.name.as_str().into();
            [name, psnr, Cell::Real(view.ssim), first, second, file.display().to_string().into()]
        };
        page.table(Table::new(columns).rows(self.views.iter().zip(files).map(row)));
        let what = format!("Pictures with `{key}` = \"{value}\" on {machine}, beside exact ones");
        page.paragraph(match (weights, &self.shown) {
            (Some(power), _) => format!(
                "{what}: weights are depth to the power of -{power}. No model is trained for it \
                 here; trained ones lose less."
            ),
            (None, None) => format!(
                "{what}. Out of order: neighbours in a list of which the first is farther; \
                 missing: entries that lists lack."
            ),
            (None, Some(_)) => format!(
                "{what}. Rendered: pixels that go through their whole list; filled in: from \
                 neighbours, where no pixel of the frame before comes to."
            ),
        });
        out::document(&page)?;
        Ok(Exit::Done)
    }
}
