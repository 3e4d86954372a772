// Compare-exchange of two unsigned entries: the smaller one leaves at `low`.
//
// Combinational. Equal entries are not exchanged.
module compare_exchange #(
    parameter int unsigned ENTRY = 32
) (
    input  logic [ENTRY-1:0] a,
    input  logic [ENTRY-1:0] b,
    output logic [ENTRY-1:0] low,
    output logic [ENTRY-1:0] high
);
    logic swap;

    assign swap = b < a;
    assign low  = swap ? b : a;
    assign high = swap ? a : b;
endmodule
