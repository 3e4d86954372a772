//! INRIA's layout: one `vertex` row of raw parameters per Gaussian.
//!
//! `f_rest_*` is channel-major: all coefficients of red, then green, then blue. Columns are found
//! by name; normals and unknown ones are ignored.

use super::super::convert::degree_of;
use super::super::error::{REEXPORT, SceneError};
use super::super::input::check_count;
use super::super::{Gaussians, Warning};
use super::header::{Element, Header};
use super::{Source, rows};

/// Columns before the SH coefficients, in the order in which rows are decoded.
const FIXED: [&str; 11] =
    ["x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "opacity"];

/// Reads the `vertex` element.
pub(super) fn read(
    source: &mut Source<'_>,
    header: &Header,
) -> Result<(Gaussians, Vec<Warning>), SceneError> {
    let element = header.advance(source, &mut 0, "vertex")?;
    let columns = columns(element)?;
    element.check_fits(header.encoding, source.left)?;
    let count = check_count("PLY element `vertex`", element.count, u64::MAX)?;
    let mut scene = Gaussians::with_capacity(count, columns.degree);
    rows::each(source, header.encoding, element, &columns.wanted, |v| {
        let f = |i: usize| v[i] as f32;
        scene.means.push([f(0), f(1), f(2)]);
        scene.log_scales.push([f(3), f(4), f(5)]);
        scene.rotations.push([f(6), f(7), f(8), f(9)]);
        scene.logit_opacities.push(f(10));
        scene.sh.extend(v[FIXED.len()..].iter().map(|&c| c as f32));
    })?;
    Ok((scene, columns.warnings))
}

struct Columns {
    /// [`FIXED`], then the SH coefficients `[channel][coefficient]`.
    wanted: Vec<usize>,
    degree: u8,
    warnings: Vec<Warning>,
}

fn columns(element: &Element) -> Result<Columns, SceneError> {
    let find = |name: &str| {
        element.column(name).ok_or_else(|| {
            let what = format!("no property `{name}`; this is not a trained Gaussian model");
            SceneError::malformed(
                "PLY element `vertex`",
                what,
                "give the trainer's point_cloud.ply",
            )
        })
    };
    let mut wanted = FIXED.iter().map(|name| find(name)).collect::<Result<Vec<_>, _>>()?;
    let rest = element.properties.iter().filter(|p| p.name.starts_with("f_rest_")).count();
    let Some(full) = rest.is_multiple_of(3).then(|| degree_of(rest / 3)).flatten() else {
        let what = format!("{rest} f_rest properties; 0, 9, 24 or 45 are known");
        return Err(SceneError::malformed("PLY element `vertex`", what, REEXPORT));
    };
    let degree = full.min(3);
    let used = super::super::convert::rest_of(degree);
    for channel in 0..3 {
        wanted.push(find(&format!("f_dc_{channel}"))?);
        for c in 0..used {
            wanted.push(find(&format!("f_rest_{}", channel * (rest / 3) + c))?);
        }
    }
    let warnings = if full > 3 { vec![Warning::ShReduced { from: full }] } else { Vec::new() };
    Ok(Columns { wanted, degree, warnings })
}
