// One stage of a bitonic network of 16 inputs: compare-exchanges of entries that are DISTANCE apart.
//
// Entry i meets entry i + DISTANCE; the pair is ordered upwards where bit BLOCK of i is clear, and
// downwards where it is set. A stage with BLOCK = 16 orders all pairs upwards.
// Combinational: eight compare-exchanges side by side.
module bitonic_stage #(
    parameter int unsigned ENTRY    = 32,
    parameter int unsigned DISTANCE = 1,
    parameter int unsigned BLOCK    = 16
) (
    input  logic [16*ENTRY-1:0] in_row,
    output logic [16*ENTRY-1:0] out_row
);
    for (genvar i = 0; i < 16; i++) begin : g_entry
        if ((i & DISTANCE) == 0) begin : g_pair
            localparam int unsigned J = i + DISTANCE;
            localparam bit UP = (i & BLOCK) == 0;
            logic [ENTRY-1:0] low, high;

            compare_exchange #(
                .ENTRY(ENTRY)
            ) exchange (
                .a   (in_row[i*ENTRY+:ENTRY]),
                .b   (in_row[J*ENTRY+:ENTRY]),
                .low (low),
                .high(high)
            );
            assign out_row[i*ENTRY+:ENTRY] = UP ? low : high;
            assign out_row[J*ENTRY+:ENTRY] = UP ? high : low;
        end
    end
endmodule
