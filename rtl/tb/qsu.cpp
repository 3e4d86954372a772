// Feeds lists to qsu.sv and tells what happens, all in 16-bit words. Reads a seed, stalls of the
// input and of the output (in eighths of cycles), and lists: the number of keys (low, high), seven
// pivots, the keys; key i has payload i. Pivots are written, one a cycle, when the unit is empty.
// Writes six words an event: kind, cycle (low, high), three words. Kind 0: an entry leaves (key,
// payload, part); 1: the last one of a list has left.
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include "Vqsu.h"

namespace {

Vqsu unit;
uint32_t cycle = 0;

void tick() {
    unit.clk = 1;
    unit.eval();
    unit.clk = 0;
    unit.eval();
}

void tell(uint16_t kind, uint16_t a, uint16_t b, uint16_t c) {
    const uint16_t event[6] = {kind, uint16_t(cycle), uint16_t(cycle >> 16), a, b, c};
    std::fwrite(event, sizeof event, 1, stdout);
}

}  // namespace

int main() {
    uint16_t head[3], list[9];
    if (std::fread(head, sizeof head, 1, stdin) != 1) return 1;
    std::mt19937 random(head[0]);
    unit.rst_n = 0;
    tick();
    tick();
    unit.rst_n = 1;
    unit.eval();
    if (unit.out_valid || !unit.in_ready) return 1;
    while (std::fread(list, sizeof list, 1, stdin) == 1) {
        std::vector<uint16_t> keys(list[0] | uint32_t(list[1]) << 16);
        if (std::fread(keys.data(), 2, keys.size(), stdin) != keys.size()) return 1;
        for (int p = 0; p < 7; p++, cycle++) {
            unit.pivot_valid = 1;
            unit.pivot_index = p;
            unit.pivot_key = list[2 + p];
            tick();
        }
        unit.pivot_valid = 0;
        size_t given = 0, left = 0;
        bool offered = false;
        const uint32_t limit = cycle + 1000 + 100 * uint32_t(keys.size());
        while (left < keys.size() && cycle < limit) {
            if (!offered) offered = given < keys.size() && random() % 8 >= head[1];
            unit.in_valid = offered;
            if (offered) {
                unit.in_key = keys[given];
                unit.in_payload = uint16_t(given);
            }
            unit.out_ready = random() % 8 >= head[2];
            unit.eval();
            if (unit.in_valid && unit.in_ready) {
                given++;
                offered = false;
            }
            if (unit.out_valid && unit.out_ready) {
                tell(0, unit.out_key, unit.out_payload, unit.out_part);
                left++;
            }
            tick();
            cycle++;
        }
        unit.in_valid = 0;
        cycle--;
        tell(1, 0, 0, 0);
        cycle++;
        if (left < keys.size()) return 1;
    }
    return 0;
}
