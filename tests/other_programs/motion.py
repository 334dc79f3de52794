"""Writes motion.toile into the folder of a fit, by docs/formats.md alone: an independent writer of the format."""

import hashlib
import os
import struct
import sys
import zlib

from truth import FRAMES, RATE, Truth

fit = sys.argv[1]
truth = Truth(os.path.dirname(os.path.abspath(fit)))
with open(os.path.join(fit, "state.toile"), "rb") as file:
    digest = hashlib.sha256(file.read()).digest()
header = b"TOILEM\r\n" + struct.pack("<IIQd", 1, 8, len(truth.positions), RATE) + digest
with open(os.path.join(fit, "motion.toile"), "wb") as file:
    file.write(header + struct.pack("<I", zlib.crc32(header)))
    for k in range(FRAMES):
        record = struct.pack("<Q", k) + truth.frame(k).astype("<f8").tobytes()
        file.write(record + struct.pack("<I", zlib.crc32(record)))
    # A run that was killed: the next frame had only begun.
    file.write(b"\0" * 100)
