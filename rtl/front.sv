// The front of a chip: from the records of a scene to the lists of tiles and the records of splats.
//
//   converters ─► pairs, one a cycle, in turn ─► front_lists ─► lines of lists
//        └─► memory ports, one each: reads, records; the first one's takes lines, too, before all else
//
// `done` when all records and lists are written. Reset: at the first Gaussian; `go` begins.
module front #(
    parameter int OPS = 16,
    // Converters, at most 8.
    parameter int UNITS = 1,
    parameter int TILES = 4096,
    parameter int LINES = 64,
    parameter int REGION = 14,
    localparam int T = $clog2(TILES),
    localparam int C = REGION - 2
) (
    input  logic                    clk,
    input  logic                    rst_n,
    input  logic                    go,
    input  logic [31:0]             gaussians,
    input  logic [31:0]             means,
    input  logic [31:0]             shapes,
    input  logic [31:0]             coefficients,
    input  logic [31:0]             features,
    input  logic [31:0]             lists,
    input  logic [18*24-1:0]        settings,
    input  logic [8:0]              tiles_x,
    input  logic [8:0]              tiles_y,
    input  logic [1:0]              degree,
    output logic [UNITS-1:0]        ask_valid,
    input  logic [UNITS-1:0]        ask_ready,
    output logic [UNITS-1:0]        ask_write,
    output logic [UNITS-1:0][31:0]  ask_address,
    output logic [UNITS-1:0][6:0]   ask_bytes,
    output logic [UNITS-1:0][15:0]  ask_tag,
    output logic [UNITS-1:0][511:0] ask_data,
    input  logic [UNITS-1:0]        come_valid,
    output logic [UNITS-1:0]        come_ready,
    input  logic [UNITS-1:0][15:0]  come_tag,
    input  logic [UNITS-1:0][511:0] come_data,
    input  logic [T-1:0]            count_tile,
    output logic [C-1:0]            count,
    output logic                    done
);
    localparam logic [15:0] LINE = 16'd4;

    logic [UNITS-1:0] pair_valid, pair_ready, is_over, unit_done;
    logic [UNITS-1:0][8:0] pair_x, pair_y;
    logic [UNITS-1:0][47:0] pair_entry;
    logic is_clear, is_flushed, line_ask;
    logic [31:0] line_address;
    logic [5:0] line_bytes;
    logic [255:0] line_data;

    for (genvar u = 0; u < UNITS; u++) begin : g_unit
        logic valid, ready, write;
        logic [31:0] address;
        logic [6:0] bytes;
        logic [15:0] tag;
        logic [511:0] data;
        front_unit #(
            .OPS(OPS), .UNITS(UNITS), .UNIT(u)
        ) one (
            .clk(clk), .rst_n(rst_n), .go(go && is_clear), .gaussians(gaussians), .means(means),
            .shapes(shapes), .coefficients(coefficients), .features(features),
            .settings(settings), .tiles_x(tiles_x), .tiles_y(tiles_y), .degree(degree),
            .ask_valid(valid), .ask_ready(ready), .ask_write(write), .ask_address(address),
            .ask_bytes(bytes), .ask_tag(tag), .ask_data(data),
            .come_valid(come_valid[u]), .come_ready(come_ready[u]), .come_tag(come_tag[u]),
            .come_data(come_data[u]),
            .pair_valid(pair_valid[u]), .pair_ready(pair_ready[u]), .pair_x(pair_x[u]),
            .pair_y(pair_y[u]), .pair_entry(pair_entry[u]), .is_over(is_over[u]),
            .done(unit_done[u]));
        if (u == 0) begin : g_lines
            assign ready = ask_ready[u] && !line_ask;
            assign ask_valid[u] = valid || line_ask;
            assign ask_write[u] = line_ask ? 1'b1 : write;
            assign ask_address[u] = line_ask ? line_address : address;
            assign ask_bytes[u] = line_ask ? {1'b0, line_bytes} : bytes;
            assign ask_tag[u] = line_ask ? LINE : tag;
            assign ask_data[u] = line_ask ? {256'd0, line_data} : data;
        end else begin : g_own
            assign ready = ask_ready[u];
            assign ask_valid[u] = valid;
            assign ask_write[u] = write;
            assign ask_address[u] = address;
            assign ask_bytes[u] = bytes;
            assign ask_tag[u] = tag;
            assign ask_data[u] = data;
        end
    end

    // --- pairs in turn ---------------------------------------------------------------------------

    // Who is first, in turn; of those behind it the next one with a pair.
    logic [3:0] first, picked;
    logic takes, list_ready;
    always_comb begin
        picked = first;
        for (int k = UNITS - 1; k >= 0; k--) begin
            if (pair_valid[(32'(first) + k) % UNITS]) picked = 4'((32'(first) + k) % UNITS);
        end
    end
    for (genvar u = 0; u < UNITS; u++) begin : g_pair
        assign pair_ready[u] = list_ready && picked == 4'(u);
    end
    assign takes = pair_valid[32'(picked)] && list_ready;
    always_ff @(posedge clk) begin
        if (!rst_n) first <= '0;
        else if (takes) first <= 32'(picked) == UNITS - 1 ? '0 : picked + 4'd1;
    end

    // --- lists -----------------------------------------------------------------------------------

    logic [T-1:0] pair_tile;
    assign pair_tile = T'(32'(pair_y[32'(picked)]) * 32'(tiles_x) + 32'(pair_x[32'(picked)]));
    front_lists #(
        .TILES(TILES), .LINES(LINES), .REGION(REGION)
    ) list (
        .clk(clk), .rst_n(rst_n), .lists(lists), .tiles_x(tiles_x), .tiles_y(tiles_y),
        .is_clear(is_clear),
        .pair_valid(pair_valid[32'(picked)]), .pair_ready(list_ready), .pair_tile(pair_tile),
        .pair_entry(pair_entry[32'(picked)]), .flush(go && is_clear && is_over == '1),
        .is_flushed(is_flushed), .write_valid(line_ask), .write_ready(ask_ready[0]),
        .write_address(line_address), .write_bytes(line_bytes), .write_data(line_data),
        .count_tile(count_tile), .count(count));

    logic [31:0] writes;
    logic wrote;
    assign wrote = come_valid[0] && come_tag[0][2:0] == LINE[2:0];
    assign done = is_flushed && unit_done == '1 && writes == '0;
    always_ff @(posedge clk) begin
        if (!rst_n) writes <= '0;
        else writes <= writes + 32'(line_ask && ask_ready[0]) - 32'(wrote);
    end
endmodule
