// Volume-rendering core: blends splats, front to back, into PIXELS pixels that take turns.
//
// Per splat and pixel: u = a x + b y + u0 and v = c y + v0 for the place of the pixel from the middle
// of the tile, q = u^2 + v^2, alpha = min(opacity 2^-q, 0.99); nothing happens below 1/255. Then keep = T (1 - alpha): below 1e-4 the
// pixel stops and is left as it is, otherwise colour += T alpha colour of the splat and T = keep.
//
// Beats arrive in order: OPEN begins a tile (transmittance 1, colour 0; pixels outside `open_mask`
// count as stopped), SPLAT blends, CLOSE ends it. A beat that does not fit the state is taken and
// does nothing. A splat holds the core for PIXELS cycles, one pixel each. After CLOSE the pipeline
// drains, LATENCY cycles from the acceptance of a CLOSE that follows its splat at once, and the
// pixels leave in order, one a cycle; then comes the next OPEN.
//
// LATENCY is 11 D, where D is 1 + SPLIT: SPLIT puts a register into every operation. `stopped` says
// that no pixel is left; it rises 9 D + 1 cycles behind the one in which the last pixel that stops
// is issued. PIXELS is at least 4, so that a pixel's transmittance is back
// before its next turn, and a power of two; COLUMNS divides it. Reset: no tile, pipeline empty;
// data keep what they had.
// `in_ready` and `out_valid` depend on registers only.
module vrc #(
    parameter int EXP = 5,
    parameter int MAN = 10,
    parameter bit SPLIT = 1'b1,
    parameter int PIXELS = 4,
    parameter int COLUMNS = 2,
    localparam int W = EXP + MAN + 1
) (
    input  logic              clk,
    input  logic              rst_n,
    input  logic              in_valid,
    output logic              in_ready,
    // 0 OPEN, 1 SPLAT, 2 CLOSE.
    input  logic [1:0]        in_op,
    // From the lowest: u0, v0; a, b, c; opacity; red, green, blue.
    input  logic [9*W-1:0]    in_record,
    // Place of the first pixel in the tile, and which pixels are in the image.
    input  logic [3:0]        open_x,
    input  logic [3:0]        open_y,
    input  logic [PIXELS-1:0] open_mask,
    output logic              stopped,
    output logic              out_valid,
    input  logic              out_ready,
    // From the lowest: red, green, blue, transmittance.
    output logic [4*W-1:0]    out_pixel
);
    localparam int D = SPLIT ? 2 : 1;
    localparam int LATENCY = 11 * D;
    localparam int I = $clog2(PIXELS);
    localparam logic [W-1:0] ONE = W'(((1 << (EXP - 1)) - 1) << MAN);
    localparam logic [W-1:0] INFINITE = W'(((1 << EXP) - 1) << MAN);
    // 1/255 and 1e-4 upwards, 0.99 downwards: 24 bits of each.
    localparam logic [W-1:0] ALPHA_MIN = W'(fp_pkg::between(EXP, MAN, -8, 8421504, 1'b1));
    localparam logic [W-1:0] ALPHA_MAX = W'(fp_pkg::between(EXP, MAN, -1, 16609443, 1'b0));
    localparam logic [W-1:0] STOP = W'(fp_pkg::between(EXP, MAN, -14, 13743895, 1'b1));
    localparam logic [1:0] OPEN = 2'd0;
    localparam logic [1:0] SPLAT = 2'd1;
    localparam logic [1:0] CLOSE = 2'd2;
    localparam logic [1:0] CLOSED = 2'd0;
    localparam logic [1:0] BLENDING = 2'd1;
    localparam logic [1:0] DRAINING = 2'd2;
    localparam logic [1:0] LEAVING = 2'd3;

    // --- control ---------------------------------------------------------------------------------

    logic [1:0] state;
    logic [I-1:0] leaving;
    logic [PIXELS-1:0] live;
    // Stage 0 is the issue of a pixel. A slot is its place in the pipeline, `first` that of pixel 0,
    // and `valid` says that something is to be done there.
    logic [LATENCY-1:0] slot;
    logic [9*D-1:0] first;
    logic [LATENCY-1:0] valid;
    logic [I-1:0] issued;
    logic open;
    logic take;
    logic last_issue;
    logic [LATENCY-2:0] goes_on;

    assign last_issue = issued == I'(PIXELS - 1);
    assign in_ready = state == CLOSED || (state == BLENDING && (!slot[0] || last_issue));
    assign open = state == CLOSED && in_valid && in_op == OPEN;
    assign take = in_valid && in_ready && state == BLENDING && in_op == SPLAT;
    assign first[0] = slot[0] && issued == '0;
    assign valid[0] = slot[0] && live[issued];
    assign stopped = state == BLENDING && live == '0;
    assign out_valid = state == LEAVING;

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            state <= CLOSED;
            slot <= '0;
            valid[LATENCY-1:1] <= '0;
            first[9*D-1:1] <= '0;
            issued <= '0;
            leaving <= '0;
        end else begin
            case (state)
                CLOSED: if (open) state <= BLENDING;
                BLENDING: if (in_valid && in_ready && in_op == CLOSE) state <= DRAINING;
                DRAINING: if (slot[LATENCY-2:0] == '0) state <= LEAVING;
                default: begin
                    if (out_ready) begin
                        leaving <= leaving == I'(PIXELS - 1) ? '0 : leaving + 1'b1;
                        if (leaving == I'(PIXELS - 1)) state <= CLOSED;
                    end
                end
            endcase
            slot <= {slot[LATENCY-2:0], take || (slot[0] && !last_issue)};
            first[9*D-1:1] <= first[9*D-2:0];
            valid[LATENCY-1:1] <= valid[LATENCY-2:0] & goes_on;
            if (slot[0]) issued <= last_issue ? '0 : issued + 1'b1;
        end
    end

    // --- the record of a splat, held where it is needed ----------------------------------------

    logic [W-1:0] middle_u_0;
    logic [W-1:0] middle_v_0;
    logic [3*W-1:0] root;
    logic [W-1:0] opacity_0;
    logic [3*W-1:0] tint_0;
    logic [W-1:0] middle_u;
    logic [W-1:0] middle_v;
    logic [W-1:0] opacity;
    logic [3*W-1:0] tint;
    logic [3:0] x;
    logic [3:0] y;

    always_ff @(posedge clk) begin
        if (take) {tint_0, opacity_0, root, middle_v_0, middle_u_0} <= in_record;
        if (open) begin
            x <= open_x;
            y <= open_y;
        end
    end
    vrc_carry #(
        .WIDTH(W), .DELAY(D), .HOLD(PIXELS)
    ) carry_v (
        .clk(clk), .first(first[D-1:0]), .d(middle_v_0), .q(middle_v));
    vrc_carry #(
        .WIDTH(W), .DELAY(2 * D), .HOLD(PIXELS)
    ) carry_u (
        .clk(clk), .first(first[2*D-1:0]), .d(middle_u_0), .q(middle_u));
    vrc_carry #(
        .WIDTH(W), .DELAY(6 * D), .HOLD(PIXELS)
    ) carry_opacity (
        .clk(clk), .first(first[6*D-1:0]), .d(opacity_0), .q(opacity));
    vrc_carry #(
        .WIDTH(3 * W), .DELAY(9 * D), .HOLD(PIXELS)
    ) carry_tint (
        .clk(clk), .first(first), .d(tint_0), .q(tint));

    // --- quadratic form --------------------------------------------------------------------------

    // Places of pixels: -7.5 to 7.5 from the middle of the tile.
    logic [15:0][W-1:0] places;
    for (genvar p = 0; p < 16; p++) begin : g_place
        localparam int TWICE = p < 8 ? 15 - 2 * p : 2 * p - 15;
        assign places[p] = {p < 8, (W - 1)'(fp_pkg::half_of(EXP, MAN, TWICE))};
    end

    logic [3:0] column;
    logic [3:0] row;
    logic [W-1:0] ax, by, cy, sum_u, sum_v, u, v, uu, vv, q;
    assign column = x + 4'(32'(issued) % COLUMNS);
    assign row = y + 4'(32'(issued) / COLUMNS);
    vrc_mul #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) mul_ax (
        .clk(clk), .valid(valid[D-1:0]), .a(root[W-1:0]), .b(places[column]), .y(ax));
    vrc_mul #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) mul_by (
        .clk(clk), .valid(valid[D-1:0]), .a(root[2*W-1:W]), .b(places[row]), .y(by));
    vrc_mul #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) mul_cy (
        .clk(clk), .valid(valid[D-1:0]), .a(root[3*W-1:2*W]), .b(places[row]), .y(cy));
    vrc_add #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) add_ab (
        .clk(clk), .valid(valid[2*D-1:D]), .a(ax), .b(by), .y(sum_u));
    vrc_add #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) add_v (
        .clk(clk), .valid(valid[2*D-1:D]), .a(cy), .b(middle_v), .y(sum_v));
    vrc_add #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) add_u (
        .clk(clk), .valid(valid[3*D-1:2*D]), .a(sum_u), .b(middle_u), .y(u));
    vrc_delay #(.WIDTH(W), .CYCLES(D)) delay_v (
        .clk(clk), .valid(valid[3*D-1:2*D]), .d(sum_v), .q(v));
    vrc_mul #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) mul_uu (
        .clk(clk), .valid(valid[4*D-1:3*D]), .a(u), .b(u), .y(uu));
    vrc_mul #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) mul_vv (
        .clk(clk), .valid(valid[4*D-1:3*D]), .a(v), .b(v), .y(vv));
    vrc_add #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) add_q (
        .clk(clk), .valid(valid[5*D-1:4*D]), .a(uu), .b(vv), .y(q));

    // --- alpha -----------------------------------------------------------------------------------

    logic [W-1:0] power, power_next;
    logic [W-1:0] raw;
    fp_exp #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) exp (
        .clk(clk), .enable(valid[5*D]), .x(q), .y(power_next));
    always_ff @(posedge clk) begin
        if (valid[6*D-1]) power <= power_next;
    end
    vrc_mul #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) mul_alpha (
        .clk(clk), .valid(valid[7*D-1:6*D]), .a(opacity), .b(power), .y(raw));

    // What is negative, NaN or below 1/255 is dropped.
    logic hit;
    logic clamped;
    logic [W-1:0] alpha_now, alpha, rest;
    assign hit = raw >= ALPHA_MIN && raw <= INFINITE;
    assign clamped = raw > ALPHA_MAX;
    assign alpha_now = clamped ? ALPHA_MAX : raw;
    vrc_add #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) add_rest (
        .clk(clk), .valid(valid[8*D-1:7*D] & goes_on[8*D-1:7*D]), .a(ONE),
        .b({1'b1, alpha_now[W-2:0]}), .y(rest));
    vrc_delay #(.WIDTH(W), .CYCLES(D)) delay_alpha (
        .clk(clk), .valid(valid[8*D-1:7*D] & goes_on[8*D-1:7*D]), .d(alpha_now), .q(alpha));

    // --- transmittance ---------------------------------------------------------------------------

    logic [PIXELS-1:0][W-1:0] transmittance;
    logic [I-1:0] read_t, write_t;
    logic is_live;
    logic [W-1:0] keep, weight;
    logic stops;
    vrc_turn #(.PIXELS(PIXELS)) turn_read_t (
        .clk(clk), .rst_n(rst_n), .slot(slot[8*D]), .turn(read_t));
    vrc_turn #(.PIXELS(PIXELS)) turn_write_t (
        .clk(clk), .rst_n(rst_n), .slot(slot[9*D]), .turn(write_t));
    assign is_live = live[read_t];
    vrc_mul #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) mul_keep (
        .clk(clk), .valid(valid[9*D-1:8*D] & goes_on[9*D-1:8*D]), .a(transmittance[read_t]),
        .b(rest), .y(keep));
    vrc_mul #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) mul_weight (
        .clk(clk), .valid(valid[9*D-1:8*D] & goes_on[9*D-1:8*D]), .a(transmittance[read_t]),
        .b(alpha), .y(weight));
    assign stops = keep < STOP;

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            live <= '0;
        end else if (open) begin
            live <= open_mask;
            transmittance <= {PIXELS{ONE}};
        end else if (valid[9*D]) begin
            if (stops) live[write_t] <= 1'b0;
            else transmittance[write_t] <= keep;
        end
    end

    always_comb begin
        goes_on = '1;
        goes_on[7*D] = hit;
        goes_on[8*D] = is_live;
        goes_on[9*D] = !stops;
    end

    // --- colour ----------------------------------------------------------------------------------

    logic [I-1:0] read_c, write_c;
    vrc_turn #(.PIXELS(PIXELS)) turn_read_c (
        .clk(clk), .rst_n(rst_n), .slot(slot[10*D]), .turn(read_c));
    vrc_turn #(.PIXELS(PIXELS)) turn_write_c (
        .clk(clk), .rst_n(rst_n), .slot(slot[11*D-1]), .turn(write_c));
    for (genvar c = 0; c < 3; c++) begin : g_channel
        logic [W-1:0] share;
        vrc_mul #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) mul_share (
            .clk(clk), .valid(valid[10*D-1:9*D] & goes_on[10*D-1:9*D]), .a(weight),
            .b(tint[c*W+:W]), .y(share));
        vrc_channel #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT), .PIXELS(PIXELS)) channel (
            .clk(clk), .clear(open), .valid(valid[11*D-1:10*D]), .read(read_c), .write(write_c),
            .leaving(leaving), .share(share), .colour(out_pixel[c*W+:W]));
    end
    assign out_pixel[3*W+:W] = transmittance[leaving];
endmodule
