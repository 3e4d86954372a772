// A chip: a front of FRONTS converters that makes lists, and cores that render them; or the cores
// alone, whose jobs come from outside (FRONTS = 0).
//
// Tiles are dealt row by row, when all lists are written, to the first core that is ready, of those
// in the same cycle to the one of the lowest number. Each core and each converter have a port of the
// memory, converters the last ones, or all of them have one behind an arbiter; fields of ports are 32 bits
// wide. Pivots come from outside, for
// each core its own, in the order of its jobs. Reset: as its parts; `go` begins.
module chip #(
    parameter int CORES = 1,
    parameter int FRONTS = 1,
    parameter int ROWS = 128,
    parameter int CHUNK = 256,
    parameter int CHUNKS = 16,
    parameter int FEATURES = 64,
    parameter int SLOTS = 8,
    parameter int AHEAD = 1,
    parameter int QUEUE = 2,
    parameter int TILES = 2,
    parameter int OPS = 16,
    parameter int LINES = 64,
    // Bytes of a list, at most: 2^REGION.
    parameter int REGION = 14,
    // Whether all memory ports are behind one.
    parameter int ONE_PORT = 0,
    localparam int INNER = CORES + FRONTS,
    localparam int PORTS = ONE_PORT == 1 ? 1 : INNER
) (
    input  logic                    clk,
    input  logic                    rst_n,
    input  logic                    go,
    // Numbers and places of what lies in memory.
    input  logic [31:0]             gaussians,
    input  logic [31:0]             means,
    input  logic [31:0]             shapes,
    input  logic [31:0]             coefficients,
    input  logic [31:0]             features,
    input  logic [31:0]             lists,
    input  logic [31:0]             pixels,
    // 256 KiB for each core.
    input  logic [31:0]             spill,
    input  logic [18*24-1:0]        settings,
    input  logic [8:0]              tiles_x,
    input  logic [8:0]              tiles_y,
    input  logic [15:0]             width,
    input  logic [15:0]             height,
    input  logic [1:0]              degree,
    // Jobs from outside: address and entries of a list; column, row, width and height of a tile.
    input  logic                    job_valid,
    input  logic [31:0]             job_address,
    input  logic [15:0]             job_entries,
    input  logic [27:0]             job_tile,
    // Which core takes a job.
    output logic [31:0]             taken,
    input  logic [31:0]             pivot_valid,
    output logic [31:0]             pivot_ready,
    input  logic [CORES-1:0][63:0]  pivot_key,
    output logic [31:0]             ask_valid,
    input  logic [31:0]             ask_ready,
    output logic [31:0]             ask_write,
    output logic [PORTS-1:0][31:0]  ask_address,
    output logic [PORTS-1:0][31:0]  ask_bytes,
    output logic [PORTS-1:0][31:0]  ask_tag,
    output logic [PORTS-1:0][511:0] ask_data,
    input  logic [31:0]             come_valid,
    output logic [31:0]             come_ready,
    input  logic [PORTS-1:0][31:0]  come_tag,
    input  logic [PORTS-1:0][511:0] come_data,
    // All lists are written; nothing is left to do.
    output logic                    is_listed,
    output logic                    idle,
    // As those of core.
    output logic [CORES-1:0][31:0]  counts
);
    logic [INNER-1:0] in_ask_valid, in_ask_ready, in_ask_write, in_come_valid, in_come_ready;
    logic [INNER-1:0][31:0] in_ask_address, in_ask_bytes, in_ask_tag, in_come_tag;
    logic [INNER-1:0][511:0] in_ask_data, in_come_data;
    if (ONE_PORT == 1) begin : g_arbiter
        logic [15:0] tag;
        arbiter #(
            .PORTS(INNER)
        ) one (
            .clk(clk), .rst_n(rst_n), .ask_valid(in_ask_valid), .ask_ready(in_ask_ready),
            .ask_write(in_ask_write), .ask_address(in_ask_address), .ask_bytes(in_ask_bytes),
            .ask_tag(in_ask_tag), .ask_data(in_ask_data), .come_valid(in_come_valid),
            .come_ready(in_come_ready), .come_tag(tag), .one_valid(ask_valid[0]),
            .one_ready(ask_ready[0]), .one_write(ask_write[0]), .one_address(ask_address[0]),
            .one_bytes(ask_bytes[0]), .one_tag(ask_tag[0]), .one_data(ask_data[0]),
            .one_come_valid(come_valid[0]), .one_come_ready(come_ready[0]),
            .one_come_tag(come_tag[0]));
        for (genvar p = 0; p < INNER; p++) begin : g_come
            assign in_come_tag[p] = 32'(tag);
            assign in_come_data[p] = come_data[0];
        end
    end else begin : g_own
        assign ask_valid[PORTS-1:0] = in_ask_valid;
        assign in_ask_ready = ask_ready[PORTS-1:0];
        assign ask_write[PORTS-1:0] = in_ask_write;
        assign ask_address = in_ask_address;
        assign ask_bytes = in_ask_bytes;
        assign ask_tag = in_ask_tag;
        assign ask_data = in_ask_data;
        assign in_come_valid = come_valid[PORTS-1:0];
        assign come_ready[PORTS-1:0] = in_come_ready;
        assign in_come_tag = come_tag;
        assign in_come_data = come_data;
    end
    assign ask_valid[31:PORTS] = '0;
    assign ask_write[31:PORTS] = '0;
    assign come_ready[31:PORTS] = '0;

    logic [CORES-1:0] ready, gets, is_idle;
    logic offers;
    logic [31:0] address;
    logic [15:0] entries;
    logic [27:0] tile;
    assign taken = 32'(gets);

    for (genvar c = 0; c < CORES; c++) begin : g_core
        localparam logic [CORES-1:0] BEFORE = CORES'((64'd1 << c) - 64'd1);
        logic [6:0] bytes;
        logic [15:0] tag;
        logic [8:0] count;
        assign gets[c] = offers && ready[c] && (ready & BEFORE) == '0;
        assign in_ask_bytes[c] = 32'(bytes);
        assign in_ask_tag[c] = 32'(tag);
        assign counts[c] = 32'(count);
        core #(
            .ROWS(ROWS), .CHUNK(CHUNK), .CHUNKS(CHUNKS), .FEATURES(FEATURES), .SLOTS(SLOTS),
            .AHEAD(AHEAD), .QUEUE(QUEUE), .TILES(TILES)
        ) one (
            .clk(clk), .rst_n(rst_n), .features(features), .pixels(pixels),
            .spill(spill + (32'(c) << 18)), .tiles_x(tiles_x),
            .job_valid(gets[c]), .job_ready(ready[c]), .job_address(address),
            .job_entries(entries), .job_tile(tile),
            .pivot_valid(pivot_valid[c]), .pivot_ready(pivot_ready[c]),
            .pivot_key(pivot_key[c][39:0]),
            .ask_valid(in_ask_valid[c]), .ask_ready(in_ask_ready[c]), .ask_write(in_ask_write[c]),
            .ask_address(in_ask_address[c]), .ask_bytes(bytes), .ask_tag(tag),
            .ask_data(in_ask_data[c]),
            .come_valid(in_come_valid[c]), .come_ready(in_come_ready[c]), .come_tag(in_come_tag[c][15:0]),
            .come_data(in_come_data[c]), .idle(is_idle[c]), .counts(count));
    end
    assign pivot_ready[31:CORES] = '0;

    if (FRONTS == 0) begin : g_jobs
        assign offers = job_valid;
        assign address = job_address;
        assign entries = job_entries;
        assign tile = job_tile;
        assign is_listed = 1'b1;
        assign idle = &is_idle && !job_valid;
        logic unused;
        assign unused = &{1'b0, go, gaussians, means, shapes, coefficients, lists, settings,
            tiles_y, width, height, degree, pivot_valid};
    end else begin : g_front
        localparam int T = 12;
        logic [FRONTS-1:0][6:0] bytes;
        logic [FRONTS-1:0][15:0] tag, came;
        logic [8:0] x, y;
        logic [T-1:0] number;
        logic [REGION-3:0] count;
        logic is_dealt;
        for (genvar u = 0; u < FRONTS; u++) begin : g_port
            assign in_ask_bytes[CORES+u] = 32'(bytes[u]);
            assign in_ask_tag[CORES+u] = 32'(tag[u]);
            assign came[u] = in_come_tag[CORES+u][15:0];
        end
        front #(
            .OPS(OPS), .UNITS(FRONTS), .TILES(1 << T), .LINES(LINES), .REGION(REGION)
        ) one (
            .clk(clk), .rst_n(rst_n), .go(go), .gaussians(gaussians), .means(means),
            .shapes(shapes), .coefficients(coefficients), .features(features), .lists(lists),
            .settings(settings), .tiles_x(tiles_x), .tiles_y(tiles_y), .degree(degree),
            .ask_valid(in_ask_valid[CORES+:FRONTS]), .ask_ready(in_ask_ready[CORES+:FRONTS]),
            .ask_write(in_ask_write[CORES+:FRONTS]), .ask_address(in_ask_address[CORES+:FRONTS]),
            .ask_bytes(bytes), .ask_tag(tag), .ask_data(in_ask_data[CORES+:FRONTS]),
            .come_valid(in_come_valid[CORES+:FRONTS]), .come_ready(in_come_ready[CORES+:FRONTS]),
            .come_tag(came), .come_data(in_come_data[CORES+:FRONTS]), .count_tile(number),
            .count(count), .done(is_listed));

        // The pixels of a tile that are inside of the image.
        function automatic logic [4:0] inside_of(input logic [15:0] length, input logic [8:0] at);
            inside_of = length - {3'd0, at, 4'd0} < 16'd16 ? 5'(length - {3'd0, at, 4'd0}) : 5'd16;
        endfunction
        assign offers = is_listed && !is_dealt;
        assign address = lists + (32'(number) << REGION);
        assign entries = 16'(count);
        assign tile = {inside_of(height, y), inside_of(width, x), y, x};
        assign idle = is_dealt && &is_idle;
        always_ff @(posedge clk) begin
            if (!rst_n) begin
                x <= '0;
                y <= '0;
                number <= '0;
                is_dealt <= 1'b0;
            end else if (gets != '0) begin
                number <= number + 1'b1;
                x <= x + 9'd1 == tiles_x ? '0 : x + 9'd1;
                if (x + 9'd1 == tiles_x) begin
                    y <= y + 9'd1;
                    is_dealt <= y + 9'd1 == tiles_y;
                end
            end
        end
        logic unused;
        assign unused = &{1'b0, job_valid, job_address, job_entries, job_tile, pivot_valid};
    end
    logic unused;
    assign unused = &{1'b0, pivot_key, in_come_tag, ask_ready, come_valid};
endmodule
