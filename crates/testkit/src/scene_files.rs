//! Small writers for every scene format: what the readers are tested and fuzzed with.

use std::collections::BTreeMap;
use std::io::{Cursor, Write};

use powergs_scene::convert::sigmoid;
use powergs_scene::export::{self, Target};
use powergs_scene::{Gaussians, write_ply};

/// Files of a scene, by name.
pub type Files = BTreeMap<String, Vec<u8>>;

/// A model with `count` Gaussians in a unit cube, the same for the same arguments.
pub fn sample(count: usize, sh_degree: u8) -> Gaussians {
    let mut state = 12_345_u32;
    let mut next = |low: f32, high: f32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        low + (high - low) * (state >> 8) as f32 / 16_777_216.0
    };
    let mut scene = Gaussians { sh_degree, ..Gaussians::default() };
    for _ in 0..count {
        scene.means.push([next(-1.0, 1.0), next(-1.0, 1.0), next(-1.0, 1.0)]);
        scene.log_scales.push([next(-6.0, -2.0), next(-6.0, -2.0), next(-6.0, -2.0)]);
        let q = [next(-1.0, 1.0), next(-1.0, 1.0), next(-1.0, 1.0), next(0.1, 1.0)];
        let length = q.iter().map(|c| c * c).sum::<f32>().sqrt();
        scene.rotations.push(q.map(|c| c / length));
        scene.logit_opacities.push(next(-3.0, 3.0));
        for _ in 0..3 {
            scene.sh.push(next(-1.5, 1.5));
            scene.sh.extend((1..(sh_degree + 1).pow(2)).map(|_| next(-0.9, 0.9)));
        }
    }
    scene
}

fn byte(value: f64) -> u8 {
    value.round().clamp(0.0, 255.0) as u8
}

fn colour(dc: f32) -> f64 {
    f64::from(dc) * 0.282_094_791_773_878_14 + 0.5
}

/// INRIA's layout.
pub fn ply(scene: &Gaussians) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_ply(scene, &mut bytes).expect("memory takes all");
    bytes
}

/// INRIA's layout as text.
pub fn ascii_ply(scene: &Gaussians) -> Vec<u8> {
    let binary = ply(scene);
    let end = binary.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
    let header = String::from_utf8_lossy(&binary[..end]).replace("binary_little_endian", "ascii");
    let mut text = header;
    for row in binary[end..].chunks_exact((binary.len() - end) / scene.len()) {
        let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]).to_string();
        text += &row.chunks_exact(4).map(number).collect::<Vec<_>>().join(" ");
        text.push('\n');
    }
    text.into_bytes()
}

