// The sum, the lesser or the greater one of a and b, or with `code` 3 that which `negative`
// chooses: a, or b where it is set. One register inside. Of the lesser and the greater one, NaN
// comes before all, and -0 is less than +0.
module ccu_adder #(
    parameter int EXP = 8,
    parameter int MAN = 15
) (
    input  logic clk,
    // The register takes a new value.
    input  logic enable,
    // 0: sum; 1: the lesser; 2: the greater; 3: by `negative`.
    input  logic [1:0] code,
    input  logic negative,
    input  logic [EXP+MAN:0] a,
    input  logic [EXP+MAN:0] b,
    output logic [EXP+MAN:0] y
);
    localparam int W = EXP + MAN + 1;
    localparam logic [W-2:0] INFINITE = {{EXP{1'b1}}, {MAN{1'b0}}};

    logic [W-1:0] sum;
    fp_add #(
        .EXP(EXP),
        .MAN(MAN),
        .SPLIT(1'b1)
    ) add (
        .clk(clk),
        .enable(enable && code == 2'd0),
        .a(a),
        .b(b),
        .y(sum)
    );

    logic less;
    logic nan;
    logic takes_b;
    logic [W-1:0] chosen;
    logic is_sum;
    always_comb begin
        less = {!a[W-1], a[W-2:0] ^ {(W - 1) {a[W-1]}}} < {!b[W-1], b[W-2:0] ^ {(W - 1) {b[W-1]}}};
        nan = a[W-2:0] > INFINITE || b[W-2:0] > INFINITE;
        takes_b = code == 2'd3 ? negative : less == code[1];
    end
    always_ff @(posedge clk) begin
        if (enable) begin
            is_sum <= code == 2'd0;
            if (code != 2'd0) begin
                if (nan && code != 2'd3) chosen <= {1'b0, INFINITE | ((W - 1)'(1) << (MAN - 1))};
                else chosen <= takes_b ? b : a;
            end
        end
    end
    assign y = is_sum ? sum : chosen;
endmodule
