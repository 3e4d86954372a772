//! Parts of a scene and how often each is drawn.

use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::preset::{Preset, Scenery};
use super::scenery::{city, garden, room, street, toy};
use super::shape::SynthShape;
use super::texture::Look;

/// How the Gaussians of a part are shaped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LayoutKind {
    /// Flat discs on a surface.
    Surface,
    /// Ground: a surface without holes.
    Terrain,
    /// Leaves and blades: thin, elongated, in all directions.
    Foliage,
    /// The far background: large discs that face the middle.
    Shell,
    /// Haze and training artefacts: large, faint, anywhere.
    Floaters,
}

/// A part of a scene.
#[derive(Debug, Clone)]
pub(super) struct LayoutPart {
    /// Where its Gaussians are.
    pub shape: SynthShape,
    /// Its colours.
    pub look: Look,
    /// How they are shaped.
    pub kind: LayoutKind,
    /// How many of them, relative to the other parts.
    pub weight: f64,
    /// Standard deviation in units of the distance between neighbours.
    pub cover: f64,
    /// Whether it is what the views look at.
    pub is_focus: bool,
}

/// A scene before its Gaussians are drawn.
#[derive(Debug)]
pub(super) struct Layout {
    /// The parts.
    pub parts: Vec<LayoutPart>,
    /// Cumulative weight, ending at 1.
    cumulative: Vec<f64>,
    /// Gaussians in the scene.
    points: f64,
    /// Factor on the logarithms of the ratios of axes.
    pub elongation: f64,
}

impl Layout {
    /// The layout of `preset`; its arrangement depends on the seed alone.
    pub(crate) fn new(preset: &Preset, points: usize, seed: u64) -> Layout {
        let mut rng = super::generator(seed, 0);
        let mut parts = match preset.scenery {
            Scenery::Toy => toy::parts(&mut rng),
            Scenery::Room => room::parts(&mut rng),
            Scenery::Street => street::parts(&mut rng),
            Scenery::Garden => garden::parts(&mut rng),
            Scenery::City => city::parts(&mut rng),
            Scenery::Demo => toy::on_a_table(&mut rng),
        };
        parts.iter_mut().for_each(|part| part.cover *= preset.scale);
        if let Some(focus) = preset.focus {
            let of = |is_focus| parts.iter().filter(move |part| part.is_focus == is_focus);
            let [own, rest] = [true, false].map(|is| of(is).map(|part| part.weight).sum::<f64>());
            let factors = [(1.0 - focus) / rest.max(f64::MIN_POSITIVE), focus / own];
            parts.iter_mut().for_each(|part| part.weight *= factors[usize::from(part.is_focus)]);
        }
        let total: f64 = parts.iter().map(|part| part.weight).sum();
        let mut sum = 0.0;
        let cumulative = parts.iter().map(|part| {
            sum += part.weight / total;
            sum
        });
        Layout {
            cumulative: cumulative.collect(),
            parts,
            points: points as f64,
            elongation: preset.elongation,
        }
    }

    /// A part, by weight, and the number of Gaussians that it is expected to get.
    pub(crate) fn draw(&self, rng: &mut Pcg64Mcg) -> (&LayoutPart, f64) {
        let at: f64 = rng.random();
        let idx = self.cumulative.partition_point(|c| *c <= at).min(self.parts.len() - 1);
        let before = if idx == 0 { 0.0 } else { self.cumulative[idx - 1] };
        (&self.parts[idx], (self.cumulative[idx] - before) * self.points)
    }
}

/// A list of parts under construction. Weights of surfaces are area times `detail`, so that the
/// sampling density does not jump between parts of the same detail.
#[derive(Debug, Default)]
pub(super) struct Builder {
    /// The parts so far.
    pub parts: Vec<LayoutPart>,
}

impl Builder {
    /// A surface whose weight is its area times `detail`.
    pub(crate) fn surface(&mut self, shape: SynthShape, look: Look, detail: f64) {
        let weight = shape.area() * detail;
        let ground = matches!(shape, SynthShape::Ground { .. });
        let kind = if ground { LayoutKind::Terrain } else { LayoutKind::Surface };
        self.parts.push(LayoutPart {
            shape,
            look,
            kind,
            weight,
            cover: SURFACE_COVER,
            is_focus: false,
        });
    }

    /// An upright box standing on `base` (centre of its lower face), turned by `yaw`.
    pub(crate) fn block(&mut self, base: DVec3, size: DVec3, yaw: f64, look: Look, detail: f64) {
        let centre = base + DVec3::new(0.0, 0.0, 0.5 * size.z);
        self.surface(SynthShape::Block { centre, half: size * 0.5, yaw }, look, detail);
    }

    /// A part with a weight of its own.
    pub(crate) fn other(
        &mut self,
        shape: SynthShape,
        look: Look,
        kind: LayoutKind,
        weight: f64,
        cover: f64,
    ) {
        self.parts.push(LayoutPart { shape, look, kind, weight, cover, is_focus: false });
    }

    /// Makes everything so far what the views look at, with a share of all Gaussians.
    pub(crate) fn focus(&mut self, total: f64) {
        self.share(0, total);
        self.parts.iter_mut().for_each(|part| part.is_focus = true);
    }

    /// Scales the weights of everything from part `from` on so that they sum to `total`.
    pub(crate) fn share(&mut self, from: usize, total: f64) {
        let sum: f64 = self.parts[from..].iter().map(|part| part.weight).sum();
        self.parts[from..].iter_mut().for_each(|part| part.weight *= total / sum);
    }
}

/// Standard deviation of surface Gaussians in units of their spacing: enough overlap to close the
/// surface at the opacities that are drawn.
const SURFACE_COVER: f64 = 0.6;
