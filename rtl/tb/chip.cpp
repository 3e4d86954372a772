// Runs chip.sv on a scene, or its cores on lists, with a memory behind two pipes: whoever started
// this program times it. All numbers are little-endian.
//
// Vchip STIMULUS, of 32-bit words: a seed; shares of cycles, in eighths, in which requests and
// answers stall, and in which answers come in any order; most cycles; columns and rows of tiles;
// columns and rows of pixels; numbers of Gaussians and degree of their colours; numbers of jobs, of
// pivots (two words each), of bytes of lists, of records of 32 bytes; addresses of lists, records,
// pixels and what is spilled, and bytes in all; the settings of the view (18); then jobs (address, entries, tile, pivots), pivots; then means, shapes and coefficients of 9, 24
// and 96 bytes, or, for cores alone, lists and records. A chip takes the pivots of the jobs only.
//
// In a cycle with requests, or with some under way, it writes the cycle, the number of requests and
// three words of each (what for, and its port from bit 8 on; address; bytes), and reads the number of
// those that are done by now and which, counted from 0. What for: 0 lists, 1 features, 2 pixels; 3 means, 4 shapes, 5
// coefficients, 6 results, 7 spilled, 8 read back. In the end it writes ~0, the cycles, those until all lists were written,
// whether it ended by itself, then for each core so many words: cycles of each of 9 counts; then
// the pixels of all tiles, 2,048 bytes each.
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <deque>
#include <random>
#include <vector>

#include "Vchip.h"

namespace {

const int cores = CORES, ports = ONE_PORT ? 1 : CORES + FRONTS;
const int counted = 9;
Vchip chip;

struct Request {
    int port;
    bool write;
    uint32_t tag, address, bytes;
};

// Word i of a port of any width.
uint32_t get(IData w, int) { return w; }
uint32_t get(QData w, int i) { return uint32_t(w >> (32 * i)); }
template <std::size_t N>
uint32_t get(const VlWide<N> &w, int i) { return w[i]; }
void set(IData &w, int, uint32_t v) { w = v; }
void set(QData &w, int i, uint32_t v) { w = (w & ~(QData(~0u) << (32 * i))) | QData(v) << (32 * i); }
template <std::size_t N>
void set(VlWide<N> &w, int i, uint32_t v) { w[i] = v; }

uint32_t word() {
    uint32_t w = 0;
    if (std::fread(&w, 4, 1, stdin) != 1) std::exit(2);
    return w;
}

void put(uint32_t w) { std::fwrite(&w, 4, 1, stdout); }

void tick() {
    chip.clk = 1;
    chip.eval();
    chip.clk = 0;
    chip.eval();
}

}  // namespace

