// Quick Sorting Unit: deals the entries of a list to PIVOTS + 1 parts by their keys.
//
// The part of an entry is the number of pivots that are not above its key, so an entry whose key
// equals a pivot goes above it. Keys are unsigned; depths of floating point that are not negative
// have the order of their bits. Pivots are expected in ascending order; they are written one a
// cycle through `pivot_*` and hold until they are written again. A pivot that is written in cycle t
// is in force for entries that are accepted from cycle t + 1 on.
//
// Interval 1, latency 2. Reset: no entry inside; pivots and data are not reset.
// `in_ready` depends on `out_ready` and on registers, not on `in_valid`.
module qsu #(
    parameter int unsigned PIVOTS  = 7,
    parameter int unsigned KEY     = 16,
    parameter int unsigned PAYLOAD = 16,
    localparam int unsigned PART   = $clog2(PIVOTS + 1)
) (
    input  logic               clk,
    input  logic               rst_n,
    input  logic               pivot_valid,
    input  logic [PART-1:0]    pivot_index,
    input  logic [KEY-1:0]     pivot_key,
    input  logic               in_valid,
    output logic               in_ready,
    input  logic [KEY-1:0]     in_key,
    input  logic [PAYLOAD-1:0] in_payload,
    output logic               out_valid,
    input  logic               out_ready,
    output logic [PART-1:0]    out_part,
    output logic [KEY-1:0]     out_key,
    output logic [PAYLOAD-1:0] out_payload
);
    logic [KEY-1:0]     pivots[PIVOTS];
    logic               held_valid;
    logic [KEY-1:0]     held_key;
    logic [PAYLOAD-1:0] held_payload;
    logic [PIVOTS-1:0]  reached;
    logic [PART-1:0]    part;
    logic               move_in, move_out;

    assign move_out = !out_valid || out_ready;
    assign move_in  = !held_valid || move_out;
    assign in_ready = move_in;

    // All pivots are compared at once; the number of those reached is the part.
    always_comb begin
        part = '0;
        for (int unsigned p = 0; p < PIVOTS; p++) begin
            reached[p] = pivots[p] <= held_key;
            part       = part + PART'(reached[p]);
        end
    end

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            held_valid <= 1'b0;
            out_valid  <= 1'b0;
        end else begin
            if (move_in) held_valid <= in_valid;
            if (move_out) out_valid <= held_valid;
        end
    end

    always_ff @(posedge clk) begin
        if (move_in && in_valid) begin
            held_key     <= in_key;
            held_payload <= in_payload;
        end
        if (move_out && held_valid) begin
            out_part    <= part;
            out_key     <= held_key;
            out_payload <= held_payload;
        end
        for (int unsigned p = 0; p < PIVOTS; p++) begin
            if (pivot_valid && pivot_index == PART'(p)) pivots[p] <= pivot_key;
        end
    end
endmodule
