// a times b, rounded to nearest even. Combinational, or with SPLIT one
// register in front of rounding.
module fp_mul #(
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
    localparam int BIAS = (1 << (EXP - 1)) - 1;
    localparam logic [EXP-1:0] ONES = '1;

    logic sign;
    logic [EXP-1:0] field_a;
    logic [EXP-1:0] field_b;
    logic [MAN:0] significand_a;
    logic [MAN:0] significand_b;
    logic [2*MAN+1:0] product;
    logic signed [EW-1:0] top;
    logic nan;
    logic infinite;
    logic [EXP+MAN:0] finite;

    always_comb begin
        sign = a[EXP+MAN] ^ b[EXP+MAN];
        field_a = a[EXP+MAN-1:MAN];
        field_b = b[EXP+MAN-1:MAN];
        significand_a = {field_a != '0, a[MAN-1:0]};
        significand_b = {field_b != '0, b[MAN-1:0]};
        product = (2 * MAN + 2)'(significand_a) * (2 * MAN + 2)'(significand_b);
        // Subnormals have exponent 1 too. The first bit of a product is worth 2.
        top = EW'(field_a) + EW'(field_a == '0) + EW'(field_b) + EW'(field_b == '0) - EW'(BIAS - 1);
        infinite = field_a == ONES || field_b == ONES;
        nan = (field_a == ONES && (a[MAN-1:0] != '0 || significand_b == '0))
            || (field_b == ONES && (b[MAN-1:0] != '0 || significand_a == '0));
    end

    logic cut_sign;
    logic cut_nan;
    logic cut_infinite;
    logic signed [EW-1:0] cut_top;
    logic [2*MAN+1:0] cut_product;
    fp_cut #(
        .WIDTH(3 + EW + 2 * MAN + 2),
        .SPLIT(SPLIT)
    ) cut (
        .clk(clk),
        .enable(enable),
        .d({sign, nan, infinite, top, product}),
        .q({cut_sign, cut_nan, cut_infinite, cut_top, cut_product})
    );

    fp_round #(
        .EXP(EXP),
        .MAN(MAN),
        .IN(2 * MAN + 2),
        .EW(EW)
    ) round (
        .sign(cut_sign),
        .top(cut_top),
        .significand(cut_product),
        .y(finite)
    );

    always_comb begin
        if (cut_nan) y = {1'b0, ONES, 1'b1, {(MAN - 1) {1'b0}}};
        else if (cut_infinite) y = {cut_sign, ONES, {MAN{1'b0}}};
        else y = finite;
    end
endmodule
