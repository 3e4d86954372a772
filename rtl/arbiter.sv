// PORTS memory ports behind one: a request a cycle, in turn, and an answer a cycle. The port of a
// request is in its tag, above the tag that it had. Nothing is held; `ask_ready` depends on the
// `ask_valid` of all ports. Reset: the first port is first.
module arbiter #(
    parameter int PORTS = 2,
    localparam int P = $clog2(PORTS + 1)
) (
    input  logic                    clk,
    input  logic                    rst_n,
    input  logic [PORTS-1:0]        ask_valid,
    output logic [PORTS-1:0]        ask_ready,
    input  logic [PORTS-1:0]        ask_write,
    input  logic [PORTS-1:0][31:0]  ask_address,
    input  logic [PORTS-1:0][31:0]  ask_bytes,
    input  logic [PORTS-1:0][31:0]  ask_tag,
    input  logic [PORTS-1:0][511:0] ask_data,
    output logic [PORTS-1:0]        come_valid,
    input  logic [PORTS-1:0]        come_ready,
    output logic [15:0]             come_tag,
    output logic                    one_valid,
    input  logic                    one_ready,
    output logic                    one_write,
    output logic [31:0]             one_address,
    output logic [31:0]             one_bytes,
    output logic [31:0]             one_tag,
    output logic [511:0]            one_data,
    input  logic                    one_come_valid,
    output logic                    one_come_ready,
    input  logic [31:0]             one_come_tag
);
    // Who is first; of those behind it the next one that asks.
    logic [P-1:0] first, picked;
    always_comb begin
        picked = first;
        for (int k = PORTS - 1; k >= 0; k--) begin
            if (ask_valid[(32'(first) + k) % PORTS]) picked = P'((32'(first) + k) % PORTS);
        end
    end
    for (genvar p = 0; p < PORTS; p++) begin : g_port
        assign ask_ready[p] = one_ready && picked == P'(p);
        assign come_valid[p] = one_come_valid && one_come_tag[31:16] == 16'(p);
    end
    assign one_valid = ask_valid[32'(picked)];
    assign one_write = ask_write[32'(picked)];
    assign one_address = ask_address[32'(picked)];
    assign one_bytes = ask_bytes[32'(picked)];
    assign one_tag = {16'(picked), ask_tag[32'(picked)][15:0]};
    assign one_data = ask_data[32'(picked)];
    assign come_tag = one_come_tag[15:0];
    assign one_come_ready = come_ready[32'(one_come_tag[16+:P])];
    always_ff @(posedge clk) begin
        if (!rst_n) first <= '0;
        else if (one_valid && one_ready) first <= 32'(picked) == PORTS - 1 ? '0 : picked + 1'b1;
    end
    logic unused;
    assign unused = &{1'b0, ask_tag};
endmodule
