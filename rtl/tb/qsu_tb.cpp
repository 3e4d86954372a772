// Test bench of qsu.sv: random keys and stalls against a count of pivots; latency 2, interval 1.
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <random>

#include "Vqsu.h"

namespace {

Vqsu unit;

void tick() {
    unit.clk = 1;
    unit.eval();
    unit.clk = 0;
    unit.eval();
}

void expect(bool holds, const char *what, long cycle) {
    if (holds) return;
    std::fprintf(stderr, "qsu: %s in cycle %ld\n", what, cycle);
    std::exit(1);
}

struct Entry {
    unsigned key, payload, part;
    long accepted;
};

// Entries with stalls of both sides in `stalls` of 8 cycles; returns cycles for `count` entries.
long run(std::mt19937 &random, const unsigned *pivots, int stalls, long count) {
    std::deque<Entry> inside;
    long given = 0, taken = 0, cycle = 0;
    bool offered = false;
    while (taken < count) {
        if (!offered) offered = given < count && int(random() % 8) >= stalls;
        if (offered && !unit.in_valid) {
            // Every other key is a pivot or a neighbour of one.
            unit.in_key = random() % 2 ? random() : pivots[random() % 7] + random() % 3 - 1;
            unit.in_payload = random();
        }
        unit.in_valid = offered;
        unit.out_ready = int(random() % 8) >= stalls;
        unit.eval();
        if (unit.in_valid && unit.in_ready) {
            unsigned part = 0;
            for (int p = 0; p < 7; p++) part += pivots[p] <= unit.in_key;
            inside.push_back({unit.in_key, unit.in_payload, part, cycle});
            given++;
            offered = false;
        }
        if (unit.out_valid && unit.out_ready) {
            expect(!inside.empty(), "an entry that never entered", cycle);
            Entry e = inside.front();
            inside.pop_front();
            expect(unit.out_key == e.key && unit.out_payload == e.payload, "another entry", cycle);
            expect(unit.out_part == e.part, "a wrong part", cycle);
            expect(stalls || cycle == e.accepted + 2, "a latency other than 2", cycle);
            taken++;
        }
        bool accepted = !offered;
        tick();
        if (accepted) unit.in_valid = 0;
        cycle++;
    }
    return cycle;
}

}  // namespace

int main() {
    std::mt19937 random(1);
    unit.rst_n = 0;
    tick();
    unit.rst_n = 1;
    unit.eval();
    expect(!unit.out_valid && unit.in_ready, "an entry after reset", 0);
    for (int round = 0; round < 20; round++) {
        unsigned pivots[7], next = random() % 8192;
        for (unsigned p = 0; p < 7; p++) {
            pivots[p] = next;
            next += random() % 8192;
            unit.pivot_valid = 1;
            unit.pivot_index = p;
            unit.pivot_key = pivots[p];
            tick();
        }
        unit.pivot_valid = 0;
        long cycles = run(random, pivots, 0, 1000);
        expect(cycles == 1002, "an interval other than 1", cycles);
        run(random, pivots, 4, 1000);
    }
    std::puts("qsu: 40,000 entries, latency 2, interval 1");
}
