"""Reads models and takes digests of recordings by schemas/model_format.md alone, and compares with the program.

usage: model_format_test.py SIGHTLINE MODEL... (each a model file by any name)
"""

import hashlib
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

SIGHTLINE = sys.argv[1]


def sightline(*arguments, status=0):
    done = subprocess.run([SIGHTLINE, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == status, (arguments, done.returncode, done.stderr)
    return done.stdout if status == 0 else done.stderr


def rows_of(target, what):
    table = json.loads(sightline("dump", target, "--what", what, "--format", "json"))
    return [dict(zip(table["columns"], row)) for row in table["rows"]]


class Reader:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, size):
        assert self.at + size <= len(self.data), "the payload ends early"
        self.at += size
        return self.data[self.at - size:self.at]

    def one(self, form):
        return struct.unpack("<" + form, self.take(struct.calcsize("<" + form)))[0]

    def text(self):
        return self.take(self.one("Q")).decode()

    def array(self, form):
        return [self.one(form) for _ in range(self.one("Q"))]

    def list(self, read):
        return [read() for _ in range(self.one("Q"))]

    def struct(self, **fields):
        """Forms of numbers, or functions, in their order."""
        return {name: form() if callable(form) else self.one(form) for name, form in fields.items()}


def read_parts(r):
    recording = lambda: r.struct(role=r.text, name=r.text, sha256=lambda: r.take(32).hex(),
                                 scans=lambda: r.list(lambda: r.take(64)))
    place = lambda: r.struct(name=r.text, drives=lambda: r.list(r.text), route_m="d", blocks="I",
                             recordings=lambda: r.list(recording), numbers=lambda: r.array("I"), number="I",
                             centre_x_m="d", centre_y_m="d", centre_z_m="d")
    parameter = lambda: r.struct(name=r.text, value=r.text)
    look = lambda: r.struct(range_m="d", returns="I", even_beyond_m="d", points="I", by_normals="B", settles="B")
    localizer = lambda: r.struct(name=r.text, version="I", parameters=lambda: r.list(parameter))
    return {
        "card": r.struct(places=lambda: r.list(place), reference="B", localizer=localizer, feature_set=r.text, hold_out=r.text, seed="Q",
                         trees="I", least_leaf_rows="I", feature_share="d", block_m="d", buffer_m="d", route_m="d",
                         blocks="I", folds="I", knows_history="B", offset="d", slope="d",
                         worlds=r.text),
        "features": r.list(lambda: r.struct(name=r.text, importance_m="d", least=lambda: r.array("d"),
                                            greatest=lambda: r.array("d"))),
        "ranges": r.list(lambda: r.struct(range_m="d", mean_error_m="d", r_squared="d", rmse_m="d",
                                          history_r_squared="d", history_rmse_m="d")),
        "kinds": r.list(lambda: r.struct(limit_m="d", kind="B", cases="I", coverage="d", range_m="d", error_m="d")),
        "forest": r.struct(features="I", labels=lambda: r.array("d"), rows=lambda: r.array("f"),
                           trees=lambda: r.list(lambda: r.list(lambda: (r.one("H"), r.one("f"))))),
        "cases": r.list(lambda: r.struct(x_m="d", y_m="d", z_m="d", place="I", drive="I", run="I", s_m="d", block="I", has_label="B",
                                         has_history="B", features_xxh3="Q", kind="B")),
        "out_of_fold": r.struct(looks=lambda: r.list(look), limits_m=lambda: r.array("d"), cases="I",
                                mean_m=lambda: r.array("d"), within=lambda: r.array("d"),
                                extrapolated=lambda: r.array("B"), out_of_fold=lambda: r.array("B"),
                                has_history=lambda: r.array("B")),
        "labels": r.array("d"),
        "tracking": r.struct(offset="d", slope="d", row_errors_m=lambda: r.array("f"), measured_m=lambda: r.array("f"),
                             mean_m=lambda: r.array("f"), within=lambda: r.array("f")),
    }


def read_model(data):
    file = Reader(data)
    assert file.take(4) == b"SLA\x1a"
    assert file.one("I") == 9
    assert file.text() == "error-model"
    payload = file.take(file.one("Q"))
    file.one("Q")
    assert file.at == len(data)
    r = Reader(payload)
    model = read_parts(r)
    model["of_samples"] = [read_parts(r) for _ in range(r.one("B"))]
    assert r.at == len(payload), "the payload goes on"
    return model, hashlib.sha256(payload).hexdigest()


def leaf_of(nodes, row):
    """The leaf that a row falls into, by walking through the nodes in preorder."""
    leaves = 0

    def walk(node, asks):  # (leaf where the row ends or None, next node); counts leaves it passes
        nonlocal leaves
        bits, threshold = nodes[node]
        goes_left = asks and row[bits & 0x3FFF] < threshold
        found, following = None, node + 1
        for is_leaf, asked in ((bits & 0x8000, goes_left), (bits & 0x4000, asks and not goes_left)):
            if is_leaf:
                found = leaves if asked else found
                leaves += 1
            else:
                below, following = walk(following, asked)
                found = below if asked else found
        return found, following

    return walk(0, True)[0] if nodes else 0


def check_model(file, work):
    model, digest = read_model(file.read_bytes())
    for samples in model["of_samples"]:
        assert all(look["returns"] > 0 for look in samples["out_of_fold"]["looks"])
        assert len(samples["labels"]) == len(samples["cases"]) * len(samples["out_of_fold"]["looks"])
        tracking = samples["tracking"]
        if tracking["row_errors_m"]:
            assert len(tracking["row_errors_m"]) == len(samples["forest"]["labels"])
            assert len(tracking["measured_m"]) == len(tracking["mean_m"]) == len(samples["labels"])
            assert len(tracking["within"]) == len(samples["out_of_fold"]["within"])
    assert not model["tracking"]["row_errors_m"]
    assert all(look["returns"] == 0 for look in model["out_of_fold"]["looks"])
    copy = work / "any.slmodel"
    shutil.copy(file, copy)
    card, forest = model["card"], model["forest"]
    assert digest in sightline("inspect", copy)
    assert rows_of(copy, "recordings") == [{"place": place["name"], **{key: recording[key] for key in ("role", "name", "sha256")}}
                                           for place in card["places"] for recording in place["recordings"]]
    rows = rows_of(copy, "model")
    assert [row["mean_error_m"] for row in rows] == model["out_of_fold"]["mean_m"]
    assert [row["measured_mean_error_m"] for row in rows] == model["labels"]
    assert len(forest["trees"]) == card["trees"] and forest["labels"] == sorted(forest["labels"])
    width = forest["features"]
    assert len(forest["rows"]) == width * len(forest["labels"]) and model["features"][-1]["name"] == "range_m"
    for nodes in forest["trees"]:
        leaves = {leaf_of(nodes, forest["rows"][i:i + width]) for i in range(0, len(forest["rows"]), width)}
        assert leaves == set(range(len(nodes) + 1)), "found a leaf without a label"


def text(value):
    return struct.pack("<Q", len(value.encode())) + value.encode()


def doubles(values):
    return struct.pack(f"<{len(values)}d", *values)


def pose(x_m):
    return [1.0, 0.0, 0.0, x_m, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]


class Drive:
    """A recording of three scans in a folder, whose sensor sits 2 m up: all that its digest names."""

    def __init__(self, name, first_x_m):
        self.name = name
        self.first_x_m = first_x_m
        self.scans = {f"{i}.bin": struct.pack("<8f", *(first_x_m + i + j for j in range(8))) for i in (2, 9, 10)}

    def write(self, folder):
        scans = folder / f"scans of {self.name}"
        scans.mkdir(parents=True)
        for name, data in self.scans.items():
            (scans / name).write_bytes(data)
        poses = "".join(" ".join(map(repr, pose(self.first_x_m + i))) + "\n" for i in range(3))
        (folder / f"{self.name}.txt").write_text(poses)
        return (f"{{name: {self.name}, scans: {scans.name}, poses: {self.name}.txt, columns: 4, pose_format: kitti, "
                "rings: 3, lidar_z_m: 2}")

    def digest(self):
        beams = [-15.0, 0.0, 15.0]
        data = text(self.name) + text("generic-16-3-rings")
        data += struct.pack("<Q", len(beams)) + doubles(beams) + doubles([0.2, 1.0, 100.0, 1.8])
        data += doubles(pose(0.0)[:11] + [2.0])
        for i, (name, scan) in enumerate(self.scans.items()):
            data += text(name) + struct.pack("<qQ", i * 100_000_000, 32) + hashlib.sha256(scan).digest()
            data += b"\x01" + doubles(pose(self.first_x_m + i))
        return hashlib.sha256(data).hexdigest()


def check_recordings(work):
    drives = {"mapping": Drive("first", 1.0), "localization": Drive("second", 5.0), "evaluation": Drive("third", 9.5)}

    def write(folder):
        folder.mkdir()
        lines = [f"{role}: {drive.write(folder)}\n" for role, drive in drives.items()]
        (folder / "place.yaml").write_text("".join(lines))
        return folder / "place.yaml"

    def dumped(config):
        return {row["role"]: (row["name"], row["sha256"]) for row in rows_of(config, "recordings")}

    taken = {role: (drive.name, drive.digest()) for role, drive in drives.items()}
    assert dumped(write(work / "here")) == taken
    assert dumped(write(work / "elsewhere")) == taken, "they depend on where a recording lies"
    scan = bytearray(drives["localization"].scans["9.bin"])
    scan[5] ^= 1
    drives["localization"].scans["9.bin"] = bytes(scan)
    changed = dumped(write(work / "changed"))
    assert {role for role in taken if changed[role] != taken[role]} == {"localization"}
    assert changed["localization"] == ("second", drives["localization"].digest())


def main(models):
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        check_recordings(work)
        for model in models:
            check_model(pathlib.Path(model), work)
        assert "SL1001" in sightline("dump", work / "any.slmodel", "--what", "ranges", status=64)
        assert "SL1001" in sightline("inspect", work / "any.slmodel", "--site", "1", status=64)
        damaged = bytearray((work / "any.slmodel").read_bytes())
        damaged[len(damaged) // 2] ^= 1
        (work / "damaged.slmodel").write_bytes(damaged)
        assert "SL4003" in sightline("inspect", work / "damaged.slmodel", status=67)


main(sys.argv[2:])
