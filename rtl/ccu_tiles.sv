// The tiles of a splat: which its box meets, and the part of its record that differs from tile to
// tile, in whole numbers. Places are in 1/256 pixel, coefficients in 2^-16.
//
// Setup takes nine cycles: numbers become whole, then the place of the middle of the first tile
// along the box, and u and v there, are made with two multipliers. Then the splat walks over the
// tiles under the square of its radius, one a cycle, row by row: from tile to tile all of these
// change by 16 coefficients. Meanwhile the next splat is set up. A splat that is infinite or NaN,
// or has no tile, is dropped in its third cycle. `in_ready` and the valids depend on registers and
// on the readies behind. Reset: no splat; data keep what they had.
module ccu_tiles #(
    parameter int EXP = 8,
    parameter int MAN = 15,
    parameter int TO_EXP = 5,
    parameter int TO_MAN = 10,
    localparam int W = EXP + MAN + 1,
    localparam int N = TO_EXP + TO_MAN + 1
) (
    input  logic            clk,
    input  logic            rst_n,
    // Columns and rows of tiles of the image.
    input  logic [8:0]      tiles_x,
    input  logic [8:0]      tiles_y,
    input  logic            in_valid,
    output logic            in_ready,
    // Outputs of the projection.
    input  logic [17*W-1:0] in_data,
    output logic            splat_valid,
    input  logic            splat_ready,
    // From the lowest: depth; a, b, c; opacity; direction from the eye.
    output logic [8*N-1:0]  splat_data,
    // From the lowest: mean in 1/256 pixel, two of 24 bits; a, b, c in 2^-16, three of 19.
    output logic [104:0]    splat_form,
    // What was taken in leaves nothing.
    output logic            dropped,
    // No splat is set up or walks.
    output logic            idle,
    output logic            pair_valid,
    input  logic            pair_ready,
    // Which splat, counted in 8 bits.
    output logic [7:0]      pair_splat,
    output logic [8:0]      pair_x,
    output logic [8:0]      pair_y,
    output logic [3:0]      pair_subtiles,
    output logic [N-1:0]    pair_u,
    output logic [N-1:0]    pair_v
);
    // Bits of places, of coefficients, and of sums of their products.
    localparam int PB = 24;
    localparam int CB = 19;
    localparam int SB = 36;
    localparam logic [EXP-1:0] ONES = '1;

    // --- setup -----------------------------------------------------------------------------------

    logic busy;
    logic [3:0] count;
    logic [16:0][W-1:0] held;
    logic regular;
    logic is_empty;
    logic hand_over;
    logic drop;
    assign in_ready = !busy || hand_over || drop;
    always_ff @(posedge clk) begin
        if (!rst_n) begin
            busy <= 1'b0;
            count <= '0;
        end else if (in_valid && in_ready) begin
            busy <= 1'b1;
            count <= '0;
        end else if (busy) begin
            if (hand_over || drop) busy <= 1'b0;
            else if (count != 4'd8) count <= count + 4'd1;
        end
    end
    always_ff @(posedge clk) begin
        if (in_valid && in_ready) held <= in_data;
    end
    always_comb begin
        regular = 1'b1;
        for (int i = 0; i < 17; i++) if (held[i][EXP+MAN-1:MAN] == ONES) regular = 1'b0;
    end

    // Places: mean, reach, half lengths in the first three cycles; coefficients: cosine, sine, a,
    // b, c in the first five; numbers of the record in the first eight.
    logic [W-1:0] place_from_x;
    logic [W-1:0] place_from_y;
    logic [W-1:0] coefficient_from;
    logic [W-1:0] record_from;
    logic signed [PB-1:0] place_x;
    logic signed [PB-1:0] place_y;
    logic signed [15:0] radius_now;
    logic signed [CB-1:0] coefficient;
    logic [N-1:0] record_part;
    always_comb begin
        case (count)
            4'd0: {place_from_y, place_from_x} = {held[2], held[1]};
            4'd1: {place_from_y, place_from_x} = {held[5], held[4]};
            default: {place_from_y, place_from_x} = {held[7], held[6]};
        endcase
        case (count)
            4'd0: coefficient_from = held[8];
            4'd1: coefficient_from = held[9];
            4'd2: coefficient_from = held[10];
            4'd3: coefficient_from = held[11];
            default: coefficient_from = held[12];
        endcase
        case (count)
            4'd0: record_from = held[0];
            4'd1: record_from = held[10];
            4'd2: record_from = held[11];
            4'd3: record_from = held[12];
            4'd4: record_from = held[13];
            4'd5: record_from = held[14];
            4'd6: record_from = held[15];
            default: record_from = held[16];
        endcase
    end
    fp_fixed #(.EXP(EXP), .MAN(MAN), .FRACTION(8), .BITS(PB), .ROUNDING(0)) fixed_x (
        .a(place_from_x), .y(place_x));
    fp_fixed #(.EXP(EXP), .MAN(MAN), .FRACTION(8), .BITS(PB), .ROUNDING(0)) fixed_y (
        .a(place_from_y), .y(place_y));
    fp_fixed #(.EXP(EXP), .MAN(MAN), .FRACTION(0), .BITS(16), .ROUNDING(1)) fixed_radius (
        .a(held[3]), .y(radius_now));
    fp_fixed #(.EXP(EXP), .MAN(MAN), .FRACTION(16), .BITS(CB), .ROUNDING(2)) fixed_coefficient (
        .a(coefficient_from), .y(coefficient));
    fp_narrow #(.EXP(EXP), .MAN(MAN), .TO_EXP(TO_EXP), .TO_MAN(TO_MAN)) narrow (
        .a(record_from), .y(record_part));

    logic signed [PB-1:0] mean_x;
    logic signed [PB-1:0] mean_y;
    logic signed [PB-1:0] reach_x;
    logic signed [PB-1:0] reach_y;
    logic signed [PB-1:0] half_0;
    logic signed [PB-1:0] half_1;
    logic signed [15:0] radius;
    logic [4:0][CB-1:0] coefficients;
    logic [7:0][N-1:0] record;
    always_ff @(posedge clk) begin
        if (busy) begin
            if (count == 4'd0) begin
                mean_x <= place_x;
                mean_y <= place_y;
                radius <= radius_now;
            end
            if (count == 4'd1) begin
                reach_x <= place_x;
                reach_y <= place_y;
            end
            if (count == 4'd2) begin
                half_0 <= place_x;
                half_1 <= place_y;
            end
            if (count < 4'd5) coefficients[count[2:0]] <= coefficient;
            if (count < 4'd8) record[count[2:0]] <= record_part;
        end
    end

    // The tiles under the square of the radius, in the second cycle: places over 4,096, held within
    // the image.
    function automatic logic [8:0] held_within(input logic signed [PB+1:0] place,
                                               input logic [8:0] most);
        logic signed [PB-11:0] tile;
        tile = (PB - 10)'(place >>> 12);
        if (tile < 0) held_within = '0;
        else if (tile > $signed({5'd0, most})) held_within = most;
        else held_within = tile[8:0];
    endfunction
    logic signed [PB+1:0] span;
    logic signed [PB+1:0] last_pixels;
    assign span = (PB + 2)'(radius) <<< 8;
    assign last_pixels = span + (PB + 2)'(15 * 256);
    logic [8:0] x_first;
    logic [8:0] x_end;
    logic [8:0] y_first;
    logic [8:0] y_end;
    always_ff @(posedge clk) begin
        if (busy && count == 4'd1) begin
            x_first <= held_within((PB + 2)'(mean_x) - span, tiles_x);
            x_end <= held_within((PB + 2)'(mean_x) + last_pixels, tiles_x);
            y_first <= held_within((PB + 2)'(mean_y) - span, tiles_y);
            y_end <= held_within((PB + 2)'(mean_y) + last_pixels, tiles_y);
        end
    end
    assign is_empty = x_first >= x_end || y_first >= y_end;
    assign drop = busy && count == 4'd2 && (is_empty || !regular);

    // The middle of the first tile from the mean, in the third cycle.
    logic signed [PB:0] place_0;
    logic signed [PB:0] place_1;
    always_ff @(posedge clk) begin
        if (busy && count == 4'd2) begin
            place_0 <= $signed({4'd0, x_first, 12'd2048}) - (PB + 1)'(mean_x);
            place_1 <= $signed({4'd0, y_first, 12'd2048}) - (PB + 1)'(mean_y);
        end
    end

    // Two products a cycle, from the fourth on; their sums a cycle later.
    logic signed [PB:0] factor_0;
    logic signed [PB:0] factor_1;
    logic signed [CB-1:0] by_0;
    logic signed [CB-1:0] by_1;
    logic signed [PB+CB:0] times_0;
    logic signed [PB+CB:0] times_1;
    logic signed [SB-1:0] product_0;
    logic signed [SB-1:0] product_1;
    logic signed [SB-1:0] sum;
    logic [3:0][SB-1:0] starts;
    always_comb begin
        case (count)
            4'd3: begin
                factor_0 = place_0;
                factor_1 = place_1;
                {by_1, by_0} = {coefficients[1], coefficients[0]};
            end
            4'd4: begin
                factor_0 = place_1;
                factor_1 = place_0;
                {by_1, by_0} = {coefficients[1], coefficients[0]};
            end
            4'd5: begin
                factor_0 = place_0 - (PB + 1)'(128);
                factor_1 = place_1 - (PB + 1)'(128);
                {by_1, by_0} = {coefficients[3], coefficients[2]};
            end
            default: begin
                factor_0 = place_1 - (PB + 1)'(128);
                factor_1 = place_1 - (PB + 1)'(128);
                {by_1, by_0} = {CB'(0), coefficients[4]};
            end
        endcase
        times_0 = factor_0 * by_0;
        times_1 = factor_1 * by_1;
        sum = count == 4'd5 ? product_0 - product_1 : product_0 + product_1;
    end
    always_ff @(posedge clk) begin
        if (busy && count >= 4'd3 && count < 4'd7) begin
            product_0 <= times_0[PB+CB:8];
            product_1 <= times_1[PB+CB:8];
        end
        if (busy && count >= 4'd4 && count < 4'd8) starts[2'(count)] <= sum;
    end

    // --- the walk --------------------------------------------------------------------------------

    logic walking;
    logic advance;
    logic last;
    logic last_column;
    logic hit;
    logic [7:0] splats;
    assign hand_over = busy && count == 4'd8 && splat_ready && (!walking || (last && advance));
    assign splat_valid = busy && count == 4'd8 && (!walking || (last && advance));
    assign splat_data = record;
    assign splat_form = {coefficients[4:2], mean_y, mean_x};
    assign dropped = drop;
    assign idle = !busy && !walking && !hit;

    logic alone;
    logic [8:0] x;
    logic [8:0] x_from;
    logic [8:0] x_to;
    logic [8:0] y;
    logic [8:0] y_to;
    logic signed [PB:0] across;
    logic signed [PB:0] across_from;
    logic signed [PB:0] down;
    logic signed [CB-1:0] cosine;
    logic signed [CB-1:0] sine;
    logic signed [CB-1:0] root_a;
    logic signed [CB-1:0] root_b;
    logic signed [CB-1:0] root_c;
    logic signed [PB-1:0] walk_reach_x;
    logic signed [PB-1:0] walk_reach_y;
    logic [CB:0] corner;
    logic signed [SB-1:0] limit_0;
    logic signed [SB-1:0] limit_1;
    logic signed [SB-1:0] along_0;
    logic signed [SB-1:0] along_1;
    logic signed [SB-1:0] along_u;
    logic signed [SB-1:0] along_v;
    logic signed [SB-1:0] row_0;
    logic signed [SB-1:0] row_1;
    logic signed [SB-1:0] row_u;

    function automatic logic [CB-1:0] size(input logic signed [CB-1:0] number);
        size = number[CB-1] ? -number : number;
    endfunction
    logic [CB:0] corner_next;
    assign corner_next = (CB + 1)'(size(coefficients[0])) + (CB + 1)'(size(coefficients[1]));

    // 16 coefficients.
    function automatic logic signed [SB-1:0] tile_of(input logic signed [CB-1:0] number);
        tile_of = SB'(number) <<< 4;
    endfunction

    assign last_column = x + 9'd1 == x_to;
    assign last = last_column && y + 9'd1 == y_to;
    always_ff @(posedge clk) begin
        if (!rst_n) begin
            walking <= 1'b0;
            splats <= '0;
        end else if (hand_over) begin
            walking <= 1'b1;
            splats <= splats + 8'd1;
        end else if (last && advance) begin
            walking <= 1'b0;
        end
    end
    always_ff @(posedge clk) begin
        if (hand_over) begin
            alone <= x_first + 9'd1 == x_end && y_first + 9'd1 == y_end;
            x <= x_first;
            x_from <= x_first;
            x_to <= x_end;
            y <= y_first;
            y_to <= y_end;
            across <= place_0;
            across_from <= place_0;
            down <= place_1;
            {root_c, root_b, root_a, sine, cosine} <= coefficients;
            walk_reach_x <= reach_x;
            walk_reach_y <= reach_y;
            corner <= corner_next;
            limit_0 <= (SB'(half_0) <<< 8) + $signed(SB'({corner_next, 3'd0}));
            limit_1 <= (SB'(half_1) <<< 8) + $signed(SB'({corner_next, 3'd0}));
            along_0 <= starts[0];
            along_1 <= starts[1];
            along_u <= starts[2];
            along_v <= starts[3];
            row_0 <= starts[0];
            row_1 <= starts[1];
            row_u <= starts[2];
        end else if (walking && advance) begin
            if (last_column) begin
                x <= x_from;
                y <= y + 9'd1;
                across <= across_from;
                down <= down + (PB + 1)'(16 * 256);
                along_0 <= row_0 + tile_of(sine);
                along_1 <= row_1 + tile_of(cosine);
                along_u <= row_u + tile_of(root_b);
                along_v <= along_v + tile_of(root_c);
                row_0 <= row_0 + tile_of(sine);
                row_1 <= row_1 + tile_of(cosine);
                row_u <= row_u + tile_of(root_b);
            end else begin
                x <= x + 9'd1;
                across <= across + (PB + 1)'(16 * 256);
                along_0 <= along_0 + tile_of(cosine);
                along_1 <= along_1 - tile_of(sine);
                along_u <= along_u + tile_of(root_a);
            end
        end
    end

    // --- the tests -------------------------------------------------------------------------------

    function automatic logic reaches(input logic signed [SB-1:0] place,
                                    input logic signed [SB-1:0] limit);
        reaches = place <= limit && -place <= limit;
    endfunction

    // A quarter of a tile. (Yosys 0.70 takes the sign in -N'(x) for one of N.)
    localparam logic signed [SB-1:0] QUARTER = SB'(4 * 256);
    logic meets;
    logic [3:0] subtiles;
    logic [1:0] columns;
    logic [1:0] rows;
    logic signed [SB-1:0] corner_4;
    logic signed [SB-1:0] cosine_4;
    logic signed [SB-1:0] sine_4;
    always_comb begin
        corner_4 = $signed(SB'({corner, 2'd0}));
        cosine_4 = SB'(cosine) <<< 2;
        sine_4 = SB'(sine) <<< 2;
        meets = reaches(SB'(across), SB'(walk_reach_x) + SB'(8 * 256))
            && reaches(SB'(down), SB'(walk_reach_y) + SB'(8 * 256))
            && reaches(along_0, limit_0) && reaches(along_1, limit_1);
        columns[0] = reaches(SB'(across) - QUARTER, SB'(walk_reach_x) + QUARTER);
        columns[1] = reaches(SB'(across) + QUARTER, SB'(walk_reach_x) + QUARTER);
        rows[0] = reaches(SB'(down) - QUARTER, SB'(walk_reach_y) + QUARTER);
        rows[1] = reaches(SB'(down) + QUARTER, SB'(walk_reach_y) + QUARTER);
        for (int i = 0; i < 4; i++) begin
            subtiles[i] = columns[i[0]] && rows[i[1]]
                && reaches(along_0 + (i[0] ? cosine_4 : -cosine_4) + (i[1] ? sine_4 : -sine_4),
                          limit_0 - corner_4)
                && reaches(along_1 + (i[1] ? cosine_4 : -cosine_4) - (i[0] ? sine_4 : -sine_4),
                          limit_1 - corner_4);
        end
    end

    logic signed [SB-1:0] hit_u;
    logic signed [SB-1:0] hit_v;
    assign advance = !hit || pair_ready;
    assign pair_valid = hit;
    always_ff @(posedge clk) begin
        if (!rst_n) hit <= 1'b0;
        else if (advance) hit <= walking && (meets || alone);
    end
    always_ff @(posedge clk) begin
        if (advance && walking && (meets || alone)) begin
            pair_splat <= splats - 8'd1;
            pair_x <= x;
            pair_y <= y;
            pair_subtiles <= subtiles;
            hit_u <= along_u;
            hit_v <= along_v;
        end
    end
    ccu_local #(.EXP(TO_EXP), .MAN(TO_MAN), .BITS(SB), .FRACTION(16)) local_u (
        .sum(hit_u), .y(pair_u));
    ccu_local #(.EXP(TO_EXP), .MAN(TO_MAN), .BITS(SB), .FRACTION(16)) local_v (
        .sum(hit_v), .y(pair_v));

    logic unused;
    assign unused = &{1'b0, times_0[7:0], times_1[7:0]};
endmodule
