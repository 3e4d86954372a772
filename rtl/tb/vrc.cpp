// Feeds beats to vrc.sv and tells what happens, all in 16-bit words. Reads a seed, stalls of the
// input and of the output (in eighths of cycles), and beats of 13 words each: op, nine numbers of
// the record, mask, x, y. Writes seven words an event: kind, cycle (low, high), four words. Kind 0:
// a pixel leaves (red, green, blue, transmittance); 1: a beat is accepted; 2: all pixels have
// stopped.
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include "Vvrc.h"

namespace {

Vvrc unit;
uint32_t cycle = 0;

void tick() {
    unit.clk = 1;
    unit.eval();
    unit.clk = 0;
    unit.eval();
}

void tell(uint16_t kind, const uint16_t *words) {
    uint16_t event[7] = {kind, uint16_t(cycle), uint16_t(cycle >> 16), 0, 0, 0, 0};
    for (int i = 0; words && i < 4; i++) event[3 + i] = words[i];
    std::fwrite(event, sizeof event, 1, stdout);
}

// Sets number i of `width` bits in words of 32.
template <typename Words>
void set(Words &words, int i, int width, uint16_t value) {
    for (int b = 0; b < width; b++) {
        const int at = i * width + b;
        words[at / 32] &= ~(1u << (at % 32));
        words[at / 32] |= uint32_t(value >> b & 1u) << (at % 32);
    }
}

}  // namespace

int main() {
    uint16_t head[3], beat[13];
    if (std::fread(head, sizeof head, 1, stdin) != 1) return 1;
    std::vector<std::vector<uint16_t>> beats;
    while (std::fread(beat, sizeof beat, 1, stdin) == 1) beats.emplace_back(beat, beat + 13);
    std::mt19937 random(head[0]);
    const int width = EXP + MAN + 1;
    size_t next = 0, closes = 0, closed = 0;
    for (const auto &b : beats) closes += b[0] == 2;
    int left = 0;
    bool offered = false, was_stopped = false;
    unit.rst_n = 0;
    tick();
    tick();
    unit.rst_n = 1;
    const uint32_t limit = 4000 + 64 * 40 * uint32_t(beats.size());
    while ((next < beats.size() || closed < closes) && cycle < limit) {
        if (!offered) offered = next < beats.size() && random() % 8 >= head[1];
        unit.in_valid = offered;
        if (offered) {
            const auto &b = beats[next];
            unit.in_op = b[0];
            for (int i = 0; i < 9; i++) set(unit.in_record, i, width, b[1 + i]);
            unit.open_mask = b[10];
            unit.open_x = b[11];
            unit.open_y = b[12];
        }
        unit.out_ready = random() % 8 >= head[2];
        unit.eval();
        if (unit.stopped && !was_stopped) tell(2, nullptr);
        was_stopped = unit.stopped;
        if (unit.in_valid && unit.in_ready) {
            tell(1, nullptr);
            next++;
            offered = false;
        }
        if (unit.out_valid && unit.out_ready) {
            uint16_t pixel[4];
            for (int i = 0; i < 4; i++) {
                pixel[i] = uint64_t(unit.out_pixel) >> (i * width) & ((1u << width) - 1);
            }
            tell(0, pixel);
            if (++left == PIXELS) {
                left = 0;
                closed++;
            }
        }
        tick();
        cycle++;
    }
    return cycle < limit ? 0 : 1;
}
