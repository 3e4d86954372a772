// Culling and conversion unit: what becomes of Gaussians on their way to the lists of tiles.
//
// Means are culled; shapes are asked for what is kept (in its order) and projected; tiles of splats
// are tested, and coefficients are asked for splats that have any (in their order) and become
// colours. See README.md. OPS is the number of multipliers and adders of the projection: 4, 8, 16
// or 32; culling and colours have fewer of their own. `settings`, `degree` and the sizes may change
// only when the unit is empty. Reset: empty; data keep what they had.
module ccu #(
    parameter int EXP = 8,
    parameter int MAN = 15,
    parameter int TO_EXP = 5,
    parameter int TO_MAN = 10,
    parameter int OPS = 16,
    // Splats that may wait for what is fetched of them: their shapes, and their coefficients.
    parameter int WAITING = 2,
    localparam int W = EXP + MAN + 1,
    localparam int N = TO_EXP + TO_MAN + 1
) (
    input  logic            clk,
    input  logic            rst_n,
    // Eye; rows of the rotation, the first two times a focal length; principal point; limits.
    input  logic [18*W-1:0] settings,
    input  logic [8:0]      tiles_x,
    input  logic [8:0]      tiles_y,
    input  logic [1:0]      degree,
    input  logic            mean_valid,
    output logic            mean_ready,
    input  logic [3*W-1:0]  mean_data,
    // For every mean, whether it is kept.
    output logic            verdict_valid,
    input  logic            verdict_ready,
    output logic            verdict_kept,
    // For every mean that is kept: standard deviations, quaternion, opacity.
    input  logic            shape_valid,
    output logic            shape_ready,
    input  logic [8*W-1:0]  shape_data,
    // Depth; a, b, c; opacity of the splats that have a tile under their square.
    output logic            splat_valid,
    input  logic            splat_ready,
    output logic [5*N-1:0]  splat_data,
    // The same as whole numbers: mean in 1/256 pixel, two of 24 bits; a, b, c in 2^-16, three of 19.
    output logic [104:0]    splat_form,
    // For every shape, in their order: a splat has a tile under its square, and its depth; or it has
    // none.
    output logic            seen,
    output logic [N-1:0]    seen_depth,
    output logic            dropped,
    // No splat is on its way through the tiles.
    output logic            tiles_idle,
    output logic            pair_valid,
    input  logic            pair_ready,
    output logic [7:0]      pair_splat,
    output logic [8:0]      pair_x,
    output logic [8:0]      pair_y,
    output logic [3:0]      pair_subtiles,
    output logic [N-1:0]    pair_u,
    output logic [N-1:0]    pair_v,
    // For every such splat: three channels of 16 coefficients; then its colour.
    input  logic            coefficients_valid,
    output logic            coefficients_ready,
    input  logic [48*N-1:0] coefficients_data,
    output logic            colour_valid,
    input  logic            colour_ready,
    output logic [3*N-1:0]  colour_data
);
    localparam int I = OPS == 4 ? 0 : OPS == 8 ? 1 : OPS == 16 ? 2 : 3;
    localparam logic [W-2:0] INFINITE = {{EXP{1'b1}}, {MAN{1'b0}}};

    // --- culling ---------------------------------------------------------------------------------

    logic cull_valid;
    logic cull_ready;
    logic [5*W-1:0] cull_data;
    logic [W-1:0] difference;
    ccu_engine #(
        .EXP(EXP), .MAN(MAN), .INPUTS(3), .SETTINGS(18), .OUTPUTS(5),
        .MULS(32'(ccu_program_pkg::CULL_MULS[I*16+:16])),
        .ADDS(32'(ccu_program_pkg::CULL_ADDS[I*16+:16])),
        .SPECIALS(32'(ccu_program_pkg::CULL_SPECIALS[I*16+:16])),
        .REGISTERS(32'(ccu_program_pkg::CULL_REGISTERS[I*16+:16])),
        .LITERALS(32'(ccu_program_pkg::CULL_LITERALS[I*16+:16])),
        .STEPS(32'(ccu_program_pkg::CULL_STEPS[I*16+:16])),
        .STAGES(32'(ccu_program_pkg::CULL_STAGES[I*16+:16])),
        .MODES(32'(ccu_program_pkg::CULL_MODES[I*16+:16])),
        .OPERATIONS_BITS(ccu_program_pkg::CULL_OPERATIONS_BITS),
        .WRITES_BITS(ccu_program_pkg::CULL_WRITES_BITS),
        .RESULTS_BITS(ccu_program_pkg::CULL_RESULTS_BITS),
        .LAPS_BITS(ccu_program_pkg::CULL_LAPS_BITS),
        .LITERAL(ccu_program_pkg::CULL_LITERAL),
        .OPERATIONS(OPS == 4 ? ccu_program_pkg::CULL_OPERATIONS_4
            : OPS == 8 ? ccu_program_pkg::CULL_OPERATIONS_8
            : OPS == 16 ? ccu_program_pkg::CULL_OPERATIONS_16
            : ccu_program_pkg::CULL_OPERATIONS_32),
        .WRITES(OPS == 4 ? ccu_program_pkg::CULL_WRITES_4
            : OPS == 8 ? ccu_program_pkg::CULL_WRITES_8
            : OPS == 16 ? ccu_program_pkg::CULL_WRITES_16
            : ccu_program_pkg::CULL_WRITES_32),
        .RESULTS(OPS == 4 ? ccu_program_pkg::CULL_RESULTS_4
            : OPS == 8 ? ccu_program_pkg::CULL_RESULTS_8
            : OPS == 16 ? ccu_program_pkg::CULL_RESULTS_16
            : ccu_program_pkg::CULL_RESULTS_32),
        .LAPS(OPS == 4 ? ccu_program_pkg::CULL_LAPS_4
            : OPS == 8 ? ccu_program_pkg::CULL_LAPS_8
            : OPS == 16 ? ccu_program_pkg::CULL_LAPS_16
            : ccu_program_pkg::CULL_LAPS_32)
    ) cull (
        .clk(clk), .rst_n(rst_n), .mode(2'd0), .settings(settings),
        .in_valid(mean_valid), .in_ready(mean_ready), .in_data(mean_data),
        .late_valid(1'b0), .late_ready(no_late[0]), .late_data({W{1'b0}}),
        .out_valid(cull_valid), .out_ready(cull_ready), .out_data(cull_data));

    // Kept is what is less than zero: the near plane less the depth.
    logic keeps;
    logic place_in_ready;
    logic place_valid;
    logic place_ready;
    logic [4*W-1:0] place_data;
    logic [1:0] no_late;
    assign difference = cull_data[4*W+:W];
    assign keeps = difference[W-1] && difference[W-2:0] <= INFINITE;
    assign verdict_kept = keeps;
    assign verdict_valid = cull_valid && (!keeps || place_in_ready);
    assign cull_ready = verdict_ready && (!keeps || place_in_ready);
    fifo #(
        .WIDTH(4 * W), .DEPTH(WAITING)
    ) places (
        .clk(clk), .rst_n(rst_n), .in_valid(cull_valid && keeps && verdict_ready),
        .in_ready(place_in_ready), .in_data(cull_data[4*W-1:0]), .out_valid(place_valid),
        .out_ready(place_ready), .out_data(place_data));

    // --- projection ------------------------------------------------------------------------------

    logic project_ready;
    logic projected_valid;
    logic projected_ready;
    logic [17*W-1:0] projected_data;
    assign shape_ready = project_ready;
    assign place_ready = project_ready;
    ccu_engine #(
        .EXP(EXP), .MAN(MAN), .INPUTS(12), .SETTINGS(18), .OUTPUTS(17),
        .MULS(32'(ccu_program_pkg::PROJECT_MULS[I*16+:16])),
        .ADDS(32'(ccu_program_pkg::PROJECT_ADDS[I*16+:16])),
        .SPECIALS(32'(ccu_program_pkg::PROJECT_SPECIALS[I*16+:16])),
        .REGISTERS(32'(ccu_program_pkg::PROJECT_REGISTERS[I*16+:16])),
        .LITERALS(32'(ccu_program_pkg::PROJECT_LITERALS[I*16+:16])),
        .STEPS(32'(ccu_program_pkg::PROJECT_STEPS[I*16+:16])),
        .STAGES(32'(ccu_program_pkg::PROJECT_STAGES[I*16+:16])),
        .MODES(32'(ccu_program_pkg::PROJECT_MODES[I*16+:16])),
        .OPERATIONS_BITS(ccu_program_pkg::PROJECT_OPERATIONS_BITS),
        .WRITES_BITS(ccu_program_pkg::PROJECT_WRITES_BITS),
        .RESULTS_BITS(ccu_program_pkg::PROJECT_RESULTS_BITS),
        .LAPS_BITS(ccu_program_pkg::PROJECT_LAPS_BITS),
        .LITERAL(ccu_program_pkg::PROJECT_LITERAL),
        .OPERATIONS(OPS == 4 ? ccu_program_pkg::PROJECT_OPERATIONS_4
            : OPS == 8 ? ccu_program_pkg::PROJECT_OPERATIONS_8
            : OPS == 16 ? ccu_program_pkg::PROJECT_OPERATIONS_16
            : ccu_program_pkg::PROJECT_OPERATIONS_32),
        .WRITES(OPS == 4 ? ccu_program_pkg::PROJECT_WRITES_4
            : OPS == 8 ? ccu_program_pkg::PROJECT_WRITES_8
            : OPS == 16 ? ccu_program_pkg::PROJECT_WRITES_16
            : ccu_program_pkg::PROJECT_WRITES_32),
        .RESULTS(OPS == 4 ? ccu_program_pkg::PROJECT_RESULTS_4
            : OPS == 8 ? ccu_program_pkg::PROJECT_RESULTS_8
            : OPS == 16 ? ccu_program_pkg::PROJECT_RESULTS_16
            : ccu_program_pkg::PROJECT_RESULTS_32),
        .LAPS(OPS == 4 ? ccu_program_pkg::PROJECT_LAPS_4
            : OPS == 8 ? ccu_program_pkg::PROJECT_LAPS_8
            : OPS == 16 ? ccu_program_pkg::PROJECT_LAPS_16
            : ccu_program_pkg::PROJECT_LAPS_32)
    ) project (
        .clk(clk), .rst_n(rst_n), .mode(2'd0), .settings(settings),
        .in_valid(place_valid && shape_valid), .in_ready(project_ready),
        .in_data({shape_data, place_data}),
        .late_valid(1'b0), .late_ready(no_late[1]), .late_data({W{1'b0}}),
        .out_valid(projected_valid), .out_ready(projected_ready), .out_data(projected_data));

    // --- tiles -----------------------------------------------------------------------------------

    logic tested_valid;
    logic record_ready;
    logic direction_in_ready;
    logic direction_valid;
    logic direction_ready;
    logic [3*N-1:0] direction_data;
    logic [8*N-1:0] tested_data;
    logic [104:0] tested_form;
    ccu_tiles #(
        .EXP(EXP), .MAN(MAN), .TO_EXP(TO_EXP), .TO_MAN(TO_MAN)
    ) tiles (
        .clk(clk), .rst_n(rst_n), .tiles_x(tiles_x), .tiles_y(tiles_y),
        .in_valid(projected_valid), .in_ready(projected_ready), .in_data(projected_data),
        .splat_valid(tested_valid), .splat_ready(record_ready && direction_in_ready),
        .splat_data(tested_data), .splat_form(tested_form), .dropped(dropped),
        .idle(tiles_idle), .pair_valid(pair_valid), .pair_ready(pair_ready),
        .pair_splat(pair_splat), .pair_x(pair_x), .pair_y(pair_y), .pair_subtiles(pair_subtiles),
        .pair_u(pair_u), .pair_v(pair_v));
    assign seen = tested_valid && record_ready && direction_in_ready;
    assign seen_depth = tested_data[N-1:0];
    fifo #(
        .WIDTH(105 + 5 * N), .DEPTH(WAITING)
    ) records (
        .clk(clk), .rst_n(rst_n), .in_valid(tested_valid && direction_in_ready),
        .in_ready(record_ready), .in_data({tested_form, tested_data[5*N-1:0]}),
        .out_valid(splat_valid), .out_ready(splat_ready), .out_data({splat_form, splat_data}));
    fifo #(
        .WIDTH(3 * N), .DEPTH(WAITING + 2)
    ) directions (
        .clk(clk), .rst_n(rst_n), .in_valid(tested_valid && record_ready),
        .in_ready(direction_in_ready), .in_data(tested_data[8*N-1:5*N]),
        .out_valid(direction_valid), .out_ready(direction_ready), .out_data(direction_data));

    // --- colours ---------------------------------------------------------------------------------

    ccu_engine #(
        .EXP(TO_EXP), .MAN(TO_MAN), .INPUTS(3), .LATE(48), .OUTPUTS(3),
        .MULS(32'(ccu_program_pkg::COLOUR_MULS[I*16+:16])),
        .ADDS(32'(ccu_program_pkg::COLOUR_ADDS[I*16+:16])),
        .SPECIALS(32'(ccu_program_pkg::COLOUR_SPECIALS[I*16+:16])),
        .REGISTERS(32'(ccu_program_pkg::COLOUR_REGISTERS[I*16+:16])),
        .LITERALS(32'(ccu_program_pkg::COLOUR_LITERALS[I*16+:16])),
        .STEPS(32'(ccu_program_pkg::COLOUR_STEPS[I*16+:16])),
        .STAGES(32'(ccu_program_pkg::COLOUR_STAGES[I*16+:16])),
        .MODES(32'(ccu_program_pkg::COLOUR_MODES[I*16+:16])),
        .OPERATIONS_BITS(ccu_program_pkg::COLOUR_OPERATIONS_BITS),
        .WRITES_BITS(ccu_program_pkg::COLOUR_WRITES_BITS),
        .RESULTS_BITS(ccu_program_pkg::COLOUR_RESULTS_BITS),
        .LAPS_BITS(ccu_program_pkg::COLOUR_LAPS_BITS),
        .LITERAL(ccu_program_pkg::COLOUR_LITERAL),
        .OPERATIONS(OPS == 4 ? ccu_program_pkg::COLOUR_OPERATIONS_4
            : OPS == 8 ? ccu_program_pkg::COLOUR_OPERATIONS_8
            : OPS == 16 ? ccu_program_pkg::COLOUR_OPERATIONS_16
            : ccu_program_pkg::COLOUR_OPERATIONS_32),
        .WRITES(OPS == 4 ? ccu_program_pkg::COLOUR_WRITES_4
            : OPS == 8 ? ccu_program_pkg::COLOUR_WRITES_8
            : OPS == 16 ? ccu_program_pkg::COLOUR_WRITES_16
            : ccu_program_pkg::COLOUR_WRITES_32),
        .RESULTS(OPS == 4 ? ccu_program_pkg::COLOUR_RESULTS_4
            : OPS == 8 ? ccu_program_pkg::COLOUR_RESULTS_8
            : OPS == 16 ? ccu_program_pkg::COLOUR_RESULTS_16
            : ccu_program_pkg::COLOUR_RESULTS_32),
        .LAPS(OPS == 4 ? ccu_program_pkg::COLOUR_LAPS_4
            : OPS == 8 ? ccu_program_pkg::COLOUR_LAPS_8
            : OPS == 16 ? ccu_program_pkg::COLOUR_LAPS_16
            : ccu_program_pkg::COLOUR_LAPS_32)
    ) colours (
        .clk(clk), .rst_n(rst_n), .mode(degree), .settings({N{1'b0}}),
        .in_valid(direction_valid), .in_ready(direction_ready), .in_data(direction_data),
        .late_valid(coefficients_valid), .late_ready(coefficients_ready),
        .late_data(coefficients_data),
        .out_valid(colour_valid), .out_ready(colour_ready), .out_data(colour_data));

    logic unused;
    assign unused = &{1'b0, no_late};
endmodule
