"""Writes files that were made to do harm, and prints the commands that must refuse them.

    python hostile.py FOLDER

FOLDER must hold table.h5, a table of rays. Each line of output is one case, with tabs between its
parts: the name of the case, the program, its arguments, and last the text that the refusal must
contain.
"""

import hashlib
import os
import shutil
import struct
import sys
import zlib

import h5py
import numpy as np

FOUND = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../fuzz/found")
os.chdir(sys.argv[1])
TABLE = "table.h5"  # baked from rays


def case(name, command, says):
    print("\t".join([name, *command, says]))


def written(name, content):
    with open(name, "wb") as file:
        file.write(content)
    return name


def zeros(count):
    """Returns a zlib stream of `count` zeros, made of equal blocks.

    The checksum needs no computation: the Adler-32 of n zeros has a closed form.
    """

    def block(length):
        packer = zlib.compressobj(9, zlib.DEFLATED, -15)
        return packer.compress(bytes(length)) + packer.flush(zlib.Z_FULL_FLUSH)

    adler = struct.pack(">HH", count % 65521, 1)
    return (
        b"\x78\xda"
        + block(1 << 20) * (count >> 20)
        + block(count % (1 << 20))
        + b"\x03\x00"
        + adler
    )


# ---- Tables. Each is changed with h5py and gets a new seal, because an attacker can compute a
# SHA-256 too.


def table(name, says, change, base=TABLE):
    path = name.replace(" ", "_") + ".h5"
    shutil.copyfile(base, path)
    with h5py.File(path, "r+", libver="latest") as file:
        change(file)
    with open(path, "rb") as file:
        content = file.read()
    assert b"AIRRSEAL" not in content[-40:]
    with open(path, "ab") as file:
        file.write(b"AIRRSEAL" + hashlib.sha256(content).digest())
    case(name, ["bake", "inspect", path], says)


def claims(name, shape, chunk):
    def change(file):
        del file[name]
        file.create_dataset(name, shape, "f8", chunks=chunk)

    return change


def attribute(name, value):
    def change(file):
        file.attrs[name] = value

    return change


def link(name, to):
    def change(file):
        del file[name]
        file[name] = to

    return change


def bomb_in_a_chunk(file):
    """Writes a chunk that has 8 MiB by its shape, 4 MiB in the file, and 4 GiB if inflated."""
    del file["histogram"]
    data = file.create_dataset(
        "histogram",
        (2, 1, 16, 16),
        "f8",
        chunks=(1, 1, 1024, 1024),
        maxshape=(None,) * 4,
        compression=4,
    )
    stream = zeros(1 << 32)
    data.id.write_direct_chunk((0, 0, 0, 0), stream)


def consistent_bomb(file):
    """Writes 2 x 1 x 4000 x 4000 bins of zeros with consistent shapes: 256 MB in 256 kB."""
    bins = 4000
    for name in ("shift_u", "shift_v"):
        del file[name]
        width = 2 * file.attrs["shift_range"] / bins
        file[name] = -file.attrs["shift_range"] + (np.arange(bins) + 0.5) * width
    del file["histogram"]
    data = file.create_dataset(
        "histogram", (2, 1, bins, bins), "f8", chunks=(1, 1, bins, bins), compression=9
    )
    for incidence in range(2):
        data.id.write_direct_chunk((incidence, 0, 0, 0), zeros(8 * bins * bins))


def elsewhere(file):
    del file["rays"]
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_external(b"/etc/passwd", 0, 16)
    h5py.h5d.create(file.id, b"rays", h5py.h5t.STD_U64LE, h5py.h5s.create_simple((2, 1)), plist)


def view(file):
    del file["rays"]
    layout = h5py.VirtualLayout((2, 1), "u8")
    layout[:] = h5py.VirtualSource("other.h5", "rays", (2, 1))
    file.create_virtual_dataset("rays", layout)


def other_filter(file):
    del file["rays"]
    file.create_dataset("rays", data=np.zeros((2, 1), "u8"), chunks=(2, 1), compression="lzf")


def group_in_itself(file):
    file["exact"] = file["/"]


def many_attributes(file):
    for k in range(20000):
        file.attrs[f"a{k}"] = k


def fixed_text(file):
    file.attrs.create("design", np.bytes_(b"x" * 60000))


