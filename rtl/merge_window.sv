// The next 16 entries of one sorted list, entry by entry in 16 banks, for the merge of the BSU.
//
// Two rows of the list are held. Bank i shows entry i of the first row, or that of the second row
// once it has been taken from the first. `take` says which heads the merge takes in this cycle;
// what it takes of a list is always a run of the list, so the first row is used up (`crosses`)
// when every bank has been taken from. Then the second row becomes the first.
// A row that is the last of its list ends it: the row behind belongs to the next pair of lists, and
// its entries show as `beyond`, above every entry, until `pair_done`.
//
// Interval: a row a cycle; latency 1. Reset: no rows. `in_ready` depends on `take`, not on `in_valid`.
module merge_window #(
    parameter int unsigned ENTRY = 32
) (
    input  logic                clk,
    input  logic                rst_n,
    input  logic                in_valid,
    output logic                in_ready,
    input  logic                in_last,
    input  logic [16*ENTRY-1:0] in_row,
    output logic                ready_to_merge,
    output logic [16*ENTRY-1:0] heads,
    output logic [15:0]         beyond,
    input  logic [15:0]         take,
    output logic                ends,
    input  logic                pair_done
);
    logic [16*ENTRY-1:0] first, second;
    logic first_valid, first_last, second_valid, second_last;
    logic [15:0] taken, taken_next;
    logic ended, crosses, push;

    // A list that has ended shows nothing until its partner has ended too.
    assign beyond         = {16{ended}} | (taken & {16{first_last}});
    assign ready_to_merge = ended || (first_valid && (taken == '0 || first_last || second_valid));
    assign crosses        = &(taken | take) && !ended;
    assign ends           = ended || (crosses && first_last);
    assign in_ready       = !second_valid || crosses;
    assign push           = in_valid && in_ready;
    assign taken_next     = crosses ? taken & take : taken | take;

    for (genvar i = 0; i < 16; i++) begin : g_head
        assign heads[i*ENTRY+:ENTRY] = taken[i] ? second[i*ENTRY+:ENTRY] : first[i*ENTRY+:ENTRY];
    end

    always_ff @(posedge clk) begin
        if (!rst_n) begin
            first_valid  <= 1'b0;
            second_valid <= 1'b0;
            taken        <= '0;
            ended        <= 1'b0;
        end else begin
            taken <= taken_next;
            ended <= pair_done ? 1'b0 : ends;
            if (crosses) begin
                first_valid  <= second_valid || push;
                second_valid <= second_valid && push;
            end else if (push) begin
                first_valid  <= 1'b1;
                second_valid <= first_valid;
            end
        end
    end

    always_ff @(posedge clk) begin
        if (crosses && second_valid) begin
            first      <= second;
            first_last <= second_last;
        end else if (push && (crosses || !first_valid)) begin
            first      <= in_row;
            first_last <= in_last;
        end
        if (push && (crosses ? second_valid : first_valid)) begin
            second      <= in_row;
            second_last <= in_last;
        end
    end
endmodule
