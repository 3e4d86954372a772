// Test bench of bsu.sv: random rows and pairs of lists, with and without stalls, against std::sort;
// latency 4, interval 1 row for either way.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <random>
#include <vector>

#include "Vbsu.h"

namespace {

using Row = std::vector<uint32_t>;

struct Beat {
    Row row;
    bool last;
};

Vbsu unit;

void tick() {
    unit.clk = 1;
    unit.eval();
    unit.clk = 0;
    unit.eval();
}

void expect(bool holds, const char *what, long cycle) {
    if (holds) return;
    std::fprintf(stderr, "bsu: %s in cycle %ld\n", what, cycle);
    std::exit(1);
}

// A source that holds its row until it is accepted.
struct Source {
    std::deque<Beat> beats;
    bool offered = false;

    bool offer(std::mt19937 &random, int stalls) {
        if (!offered) offered = !beats.empty() && int(random() % 8) >= stalls;
        return offered;
    }
    void accepted() {
        beats.pop_front();
        offered = false;
    }
};

// Runs until `expected` has left; returns the cycle of the first and behind the last row.
std::pair<long, long> run(std::mt19937 &random, int stalls, Source sort, Source a, Source b,
                          std::deque<Row> expected) {
    long cycle = 0, first = -1;
    while (!expected.empty()) {
        unit.sort_valid = sort.offer(random, stalls);
        unit.a_valid = a.offer(random, stalls);
        unit.b_valid = b.offer(random, stalls);
        for (int i = 0; i < 16; i++) {
            if (sort.offered) unit.sort_row[i] = sort.beats[0].row[i];
            if (a.offered) unit.a_row[i] = a.beats[0].row[i];
            if (b.offered) unit.b_row[i] = b.beats[0].row[i];
        }
        if (a.offered) unit.a_last = a.beats[0].last;
        if (b.offered) unit.b_last = b.beats[0].last;
        unit.out_ready = int(random() % 8) >= stalls;
        unit.eval();
        if (unit.out_valid && unit.out_ready) {
            if (first < 0) first = cycle;
            for (int i = 0; i < 16; i++) expect(unit.out_row[i] == expected[0][i], "a wrong row", cycle);
            expected.pop_front();
        }
        if (unit.sort_valid && unit.sort_ready) sort.accepted();
        if (unit.a_valid && unit.a_ready) a.accepted();
        if (unit.b_valid && unit.b_ready) b.accepted();
        tick();
        expect(++cycle < 100000, "no end", cycle);
    }
    unit.sort_valid = unit.a_valid = unit.b_valid = 0;
    return {first, cycle};
}

// Entries in the range of `spread`: a small one makes ties, and lists that do not overlap.
Row entries(std::mt19937 &random, size_t count, uint32_t spread, uint32_t from) {
    Row row(count);
    for (auto &entry : row) entry = from + (spread ? uint32_t(random()) % spread : uint32_t(random()));
    return row;
}

std::deque<Beat> rows(const Row &list) {
    std::deque<Beat> beats;
    for (size_t i = 0; i < list.size(); i += 16)
        beats.push_back({Row(list.begin() + i, list.begin() + i + 16), i + 16 == list.size()});
    return beats;
}

}  // namespace

int main() {
    std::mt19937 random(1);
    unit.rst_n = 0;
    tick();
    unit.rst_n = 1;
    unit.eval();
    expect(!unit.out_valid, "a row after reset", 0);
    for (int round = 0; round < 200; round++) {
        int stalls = round % 2 * 4;
        uint32_t spread = round % 4 < 2 ? 0 : 40;
        Source sort, a, b;
        std::deque<Row> expected;
        for (int i = 0; i < 100; i++) {
            Row row = entries(random, 16, spread, 0);
            sort.beats.push_back({row, false});
            std::sort(row.begin(), row.end());
            expected.push_back(row);
        }
        auto [first, end] = run(random, stalls, sort, a, b, expected);
        expect(stalls || (first == 4 && end == 104), "another time of sorting", end);
        sort.beats.clear();
        expected.clear();
        for (int pair = 0; pair < 40; pair++) {
            Row x = entries(random, 16 * (1 + random() % 8), spread, random() % 3 * spread);
            Row y = entries(random, 16 * (1 + random() % 8), spread, random() % 3 * spread);
            std::sort(x.begin(), x.end());
            std::sort(y.begin(), y.end());
            for (auto &beat : rows(x)) a.beats.push_back(beat);
            for (auto &beat : rows(y)) b.beats.push_back(beat);
            x.insert(x.end(), y.begin(), y.end());
            std::sort(x.begin(), x.end());
            for (auto &beat : rows(x)) expected.push_back(beat.row);
        }
        long count = long(expected.size());
        auto [start, done] = run(random, stalls, sort, a, b, expected);
        expect(stalls || (start == 4 && done == count + 4), "another time of merging", done);
    }
    std::puts("bsu: 20,000 rows sorted, 8,000 pairs of lists merged, latency 4, interval 1");
}
