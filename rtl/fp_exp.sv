// 2^-|x|, faithful: the largest errors are in README.md. Combinational, or with SPLIT one register
// in front of rounding. 1 of both zeros, 0 of both infinities. |x| is cut to MAN + 4 bits after the
// point and negated; its whole part is the exponent, and on the fraction the power is a straight
// line between the entries of a table.
module fp_exp #(
    parameter int EXP = 5,
    parameter int MAN = 10,
    parameter bit SPLIT = 1'b0
) (
    input  logic clk,
    // The register takes a new value.
    input  logic enable,
    input  logic [EXP+MAN:0] x,
    output logic [EXP+MAN:0] y
);
    localparam int EW = fp_pkg::exponent_width(EXP);
    localparam int BIAS = (1 << (EXP - 1)) - 1;
    localparam logic [EXP-1:0] ONES = '1;
    // Bits of |x| after and before the point; above, the result is zero.
    localparam int FRACTION = MAN + 4;
    localparam int WHOLE = $clog2(BIAS + MAN + 2);
    // Bits of the index into the table, and bits after the point of its entries.
    localparam int INDEX = (MAN + 1) / 2 < 5 ? (MAN + 1) / 2 : 5;
    localparam int BELOW = FRACTION - INDEX;
    localparam int POWER = MAN + 4 < 16 ? MAN + 4 : 16;

    // 2^(i/32) to 16 bits after the point, rounded to nearest.
    function automatic int master(input int i);
        case (i)
            0: master = 65536; 1: master = 66971; 2: master = 68438; 3: master = 69936;
            4: master = 71468; 5: master = 73032; 6: master = 74632; 7: master = 76266;
            8: master = 77936; 9: master = 79642; 10: master = 81386; 11: master = 83169;
            12: master = 84990; 13: master = 86851; 14: master = 88752; 15: master = 90696;
            16: master = 92682; 17: master = 94711; 18: master = 96785; 19: master = 98905;
            20: master = 101070; 21: master = 103283; 22: master = 105545; 23: master = 107856;
            24: master = 110218; 25: master = 112631; 26: master = 115098; 27: master = 117618;
            28: master = 120194; 29: master = 122825; 30: master = 125515; 31: master = 128263;
            default: master = 131072;
        endcase
    endfunction

    // Entry i of the table of this format.
    function automatic int entry(input int i);
        entry = (master(i << (5 - INDEX)) + ((1 << (16 - POWER)) >> 1)) >> (16 - POWER);
    endfunction

    logic [(1<<INDEX)-1:0][POWER:0] table_from;
    logic [(1<<INDEX)-1:0][POWER:0] table_rise;
    for (genvar i = 0; i < 1 << INDEX; i++) begin : g_table
        assign table_from[i] = (POWER + 1)'(entry(i));
        assign table_rise[i] = (POWER + 1)'(entry(i + 1) - entry(i));
    end

    logic [EXP-1:0] field;
    logic [MAN:0] significand;
    logic too_large;
    logic signed [EW-1:0] behind;
    logic [WHOLE+FRACTION-1:0] argument;
    logic [WHOLE+FRACTION:0] negated;
    logic signed [EW-1:0] top;
    logic [INDEX-1:0] index;
    logic [BELOW-1:0] step;
    logic [POWER+BELOW:0] rise;
    logic [POWER:0] line;
    logic [EXP+MAN:0] finite;

    always_comb begin
        field = x[EXP+MAN-1:MAN];
        significand = {field != '0, x[MAN-1:0]};
        // How far the first bit of the significand is behind the first bit of the argument.
        behind = EW'(WHOLE - 1 + BIAS) - EW'(field) - EW'(field == '0);
        too_large = behind < 0 || field == ONES;
        argument = {significand, {(WHOLE + FRACTION - MAN - 1) {1'b0}}} >> EW'(behind);
        negated = -{1'b0, argument};
        top = EW'(BIAS) + EW'(signed'(negated[WHOLE+FRACTION:FRACTION]));
        index = negated[FRACTION-1-:INDEX];
        step = negated[BELOW-1:0];
        rise = (POWER + BELOW + 1)'(table_rise[index]) * (POWER + BELOW + 1)'(step);
        line = table_from[index] + (POWER + 1)'(rise[POWER+BELOW:BELOW]);
    end

    logic nan;
    assign nan = field == ONES && x[MAN-1:0] != '0;

    logic cut_nan;
    logic cut_too_large;
    logic signed [EW-1:0] cut_top;
    logic [POWER:0] cut_line;
    fp_cut #(
        .WIDTH(2 + EW + POWER + 1),
        .SPLIT(SPLIT)
    ) cut (
        .clk(clk),
        .enable(enable),
        .d({nan, too_large, top, line}),
        .q({cut_nan, cut_too_large, cut_top, cut_line})
    );

    fp_round #(
        .EXP(EXP),
        .MAN(MAN),
        .IN(POWER + 1),
        .EW(EW),
        .LEADING_ZEROS(1'b0)
    ) round (
        .sign(1'b0),
        .top(cut_top),
        .significand(cut_line),
        .y(finite)
    );

    logic unused;
    assign unused = &{1'b0, x[EXP+MAN], rise[BELOW-1:0]};

    always_comb begin
        if (cut_nan) y = {1'b0, ONES, 1'b1, {(MAN - 1) {1'b0}}};
        else if (cut_too_large) y = '0;
        else y = finite;
    end
endmodule
