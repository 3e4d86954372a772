// A data-flow graph folded over a few operators by a schedule (ccu_program_pkg).
//
// Laps of a fixed number of steps follow each other. Work that is offered when a lap begins enters
// with it, is read from the port during the lap, and is taken at its end. An operation reads its
// operands in its step, and its result is in a register three cycles later; each stage of the
// schedule is a lap behind the one before. Late inputs are read during a lap of their own, and
// taken at its end. Outputs are offered in one step of a lap.
//
// `step` is false where outputs are not taken or late inputs are not there: then nothing moves. A
// port's ready depends on the ready and valid of other ports, not on its own valid. `mode` may
// change only when no work is in the unit. Reset: no work; data keep what they had.
module ccu_engine #(
    parameter int EXP = 8,
    parameter int MAN = 15,
    parameter int INPUTS = 1,
    // 0 for none, as SETTINGS.
    parameter int LATE = 0,
    parameter int SETTINGS = 0,
    parameter int OUTPUTS = 1,
    parameter int MULS = 1,
    parameter int ADDS = 1,
    parameter int SPECIALS = 0,
    parameter int REGISTERS = 1,
    parameter int LITERALS = 1,
    parameter int STEPS = 2,
    parameter int STAGES = 1,
    parameter int MODES = 1,
    parameter int OPERATIONS_BITS = 40,
    parameter int WRITES_BITS = 16,
    parameter int RESULTS_BITS = 12,
    parameter int LAPS_BITS = 40,
    parameter logic [32*LITERALS-1:0] LITERAL = '0,
    parameter logic [OPERATIONS_BITS-1:0] OPERATIONS = '0,
    parameter logic [WRITES_BITS-1:0] WRITES = '0,
    parameter logic [RESULTS_BITS-1:0] RESULTS = '0,
    parameter logic [LAPS_BITS-1:0] LAPS = '0,
    localparam int W = EXP + MAN + 1,
    localparam int LATE_PORT = LATE > 0 ? LATE : 1,
    localparam int SETTINGS_PORT = SETTINGS > 0 ? SETTINGS : 1
) (
    input  logic                       clk,
    input  logic                       rst_n,
    input  logic [1:0]                 mode,
    input  logic [SETTINGS_PORT*W-1:0] settings,
    input  logic                       in_valid,
    output logic                       in_ready,
    input  logic [INPUTS*W-1:0]        in_data,
    input  logic                       late_valid,
    output logic                       late_ready,
    input  logic [LATE_PORT*W-1:0]     late_data,
    output logic                       out_valid,
    input  logic                       out_ready,
    output logic [OUTPUTS*W-1:0]       out_data
);
    localparam int LANES = MULS + ADDS + SPECIALS;
    localparam int SOURCES = REGISTERS + INPUTS + LATE + SETTINGS + LITERALS + LANES;
    localparam int PW = STEPS > 1 ? $clog2(STEPS) : 1;
    localparam int SW = STAGES > 1 ? $clog2(STAGES) : 1;

    // --- laps ------------------------------------------------------------------------------------

    logic [3:0][PW-1:0] firsts;
    logic [3:0][PW-1:0] lasts;
    logic [3:0][PW-1:0] leave_steps;
    logic [3:0][SW-1:0] leave_stages;
    logic [3:0][SW-1:0] late_stages;
    for (genvar m = 0; m < 4; m++) begin : g_mode
        localparam int M = m < MODES ? m : 0;
        assign firsts[m] = PW'(LAPS[M*40+:8]);
        assign lasts[m] = PW'(LAPS[M*40+8+:8]);
        assign leave_steps[m] = PW'(LAPS[M*40+16+:8]);
        assign leave_stages[m] = SW'(LAPS[M*40+24+:8]);
        assign late_stages[m] = SW'(LAPS[M*40+32+:8]);
    end

    logic [PW-1:0] now;
    logic [PW-1:0] next;
    logic started;
    logic entered;
    logic [STAGES-1:0] older;
    logic [STAGES-1:0] live;
    logic is_first;
    logic is_last;
    logic step;
    logic late_missing;
    // After reset the first lap begins where the mode says.
    assign next = started ? now : firsts[mode];
    assign is_first = next == firsts[mode];
    assign is_last = next == lasts[mode];
    always_comb begin
        live = older;
        live[0] = is_first ? in_valid : entered;
    end
    if (LATE > 0) begin : g_late
        assign late_missing = live[late_stages[mode]] && !late_valid;
        assign late_ready = step && is_last && live[late_stages[mode]];
    end else begin : g_no_late
        logic unused;
        assign late_missing = 1'b0;
        assign late_ready = 1'b0;
        assign unused = &{1'b0, late_valid, late_stages, late_data};
    end
    assign out_valid = next == leave_steps[mode] && live[leave_stages[mode]] && !late_missing;
    assign step = !late_missing && !(out_valid && !out_ready);
    assign in_ready = step && is_last && entered;

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            started <= 1'b0;
            entered <= 1'b0;
            older <= '0;
        end else if (step) begin
            started <= 1'b1;
            now <= is_last ? firsts[mode] : next + 1'b1;
            entered <= live[0] && !is_last;
            if (is_last) older <= live << 1;
        end
    end

    // --- where numbers are -----------------------------------------------------------------------

    logic [SOURCES*W-1:0] numbers;
    logic [REGISTERS*W-1:0] registers;
    logic [LANES*W-1:0] results;
    assign numbers[REGISTERS*W-1:0] = registers;
    assign numbers[REGISTERS*W+:INPUTS*W] = in_data;
    if (LATE > 0) begin : g_late_numbers
        assign numbers[(REGISTERS+INPUTS)*W+:LATE_PORT*W] = late_data;
    end
    if (SETTINGS > 0) begin : g_settings
        assign numbers[(REGISTERS+INPUTS+LATE)*W+:SETTINGS_PORT*W] = settings;
    end else begin : g_no_settings
        logic unused;
        assign unused = &{1'b0, settings};
    end
    for (genvar i = 0; i < LITERALS; i++) begin : g_literal
        localparam logic [31:0] BITS = fp_pkg::of_single(EXP, MAN, LITERAL[i*32+:32]);
        assign numbers[(REGISTERS+INPUTS+LATE+SETTINGS+i)*W+:W] = BITS[W-1:0];
    end
    assign numbers[SOURCES*W-1-:LANES*W] = results;

    // --- operators -------------------------------------------------------------------------------

    for (genvar l = 0; l < LANES; l++) begin : g_lane
        logic [STEPS*(2*W+4)-1:0] words;
        logic [W-1:0] from_a;
        logic [W-1:0] from_b;
        logic from_c;
        logic [1:0] code_now;
        logic reads;
        for (genvar p = 0; p < STEPS; p++) begin : g_step
            localparam logic [39:0] WORD = OPERATIONS[(l*STEPS+p)*40+:40];
            localparam int A = 32'(WORD[8:0]);
            localparam int B = 32'(WORD[19:11]);
            localparam int C = 32'(WORD[30:22]);
            localparam int STAGE = WORD[38] ? 32'(WORD[37:33]) : 0;
            assign words[p*(2*W+4)+:2*W+4] = {
                WORD[38] && live[STAGE], WORD[32:31], numbers[C*W+W-1],
                (numbers[B*W+W-1] && !WORD[20]) ^ WORD[21], numbers[B*W+:W-1],
                (numbers[A*W+W-1] && !WORD[9]) ^ WORD[10], numbers[A*W+:W-1]
            };
        end
        ccu_choose #(
            .WIDTH(2 * W + 4), .COUNT(STEPS)
        ) choose (
            .words(words), .index(next), .y({reads, code_now, from_c, from_b, from_a}));

        logic [W-1:0] a;
        logic [W-1:0] b;
        logic busy;
        logic enable;
        assign enable = busy && step;
        always_ff @(posedge clk) begin
            if (!rst_n) busy <= 1'b0;
            else if (step) busy <= reads;
        end
        if (l < MULS) begin : g_mul
            logic unused;
            assign unused = &{1'b0, from_c, code_now};
            always_ff @(posedge clk) begin
                if (step && reads) begin
                    a <= from_a;
                    b <= from_b;
                end
            end
            fp_mul #(
                .EXP(EXP), .MAN(MAN), .SPLIT(1'b1)
            ) mul (
                .clk(clk), .enable(enable), .a(a), .b(b), .y(results[l*W+:W]));
        end else if (l < MULS + ADDS) begin : g_add
            logic [1:0] code;
            logic negative;
            always_ff @(posedge clk) begin
                if (step && reads) begin
                    a <= from_a;
                    b <= from_b;
                    negative <= from_c;
                    code <= code_now;
                end
            end
            ccu_adder #(
                .EXP(EXP), .MAN(MAN)
            ) adder (
                .clk(clk), .enable(enable), .code(code), .negative(negative), .a(a), .b(b),
                .y(results[l*W+:W]));
        end else begin : g_special
            logic root;
            logic unused;
            assign unused = &{1'b0, from_b, from_c, code_now, b};
            assign b = '0;
            always_ff @(posedge clk) begin
                if (step && reads) begin
                    a <= from_a;
                    root <= code_now[0];
                end
            end
            fp_special #(
                .EXP(EXP), .MAN(MAN), .SPLIT(1'b1)
            ) special (
                .clk(clk), .enable(enable), .root(root), .a(a), .y(results[l*W+:W]));
        end
    end

    // --- registers -------------------------------------------------------------------------------

    for (genvar r = 0; r < REGISTERS; r++) begin : g_register
        logic [STEPS*(W+1)-1:0] words;
        logic [W-1:0] from;
        logic written;
        for (genvar p = 0; p < STEPS; p++) begin : g_step
            localparam logic [15:0] WORD = WRITES[(r*STEPS+p)*16+:16];
            localparam int FROM = 32'(WORD[8:0]);
            localparam int STAGE = WORD[14] ? 32'(WORD[13:9]) : 0;
            assign words[p*(W+1)+:W+1] = {WORD[14] && live[STAGE], numbers[FROM*W+:W]};
        end
        ccu_choose #(
            .WIDTH(W + 1), .COUNT(STEPS)
        ) choose (
            .words(words), .index(next), .y({written, from}));
        always_ff @(posedge clk) begin
            if (step && written) registers[r*W+:W] <= from;
        end
    end

    // --- outputs ---------------------------------------------------------------------------------

    for (genvar o = 0; o < OUTPUTS; o++) begin : g_output
        logic [4*W-1:0] from;
        for (genvar m = 0; m < 4; m++) begin : g_mode
            localparam int M = m < MODES ? m : 0;
            localparam int FROM = 32'(RESULTS[(M*OUTPUTS+o)*12+:12]);
            assign from[m*W+:W] = numbers[FROM*W+:W];
        end
        ccu_choose #(
            .WIDTH(W), .COUNT(4)
        ) choose (
            .words(from), .index(mode), .y(out_data[o*W+:W]));
    end

    logic unused_numbers;
    assign unused_numbers = &{1'b0, numbers};
endmodule
