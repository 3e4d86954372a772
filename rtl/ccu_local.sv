// A whole number of 2^-FRACTION as a floating-point number, held within an eighth of the largest
// one. Combinational.
module ccu_local #(
    parameter int EXP = 5,
    parameter int MAN = 10,
    parameter int BITS = 36,
    parameter int FRACTION = 16
) (
    input  logic signed [BITS-1:0] sum,
    output logic [EXP+MAN:0]       y
);
    localparam int EW = fp_pkg::exponent_width(EXP) + 1;
    localparam int BIAS = (1 << (EXP - 1)) - 1;
    // The largest number, its exponent less by three.
    localparam logic [EXP+MAN-1:0] ROOM = (EXP + MAN)'(((1 << EXP) - 5) << MAN)
        | {{EXP{1'b0}}, {MAN{1'b1}}};

    logic [BITS-1:0] magnitude;
    logic [EXP+MAN:0] rounded;
    assign magnitude = sum[BITS-1] ? -sum : sum;
    fp_round #(
        .EXP(EXP),
        .MAN(MAN),
        .IN(BITS),
        .EW(EW),
        .BELOW(1'b0)
    ) round (
        .sign(sum[BITS-1]),
        .top(EW'(BIAS + BITS - 1 - FRACTION)),
        .significand(magnitude),
        .y(rounded)
    );
    assign y = rounded[EXP+MAN-1:0] > ROOM ? {rounded[EXP+MAN], ROOM} : rounded;
endmodule
