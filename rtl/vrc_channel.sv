// One colour of the pixels of a core: adds to the pixel whose turn it is. Not reset; `clear` makes
// all of them zero.
module vrc_channel #(
    parameter int EXP = 5,
    parameter int MAN = 10,
    parameter bit SPLIT = 1'b1,
    parameter int PIXELS = 4,
    localparam int D = SPLIT ? 2 : 1,
    localparam int I = $clog2(PIXELS),
    localparam int W = EXP + MAN + 1
) (
    input  logic         clk,
    input  logic         clear,
    input  logic [D-1:0] valid,
    input  logic [I-1:0] read,
    input  logic [I-1:0] write,
    input  logic [I-1:0] leaving,
    input  logic [W-1:0] share,
    output logic [W-1:0] colour
);
    logic [PIXELS-1:0][W-1:0] pixels;
    logic [W-1:0] sum;
    fp_add #(.EXP(EXP), .MAN(MAN), .SPLIT(SPLIT)) add (
        .clk(clk), .enable(valid[0]), .a(pixels[read]), .b(share), .y(sum));
    // Pixel by pixel, so that the register of each has an enable that a clock gate can take.
    for (genvar i = 0; i < PIXELS; i++) begin : g_pixel
        always_ff @(posedge clk) begin
            if (clear) pixels[i] <= '0;
            else if (valid[D-1] && write == I'(i)) pixels[i] <= sum;
        end
    end
    assign colour = pixels[leaving];
endmodule
