// Sum with a register behind it and, with SPLIT, one inside; each takes a new value where
// something valid passes.
module vrc_add #(
    parameter int EXP = 5,
    parameter int MAN = 10,
    parameter bit SPLIT = 1'b1,
    localparam int D = SPLIT ? 2 : 1
) (
    input  logic             clk,
    input  logic [D-1:0]     valid,
    input  logic [EXP+MAN:0] a,
    input  logic [EXP+MAN:0] b,
    output logic [EXP+MAN:0] y
);
    logic [EXP+MAN:0] next;
    fp_add #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) operation (
        .clk(clk), .enable(valid[0]), .a(a), .b(b), .y(next));
    always_ff @(posedge clk) begin
        if (valid[D-1]) y <= next;
    end
endmodule
