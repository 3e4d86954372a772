//! Writes INRIA's layout.

use std::io::{self, Write};

use super::super::Gaussians;
use super::super::convert::rest_of;
use super::header::ANTIALIASED;

/// Gaussians that are encoded before they are written.
const BLOCK: usize = 1024;

/// Writes `scene` as binary little-endian PLY in INRIA's layout: means, normals (zero), `f_dc`,
/// `f_rest` (channel-major), opacity, scales, rotation, all raw; 62 properties at degree 3. Reading
/// it back gives the same bits. A comment says that a model is anti-aliased.
///
/// # Errors
/// Those of `out`.
pub fn write(scene: &Gaussians, out: &mut impl Write) -> io::Result<()> {
    write_header(scene, out)?;
    let rest = rest_of(scene.sh_degree);
    let mut block = Vec::with_capacity(BLOCK * 4 * (17 + 3 * rest));
    for i in 0..scene.len() {
        let sh = scene.sh_of(i);
        let mut push = |values: &[f32]| {
            values.iter().for_each(|v| block.extend_from_slice(&v.to_le_bytes()));
        };
        push(&scene.means[i]);
        push(&[0.0; 3]);
        push(&[sh[0], sh[rest + 1], sh[2 * (rest + 1)]]);
        sh.chunks_exact(rest + 1).for_each(|channel| push(&channel[1..]));
        push(&[scene.logit_opacities[i]]);
        push(&scene.log_scales[i]);
        push(&scene.rotations[i]);
        if (i + 1) % BLOCK == 0 {
            out.write_all(&block)?;
            block.clear();
        }
    }
    out.write_all(&block)
}

fn write_header(scene: &Gaussians, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    if scene.antialiased {
        writeln!(out, "{ANTIALIASED}")?;
    }
    writeln!(out, "element vertex {}", scene.len())?;
    let rest = (0..3 * rest_of(scene.sh_degree)).map(|i| format!("f_rest_{i}"));
    let before = ["x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"];
    let after = ["opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"];
    let names = before.map(String::from).into_iter().chain(rest).chain(after.map(String::from));
    names.into_iter().try_for_each(|name| writeln!(out, "property float {name}"))?;
    writeln!(out, "end_header")
}
