"""Reads .pelagecache, the positions of simulated hair in every frame of a shot
(docs/bake_outputs.md describes the file). It needs Python's zstandard, which Blender has.
"""

import os
import struct

import numpy as np

from . import ExportError

_HEADER = struct.Struct("<8s6IdqfIQQQ")
_FRAME = struct.Struct("<IfII")
_CHUNK = np.dtype([("bytes", "<u4"), ("planes", "u1"), ("time", "u1"), ("space", "u1"),
                   ("reserved", "u1")])
_ENTRY = np.dtype([("offset", "<u8"), ("checksum", "<u8"), ("bytes", "<u4"), ("from_key", "<u4")])
_FOOTER = struct.Struct("<QQQ8s")
_CHUNK_VERTICES = 8192
_MAX_VERTICES = 1 << 28


def _zstd():
    try:
        import zstandard
    except ImportError:
        raise ExportError("reading a .pelagecache takes Python's zstandard "
                          "(Debian: python3-zstandard)") from None
    return zstandard


def _decompress(data, size):
    """The contents of zstd frames that follow each other, of `size` bytes in all."""
    zstandard = _zstd()
    parts, left = [], size
    while data and left > 0:
        decompressor = zstandard.ZstdDecompressor().decompressobj()
        try:
            parts.append(decompressor.decompress(data))
        except zstandard.ZstdError as error:
            raise ExportError("a chunk cannot be decoded: %s" % error) from None
        left -= len(parts[-1])
        data = decompressor.unused_data
    if data or left != 0:
        raise ExportError("a chunk does not have the size of its vertices")
    return b"".join(parts)


class _Chunk:
    """Strands that are coded together."""

    def __init__(self, counts):
        self.vertices = int(counts.sum())
        self._even = bool((counts == counts[0]).all())
        self._mask = np.arange(counts.max())[None, :] < counts[:, None]

    def add_prediction(self, residuals, order):
        """Values of the residuals [vertex, 3] of a space order, modulo 2^32."""
        if order == 0:
            return residuals
        grid = np.zeros(self._mask.shape + (3,), np.uint32)
        grid[self._mask] = residuals
        roots = np.cumsum(grid[:, 0], axis=0, dtype=np.uint32)
        edges = grid[:, 1:]
        if order == 2:
            edges = np.cumsum(edges, axis=1, dtype=np.uint32)
        elif order == 3 and self._even:
            edges = np.cumsum(edges, axis=0, dtype=np.uint32)
        elif order == 3:
            for strand in range(1, len(edges)):
                edges[strand] += np.where(self._mask[strand - 1, 1:, None], edges[strand - 1], 0)
        both = np.concatenate((roots[:, None], edges), axis=1)
        return np.cumsum(both, axis=1, dtype=np.uint32)[self._mask]


