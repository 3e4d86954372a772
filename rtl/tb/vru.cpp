// Feeds beats to vru.sv and tells what happens, all in 16-bit words. Reads a seed, stalls of the
// input and of the output (in eighths of cycles), and beats of 13 words each: op, nine numbers of
// the record, bitmap, width, height. Writes 67 words an event: kind, cycle (low, high), 64 words.
// Kind 0: a pixel of each core leaves (red, green, blue, transmittance); 1: a beat is accepted.
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include "Vvru.h"

namespace {

const int width = EXP + MAN + 1;
Vvru unit;
uint32_t cycle = 0;

void tick() {
    unit.clk = 1;
    unit.eval();
    unit.clk = 0;
    unit.eval();
}

void tell(uint16_t kind) {
    uint16_t event[67] = {kind, uint16_t(cycle), uint16_t(cycle >> 16)};
    for (int i = 0; kind == 0 && i < 64; i++) {
        for (int b = 0; b < width; b++) {
            const int at = i * width + b;
            event[3 + i] |= uint16_t((unit.out_pixels[at / 32] >> (at % 32) & 1u) << b);
        }
    }
    std::fwrite(event, sizeof event, 1, stdout);
}

void set_record(int i, uint16_t value) {
    for (int b = 0; b < width; b++) {
        const int at = i * width + b;
        unit.in_record[at / 32] &= ~(1u << (at % 32));
        unit.in_record[at / 32] |= uint32_t(value >> b & 1u) << (at % 32);
    }
}

}  // namespace

int main() {
    uint16_t head[3], beat[13];
    if (std::fread(head, sizeof head, 1, stdin) != 1) return 1;
    std::vector<std::vector<uint16_t>> beats;
    while (std::fread(beat, sizeof beat, 1, stdin) == 1) beats.emplace_back(beat, beat + 13);
    std::mt19937 random(head[0]);
    size_t next = 0, expected = 0, left = 0;
    for (const auto &b : beats) expected += b[0] == 2 ? 16 : 0;
    bool offered = false;
    unit.rst_n = 0;
    tick();
    tick();
    unit.rst_n = 1;
    const uint32_t limit = 4000 + 64 * 40 * uint32_t(beats.size());
    while ((next < beats.size() || left < expected) && cycle < limit) {
        if (!offered) offered = next < beats.size() && random() % 8 >= head[1];
        unit.in_valid = offered;
        if (offered) {
            const auto &b = beats[next];
            unit.in_op = b[0];
            for (int i = 0; i < 9; i++) set_record(i, b[1 + i]);
            unit.in_bitmap = b[10];
            unit.open_width = b[11];
            unit.open_height = b[12];
        }
        unit.out_ready = random() % 8 >= head[2];
        unit.eval();
        if (unit.in_valid && unit.in_ready) {
            tell(1);
            next++;
            offered = false;
        }
        if (unit.out_valid && unit.out_ready) {
            tell(0);
            left++;
        }
        tick();
        cycle++;
    }
    return cycle < limit ? 0 : 1;
}
