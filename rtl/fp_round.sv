// The end of every operation: normalises, rounds to nearest even and packs, subnormals included.
// Combinational. The value is significand / 2^(IN-1) times 2^(top - bias): top is the biased
// exponent of its first bit.
module fp_round #(
    parameter int EXP = 5,
    parameter int MAN = 10,
    // Bits of the significand, at least MAN + 3; the last one may be sticky.
    parameter int IN = 22,
    // Bits of top.
    parameter int EW = 8,
    // Whether the first bits can be zero.
    parameter bit LEADING_ZEROS = 1'b1,
    // Whether top can be below 1.
    parameter bit BELOW = 1'b1
) (
    input  logic                 sign,
    input  logic signed [EW-1:0] top,
    input  logic        [IN-1:0] significand,
    output logic     [EXP+MAN:0] y
);
    localparam int STEPS = $clog2(IN + 2);
    localparam int WIDE = 1 << STEPS;

    // With an exponent below 1 the number is subnormal: it moves right; what falls out is sticky.
    logic signed [EW-1:0] start;
    logic [IN:0] placed;
    if (BELOW) begin : g_below
        logic signed [EW-1:0] missing;
        logic [$clog2(IN+1)-1:0] amount;
        logic [2*IN-1:0] moved;
        always_comb begin
            missing = EW'(1) - top;
            if (missing <= 0) amount = '0;
            else if (missing >= EW'(IN)) amount = ($clog2(IN+1))'(IN);
            else amount = ($clog2(IN+1))'(missing);
            moved = {significand, {IN{1'b0}}} >> amount;
            placed = {moved[2*IN-1:IN], |moved[IN-1:0]};
            start = missing > 0 ? EW'(1) : top;
        end
    end else begin : g_normal
        always_comb begin
            placed = {significand, 1'b0};
            start = top;
        end
    end

    // It moves left until its first bit is set or its exponent is 1, whichever comes first: the
    // guide has a one where the exponent would be 1.
    logic [IN:0] normal;
    logic signed [EW-1:0] exponent;
    if (LEADING_ZEROS) begin : g_leading
        logic [WIDE-1:0] guide;
        logic [WIDE-1:0] moving;
        logic [STEPS-1:0] count;
        always_comb begin
            moving = {placed, {(WIDE - IN - 1) {1'b0}}};
            guide = moving | ({1'b1, {(WIDE - 1) {1'b0}}} >> (start - EW'(1)));
            for (int k = STEPS - 1; k >= 0; k--) begin
                count[k] = (guide >> (WIDE - (1 << k))) == '0;
                if (count[k]) begin
                    guide = guide << (1 << k);
                    moving = moving << (1 << k);
                end
            end
        end
        assign normal = moving[WIDE-1-:IN+1];
        assign exponent = start - EW'({1'b0, count});
        // What is to the right of the last bit is zero.
        logic unused;
        assign unused = &{1'b0, moving[WIDE-IN-2:0]};
    end else begin : g_placed
        assign normal = placed;
        assign exponent = start;
    end

    logic [MAN:0] whole;
    logic guard;
    logic sticky;
    logic up;
    // Exponent field and mantissa in one: a carry out of the mantissa arrives in the exponent, and
    // a subnormal has exponent 1 without its leading one.
    logic [EW+MAN-1:0] packed_up;
    always_comb begin
        whole = normal[IN-:MAN+1];
        guard = normal[IN-MAN-1];
        sticky = |normal[IN-MAN-2:0];
        up = guard && (sticky || whole[0]);
        packed_up = {exponent - EW'(1), {MAN{1'b0}}} + (EW + MAN)'(whole) + (EW + MAN)'(up);
        if (significand == '0) begin
            y = {sign, {(EXP + MAN) {1'b0}}};
        end else if (packed_up[EW+MAN-1:MAN] >= EW'((1 << EXP) - 1)) begin
            y = {sign, {EXP{1'b1}}, {MAN{1'b0}}};
        end else begin
            y = {sign, packed_up[EXP+MAN-1:0]};
        end
    end
endmodule
