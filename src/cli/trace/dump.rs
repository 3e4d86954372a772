//! `trace dump`: one frame as CSV.

use std::fmt::Display;
use std::io::{self, Write};
use std::path::PathBuf;

use super::open;
use crate::cli::output_file::{self, Overwrite};
use crate::cli::{Context, Exit, Failure, OrExit, out};
use powergs_base::format::counted;
use powergs_core::run::store::atomic::write_atomically;
use powergs_frame::fovea::Screen;
use powergs_frame::trace::{Frame, NEVER};

/// The arguments of `trace dump`.
#[derive(Debug, clap::Args)]
pub(super) struct DumpArgs {
    /// The trace
    file: PathBuf,
    /// The frame, counted from 0
    #[arg(long, value_name = "K")]
    frame: u64,
    /// The table
    #[arg(long, value_enum, default_value = "splats")]
    what: What,
    /// The CSV file; standard output without it
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum What {
    /// A row a visible splat, in depth order
    Splats,
    /// A row a pixel; an empty stop rank says that the pixel never stopped
    Pixels,
    /// Camera, counts, background
    Facts,
}

/// Runs `trace dump`.
pub(super) fn run(args: &DumpArgs, context: &Context) -> Result<Exit, Failure> {
    if context.global.json {
        let what = "trace dump writes CSV; leave out --json, or use trace info --json";
        return Err(Failure::new(Exit::Usage, what));
    }
    args.output.iter().try_for_each(|path| args.overwrite.check(path))?;
    let mut reader = open(&args.file)?;
    if args.frame >= reader.len() {
        let (frame, frames) = (args.frame, reader.len());
        let what =
            format!("--frame {frame}: the trace has {}, numbered from 0", counted(frames, "frame"));
        return Err(Failure::new(Exit::Usage, what));
    }
    let name = || args.file.display();
    let frame = reader.read_block(args.frame).or_exit(Exit::BadInput, name())?;
    let within = context.global.memory.check(frame.decoding_bytes());
    within.or_exit(Exit::BadInput, format_args!("{}: frame {}", name(), args.frame))?;
    let frame = frame.decode().or_exit(Exit::BadInput, name())?;
    let table = |out: &mut dyn Write| match args.what {
        What::Splats => splats(&frame, out),
        What::Pixels => pixels(&frame, out),
        What::Facts => facts(&frame, out),
    };
    match &args.output {
        Some(path) => {
            write_atomically(path, table)?;
            let what = match args.what {
                What::Splats => format!("{} splats of frame {}", frame.splats.len(), args.frame),
                What::Pixels => {
                    format!("{} pixels of frame {}", frame.pixels.stop_rank.len(), args.frame)
                }
                What::Facts => format!("the facts of frame {}", args.frame),
            };
            output_file::say(path, what, context)?;
        }
        None if args.what == What::Facts => {
            let mut text = Vec::new();
            facts(&frame, &mut text).or_exit(Exit::Internal, "the facts of a frame")?;
            out::text(&String::from_utf8_lossy(&text))?;
        }
        None => out::write(table)?,
    }
    Ok(Exit::Done)
}

fn splats(frame: &Frame, out: &mut dyn Write) -> io::Result<()> {
    let levels = frame.fovea.as_ref().map(|f| &f.highest_level);
    let more = if levels.is_some() { ",highest_level" } else { "" };
    writeln!(
        out,
        "rank,index,depth_world,mean_x_px,mean_y_px,cov_xx_px2,cov_xy_px2,cov_yy_px2,opacity{more}"
    )?;
    for (rank, s) in frame.splats.iter().enumerate() {
        let ([x, y], [a, b, d]) = (s.mean, s.cov);
        write!(out, "{rank},{},{},{x},{y},{a},{b},{d},{}", s.index, s.depth, s.opacity)?;
        match levels {
            Some(levels) => writeln!(out, ",{}", levels[rank])?,
            None => writeln!(out)?,
        }
    }
    Ok(())
}

fn pixels(frame: &Frame, out: &mut dyn Write) -> io::Result<()> {
    let more = if frame.fovea.is_some() { ",stop_rank_2,extra_alpha,blended_2" } else { "" };
    writeln!(out, "x_px,y_px,stop_rank,blended{more}")?;
    let width = frame.facts.camera.width as usize;
    let pixels = frame.pixels.stop_rank.iter().zip(&frame.pixels.blended);
    for (i, (&stop, blended)) in pixels.enumerate() {
        write!(out, "{},{},{},{blended}", i % width, i / width, rank(stop))?;
        match &frame.fovea {
            Some(f) => {
                let (extra, second) = (f.extra_alpha[i], f.blended_2[i]);
                writeln!(out, ",{},{extra},{second}", rank(f.stop_rank_2[i]))?;
            }
            None => writeln!(out)?,
        }
    }
    Ok(())
}

/// A stop rank; empty for [`NEVER`].
fn rank(stop: u32) -> String {
    if stop == NEVER { String::new() } else { stop.to_string() }
}

fn facts(frame: &Frame, out: &mut dyn Write) -> io::Result<()> {
    let (facts, camera) = (&frame.facts, &frame.facts.camera);
    let mut table = csv::Writer::from_writer(out);
    let mut row = |name: &str, value: &dyn Display| {
        table.write_record([name, &value.to_string()]).map_err(io::Error::other)
    };
    row("name", &"value")?;
    row("id", &format!("{:016x}", frame.id()))?;
    row("view", &camera.name)?;
    row("width_px", &camera.width)?;
    row("height_px", &camera.height)?;
    row("fx_px", &camera.fx)?;
    row("fy_px", &camera.fy)?;
    row("cx_px", &camera.cx)?;
    row("cy_px", &camera.cy)?;
    let rotation = camera.world_to_camera.transpose().to_cols_array();
    for (i, value) in rotation.iter().enumerate() {
        row(&format!("world_to_camera_{}{}", i / 3, i % 3), value)?;
    }
    for (axis, value) in ["x", "y", "z"].iter().zip(camera.centre.to_array()) {
        row(&format!("centre_{axis}_world"), &value)?;
    }
    row("split", &camera.split.map_or("", |s| s.name()))?;
    row("points", &facts.points)?;
    row("sh_degree", &facts.sh_degree.map_or(String::new(), |degree| degree.to_string()))?;
    row("antialiased", &facts.antialiased)?;
    row("survivors", &facts.survivors)?;
    row("visible_splats", &frame.splats.len())?;
    for (channel, value) in ["r", "g", "b"].iter().zip(facts.background) {
        row(&format!("background_{channel}_srgb"), &value)?;
    }
    for (i, channel) in ["r", "g", "b"].iter().enumerate() {
        let mean = facts.mean_linear_rgb.map_or(String::new(), |mean| mean[i].to_string());
        row(&format!("mean_linear_{channel}"), &mean)?;
    }
    let gaze = |i: usize| frame.fovea.as_ref().map_or(String::new(), |f| f.gaze[i].to_string());
    row("gaze_x", &gaze(0))?;
    row("gaze_y", &gaze(1))?;
    let screen = |get: fn(&Screen) -> f64| {
        frame.fovea.as_ref().map_or(String::new(), |f| get(&f.screen).to_string())
    };
    row("screen_fov_deg", &screen(|s| s.fov_deg))?;
    row("screen_pooling_rate", &screen(|s| s.pooling_rate))?;
    table.flush()
}
