// The tile side of a chip: jobs in their order to the first core that is ready, a memory port for
// each core. A job goes to the core of the lowest number among those that are ready. Pivots of a job
// come from outside, for each core its own. Reset: as core.
module cores #(
    parameter int CORES = 1,
    parameter int ROWS = 128,
    parameter int CHUNK = 256,
    parameter int CHUNKS = 16,
    parameter int FEATURES = 64,
    parameter int SLOTS = 8,
    parameter int AHEAD = 1,
    parameter int QUEUE = 2,
    parameter int TILES = 2
) (
    input  logic              clk,
    input  logic              rst_n,
    input  logic [31:0]       features,
    input  logic [31:0]       pixels,
    input  logic [8:0]        tiles_x,
    input  logic              job_valid,
    output logic [CORES-1:0]  job_taken,
    input  logic [31:0]       job_address,
    input  logic [15:0]       job_entries,
    input  logic [27:0]       job_tile,
    input  logic [CORES-1:0]  pivot_valid,
    output logic [CORES-1:0]  pivot_ready,
    input  logic [63:0]       pivot_key[CORES],
    output logic [CORES-1:0]  ask_valid,
    input  logic [CORES-1:0]  ask_ready,
    output logic [CORES-1:0]  ask_write,
    output logic [31:0]       ask_address[CORES],
    output logic [7:0]        ask_bytes[CORES],
    output logic [15:0]       ask_tag[CORES],
    output logic [511:0]      ask_data[CORES],
    input  logic [CORES-1:0]  come_valid,
    output logic [CORES-1:0]  come_ready,
    input  logic [15:0]       come_tag[CORES],
    input  logic [511:0]      come_data[CORES],
    output logic              idle,
    output logic [15:0]       counts[CORES]
);
    logic [CORES-1:0] ready, gets, is_idle;
    logic unused;
    assign idle = &is_idle && !job_valid;
    assign job_taken = gets;
    for (genvar c = 0; c < CORES; c++) begin : g_core
        localparam logic [CORES-1:0] BEFORE = CORES'((64'd1 << c) - 64'd1);
        assign gets[c] = job_valid && ready[c] && (ready & BEFORE) == '0;
        core #(
            .ROWS(ROWS), .CHUNK(CHUNK), .CHUNKS(CHUNKS), .FEATURES(FEATURES), .SLOTS(SLOTS),
            .AHEAD(AHEAD), .QUEUE(QUEUE), .TILES(TILES)
        ) one (
            .clk(clk), .rst_n(rst_n), .features(features), .pixels(pixels), .tiles_x(tiles_x),
            .job_valid(gets[c]), .job_ready(ready[c]), .job_address(job_address),
            .job_entries(job_entries), .job_tile(job_tile),
            .pivot_valid(pivot_valid[c]), .pivot_ready(pivot_ready[c]),
            .pivot_key(pivot_key[c][39:0]),
            .ask_valid(ask_valid[c]), .ask_ready(ask_ready[c]), .ask_write(ask_write[c]),
            .ask_address(ask_address[c]), .ask_bytes(ask_bytes[c][6:0]), .ask_tag(ask_tag[c]),
            .ask_data(ask_data[c]),
            .come_valid(come_valid[c]), .come_ready(come_ready[c]), .come_tag(come_tag[c]),
            .come_data(come_data[c]), .idle(is_idle[c]), .counts(counts[c][8:0]));
        assign ask_bytes[c][7] = 1'b0;
        assign counts[c][15:9] = '0;
    end
    assign unused = &{1'b0, pivot_key[0][63:40]};
endmodule
