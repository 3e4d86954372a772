// Volume rendering unit of a core: a tile of 16 x 16 pixels, four sub-tiles of 8 x 8 with a queue
// each, and four cores of 4 x 4 pixels in each sub-tile.
//
// Beats arrive in order and wait in one register, at the head. OPEN begins a tile of `open_width` x
// `open_height` pixels that are in the image. A SPLAT leaves the head when the queues of all
// sub-tiles of its bitmap have room, and enters them in one and the same cycle, one splat a cycle at
// most; sub-tiles that are known to have stopped need no room and receive nothing. A splat holds a
// sub-tile for 16 cycles. That a sub-tile has stopped is known one cycle behind `stopped` of its
// last core; what waits in its queue then leaves unused. CLOSE leaves the head when all queues are
// empty and all cores are ready. Then pipelines drain, and the pixels leave together, one of each
// core a cycle; then comes the next OPEN.
//
// `stopped` says that no sub-tile needs anything more. Reset: no beat, no tile, queues empty.
// `in_ready` and `out_valid` depend on registers only.
module vru #(
    parameter int EXP = 5,
    parameter int MAN = 10,
    parameter bit SPLIT = 1'b1,
    // Entries of a queue with the one that is worked on, at least 2.
    parameter int QUEUE = 2,
    localparam int W = EXP + MAN + 1
) (
    input  logic            clk,
    input  logic            rst_n,
    input  logic            in_valid,
    output logic            in_ready,
    // As for vrc.
    input  logic [1:0]      in_op,
    input  logic [9*W-1:0]  in_record,
    // Sub-tiles: left and right of the upper row, then of the lower one.
    input  logic [3:0]      in_bitmap,
    input  logic [4:0]      open_width,
    input  logic [4:0]      open_height,
    output logic            stopped,
    output logic            out_valid,
    input  logic            out_ready,
    // Core by core, four to a sub-tile, in rows of two: red, green, blue, transmittance.
    output logic [64*W-1:0] out_pixels
);
    localparam int SIDE = 2;
    localparam int SUBTILES = SIDE * SIDE;
    localparam int CORES = 4;
    localparam int PIXELS = 16;
    localparam int COLUMNS = 4;
    localparam logic [1:0] OPEN = 2'd0;
    localparam logic [1:0] SPLAT = 2'd1;
    localparam logic [1:0] CLOSE = 2'd2;

    // --- the head --------------------------------------------------------------------------------

    logic head_valid;
    logic [1:0] op;
    logic [9*W-1:0] record;
    logic [3:0] bitmap;
    logic [4:0] width;
    logic [4:0] height;
    logic leaves;

    assign in_ready = !head_valid || leaves;

    always_ff @(posedge clk) begin
        if (!rst_n) head_valid <= 1'b0;
        else if (in_ready) head_valid <= in_valid;
        if (in_valid && in_ready) begin
            op <= in_op;
            bitmap <= in_bitmap;
            width <= open_width;
            height <= open_height;
            if (in_op == SPLAT) record <= in_record;
        end
    end

    // --- sub-tiles -------------------------------------------------------------------------------

    logic [SUBTILES-1:0] known;
    logic [SUBTILES-1:0] wanted;
    logic [SUBTILES-1:0] room;
    logic [SUBTILES-1:0] empty;
    logic [SUBTILES*CORES-1:0] ready;
    logic [SUBTILES*CORES-1:0] core_stopped;
    logic [SUBTILES*CORES-1:0] leaving;
    logic opens;
    logic closes;
    logic pushes;

    assign wanted = bitmap & ~known;
    assign leaves = head_valid && (op == SPLAT ? (wanted & ~room) == '0 : &empty && &ready);
    assign opens = leaves && op == OPEN;
    assign closes = leaves && op == CLOSE;
    assign pushes = leaves && op == SPLAT;
    assign stopped = &known;
    assign out_valid = &leaving;

    for (genvar s = 0; s < SUBTILES; s++) begin : g_subtile
        localparam int LEFT = 8 * (s % SIDE);
        localparam int TOP = 8 * (s / SIDE);
        logic waits;
        logic [9*W-1:0] next;
        vru_queue #(.WIDTH(9 * W), .QUEUE(QUEUE)) queue (
            .clk(clk), .rst_n(rst_n), .flush(known[s]), .push(pushes && wanted[s]), .d(record),
            .room(room[s]), .empty(empty[s]), .valid(waits), .ready(ready[CORES*s]), .q(next));
        always_ff @(posedge clk) begin
            if (!rst_n) known[s] <= 1'b0;
            else if (opens) known[s] <= width <= 5'(LEFT) || height <= 5'(TOP);
            else if (core_stopped[CORES*s+:CORES] == '1) known[s] <= 1'b1;
        end
        for (genvar c = 0; c < CORES; c++) begin : g_core
            localparam int X = LEFT + 4 * (c % 2);
            localparam int Y = TOP + 4 * (c / 2);
            logic [PIXELS-1:0] mask;
            for (genvar i = 0; i < PIXELS; i++) begin : g_pixel
                assign mask[i] = width > 5'(X + i % COLUMNS) && height > 5'(Y + i / COLUMNS);
            end
            vrc #(
                .EXP(EXP), .MAN(MAN), .SPLIT(SPLIT), .PIXELS(PIXELS), .COLUMNS(COLUMNS)
            ) core (
                .clk(clk),
                .rst_n(rst_n),
                .in_valid(opens || closes || waits),
                .in_ready(ready[CORES*s+c]),
                .in_op(opens ? OPEN : closes ? CLOSE : SPLAT),
                .in_record(next),
                .open_x(4'(X)),
                .open_y(4'(Y)),
                .open_mask(mask),
                .stopped(core_stopped[CORES*s+c]),
                .out_valid(leaving[CORES*s+c]),
                .out_ready(out_ready && out_valid),
                .out_pixel(out_pixels[(CORES*s+c)*4*W+:4*W])
            );
        end
    end
endmodule
