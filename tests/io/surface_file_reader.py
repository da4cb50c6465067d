# SPDX-License-Identifier: Apache-2.0
"""Reads a 3MF or binary glTF file with the standard library alone, for tests. Prints the unit, then a line for each object: name,
sRGB colour, numbers of vertices and triangles, volume in mm3 and bounding box in mm, in the frame of the patient (LPS).

surface_file_reader.py FILE
"""
import json
import struct
import sys
import xml.etree.ElementTree
import zipfile


def describe(name, colour, points, triangles):
    volume = 0.0
    for a, b, c in triangles:
        p, q, r = points[a], points[b], points[c]
        cross = (q[1] * r[2] - q[2] * r[1], q[2] * r[0] - q[0] * r[2], q[0] * r[1] - q[1] * r[0])
        volume += sum(x * y for x, y in zip(p, cross)) / 6
    low, high = ([f(p[a] for p in points) for a in range(3)] for f in (min, max))
    box = " ".join(f"{v:.2f}" for v in [*low, *high])
    print(name, " ".join(str(c) for c in colour), f"{len(points)} {len(triangles)}", f"{volume:.1f}", box, sep="|")


def read_3mf(path):
    space = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
    with zipfile.ZipFile(path) as archive:
        relations = xml.etree.ElementTree.fromstring(archive.read("_rels/.rels"))
        target = next(r.get("Target") for r in relations if r.get("Type").endswith("/3dmodel"))
        model = xml.etree.ElementTree.fromstring(archive.read(target.lstrip("/")))
    print(model.get("unit"))
    resources = model.find(space + "resources")
    materials = {m.get("id"): list(m) for m in resources.iter(space + "basematerials")}
    objects = {o.get("id"): o for o in resources.iter(space + "object")}
    for item in model.find(space + "build"):
        assert item.get("transform") is None
        thing = objects[item.get("objectid")]
        material = materials[thing.get("pid")][int(thing.get("pindex"))]
        colour = bytes.fromhex(material.get("displaycolor")[1:7])
        points = [tuple(float(v.get(a)) for a in "xyz") for v in thing.iter(space + "vertex")]
        triangles = [tuple(int(t.get(a)) for a in ("v1", "v2", "v3")) for t in thing.iter(space + "triangle")]
        describe(thing.get("name"), colour, points, triangles)


def read_glb(path):
    with open(path, "rb") as file:
        data = file.read()
    magic, version, total = struct.unpack_from("<4sII", data)
    assert (magic, version, total) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON" and size % 4 == 0
    scene = json.loads(data[20 : 20 + size])
    binary_size, kind = struct.unpack_from("<I4s", data, 20 + size)
    assert kind == b"BIN\0" and 28 + size + binary_size == total and scene["buffers"][0]["byteLength"] <= binary_size
    binary = data[28 + size :]

    def values(index, width):
        accessor = scene["accessors"][index]
        view = scene["bufferViews"][accessor["bufferView"]]
        assert view["byteOffset"] % 4 == 0
        code = {5126: "f", 5125: "I"}[accessor["componentType"]]
        count = accessor["count"] * (3 if accessor["type"] == "VEC3" else 1)
        assert count * 4 == view["byteLength"]
        flat = struct.unpack_from(f"<{count}{code}", binary, view["byteOffset"])
        found = [flat[n : n + width] for n in range(0, count, width)]
        if "min" in accessor:
            for f, key in ((min, "min"), (max, "max")):
                limits = [f(v[a] for v in found) for a in range(width)]
                assert all(abs(x - y) <= 1e-4 * max(1, abs(x)) for x, y in zip(limits, accessor[key]))
        return found

    root = scene["nodes"][scene["scenes"][scene["scene"]]["nodes"][0]]

    def world(point):
        """Position in the frame of glTF: scaled, then turned by the quaternion of the root."""
        x, y, z, w = root["rotation"]
        v = [s * p for s, p in zip(root["scale"], point)]
        t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])]
        return (v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0])

    lines = []
    outwards = True
    for index in root["children"]:
        node = scene["nodes"][index]
        primitive = scene["meshes"][node["mesh"]]["primitives"][0]
        assert primitive.get("mode", 4) == 4
        points = values(primitive["attributes"]["POSITION"], 3)
        normals = values(primitive["attributes"]["NORMAL"], 3)
        middle = [sum(p[a] for p in points) / len(points) for a in range(3)]
        for p, n in zip(points, normals):
            assert abs(sum(c * c for c in n) - 1) < 1e-4
            outwards = outwards and sum((p[a] - middle[a]) * n[a] for a in range(3)) > 0
        linear = scene["materials"][primitive["material"]]["pbrMetallicRoughness"]["baseColorFactor"][:3]
        colour = [round(255 * (12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055)) for c in linear]
        # +Y is superior, +Z anterior, +X left; metres.
        placed = [world(p) for p in points]
        patient = [(1000 * x, -1000 * z, 1000 * y) for x, y, z in placed]
        lines.append((node["name"], colour, patient, values(primitive["indices"], 3)))
    print("metre, normals point", "outwards" if outwards else "inwards")
    for line in lines:
        describe(*line)


(read_3mf if sys.argv[1].endswith(".3mf") else read_glb)(sys.argv[1])
