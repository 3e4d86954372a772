// A core: from the list of a tile to its pixels.
//
//   job ─► core_lists ─► core_fetch ─► core_feed ─► vru ─► core_pixels
//          list, QSUs      │  ▲         order, record       │
//                          ▼  │ order                       │
//                        core_sort (BSU)                    │
//   memory port ◄── lists, then features, then pixels ◄─────┘
//
// One memory port: a request a cycle of up to 64 bytes with a tag, and an answer a cycle to each,
// writes included, in any order. Requests of lists go first, then those of features, then pixels.
// A list that has no room in the sorting buffer is spilled to 256 KiB at `spill`.
// Parameters are those of a machine file: the core's shares of the buffers in rows of 16 entries
// (`buffers.sorting` of 96 bytes a row, `buffers.feature` of 512) and tiles (`buffers.pixel-out` of
// 2,048 bytes), `geometry.chunk`, `vru.speculation`, `vru.subtile-queue`. Reset: no job, nothing
// on the way.
module core #(
    parameter int ROWS = 128,
    parameter int CHUNK = 256,
    parameter int CHUNKS = 16,
    parameter int FEATURES = 64,
    parameter int SLOTS = 8,
    parameter int AHEAD = 1,
    parameter int QUEUE = 2,
    parameter int TILES = 2
) (
    input  logic         clk,
    input  logic         rst_n,
    // Where records and pixels lie, and columns of tiles of the image.
    input  logic [31:0]  features,
    input  logic [31:0]  pixels,
    input  logic [31:0]  spill,
    input  logic [8:0]   tiles_x,
    // A tile: address and entries of its list; column, row, width, height inside the image.
    input  logic         job_valid,
    output logic         job_ready,
    input  logic [31:0]  job_address,
    input  logic [15:0]  job_entries,
    input  logic [27:0]  job_tile,
    input  logic         pivot_valid,
    output logic         pivot_ready,
    input  logic [39:0]  pivot_key,
    output logic         ask_valid,
    input  logic         ask_ready,
    output logic         ask_write,
    output logic [31:0]  ask_address,
    output logic [6:0]   ask_bytes,
    output logic [15:0]  ask_tag,
    output logic [511:0] ask_data,
    input  logic         come_valid,
    output logic         come_ready,
    input  logic [15:0]  come_tag,
    input  logic [511:0] come_data,
    // Nothing is left to do.
    output logic         idle,
    // From the lowest: QSUs at work, held up by banks, waiting for a list, for room or for those
    // behind; BSU at work; rendering unit at work, waiting for features, for the sorter, for room
    // of pixels.
    output logic [8:0]   counts
);
    localparam int E = 44;
    localparam int R = $clog2(ROWS);
    localparam int C = $clog2(CHUNKS);
    localparam int F = $clog2(FEATURES);
    localparam int S = $clog2(SLOTS);
    localparam int T = TILES > 1 ? $clog2(TILES) : 1;
    localparam logic [1:0] LIST = 2'd0;
    localparam logic [1:0] FEATURE = 2'd1;
    localparam logic [1:0] PIXEL = 2'd2;
    localparam logic [1:0] SPILL = 2'd3;

    logic lists_ready, tile_ready;
    assign job_ready = lists_ready && tile_ready;

    logic list_ask, list_asks, list_write, list_spill;
    logic [511:0] list_data, pixel_data;
    logic [31:0] list_address;
    logic [6:0] list_bytes;
    logic [11:0] list_beat;
    logic list_come;
    logic list_valid, list_ready, list_open, list_over;
    logic [C:0] list_chunks;
    logic [C-1:0] chunk_index;
    logic [R-1:0] chunk_head;
    logic [8:0] chunk_entries;
    logic chunk_drop, chunk_dropped;
    logic [1:0] read_valid, read_ready;
    logic unused;
    assign unused = &{1'b0, read_ready[0], come_tag};
    logic [1:0][R-1:0] read_row;
    logic [1:0][R-1:0] read_next;
    logic [16*E-1:0] read_data;
    logic qsu_working, qsu_conflict, qsu_reading, qsu_waiting;
    core_lists #(
        .ROWS(ROWS), .CHUNK(CHUNK), .CHUNKS(CHUNKS)
    ) lists (
        .clk(clk), .rst_n(rst_n),
        .job_valid(job_valid && tile_ready), .job_ready(lists_ready), .job_address(job_address),
        .job_entries(job_entries),
        .ask_valid(list_ask), .ask_ready(list_asks), .ask_write(list_write),
        .ask_spill(list_spill), .ask_address(list_address), .ask_bytes(list_bytes),
        .ask_beat(list_beat), .ask_data(list_data), .spill(spill),
        .come_valid(list_come), .come_beat(come_tag[13:2]), .come_data(come_data),
        .pivot_valid(pivot_valid), .pivot_ready(pivot_ready), .pivot_key(pivot_key),
        .list_valid(list_valid), .list_ready(list_ready), .list_chunks(list_chunks),
        .list_open(list_open), .list_over(list_over),
        .chunk_index(chunk_index), .chunk_head(chunk_head), .chunk_entries(chunk_entries),
        .chunk_drop(chunk_drop), .chunk_dropped(chunk_dropped),
        .read_valid(read_valid), .read_ready(read_ready), .read_row(read_row),
        .read_next(read_next), .read_data(read_data),
        .working(qsu_working), .in_conflict(qsu_conflict), .reading(qsu_reading),
        .waiting(qsu_waiting));

    logic sort_valid, sort_ready, sort_done, sort_working;
    logic [R-1:0] sort_head;
    logic [8:0] sort_entries;
    logic [F-1:0] sort_order;
    logic order_write;
    logic [F-1:0] order_row;
    logic [16*12-1:0] order_data;
    core_sort #(
        .ROWS(ROWS), .ORDER(FEATURES)
    ) sort (
        .clk(clk), .rst_n(rst_n),
        .chunk_valid(sort_valid), .chunk_ready(sort_ready), .chunk_head(sort_head),
        .chunk_entries(sort_entries), .chunk_order(sort_order),
        .read_valid(read_valid[0]), .read_row(read_row[0]), .read_next(read_next[0]),
        .read_data(read_data),
        .order_write(order_write), .order_row(order_row), .order_data(order_data),
        .done(sort_done), .working(sort_working));

    logic feature_ask, feature_asks, feature_come, feature_ready;
    logic [31:0] feature_address;
    logic [S+F+3:0] feature_tag;
    logic ready_valid, ready_take, ready_empty, ready_last;
    logic [8:0] ready_entries;
    logic [F-1:0] ready_row;
    logic is_fetching, is_sorting, over;
    logic feed_valid;
    logic [F-1:0] feed_row, record_base;
    logic [3:0] feed_place, feed_subtiles;
    logic [255:0] record;
    logic fetch_working, fetch_holds;
    core_fetch #(
        .ROWS(ROWS), .CHUNKS(CHUNKS), .FEATURES(FEATURES), .SLOTS(SLOTS), .AHEAD(AHEAD)
    ) fetch (
        .clk(clk), .rst_n(rst_n), .features(features),
        .list_valid(list_valid), .list_ready(list_ready), .list_chunks(list_chunks),
        .list_open(list_open), .list_over(list_over),
        .chunk_index(chunk_index), .chunk_head(chunk_head), .chunk_entries(chunk_entries),
        .chunk_drop(chunk_drop), .chunk_dropped(chunk_dropped),
        .read_valid(read_valid[1]), .read_ready(read_ready[1]), .read_row(read_row[1]),
        .read_next(read_next[1]), .read_data(read_data),
        .sort_valid(sort_valid), .sort_ready(sort_ready), .sort_head(sort_head),
        .sort_entries(sort_entries), .sort_order(sort_order), .sort_done(sort_done),
        .ask_valid(feature_ask), .ask_ready(feature_asks), .ask_address(feature_address),
        .ask_tag(feature_tag),
        .come_valid(feature_come), .come_ready(feature_ready), .come_tag(come_tag[2+:S+F+4]),
        .come_data(come_data[255:0]),
        .order_write(order_write), .order_row(order_row), .order_data(order_data),
        .ready_valid(ready_valid), .ready_take(ready_take), .ready_empty(ready_empty),
        .ready_last(ready_last), .ready_entries(ready_entries),
        .ready_row(ready_row), .is_fetching(is_fetching), .is_sorting(is_sorting), .over(over),
        .feed_valid(feed_valid), .feed_row(feed_row), .feed_place(feed_place),
        .feed_subtiles(feed_subtiles), .record_base(record_base), .record(record),
        .working(fetch_working), .holds(fetch_holds));

    logic unit_valid, unit_ready, unit_stopped;
    logic [1:0] unit_op;
    logic [143:0] unit_record;
    logic [3:0] unit_subtiles;
    logic [4:0] unit_width, unit_height;
    logic close_valid, close_ready;
    logic [27:0] close_tile;
    logic feed_idle;
    core_feed #(
        .FEATURES(FEATURES)
    ) feed (
        .clk(clk), .rst_n(rst_n),
        .tile_valid(job_valid && lists_ready), .tile_ready(tile_ready), .tile(job_tile),
        .ready_valid(ready_valid), .ready_take(ready_take), .ready_empty(ready_empty),
        .ready_last(ready_last), .ready_entries(ready_entries), .ready_row(ready_row), .over(over),
        .feed_valid(feed_valid), .feed_row(feed_row), .feed_place(feed_place),
        .feed_subtiles(feed_subtiles), .record_base(record_base), .record(record),
        .unit_valid(unit_valid), .unit_ready(unit_ready), .unit_op(unit_op),
        .unit_record(unit_record), .unit_subtiles(unit_subtiles), .unit_width(unit_width),
        .unit_height(unit_height), .unit_stopped(unit_stopped),
        .close_valid(close_valid), .close_ready(close_ready), .close_tile(close_tile),
        .idle(feed_idle));

    logic pixels_valid, pixels_ready;
    logic [1023:0] pixels_data;
    vru #(
        .QUEUE(QUEUE)
    ) unit (
        .clk(clk), .rst_n(rst_n), .in_valid(unit_valid), .in_ready(unit_ready), .in_op(unit_op),
        .in_record(unit_record), .in_bitmap(unit_subtiles), .open_width(unit_width),
        .open_height(unit_height), .stopped(unit_stopped), .out_valid(pixels_valid),
        .out_ready(pixels_ready), .out_pixels(pixels_data));

    logic pixel_ask, pixel_asks, last_in, is_full, pixels_idle;
    logic [31:0] pixel_address;
    logic [6:0] pixel_bytes;
    logic [T-1:0] pixel_tag;
    core_pixels #(
        .TILES(TILES)
    ) out (
        .clk(clk), .rst_n(rst_n), .pixels(pixels), .tiles_x(tiles_x),
        .close_valid(close_valid), .close_ready(close_ready), .close_tile(close_tile),
        .in_valid(pixels_valid), .in_ready(pixels_ready), .in_pixels(pixels_data),
        .write_valid(pixel_ask), .write_ready(pixel_asks), .write_address(pixel_address),
        .write_bytes(pixel_bytes), .write_tag(pixel_tag), .write_data(pixel_data),
        .done_valid(come_valid && come_tag[1:0] == PIXEL), .done_tag(come_tag[2+:T]),
        .last_in(last_in), .is_full(is_full), .idle(pixels_idle));

    // --- the memory port -------------------------------------------------------------------------

    assign list_asks = ask_ready;
    assign feature_asks = ask_ready && !list_ask;
    assign pixel_asks = ask_ready && !list_ask && !feature_ask;
    assign ask_valid = list_ask || feature_ask || pixel_ask;
    assign ask_write = list_ask ? list_write : !feature_ask;
    assign ask_data = list_ask ? list_data : pixel_data;
    always_comb begin
        if (list_ask) begin
            ask_address = list_address;
            ask_bytes = list_bytes;
            ask_tag = {2'd0, list_beat, list_spill ? SPILL : LIST};
        end else if (feature_ask) begin
            ask_address = feature_address;
            ask_bytes = 7'd32;
            ask_tag = {14'(feature_tag), FEATURE};
        end else begin
            ask_address = pixel_address;
            ask_bytes = pixel_bytes;
            ask_tag = {14'(pixel_tag), PIXEL};
        end
    end
    assign list_come = come_valid && (come_tag[1:0] == LIST || come_tag[1:0] == SPILL);
    assign feature_come = come_valid && come_tag[1:0] == FEATURE;
    assign come_ready = come_tag[1:0] != FEATURE || feature_ready;

    // --- what the units do -----------------------------------------------------------------------

    // A tile is open from the beat that opens it on; behind the one that closes it the unit drains.
    logic open, draining, starves;
    assign starves = open && !draining && unit_ready && !unit_valid;
    always_ff @(posedge clk) begin
        if (!rst_n) begin
            open <= 1'b0;
            draining <= 1'b0;
        end else begin
            if (last_in) begin
                draining <= 1'b0;
                open <= 1'b0;
            end
            if (unit_valid && unit_ready && unit_op == 2'd0) open <= 1'b1;
            if (unit_valid && unit_ready && unit_op == 2'd2) draining <= 1'b1;
        end
    end
    assign idle = lists_ready && !list_valid && !fetch_working && !fetch_holds && feed_idle
        && !open && !draining && pixels_idle && !sort_working;
    assign counts = {is_full, is_sorting, is_fetching,
        (open || draining || unit_valid) && !starves && !is_full, sort_working,
        qsu_waiting, qsu_reading, qsu_conflict, qsu_working};
endmodule
