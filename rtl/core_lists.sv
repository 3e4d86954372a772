// List fetch of a core: reads the list of a job into the sorting buffer, and splits it by depth until
// every part fits a chunk.
//
// The sorting buffer has rows of 16 entries in 16 banks of one entry, with a read and a write port
// each. Rows are dealt from a list of free ones and chained, so a part may grow to any length while
// the rows that it is made of are given back. A list is read when its rows, and one more for each
// part if it has to be split, are free. Two quick sorting units share each list: entries of even and
// odd places go to one each. An entry that meets a bank that another one writes waits a cycle.
//
// A list that has no room in the whole buffer is split while it comes, up to WINDOW rows of it at a
// time, while a chunk of the list before may still be there; the buffer has 64 rows at least. When
// fewer than LOW rows are free, the first row of the part that is needed last is written to memory,
// at `spill`; the last row of a part stays. Then its parts are taken in turn: one that is a chunk
// gets its rows back, and is there for those behind; one that is longer is split again, from the
// rows that have stayed and those that come back, which spills in the same way. When its tile is
// over, what is left of it is dropped where it is.
//
// Splits go two levels deep: CHUNK, 8 CHUNK and 64 CHUNK entries are the longest lists of none, one
// and two. Pivots come from outside, seven for each split in the order of the splits; they are
// whole keys (depth, then number), so that parts have the lengths that their pivots stand for.
//
// A row is read twice by those behind: by the sorter and by the fetch. The second one frees it. The
// rows of a chunk that nobody wants are freed all at once.
// Reset: no job, all rows free. No `ready` depends on a `valid` of the same cycle.
module core_lists #(
    // Rows of the sorting buffer.
    parameter int ROWS = 128,
    // Entries of a chunk, at most 256.
    parameter int CHUNK = 256,
    // Chunks of a list, at most.
    parameter int CHUNKS = 16,
    // Rows below which a list that has no room is written out, and rows of it on their way.
    parameter int LOW = 10,
    localparam int WINDOW = 16,
    localparam int E = 44,
    localparam int R = $clog2(ROWS),
    localparam int C = $clog2(CHUNKS)
) (
    input  logic            clk,
    input  logic            rst_n,
    // A list: address of its first byte, and its entries of 6 bytes.
    input  logic            job_valid,
    output logic            job_ready,
    input  logic [31:0]     job_address,
    input  logic [15:0]     job_entries,
    // Reads of up to ten entries; what is spilled, and its way back.
    output logic            ask_valid,
    input  logic            ask_ready,
    output logic            ask_write,
    output logic            ask_spill,
    output logic [31:0]     ask_address,
    output logic [6:0]      ask_bytes,
    output logic [11:0]     ask_beat,
    output logic [511:0]    ask_data,
    // Where 16 parts of 16 KiB go.
    input  logic [31:0]     spill,
    input  logic            come_valid,
    input  logic [11:0]     come_beat,
    input  logic [511:0]    come_data,
    input  logic            pivot_valid,
    output logic            pivot_ready,
    input  logic [39:0]     pivot_key,
    // A list that is split; whoever takes it reads its chunks by number until it takes the next.
    // Chunks of one that is `open` are still being added. Nobody wants more of it: `over`.
    output logic            list_valid,
    input  logic            list_ready,
    output logic [C:0]      list_chunks,
    output logic            list_open,
    input  logic            list_over,
    input  logic [C-1:0]    chunk_index,
    output logic [R-1:0]    chunk_head,
    output logic [8:0]      chunk_entries,
    // The chunk is not wanted.
    input  logic            chunk_drop,
    output logic            chunk_dropped,
    // Rows for the sorter (0, first served) and for the fetch (1); data come a cycle behind `ready`.
    input  logic [1:0]      read_valid,
    output logic [1:0]      read_ready,
    input  logic [1:0][R-1:0] read_row,
    output logic [1:0][R-1:0] read_next,
    output logic [16*E-1:0] read_data,
    // For counters: at work; held up by banks; waiting for entries; for room or for those behind.
    output logic            working,
    output logic            in_conflict,
    output logic            reading,
    output logic            waiting
);
    localparam int PARTS = 8;
    localparam int PIVOTS = PARTS - 1;
    // Rows of a chunk.
    localparam int HELD = CHUNK / 16;
    localparam logic [2:0] IDLE = 3'd0;
    localparam logic [2:0] ROOM = 3'd1;
    localparam logic [2:0] READ = 3'd2;
    localparam logic [2:0] PIVOT = 3'd3;
    localparam logic [2:0] SPLIT = 3'd4;
    localparam logic [2:0] PICK = 3'd5;
    localparam logic [2:0] READY = 3'd6;
    // What of a list was written out comes back, or nobody wants it.
    localparam logic [2:0] FILL = 3'd7;

    logic [2:0] state;
    // A list that has no room, and one that is dropped.
    logic streams, drops;
    // Whether somebody has taken it.
    logic is_taken;

    // Chunks of two lists: of the one that is split, and of the one whose chunks are taken.
    logic bank_now;
    logic [1:0][CHUNKS-1:0][R-1:0] table_head;
    logic [1:0][CHUNKS-1:0][R-1:0] table_tail;
    logic [1:0][CHUNKS-1:0][8:0] table_count;

    // --- rows ------------------------------------------------------------------------------------

    logic [ROWS-1:0][R-1:0] next;
    logic [ROWS-1:0] seen;
    // Free rows are chained, too; those that were never used are numbered on.
    logic [R-1:0] free_head, free_tail;
    logic [R:0] free_count;
    logic [R:0] fresh;
    logic is_fresh;
    logic takes;
    logic [R-1:0] taken;
    logic gives;
    logic [R-1:0] given, given_end;
    logic [R:0] given_rows;
    logic has_free;
    logic [R:0] chained;
    assign has_free = free_count != '0;
    assign is_fresh = fresh != (R + 1)'(ROWS);
    assign chained = free_count - ((R + 1)'(ROWS) - fresh);
    assign taken = is_fresh ? fresh[R-1:0] : free_head;

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            free_count <= (R + 1)'(ROWS);
            fresh <= '0;
        end else begin
            free_count <= free_count + (gives ? given_rows : '0) - (R + 1)'(takes);
            if (takes && is_fresh) fresh <= fresh + 1'b1;
        end
        // Without any, or with the last one taken, what is given is the first.
        if (gives && (chained == '0 || (takes && !is_fresh && chained == (R + 1)'(1)))) free_head <= given;
        else if (takes && !is_fresh) free_head <= next[free_head];
        if (gives) free_tail <= given_end;
    end

    // --- reading rows ----------------------------------------------------------------------------

    logic source_asks;
    logic [R-1:0] source_row;
    logic source_gets;
    logic reads;
    logic [R-1:0] row;
    assign read_ready = {!read_valid[0], 1'b1};
    // A row that is written out goes last.
    logic leave_asks, leave_gets;
    logic [R-1:0] leave_row;
    assign source_gets = source_asks && read_valid == '0;
    assign leave_gets = leave_asks && !source_asks && read_valid == '0;
    assign reads = read_valid != '0 || source_asks || leave_asks;
    assign row = read_valid[0] ? read_row[0] : read_valid[1] ? read_row[1]
        : source_asks ? source_row : leave_row;
    for (genvar i = 0; i < 2; i++) begin : g_next
        assign read_next[i] = next[read_row[i]];
    end
    // A row of a list that is split is used up at once.
    logic gives_row, gives_part;
    logic [R-1:0] left_head, left_tail;
    logic [R:0] left_rows;
    assign gives_row = source_gets || leave_gets || (read_valid != '0 && seen[row]);
    assign chunk_dropped = chunk_drop && !gives_row;
    assign gives = gives_row || chunk_dropped || gives_part;
    always_comb begin
        given = row;
        given_end = row;
        given_rows = (R + 1)'(1);
        if (chunk_dropped) begin
            given = chunk_head;
            given_end = table_tail[!bank_now][chunk_index];
            given_rows = (R + 1)'((32'(chunk_entries) + 32'd15) >> 4);
        end else if (gives_part) begin
            given = left_head;
            given_end = left_tail;
            given_rows = left_rows;
        end
    end
    always_ff @(posedge clk) begin
        if (!rst_n) seen <= '0;
        else if (read_valid != '0) seen[row] <= !seen[row];
    end

    // --- writing entries -------------------------------------------------------------------------

    logic [15:0] write;
    logic [15:0][R-1:0] write_row;
    logic [15:0][E-1:0] write_data;
    for (genvar b = 0; b < 16; b++) begin : g_bank
        sram #(
            .WIDTH(E), .DEPTH(ROWS)
        ) bank (
            .clk(clk), .write(write[b]), .write_at(write_row[b]), .write_data(write_data[b]),
            .read(reads), .read_at(row), .read_data(read_data[b*E+:E]));
    end

    // --- entries arrive --------------------------------------------------------------------------

    // The list, or what of a part was written out: address, entries, those that were asked for and
    // those that came.
    logic [31:0] address;
    logic [15:0] entries, asked, got;
    logic [10:0] beat;
    logic [ROWS-1:0][R-1:0] place_row;
    logic [11:0] rows_now, rows_due;
    logic [R-1:0] head, tail;
    logic [3:0] wanted, came;
    logic needs_row;
    logic is_back;
    logic asks, comes, is_written;
    logic may_ask;
    // A row on its way out, in two requests.
    logic leaves, leave_second;
    logic [31:0] leave_address;
    // Rows of a list that has no room: how many were taken on, and entries of each of those under way.
    logic [11:0] rows_gone;
    logic [15:0][4:0] filled;
    assign wanted = entries - asked < 16'd10 ? 4'(entries - asked) : 4'd10;
    assign rows_due = 12'((32'(asked) + 32'(wanted) + 32'd15) >> 4);
    assign needs_row = rows_due != rows_now;
    always_comb begin
        may_ask = state == READ;
        if (state == FILL) may_ask = !drops && (!needs_row || has_free);
        if (streams && (state == PIVOT || state == SPLIT)) begin
            may_ask = !needs_row
                || (rows_now - rows_gone < 12'(WINDOW)
                    && 32'(free_count) >= (is_chain ? LOW + PARTS : LOW));
        end
        if (asked == entries) may_ask = 1'b0;
    end
    assign ask_valid = leaves || may_ask;
    assign ask_write = leaves;
    assign ask_spill = leaves || is_back;
    assign asks = !leaves && may_ask && ask_ready;
    assign ask_address = leaves ? leave_address : address + 32'd6 * 32'(asked);
    assign ask_bytes = leaves ? leave_second ? 7'd32 : 7'd64 : 7'd6 * 7'(wanted);
    assign ask_beat = {leaves, beat};
    assign comes = come_valid && !come_beat[11];
    assign is_written = come_valid && come_beat[11];
    assign came = 32'(entries) - 32'd10 * 32'(come_beat) < 32'd10
        ? 4'(32'(entries) - 32'd10 * 32'(come_beat)) : 4'd10;

    // Where in an answer the entry of a bank is: banks behind its first one are in the same row of
    // the list, those before in the next one.
    logic [15:0] come_first;
    logic [15:0][3:0] come_place;
    logic [15:0] comes_next;
    logic [R-1:0] this_row, next_row;
    logic [11:0] this_number;
    assign come_first = 16'(10 * 32'(come_beat));
    assign this_number = come_first[15:4];
    assign this_row = place_row[place_of(this_number)];
    assign next_row = place_row[place_of(this_number + 12'd1)];
    for (genvar b = 0; b < 16; b++) begin : g_come
        assign come_place[b] = 4'(b) - come_first[3:0];
        assign comes_next[b] = 1'((5'(come_place[b]) + 5'(come_first[3:0])) >> 4);
    end

    // Where the number of a row's row is kept; rows of a list that has no room are few at a time.
    function automatic logic [R-1:0] place_of(input logic [11:0] number);
        place_of = R'(number & {{8{!streams}}, 4'd15});
    endfunction

    // Entries of an answer that belong to the row of its first one, and to the next.
    logic [4:0] fills_this, fills_next;
    always_comb begin
        fills_this = 5'd16 - 5'(come_first[3:0]);
        if (5'(came) < fills_this) fills_this = 5'(came);
        fills_next = 5'(came) - fills_this;
    end

    // Rows that a list needs: its own, and one for each part that is begun.
    logic [12:0] room;
    assign room = 13'((32'(entries) + 32'd15) >> 4) + (32'(entries) > CHUNK ? 13'(PARTS) : '0);

    // --- splits ----------------------------------------------------------------------------------

    // The parts of two levels; those of the second belong to part `outer` of the first. `spilled`
    // counts rows that were written out.
    logic level;
    logic [2:0] outer, inner;
    logic [1:0][PARTS-1:0][R-1:0] part_head;
    logic [1:0][PARTS-1:0][15:0] part_count;
    logic [1:0][PARTS-1:0][R-1:0] part_tail;
    logic [1:0][PARTS-1:0][7:0] spilled;
    logic [15:0] left;

    // Rows on their way to the comparators: one that is dealt, one that was read ahead. They come
    // from a chain, and behind it from the window.
    logic [16*E-1:0] held, ahead;
    logic held_valid, ahead_valid, coming;
    logic [4:0] held_count, ahead_count, coming_count;
    logic [R-1:0] walk;
    logic [15:0] walk_left;
    logic [3:0] pair;
    logic [1:0] used;
    logic row_done;
    logic is_chain, is_window;
    logic [15:0] window_left, source_left;
    logic [4:0] source_count;
    assign is_chain = walk_left != '0;
    assign window_left = entries - {rows_gone, 4'd0};
    assign is_window = streams && rows_gone != rows_now
        && filled[4'(rows_gone)] == (window_left < 16'd16 ? 5'(window_left) : 5'd16);
    assign source_left = is_chain ? walk_left : window_left;
    assign source_count = source_left < 16'd16 ? 5'(source_left) : 5'd16;
    assign source_row = is_chain ? walk : place_row[place_of(rows_gone)];
    assign source_asks = (state == PIVOT || state == SPLIT) && (is_chain || is_window) && !coming
        && !ahead_valid;

    logic [1:0] in_valid, in_ready, out_valid, out_ready;
    logic [1:0][E-1:0] in_entry, out_entry;
    logic [1:0][2:0] out_part;
    logic [2:0] pivot;
    for (genvar i = 0; i < 2; i++) begin : g_unit
        assign in_entry[i] = held[(2*32'(pair)+i)*E+:E];
        assign in_valid[i] = state == SPLIT && held_valid && !used[i] && 32'(held_count) > 2 * 32'(pair) + i;
        qsu #(
            .PIVOTS(PIVOTS), .KEY(40), .PAYLOAD(4)
        ) unit (
            .clk(clk), .rst_n(rst_n),
            .pivot_valid(pivot_valid && pivot_ready), .pivot_index(pivot), .pivot_key(pivot_key),
            .in_valid(in_valid[i]), .in_ready(in_ready[i]),
            .in_key(in_entry[i][39:0]), .in_payload(in_entry[i][43:40]),
            .out_valid(out_valid[i]), .out_ready(out_ready[i]), .out_part(out_part[i]),
            .out_key(out_entry[i][39:0]), .out_payload(out_entry[i][43:40]));
    end
    // Both units have what is theirs of a pair, or nothing of it is left.
    logic [1:0] gone;
    assign gone = used | ~in_valid | in_ready;
    assign row_done = held_valid && state == SPLIT && gone == '1 && 2 * 32'(pair) + 2 >= 32'(held_count);

    // Where the two entries that leave the units go: behind what arrives.
    logic [1:0][15:0] at;
    logic [1:0] begins;
    logic [1:0] goes;
    logic conflict, no_room;
    logic [15:0] come_banks;
    for (genvar b = 0; b < 16; b++) begin : g_come_bank
        assign come_banks[b] = comes && come_place[b] < came;
    end
    always_comb begin
        at[0] = part_count[level][out_part[0]];
        at[1] = part_count[level][out_part[1]] + 16'(out_valid[0] && out_part[0] == out_part[1]);
        no_room = !has_free || (asks && needs_row);
        for (int i = 0; i < 2; i++) begin
            begins[i] = at[i][3:0] == '0;
            goes[i] = out_valid[i] && !(begins[i] && no_room) && !come_banks[at[i][3:0]];
        end
        conflict = out_valid == '1 && (at[0][3:0] == at[1][3:0] || begins == '1);
        goes[1] = goes[1] && !conflict && goes[0] == out_valid[0];
    end
    assign out_ready = {(goes[1] || !out_valid[1]), (goes[0] || !out_valid[0])};

    // A part of the list's own rows, or of a part's.
    logic [PARTS-1:0] fits;
    logic all_fit;
    logic [1:0] dealt;
    for (genvar p = 0; p < PARTS; p++) begin : g_fits
        assign fits[p] = 32'(part_count[level][p]) <= CHUNK;
    end
    assign all_fit = &fits;
    assign dealt = {1'b0, goes[0]} + {1'b0, goes[1]};

    always_comb begin
        write = come_banks;
        for (int b = 0; b < 16; b++) begin
            write_row[b] = comes_next[b] ? next_row : this_row;
            write_data[b] = come_data[48*32'(come_place[b])+:E];
        end
        takes = asks && needs_row;
        for (int i = 0; i < 2; i++) begin
            if (goes[i]) begin
                write[at[i][3:0]] = 1'b1;
                // A second entry may follow the first one into the row that it begins.
                write_row[at[i][3:0]] = begins[i] || (i == 1 && goes[0] && begins[0]
                    && out_part[0] == out_part[1]) ? taken : part_tail[level][out_part[i]];
                write_data[at[i][3:0]] = out_entry[i];
                if (begins[i]) takes = 1'b1;
            end
        end
    end

    // --- rows are written out --------------------------------------------------------------------

    // Parts that have more rows than their last, those that are needed last on top.
    logic [15:0] can_leave;
    for (genvar p = 0; p < PARTS; p++) begin : g_leave
        assign can_leave[p] = level && part_count[1][p] != '0 && part_head[1][p] != part_tail[1][p];
        assign can_leave[PARTS+p] = part_count[0][p] != '0 && part_head[0][p] != part_tail[0][p];
    end
    logic leave_upper;
    logic [2:0] leave_part;
    always_comb begin
        {leave_upper, leave_part} = '0;
        for (int k = 0; k < 16; k++) if (can_leave[k]) {leave_upper, leave_part} = 4'(k);
    end
    logic leave_level;
    logic leave_comes;
    logic [16*48-1:0] leave_data;
    // Requests that are not done.
    logic [4:0] unwritten;
    logic is_settled;
    assign leave_level = !leave_upper;
    assign leave_row = part_head[leave_level][leave_part];
    // A split begins with a row for each of its parts.
    assign leave_asks = streams && (state == PIVOT || state == SPLIT || (is_there && !is_chunk))
        && 32'(free_count) < LOW && can_leave != '0 && !leave_comes && !leaves && unwritten < 5'd28;
    assign ask_data = leave_data[511:0];
    assign is_settled = !leave_comes && !leaves && unwritten == '0;

    // --- chunks ----------------------------------------------------------------------------------

    logic [C:0] chunks;
    logic [PARTS:0][3:0] ahead_of;
    assign ahead_of[0] = '0;
    for (genvar p = 0; p < PARTS; p++) begin : g_ahead
        assign ahead_of[p+1] = ahead_of[p] + 4'(part_count[level][p] != '0);
    end
    assign list_valid = state == READY;
    assign chunk_head = table_head[!bank_now][chunk_index];
    assign chunk_entries = table_count[!bank_now][chunk_index];

    logic ends_split;
    assign ends_split = state == SPLIT && left == 16'(dealt);
    assign job_ready = state == IDLE;

    // A list that has no room: the part whose turn it is.
    logic [2:0] turn;
    logic [15:0] turn_count;
    logic [7:0] turn_spilled;
    logic gives_up, is_chunk, is_there, is_back_now, gives_chunk, comes_back, splits_again;
    // Entries that are in no chunk yet.
    logic [15:0] chunks_left;
    assign turn = level ? inner : outer;
    assign turn_count = part_count[level][turn];
    assign turn_spilled = spilled[level][turn];
    assign is_chunk = 32'(turn_count) <= CHUNK;
    assign is_there = state == PICK && streams && !gives_up && turn_count != '0;
    assign gives_up = is_taken && list_over;
    assign is_back_now = state == FILL && !drops && got == entries;
    assign gives_chunk = (is_there && is_chunk && is_taken && turn_spilled == '0) || is_back_now;
    assign comes_back = is_there && is_chunk && is_taken && turn_spilled != '0 && is_settled;
    assign splits_again = is_there && !is_chunk && is_settled && 32'(free_count) >= LOW;

    // One that is dropped: its parts, and the pivots of those that would have been split.
    logic [3:0] drop_at;
    logic [15:0] drop_count;
    logic drop_pivots, drop_paid, drop_ends;
    assign drop_count = part_count[drop_at[3]][drop_at[2:0]];
    assign drop_pivots = drops && !drop_at[3] && 32'(drop_count) > CHUNK && !drop_paid;
    assign pivot_ready = state == PIVOT || drop_pivots;
    assign gives_part = drops && drop_count != '0 && !drop_pivots && !gives_row && !chunk_drop;
    assign left_head = part_head[drop_at[3]][drop_at[2:0]];
    assign left_tail = part_tail[drop_at[3]][drop_at[2:0]];
    assign left_rows = (R + 1)'(((32'(drop_count) + 32'd15) >> 4)
        - 32'(spilled[drop_at[3]][drop_at[2:0]]));
    assign drop_ends = drops && drop_at == '1 && drop_count == '0 && is_settled;

    logic is_starved, is_full;
    assign is_starved = state == SPLIT && streams && !held_valid && out_valid == '0;
    assign is_full = state == SPLIT && !has_free && (out_valid & begins) != '0;
    assign in_conflict = state == SPLIT && !is_full && (out_valid & ~goes) != '0;
    assign working = (state == PIVOT || state == SPLIT || state == PICK) && !in_conflict && !is_full
        && !is_starved;
    assign reading = state == READ || is_starved || (state == FILL && !drops);
    assign waiting = state == ROOM || state == READY || is_full;

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            state <= IDLE;
            held_valid <= 1'b0;
            ahead_valid <= 1'b0;
            coming <= 1'b0;
            bank_now <= 1'b0;
            streams <= 1'b0;
            drops <= 1'b0;
            leave_comes <= 1'b0;
            leaves <= 1'b0;
            unwritten <= '0;
            list_open <= 1'b0;
        end else begin
            case (state)
                IDLE: if (job_valid) state <= job_entries == '0 ? READY : ROOM;
                ROOM: begin
                    if (32'(room) > ROWS && 32'(free_count) + HELD >= ROWS) begin
                        streams <= 1'b1;
                        state <= PIVOT;
                    end else if (13'(free_count) >= room) state <= READ;
                end
                READ: if (got == entries) state <= 32'(entries) <= CHUNK ? READY : PIVOT;
                PIVOT: if (pivot_valid && pivot == 3'(PIVOTS - 1)) state <= SPLIT;
                SPLIT: if (ends_split) state <= PICK;
                PICK: begin
                    if (streams) begin
                        if (gives_up) begin
                            drops <= 1'b1;
                            state <= FILL;
                        end else if (is_there && is_chunk && !is_taken) state <= READY;
                        else if (comes_back) state <= FILL;
                        else if (splits_again) state <= PIVOT;
                    end else if (level || all_fit)
                        state <= !level || outer == 3'(PARTS - 1) ? READY : PICK;
                    else if (!fits[outer]) state <= PIVOT;
                    else if (outer == 3'(PARTS - 1)) state <= READY;
                end
                FILL: if (is_back_now) state <= PICK;
                default: if (list_ready) state <= streams ? PICK : IDLE;
            endcase
            // The last chunk, or nobody wants any more.
            if ((gives_chunk && chunks_left == turn_count) || drop_ends) begin
                state <= IDLE;
                streams <= 1'b0;
                drops <= 1'b0;
                list_open <= 1'b0;
            end else if (state == READY && list_ready) list_open <= streams;
            if (row_done) held_valid <= 1'b0;
            if ((!held_valid || row_done) && (ahead_valid || coming)) held_valid <= 1'b1;
            if ((!held_valid || row_done) && ahead_valid) ahead_valid <= coming;
            else if (coming && held_valid && !row_done) ahead_valid <= 1'b1;
            coming <= source_gets;
            if (state == IDLE) is_taken <= 1'b0;
            if (state == READY && list_ready) begin
                bank_now <= !bank_now;
                is_taken <= 1'b1;
            end
            leave_comes <= leave_gets;
            if (leave_comes) leaves <= 1'b1;
            else if (ask_ready && leave_second) leaves <= 1'b0;
            unwritten <= unwritten + 5'(leaves && ask_ready) - 5'(is_written);
        end
    end

    always_ff @(posedge clk) begin
        if (gives && chained != '0) next[free_tail] <= given;
        coming_count <= source_count;
        // `read_data` is that of the row that comes now.
        if ((!held_valid || row_done) && ahead_valid) begin
            held <= ahead;
            held_count <= ahead_count;
        end else if (!held_valid || row_done) begin
            held <= read_data;
            held_count <= coming_count;
        end
        if (coming) begin
            ahead <= read_data;
            ahead_count <= coming_count;
        end
        if (source_gets && is_chain) begin
            walk <= next[walk];
            walk_left <= walk_left - 16'(source_count);
        end else if (source_gets) rows_gone <= rows_gone + 12'd1;
        if (row_done) pair <= '0;
        else if (state == SPLIT && held_valid && gone == '1) pair <= pair + 4'd1;
        if (state == SPLIT && held_valid && gone == '1) used <= '0;
        else used <= used | (in_valid & in_ready);

        // What comes in, and what goes out.
        if (asks) begin
            asked <= asked + 16'(wanted);
            beat <= beat + 11'd1;
            rows_now <= rows_due;
            if (needs_row) begin
                place_row[place_of(rows_now)] <= taken;
                filled[4'(rows_now)] <= '0;
                if (state == READ || state == FILL) begin
                    if (rows_now == '0) head <= taken;
                    else next[tail] <= taken;
                    tail <= taken;
                end
            end
        end
        if (comes) begin
            got <= got + 16'(came);
            filled[4'(this_number)] <= filled[4'(this_number)] + fills_this;
            if (fills_next != '0) filled[4'(this_number + 12'd1)] <= filled[4'(this_number + 12'd1)] + fills_next;
        end
        if (leave_gets) begin
            part_head[leave_level][leave_part] <= next[leave_row];
            spilled[leave_level][leave_part] <= spilled[leave_level][leave_part] + 8'd1;
            leave_address <= spill + {14'd0, leave_level, leave_part, 14'd0}
                + 32'd96 * 32'(spilled[leave_level][leave_part]);
            leave_second <= 1'b0;
        end
        if (leave_comes) begin
            for (int b = 0; b < 16; b++) leave_data[48*b+:48] <= {4'd0, read_data[E*b+:E]};
        end else if (leaves && ask_ready) begin
            leave_second <= 1'b1;
            leave_address <= leave_address + 32'd64;
            leave_data <= {512'd0, leave_data[16*48-1:512]};
        end

        case (state)
            IDLE: begin
                if (job_valid) begin
                    address <= job_address;
                    entries <= job_entries;
                    chunks_left <= job_entries;
                end
                asked <= '0;
                got <= '0;
                beat <= '0;
                rows_now <= '0;
                rows_gone <= '0;
                is_back <= 1'b0;
                chunks <= '0;
                level <= 1'b0;
                outer <= '0;
                pivot <= '0;
                used <= '0;
                pair <= '0;
                part_count <= '0;
                spilled <= '0;
                walk_left <= '0;
                drop_at <= '0;
                drop_paid <= 1'b0;
            end
            ROOM: left <= entries;
            READ: begin
                if (got == entries) begin
                    table_head[bank_now][0] <= head;
                    table_tail[bank_now][0] <= tail;
                    table_count[bank_now][0] <= entries[8:0];
                    if (32'(entries) <= CHUNK) chunks <= (C + 1)'(1);
                    walk <= head;
                    walk_left <= entries;
                end
            end
            PIVOT: if (pivot_valid) pivot <= pivot == 3'(PIVOTS - 1) ? '0 : pivot + 3'd1;
            SPLIT: begin
                left <= left - 16'(dealt);
                for (int i = 0; i < 2; i++) begin
                    if (goes[i]) begin
                        part_count[level][out_part[i]] <= at[i] + 16'd1;
                        if (begins[i]) begin
                            if (at[i] == '0) part_head[level][out_part[i]] <= taken;
                            else next[part_tail[level][out_part[i]]] <= taken;
                            part_tail[level][out_part[i]] <= taken;
                        end
                    end
                end
            end
            PICK: begin
                if (streams) begin
                    if (turn_count == '0) begin
                        inner <= inner + 3'd1;
                        if (!level || inner == 3'(PARTS - 1)) outer <= outer + 3'd1;
                        if (inner == 3'(PARTS - 1)) level <= 1'b0;
                    end
                    if (comes_back || splits_again) begin
                        address <= spill + {14'd0, level, turn, 14'd0};
                        entries <= {4'd0, turn_spilled, 4'd0};
                        is_back <= 1'b1;
                        asked <= '0;
                        got <= '0;
                        beat <= '0;
                        rows_now <= '0;
                        rows_gone <= '0;
                    end
                    if (splits_again) begin
                        level <= 1'b1;
                        inner <= '0;
                        walk <= part_head[0][outer];
                        walk_left <= turn_count - {4'd0, turn_spilled, 4'd0};
                        left <= turn_count;
                        part_count[0][outer] <= '0;
                        part_count[1] <= '0;
                        spilled[1] <= '0;
                    end
                end else if (level || all_fit) begin
                    for (int p = 0; p < PARTS; p++) begin
                        if (part_count[level][p] != '0) begin
                            table_head[bank_now][C'(chunks + (C + 1)'(ahead_of[p]))] <= part_head[level][p];
                            table_tail[bank_now][C'(chunks + (C + 1)'(ahead_of[p]))] <= part_tail[level][p];
                            table_count[bank_now][C'(chunks + (C + 1)'(ahead_of[p]))] <= part_count[level][p][8:0];
                        end
                    end
                    chunks <= chunks + (C + 1)'(ahead_of[PARTS]);
                    level <= 1'b0;
                    outer <= outer + 3'd1;
                end else if (fits[outer]) begin
                    if (part_count[0][outer] != '0) begin
                        table_head[bank_now][C'(chunks)] <= part_head[0][outer];
                        table_tail[bank_now][C'(chunks)] <= part_tail[0][outer];
                        table_count[bank_now][C'(chunks)] <= part_count[0][outer][8:0];
                        chunks <= chunks + (C + 1)'(1);
                    end
                    outer <= outer + 3'd1;
                end else begin
                    level <= 1'b1;
                    walk <= part_head[0][outer];
                    walk_left <= part_count[0][outer];
                    left <= part_count[0][outer];
                    part_count[1] <= '0;
                end
            end
            FILL: begin
                if (drop_pivots && pivot_valid) pivot <= pivot == 3'(PIVOTS - 1) ? '0 : pivot + 3'd1;
                if (drop_pivots && pivot_valid && pivot == 3'(PIVOTS - 1)) drop_paid <= 1'b1;
                if (gives_part) begin
                    part_count[drop_at[3]][drop_at[2:0]] <= '0;
                    drop_paid <= 1'b0;
                end
                if (drops && drop_count == '0 && drop_at != '1) drop_at <= drop_at + 4'd1;
            end
            default: begin
                // Whoever takes the list takes the chunks that are there.
                if (list_ready) list_chunks <= chunks;
            end
        endcase
        if (gives_chunk) begin
            table_head[!bank_now][C'(list_chunks)] <= is_back_now ? head : part_head[level][turn];
            table_tail[!bank_now][C'(list_chunks)] <= part_tail[level][turn];
            table_count[!bank_now][C'(list_chunks)] <= turn_count[8:0];
            list_chunks <= list_chunks + 1'b1;
            chunks_left <= chunks_left - turn_count;
            part_count[level][turn] <= '0;
        end
        // What came back goes in front of what has stayed.
        if (is_back_now) next[tail] <= part_head[level][turn];
    end
endmodule
