// 1 / a, or with `root` 1 / sqrt(a), off by 1.3 ulp at most in 15 bits of mantissa: straight lines
// between the entries of tables. Combinational, or with SPLIT one register in front of rounding.
// Subnormal arguments count as zero. At most 17 bits of mantissa.
module fp_special #(
    parameter int EXP = 8,
    parameter int MAN = 15,
    parameter bit SPLIT = 1'b0
) (
    input  logic clk,
    // The register takes a new value.
    input  logic enable,
    input  logic root,
    input  logic [EXP+MAN:0] a,
    output logic [EXP+MAN:0] y
);
    localparam int EW = fp_pkg::exponent_width(EXP);
    localparam int BIAS = (1 << (EXP - 1)) - 1;
    localparam logic [EXP-1:0] ONES = '1;
    // Bits of the way on a line of 1 / a, and of all behind the point.
    localparam int STEP = MAN > 8 ? MAN - 7 : 1;
    localparam int ALL = 7 + STEP;

    logic [EXP-1:0] field;
    logic odd;
    logic [ALL-1:0] whole;
    logic [6:0] index;
    logic [STEP:0] step;
    logic [39:0] entry;
    logic [16+STEP:0] fall;
    logic [21:0] line;
    logic signed [EW-1:0] top;
    logic signed [EW-1:0] even;
    logic sign;
    logic nan;
    logic infinite;
    logic zero;
    logic [EXP+MAN:0] finite;

    always_comb begin
        field = a[EXP+MAN-1:MAN];
        // The bias is odd.
        odd = !field[0];
        whole = ALL'(a[MAN-1:0]) << (ALL - MAN);
        index = root ? {odd, whole[ALL-1-:6]} : whole[ALL-1-:7];
        step = root ? whole[STEP:0] : {whole[STEP-1:0], 1'b0};
        entry = root ? fp_special_pkg::ROOT[index*40+:40]
            : fp_special_pkg::RECIPROCAL[index*40+:40];
        fall = (17 + STEP)'(entry[15:0]) * (17 + STEP)'(step);
        line = entry[37:16] - 22'(fall[16+STEP:STEP+1]);
        even = signed'(EW'(field) - EW'(BIAS) - EW'(odd)) >>> 1;
        top = root ? EW'(BIAS - 1) - even : EW'(2 * BIAS - 1) - EW'(field);
        sign = a[EXP+MAN] && !root;
        nan = (field == ONES && a[MAN-1:0] != '0) || (root && a[EXP+MAN] && field != '0);
        zero = field == ONES;
        infinite = field == '0;
    end

    logic cut_sign;
    logic cut_nan;
    logic cut_infinite;
    logic cut_zero;
    logic signed [EW-1:0] cut_top;
    logic [21:0] cut_line;
    fp_cut #(
        .WIDTH(4 + EW + 22),
        .SPLIT(SPLIT)
    ) cut (
        .clk(clk),
        .enable(enable),
        .d({sign, nan, infinite, zero, top, line}),
        .q({cut_sign, cut_nan, cut_infinite, cut_zero, cut_top, cut_line})
    );

    fp_round #(
        .EXP(EXP),
        .MAN(MAN),
        .IN(22),
        .EW(EW)
    ) round (
        .sign(cut_sign),
        .top(cut_top),
        .significand(cut_line),
        .y(finite)
    );

    logic unused;
    assign unused = &{1'b0, entry[39:38], fall[STEP:0]};

    always_comb begin
        if (cut_nan) y = {1'b0, ONES, 1'b1, {(MAN - 1) {1'b0}}};
        else if (cut_infinite) y = {cut_sign, ONES, {MAN{1'b0}}};
        else if (cut_zero) y = {cut_sign, {(EXP + MAN) {1'b0}}};
        else y = finite;
    end
endmodule
