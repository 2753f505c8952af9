#include "formats/foreign/recording/scan_files.h"

#include <sys/stat.h>

#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

std::vector<std::string> names(const std::vector<std::filesystem::path>& files) {
  std::vector<std::string> list;
  for (const std::filesystem::path& file : files) list.push_back(file.filename().string());
  return list;
}

TEST(ScanFiles, AreListedInNaturalOrder) {
  const ScratchFolder folder;
  for (const char* name : {"scan10.pcd", "scan2.pcd", "scan1.PCD", ".hidden.pcd", "notes.txt"}) {
    folder.write(name, "x");
  }
  std::filesystem::create_directory(folder / "folder.pcd");
  const auto files = value_of(list_scan_files(folder.path()));
  EXPECT_EQ(names(files), (std::vector<std::string>{"scan1.PCD", "scan2.pcd", "scan10.pcd"}));
}

TEST(ScanFiles, NaturalOrderIsAnOrder) {
  const std::vector<std::string> ordered = {
      "1", "01", "2",    "9b",    "10",  "10a", "10b",
      "a", "a1", "a1.9", "a1.10", "a02", "a2",  "99999999999999999999999",
      "b"};
  for (const std::string& a : ordered) {
    EXPECT_FALSE(natural_less(a, a));
    for (const std::string& b : ordered) {
      EXPECT_EQ(natural_less(a, b) || natural_less(b, a), a != b) << a << " " << b;
      EXPECT_FALSE(natural_less(a, b) && natural_less(b, a)) << a << " " << b;
      for (const std::string& c : ordered) {
        if (natural_less(a, b) && natural_less(b, c)) {
          EXPECT_TRUE(natural_less(a, c)) << a << " " << b << " " << c;
        }
      }
    }
  }
  EXPECT_TRUE(natural_less("2.pcd", "10.pcd"));
}

TEST(ScanFiles, RefusesFoldersWithoutScansOfOneKind) {
  const ScratchFolder folder;
  EXPECT_EQ(list_scan_files(folder.path()).error().code, ErrorCode::kEmptyDirectory);
  EXPECT_EQ(list_scan_files(folder / "none").error().code, ErrorCode::kFileNotFound);
  folder.write("Scans/000.pcd", "x");
  const auto deeper = list_scan_files(folder.path());
  EXPECT_EQ(deeper.error().code, ErrorCode::kEmptyDirectory);
  EXPECT_THAT(deeper.error().message, HasSubstr("its folder Scans does"));
  folder.write("000.laz", "LASF" + std::string(100, '\0') + "\x83");
  EXPECT_EQ(list_scan_files(folder.path()).error().code, ErrorCode::kUnsupportedFormat);
  folder.write("001.bin", "x");
  EXPECT_EQ(list_scan_files(folder.path()).error().code, ErrorCode::kMixedFormats);
}

TEST(ScanFiles, RefusesALinkThatLeadsNowhereByItsName) {
  const ScratchFolder folder;
  folder.write("000.pcd", "x");
  std::filesystem::create_symlink("000.pcd", folder / "001.pcd");
  EXPECT_EQ(list_scan_files(folder.path())->size(), 2U);
  std::filesystem::create_symlink("archive/002.pcd", folder / "002.pcd");
  const Error error = failure_of(list_scan_files(folder.path()));
  EXPECT_EQ(error.code, ErrorCode::kFileNotFound);
  EXPECT_EQ(error.file, (folder / "002.pcd").string());
  EXPECT_THAT(error.message, HasSubstr("archive/002.pcd"));
  std::filesystem::remove(folder / "002.pcd");
  std::filesystem::create_symlink("003.pcd", folder / "003.pcd");
  EXPECT_EQ(list_scan_files(folder.path()).error().file, (folder / "003.pcd").string());
}

TEST(ScanFiles, RefusesAPipeWithoutWaitingForIt) {
  const ScratchFolder folder;
  ASSERT_EQ(::mkfifo((folder / "000.pcd").c_str(), 0600), 0);
  EXPECT_EQ(list_scan_files(folder.path()).error().code, ErrorCode::kCannotRead);
}

TEST(ScanFiles, NamesTellNumbersAndTimes) {
  EXPECT_EQ(scan_number("a/000012.pcd"), 12);
  EXPECT_EQ(scan_number("run2_scan_7_xyz.pcd"), 7);
  EXPECT_EQ(scan_number("scan.pcd"), std::nullopt);
  EXPECT_EQ(scan_stamp_ns("1567410201745204736.pcd"), 1567410201745204736);
  EXPECT_EQ(scan_stamp_ns("1567410201.745204.bin"), 1567410201745204000);
  EXPECT_EQ(scan_stamp_ns("n015-2018-07-24-11-22-45+0800__LIDAR_TOP__1532402927647951.pcd.bin"),
            1532402927647951000);
  EXPECT_EQ(scan_stamp_ns("0000000012.pcd"), std::nullopt);
  EXPECT_EQ(scan_stamp_ns("000000000000000012.pcd"), std::nullopt);
  EXPECT_EQ(scan_stamp_ns("scan_1567410201745204736.pcd"), std::nullopt);
}

TEST(ScanFiles, AFileOfAFormatThatIsNotReadSaysHowToConvertIt) {
  const ScratchFolder folder;
  const auto said = [](const std::filesystem::path& path) {
    return outcome_of(list_scan_files(path));
  };
  const std::filesystem::path osf = folder.write("drive.osf", std::string("\0\0\0\x24OSF!", 8));
  EXPECT_THAT(said(osf), HasSubstr("ouster-cli source in.osf save out.pcap"));
  EXPECT_THAT(said(folder.path()), HasSubstr("ouster-cli source in.osf save out.pcap"));
  const ScratchFolder other;
  EXPECT_THAT(said(other.write("a.lvx2", "livox_tech")), HasSubstr("livox_ros_driver"));
  EXPECT_THAT(said(other.write("a.e57", "ASTM-E57")), HasSubstr("CloudCompare"));
  // A single scan is reported by the verb that was called.
  EXPECT_EQ(list_scan_files(other.write("a.pcd", "# .PCD")).error().code, ErrorCode::kCannotOpen);
}

}  // namespace
}  // namespace sightline
