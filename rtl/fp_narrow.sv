// A number of a wide format as the nearest one of a narrow format. Combinational. The narrow format
// has no more bits of exponent and mantissa than the wide one.
module fp_narrow #(
    parameter int EXP = 8,
    parameter int MAN = 15,
    parameter int TO_EXP = 5,
    parameter int TO_MAN = 10
) (
    input  logic [EXP+MAN:0]       a,
    output logic [TO_EXP+TO_MAN:0] y
);
    localparam int EW = EXP + 3;
    localparam int IN = MAN + 4;
    localparam int REBIAS = (1 << (TO_EXP - 1)) - (1 << (EXP - 1));
    localparam logic [EXP-1:0] ONES = '1;

    logic [EXP-1:0] field;
    logic signed [EW-1:0] top;
    logic [IN-1:0] significand;
    logic [TO_EXP+TO_MAN:0] finite;
    assign field = a[EXP+MAN-1:MAN];
    assign top = EW'(field) + EW'(field == '0) + EW'(REBIAS);
    assign significand = {field != '0, a[MAN-1:0], 3'b000};

    // Subnormal numbers of the wide format are subnormal or zero here: no leading zeros to remove.
    fp_round #(
        .EXP(TO_EXP),
        .MAN(TO_MAN),
        .IN(IN),
        .EW(EW),
        .LEADING_ZEROS(1'b0)
    ) round (
        .sign(a[EXP+MAN]),
        .top(top),
        .significand(significand),
        .y(finite)
    );

    always_comb begin
        if (field != ONES) y = finite;
        else if (a[MAN-1:0] != '0) y = {1'b0, {TO_EXP{1'b1}}, 1'b1, {(TO_MAN - 1) {1'b0}}};
        else y = {a[EXP+MAN], {TO_EXP{1'b1}}, {TO_MAN{1'b0}}};
    end
endmodule
