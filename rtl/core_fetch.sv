// Chunk issue and feature buffer of a core: asks for the features of chunks in the order of their
// lists, and holds them, with the order in which they are blended, until they have been.
//
// The buffer is a ring of rows of 16 records. A chunk begins when its rows are free and one of SLOTS
// places of chunks is; then it is queued at the sorter, and its features are asked for, one a cycle,
// in the order of the sorting buffer. Answers may come in any order. A chunk is ready when it is in
// order and complete. Chunks of a list that are not the first one are asked for only if at most
// AHEAD chunks of the list are in front of them: nobody knows before how much of a list is needed.
// The next list begins when all chunks of this one have been asked for, or when its tile is `over`;
// what was asked for in vain leaves when it has come, and what was not is dropped.
// Reset: no list, buffer empty.
module core_fetch #(
    parameter int ROWS = 128,
    parameter int CHUNKS = 16,
    // Rows of the feature buffer, and chunks in it.
    parameter int FEATURES = 64,
    parameter int SLOTS = 8,
    parameter int AHEAD = 1,
    localparam int E = 44,
    localparam int R = $clog2(ROWS),
    localparam int C = $clog2(CHUNKS),
    localparam int F = $clog2(FEATURES),
    localparam int S = $clog2(SLOTS)
) (
    input  logic             clk,
    input  logic             rst_n,
    input  logic [31:0]      features,
    input  logic             list_valid,
    output logic             list_ready,
    // Chunks that are there; more of the list will come; nobody wants more of it.
    input  logic [C:0]       list_chunks,
    input  logic             list_open,
    output logic             list_over,
    output logic [C-1:0]     chunk_index,
    input  logic [R-1:0]     chunk_head,
    input  logic [8:0]       chunk_entries,
    output logic             chunk_drop,
    input  logic             chunk_dropped,
    output logic             read_valid,
    input  logic             read_ready,
    output logic [R-1:0]     read_row,
    input  logic [R-1:0]     read_next,
    input  logic [16*E-1:0]  read_data,
    // Towards the sorter.
    output logic             sort_valid,
    input  logic             sort_ready,
    output logic [R-1:0]     sort_head,
    output logic [8:0]       sort_entries,
    output logic [F-1:0]     sort_order,
    input  logic             sort_done,
    // Reads of a record of 32 bytes.
    output logic             ask_valid,
    input  logic             ask_ready,
    output logic [31:0]      ask_address,
    output logic [S+F+3:0]   ask_tag,
    input  logic             come_valid,
    output logic             come_ready,
    input  logic [S+F+3:0]   come_tag,
    input  logic [255:0]     come_data,
    // The order of chunks.
    input  logic             order_write,
    input  logic [F-1:0]     order_row,
    input  logic [16*12-1:0] order_data,
    // The oldest chunk, or a list without any.
    output logic             ready_valid,
    input  logic             ready_take,
    output logic             ready_empty,
    output logic             ready_last,
    output logic [8:0]       ready_entries,
    output logic [F-1:0]     ready_row,
    // Why there is none: features are on their way; it is being sorted.
    output logic             is_fetching,
    output logic             is_sorting,
    // The tile of the oldest chunk is over: the rest of its list is not needed.
    input  logic             over,
    // An entry by row and place: sub-tiles in the next cycle, the record in the one behind.
    input  logic             feed_valid,
    input  logic [F-1:0]     feed_row,
    input  logic [3:0]       feed_place,
    output logic [3:0]       feed_subtiles,
    input  logic [F-1:0]     record_base,
    output logic [255:0]     record,
    // A list has chunks that have not been asked for; chunks are in the buffer.
    output logic             working,
    output logic             holds
);
    // --- the ring and its chunks -----------------------------------------------------------------

    logic [F-1:0] ring_head;
    logic [F:0] ring_used;
    logic [S-1:0] oldest, newest;
    logic [S:0] held;
    logic [SLOTS-1:0][8:0] slot_entries, slot_missing;
    logic [SLOTS-1:0][F-1:0] slot_row;
    logic [SLOTS-1:0] slot_first, slot_last, slot_empty, slot_sorted, slot_dropped;
    logic [F:0] oldest_rows, chunk_rows;
    assign oldest_rows = (F + 1)'((32'(slot_entries[oldest]) + 32'd15) >> 4);
    assign chunk_rows = (F + 1)'((32'(chunk_entries) + 32'd15) >> 4);

    // --- the list whose chunks are asked for -----------------------------------------------------

    logic has_list;
    logic [C:0] next_chunk;
    // Chunks of this list in the buffer.
    logic [C:0] in_front;
    logic [SLOTS-1:0] drop;
    logic is_of_list;
    logic list_is_over;
    logic begins, passes;
    logic asking;
    logic [R-1:0] walk;
    logic [8:0] to_ask;
    logic [S-1:0] asking_slot;
    logic [F-1:0] asking_row;
    logic has_row;
    logic row_comes;
    logic [16*E-1:0] row_now;
    logic [3:0] place;
    logic [15:0][E-1:0] row_entries;

    assign chunk_index = C'(next_chunk);
    assign chunk_drop = has_list && list_is_over && next_chunk != list_chunks;
    assign list_over = has_list && list_is_over;
    assign in_front = 32'(held) < 32'(next_chunk) ? (C + 1)'(held) : next_chunk;
    assign begins = has_list && !list_is_over && !over && next_chunk != list_chunks && !asking
        && 32'(in_front) <= AHEAD && held != (S + 1)'(SLOTS) && queue_ready
        && 32'(ring_used) + 32'(chunk_rows) <= FEATURES;
    // A list without chunks passes when nothing waits in front of it.
    assign passes = has_list && list_chunks == '0 && !list_open && held == '0;
    assign working = has_list;
    assign holds = held != '0;
    assign list_ready = !has_list;

    // --- the sorter's queue ----------------------------------------------------------------------

    logic queue_ready;
    fifo #(
        .WIDTH(R + 9 + F), .DEPTH(SLOTS)
    ) queue (
        .clk(clk), .rst_n(rst_n), .in_valid(begins), .in_ready(queue_ready),
        .in_data({chunk_head, chunk_entries, F'(ring_head)}),
        .out_valid(sort_valid), .out_ready(sort_ready),
        .out_data({sort_head, sort_entries, sort_order}));
    // Chunks are sorted in their order.
    logic [S-1:0] sorting;

    // --- features are asked for ------------------------------------------------------------------

    assign read_valid = asking && !has_row && !row_comes;
    assign read_row = walk;
    assign row_entries = row_now;
    assign ask_valid = has_row;
    assign ask_address = features + {3'd0, row_entries[place][23:0], 5'd0};
    assign ask_tag = {asking_slot, asking_row, place};
    logic last_of_row;
    assign last_of_row = place == 4'd15 || to_ask == 9'd1;

    // --- records ---------------------------------------------------------------------------------

    // One port: what is blended goes first.
    logic feeds;
    logic [F+3:0] feed_record;
    logic [16*12-1:0] order;
    logic [3:0] order_place;
    logic [11:0] entry;
    assign come_ready = !feeds;
    assign entry = order[12*32'(order_place)+:12];
    assign feed_subtiles = entry[3:0];
    assign feed_record = {record_base, 4'd0} + (F + 4)'(entry[11:4]);
    sram #(
        .WIDTH(16 * 12), .DEPTH(FEATURES)
    ) orders (
        .clk(clk), .write(order_write), .write_at(order_row), .write_data(order_data),
        .read(feed_valid), .read_at(feed_row), .read_data(order));
    sram #(
        .WIDTH(256), .DEPTH(16 * FEATURES)
    ) records (
        .clk(clk), .write(come_valid && come_ready), .write_at(come_tag[F+3:0]),
        .write_data(come_data), .read(feeds), .read_at(feed_record), .read_data(record));
    always_ff @(posedge clk) begin
        if (feed_valid) order_place <= feed_place;
    end
    always_ff @(posedge clk) begin
        if (!rst_n) feeds <= 1'b0;
        else feeds <= feed_valid;
    end

    // --- the oldest chunk ------------------------------------------------------------------------

    logic is_complete, is_there;
    logic drops, leaves;
    assign is_there = held != '0;
    assign is_complete = slot_missing[oldest] == '0;
    assign ready_valid = is_there && !slot_dropped[oldest] && is_complete && slot_sorted[oldest];
    assign ready_empty = slot_empty[oldest];
    assign ready_last = slot_last[oldest];
    assign ready_entries = slot_entries[oldest];
    assign ready_row = slot_row[oldest];
    assign is_fetching = is_there && !slot_dropped[oldest] && !is_complete;
    assign is_sorting = is_there && !slot_dropped[oldest] && is_complete && !slot_sorted[oldest];
    // What is not needed leaves when all of it has come and the sorter is done with it.
    assign drops = is_there && slot_dropped[oldest] && is_complete && slot_sorted[oldest];
    assign leaves = ready_take || drops;

    logic arrives;
    assign arrives = come_valid && come_ready;

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            ring_head <= '0;
            ring_used <= '0;
            oldest <= '0;
            newest <= '0;
            sorting <= '0;
            held <= '0;
            has_list <= 1'b0;
            asking <= 1'b0;
            has_row <= 1'b0;
            row_comes <= 1'b0;
        end else begin
            if (list_valid && list_ready) has_list <= 1'b1;
            else if (passes || (has_list && list_chunks != '0 && !list_open && !asking
                && next_chunk == list_chunks))
                has_list <= 1'b0;
            held <= held + (S + 1)'(begins || passes) - (S + 1)'(leaves);
            ring_used <= ring_used + (begins ? chunk_rows : '0) - (leaves ? oldest_rows : '0);
            if (begins) ring_head <= ring_head + F'(chunk_rows);
            if (begins || passes) newest <= newest + 1'b1;
            if (leaves) oldest <= oldest + 1'b1;
            if (begins) asking <= 1'b1;
            else if (ask_valid && ask_ready && to_ask == 9'd1) asking <= 1'b0;
            row_comes <= read_valid && read_ready;
            if (row_comes) has_row <= 1'b1;
            else if (ask_valid && ask_ready && last_of_row) has_row <= 1'b0;
            if (passes) sorting <= sorting + 1'b1;
            else if (sort_done) sorting <= sorting + 1'b1;
        end
    end

    always_ff @(posedge clk) begin
        if (list_valid && list_ready) begin
            next_chunk <= '0;
            list_is_over <= 1'b0;
        end else begin
            if (begins || chunk_dropped) next_chunk <= next_chunk + 1'b1;
            if (over && is_of_list) list_is_over <= 1'b1;
        end
        if (begins || passes) begin
            slot_entries[newest] <= passes ? '0 : chunk_entries;
            slot_row[newest] <= ring_head;
            slot_first[newest] <= passes || next_chunk == '0;
            slot_last[newest] <= passes || (next_chunk + 1'b1 == list_chunks && !list_open);
            slot_empty[newest] <= passes;
            slot_sorted[newest] <= passes;
            slot_dropped[newest] <= 1'b0;
        end
        if (sort_done) slot_sorted[sorting] <= 1'b1;
        for (int s = 0; s < SLOTS; s++) begin
            if ((begins || passes) && newest == S'(s)) slot_missing[s] <= passes ? '0 : chunk_entries;
            else if (arrives && come_tag[F+4+:S] == S'(s)) slot_missing[s] <= slot_missing[s] - 9'd1;
            if (over && drop[s]) slot_dropped[s] <= 1'b1;
        end
        if (begins) begin
            walk <= chunk_head;
            to_ask <= chunk_entries;
            asking_slot <= newest;
            asking_row <= ring_head;
        end else begin
            if (read_valid && read_ready) walk <= read_next;
            if (row_comes) begin
                row_now <= read_data;
                place <= '0;
            end else if (ask_valid && ask_ready) begin
                place <= place + 4'd1;
                to_ask <= to_ask - 9'd1;
                if (last_of_row) asking_row <= asking_row + 1'b1;
            end
        end
    end

    // Behind the chunk that leaves now, those of the tile that is over: up to the next first one.
    // Without any such one, what is asked for is of this tile, too.
    logic goes_on;
    always_comb begin
        goes_on = 1'b1;
        drop = '0;
        for (int k = 0; k < SLOTS; k++) begin
            if (k >= 32'(ready_take) && k < 32'(held)) begin
                if (slot_first[S'(32'(oldest) + k)]) goes_on = 1'b0;
                if (goes_on) drop[S'(32'(oldest) + k)] = 1'b1;
            end
        end
    end
    assign is_of_list = goes_on && has_list && next_chunk != '0;
endmodule