table("10^12 bins", "claims 8000000000000 bytes", claims("shift_u", (10**12,), (1 << 20,)))
table(
    "2^40 directions", "claims 8796093022208 bytes", claims("incidence_deg", (1 << 40,), (1 << 20,))
)
table(
    "a huge histogram",
    "dataset histogram claims",
    claims("histogram", (2, 1, 10**6, 10**6), (1, 1, 64, 64)),
)
table("a chunk that inflates without end", "", bomb_in_a_chunk)
table("zeros in agreement", "as a decompression bomb does", consistent_bomb)
table("data in another file", "stored in another file", elsewhere)
table("a view of another file", "as a view of other datasets", view)
table("an unknown filter", "through a filter other than", other_filter)
table(
    "a link out of the file",
    "dataset rays is missing",
    link("rays", h5py.ExternalLink("table.h5", "/rays")),
)
table("a link to itself", "dataset rays is missing", link("rays", h5py.SoftLink("/rays")))
table("a group in itself", "dataset exact/", group_in_itself)
table("version in words", "attribute version is", attribute("version", "one"))
table("a million versions", "attribute version is", attribute("version", np.ones(8000, "i8")))
table("range NaN", "shift_range is NaN", attribute("shift_range", float("nan")))
table("edge length infinite", "edge_length is inf", attribute("edge_length", float("inf")))
table("a long fixed text", "attribute design is", fixed_text)
table(
    "twenty thousand attributes",
    "attribute content_hash",
    lambda file: (many_attributes(file), attribute("seed", np.uint64(99))(file)),
)


def not_utf8(name, kind):
    def change(file):
        file.attrs.create(name, b"caf\xe9", dtype=kind)

    return change


# Every text attribute: of variable length, which the library calls UTF-8, and of fixed length.
for name in (
    "format",
    "generator",
    "design",
    "mesh_hash",
    "edge_length_unit",
    "back",
    "losses",
    "method",
    "sampler",
    "options",
    "content_hash",
):
    for kind in (h5py.string_dtype(), h5py.string_dtype(length=4), np.dtype("S4")):
        title = f"{name} in Latin-1 {'of 4 bytes' if kind.itemsize == 4 else ''}{kind.kind}"
        table(title, f"attribute {name} is not UTF-8", not_utf8(name, kind))


def fates_in_latin_1(file):
    names = list(file["fate_name"])
    del file["fate_name"]
    names[3] = b"caf\xe9"
    file.create_dataset("fate_name", data=names, dtype=h5py.string_dtype())


table("fates in Latin-1", "dataset fate_name is", fates_in_latin_1)


def many_directions(file):
    for name, end in ("incidence_deg", 89.0), ("azimuth_deg", 359.0):
        del file[name]
        file.create_dataset(name, data=np.linspace(0, end, 1000), compression=9)


def polygons(paths, corners, size=1e-3):
    """Returns a function that adds equal regular polygons, all of the first direction."""

    def change(file):
        group = file.create_group("exact")
        group.attrs["entrance_area"] = 1.0
        turns = 2 * np.pi * np.arange(corners) / corners
        ring = size * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        arrays = {
            "path_direction": np.zeros(paths, "u8"),
            "path_matrix": np.broadcast_to(-2.0 * np.eye(2), (paths, 2, 2)),
            "path_offset": np.zeros((paths, 2)),
            "path_weight": np.ones(paths),
            "polygon_start": np.arange(0, corners * paths + 1, corners, "u8"),
            "polygon_vertex": np.tile(ring, (paths, 1)),
        }
        for name, data in arrays.items():
            group.create_dataset(name, data=data, chunks=data.shape, compression=9)

    return change


table("10^6 directions", "the directions are 1000000, above the limit of", many_directions)
table("too many paths", "the paths of direction 0 are 40000, above", polygons(40000, 3))
table("polygons all over the bins", "the polygons over the whole", polygons(3000, 3, 100.0))
table("too many corners", "the corners of path 0 of direction 0 are 20000", polygons(1, 20000))


def bins_nan(file):
    file["shift_u"][3] = np.nan


table("bins NaN", "dataset shift_u is NaN", bins_nan)


# ---- Meshes


def obj(name, text, says):
    path = written(name.replace(" ", "_") + ".obj", text.encode())
    case(name, ["bake", "trace", path, "-o", "out.h5"], says)


def gltf(name, json, says):
    path = written(name.replace(" ", "_") + ".gltf", json.encode())
    case(name, ["bake", "trace", path, "-o", "out.h5"], says)


HEAD = '"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}]'
MESH = '"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]'


def accessor(count, uri, length=36, more=""):
    return (
        "{"
        + HEAD
        + ',"nodes":[{"mesh":0}],'
        + MESH
        + more
        + ',"buffers":[{"byteLength":%d,"uri":"%s"}],'
        '"bufferViews":[{"buffer":0,"byteLength":%d}],'
        '"accessors":[{"bufferView":0,"componentType":5126,'
        '"count":%d,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}]}' % (length, uri, length, count)
    )