class HairCache:
    """A file. Its checksums are not tested; what does not fit together is an ExportError."""

    def __init__(self, path):
        self.path = path
        try:
            self._file = open(path, "rb")
        except OSError as error:
            raise ExportError("%s: %s" % (path, error.strerror)) from None
        try:
            self._read_header()
            self._read_index()
        except (struct.error, ValueError):
            raise ExportError("%s: the file is incomplete" % path) from None
        self._frame, self._last, self._values = -1, None, None

    def _read_header(self):
        (magic, version, order, strands, per_strand, key_interval, name_length, self.fps,
         self.first_frame, self.error_bound, has_ids, _, _, _) = _HEADER.unpack(
             self._file.read(_HEADER.size))
        if magic != b"PELHAI\r\n" or order != 0x0A0B0C0D or version != 1:
            raise ExportError("%s is no .pelagecache of version 1" % self.path)
        self._size = os.path.getsize(self.path)
        if has_ids > 1 or strands < 1 or name_length > 4095 or not 1 <= key_interval <= 256:
            raise ExportError("%s: the header is broken" % self.path)
        if strands > _MAX_VERTICES or strands * per_strand > _MAX_VERTICES:
            raise ExportError("%s: too many vertices" % self.path)
        if (8 * has_ids + (0 if per_strand else 4)) * strands > self._size:
            raise ExportError("%s: the file is incomplete" % self.path)
        self.ids = np.frombuffer(self._file.read(8 * strands * has_ids), "<u8")
        if per_strand:
            self.counts = np.full(strands, per_strand)
        else:
            self.counts = np.frombuffer(self._file.read(4 * strands), "<u4").astype(np.int64)
        self.name = self._file.read(name_length).decode("utf-8", "replace")
        if len(self.counts) != strands or self.counts.min() < 1 or self.counts.max() > 256:
            raise ExportError("%s: a strand has 1 to 256 vertices" % self.path)
        self.vertex_count = int(self.counts.sum())
        self._chunks = list(self._make_chunks())

    def _make_chunks(self):
        begin, vertices = 0, 0
        for strand, count in enumerate(self.counts):
            vertices += count
            if vertices >= _CHUNK_VERTICES or strand + 1 == len(self.counts):
                yield _Chunk(self.counts[begin:strand + 1])
                begin, vertices = strand + 1, 0

    def _read_index(self):
        self._file.seek(-_FOOTER.size, os.SEEK_END)
        index_at, count, _, magic = _FOOTER.unpack(self._file.read(_FOOTER.size))
        if magic != b"\r\nPELEND" or index_at + count * _ENTRY.itemsize + _FOOTER.size != self._size:
            raise ExportError("%s does not end with an index; was it closed?" % self.path)
        self._file.seek(index_at)
        self._index = np.frombuffer(self._file.read(count * _ENTRY.itemsize), _ENTRY)
        self.frame_count = len(self._index)

    def read(self, frame):
        """The positions of a frame, 0..frame_count - 1: float32 [vertex, 3] in meters, y up."""
        if not 0 <= frame < self.frame_count:
            raise ExportError("%s: there is no frame %d" % (self.path, frame))
        key = frame - int(self._index[frame]["from_key"])
        begin = self._frame + 1 if key <= self._frame <= frame else key
        for index in range(begin, frame + 1):
            self._decode(index)
        if self._step > 0:
            return self._values.view(np.int32).astype(np.float32) * np.float32(self._step)
        # The order of the numbers as integers, back to the bits of floats.
        signs = (self._values.view(np.int32) >> 31).view(np.uint32) >> 1
        return (self._values ^ signs).view(np.float32)

    def _decode(self, frame):
        self._frame, entry = -1, self._index[frame]
        self._file.seek(int(entry["offset"]))
        record = self._file.read(int(entry["bytes"]))
        try:
            is_key, self._step, chunk_count, _ = _FRAME.unpack_from(record)
            if is_key != (entry["from_key"] == 0) or chunk_count != len(self._chunks):
                raise ExportError("frame %d is not that of this file" % frame)
            chunks = np.frombuffer(record, _CHUNK, chunk_count, _FRAME.size)
        except (struct.error, ValueError):
            raise ExportError("frame %d is incomplete" % frame) from None
        values = np.empty((self.vertex_count, 3), np.uint32)
        at, first = _FRAME.size + chunks.nbytes, 0
        for chunk, head in zip(self._chunks, chunks):
            part = slice(first, first + chunk.vertices)
            values[part] = self._decode_chunk(chunk, head, record[at:at + int(head["bytes"])], part)
            at, first = at + int(head["bytes"]), part.stop
        self._last, self._values, self._frame = self._values, values, frame

    def _decode_chunk(self, chunk, head, data, part):
        count, planes = 3 * chunk.vertices, int(head["planes"])
        if planes > 4 or head["space"] > 3 or head["time"] > 2:
            raise ExportError("a prediction that there is not")
        raw = np.frombuffer(_decompress(data, planes * count), np.uint8).reshape(planes, count)
        zigzag = np.zeros(count, np.uint32)
        for plane in range(planes):
            zigzag |= raw[plane].astype(np.uint32) << np.uint32(8 * plane)
        residuals = (zigzag >> 1) ^ (np.uint32(0) - (zigzag & 1))
        values = chunk.add_prediction(residuals.reshape(-1, 3), int(head["space"]))
        if head["time"] > 0:
            values = values + self._values[part]
        if head["time"] > 1:
            values += self._values[part] - self._last[part]
        return values
