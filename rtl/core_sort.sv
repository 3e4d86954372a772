// Sorts chunks: rows of 16 entries are sorted by the bitonic network on their way from the sorting
// buffer, then merged in pairs of lists, level by level, between two memories of a chunk each.
//
// A list without a partner stays where it is, so each row says in which memory it lies: a row that
// leaves goes to the other memory than the row whose place it takes. The last level writes the
// order of the chunk: for each entry its place among those that were fetched, and its sub-tiles.
//
// A chunk of r rows takes a cycle to read the first one, r + 4 for all of them, and for each level
// four more than the rows that have a partner. Reset: no chunk. `chunk_ready` depends on registers
// only; the sorter is first at the sorting buffer.
module core_sort #(
    // Rows of the sorting buffer.
    parameter int ROWS = 128,
    // Rows of the order, one for each of the feature buffer.
    parameter int ORDER = 64,
    localparam int E = 44,
    localparam int R = $clog2(ROWS),
    localparam int O = $clog2(ORDER),
    localparam int W = E + 8
) (
    input  logic              clk,
    input  logic              rst_n,
    input  logic              chunk_valid,
    output logic              chunk_ready,
    input  logic [R-1:0]      chunk_head,
    input  logic [8:0]        chunk_entries,
    input  logic [O-1:0]      chunk_order,
    output logic              read_valid,
    output logic [R-1:0]      read_row,
    input  logic [R-1:0]      read_next,
    input  logic [16*E-1:0]   read_data,
    output logic              order_write,
    output logic [O-1:0]      order_row,
    output logic [16*12-1:0]  order_data,
    // The chunk is in order.
    output logic              done,
    output logic              working
);
    logic busy;
    logic accepts;
    logic merging;
    logic [R-1:0] walk;
    logic [8:0] entries;
    logic [O-1:0] order;
    logic [4:0] rows;
    logic [4:0] asked, left;
    // Rows of the lists of this level: 1, 2, 4, 8.
    logic [4:0] list;

    logic is_one_row;
    logic is_last;
    assign rows = 5'((32'(entries) + 32'd15) >> 4);
    assign is_one_row = rows == 5'd1;
    assign is_last = merging ? 2 * list >= rows : is_one_row;
    assign accepts = chunk_valid && !busy;
    assign working = busy;

    // --- rows come from the sorting buffer -------------------------------------------------------

    logic comes;
    logic [4:0] coming;
    logic [16*W-1:0] fresh;
    assign read_valid = accepts || (busy && !merging && asked != rows);
    assign read_row = accepts ? chunk_head : walk;
    for (genvar i = 0; i < 16; i++) begin : g_entry
        logic [8:0] place;
        logic [E-1:0] entry;
        assign place = {coming, 4'(i)};
        assign entry = read_data[i*E+:E];
        // Depth, number, place, sub-tiles: what is compared is decided before the last two.
        assign fresh[i*W+:W] = place < entries ? {entry[39:0], place[7:0], entry[43:40]} : '1;
    end

    // --- the two memories ------------------------------------------------------------------------

    logic [15:0] where;
    logic [4:0] a_row, b_row;
    logic to;
    logic [1:0][16*W-1:0] a_rows, b_rows;
    logic out_valid;
    logic [16*W-1:0] out_row;
    assign to = merging && !where[left[3:0]];
    for (genvar m = 0; m < 2; m++) begin : g_memory
        sram_async #(
            .WIDTH(16 * W), .DEPTH(16), .READS(2)
        ) memory (
            .clk(clk), .write(out_valid && to == (m == 1)), .write_at(left[3:0]),
            .write_data(out_row), .read_at({b_row[3:0], a_row[3:0]}),
            .read_data({b_rows[m], a_rows[m]}));
    end

    // --- pairs of lists --------------------------------------------------------------------------

    // Rows that are in pairs: all, or all but the last list.
    logic [4:0] lists;
    logic [4:0] paired;
    logic [4:0] shift;
    assign lists = 5'((rows + list - 5'd1) >> shift);
    assign paired = lists[0] ? 5'((lists - 5'd1) << shift) : rows;

    logic a_valid, a_ready, a_last, b_valid, b_ready, b_last;
    assign a_valid = busy && merging && a_row < paired;
    assign b_valid = busy && merging && b_row < paired;
    assign a_last = (a_row & (list - 5'd1)) == list - 5'd1;
    assign b_last = (b_row & (list - 5'd1)) == list - 5'd1 || b_row + 5'd1 == rows;

    logic sorted_ready;
    bsu #(
        .ENTRY(W)
    ) unit (
        .clk(clk), .rst_n(rst_n),
        .sort_valid(comes), .sort_ready(sorted_ready), .sort_row(fresh),
        .a_valid(a_valid), .a_ready(a_ready), .a_last(a_last),
        .a_row(a_rows[where[a_row[3:0]]]),
        .b_valid(b_valid), .b_ready(b_ready), .b_last(b_last),
        .b_row(b_rows[where[b_row[3:0]]]),
        .out_valid(out_valid), .out_ready(1'b1), .out_row(out_row));

    logic [4:0] due;
    logic ends_level;
    assign due = merging ? paired : rows;
    assign ends_level = busy && out_valid && left + 5'd1 == due;
    assign done = ends_level && is_last;
    assign chunk_ready = !busy;
    assign order_write = out_valid && is_last;
    assign order_row = order + O'(left);
    for (genvar i = 0; i < 16; i++) begin : g_order
        assign order_data[12*i+:12] = out_row[i*W+:12];
    end

    logic unused;
    assign unused = &{1'b0, sorted_ready, out_row};

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            busy <= 1'b0;
            comes <= 1'b0;
        end else begin
            if (accepts) busy <= 1'b1;
            else if (done) busy <= 1'b0;
            comes <= read_valid;
        end
    end

    always_ff @(posedge clk) begin
        coming <= accepts ? '0 : asked;
        if (read_valid) walk <= read_next;
        if (accepts) begin
            entries <= chunk_entries;
            order <= chunk_order;
            merging <= 1'b0;
            asked <= 5'd1;
            left <= '0;
            list <= 5'd1;
            shift <= '0;
            where <= '0;
        end else if (busy) begin
            if (read_valid) asked <= asked + 5'd1;
            if (a_valid && a_ready) begin
                // Behind the list is its partner, then the next list.
                a_row <= a_last ? a_row + list + 5'd1 : a_row + 5'd1;
            end
            if (b_valid && b_ready) b_row <= b_last ? b_row + list + 5'd1 : b_row + 5'd1;
            if (out_valid) left <= left + 5'd1;
            if (ends_level) begin
                merging <= 1'b1;
                left <= '0;
                a_row <= '0;
                if (merging) begin
                    for (int r = 0; r < 16; r++) if (r < 32'(paired)) where[r] <= !where[r];
                    list <= list << 1;
                    shift <= shift + 5'd1;
                    b_row <= list << 1;
                end else begin
                    b_row <= 5'd1;
                end
            end
        end
    end
endmodule
