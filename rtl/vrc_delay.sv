// CYCLES registers, each of which takes a new value where something valid passes.
module vrc_delay #(
    parameter int WIDTH = 16,
    parameter int CYCLES = 1
) (
    input  logic              clk,
    input  logic [CYCLES-1:0] valid,
    input  logic [WIDTH-1:0]  d,
    output logic [WIDTH-1:0]  q
);
    logic [CYCLES:0][WIDTH-1:0] held;
    assign held[0] = d;
    for (genvar i = 0; i < CYCLES; i++) begin : g_register
        always_ff @(posedge clk) begin
            if (valid[i]) held[i+1] <= held[i];
        end
    end
    assign q = held[CYCLES];
endmodule