INLINE = "data:application/octet-stream;base64," + "A" * 48
obj("a face to vertex 10^12", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 1000000000000\n", "line 4")
obj("vertices NaN and infinite", "v nan 0 0\nv inf 0 0\nv 0 1 0\nf 1 2 3\n", "not finite")
obj(
    "a face of a million corners",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + " 1 2 3" * 333333 + "\n",
    "corners of one polygon",
)
obj("nine million vertices", "v 0 0 0\n" * 9000000 + "f 1 2 3\n", "9000000 vertices")
gltf("10^12 vertices", accessor(10**12, INLINE), "")
gltf("10^9 vertices", accessor(10**9, INLINE), "1000000000 vertices")
gltf("a buffer of 10^15 bytes", accessor(3, INLINE, 10**15), "holds the number 1000000000000000")
for name, uri in [
    ("above its folder", "../table.h5"),
    ("by an absolute path", "/etc/passwd"),
    ("from the network", "http://localhost/a.bin"),
    ("above by escapes", "%2e%2e/table.h5"),
    ("by a file URI", "file:///etc/passwd"),
]:
    gltf("a buffer " + name, accessor(3, uri), "cannot be resolved")
gltf(
    "data that is not base64",
    accessor(3, "data:application/octet-stream;base64," + "!" * 48),
    "cannot be resolved",
)
gltf(
    "a data URI of 200 MB",
    accessor(3, "data:application/octet-stream;base64," + "A" * 200_000_000),
    "more than the limit of 134217728",
)
gltf(
    "a hundred thousand nodes deep",
    "{"
    + HEAD
    + ',"nodes":['
    + ",".join('{"children":[%d]}' % (k + 1) for k in range(100000))
    + ",{}]}",
    "no triangles",
)
gltf(
    "five million empty nodes",
    "{" + HEAD + ',"nodes":[' + ",".join(["{}"] * 5000000) + "]}",
    "JSON objects",
)
gltf("nodes in a circle", "{" + HEAD + ',"nodes":[{"children":[1]},{"children":[0]}]}', "twice")
gltf(
    "JSON nested a million deep",
    "{" + HEAD + ',"extras":' + "[" * 1000000 + "]" * 1000000 + "}",
    "not valid glTF",
)
case(
    "a GLB that claims 4 GB",
    [
        "bake",
        "trace",
        written("claims.glb", b"glTF" + struct.pack("<III", 2, 0xFFFFFFFF, 0xFFFFFFF0) + b"JSON{}"),
        "-o",
        "out.h5",
    ],
    "shorter than its header says",
)


# ---- Photographs


def photograph(name, ending, content, says):
    path = written(name.replace(" ", "_") + ending, content)
    case(name, ["fit", "mtf", path, "--pixel-pitch", "0.1"], says)


def png(width, height, bits, colour, rows):
    def chunk(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, colour, 0, 0, 0))
        + chunk(b"IDAT", rows)
        + chunk(b"IEND", b"")
    )


def tiff(width, height, bits, compression, data):
    entries = [
        (256, 4, width),
        (257, 4, height),
        (258, 3, bits),
        (259, 3, compression),
        (262, 3, 1),
        (273, 4, 8 + 2 + 12 * 9 + 4),
        (277, 3, 1),
        (278, 4, height),
        (279, 4, len(data)),
    ]
    return (
        b"II*\0"
        + struct.pack("<IH", 8, len(entries))
        + b"".join(struct.pack("<HHII", tag, kind, 1, value) for tag, kind, value in entries)
        + bytes(4)
        + data
    )


def exr(width, height, tile=None):
    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(data)) + data

    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"Y\0" + struct.pack("<iIii", 2, 0, 1, 1) + b"\0"
    tiles = attribute(b"tiles", b"tiledesc", struct.pack("<IIB", tile, tile, 0)) if tile else b""
    return (
        struct.pack("<II", 20000630, 2 | (0x200 if tile else 0))
        + attribute(b"channels", b"chlist", channels)
        + attribute(b"compression", b"compression", b"\3")
        + attribute(b"dataWindow", b"box2i", window)
        + attribute(b"displayWindow", b"box2i", window)
        + attribute(b"lineOrder", b"lineOrder", b"\0")
        + attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
        + attribute(b"screenWindowCenter", b"v2f", bytes(8))
        + attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1))
        + tiles
        + b"\0"
    )


photograph(
    "PNG of 10^6 x 10^6",
    ".png",
    png(10**6, 10**6, 16, 0, zlib.compress(b"")),
    "1000000 x 1000000 pixels",
)
photograph(
    "TIFF of 10^6 x 10^6", ".tif", tiff(10**6, 10**6, 16, 1, b""), "1000000 x 1000000 pixels"
)
photograph("EXR of 10^6 x 10^6", ".exr", exr(10**6, 10**6), "EXR")


def wrong_end(stream):
    """Returns a zlib stream with another checksum."""
    return stream[:-1] + bytes([stream[-1] ^ 1])


