// One of COUNT words. Combinational.
module ccu_choose #(
    parameter int WIDTH = 16,
    parameter int COUNT = 2,
    localparam int IW = COUNT > 1 ? $clog2(COUNT) : 1
) (
    input  logic [COUNT*WIDTH-1:0] words,
    input  logic [IW-1:0]          index,
    output logic [WIDTH-1:0]       y
);
    logic [COUNT-1:0][WIDTH-1:0] all;
    assign all = words;
    assign y = all[index];
endmodule
