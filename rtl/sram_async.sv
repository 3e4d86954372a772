// Register file of DEPTH words with a port to write and READS ports that are read in the same cycle.
// Stands for a compiled one: synthesis of a core leaves it out. Reset: none, contents are unknown.
module sram_async #(
    parameter int WIDTH = 32,
    parameter int DEPTH = 16,
    parameter int READS = 1,
    localparam int A = $clog2(DEPTH)
) (
    input  logic                   clk,
    input  logic                   write,
    input  logic [A-1:0]           write_at,
    input  logic [WIDTH-1:0]       write_data,
    input  logic [READS*A-1:0]     read_at,
    output logic [READS*WIDTH-1:0] read_data
);
    logic [WIDTH-1:0] words[DEPTH];
    always_ff @(posedge clk) begin
        if (write) words[write_at] <= write_data;
    end
    for (genvar r = 0; r < READS; r++) begin : g_read
        assign read_data[r*WIDTH+:WIDTH] = words[read_at[r*A+:A]];
    end
endmodule
