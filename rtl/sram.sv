// Memory of DEPTH words with a port to write and a port to read. What is read is there a cycle later
// and stays until something else is read; of a word that is written at the same time, what it was.
// Stands for a compiled SRAM: synthesis of a core leaves it out. Reset: none, contents are unknown.
module sram #(
    parameter int WIDTH = 32,
    parameter int DEPTH = 64,
    localparam int A = $clog2(DEPTH)
) (
    input  logic             clk,
    input  logic             write,
    input  logic [A-1:0]     write_at,
    input  logic [WIDTH-1:0] write_data,
    input  logic             read,
    input  logic [A-1:0]     read_at,
    output logic [WIDTH-1:0] read_data
);
    logic [WIDTH-1:0] words[DEPTH];
    always_ff @(posedge clk) begin
        if (write) words[write_at] <= write_data;
        if (read) read_data <= words[read_at];
    end
endmodule
