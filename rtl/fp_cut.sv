// A register, or with SPLIT = 0 a wire. Not reset: what is valid is known elsewhere.
module fp_cut #(
    parameter int WIDTH = 16,
    parameter bit SPLIT = 1'b1
) (
    input  logic             clk,
    input  logic             enable,
    input  logic [WIDTH-1:0] d,
    output logic [WIDTH-1:0] q
);
    if (SPLIT) begin : g_register
        always_ff @(posedge clk) begin
            if (enable) q <= d;
        end
    end else begin : g_wire
        assign q = d;
        logic unused;
        assign unused = &{1'b0, clk, enable};
    end
endmodule
