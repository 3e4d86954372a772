// Runs cores.sv on jobs from a file, with a memory behind two pipes: whoever started this program
// times it. All numbers are little-endian.
//
// Cvcores STIMULUS, of 32-bit words: a seed; shares of cycles, in eighths, in which requests and
// answers stall, and in which answers come in any order; columns of tiles; most cycles; numbers of
// jobs, of pivots (two words each), of bytes of lists, of records of 32 bytes, of tiles; then jobs
// (address, entries, tile, pivots), pivots, lists, records.
//
// In a cycle with requests, or with some under way, it writes the cycle, the number of requests and
// four words of each (port, 0 list 1 feature 2 pixels, address, bytes), and reads the number of
// those that are done by now and which, counted from 0. In the end it writes ~0, the cycles, whether
// it ended by itself, then for each core so many words: cycles of each of 9 counts; then the pixels
// of all tiles, 2,048 bytes each.
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <deque>
#include <memory>
#include <random>
#include <vector>

#include "Vcores.h"

namespace {

const int cores = CORES, counted = 9;
Vcores chip;

struct Request {
    int port;
    bool write;
    uint16_t tag;
    uint32_t address, bytes;
};

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
    if (!file) return 2;
    uint32_t head[11];
    if (std::fread(head, sizeof head, 1, file) != 1) return 2;
    const uint32_t seed = head[0], stall_ask = head[1], stall_come = head[2], any_order = head[3];
    const uint32_t most = head[5];
    std::vector<uint32_t> jobs(4 * size_t(head[6]));
    std::vector<uint64_t> pivots(head[7]);
    const uint32_t lists = (head[8] + 63) / 32 * 32, records = 32 * head[9], tiles = 2048 * head[10];
    // Lists, then records, then pixels; a read may go beyond the end.
    std::vector<uint8_t> memory(size_t(lists) + records + tiles + 64);
    if (std::fread(jobs.data(), 4, jobs.size(), file) != jobs.size()) return 2;
    if (std::fread(pivots.data(), 8, pivots.size(), file) != pivots.size()) return 2;
    if (std::fread(memory.data(), 1, head[8], file) != head[8]) return 2;
    if (std::fread(memory.data() + lists, 1, records, file) != records) return 2;
    std::fclose(file);

    std::mt19937 random(seed);
    chip.features = lists;
    chip.pixels = lists + records;
    chip.tiles_x = head[4];
    chip.rst_n = 0;
    chip.job_valid = 0;
    chip.pivot_valid = 0;
    chip.ask_ready = 0;
    chip.come_valid = 0;
    tick();
    tick();
    chip.rst_n = 1;

    std::vector<Request> asked;
    std::vector<std::deque<uint32_t>> done(cores);
    std::vector<std::deque<uint64_t>> given(cores);
    std::vector<uint64_t> counts(counted * cores);
    size_t job = 0, pivot = 0, open = 0;
    uint64_t cycle = 0;
    bool ended = false;
    // Cycles without a request, an answer or a job: more than any unit takes alone.
    uint32_t quiet = 0;
    for (; cycle < most; cycle++) {
        // What is done by now is there in this cycle.
        chip.job_valid = 4 * job < jobs.size();
        if (chip.job_valid) {
            chip.job_address = jobs[4 * job];
            chip.job_entries = jobs[4 * job + 1];
            chip.job_tile = jobs[4 * job + 2];
        }
        uint32_t valid = 0, ready = 0, keys = 0;
        for (int c = 0; c < cores; c++) {
            ready |= uint32_t(random() % 8 >= stall_ask) << c;
            keys |= uint32_t(!given[c].empty()) << c;
            if (!given[c].empty()) chip.pivot_key[c] = given[c].front();
            if (done[c].empty() || random() % 8 < stall_come) continue;
            if (done[c].size() > 1 && random() % 8 < any_order) {
                std::swap(done[c][0], done[c][random() % done[c].size()]);
            }
            const Request &r = asked[done[c].front()];
            valid |= 1u << c;
            chip.come_tag[c] = r.tag;
            if (!r.write) std::memcpy(chip.come_data[c].data(), &memory[r.address], 64);
        }
        chip.ask_ready = ready;
        chip.come_valid = valid;
        chip.pivot_valid = keys;
        chip.eval();
        if (chip.idle && 4 * job == jobs.size() && open == 0) {
            ended = true;
            break;
        }
        std::vector<uint32_t> now;
        if (++quiet > 1000000) break;
        for (int c = 0; c < cores; c++) {
            for (int k = 0; k < counted; k++) counts[counted * c + k] += chip.counts[c] >> k & 1;
            if (valid >> c & chip.come_ready >> c & 1) {
                done[c].pop_front();
                open--;
                quiet = 0;
            }
            if (keys >> c & chip.pivot_ready >> c & 1) given[c].pop_front();
            if (chip.job_taken >> c & 1) {
                for (uint32_t k = 0; k < jobs[4 * job + 3]; k++) given[c].push_back(pivots[pivot++]);
                job++;
                quiet = 0;
            }
            if (!(chip.ask_valid >> c & ready >> c & 1)) continue;
            const Request r = {c, bool(chip.ask_write >> c & 1), chip.ask_tag[c], chip.ask_address[c], chip.ask_bytes[c]};
            if (size_t(r.address) + r.bytes > memory.size()) return 3;
            if (r.write) std::memcpy(&memory[r.address], chip.ask_data[c].data(), 64);
            now.insert(now.end(), {uint32_t(c), r.write ? 2u : r.tag & 3u, r.address, r.bytes});
            asked.push_back(r);
            open++;
        }
        // What the next cycle begins with.
        if (open > 0) {
            put(uint32_t(cycle));
            put(uint32_t(now.size() / 4));
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
    put(ended);
    for (uint64_t n : counts) put(uint32_t(n));
    std::fwrite(&memory[lists + records], 1, tiles, stdout);
    std::fflush(stdout);
    return 0;
}
