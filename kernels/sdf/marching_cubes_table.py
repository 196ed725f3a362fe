#!/usr/bin/env python3
"""Writes marching_cubes_table.hlsli: python3 marching_cubes_table.py > marching_cubes_table.hlsli

Goes around the six faces of a cell, counter-clockwise as seen from outside, and notes for every
edge what comes after it on the face where a run of inside corners begins at that edge. Checks for
all 256 cases what marching_cubes_cell.hlsli relies on.
"""

# Corner c is at (c & 1, c >> 1 & 1, c >> 2). Edge 4 a + k runs along axis a; the bits of k are the
# coordinates of its start on the other two axes, the lower axis first.
OTHERS = {0: (1, 2), 1: (0, 2), 2: (0, 1)}


def corner(position):
    return position[0] | position[1] << 1 | position[2] << 2


def edge_between(a, b):
    axis = (a ^ b).bit_length() - 1
    low, high = OTHERS[axis]
    return 4 * axis + ((a >> low & 1) | (a >> high & 1) << 1)


def make_faces():
    """The corners of the six faces, counter-clockwise as seen from outside."""
    faces = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3  # u x v = axis
        for side in (0, 1):
            ring = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                position = [0, 0, 0]
                position[axis], position[u], position[v] = side, a, b
                ring.append(corner(position))
            faces.append(ring if side else ring[::-1])
    return faces


FACES = make_faces()
FACE_EDGES = [{edge_between(f[i], f[(i + 1) % 4]) for i in range(4)} for f in FACES]


def make_table():
    """[edge][which end is inside]: the three edges and two corners after the inside one."""
    table = [[None, None] for _ in range(12)]
    for ring in FACES:
        for i in range(4):
            before, first, second, third = (ring[(i + k) % 4] for k in range(-1, 3))
            ends = (edge_between(first, second), edge_between(second, third),
                    edge_between(third, before))
            start_inside = int(first < before)
            edge = edge_between(before, first)
            assert table[edge][start_inside] is None
            table[edge][start_inside] = (ends, (second, third))
    return table


TABLE = make_table()


def following(edge, case):
    axis, k = divmod(edge, 4)
    low, high = OTHERS[axis]
    start = (k & 1) << low | (k >> 1) << high
    ends, corners = TABLE[edge][case >> start & 1]
    for end, after in zip(ends, corners):
        if not case >> after & 1:
            return end
    return ends[2]


def check(case):
    left = {
        edge_between(c, c | 1 << axis)
        for c in range(8)
        for axis in range(3)
        if not c >> axis & 1 and (case >> c ^ case >> (c | 1 << axis)) & 1
    }
    triangles = 0
    while left:
        loop = [min(left)]
        while following(loop[-1], case) != loop[0]:
            loop.append(following(loop[-1], case))
        assert len(loop) == len(set(loop)) and left.issuperset(loop)
        left -= set(loop)
        triangles += len(loop) - 2
        assert len(loop) <= 8
        assert any(is_fan_sound(loop[i:] + loop[:i]) for i in range(len(loop)))
    assert triangles <= 5


def is_fan_sound(loop):
    """No diagonal from the first edge lies in a face."""
    return not any({loop[0], other} <= face for other in loop[2:-1] for face in FACE_EDGES)


def main():
    for case in range(256):
        check(case)
    print("// Made by marching_cubes_table.py, which says how.")
    print("#ifndef PELAGE_SDF_MARCHING_CUBES_TABLE_HLSLI")
    print("#define PELAGE_SDF_MARCHING_CUBES_TABLE_HLSLI")
    print()
    print("// [2 e + s], s = 1 when the start of edge e is inside and its end is not, 0 the other way")
    print("// around: what follows on the face on which e leads inside. Bits 0 - 11 the three edges,")
    print("// 12 - 17 the two corners between them.")
    print("static const uint kAfterEdge[24] = {")
    words = [
        ends[0] | ends[1] << 4 | ends[2] << 8 | corners[0] << 12 | corners[1] << 15
        for pair in TABLE
        for ends, corners in pair
    ]
    for row in range(0, 24, 8):
        comma = "," if row < 16 else ""
        print("    " + ", ".join("0x%05xu" % word for word in words[row : row + 8]) + comma)
    print("};")
    print()
    print("#endif")


if __name__ == "__main__":
    main()
