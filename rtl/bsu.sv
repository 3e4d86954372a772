// Bitonic Sorting Unit: sorts rows of 16 entries, and merges two sorted lists a row at a time.
//
// A row that enters at `sort_*` leaves sorted. A list that enters at `a_*` and one that enters at
// `b_*`, both rows of 16 in ascending order with `last` at their last row, leave as one sorted list
// of as many rows. Both ways share ranks 2 to 4 and the last four of the ten stages:
//
//   sort_row -> stages 1-3 -> rank 1 -> stages 4-6 -+
//   a_row -> window -+                              +-> rank 2 -> 7, 8 -> rank 3 -> 9, 10 -> rank 4
//   b_row -> window -+-> 16 selectors --------------+
//
// The selectors take the 16 smallest entries of both windows: head i of one list meets head 15 - i
// of the other, as in a half-cleaner of 32 inputs of which one half is kept. What they take is a
// bitonic row in rotation, which stages 7 to 10 sort. Entries are compared whole as unsigned
// numbers, so ties of a key are decided by what stands below it. Unused places of a list's last row
// are filled with ones.
//
// Interval 1 row, latency 4, for either way; a row to be sorted goes before a row to be merged.
// Reset: no row inside; data are not reset. No `ready` depends on a `valid` of the same cycle;
// `a_ready` and `b_ready` come behind the comparisons of the selectors.
module bsu #(
    parameter int unsigned ENTRY = 32
) (
    input  logic                clk,
    input  logic                rst_n,
    input  logic                sort_valid,
    output logic                sort_ready,
    input  logic [16*ENTRY-1:0] sort_row,
    input  logic                a_valid,
    output logic                a_ready,
    input  logic                a_last,
    input  logic [16*ENTRY-1:0] a_row,
    input  logic                b_valid,
    output logic                b_ready,
    input  logic                b_last,
    input  logic [16*ENTRY-1:0] b_row,
    output logic                out_valid,
    input  logic                out_ready,
    output logic [16*ENTRY-1:0] out_row
);
    localparam int unsigned ROW = 16 * ENTRY;

    logic [ROW-1:0] rank1, rank2, rank3, rank4;
    logic valid1, valid2, valid3, valid4;
    logic move1, move2, move3, move4;
    logic merge;

    assign move4      = !valid4 || out_ready;
    assign move3      = !valid3 || move4;
    assign move2      = !valid2 || move3;
    assign move1      = !valid1 || move2;
    assign sort_ready = move1;
    assign out_valid  = valid4;
    assign out_row    = rank4;

    logic [ROW-1:0] s1, s2, s3, s4, s5, s6, s7, s8, s9, s10;
    bitonic_stage #(.ENTRY(ENTRY), .DISTANCE(1), .BLOCK(2)) stage1 (.in_row(sort_row), .out_row(s1));
    bitonic_stage #(.ENTRY(ENTRY), .DISTANCE(2), .BLOCK(4)) stage2 (.in_row(s1), .out_row(s2));
    bitonic_stage #(.ENTRY(ENTRY), .DISTANCE(1), .BLOCK(4)) stage3 (.in_row(s2), .out_row(s3));
    bitonic_stage #(.ENTRY(ENTRY), .DISTANCE(4), .BLOCK(8)) stage4 (.in_row(rank1), .out_row(s4));
    bitonic_stage #(.ENTRY(ENTRY), .DISTANCE(2), .BLOCK(8)) stage5 (.in_row(s4), .out_row(s5));
    bitonic_stage #(.ENTRY(ENTRY), .DISTANCE(1), .BLOCK(8)) stage6 (.in_row(s5), .out_row(s6));
    bitonic_stage #(.ENTRY(ENTRY), .DISTANCE(8)) stage7 (.in_row(rank2), .out_row(s7));
    bitonic_stage #(.ENTRY(ENTRY), .DISTANCE(4)) stage8 (.in_row(s7), .out_row(s8));
    bitonic_stage #(.ENTRY(ENTRY), .DISTANCE(2)) stage9 (.in_row(rank3), .out_row(s9));
    bitonic_stage #(.ENTRY(ENTRY), .DISTANCE(1)) stage10 (.in_row(s9), .out_row(s10));

    logic [ROW-1:0] a_heads, b_heads, selected;
    logic [15:0] a_beyond, b_beyond, take_a, a_take, b_take;
    logic a_can, b_can, a_ends, b_ends, pair_done;

    assign merge     = a_can && b_can && move2 && !valid1;
    assign pair_done = merge && a_ends && b_ends;

    for (genvar i = 0; i < 16; i++) begin : g_select
        assign take_a[i] = {a_beyond[i], a_heads[i*ENTRY+:ENTRY]}
            <= {b_beyond[15-i], b_heads[(15-i)*ENTRY+:ENTRY]};
        assign selected[i*ENTRY+:ENTRY] =
            take_a[i] ? a_heads[i*ENTRY+:ENTRY] : b_heads[(15-i)*ENTRY+:ENTRY];
        assign a_take[i]    = merge && take_a[i];
        assign b_take[15-i] = merge && !take_a[i];
    end

    merge_window #(
        .ENTRY(ENTRY)
    ) window_a (
        .clk,
        .rst_n,
        .in_valid      (a_valid),
        .in_ready      (a_ready),
        .in_last       (a_last),
        .in_row        (a_row),
        .ready_to_merge(a_can),
        .heads         (a_heads),
        .beyond        (a_beyond),
        .take          (a_take),
        .ends          (a_ends),
        .pair_done     (pair_done)
    );
    merge_window #(
        .ENTRY(ENTRY)
    ) window_b (
        .clk,
        .rst_n,
        .in_valid      (b_valid),
        .in_ready      (b_ready),
        .in_last       (b_last),
        .in_row        (b_row),
        .ready_to_merge(b_can),
        .heads         (b_heads),
        .beyond        (b_beyond),
        .take          (b_take),
        .ends          (b_ends),
        .pair_done     (pair_done)
    );

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            valid1 <= 1'b0;
            valid2 <= 1'b0;
            valid3 <= 1'b0;
            valid4 <= 1'b0;
        end else begin
            if (move1) valid1 <= sort_valid;
            if (move2) valid2 <= valid1 || merge;
            if (move3) valid3 <= valid2;
            if (move4) valid4 <= valid3;
        end
    end

    always_ff @(posedge clk) begin
        if (move1 && sort_valid) rank1 <= s3;
        if (move2 && (valid1 || merge)) rank2 <= valid1 ? s6 : selected;
        if (move3 && valid2) rank3 <= s8;
        if (move4 && valid3) rank4 <= s10;
    end
endmodule
