// Operations of ten formats; the list of the Rust tests (lab/datapath/tests/it/numbers.rs) has
// the same order.
module fp_bench (
    input  logic        clk,
    input  logic [ 3:0] index,
    input  logic [15:0] a,
    input  logic [15:0] b,
    output logic [15:0] sum,
    output logic [15:0] product,
    output logic [15:0] power,
    output logic [15:0] split_sum,
    output logic [15:0] split_product,
    output logic [15:0] split_power
);
    localparam int FORMATS = 10;
    localparam int EXPS[FORMATS] = '{5, 8, 4, 6, 5, 4, 5, 3, 2, 6};
    localparam int MANS[FORMATS] = '{10, 7, 11, 5, 6, 3, 2, 4, 13, 9};
    logic [FORMATS-1:0][5:0][15:0] results;
    for (genvar f = 0; f < FORMATS; f++) begin : g_format
        fp_bench_unit #(
            .EXP(EXPS[f]),
            .MAN(MANS[f])
        ) unit (
            .clk(clk),
            .a(index == 4'(f) ? a : '0),
            .b(index == 4'(f) ? b : '0),
            .sum(results[f][0]),
            .product(results[f][1]),
            .power(results[f][2]),
            .split_sum(results[f][3]),
            .split_product(results[f][4]),
            .split_power(results[f][5])
        );
    end
    assign sum = results[index][0];
    assign product = results[index][1];
    assign power = results[index][2];
    assign split_sum = results[index][3];
    assign split_product = results[index][4];
    assign split_power = results[index][5];
endmodule
