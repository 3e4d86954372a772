// Which pixel passes a stage: they come in turn. After reset pixel 0 is next.
module vrc_turn #(
    parameter int PIXELS = 4,
    localparam int I = $clog2(PIXELS)
) (
    input  logic         clk,
    input  logic         rst_n,
    input  logic         slot,
    output logic [I-1:0] turn
);
    always_ff @(posedge clk) begin
        if (!rst_n) turn <= '0;
        else if (slot) turn <= turn == I'(PIXELS - 1) ? '0 : turn + 1'b1;
    end
endmodule
