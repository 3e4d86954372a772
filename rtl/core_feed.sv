// From the feature buffer to the rendering unit: opens tiles, gives the entries of ready chunks in
// their order, and closes a tile behind its last entry or when nothing of it needs anything more.
//
// A record has the mean in the image; what a rendering core takes is the form in the middle of the
// tile. u = a x + b y and v = c y there are sums of whole numbers, as those of ccu_tiles are, rounded
// once. An entry takes four cycles: order, record, products, sums. Reset: no tile, nothing on the
// way. `unit_valid` depends on registers only.
module core_feed #(
    parameter int FEATURES = 64,
    localparam int F = $clog2(FEATURES),
    localparam int N = 16
) (
    input  logic           clk,
    input  logic           rst_n,
    // Tiles in the order of their lists: column, row, size inside the image.
    input  logic           tile_valid,
    output logic           tile_ready,
    input  logic [27:0]    tile,
    input  logic           ready_valid,
    output logic           ready_take,
    input  logic           ready_empty,
    input  logic           ready_last,
    input  logic [8:0]     ready_entries,
    input  logic [F-1:0]   ready_row,
    output logic           over,
    output logic           feed_valid,
    output logic [F-1:0]   feed_row,
    output logic [3:0]     feed_place,
    input  logic [3:0]     feed_subtiles,
    output logic [F-1:0]   record_base,
    input  logic [255:0]   record,
    output logic           unit_valid,
    input  logic           unit_ready,
    output logic [1:0]     unit_op,
    output logic [9*N-1:0] unit_record,
    output logic [3:0]     unit_subtiles,
    output logic [4:0]     unit_width,
    output logic [4:0]     unit_height,
    input  logic           unit_stopped,
    // The tile that closes, for its pixels.
    output logic           close_valid,
    input  logic           close_ready,
    output logic [27:0]    close_tile,
    output logic           idle
);
    localparam logic [1:0] OPEN = 2'd0;
    localparam logic [1:0] SPLAT = 2'd1;
    localparam logic [1:0] CLOSE = 2'd2;
    localparam logic [1:0] CLOSED = 2'd0;
    localparam logic [1:0] FEEDING = 2'd1;
    localparam logic [1:0] BETWEEN = 2'd2;
    localparam logic [1:0] CLOSING = 2'd3;
    // Beats on the way and in front of the unit.
    localparam int DEPTH = 8;
    localparam int B = 2 + 3 + 4 + 9 * N + 10;

    logic [1:0] state;
    // Which tile, counted in three bits: no more than seven are between here and the unit.
    logic [2:0] turn;
    logic [8:0] place;
    logic begun;
    logic [3:0] credit;
    logic may;
    logic [1:0] op;
    logic issues;
    logic stops;
    logic last_entry;

    logic next_valid, next_take;
    logic [27:0] next_tile, now;
    fifo #(
        .WIDTH(28), .DEPTH(16)
    ) tiles (
        .clk(clk), .rst_n(rst_n), .in_valid(tile_valid), .in_ready(tile_ready), .in_data(tile),
        .out_valid(next_valid), .out_ready(next_take), .out_data(next_tile));

    assign idle = state == CLOSED && !next_valid && credit == 4'(DEPTH);
    assign may = credit != '0;
    assign stops = begun && unit_stopped && (state == FEEDING || state == BETWEEN);
    assign last_entry = place + 9'd1 >= ready_entries;
    assign feed_valid = state == FEEDING && may && !stops;
    assign feed_row = ready_row + F'(place[7:4]);
    assign feed_place = place[3:0];
    assign over = stops;
    assign ready_take = (state == FEEDING && (stops || (feed_valid && last_entry)))
        || (state == CLOSED && next_take && ready_empty);
    assign next_take = state == CLOSED && ready_valid && next_valid && may;
    assign close_valid = state == CLOSING && may;
    assign close_tile = now;

    always_comb begin
        issues = 1'b0;
        op = SPLAT;
        case (state)
            CLOSED: begin
                issues = next_take;
                op = OPEN;
            end
            FEEDING: issues = feed_valid;
            BETWEEN: ;
            default: begin
                issues = may && close_ready;
                op = CLOSE;
            end
        endcase
    end

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            state <= CLOSED;
            begun <= 1'b0;
            turn <= '0;
            credit <= 4'(DEPTH);
        end else begin
            case (state)
                CLOSED: if (next_take) state <= ready_empty ? CLOSING : FEEDING;
                FEEDING: begin
                    if (stops) state <= CLOSING;
                    else if (feed_valid && last_entry) state <= ready_last ? CLOSING : BETWEEN;
                end
                BETWEEN: begin
                    if (stops) state <= CLOSING;
                    else if (ready_valid) state <= FEEDING;
                end
                default: if (issues) state <= CLOSED;
            endcase
            if (next_take) turn <= turn + 3'd1;
            // The first splat that the unit takes says that the tile is open.
            if (next_take) begun <= 1'b0;
            else if (unit_valid && unit_ready && unit_op == SPLAT && unit_turn == turn) begun <= 1'b1;
            credit <= credit - 4'(issues) + 4'(unit_valid && unit_ready);
        end
    end
    always_ff @(posedge clk) begin
        if (next_take) now <= next_tile;
        if (state != FEEDING) place <= '0;
        else if (feed_valid) place <= last_entry ? '0 : place + 9'd1;
    end

    // --- the way of an entry ---------------------------------------------------------------------

    logic [3:0] valid;
    logic [3:0][1:0] ops;
    logic [3:0][2:0] turns;
    logic [3:0][27:0] of_tile;
    logic [2:0][3:0] subtiles;
    logic [27:0] tile_now;
    assign tile_now = state == CLOSED ? next_tile : now;
    always_ff @(posedge clk) begin
        if (!rst_n) valid <= '0;
        else valid <= {valid[2:0], issues};
        ops <= {ops[2:0], op};
        turns <= {turns[2:0], state == CLOSED ? turn + 3'd1 : turn};
        of_tile <= {of_tile[2:0], tile_now};
        subtiles <= {subtiles[1:0], feed_subtiles};
        record_base <= ready_row;
    end

    // Places are in 1/256 pixel, coefficients and sums in 2^-16.
    logic signed [23:0] mean_x, mean_y;
    logic signed [18:0] root_a, root_b, root_c;
    logic signed [25:0] local_x, local_y;
    logic signed [44:0] times_a, times_b, times_c;
    logic [111:0] rest, rest_now;
    assign {root_c, root_b, root_a, mean_y, mean_x} = record[104:0];
    assign local_x = 26'({of_tile[1][8:0], 12'd0}) + 26'sd1920 - 26'(mean_x);
    assign local_y = 26'({of_tile[1][17:9], 12'd0}) + 26'sd1920 - 26'(mean_y);
    assign rest = record[223:112];
    always_ff @(posedge clk) begin
        if (valid[1] && ops[1] == SPLAT) begin
            times_a <= local_x * root_a;
            times_b <= local_y * root_b;
            times_c <= local_y * root_c;
            rest_now <= rest;
        end
    end
    logic signed [35:0] sum_u, sum_v;
    logic [N-1:0] u, v;
    assign sum_u = 36'(times_a >>> 8) + 36'(times_b >>> 8);
    assign sum_v = 36'(times_c >>> 8);
    ccu_local #(.EXP(5), .MAN(10), .BITS(36), .FRACTION(16)) local_u (.sum(sum_u), .y(u));
    ccu_local #(.EXP(5), .MAN(10), .BITS(36), .FRACTION(16)) local_v (.sum(sum_v), .y(v));
    logic [9*N-1:0] made;
    always_ff @(posedge clk) begin
        if (valid[2] && ops[2] == SPLAT) made <= {rest_now, v, u};
    end

    logic [2:0] unit_turn;
    logic room;
    fifo #(
        .WIDTH(B), .DEPTH(DEPTH)
    ) beats (
        .clk(clk), .rst_n(rst_n), .in_valid(valid[3]), .in_ready(room),
        .in_data({of_tile[3][27:18], made, subtiles[2], turns[3], ops[3]}),
        .out_valid(unit_valid), .out_ready(unit_ready),
        .out_data({unit_height, unit_width, unit_record, unit_subtiles, unit_turn, unit_op}));

    logic unused;
    assign unused = &{1'b0, room, record[255:224], record[111:105]};
endmodule
