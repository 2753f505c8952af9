"""The wheel is whole: each file as its record says, its libraries need none but those of the system and each other, and its
module reads a map without any other library of ours. The same inputs give the same bytes.

usage: wheel_test.py BUILD_FOLDER WRITE_RANDOM_MAP
Exit status 77: this machine lacks what makes a wheel.
"""

import base64
import csv
import hashlib
import io
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

BUILD, WRITE_RANDOM_MAP = pathlib.Path(sys.argv[1]), sys.argv[2]
OF_SYSTEM = re.compile(r"(libstdc\+\+|libgcc_s|libm|libc|ld-linux.*)\.so\.\d+$")


def run(*command, **options):
    return subprocess.run([str(each) for each in command], check=True, text=True, stdout=subprocess.PIPE, **options).stdout


def made_wheel():
    run("ninja", "-C", BUILD, "sightline_wheel")
    (wheel,) = BUILD.glob("sightline_map-*.whl")
    return wheel


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.wheel = made_wheel()
        cls.folder = tempfile.TemporaryDirectory()
        with zipfile.ZipFile(cls.wheel) as archive:
            archive.extractall(cls.folder.name)
        cls.root = pathlib.Path(cls.folder.name)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_each_file_is_as_its_record_says(self):
        (record,) = self.root.glob("*.dist-info/RECORD")
        rows = list(csv.reader(io.StringIO(record.read_text())))
        files = {str(file.relative_to(self.root)) for file in self.root.rglob("*") if file.is_file()}
        self.assertEqual({name for name, _, _ in rows}, files)
        for name, digest, size in rows:
            if name.endswith("/RECORD"):
                continue
            data = (self.root / name).read_bytes()
            found = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            self.assertEqual((digest, int(size)), (f"sha256={found}", len(data)), name)

    def test_libraries_need_the_system_and_each_other_alone(self):
        libraries = list((self.root / "sightline/libraries").iterdir())
        names = {library.name for library in libraries}
        self.assertTrue({"libsightline-reader.so.0", "libsightline-localizer.so.0"} <= names)
        for library in libraries:
            for needed in re.findall(r"NEEDED\s+(\S+)", run("objdump", "-p", library)):
                self.assertTrue(OF_SYSTEM.match(needed) or needed in names, f"{library.name} needs {needed}")
            versions = re.findall(r"\bGLIBC_2\.(\d+)", run("objdump", "-T", library))
            self.assertLessEqual(max(int(version) for version in versions), 34, library.name)
        self.assertIn("manylinux_2_34", self.wheel.name)

    def test_module_reads_a_map_with_its_own_libraries(self):
        run(WRITE_RANDOM_MAP, "1", self.root)
        program = ("import sightline, sightline._interface as interface\n"
                   "with sightline.Map('map.slmap') as opened:\n    print(opened.site_count > 0)\n"
                   "interface.localizer()\nprint(open('/proc/self/maps').read())")
        lines = run(sys.executable, "-c", program, cwd=self.root, env={"PATH": os.environ["PATH"], "PYTHONDONTWRITEBYTECODE": "1"})
        self.assertTrue(lines.startswith("True\n"))
        for line in lines.splitlines():
            if re.search(r"sightline-|libtbb|libcrypto", line):
                self.assertIn(str(self.root.resolve()), line)
        self.assertIn("libtbb-sightline.so.12", lines)

    def test_same_inputs_give_the_same_bytes(self):
        before = self.wheel.read_bytes()
        self.wheel.unlink()
        self.assertEqual(made_wheel().read_bytes(), before)


if __name__ == "__main__":
    if not all(map(shutil.which, ("patchelf", "objdump", "ninja"))):
        print("skipped: patchelf, objdump or ninja is not installed")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
