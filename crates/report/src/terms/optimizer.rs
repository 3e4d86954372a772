//! The optimiser.

use super::{Term, term};

pub(super) const OPTIMIZER: &[Term] = &[
    term(
        &["rho", "ρ", "pruned", "pruned, %", "pruned share"],
        "",
        "Share of the Gaussians of the dense model that has been pruned, 0 to 1.",
    ),
    term(
        &["lambda", "λ", "lambda_per_w"],
        "1/W",
        "Weight of the display power in the loss of a fine-tune; a controller raises it until the \
         quality is just above the target.",
    ),
    term(
        &["gain_red", "gain_green", "gain_blue"],
        "",
        "What a colour channel of a model was scaled by, 0 to 1, to spend on the display what it \
         had above its target.",
    ),
    term(
        &["saved, %"],
        "%",
        "Share of the power of the dense model, display and accelerator, that a model does not \
         need.",
    ),
    term(
        &["quality"],
        "",
        "The target that a model was made for: H, M or L, or a share or decibels as they were \
         asked for.",
    ),
    term(
        &["mostly"],
        "",
        "The largest part of the power of a model: display, rendering or standby.",
    ),
    term(
        &["used up"],
        "",
        "Which way to save has nothing left at this quality: pruning where no model that passes \
         is pruned further and one that is misses the target, dimming where no quality is left \
         above the target.",
    ),
    term(
        &["next saves"],
        "%",
        "What the cheapest model of the run that reaches the next lower quality takes less; where \
         that quality was not asked for, a search for it saves more.",
    ),
    term(&["dense"], "", "The model as it was given."),
    term(
        &["held-out"],
        "",
        "The dense model trained on without the views that decide on quality: they are then not \
         known from training, and a target that is a share means a share of this one.",
    ),
    term(
        &["sample"],
        "",
        "A pruned model that is fine-tuned until it reaches the target at one ρ.",
    ),
    term(
        &["gate", "gate views", "gate, dB"],
        "",
        "Views that decide whether a model meets the target; λ follows them.",
    ),
    term(
        &["test", "test views", "test, dB"],
        "",
        "Views that are only reported: nothing is selected or trained on them.",
    ),
    term(
        &["gate PSNR", "gate_psnr_db", "test PSNR", "test_psnr_db", "psnr_db", "PSNR"],
        "dB",
        "Peak signal-to-noise ratio against the reference, over the views that the name says.",
    ),
    term(
        &["gate SSIM", "gate_ssim", "test SSIM", "test_ssim", "ssim"],
        "",
        "Structural similarity against the reference, 1 for equal pictures, over the views that \
         the name says.",
    ),
    term(
        &["FLIP", "test FLIP", "flip_test"],
        "",
        "Difference as an observer sees it who alternates between both pictures, 0 to 1; small \
         is good.",
    ),
    term(
        &["LPIPS", "test LPIPS", "lpips_test"],
        "",
        "Perceptual distance by a trained network, whose weights you bring; small is good.",
    ),
    term(
        &[
            "HVSQ",
            "HVSQ of L1 to L4",
            "target_hvsq",
            "test_hvsq",
            "hvsq_l1",
            "hvsq_l2",
            "hvsq_l3",
            "hvsq_l4",
            "hvsq_r1",
            "hvsq_r2",
            "hvsq_r3",
            "hvsq_r4",
        ],
        "",
        "Difference in the periphery of sight: of means and variances in pools that grow with \
         eccentricity; small is good.",
    ),
    term(
        &["model"],
        "",
        "A model of the run, with the name that it has in charts, tables and files.",
    ),
    term(
        &[
            "Gaussians",
            "Gaussians of L1 to L4",
            "survivors",
            "gaussians_l1",
            "gaussians_l2",
            "gaussians_l3",
            "gaussians_l4",
        ],
        "",
        "How many Gaussians the model, or a level of it, has left.",
    ),
    term(
        &["lost, dB", "dense, dB"],
        "dB",
        "PSNR of the dense model in a view, and how much of it the result lost there.",
    ),
    term(&["split"], "", "Whether a view decides on quality (gate) or is only reported (test)."),
    term(
        &["accelerator"],
        "W",
        "What the accelerator draws at the display rate: rendering, and standby, which it draws \
         whatever it renders.",
    ),
    term(&["passed", "gate_passed"], "", "Whether the gate views meet the target."),
    term(
        &["render", "render_w", "R"],
        "W",
        "Power of the accelerator at the display rate, standby included: mean over the views of \
         the power.",
    ),
    term(
        &["display_w", "D", "gate_display_w"],
        "W",
        "Display power, mean over the views of the power.",
    ),
    term(
        &["display_spent_w"],
        "W",
        "Display power that the curve is fitted to: that of a sample with all quality above the \
         target spent on the display.",
    ),
    term(&["total_w", "ours_w", "result_w"], "W", "Accelerator and display power together."),
    term(&["display_to_render"], "", "Display power over accelerator power of the dense model."),
    term(&["display_scale"], "", "Factor on the power of the panel."),
    term(
        &["saved_over_render_only", "saved_over_display_only", "saved_over_dense"],
        "",
        "Share of the total power that is saved against that model.",
    ),
    term(&["job"], "", "A part of a run: dense, held-out, a sample, the final model, a baseline."),
    term(&["role of a model", "source"], "", "What a model is in the run, or where it came from."),
    term(
        &["iteration", "iterations"],
        "",
        "Optimisation steps of a fine-tune; one training view each.",
    ),
    term(&["kept_at"], "", "Iteration of the fine-tune that the kept model is from."),
    term(&["view"], "", "The view: its name or its number."),
    term(
        &["loss", "l1"],
        "",
        "0.8 L1 + 0.2 (1 - SSIM) + λ P_display of the training view; `l1` is its first part.",
    ),
    term(&["gate_hvsq"], "", "HVSQ of the gate views."),
    term(
        &["method"],
        "",
        "How the foveated frames were made: ours, or one of the methods compared.",
    ),
    term(&["variant"], "", "The quality target of the row: H, M or L."),
    term(
        &["level"],
        "",
        "A level of a foveated model: 1 for the fovea to 4 for the far periphery.",
    ),
    term(&["foveated"], "", "The foveated model or method of the row."),
    term(
        &["of that filter", "filter_w"],
        "W",
        "The part of the power that the D22 colour filter takes.",
    ),
    term(&["target"], "", "What was asked for."),
    term(
        &["claim", "published", "expected", "here", "agrees"],
        "",
        "A statement of the PowerGS publication, its number there, what has to come out here, the \
         number of this run, and whether it agrees.",
    ),
    term(&["fovea"], "", "The part of sight around the gaze that sees sharply."),
    term(
        &["gaze"],
        "",
        "Where the viewer looks, as shares of width and height from the upper left corner.",
    ),
    term(
        &["D22"],
        "",
        "The colour filter of Duinkharjav et al. 2022: cheaper colours outside of the fovea.",
    ),
];
