"""A reader of traces, from docs/trace-format.md alone: complete traces into arrays. It checks the checksums, but not
the rules of section 2. Prints the frames of each file that is named."""
import struct, sys, zlib
import numpy as np
import zstandard

WORDS = {b"SIDX": "<u4", b"PSTP": "<u4", b"PBLD": "<u4", b"FST2": "<u4", b"FEXA": "<u4", b"FBL2": "<u4",
         b"SDEP": "<f4", b"SMNX": "<f4", b"SMNY": "<f4", b"SCVA": "<f4", b"SCVB": "<f4", b"SCVD": "<f4",
         b"SOPA": "<f4"}

def blocks(data, at, end):
    while at < end:
        tag, _, codec, transform, _, raw, stored, crc, head_crc = struct.unpack_from("<4sBBBBQQII", data, at)
        assert zlib.crc32(data[at:at + 28]) == head_crc, f"damaged header at byte {at}"
        content = data[at + 32:at + 32 + stored]
        assert zlib.crc32(content) == crc, f"damaged block at byte {at}"
        if codec == 1:
            reader = zstandard.ZstdDecompressor().stream_reader(content, read_across_frames=True)
            content = reader.read(raw)
        assert len(content) == raw
        yield tag, transform, content
        at += 32 + stored

def column(tag, transform, content):
    if tag not in WORDS:
        data = np.frombuffer(content, "u1").copy()
        if transform == 5:
            for channel in range(3):
                data[channel::3] = np.cumsum(data[channel::3], dtype="u1")
        return data
    if transform == 0:
        words = np.frombuffer(content, "<u4")
    else:
        words = np.ascontiguousarray(np.frombuffer(content, "u1").reshape(4, -1).T).view("<u4")[:, 0]
        if transform == 2:
            words = (words >> 1) | (words << 31)
        if transform == 4:
            words = (words >> 1) ^ (0 - (words & 1))
        if transform in (3, 4):
            words = np.cumsum(words, dtype="u4")
    return words.view(WORDS[tag])

def frames(path):
    data = open(path, "rb").read()
    assert data[:8] == b"\x89PGST\r\n\x1a" and data[-4:] == b"END\n", "no complete trace"
    foot, = struct.unpack_from("<Q", data, len(data) - 16)
    (_, _, index), = blocks(data, foot, len(data) - 16)
    for offset, length in struct.iter_unpack("<QQ", index):
        (_, _, facts), *rest = blocks(data, offset, offset + length)
        width, height = struct.unpack_from("<II", facts, 40)
        yield width, height, {tag.decode(): column(tag, t, c) for tag, t, c in rest}

for path in sys.argv[1:]:
    for number, (width, height, columns) in enumerate(frames(path)):
        sizes = {tag: len(values) for tag, values in columns.items()}
        print(path, number, f"{width}x{height}", sizes)
