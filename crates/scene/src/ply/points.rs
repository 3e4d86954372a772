//! Plain point clouds: places, and colours of 8 bits where there are any.

use super::super::error::{REEXPORT, SceneError};
use super::super::input::{Input, check_count};
use super::{Source, header, rows};
use crate::PointCloud;

/// The colour of points without one: a middle grey.
const GREY: f64 = 127.5;

/// Reads the points of a PLY.
pub fn read_points(input: Input<'_>) -> Result<PointCloud, SceneError> {
    let mut source = Source { reader: input.reader, left: input.len };
    let header = header::read(&mut source)?;
    let element = header.advance(&mut source, &mut 0, "vertex")?;
    let column = |name: &str| {
        element.column(name).ok_or_else(|| {
            let what = format!("no column `{name}`; points have x, y and z");
            SceneError::malformed("PLY element `vertex`", what, REEXPORT)
        })
    };
    let mut wanted = vec![column("x")?, column("y")?, column("z")?];
    let colours = ["red", "green", "blue"].map(|name| element.column(name));
    let has_colours = colours.iter().all(Option::is_some);
    if has_colours {
        wanted.extend(colours.into_iter().flatten());
    }
    element.check_fits(header.encoding, source.left)?;
    if element.count == 0 {
        let todo = "give a file with points";
        return Err(SceneError::malformed("PLY element `vertex`", "no points", todo));
    }
    check_count("PLY element `vertex`", element.count, u64::MAX)?;
    let mut cloud = PointCloud::default();
    let mut bad = None;
    rows::each(&mut source, header.encoding, element, &wanted, |v| {
        let place = [v[0], v[1], v[2]];
        if !place.iter().all(|v| (*v as f32).is_finite()) {
            bad.get_or_insert(cloud.len());
        }
        let colour = if has_colours { [v[3], v[4], v[5]] } else { [GREY; 3] };
        cloud.push(place, colour.map(|v| v.clamp(0.0, 255.0) as u8));
    })?;
    match bad {
        None => Ok(cloud),
        Some(row) => {
            let place = format!("PLY element `vertex`, row {row}");
            Err(SceneError::malformed(place, "a place that is not finite", REEXPORT))
        }
    }
}
