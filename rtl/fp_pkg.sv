// What elaboration knows about number formats: a sign, EXP bits of biased exponent and MAN bits of
// mantissa, with subnormals, infinities and one NaN (positive, first mantissa bit). EXP = 5 and
// MAN = 10 is IEEE binary16.
package fp_pkg;

    // Bits of a signed exponent that can be off by the length of a product.
    function automatic int exponent_width(input int exp_bits);
        exponent_width = (exp_bits > 5 ? exp_bits : 5) + 3;
    endfunction

    // significand / 2^23 times 2^exponent, for a significand of 24 bits with its leading one: the
    // number next below or, with up, next above it. It must lie between two numbers.
    function automatic logic [15:0] between(input int exp_bits, input int man_bits,
                                            input int exponent, input int significand,
                                            input bit up);
        int first;
        int least;
        int kept;
        first = 2 - (1 << (exp_bits - 1));
        least = first - man_bits;
        kept = (exponent > first ? exponent : first) - man_bits;
        between = 16'(((kept - least) << man_bits) + (significand >> (kept - exponent + 23))
            + int'(up));
    endfunction

    // n / 2 for n of 0 to 15, rounded to nearest even.
    function automatic logic [15:0] half_of(input int exp_bits, input int man_bits, input int n);
        int top;
        int dropped;
        int whole;
        int rest;
        top = n >= 8 ? 3 : n >= 4 ? 2 : n >= 2 ? 1 : 0;
        dropped = top - man_bits;
        whole = n;
        rest = 0;
        if (dropped > 0) begin
            whole = n >> dropped;
            rest = n - (whole << dropped);
            if (2 * rest > (1 << dropped) || (2 * rest == (1 << dropped) && whole[0])) begin
                whole = whole + 1;
            end
        end else begin
            whole = n << -dropped;
        end
        half_of = n == 0 ? 16'd0 : 16'(((top - 1 + (1 << (exp_bits - 1)) - 2) << man_bits) + whole);
    endfunction

    // The number nearest to one of binary32 that is zero or normal in both formats, MAN below 23.
    function automatic logic [31:0] of_single(input int exp_bits, input int man_bits,
                                              input logic [31:0] single);
        logic [31:0] magnitude;
        logic [31:0] rest;
        logic [31:0] half;
        magnitude = {1'b0, single[30:0]} >> (23 - man_bits);
        rest = {1'b0, single[30:0]} - (magnitude << (23 - man_bits));
        half = 32'd1 << (22 - man_bits);
        if (rest > half || (rest == half && magnitude[0])) magnitude = magnitude + 32'd1;
        magnitude = magnitude - 32'(((127 - (1 << (exp_bits - 1)) + 1) << man_bits));
        if (single[30:0] == '0) magnitude = '0;
        of_single = magnitude | (32'(single[31]) << (exp_bits + man_bits));
    endfunction

endpackage
