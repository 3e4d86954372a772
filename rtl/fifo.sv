// First-in first-out queue of DEPTH entries with valid/ready on both sides.
//
// Interval 1; latency 1 (an entry that is accepted in cycle t is offered in cycle t + 1).
// Reset: empty. Entries themselves are not reset.
// Neither `in_ready` nor `out_valid` depends on an input of the same cycle: a full queue accepts
// nothing in the cycle in which it gives an entry away.
module fifo #(
    parameter int unsigned WIDTH = 32,
    parameter int unsigned DEPTH = 2
) (
    input  logic             clk,
    input  logic             rst_n,
    input  logic             in_valid,
    output logic             in_ready,
    input  logic [WIDTH-1:0] in_data,
    output logic             out_valid,
    input  logic             out_ready,
    output logic [WIDTH-1:0] out_data
);
    localparam int unsigned PLACE = DEPTH > 1 ? $clog2(DEPTH) : 1;
    localparam int unsigned COUNT = $clog2(DEPTH + 1);
    localparam logic [PLACE-1:0] LAST = PLACE'(DEPTH - 1);

    logic [WIDTH-1:0] entries[DEPTH];
    logic [PLACE-1:0] head, tail;
    logic [COUNT-1:0] held;
    logic push, pop;

    assign in_ready  = held != COUNT'(DEPTH);
    assign out_valid = held != '0;
    assign out_data  = entries[head];
    assign push      = in_valid && in_ready;
    assign pop       = out_valid && out_ready;

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            head <= '0;
            tail <= '0;
            held <= '0;
        end else begin
            if (push) tail <= tail == LAST ? '0 : tail + 1'b1;
            if (pop) head <= head == LAST ? '0 : head + 1'b1;
            if (push && !pop) held <= held + 1'b1;
            if (pop && !push) held <= held - 1'b1;
        end
    end

    always_ff @(posedge clk) begin
        if (push) entries[tail] <= in_data;
    end
endmodule
