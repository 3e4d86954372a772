//! INRIA's layout: one `vertex` row of raw parameters per Gaussian, and what others make of it.
//!
//! `f_rest_*` is channel-major: all coefficients of red, then green, then blue. Columns are found
//! by name; normals are ignored, other columns that are not read are named in a warning. Colours
//! may be `red`, `green` and `blue` instead of `f_dc_*` (nerfstudio's exporter). 2D Gaussian
//! Splatting has two scales. `filter_3D` is the 3D filter of Mip-Splatting, which is applied.

use std::collections::HashSet;

use super::super::convert::{dc, degree_of, rest_of, sigmoid};
use super::super::error::{REEXPORT, SceneError};
use super::super::input::{check_count, clip};
use super::super::{Gaussians, Warning};
use super::header::{Element, PlyHeader, Scalar};
use super::{Source, rows};

/// The element that holds Gaussians, in messages.
const VERTEX: &str = "PLY element `vertex`";
/// Columns that stand for nothing, as trainers leave them out of their models.
const NORMALS: [&str; 3] = ["nx", "ny", "nz"];
/// Colours as a viewer of point clouds takes them: instead of `f_dc_*`, or a copy of them.
const RGB: [&str; 3] = ["red", "green", "blue"];
/// The logarithm of the scale of a flat Gaussian across its plane: far below a pixel.
const FLAT: f32 = -20.0;

/// Reads the `vertex` element.
pub(super) fn read(
    source: &mut Source<'_>,
    header: &PlyHeader,
) -> Result<(Gaussians, Vec<Warning>), SceneError> {
    let element = header.advance(source, &mut 0, "vertex")?;
    let columns = InriaColumns::of(element)?;
    element.check_fits(header.encoding, source.left)?;
    let count = check_count(VERTEX, element.count, u64::MAX)?;
    let mut scene = Gaussians::with_capacity(count, columns.degree);
    rows::each(source, header.encoding, element, &columns.wanted, |v| columns.push(v, &mut scene))?;
    Ok((scene, columns.warnings))
}

/// Where a row has what.
struct InriaColumns {
    /// The columns of the element that are read: mean, rotation, opacity, scales, the 3D filter if
    /// there is one, then the SH coefficients `[channel][coefficient]`.
    wanted: Vec<usize>,
    /// Scales: 3, or 2.
    scales: usize,
    has_filter: bool,
    /// What the end of the range of a colour is stored as, where colours are stored.
    rgb: Option<f64>,
    degree: u8,
    warnings: Vec<Warning>,
}

/// Mean, rotation and opacity.
const FIXED: [&str; 8] = ["x", "y", "z", "rot_0", "rot_1", "rot_2", "rot_3", "opacity"];

impl InriaColumns {
    fn of(element: &Element) -> Result<InriaColumns, SceneError> {
        refuse_relatives(element)?;
        let mut used = HashSet::new();
        let mut find = |name: &str| {
            let found = element.column(name).ok_or_else(|| missing(name, element))?;
            used.insert(found);
            Ok(found)
        };
        let mut wanted = FIXED.iter().map(|name| find(name)).collect::<Result<Vec<_>, _>>()?;
        let mut warnings = Vec::new();
        let is_flat = element.column("scale_2").is_none() && element.column("scale_1").is_some();
        let scales = if is_flat { 2 } else { 3 };
        for axis in 0..scales {
            wanted.push(find(&format!("scale_{axis}"))?);
        }
        if is_flat {
            warnings.push(Warning::Flat);
        }
        let has_filter = element.column("filter_3D").is_some();
        if has_filter {
            wanted.push(find("filter_3D")?);
            warnings.push(Warning::Filter3d);
        }
        let rest = element.properties.iter().filter(|p| p.name.starts_with("f_rest_")).count();
        let Some(full) = rest.is_multiple_of(3).then(|| degree_of(rest / 3)).flatten() else {
            let what = format!("{rest} f_rest properties; 0, 9, 24 or 45 are known");
            return Err(SceneError::malformed(VERTEX, what, REEXPORT));
        };
        if full > 3 {
            warnings.push(Warning::ShReduced { from: full });
        }
        let degree = full.min(3);
        let rgb = rgb_range(element);
        for (channel, colour) in RGB.into_iter().enumerate() {
            wanted.push(match rgb {
                Some(_) => find(colour)?,
                None => find(&format!("f_dc_{channel}"))?,
            });
            for c in 0..rest_of(degree) {
                wanted.push(find(&format!("f_rest_{}", channel * (rest / 3) + c))?);
            }
        }
        let names = ignored(element, &used);
        if !names.is_empty() {
            warnings.push(Warning::IgnoredColumns { names });
        }
        Ok(InriaColumns { wanted, scales, has_filter, rgb, degree, warnings })
    }