/// antimatter15's rows.
pub fn splat(scene: &Gaussians) -> Vec<u8> {
    let mut bytes = Vec::new();
    let n = scene.sh_coefficients();
    for i in 0..scene.len() {
        let scales = scene.log_scales[i].map(f32::exp);
        for value in scene.means[i].iter().chain(&scales) {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend(scene.sh_of(i).chunks_exact(n).map(|c| byte(255.0 * colour(c[0]))));
        bytes.push(byte(255.0 * sigmoid(scene.logit_opacities[i])));
        bytes.extend(scene.rotations[i].map(|c| byte(f64::from(c) * 128.0 + 128.0)));
    }
    bytes
}

/// Index of the largest of four components, and the other three with its sign made positive.
fn smallest_three(q: [f32; 4]) -> (usize, [f64; 3]) {
    let largest = (0..4).max_by(|&a, &b| q[a].abs().total_cmp(&q[b].abs())).expect("four");
    let sign = f64::from(q[largest].signum());
    let mut others = (0..4).filter(|&i| i != largest).map(|i| sign * f64::from(q[i]));
    (largest, std::array::from_fn(|_| others.next().expect("three others")))
}

fn bounds(rows: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let fold = |pick: fn(f32, f32) -> f32, start: f32| {
        rows.iter().fold([start; 3], |b, r| std::array::from_fn(|i| pick(b[i], r[i])))
    };
    (fold(f32::min, f32::MAX), fold(f32::max, f32::MIN))
}

fn pack_11_10_11(v: [f32; 3], (min, max): ([f32; 3], [f32; 3])) -> u32 {
    let part = |i: usize, largest: f32| {
        (((v[i] - min[i]) / (max[i] - min[i]).max(1e-9)) * largest).round() as u32
    };
    part(0, 2047.0) << 21 | part(1, 1023.0) << 11 | part(2, 2047.0)
}

/// PlayCanvas compressed PLY, with colour bounds and an SH element where the model has degrees.
pub fn compressed_ply(scene: &Gaussians) -> Vec<u8> {
    let chunks = scene.len().div_ceil(256);
    let rest = 3 * (scene.sh_coefficients() - 1);
    let mut header = format!("ply\nformat binary_little_endian 1.0\nelement chunk {chunks}\n");
    for kind in ["", "scale_"] {
        for end in ["min", "max"] {
            ["x", "y", "z"]
                .iter()
                .for_each(|a| header += &format!("property float {end}_{kind}{a}\n"));
        }
    }
    for end in ["min", "max"] {
        ["r", "g", "b"].iter().for_each(|c| header += &format!("property float {end}_{c}\n"));
    }
    header += &format!("element vertex {}\n", scene.len());
    for name in ["position", "rotation", "scale", "color"] {
        header += &format!("property uint packed_{name}\n");
    }
    if rest > 0 {
        header += &format!("element sh {}\n", scene.len());
        (0..rest).for_each(|i| header += &format!("property uchar f_rest_{i}\n"));
    }
    let (mut table, mut rows, mut sh) = (Vec::new(), Vec::new(), Vec::new());
    for start in (0..scene.len()).step_by(256) {
        let range = start..scene.len().min(start + 256);
        let means = bounds(&scene.means[range.clone()]);
        let scales = bounds(&scene.log_scales[range.clone()]);
        let bound = [means.0, means.1, scales.0, scales.1, [-0.5; 3], [1.5; 3]];
        bound.iter().flatten().for_each(|v| table.extend(v.to_le_bytes()));
        for i in range {
            let (largest, small) = smallest_three(scene.rotations[i]);
            let part = |c: f64| ((c / std::f64::consts::SQRT_2 + 0.5) * 1023.0).round() as u32;
            let rotation = (largest as u32) << 30
                | part(small[0]) << 20
                | part(small[1]) << 10
                | part(small[2]);
            let channels = scene.sh_of(i).chunks_exact(scene.sh_coefficients());
            let rgb: Vec<u8> =
                channels.clone().map(|c| byte(255.0 * (colour(c[0]) + 0.5) / 2.0)).collect();
            let alpha = byte(255.0 * sigmoid(scene.logit_opacities[i]));
            let words = [
                pack_11_10_11(scene.means[i], means),
                rotation,
                pack_11_10_11(scene.log_scales[i], scales),
                u32::from_be_bytes([rgb[0], rgb[1], rgb[2], alpha]),
            ];
            words.iter().for_each(|w| rows.extend(w.to_le_bytes()));
            let coefficients = channels.flat_map(|c| &c[1..]);
            sh.extend(coefficients.map(|&c| ((f64::from(c) / 8.0 + 0.5) * 256.0) as u8));
        }
    }
    [header.as_bytes(), b"end_header\n", &table, &rows, &sh].concat()
}

/// The attributes of SPZ in order, with the axes as they are: turned on purpose nowhere.
fn spz_attributes(scene: &Gaussians, version: u8) -> Vec<Vec<u8>> {
    let n = scene.sh_coefficients();
    let mut parts = vec![Vec::new(); 6];
    for i in 0..scene.len() {
        for v in scene.means[i] {
            match version {
                1 => parts[0].extend(half(v).to_le_bytes()),
                _ => parts[0].extend(&((v * 4096.0).round() as i32).to_le_bytes()[..3]),
            }
        }
        parts[1].push(byte(255.0 * sigmoid(scene.logit_opacities[i])));
        let channels: Vec<_> = scene.sh_of(i).chunks_exact(n).collect();
        parts[2].extend(channels.iter().map(|c| byte(255.0 * (f64::from(c[0]) * 0.15 + 0.5))));
        parts[3].extend(scene.log_scales[i].map(|s| byte((f64::from(s) + 10.0) * 16.0)));
        let [w, x, y, z] = scene.rotations[i];
        if version < 3 {
            parts[4].extend([x, y, z].map(|c| byte(f64::from(c * w.signum()) * 127.5 + 127.5)));
        } else {
            let (largest, small) = smallest_three([x, y, z, w]);
            let word = small.iter().fold(largest as u32, |word, c| {
                let magnitude = (c.abs() * std::f64::consts::SQRT_2 * 511.0).round() as u32;
                word << 10 | u32::from(*c < 0.0) << 9 | magnitude
            });
            parts[4].extend(word.to_le_bytes());
        }
        let stored = |c: usize| channels.iter().map(move |channel| channel[c]);
        parts[5].extend((1..n).flat_map(stored).map(|v| byte(f64::from(v) * 128.0 + 128.0)));
    }
    parts
}

/// Half precision of a normal number, cut off.
fn half(v: f32) -> u16 {
    let bits = v.to_bits();
    let exponent = (bits >> 23 & 0xff) as i32 - 112;
    let sign = (bits >> 16 & 0x8000) as u16;
    if exponent <= 0 { sign } else { sign | (exponent as u16) << 10 | (bits >> 13 & 0x3ff) as u16 }
}

/// Niantic SPZ, version 1 to 4, values as they are in the stored axes; `extensions` are records.
pub fn spz(scene: &Gaussians, version: u8, extensions: &[u8]) -> Vec<u8> {
    let flags = if extensions.is_empty() { 0 } else { 2 };
    let mut head = b"NGSP".to_vec();
    head.extend(u32::from(version).to_le_bytes());
    head.extend((scene.len() as u32).to_le_bytes());
    head.extend([scene.sh_degree, 12, flags, 0]);
    let mut parts = spz_attributes(scene, version);
    if version < 4 {
        let plain = [&head[..], &parts.concat(), extensions].concat();
        return gzip(&plain);
    }
    parts.retain(|part| !part.is_empty());
    head[15] = parts.len() as u8;
    head.extend((32 + extensions.len() as u32).to_le_bytes());
    head.extend([0; 12]);
    head.extend(extensions);
    let packed: Vec<Vec<u8>> =
        parts.iter().map(|part| zstd::bulk::compress(part, 3).expect("memory")).collect();
    for (packed, plain) in packed.iter().zip(&parts) {
        head.extend((packed.len() as u64).to_le_bytes());
        head.extend((plain.len() as u64).to_le_bytes());
    }
    [head, packed.concat()].concat()
}

/// A gzip stream.
pub fn gzip(plain: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(plain).and_then(|()| encoder.finish()).expect("memory takes all")
}

/// A lossless WebP image of the pixels, `width` wide, padded with zeros.
fn webp(mut pixels: Vec<[u8; 4]>, width: usize) -> Vec<u8> {
    let height = pixels.len().div_ceil(width);
    pixels.resize(width * height, [0; 4]);
    let mut bytes = Vec::new();
    let (width, height) = (width as u32, height as u32);
    image_webp::WebPEncoder::new(&mut bytes)
        .encode(pixels.as_flattened(), width, height, image_webp::ColorType::Rgba8)
        .expect("memory takes all");
    bytes
}

/// 256 steps over the values, and the step nearest to a value.
struct SceneFileCodebook(f64, f64);

impl SceneFileCodebook {
    fn of<'a>(values: impl Iterator<Item = &'a f32> + Clone) -> Self {
        let fold = |pick: fn(f32, f32) -> f32, start| values.clone().copied().fold(start, pick);
        Self(fold(f32::min, f32::MAX).into(), fold(f32::max, f32::MIN).into())
    }

    fn byte(&self, value: f32) -> u8 {
        byte((f64::from(value) - self.0) / (self.1 - self.0).max(1e-9) * 255.0)
    }

    /// `codebook` of version 2, or `mins` and `maxs` of `n` channels of version 1.
    fn json(&self, version: u8, n: usize) -> serde_json::Value {
        let step = |i: usize| self.0 + (self.1 - self.0) * i as f64 / 255.0;
        match (version, n) {
            (2, _) => serde_json::json!({ "codebook": (0..256).map(step).collect::<Vec<_>>() }),
            (_, 1) => serde_json::json!({ "mins": self.0, "maxs": self.1 }),
            _ => serde_json::json!({ "mins": vec![self.0; n], "maxs": vec![self.1; n] }),
        }
    }
}