int main(int argc, char **argv) {
    std::FILE *file = argc == 2 ? std::fopen(argv[1], "rb") : nullptr;
    uint32_t head[20], settings[18];
    if (!file || std::fread(head, sizeof head, 1, file) != 1) return 2;
    if (std::fread(settings, sizeof settings, 1, file) != 1) return 2;
    const uint32_t stall_ask = head[1], stall_come = head[2], any_order = head[3], most = head[4];
    const uint32_t tiles = head[5] * head[6], gaussians = head[9];
    std::vector<uint32_t> jobs(4 * size_t(head[11]));
    std::vector<uint64_t> pivots(head[12]);
    if (std::fread(jobs.data(), 4, jobs.size(), file) != jobs.size()) return 2;
    if (std::fread(pivots.data(), 8, pivots.size(), file) != pivots.size()) return 2;
    const size_t given = FRONTS ? size_t(129) * gaussians : 0;
    const uint32_t lists = head[15], features = head[16], pixels = head[17];
    std::vector<uint8_t> memory(head[19]);
    if (std::fread(memory.data(), 1, given, file) != given) return 2;
    if (!FRONTS && std::fread(&memory[lists], 1, head[13], file) != head[13]) return 2;
    if (!FRONTS && std::fread(&memory[features], 32, head[14], file) != head[14]) return 2;
    std::fclose(file);

    std::mt19937 random(head[0]);
    chip.tiles_x = head[5];
    chip.tiles_y = head[6];
    chip.width = head[7];
    chip.height = head[8];
    chip.gaussians = gaussians;
    chip.degree = head[10];
    chip.means = 0;
    chip.shapes = 9 * gaussians;
    chip.coefficients = 33 * gaussians;
    chip.lists = lists;
    chip.features = features;
    chip.pixels = pixels;
    chip.spill = head[18];
    for (int i = 0; i < 18 * 24; i++) {
        const uint32_t bit = settings[i / 24] >> (i % 24) & 1;
        chip.settings[i / 32] = (chip.settings[i / 32] & ~(1u << (i % 32))) | bit << (i % 32);
    }
    chip.go = 0;
    chip.rst_n = 0;
    chip.job_valid = 0;
    chip.pivot_valid = 0;
    chip.ask_ready = 0;
    chip.come_valid = 0;
    tick();
    tick();
    chip.rst_n = 1;
    chip.go = 1;

    std::vector<Request> asked;
    std::vector<std::deque<uint32_t>> done(ports);
    std::vector<std::deque<uint64_t>> keys(cores);
    std::vector<uint64_t> counts(counted * cores);
    size_t job = 0, pivot = 0, open = 0;
    uint64_t cycle = 0, listed = 0;
    bool ended = false;
    // Cycles without a request, an answer or a job: more than any unit takes alone.
    uint32_t quiet = 0;
    for (; cycle < most; cycle++) {
        chip.job_valid = 4 * job < jobs.size();
        if (chip.job_valid) {
            chip.job_address = lists + jobs[4 * job];
            chip.job_entries = jobs[4 * job + 1];
            chip.job_tile = jobs[4 * job + 2];
        }
        // What is done by now is there in this cycle.
        uint32_t valid = 0, ready = 0, offered = 0;
        for (int p = 0; p < ports; p++) {
            ready |= uint32_t(random() % 8 >= stall_ask) << p;
            if (done[p].empty() || random() % 8 < stall_come) continue;
            if (done[p].size() > 1 && random() % 8 < any_order) {
                std::swap(done[p][0], done[p][random() % done[p].size()]);
            }
            const Request &r = asked[done[p].front()];
            valid |= 1u << p;
            set(chip.come_tag, p, r.tag);
            if (!r.write) std::memcpy(&chip.come_data[16 * p], &memory[r.address], 64);
        }
        for (int c = 0; c < cores; c++) {
            if (keys[c].empty()) continue;
            offered |= 1u << c;
            set(chip.pivot_key, 2 * c, uint32_t(keys[c].front()));
            set(chip.pivot_key, 2 * c + 1, uint32_t(keys[c].front() >> 32));
        }
        chip.ask_ready = ready;
        chip.come_valid = valid;
        chip.pivot_valid = offered;
        chip.eval();
        if (!chip.is_listed) listed = cycle + 1;
        if (chip.idle && 4 * job == jobs.size() && open == 0) {
            ended = true;
            break;
        }
        if (++quiet > 1000000) break;
        std::vector<uint32_t> now;
        for (int p = 0; p < ports; p++) {
            if (valid >> p & chip.come_ready >> p & 1) {
                done[p].pop_front();
                open--;
                quiet = 0;
            }
            if (!(chip.ask_valid >> p & ready >> p & 1)) continue;
            const Request r = {p, bool(chip.ask_write >> p & 1), get(chip.ask_tag, p),
                               get(chip.ask_address, p), get(chip.ask_bytes, p)};
            if (size_t(r.address) + r.bytes > memory.size() || r.bytes > 64) return 3;
            if (r.write) std::memcpy(&memory[r.address], &chip.ask_data[16 * p], r.bytes);
            // An arbiter says in the tag whose it is.
            const int whose = ONE_PORT ? int(r.tag >> 16) : p;
            const uint32_t of_core = (r.tag & 3) < 3 ? r.tag & 3 : r.write ? 7 : 8;
            const uint32_t what = whose < cores ? of_core : (r.write ? 6 : 3 + (r.tag & 7));
            now.insert(now.end(), {what | uint32_t(whose) << 8, r.address, r.bytes});
            asked.push_back(r);
            open++;
        }
        for (int c = 0; c < cores; c++) {
            for (int k = 0; k < counted; k++) counts[counted * c + k] += get(chip.counts, c) >> k & 1;
            if (offered >> c & chip.pivot_ready >> c & 1) keys[c].pop_front();
            if (!(chip.taken >> c & 1)) continue;
            for (uint32_t k = 0; k < jobs[4 * job + 3]; k++) keys[c].push_back(pivots[pivot++]);
            job++;
            quiet = 0;
        }
        // What the next cycle begins with.
        if (open > 0) {
            put(uint32_t(cycle));
            put(uint32_t(now.size() / 3));
            std::fwrite(now.data(), 4, now.size(), stdout);
            std::fflush(stdout);
            for (uint32_t n = word(); n > 0; n--) {
                const uint32_t id = word();
                if (id >= asked.size()) return 4;
                done[asked[id].port].push_back(id);
            }
        }
        tick();
    }
    put(~0u);
    put(uint32_t(cycle));
    put(uint32_t(listed));
    put(ended);
    for (uint64_t n : counts) put(uint32_t(n));
    std::fwrite(&memory[pixels], 1, 2048 * size_t(tiles), stdout);
    std::fflush(stdout);
    return 0;
}
