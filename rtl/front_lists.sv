// Pairs into the lists of tiles: a pointer for each tile, and lines of 32 bytes that gather entries of
// 6 bytes until they are full.
//
// The list of tile t lies at `lists` + t 2^REGION. A line belongs to one of the tiles whose numbers
// are equal in the last bits; an entry of another one sends away what is in it, as a masked write.
// `flush` sends away all of them, one a cycle. An entry a cycle at most. Reset: lists and lines
// empty, which takes a cycle for each tile of the image (`is_clear`).
module front_lists #(
    parameter int TILES = 4096,
    parameter int LINES = 64,
    // Bytes of a list, at most: 2^REGION.
    parameter int REGION = 14,
    localparam int T = $clog2(TILES),
    localparam int L = $clog2(LINES),
    localparam int C = REGION - 2
) (
    input  logic         clk,
    input  logic         rst_n,
    input  logic [31:0]  lists,
    input  logic [8:0]   tiles_x,
    input  logic [8:0]   tiles_y,
    output logic         is_clear,
    input  logic         pair_valid,
    output logic         pair_ready,
    input  logic [T-1:0] pair_tile,
    input  logic [47:0]  pair_entry,
    input  logic         flush,
    output logic         is_flushed,
    output logic         write_valid,
    input  logic         write_ready,
    output logic [31:0]  write_address,
    output logic [5:0]   write_bytes,
    output logic [255:0] write_data,
    // Entries of a tile, when all is flushed.
    input  logic [T-1:0] count_tile,
    output logic [C-1:0] count
);
    // Fields of a line: its tile, its number in the list, first byte and bytes up to which it is
    // filled, and the bytes.
    localparam int N = REGION - 5;
    localparam int W = T + N + 5 + 6 + 256;
    logic [LINES-1:0] used;
    logic [L-1:0] at;
    logic [W-1:0] line, line_next;
    logic [T-1:0] line_tile;
    logic [N-1:0] line_number;
    logic [4:0] line_start;
    logic [5:0] line_fill;
    logic [255:0] line_data;
    logic write_line;
    assign {line_tile, line_number, line_start, line_fill, line_data} = line;

    logic [T-1:0] clearing;
    logic [8:0] column, row;
    logic [C-1:0] entries;
    logic counts;
    assign is_clear = row == tiles_y;
    assign count = entries;

    logic [L:0] flushing;
    logic flushes;
    assign is_flushed = flush && flushing == (L + 1)'(LINES);
    assign flushes = flush && !is_flushed;
    assign at = flushes ? flushing[L-1:0] : pair_tile[L-1:0];

    sram_async #(
        .WIDTH(C), .DEPTH(TILES)
    ) pointers (
        .clk(clk), .write(counts || !is_clear), .write_at(is_clear ? pair_tile : clearing),
        .write_data(is_clear ? entries + 1'b1 : '0), .read_at(flush ? count_tile : pair_tile),
        .read_data(entries));
    sram_async #(
        .WIDTH(W), .DEPTH(LINES)
    ) lines (
        .clk(clk), .write(write_line), .write_at(at), .write_data(line_next), .read_at(at),
        .read_data(line));

    // --- an entry joins its line -----------------------------------------------------------------

    logic is_own, is_other;
    logic [REGION-1:0] place;
    logic [4:0] start;
    logic [5:0] fill, fills;
    logic [N-1:0] number;
    logic [255:0] gathered;
    logic [303:0] joined;
    logic is_full;
    assign is_own = used[at] && line_tile == pair_tile;
    assign is_other = used[at] && !is_own;
    assign place = REGION'(entries) * REGION'(6);
    assign start = is_own ? line_start : place[4:0];
    assign fill = is_own ? line_fill : {1'b0, place[4:0]};
    assign number = is_own ? line_number : place[REGION-1:5];
    assign gathered = is_own ? line_data : '0;
    assign joined = {48'd0, gathered} | (304'(pair_entry) << {fill, 3'd0});
    assign fills = fill + 6'd6;
    assign is_full = fills >= 6'd32;

    // Sent away: a line of another tile, in whole or in part; one that is full; one that is flushed.
    logic sends_other, sends_full;
    logic [4:0] sent_start;
    logic [5:0] sent_end;
    logic [T-1:0] sent_tile;
    logic [N-1:0] sent_number;
    logic [255:0] sent;
    assign sends_other = (pair_valid && is_clear && !flush && is_other) || (flushes && used[at]);
    assign sends_full = pair_valid && is_clear && !flush && !is_other && is_full;
    assign sent_start = sends_other ? line_start : start;
    assign sent_end = sends_other ? line_fill : 6'd32;
    assign sent_tile = sends_other ? line_tile : pair_tile;
    assign sent_number = sends_other ? line_number : number;
    assign sent = sends_other ? line_data : joined[255:0];
    assign write_valid = sends_other || sends_full;
    assign write_address = lists + {{(32 - T - REGION) {1'b0}}, sent_tile, sent_number, sent_start};
    assign write_bytes = sent_end - {1'b0, sent_start};
    assign write_data = sent >> {sent_start, 3'd0};

    // A line leaves in the cycle in which the entry of another tile takes its place, but for an entry
    // that fills its line at once: that sends two.
    assign pair_ready = is_clear && !flush && (is_other ? !is_full && write_ready
        : !is_full || write_ready);
    assign counts = pair_valid && pair_ready;
    assign write_line = counts;
    assign line_next = is_full
        ? {pair_tile, number + 1'b1, 5'd0, fills - 6'd32, 208'd0, joined[303:256]}
        : {pair_tile, number, start, fills, joined[255:0]};

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            used <= '0;
            clearing <= '0;
            column <= '0;
            row <= '0;
            flushing <= '0;
        end else begin
            if (!is_clear) begin
                clearing <= clearing + 1'b1;
                column <= column + 9'd1 == tiles_x ? '0 : column + 9'd1;
                if (column + 9'd1 == tiles_x) row <= row + 9'd1;
            end
            if (counts) used[at] <= !(is_full && fills == 6'd32);
            else if (sends_other && write_ready) used[at] <= 1'b0;
            if (flushes && (!used[at] || write_ready)) flushing <= flushing + 1'b1;
        end
    end
endmodule