/// PlayCanvas SOG, version 1 or 2, as files of a folder.
pub fn sog(scene: &Gaussians, version: u8) -> Files {
    let n = scene.sh_coefficients();
    let log = |v: f32| f64::from(v.signum()) * f64::from(v.abs()).ln_1p();
    let (low, high) = (-1.0_f64.ln_1p(), 1.0_f64.ln_1p());
    let sixteen = |v: f32| ((log(v) - low) / (high - low) * 65535.0).round() as u16;
    let positions: Vec<_> =
        scene.means.iter().map(|m| m.map(|v| sixteen(v).to_le_bytes())).collect();
    let half = |k: usize| positions.iter().map(|p| [p[0][k], p[1][k], p[2][k], 255]).collect();
    let scales = SceneFileCodebook::of(scene.log_scales.iter().flatten());
    let dc = SceneFileCodebook::of(scene.sh.iter().step_by(n).chain(&scene.logit_opacities));
    let rest = SceneFileCodebook::of(scene.sh.iter());
    let opacity = |logit: f32| match version {
        2 => byte(255.0 * sigmoid(logit)),
        _ => dc.byte(logit),
    };
    let rotation = |q: &[f32; 4]| {
        let (largest, small) = smallest_three(*q);
        let [a, b, c] = small.map(|c| byte((c / std::f64::consts::SQRT_2 + 0.5) * 255.0));
        [a, b, c, 252 + largest as u8]
    };
    let sh0 = |i: usize| {
        let c = scene.sh_of(i);
        [dc.byte(c[0]), dc.byte(c[n]), dc.byte(c[2 * n]), opacity(scene.logit_opacities[i])]
    };
    let width = 16;
    let scale = |s: &[f32; 3]| [scales.byte(s[0]), scales.byte(s[1]), scales.byte(s[2]), 255];
    let images = [
        ("means_l.webp", webp(half(0), width)),
        ("means_u.webp", webp(half(1), width)),
        ("scales.webp", webp(scene.log_scales.iter().map(scale).collect(), width)),
        ("quats.webp", webp(scene.rotations.iter().map(rotation).collect(), width)),
        ("sh0.webp", webp((0..scene.len()).map(sh0).collect(), width)),
    ];
    let mut files: Files = images.map(|(name, bytes)| (name.to_string(), bytes)).into();
    let mut meta = serde_json::json!({
        "means": {
            "mins": [low, low, low],
            "maxs": [high, high, high],
            "files": ["means_l.webp", "means_u.webp"],
        },
        "scales": scales.json(version, 3),
        "quats": { "files": ["quats.webp"] },
        "sh0": dc.json(version, 4),
    });
    meta["scales"]["files"] = vec!["scales.webp"].into();
    meta["sh0"]["files"] = vec!["sh0.webp"].into();
    match version {
        2 => (meta["version"], meta["count"]) = (2.into(), scene.len().into()),
        _ => meta["means"]["shape"] = vec![scene.len(), 3].into(),
    }
    if n > 1 {
        let texels = |i: usize| {
            let c = scene.sh_of(i);
            (1..n).map(move |k| [c[k], c[n + k], c[2 * n + k]])
        };
        let texel = |[r, g, b]: [f32; 3]| [rest.byte(r), rest.byte(g), rest.byte(b), 255];
        let palette: Vec<_> = (0..scene.len()).flat_map(texels).map(texel).collect();
        let label = |i: usize| [(i % 256) as u8, (i / 256) as u8, 0, 255];
        files.insert("c.webp".into(), webp(palette, 64 * (n - 1)));
        files.insert("l.webp".into(), webp((0..scene.len()).map(label).collect(), width));
        meta["shN"] = rest.json(version, 1);
        meta["shN"]["files"] = vec!["c.webp", "l.webp"].into();
    }
    files.insert("meta.json".into(), meta.to_string().into_bytes());
    files
}

