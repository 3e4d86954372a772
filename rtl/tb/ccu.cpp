// Feeds Gaussians to ccu.sv and tells what happens, all in 16-bit words. Reads a seed, stalls of the
// inputs and of the outputs (in eighths of cycles), the pause behind a mean (cycles), SH degree,
// columns and rows of tiles, 18 settings of two words each (low, high), and Gaussians of 71 words:
// mean (3 x 2), shape (8 x 2), whether it has coefficients, 48 coefficients. Writes nine words an
// event: kind, cycle (low, high), six words. Kind 0: a mean is taken; 1: a verdict (kept); 2: a shape
// is taken; 3: a splat leaves (5 numbers); 4: a pair leaves (splat, column, row, sub-tiles, u, v);
// 5: coefficients are taken; 6: a colour leaves (3 numbers). Ends when nothing has happened for long.
#include <cstdint>
#include <cstdio>
#include <random>
#include <type_traits>
#include <vector>

#include "Vccu.h"

namespace {

Vccu unit;
uint32_t cycle = 0;
uint32_t last_event = 0;

void tick() {
    unit.clk = 1;
    unit.eval();
    unit.clk = 0;
    unit.eval();
}

void tell(uint16_t kind, const std::vector<uint16_t> &words) {
    uint16_t event[9] = {kind, uint16_t(cycle), uint16_t(cycle >> 16)};
    for (size_t i = 0; i < words.size(); i++) event[3 + i] = words[i];
    std::fwrite(event, sizeof event, 1, stdout);
    last_event = cycle;
}

// Bit `at` of a port of any width.
template <typename Port>
bool bit(const Port &port, int at) {
    if constexpr (std::is_integral_v<Port>) {
        return uint64_t(port) >> at & 1u;
    } else {
        return port[at / 32] >> (at % 32) & 1u;
    }
}

template <typename Port>
void set_bit(Port &port, int at, bool value) {
    if constexpr (std::is_integral_v<Port>) {
        port = Port((uint64_t(port) & ~(1ull << at)) | uint64_t(value) << at);
    } else {
        port[at / 32] = (port[at / 32] & ~(1u << (at % 32))) | uint32_t(value) << (at % 32);
    }
}

// Number i of `width` bits.
template <typename Port>
void set(Port &port, int i, int width, uint32_t value) {
    for (int b = 0; b < width; b++) set_bit(port, i * width + b, value >> b & 1u);
}

template <typename Port>
std::vector<uint16_t> numbers(const Port &port, int count, int width) {
    std::vector<uint16_t> out(count);
    for (int i = 0; i < count; i++) {
        for (int b = 0; b < width; b++) out[i] |= uint16_t(bit(port, i * width + b)) << b;
    }
    return out;
}

uint32_t wide(const uint16_t *words) { return words[0] | uint32_t(words[1]) << 16; }

}  // namespace

int main() {
    const int W = EXP + MAN + 1, N = TO_EXP + TO_MAN + 1;
    uint16_t head[7], settings[36], words[71];
    if (std::fread(head, sizeof head, 1, stdin) != 1) return 1;
    if (std::fread(settings, sizeof settings, 1, stdin) != 1) return 1;
    std::vector<std::vector<uint16_t>> gaussians;
    while (std::fread(words, sizeof words, 1, stdin) == 1) {
        gaussians.emplace_back(words, words + 71);
    }
    std::mt19937 random(head[0]);
    for (int i = 0; i < 18; i++) set(unit.settings, i, W, wide(settings + 2 * i));
    unit.degree = head[4];
    unit.tiles_x = head[5];
    unit.tiles_y = head[6];
    unit.rst_n = 0;
    tick();
    tick();
    unit.rst_n = 1;
    size_t mean = 0, verdict = 0, shape = 0, colour = 0;
    std::vector<size_t> kept, coloured;
    for (size_t i = 0; i < gaussians.size(); i++) {
        if (gaussians[i][22]) coloured.push_back(i);
    }
    bool mean_offered = false, shape_offered = false, colour_offered = false;
    uint32_t pause = 0;
    auto comes = [&] { return random() % 8 >= head[1]; };
    auto goes = [&] { return random() % 8 >= head[2]; };
    while (cycle < last_event + 4000 + head[3]) {
        if (pause > 0) pause--;
        else if (!mean_offered) mean_offered = mean < gaussians.size() && comes();
        if (!shape_offered) shape_offered = shape < kept.size() && comes();
        if (!colour_offered) colour_offered = colour < coloured.size() && comes();
        unit.mean_valid = mean_offered;
        if (mean_offered) {
            for (int i = 0; i < 3; i++) set(unit.mean_data, i, W, wide(&gaussians[mean][2 * i]));
        }
        unit.shape_valid = shape_offered;
        if (shape_offered) {
            const auto &g = gaussians[kept[shape]];
            for (int i = 0; i < 8; i++) set(unit.shape_data, i, W, wide(&g[6 + 2 * i]));
        }
        unit.coefficients_valid = colour_offered;
        if (colour_offered) {
            const auto &g = gaussians[coloured[colour]];
            for (int i = 0; i < 48; i++) set(unit.coefficients_data, i, N, g[23 + i]);
        }
        unit.verdict_ready = goes();
        unit.splat_ready = goes();
        unit.pair_ready = goes();
        unit.colour_ready = goes();
        unit.eval();
        if (unit.mean_valid && unit.mean_ready) {
            tell(0, {});
            mean++;
            mean_offered = false;
            pause = head[3];
        }
        if (unit.verdict_valid && unit.verdict_ready) {
            tell(1, {unit.verdict_kept});
            if (unit.verdict_kept) kept.push_back(verdict);
            verdict++;
        }
        if (unit.shape_valid && unit.shape_ready) {
            tell(2, {});
            shape++;
            shape_offered = false;
        }
        if (unit.splat_valid && unit.splat_ready) tell(3, numbers(unit.splat_data, 5, N));
        if (unit.pair_valid && unit.pair_ready) {
            tell(4, {unit.pair_splat, unit.pair_x, unit.pair_y, unit.pair_subtiles,
                     uint16_t(unit.pair_u), uint16_t(unit.pair_v)});
        }
        if (unit.coefficients_valid && unit.coefficients_ready) {
            tell(5, {});
            colour++;
            colour_offered = false;
        }
        if (unit.colour_valid && unit.colour_ready) tell(6, numbers(unit.colour_data, 3, N));
        tick();
        cycle++;
    }
    return mean == gaussians.size() ? 0 : 1;
}
