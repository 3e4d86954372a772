// One of the UNITS converters of a front: from the records of a scene to pairs and the records of
// splats.
//
//   means ─► ccu ─► kept? ─► shapes ─► ccu ─► seen? ─► coefficients ─► ccu ─► colour ─┐
//             │                         │                                             ▼
//             │                         └─► depth, form ────────────────► record of a splat ─► memory
//             └─► pairs
//
// Means are read in order, seven in a request of 63 bytes (three numbers of 24 bits each): unit u
// takes every UNITSth seven, from the uth on. Shapes are read of what is kept, 24 bytes (eight
// numbers); coefficients of what is seen, twice 48 bytes. A request is made when there is room for
// its answer (credits), and at most FLIGHT Gaussians are between the request of their shape and
// their record. Splats are numbered as they are seen, in steps of UNITS from u on. One memory port,
// as of a core: writes of records go first, then coefficients, shapes, means. `is_over` when no pair
// will come, `done` when all records are written. Reset: at the first Gaussian; `go` begins.
module front_unit #(
    parameter int OPS = 16,
    parameter int UNITS = 1,
    // Which of them it is.
    parameter int UNIT = 0,
    // Places for answers.
    parameter int MEANS = 16,
    parameter int SHAPES = 32,
    parameter int COLOURS = 32,
    parameter int FLIGHT = 64,
    localparam int W = 24
) (
    input  logic            clk,
    input  logic            rst_n,
    input  logic            go,
    input  logic [31:0]     gaussians,
    input  logic [31:0]     means,
    input  logic [31:0]     shapes,
    input  logic [31:0]     coefficients,
    input  logic [31:0]     features,
    input  logic [18*W-1:0] settings,
    input  logic [8:0]      tiles_x,
    input  logic [8:0]      tiles_y,
    input  logic [1:0]      degree,
    output logic            ask_valid,
    input  logic            ask_ready,
    output logic            ask_write,
    output logic [31:0]     ask_address,
    output logic [6:0]      ask_bytes,
    output logic [15:0]     ask_tag,
    output logic [511:0]    ask_data,
    input  logic            come_valid,
    output logic            come_ready,
    input  logic [15:0]     come_tag,
    input  logic [511:0]    come_data,
    // Column and row of a tile, and its entry: number and depth of the splat, sub-tiles.
    output logic            pair_valid,
    input  logic            pair_ready,
    output logic [8:0]      pair_x,
    output logic [8:0]      pair_y,
    output logic [47:0]     pair_entry,
    output logic            is_over,
    output logic            done
);
    localparam logic [2:0] MEAN = 3'd0;
    localparam logic [2:0] SHAPE = 3'd1;
    localparam logic [2:0] COLOUR = 3'd2;
    localparam logic [2:0] WRITE = 3'd3;
    localparam int M = $clog2(MEANS);
    localparam int H = $clog2(SHAPES);
    localparam int K = $clog2(COLOURS);
    localparam int G = $clog2(FLIGHT + 1);

    assign come_ready = 1'b1;

    // --- means -----------------------------------------------------------------------------------

    logic mean_room, mean_ask, mean_asks;
    logic [M-1:0] mean_slot;
    logic [31:0] mean_asked;
    logic [31:0] mean_left;
    logic row_valid, row_ready;
    logic [503:0] row;
    logic [2:0] place;
    logic [31:0] mean_given;
    logic mean_valid, mean_ready;
    assign mean_left = gaussians - mean_asked;
    assign mean_ask = go && mean_room && mean_asked < gaussians;
    fetch_queue #(
        .WIDTH(504), .SLOTS(MEANS)
    ) mean_queue (
        .clk(clk), .rst_n(rst_n), .room(mean_room), .slot(mean_slot), .take(mean_asks),
        .come_valid(come_valid && come_tag[2:0] == MEAN), .come_slot(come_tag[3+:M]),
        .come_part(1'b0), .come_data(come_data[503:0]),
        .out_valid(row_valid), .out_ready(row_ready), .out_data(row));
    assign mean_valid = row_valid;
    assign row_ready = mean_ready && (place == 3'd6 || mean_given + 32'd1 == gaussians);

    // The Gaussian behind this one: the next of its seven, or the first of those that are next.
    function automatic logic [31:0] behind(input logic [31:0] number, input logic [2:0] place_of);
        behind = place_of == 3'd6 ? number + 32'(7 * UNITS - 6) : number + 32'd1;
    endfunction

    // --- what is kept ----------------------------------------------------------------------------

    logic verdict_valid, verdict_ready, verdict_kept;
    logic [31:0] judged;
    logic [2:0] judged_place;
    logic kept_valid, kept_ready, kept_room;
    logic [31:0] kept;
    assign verdict_ready = kept_room;
    fifo #(
        .WIDTH(32), .DEPTH(8)
    ) kept_queue (
        .clk(clk), .rst_n(rst_n), .in_valid(verdict_valid && verdict_kept), .in_ready(kept_room),
        .in_data(judged), .out_valid(kept_valid), .out_ready(kept_ready), .out_data(kept));

    logic shape_room, shape_ask, shape_asks;
    logic [H-1:0] shape_slot;
    logic shape_valid, shape_ready;
    logic [191:0] shape;
    logic [G-1:0] flight;
    assign shape_ask = kept_valid && shape_room && flight != G'(FLIGHT);
    assign kept_ready = shape_asks;
    fetch_queue #(
        .WIDTH(192), .SLOTS(SHAPES)
    ) shape_queue (
        .clk(clk), .rst_n(rst_n), .room(shape_room), .slot(shape_slot), .take(shape_asks),
        .come_valid(come_valid && come_tag[2:0] == SHAPE), .come_slot(come_tag[3+:H]),
        .come_part(1'b0), .come_data(come_data[191:0]),
        .out_valid(shape_valid), .out_ready(shape_ready), .out_data(shape));

    // --- what is seen ----------------------------------------------------------------------------

    // Numbers in the scene of what is projected, then of what is seen; no more than are in flight.
    logic seen, dropped;
    logic [15:0] seen_depth;
    logic [31:0] projected, wanted;
    logic projected_valid, wanted_valid, wanted_ready;
    logic [1:0] no_wait;
    fifo #(
        .WIDTH(32), .DEPTH(FLIGHT)
    ) projected_queue (
        .clk(clk), .rst_n(rst_n), .in_valid(shape_asks), .in_ready(no_wait[0]), .in_data(kept),
        .out_valid(projected_valid), .out_ready(seen || dropped), .out_data(projected));
    fifo #(
        .WIDTH(32), .DEPTH(FLIGHT)
    ) wanted_queue (
        .clk(clk), .rst_n(rst_n), .in_valid(seen), .in_ready(no_wait[1]), .in_data(projected),
        .out_valid(wanted_valid), .out_ready(wanted_ready), .out_data(wanted));

    logic colour_room, colour_ask, colour_asks, colour_part;
    logic [K-1:0] colour_slot;
    logic coefficients_valid, coefficients_ready;
    logic [767:0] coefficients_data;
    assign colour_ask = wanted_valid && colour_room;
    assign wanted_ready = colour_asks && colour_part;
    fetch_queue #(
        .WIDTH(384), .PARTS(2), .SLOTS(COLOURS)
    ) colour_queue (
        .clk(clk), .rst_n(rst_n), .room(colour_room), .slot(colour_slot),
        .take(colour_asks && colour_part),
        .come_valid(come_valid && come_tag[2:0] == COLOUR), .come_slot(come_tag[4+:K]),
        .come_part(come_tag[3]), .come_data(come_data[383:0]),
        .out_valid(coefficients_valid), .out_ready(coefficients_ready),
        .out_data(coefficients_data));

    // --- the unit --------------------------------------------------------------------------------

    logic splat_valid, splat_ready, colour_valid, colour_ready;
    logic [79:0] splat;
    logic [104:0] form;
    logic [47:0] colour;
    logic [7:0] pair_splat;
    logic [3:0] pair_subtiles;
    logic [15:0] pair_u, pair_v;
    ccu #(
        .OPS(OPS), .WAITING(SHAPES)
    ) unit (
        .clk(clk), .rst_n(rst_n), .settings(settings), .tiles_x(tiles_x), .tiles_y(tiles_y),
        .degree(degree),
        .mean_valid(mean_valid), .mean_ready(mean_ready), .mean_data(row[72*32'(place)+:72]),
        .verdict_valid(verdict_valid), .verdict_ready(verdict_ready), .verdict_kept(verdict_kept),
        .shape_valid(shape_valid), .shape_ready(shape_ready), .shape_data(shape),
        .splat_valid(splat_valid), .splat_ready(splat_ready), .splat_data(splat),
        .splat_form(form), .seen(seen), .seen_depth(seen_depth), .dropped(dropped),
        .tiles_idle(tiles_idle),
        .pair_valid(pair_valid), .pair_ready(pair_ready), .pair_splat(pair_splat),
        .pair_x(pair_x), .pair_y(pair_y), .pair_subtiles(pair_subtiles), .pair_u(pair_u),
        .pair_v(pair_v),
        .coefficients_valid(coefficients_valid), .coefficients_ready(coefficients_ready),
        .coefficients_data(coefficients_data),
        .colour_valid(colour_valid), .colour_ready(colour_ready), .colour_data(colour));

    // --- records ---------------------------------------------------------------------------------

    logic record_ask, record_asks;
    logic [23:0] slot;
    assign record_ask = splat_valid && colour_valid;
    assign splat_ready = record_asks;
    assign colour_ready = record_asks;

    // --- pairs -----------------------------------------------------------------------------------

    // Depth and number of the last splats that were seen, by the last bits of their count.
    logic [3:0][15:0] depths;
    logic [3:0][23:0] numbers;
    logic [1:0] seen_count;
    logic [23:0] seen_number;
    logic tiles_idle;
    logic [31:0] writes;
    logic writes_one, wrote_one;
    assign pair_entry = {4'd0, pair_subtiles, depths[pair_splat[1:0]], numbers[pair_splat[1:0]]};
    // Everything has been judged, nothing is in flight, and the walk of the last splat is over.
    assign is_over = go && judged >= gaussians && !kept_valid && flight == '0 && tiles_idle;
    assign done = is_over && writes == '0;
    assign writes_one = ask_valid && ask_ready && ask_write;
    assign wrote_one = come_valid && come_tag[2:0] == WRITE;

    // --- the memory port -------------------------------------------------------------------------

    assign record_asks = record_ask && ask_ready;
    assign colour_asks = colour_ask && ask_ready && !record_ask;
    assign shape_asks = shape_ask && ask_ready && !record_ask && !colour_ask;
    assign mean_asks = mean_ask && ask_ready && !record_ask && !colour_ask && !shape_ask;
    assign ask_valid = record_ask || colour_ask || shape_ask || mean_ask;
    assign ask_write = record_ask;
    // Form; a, b, c, opacity of the splat, whose depth is in the lists; colour.
    assign ask_data = {288'd0, colour, splat[79:16], 7'd0, form};
    always_comb begin
        if (record_ask) begin
            ask_address = features + {3'd0, slot, 5'd0};
            ask_bytes = 7'd32;
            ask_tag = {13'd0, WRITE};
        end else if (colour_ask) begin
            ask_address = coefficients + 32'd96 * wanted + (colour_part ? 32'd48 : 32'd0);
            ask_bytes = 7'd48;
            ask_tag = {(12 - K)'(0), colour_slot, colour_part, COLOUR};
        end else if (shape_ask) begin
            ask_address = shapes + 32'd24 * kept;
            ask_bytes = 7'd24;
            ask_tag = {(13 - H)'(0), shape_slot, SHAPE};
        end else begin
            ask_address = means + 32'd9 * mean_asked;
            ask_bytes = mean_left < 32'd7 ? 7'd9 * mean_left[6:0] : 7'd63;
            ask_tag = {(13 - M)'(0), mean_slot, MEAN};
        end
    end

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            mean_asked <= 32'(7 * UNIT);
            mean_given <= 32'(7 * UNIT);
            place <= '0;
            judged <= 32'(7 * UNIT);
            judged_place <= '0;
            flight <= '0;
            colour_part <= 1'b0;
            slot <= 24'(UNIT);
            seen_number <= 24'(UNIT);
            seen_count <= '0;
            writes <= '0;
        end else begin
            if (mean_asks) mean_asked <= mean_asked + 32'(7 * UNITS);
            if (mean_valid && mean_ready) begin
                mean_given <= behind(mean_given, place);
                place <= place == 3'd6 ? '0 : place + 3'd1;
            end
            if (verdict_valid && verdict_ready) begin
                judged <= behind(judged, judged_place);
                judged_place <= judged_place == 3'd6 ? '0 : judged_place + 3'd1;
            end
            flight <= flight + G'(shape_asks) - G'(dropped) - G'(record_asks);
            if (colour_asks) colour_part <= !colour_part;
            if (record_asks) slot <= slot + 24'(UNITS);
            if (seen) begin
                seen_number <= seen_number + 24'(UNITS);
                seen_count <= seen_count + 2'd1;
            end
            writes <= writes + 32'(writes_one) - 32'(wrote_one);
        end
    end
    always_ff @(posedge clk) begin
        if (seen) begin
            depths[seen_count] <= seen_depth;
            numbers[seen_count] <= seen_number;
        end
    end

    logic unused;
    assign unused = &{1'b0, no_wait, projected_valid, pair_u, pair_v, pair_splat[7:2], splat[15:0],
        come_data[511:504], come_tag};
endmodule
