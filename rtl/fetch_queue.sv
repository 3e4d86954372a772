// Answers in the order of their requests: SLOTS places, each of PARTS answers of WIDTH bits, which
// come in any order. A place is taken when its requests begin, and given back when its data leave.
// Reset: empty.
module fetch_queue #(
    parameter int WIDTH = 256,
    parameter int PARTS = 1,
    parameter int SLOTS = 8,
    localparam int S = $clog2(SLOTS)
) (
    input  logic                   clk,
    input  logic                   rst_n,
    output logic                   room,
    output logic [S-1:0]           slot,
    input  logic                   take,
    input  logic                   come_valid,
    input  logic [S-1:0]           come_slot,
    input  logic                   come_part,
    input  logic [WIDTH-1:0]       come_data,
    output logic                   out_valid,
    input  logic                   out_ready,
    output logic [PARTS*WIDTH-1:0] out_data
);
    logic [S-1:0] head, tail;
    logic [S:0] held;
    logic [PARTS-1:0][SLOTS-1:0] there;
    logic leaves;
    assign room = held != (S + 1)'(SLOTS);
    assign slot = tail;
    assign leaves = out_valid && out_ready;
    always_comb begin
        out_valid = held != '0;
        for (int p = 0; p < PARTS; p++) if (!there[p][head]) out_valid = 1'b0;
    end
    for (genvar p = 0; p < PARTS; p++) begin : g_part
        sram_async #(
            .WIDTH(WIDTH), .DEPTH(SLOTS)
        ) answers (
            .clk(clk), .write(come_valid && (PARTS == 1 || come_part == (p == 1))),
            .write_at(come_slot), .write_data(come_data), .read_at(head),
            .read_data(out_data[p*WIDTH+:WIDTH]));
        always_ff @(posedge clk) begin
            if (!rst_n) there[p] <= '0;
            else begin
                if (leaves) there[p][head] <= 1'b0;
                if (come_valid && (PARTS == 1 || come_part == (p == 1))) there[p][come_slot] <= 1'b1;
            end
        end
    end
    always_ff @(posedge clk) begin
        if (!rst_n) begin
            head <= '0;
            tail <= '0;
            held <= '0;
        end else begin
            held <= held + (S + 1)'(take) - (S + 1)'(leaves);
            if (take) tail <= tail == S'(SLOTS - 1) ? '0 : tail + 1'b1;
            if (leaves) head <= head == S'(SLOTS - 1) ? '0 : head + 1'b1;
        end
    end
endmodule
