// Operations of one format for fp_bench.cpp, on numbers of 16 bits of which the lowest are used.
module fp_bench_unit #(
    parameter int EXP = 5,
    parameter int MAN = 10
) (
    input  logic        clk,
    input  logic [15:0] a,
    input  logic [15:0] b,
    output logic [15:0] sum,
    output logic [15:0] product,
    output logic [15:0] power,
    // The same with a register inside, one cycle later.
    output logic [15:0] split_sum,
    output logic [15:0] split_product,
    output logic [15:0] split_power
);
    localparam int TOP = EXP + MAN;
    fp_add #(.EXP(EXP), .MAN(MAN)) add (
        .clk(clk), .enable(1'b1), .a(a[TOP:0]), .b(b[TOP:0]), .y(sum[TOP:0]));
    fp_mul #(.EXP(EXP), .MAN(MAN)) mul (
        .clk(clk), .enable(1'b1), .a(a[TOP:0]), .b(b[TOP:0]), .y(product[TOP:0]));
    fp_exp #(.EXP(EXP), .MAN(MAN)) exp (.clk(clk), .enable(1'b1), .x(a[TOP:0]), .y(power[TOP:0]));
    fp_add #(.EXP(EXP), .MAN(MAN), .SPLIT(1'b1)) add_split (
        .clk(clk), .enable(1'b1), .a(a[TOP:0]), .b(b[TOP:0]), .y(split_sum[TOP:0]));
    fp_mul #(.EXP(EXP), .MAN(MAN), .SPLIT(1'b1)) mul_split (
        .clk(clk), .enable(1'b1), .a(a[TOP:0]), .b(b[TOP:0]), .y(split_product[TOP:0]));
    fp_exp #(.EXP(EXP), .MAN(MAN), .SPLIT(1'b1)) exp_split (
        .clk(clk), .enable(1'b1), .x(a[TOP:0]), .y(split_power[TOP:0]));
    if (TOP < 15) begin : g_rest
        assign sum[15:TOP+1] = '0;
        assign product[15:TOP+1] = '0;
        assign power[15:TOP+1] = '0;
        assign split_sum[15:TOP+1] = '0;
        assign split_product[15:TOP+1] = '0;
        assign split_power[15:TOP+1] = '0;
        logic unused;
        assign unused = &{1'b0, a[15:TOP+1], b[15:TOP+1]};
    end
endmodule
