// Queue in front of the cores of a sub-tile: QUEUE entries with the one that is worked on, so
// QUEUE - 1 places. What is pushed while nobody waits and the cores are ready goes straight to
// them. `room` depends on `ready` and on registers only. `flush` empties it; a push in the same
// cycle is lost. Reset: empty; data keep what they had.
module vru_queue #(
    parameter int WIDTH = 144,
    parameter int QUEUE = 2
) (
    input  logic             clk,
    input  logic             rst_n,
    input  logic             flush,
    input  logic             push,
    input  logic [WIDTH-1:0] d,
    output logic             room,
    output logic             empty,
    // Towards the cores, which take what is valid when they are ready.
    output logic             valid,
    input  logic             ready,
    output logic [WIDTH-1:0] q
);
    localparam int PLACES = QUEUE - 1;
    localparam int C = $clog2(PLACES + 1);
    logic [C-1:0] count;
    logic [PLACES-1:0][WIDTH-1:0] held;
    logic none;
    logic pop;
    logic store;
    logic [C-1:0] place;

    assign none = count == '0;
    assign empty = none || flush;
    assign pop = ready && !empty;
    assign room = count != C'(PLACES) || ready;
    assign valid = !flush && (!none || push);
    assign q = none ? d : held[0];
    assign store = push && !(none && ready);
    assign place = count - C'(pop);

    always_ff @(posedge clk) begin
        if (!rst_n || flush) count <= '0;
        else count <= place + C'(store);
        for (int i = 0; i < PLACES; i++) begin
            if (store && place == C'(i)) held[i] <= d;
            else if (pop && i + 1 < PLACES) held[i] <= held[(i+1)%PLACES];
        end
    end
endmodule
