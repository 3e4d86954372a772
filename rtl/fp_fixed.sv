// A number as a whole number of 2^-FRACTION, of BITS bits with its sign. Combinational. What is
// beyond them, infinite numbers and NaN become the last number of their sign.
module fp_fixed #(
    parameter int EXP = 8,
    parameter int MAN = 15,
    parameter int FRACTION = 8,
    // More than MAN + 1.
    parameter int BITS = 24,
    // 0: down; 1: up; 2: to nearest, halves away from zero.
    parameter int ROUNDING = 0
) (
    input  logic [EXP+MAN:0]       a,
    output logic signed [BITS-1:0] y
);
    localparam int BIAS = (1 << (EXP - 1)) - 1;
    // The field of numbers whose first bit is the first one behind the sign.
    localparam int HIGHEST = BITS - 2 - FRACTION + BIAS;
    localparam int SHIFT = BITS + 1;
    localparam int SW = $clog2(SHIFT + 1);
    localparam logic [EXP-1:0] ONES = '1;

    logic [EXP-1:0] field;
    logic sign;
    logic too_large;
    logic [SW-1:0] shift;
    logic [2*BITS-1:0] placed;
    logic [BITS-1:0] whole;
    logic half;
    logic rest;
    logic up;
    logic [BITS-1:0] rounded;
    logic [BITS-2:0] magnitude;
    always_comb begin
        sign = a[EXP+MAN];
        field = a[EXP+MAN-1:MAN];
        too_large = 32'(field) > HIGHEST || field == ONES;
        if (HIGHEST - 32'(field) > SHIFT) shift = SW'(SHIFT);
        else shift = SW'(HIGHEST - 32'(field) - 32'(field == '0));
        placed = {1'b0, field != '0, a[MAN-1:0], {(2 * BITS - MAN - 2) {1'b0}}} >> shift;
        whole = placed[2*BITS-1:BITS];
        half = placed[BITS-1];
        rest = placed[BITS-2:0] != '0;
        if (ROUNDING == 0) up = sign && (half || rest);
        else if (ROUNDING == 1) up = !sign && (half || rest);
        else up = half;
        rounded = whole + BITS'(up);
        magnitude = too_large || rounded[BITS-1] ? '1 : rounded[BITS-2:0];
        y = sign ? -$signed({1'b0, magnitude}) : $signed({1'b0, magnitude});
    end
endmodule
