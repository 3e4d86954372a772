// What belongs to a splat, DELAY cycles later, for as long as its pixels pass there: `d` holds from
// the cycle of its first pixel for HOLD cycles at least. `first` are the stages that are passed. A
// register for every HOLD cycles suffices.
module vrc_carry #(
    parameter int WIDTH = 16,
    parameter int DELAY = 4,
    parameter int HOLD = 4
) (
    input  logic             clk,
    input  logic [DELAY-1:0] first,
    input  logic [WIDTH-1:0] d,
    output logic [WIDTH-1:0] q
);
    localparam int HOPS = (DELAY + HOLD - 1) / HOLD;
    logic [HOPS:0][WIDTH-1:0] held;
    assign held[0] = d;
    for (genvar h = 1; h <= HOPS; h++) begin : g_hop
        localparam int AT = h == HOPS ? DELAY : h * HOLD;
        always_ff @(posedge clk) begin
            if (first[AT-1]) held[h] <= held[h-1];
        end
    end
    assign q = held[HOPS];
    logic unused;
    assign unused = &{1'b0, first};
endmodule
