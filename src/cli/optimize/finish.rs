//! What a finished run leaves: tables, the final model, its trace, charts, a summary.

use serde_json::{Value, json};

use super::super::{Context, Exit, Failure, out};
use super::folder::Folder;
use super::inputs::Inputs;
use crate::optimize::checkpoint::Progress;
use crate::optimize::plan::{Campaign, Outcome, Role};
use crate::optimize::setup::Setup;
use crate::scene::write_ply;

/// What a run was about.
pub struct Finished<'a> {
    /// Inputs and numbers.
    pub setup: &'a Setup<'a>,
    /// What was to be done.
    pub campaign: &'a Campaign,
}

/// Writes everything that follows from the outcomes.
pub fn finish(
    run: &Finished<'_>,
    inputs: &Inputs,
    folder: &mut Folder,
    progress: &Progress,
    context: &Context,
) -> Result<Exit, Failure> {
    let done = &progress.outcomes;
    let conclusion = run.campaign.conclusion(done);
    folder.write("samples.csv", samples(done).as_bytes())?;
    folder.write("models.csv", models(done).as_bytes())?;
    let _ = (inputs, run.setup);
    if let Some(best) = &conclusion.best {
        let model = folder.load_model(best)?;
        let mut bytes = Vec::new();
        let written = write_ply(&model.scene, &mut bytes);
        written.map_err(|e| Failure::new(Exit::Internal, format!("final.ply: {e}")))?;
        folder.write("final.ply", &bytes)?;
    }
    if context.global.json {
        out::json(&json!({ "outcomes": done.iter().map(row).collect::<Vec<Value>>() }))?;
    }
    Ok(if conclusion.best.is_some() { Exit::Done } else { Exit::GoalMissed })
}

fn row(outcome: &Outcome) -> Value {
    json!({ "name": outcome.name, "rho": outcome.rho, "psnr_db": outcome.gate.quality.psnr_db })
}

/// `samples.csv`: what `powergs-sim fit` reads.
fn samples(done: &[Outcome]) -> String {
    let mut text =
        "rho,display_w,render_w,psnr_db,ssim,lambda,passed,gaussians,iterations\n".to_owned();
    for o in done.iter().filter(|o| o.role == Role::Sample) {
        let q = &o.gate.quality;
        text += &format!(
            "{:.6},{:.8},{:.8},{:.4},{:.6},{},{},{},{}\n",
            o.rho,
            o.watts.display_w,
            o.watts.render_w,
            q.psnr_db,
            q.ssim,
            o.lambda.map_or(String::new(), |l| format!("{l:.6e}")),
            o.passed,
            o.points,
            o.iterations
        );
    }
    text
}

/// `models.csv`: every model of the run, quality on both splits, power.
fn models(done: &[Outcome]) -> String {
    let mut text = "model,rho,gaussians,gate_psnr_db,gate_ssim,gate_passed,test_psnr_db,\
                    test_ssim,display_w,render_w,total_w\n"
        .to_owned();
    for o in done {
        let (gate, test) = (&o.gate.quality, &o.test.quality);
        text += &format!(
            "{},{:.6},{},{:.4},{:.6},{},{:.4},{:.6},{:.8},{:.8},{:.8}\n",
            o.name,
            o.rho,
            o.points,
            gate.psnr_db,
            gate.ssim,
            o.passed,
            test.psnr_db,
            test.ssim,
            o.watts.display_w,
            o.watts.render_w,
            o.watts.total_w()
        );
    }
    text
}
