// List fetch of a core: reads the list of a job into the sorting buffer, and splits it by depth until
// every part fits a chunk.
//
// The sorting buffer has rows of 16 entries in 16 banks of one entry, with a read and a write port
// each. Rows are dealt from a list of free ones and chained, so a part may grow to any length while
// the rows that it is made of are given back. A list is read when its rows, and one more for each
// part if it has to be split, are free. Two quick sorting units share each list: entries of even and
// odd places go to one each. An entry that meets a bank that the other one writes waits a cycle.
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
    // Reads of up to ten entries.
    output logic            ask_valid,
    input  logic            ask_ready,
    output logic [31:0]     ask_address,
    output logic [6:0]      ask_bytes,
    output logic [11:0]     ask_beat,
    input  logic            come_valid,
    input  logic [11:0]     come_beat,
    input  logic [511:0]    come_data,
    input  logic            pivot_valid,
    output logic            pivot_ready,
    input  logic [39:0]     pivot_key,
    // A list that is split; whoever takes it reads its chunks by number until it takes the next.
    output logic            list_valid,
    input  logic            list_ready,
    output logic [C:0]      list_chunks,
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
    localparam logic [2:0] IDLE = 3'd0;
    localparam logic [2:0] ROOM = 3'd1;
    localparam logic [2:0] READ = 3'd2;
    localparam logic [2:0] PIVOT = 3'd3;
    localparam logic [2:0] SPLIT = 3'd4;
    localparam logic [2:0] PICK = 3'd5;
    localparam logic [2:0] READY = 3'd6;

    logic [2:0] state;

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
    logic [4:0] given_rows;
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
            free_count <= free_count + (gives ? (R + 1)'(given_rows) : '0) - (R + 1)'(takes);
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
    assign source_gets = source_asks && read_valid == '0;
    assign reads = read_valid != '0 || source_asks;
    assign row = read_valid[0] ? read_row[0] : read_valid[1] ? read_row[1] : source_row;
    for (genvar i = 0; i < 2; i++) begin : g_next
        assign read_next[i] = next[read_row[i]];
    end
    // A row of a list that is split is used up at once.
    logic gives_row;
    assign gives_row = source_gets || (read_valid != '0 && seen[row]);
    assign chunk_dropped = chunk_drop && !gives_row;
    assign gives = gives_row || chunk_dropped;
    assign given = gives_row ? row : chunk_head;
    assign given_end = gives_row ? row : table_tail[!bank_now][chunk_index];
    assign given_rows = gives_row ? 5'd1 : 5'((32'(chunk_entries) + 32'd15) >> 4);
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

    // --- the list arrives ------------------------------------------------------------------------

    logic [31:0] address;
    logic [15:0] entries, asked, got;
    logic [11:0] beat;
    logic [ROWS-1:0][R-1:0] place_row;
    logic [R:0] rows_now;
    logic [R-1:0] head, tail;
    logic [3:0] wanted, came;
    logic needs_row;
    logic [R:0] rows_due;
    logic asks;
    assign wanted = entries - asked < 16'd10 ? 4'(entries - asked) : 4'd10;
    assign rows_due = (R + 1)'((32'(asked) + 32'(wanted) + 32'd15) >> 4);
    assign needs_row = rows_due != rows_now;
    assign ask_valid = state == READ && asked != entries;
    assign asks = ask_valid && ask_ready;
    assign ask_address = address + 32'd6 * 32'(asked);
    assign ask_bytes = 7'd6 * 7'(wanted);
    assign ask_beat = beat;
    assign came = 32'(entries) - 32'd10 * 32'(come_beat) < 32'd10
        ? 4'(32'(entries) - 32'd10 * 32'(come_beat)) : 4'd10;

    // Where in an answer the entry of a bank is: banks behind its first one are in the same row of
    // the list, those before in the next one.
    logic [15:0] come_first;
    logic [15:0][3:0] come_place;
    logic [15:0] comes_next;
    logic [R-1:0] this_row, next_row;
    assign come_first = 16'(10 * 32'(come_beat));
    assign this_row = place_row[R'(come_first >> 4)];
    assign next_row = place_row[R'((come_first >> 4) + 16'd1)];
    for (genvar b = 0; b < 16; b++) begin : g_come
        assign come_place[b] = 4'(b) - come_first[3:0];
        assign comes_next[b] = 1'((5'(come_place[b]) + 5'(come_first[3:0])) >> 4);
    end

    // Rows that a list needs: its own, and one for each part that is begun.
    logic [R+1:0] room;
    assign room = (R + 2)'((32'(entries) + 32'd15) >> 4) + (32'(entries) > CHUNK ? (R + 2)'(PARTS) : '0);

    // --- splits ----------------------------------------------------------------------------------

    // The parts of two levels; those of the second belong to part `outer` of the first.
    logic level;
    logic [2:0] outer;
    logic [1:0][PARTS-1:0][R-1:0] part_head;
    logic [1:0][PARTS-1:0][15:0] part_count;
    logic [1:0][PARTS-1:0][R-1:0] part_tail;
    logic [15:0] left;

    // Rows on their way to the comparators: one that is dealt, one that was read ahead.
    logic [16*E-1:0] held, ahead;
    logic held_valid, ahead_valid, coming;
    logic [4:0] held_count, ahead_count, coming_count;
    logic [R-1:0] walk;
    logic [15:0] walk_left;
    logic [3:0] pair;
    logic [1:0] used;
    logic row_done;
    logic [4:0] walk_count;
    assign source_row = walk;
    assign walk_count = walk_left < 16'd16 ? 5'(walk_left) : 5'd16;
    assign source_asks = (state == PIVOT || state == SPLIT) && walk_left != '0 && !coming && !ahead_valid;

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
    assign pivot_ready = state == PIVOT;
    // Both units have what is theirs of a pair, or nothing of it is left.
    logic [1:0] gone;
    assign gone = used | ~in_valid | in_ready;
    assign row_done = held_valid && state == SPLIT && gone == '1 && 2 * 32'(pair) + 2 >= 32'(held_count);

    // Where the two entries that leave the units go.
    logic [1:0][15:0] at;
    logic [1:0] begins;
    logic [1:0] goes;
    logic conflict;
    always_comb begin
        at[0] = part_count[level][out_part[0]];
        at[1] = part_count[level][out_part[1]] + 16'(out_valid[0] && out_part[0] == out_part[1]);
        for (int i = 0; i < 2; i++) begins[i] = at[i][3:0] == '0;
        goes[0] = out_valid[0] && (!begins[0] || has_free);
        conflict = out_valid == '1 && (at[0][3:0] == at[1][3:0] || begins == '1);
        goes[1] = out_valid[1] && (!begins[1] || has_free) && !conflict && goes[0] == out_valid[0];
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
        write = '0;
        for (int b = 0; b < 16; b++) begin
            write_row[b] = '0;
            write_data[b] = '0;
        end
        takes = asks && needs_row;
        for (int b = 0; b < 16; b++) begin
            if (come_valid && come_place[b] < came) begin
                write[b] = 1'b1;
                write_row[b] = comes_next[b] ? next_row : this_row;
                write_data[b] = come_data[48*32'(come_place[b])+:E];
            end
        end
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

    // --- chunks ----------------------------------------------------------------------------------

    logic [C:0] chunks;
    logic [PARTS:0][3:0] ahead_of;
    assign ahead_of[0] = '0;
    for (genvar p = 0; p < PARTS; p++) begin : g_ahead
        assign ahead_of[p+1] = ahead_of[p] + 4'(part_count[level][p] != '0);
    end
    assign list_valid = state == READY;
    assign list_chunks = chunks;
    assign chunk_head = table_head[!bank_now][chunk_index];
    assign chunk_entries = table_count[!bank_now][chunk_index];

    logic ends_split;
    assign ends_split = state == SPLIT && left == 16'(dealt);
    assign job_ready = state == IDLE;
    assign in_conflict = state == SPLIT && (out_valid & ~goes) != '0;
    assign working = (state == PIVOT || state == SPLIT || state == PICK) && !in_conflict;
    assign reading = state == READ;
    assign waiting = state == ROOM || state == READY;

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            state <= IDLE;
            held_valid <= 1'b0;
            ahead_valid <= 1'b0;
            coming <= 1'b0;
            bank_now <= 1'b0;
        end else begin
            case (state)
                IDLE: if (job_valid) state <= job_entries == '0 ? READY : ROOM;
                ROOM: if ((R + 2)'(free_count) >= room) state <= READ;
                READ: if (got == entries) state <= 32'(entries) <= CHUNK ? READY : PIVOT;
                PIVOT: if (pivot_valid && pivot == 3'(PIVOTS - 1)) state <= SPLIT;
                SPLIT: if (ends_split) state <= PICK;
                PICK: begin
                    if (level || all_fit) state <= !level || outer == 3'(PARTS - 1) ? READY : PICK;
                    else if (!fits[outer]) state <= PIVOT;
                    else if (outer == 3'(PARTS - 1)) state <= READY;
                end
                default: if (list_ready) state <= IDLE;
            endcase
            if (row_done) held_valid <= 1'b0;
            if ((!held_valid || row_done) && (ahead_valid || coming)) held_valid <= 1'b1;
            if ((!held_valid || row_done) && ahead_valid) ahead_valid <= coming;
            else if (coming && held_valid && !row_done) ahead_valid <= 1'b1;
            coming <= source_gets;
            if (state == READY && list_ready) bank_now <= !bank_now;
        end
    end

    always_ff @(posedge clk) begin
        if (gives && chained != '0) next[free_tail] <= given;
        coming_count <= walk_count;
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
        if (source_gets) begin
            walk <= next[walk];
            walk_left <= walk_left - 16'(walk_count);
        end
        if (row_done) pair <= '0;
        else if (state == SPLIT && held_valid && gone == '1) pair <= pair + 4'd1;
        if (state == SPLIT && held_valid && gone == '1) used <= '0;
        else used <= used | (in_valid & in_ready);

        case (state)
            IDLE: begin
                if (job_valid) begin
                    address <= job_address;
                    entries <= job_entries;
                end
                asked <= '0;
                got <= '0;
                beat <= '0;
                rows_now <= '0;
                chunks <= '0;
                level <= 1'b0;
                outer <= '0;
                pivot <= '0;
                used <= '0;
                pair <= '0;
            end
            READ: begin
                if (asks) begin
                    asked <= asked + 16'(wanted);
                    beat <= beat + 12'd1;
                    rows_now <= rows_due;
                    if (needs_row) begin
                        place_row[rows_now[R-1:0]] <= taken;
                        if (rows_now == '0) head <= taken;
                        else next[tail] <= taken;
                        tail <= taken;
                    end
                end
                if (come_valid) got <= got + 16'(came);
                if (got == entries) begin
                    table_head[bank_now][0] <= head;
                    table_tail[bank_now][0] <= tail;
                    table_count[bank_now][0] <= entries[8:0];
                    if (32'(entries) <= CHUNK) chunks <= (C + 1)'(1);
                    walk <= head;
                    walk_left <= entries;
                    left <= entries;
                    for (int p = 0; p < PARTS; p++) part_count[0][p] <= '0;
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
                if (level || all_fit) begin
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
                    for (int p = 0; p < PARTS; p++) part_count[1][p] <= '0;
                end
            end
            default: ;
        endcase
    end
endmodule