/// Files as a zip archive.
pub fn zipped(files: &Files) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        let options = zip::write::SimpleFileOptions::default();
        archive.start_file(name, options).expect("memory takes all");
        archive.write_all(bytes).expect("memory takes all");
    }
    archive.finish().expect("memory takes all").into_inner()
}

/// A file of the program's own writer.
fn written(scene: &Gaussians, target: Target) -> Vec<u8> {
    match export::write(scene, target).expect("a sound model").files {
        export::Files::One(bytes) => bytes,
        export::Files::Folder(_) => panic!("one file"),
    }
}

/// One small file or more for each fuzz target: target, name, bytes.
pub fn seeds() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let (flat, round) = (sample(3, 0), sample(2, 2));
    let axes = [&0xadbe_0003_u32.to_le_bytes()[..], &[4, 0, 0, 0], &[6, 0, 0, 0]].concat();
    vec![
        ("scene_ply", "binary", ply(&sample(2, 1))),
        ("scene_ply", "ascii", ascii_ply(&flat)),
        ("scene_compressed_ply", "degree0", compressed_ply(&flat)),
        ("scene_compressed_ply", "degree2", compressed_ply(&round)),
        ("scene_splat", "rows", splat(&flat)),
        ("scene_spz", "v1", spz(&flat, 1, &[])),
        ("scene_spz", "v2", spz(&flat, 2, &[])),
        ("scene_spz", "v3", spz(&round, 3, &axes)),
        ("scene_spz", "v4", spz(&flat, 4, &[])),
        ("scene_spz", "v4_degree2", spz(&round, 4, &axes)),
        ("scene_gltf", "json", written(&round, Target::Gltf)),
        ("scene_gltf", "binary", written(&flat, Target::Glb)),
        ("scene_gltf", "spz", written(&flat, Target::GlbSpz)),
        ("scene_sog", "v1", zipped(&sog(&flat, 1))),
        ("scene_sog", "v2_degree2", zipped(&sog(&round, 2))),
        ("scene_sog_plane", "means_l", sog(&flat, 2)["means_l.webp"].clone()),
    ]
}