    /// Appends the Gaussian of a row.
    fn push(&self, v: &[f64], scene: &mut Gaussians) {
        let f = |i: usize| v[i] as f32;
        let first = FIXED.len();
        let third = if self.scales == 2 { FLAT } else { f(first + 2) };
        let mut scale = [f(first), f(first + 1), third];
        let mut logit = f(7);
        let mut next = first + self.scales;
        if self.has_filter {
            (scale, logit) = filtered(scale, logit, v[next]);
            next += 1;
        }
        scene.means.push([f(0), f(1), f(2)]);
        scene.rotations.push([f(3), f(4), f(5), f(6)]);
        scene.log_scales.push(scale);
        scene.logit_opacities.push(logit);
        let sh = &v[next..];
        let Some(range) = self.rgb else {
            scene.sh.extend(sh.iter().map(|&c| c as f32));
            return;
        };
        for channel in sh.chunks_exact(1 + rest_of(self.degree)) {
            scene.sh.push(dc(channel[0] / range));
            scene.sh.extend(channel[1..].iter().map(|&c| c as f32));
        }
    }
}

fn missing(name: &str, element: &Element) -> SceneError {
    let what = format!(
        "no property `{name}`, which a trained 3DGS model has; there are {}",
        listed(element)
    );
    SceneError::malformed(VERTEX, what, "give the trainer's point_cloud.ply of a 3DGS model")
}

/// The columns that are there, in a line; those that a number tells apart by their first.
fn listed(element: &Element) -> String {
    const MOST: usize = 240;
    let mut names: Vec<String> = Vec::new();
    let mut series = HashSet::new();
    for name in element.properties.iter().map(|p| p.name.as_str()) {
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
        if stem == name {
            names.push(clip(name));
        } else if series.insert(stem) {
            names.push(format!("{}...", clip(name)));
        }
    }
    let all = names.join(", ");
    let shown: String = all.chars().take(MOST).collect();
    if shown.len() < all.len() { shown + " ..." } else { shown }
}

/// Refuses what trainers write beside Gaussians, or instead of them, by its name.
fn refuse_relatives(element: &Element) -> Result<(), SceneError> {
    let has = |start: &str| element.properties.iter().any(|p| p.name.starts_with(start));
    if has("f_offset_") || has("f_anchor_feat") {
        let what = "anchors with offsets and features (`f_offset_0`): a model of Scaffold-GS or a \
                    relative of it, whose networks make the Gaussians of each view";
        let todo = "export Gaussians with the code that trained it, or train a 3DGS model";
        return Err(SceneError::malformed(VERTEX, what, todo));
    }
    if element.column("beta").is_some() && has("sb_params") {
        let what = "`beta`, `sb_params_0` and `sh0_0`: a model of Deformable Beta Splatting, whose \
                    kernel is no Gaussian and whose colours are no spherical harmonics";
        let todo = "render it with the code that trained it, or train a 3DGS model";
        return Err(SceneError::malformed(VERTEX, what, todo));
    }
    if !has("scale_") && !has("rot_") && !has("opacity") {
        let what = "points without scales, rotations and opacities: a point cloud or a mesh, as \
                    COLMAP's points3D.ply or the input.ply of a run";
        let todo = "give the trained model, point_cloud/iteration_*/point_cloud.ply";
        return Err(SceneError::malformed(VERTEX, what, todo));
    }
    Ok(())
}

/// The end of the range of colours, where there are colours and no coefficients.
fn rgb_range(element: &Element) -> Option<f64> {
    let column = element.column(RGB[0])?;
    if element.column("f_dc_0").is_some() {
        return None;
    }
    Some(match element.properties[column].scalar {
        Scalar::U8 | Scalar::I8 => f64::from(u8::MAX),
        Scalar::U16 | Scalar::I16 => f64::from(u16::MAX),
        Scalar::U32 | Scalar::I32 => f64::from(u32::MAX),
        Scalar::F32 | Scalar::F64 => 1.0,
    })
}

/// Columns that are not read and mean something.
fn ignored(element: &Element, used: &HashSet<usize>) -> Vec<String> {
    let is_known = |name: &str| {
        NORMALS.contains(&name)
            || RGB.contains(&name)
            || name == "alpha"
            // Degree 4, of which another warning speaks.
            || name.starts_with("f_rest_")
    };
    let columns = element.properties.iter().enumerate();
    let others = columns.filter(|(i, p)| !used.contains(i) && !is_known(&p.name));
    others.map(|(_, p)| p.name.clone()).collect()
}

/// Raw scales and opacity behind the 3D filter of a standard deviation: variances add, and the
/// opacity falls by the root of the ratio of the determinants.
fn filtered(scale: [f32; 3], logit: f32, filter: f64) -> ([f32; 3], f32) {
    if filter == 0.0 {
        return (scale, logit);
    }
    let own = scale.map(f64::from);
    let wide = own.map(|s| 0.5 * ((2.0 * s).exp() + filter * filter).ln());
    let lost: f64 = own.iter().zip(wide).map(|(own, wide)| own - wide).sum();
    let opacity = sigmoid(logit) * lost.exp();
    (wide.map(|s| s as f32), (opacity / (1.0 - opacity)).ln() as f32)
}