ROWS = wrong_end(zlib.compress(bytes(8 * 17)))
photograph("PNG with another Adler-32", ".png", png(8, 8, 16, 0, ROWS), "cannot be decoded")
CUT = zlib.compress(b"".join(b"\0" + bytes(range(k, k + 16)) for k in range(8)))[:30]
photograph("PNG of a stream that is cut", ".png", png(8, 8, 16, 0, CUT), "cannot be decoded")
STRIP = wrong_end(zlib.compress(bytes(8 * 16)))
photograph("TIFF with another Adler-32", ".tif", tiff(8, 8, 16, 8, STRIP), "cannot be decoded")
photograph("TIFF of old deflate", ".tif", tiff(8, 8, 16, 32946, STRIP), "cannot be decoded")
# A block of zeros: its offset, its first row and length; each byte but the first is stored as its
# difference from the one before it, plus 128.
HEADER = exr(8, 8)
BLOCK = wrong_end(zlib.compress(bytes(1) + b"\x80" * 255))
photograph(
    "EXR with another Adler-32",
    ".exr",
    HEADER + struct.pack("<QiI", len(HEADER) + 8, 0, len(BLOCK)) + BLOCK,
    "cannot be decoded",
)
photograph("EXR of 10^6 x 10^6 in tiles of one pixel", ".exr", exr(10**6, 10**6, 1), "")
photograph("EXR of 14000 x 14000 in tiles of one pixel", ".exr", exr(14000, 14000, 1), "")
photograph(
    "JPEG of 65535 x 65535",
    ".jpg",
    b"\xff\xd8\xff\xc0\0\x0b\x08\xff\xff\xff\xff\x01\x01\x11\0\xff\xda\0\x08\x01\x01\0\0\x3f\0",
    "",
)
photograph(
    "PNG of 190 megapixels of nothing",
    ".png",
    png(19000, 10000, 16, 2, zeros((19000 * 6 + 1) * 10000)),
    "as a decompression bomb does",
)
photograph(
    "TIFF of 190 megapixels of nothing",
    ".tif",
    tiff(19000, 10000, 16, 8, zeros(19000 * 2 * 10000)),
    "as a decompression bomb does",
)
photograph("EXR of 190 megapixels of nothing", ".exr", exr(19000, 10000), "")
photograph("a small PNG that inflates without end", ".png", png(8, 8, 16, 0, zeros(1 << 32)), "")
photograph("a small TIFF that inflates without end", ".tif", tiff(8, 8, 16, 8, zeros(1 << 32)), "")


# ---- Texts


def text(name, content, command, says):
    path = written(name.replace(" ", "_") + ".txt", content)
    case(name, [path if word == "FILE" else word for word in command], says)


ESTIMATE = ["fit", "estimate", "FILE", "--table", TABLE, "-o", "result.json"]
PREDICT = ["fit", "predict", "FILE", "--table", TABLE, "--distance", "100", "--incidence", "0"]
text("TOML of 100 MB", b"a = 1\n" * 17_000_000, ESTIMATE, "longer than")
text("TOML nested deep", b"a = " + b"[" * 100000 + b"]" * 100000, ESTIMATE, "not valid TOML")
text(
    "TOML tables nested deep",
    b"a = " + b"{a=" * 100000 + b"1" + b"}" * 100000,
    ESTIMATE,
    "not valid TOML",
)
text("a TOML key of many dots", b".".join([b"a"] * 400000) + b" = 1", ESTIMATE, "")
text("a TOML heading of many dots", b"[" + b".".join([b"a"] * 400000) + b"]", ESTIMATE, "")
text("many TOML headings", b"[[capture]]\n" * 80000, ESTIMATE, "")
CAPTURE = b'{image="n",floating_distance_mm=9,incidence_deg=0},\n'
written("n", b"")
text(
    "a manifest of 20000 photographs",
    b"capture = [\n" + CAPTURE * 20000 + b"]\n[setup]\npixel_pitch_mm = 0.1\n",
    ESTIMATE,
    "",
)
text("JSON nested deep", b"[" * 1000000, PREDICT, "")
text("JSON of 100 MB", b'{"kernel":"' + b"a" * 100_000_000 + b'"}', PREDICT, "longer than")

# ---- Tables found by fuzzing. The headers of two claim 1.6 GB and an exabyte, and libhdf5 asks for
# that much memory at once. One has an attribute with fewer bytes than its type needs.

FOUND_TABLES = {
    "header_of_exabytes.h5": "damaged, copy it again",
    "header_of_gigabytes.h5": "damaged, copy it again",
    "text_of_15_bytes.h5": "in 15 bytes",
}
assert sorted(os.listdir(os.path.join(FOUND, "table"))) == sorted(FOUND_TABLES)
for name, says in FOUND_TABLES.items():
    case(name, ["bake", "inspect", os.path.join(FOUND, "table", name)], says)
