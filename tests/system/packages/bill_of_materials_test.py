"""The package's bill of materials is one of SPDX 2.3, and names every library that the program and the libraries load.

usage: bill_of_materials_test.py BILL PROGRAM_OR_LIBRARY...
"""

import json
import re
import subprocess
import sys
import unittest

BILL, BINARIES = sys.argv[1], sys.argv[2:]

# Beginnings of the names of shared libraries; those that come with every program of C++ have no row.
OF_SONAME = {"libbz2": "bzip2", "libceres": "Ceres", "libcrypto": "OpenSSL", "libembree": "Embree",
             "libfmt": "fmt", "libGeographicLib": "GeographicLib", "liblz4": "lz4", "liboctomap": "OctoMap",
             "liboctomath": "OctoMap", "libpcl_": "PCL", "libpng": "libpng", "libsodium": "libsodium",
             "libspdlog": "spdlog", "libsqlite3": "SQLite", "libtbb": "oneTBB", "libtinyxml2": "TinyXML-2", "libyaml-cpp": "yaml-cpp",
             "libz.": "zlib", "libzstd": "zstd"}
TOOLCHAIN = ("libstdc++.", "libgcc_s.", "libm.", "libc.", "libpthread.", "ld-linux")
# Of Ceres, which is linked statically.
OF_OTHERS = ("libcholmod.", "libcxsparse.", "libf77blas.", "libgflags.", "libglog.", "liblapack.")


class BillOfMaterials(unittest.TestCase):
    def setUp(self):
        with open(BILL, encoding="utf-8") as file:
            self.bill = json.load(file)
        self.packages = {package["name"]: package for package in self.bill["packages"]}

    def test_is_a_document_of_spdx(self):
        bill = self.bill
        self.assertEqual((bill["spdxVersion"], bill["dataLicense"], bill["SPDXID"]),
                         ("SPDX-2.3", "CC0-1.0", "SPDXRef-DOCUMENT"))
        self.assertRegex(bill["documentNamespace"], r"^https://[^# ]+$")
        self.assertRegex(bill["creationInfo"]["created"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
        for creator in bill["creationInfo"]["creators"]:
            self.assertRegex(creator, r"^(Tool|Organization|Person): .")
        ids = [package["SPDXID"] for package in bill["packages"]]
        self.assertEqual(len(ids), len(set(ids)))
        for package in bill["packages"]:
            self.assertRegex(package["SPDXID"], r"^SPDXRef-[A-Za-z0-9.-]+$")
            self.assertRegex(package["versionInfo"], r"^\d")
            self.assertTrue(package["downloadLocation"] and package["licenseDeclared"])
        for relationship in bill["relationships"]:
            for end in ("spdxElementId", "relatedSpdxElement"):
                self.assertIn(relationship[end], ids + ["SPDXRef-DOCUMENT"])

    def test_names_what_is_loaded(self):
        for binary in BINARIES:
            text = subprocess.run(["objdump", "-p", binary], capture_output=True, text=True, check=True).stdout
            for soname in re.findall(r"NEEDED +(\S+)", text):
                if soname.startswith(TOOLCHAIN + OF_OTHERS):
                    continue
                names = [name for beginning, name in OF_SONAME.items() if soname.startswith(beginning)]
                self.assertTrue(names, f"{soname}: compiler/package/libraries.cmake has no row for it")
                self.assertIn(names[0], self.packages)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
