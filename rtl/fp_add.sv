// a plus b, rounded to nearest even. Combinational, or with SPLIT one
// register in front of rounding. The difference of two equal numbers is +0.
module fp_add #(
    parameter int EXP = 5,
    parameter int MAN = 10,
    parameter bit SPLIT = 1'b0
) (
    input  logic clk,
    // The register takes a new value.
    input  logic enable,
    input  logic [EXP+MAN:0] a,
    input  logic [EXP+MAN:0] b,
    output logic [EXP+MAN:0] y
);
    localparam int EW = fp_pkg::exponent_width(EXP);
    localparam logic [EXP-1:0] ONES = '1;
    // Beyond this distance the smaller summand is below the guard and rounding bits.
    localparam int FAR = MAN + 3;

    logic swap;
    logic [EXP+MAN:0] high;
    logic [EXP+MAN:0] low;
    logic [EXP-1:0] exponent_high;
    logic [EXP-1:0] exponent_low;
    logic [EXP-1:0] distance;
    logic [MAN:0] significand_high;
    logic [MAN:0] significand_low;
    logic [2*MAN+3:0] moved;
    logic [MAN+4:0] left;
    logic [MAN+4:0] right;
    logic [MAN+4:0] total;
    logic subtract;
    logic sign;
    logic nan;
    logic infinite;
    logic [EXP+MAN:0] finite;

    always_comb begin
        swap = a[EXP+MAN-1:0] < b[EXP+MAN-1:0];
        high = swap ? b : a;
        low = swap ? a : b;
        subtract = high[EXP+MAN] ^ low[EXP+MAN];
        significand_high = {high[EXP+MAN-1:MAN] != '0, high[MAN-1:0]};
        significand_low = {low[EXP+MAN-1:MAN] != '0, low[MAN-1:0]};
        // Subnormals have exponent 1 too.
        exponent_high = high[EXP+MAN-1:MAN] | EXP'(high[EXP+MAN-1:MAN] == '0);
        exponent_low = low[EXP+MAN-1:MAN] | EXP'(low[EXP+MAN-1:MAN] == '0);
        distance = exponent_high - exponent_low;
        moved = {significand_low, {(MAN + 3) {1'b0}}};
        moved = 32'(distance) > FAR ? moved >> FAR : moved >> distance;
        left = {1'b0, significand_high, 3'b000};
        right = {1'b0, moved[2*MAN+3:MAN+1], |moved[MAN:0]};
        total = subtract ? left - right : left + right;
        infinite = high[EXP+MAN-1:MAN] == ONES;
        sign = total == '0 && !infinite ? a[EXP+MAN] & b[EXP+MAN] : high[EXP+MAN];
        nan = infinite && (high[MAN-1:0] != '0 || (low[EXP+MAN-1:MAN] == ONES && subtract));
    end

    logic cut_sign;
    logic cut_nan;
    logic cut_infinite;
    logic [EXP-1:0] cut_exponent;
    logic [MAN+4:0] cut_total;
    fp_cut #(
        .WIDTH(3 + EXP + MAN + 5),
        .SPLIT(SPLIT)
    ) cut (
        .clk(clk),
        .enable(enable),
        .d({sign, nan, infinite, exponent_high, total}),
        .q({cut_sign, cut_nan, cut_infinite, cut_exponent, cut_total})
    );

    fp_round #(
        .EXP(EXP),
        .MAN(MAN),
        .IN(MAN + 5),
        .EW(EW),
        .BELOW(1'b0)
    ) round (
        .sign(cut_sign),
        .top(EW'(cut_exponent) + EW'(1)),
        .significand(cut_total),
        .y(finite)
    );

    always_comb begin
        if (cut_nan) y = {1'b0, ONES, 1'b1, {(MAN - 1) {1'b0}}};
        else if (cut_infinite) y = {cut_sign, ONES, {MAN{1'b0}}};
        else y = finite;
    end
endmodule
