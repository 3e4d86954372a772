// Reads (format, a, b) as three 16-bit words each until the end of its input, and writes sum,
// product and power of a, without and with a register inside, as six.
#include <cstdint>
#include <cstdio>

#include "Vfp_bench.h"

int main() {
    Vfp_bench unit;
    uint16_t in[3];
    while (std::fread(in, sizeof in, 1, stdin) == 1) {
        unit.index = in[0];
        unit.a = in[1];
        unit.b = in[2];
        unit.clk = 0;
        unit.eval();
        unit.clk = 1;
        unit.eval();
        const uint16_t out[6] = {unit.sum,       unit.product,       unit.power,
                                 unit.split_sum, unit.split_product, unit.split_power};
        if (std::fwrite(out, sizeof out, 1, stdout) != 1) return 1;
    }
    return 0;
}
