// Pixels of finished tiles: a buffer of TILES tiles, and their way to the memory, 64 bytes at a time.
//
// A tile enters when a place is free: 16 pixels a cycle, one of each rendering core. Eight bytes are
// a pixel (red, green, blue, transmittance). A request has eight pixels of a row, two neighbours of
// each of four rendering cores side by side, so that those inside of the image are the first ones;
// the others are not written, and requests without any are left out. A place is free when all
// writes of its tile are done. Reset: empty.
module core_pixels #(
    parameter int TILES = 2,
    localparam int T = TILES > 1 ? $clog2(TILES) : 1
) (
    input  logic          clk,
    input  logic          rst_n,
    input  logic [31:0]   pixels,
    input  logic [8:0]    tiles_x,
    input  logic          close_valid,
    output logic          close_ready,
    input  logic [27:0]   close_tile,
    input  logic          in_valid,
    output logic          in_ready,
    input  logic [1023:0] in_pixels,
    output logic          write_valid,
    input  logic          write_ready,
    output logic [31:0]   write_address,
    output logic [6:0]    write_bytes,
    output logic [T-1:0]  write_tag,
    output logic [511:0]  write_data,
    input  logic          done_valid,
    input  logic [T-1:0]  done_tag,
    output logic          last_in,
    output logic          is_full,
    output logic          idle
);
    logic tile_valid, tile_take;
    logic [27:0] tile;
    fifo #(
        .WIDTH(28), .DEPTH(4)
    ) closed (
        .clk(clk), .rst_n(rst_n), .in_valid(close_valid), .in_ready(close_ready), .in_data(close_tile),
        .out_valid(tile_valid), .out_ready(tile_take), .out_data(tile));

    logic [TILES-1:0] used, whole;
    logic [TILES-1:0][27:0] of_tile;
    logic [TILES-1:0][5:0] open_writes;
    logic [TILES-1:0] sent;
    logic [T-1:0] filling, writing;
    logic [3:0] beat;
    logic [4:0] turn;

    assign idle = used == '0 && !tile_valid;
    assign in_ready = beat != '0 || (!used[filling] && tile_valid);
    assign tile_take = in_valid && in_ready && beat == '0;
    assign last_in = in_valid && in_ready && beat == 4'd15;
    assign is_full = in_valid && !in_ready;

    // Of a request: the row of rendering cores (turn[1:0]), row (turn[4:3]) and half (turn[2]) of
    // the pixels of a core.
    logic [7:0] seen;
    logic [3:0] count;
    logic [1:0][1023:0] lines;
    for (genvar i = 0; i < 8; i++) begin : g_pixel
        localparam int X = 4 * (i / 2) + i % 2;
        logic [3:0] core;
        assign core = {turn[1], 1'(i / 4), turn[0], 1'(i / 2 % 2)};
        assign seen[i] = 5'(X) + {3'd0, turn[2], 1'b0} < of_tile[writing][22:18]
            && {1'b0, turn[1:0], turn[4:3]} < of_tile[writing][27:23];
        assign write_data[64*i+:64] = lines[i%2][64*core+:64];
    end
    always_comb begin
        count = '0;
        for (int i = 0; i < 8; i++) count = count + 4'(seen[i]);
    end
    logic turns;
    assign write_valid = whole[writing] && !sent[writing] && count != '0;
    assign turns = whole[writing] && !sent[writing] && (count == '0 || write_ready);
    assign write_tag = writing;
    assign write_bytes = {count, 3'd0};
    assign write_address = pixels
        + 32'd2048 * (32'(of_tile[writing][17:9]) * 32'(tiles_x) + 32'(of_tile[writing][8:0]))
        + {21'd0, turn, 6'd0};
    // Pixels of even and of odd columns.
    for (genvar b = 0; b < 2; b++) begin : g_bank
        sram_async #(
            .WIDTH(1024), .DEPTH(8 << T)
        ) memory (
            .clk(clk), .write(in_valid && in_ready && beat[0] == 1'(b)),
            .write_at({filling, beat[3:1]}), .write_data(in_pixels),
            .read_at({writing, turn[4:2]}), .read_data(lines[b]));
    end

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            used <= '0;
            whole <= '0;
            sent <= '0;
            filling <= '0;
            writing <= '0;
            beat <= '0;
            turn <= '0;
        end else begin
            if (in_valid && in_ready) begin
                beat <= beat + 4'd1;
                used[filling] <= 1'b1;
                if (beat == 4'd15) begin
                    whole[filling] <= 1'b1;
                    filling <= filling == T'(TILES - 1) ? '0 : filling + 1'b1;
                end
            end
            if (turns) begin
                turn <= turn + 5'd1;
                if (turn == 5'd31) begin
                    sent[writing] <= 1'b1;
                    writing <= writing == T'(TILES - 1) ? '0 : writing + 1'b1;
                end
            end
            for (int t = 0; t < TILES; t++) begin
                if (sent[t] && open_writes[t] == '0) begin
                    used[t] <= 1'b0;
                    whole[t] <= 1'b0;
                    sent[t] <= 1'b0;
                end
            end
        end
    end
    always_ff @(posedge clk) begin
        if (tile_take) of_tile[filling] <= tile;
        for (int t = 0; t < TILES; t++) begin
            if (!used[t]) open_writes[t] <= '0;
            else open_writes[t] <= open_writes[t]
                + 6'(write_valid && write_ready && writing == T'(t))
                - 6'(done_valid && done_tag == T'(t));
        end
    end
endmodule
