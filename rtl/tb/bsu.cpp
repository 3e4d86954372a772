// Sorts chunks with bsu.sv and tells what happens, all in 16-bit words. Reads a seed, stalls of the
// inputs and of the output (in eighths of cycles), and chunks: the number of rows, and 16 entries of
// two words (low, high) each. Rows are sorted, and what leaves is merged in pairs, level by level,
// each when the one before has left whole; a list without a partner stays where it is. Writes 35
// words an event: kind, cycle (low, high), 32 words. Kind 1: a chunk is sorted; 0: its rows, in order.
#include <cstdint>
#include <cstdio>
#include <deque>
#include <random>
#include <vector>

#include "Vbsu.h"

namespace {

using Row = std::vector<uint32_t>;
using List = std::vector<Row>;

Vbsu unit;
uint32_t cycle = 0;
std::mt19937 random_bits;
uint16_t come, go;

void tick() {
    unit.clk = 1;
    unit.eval();
    unit.clk = 0;
    unit.eval();
}

void tell(uint16_t kind, const Row &row) {
    uint16_t event[35] = {kind, uint16_t(cycle - 1), uint16_t((cycle - 1) >> 16)};
    for (size_t i = 0; i < row.size(); i++) {
        event[3 + 2 * i] = uint16_t(row[i]);
        event[4 + 2 * i] = uint16_t(row[i] >> 16);
    }
    std::fwrite(event, sizeof event, 1, stdout);
}

struct Beat {
    Row row;
    bool last;
};

// A port that holds its row until it is accepted.
struct Source {
    std::deque<Beat> beats;
    bool offered = false;

    void add(const List &list) {
        for (size_t i = 0; i < list.size(); i++) beats.push_back({list[i], i + 1 == list.size()});
    }
    bool offer() {
        if (!offered) offered = !beats.empty() && random_bits() % 8 >= come;
        return offered;
    }
    void accepted() {
        beats.pop_front();
        offered = false;
    }
};

template <typename Port>
void put(Port &port, const Source &source) {
    for (int i = 0; source.offered && i < 16; i++) port[i] = source.beats[0].row[i];
}

// Runs until `rows` rows have left.
List run(Source sort, Source a, Source b, size_t rows) {
    List left;
    const uint32_t limit = cycle + 1000 + 100 * uint32_t(rows);
    while (left.size() < rows && cycle < limit) {
        unit.sort_valid = sort.offer();
        unit.a_valid = a.offer();
        unit.b_valid = b.offer();
        put(unit.sort_row, sort);
        put(unit.a_row, a);
        put(unit.b_row, b);
        if (a.offered) unit.a_last = a.beats[0].last;
        if (b.offered) unit.b_last = b.beats[0].last;
        unit.out_ready = random_bits() % 8 >= go;
        unit.eval();
        if (unit.out_valid && unit.out_ready) left.emplace_back(&unit.out_row[0], &unit.out_row[0] + 16);
        if (unit.sort_valid && unit.sort_ready) sort.accepted();
        if (unit.a_valid && unit.a_ready) a.accepted();
        if (unit.b_valid && unit.b_ready) b.accepted();
        tick();
        cycle++;
    }
    unit.sort_valid = unit.a_valid = unit.b_valid = 0;
    return left;
}

}  // namespace

int main() {
    uint16_t head[3], rows, entry[2];
    if (std::fread(head, sizeof head, 1, stdin) != 1) return 1;
    random_bits.seed(head[0]);
    come = head[1];
    go = head[2];
    unit.rst_n = 0;
    tick();
    tick();
    unit.rst_n = 1;
    unit.eval();
    if (unit.out_valid) return 1;
    while (std::fread(&rows, sizeof rows, 1, stdin) == 1) {
        List chunk(rows, Row(16));
        for (auto &row : chunk) {
            for (auto &value : row) {
                if (std::fread(entry, sizeof entry, 1, stdin) != 1) return 1;
                value = entry[0] | uint32_t(entry[1]) << 16;
            }
        }
        Source sort;
        for (const auto &row : chunk) sort.beats.push_back({row, false});
        const List sorted = run(sort, {}, {}, rows);
        if (sorted.size() < rows) return 1;
        std::vector<List> lists;
        for (const auto &row : sorted) lists.push_back({row});
        while (lists.size() > 1) {
            Source a, b;
            size_t moved = 0;
            for (size_t i = 0; i + 1 < lists.size(); i += 2) {
                a.add(lists[i]);
                b.add(lists[i + 1]);
                moved += lists[i].size() + lists[i + 1].size();
            }
            const List merged = run({}, a, b, moved);
            if (merged.size() < moved) return 1;
            std::vector<List> next;
            size_t at = 0;
            for (size_t i = 0; i < lists.size(); i += 2) {
                if (i + 1 == lists.size()) {
                    next.push_back(lists[i]);
                    continue;
                }
                const size_t count = lists[i].size() + lists[i + 1].size();
                next.emplace_back(merged.begin() + at, merged.begin() + at + count);
                at += count;
            }
            lists = next;
        }
        tell(1, {});
        if (rows > 0) {
            for (const auto &row : lists[0]) tell(0, row);
        }
    }
    return 0;
}
