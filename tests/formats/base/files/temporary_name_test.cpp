#include "formats/base/files/temporary_name.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <set>
#include <string>

#include "tests/support/scratch_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// A name that a process made which has ended since.
std::string name_of_the_gone() {
  std::array<int, 2> ends{};
  EXPECT_EQ(::pipe(ends.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const std::string name = temporary_name();
    ::_exit(::write(ends[1], name.data(), name.size()) < 0 ? 1 : 0);
  }
  ::waitpid(child, nullptr, 0);
  std::array<char, 256> name{};
  const ssize_t size = ::read(ends[0], name.data(), name.size());
  ::close(ends[0]);
  ::close(ends[1]);
  return {name.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
}

std::string with_field(const std::string& name, int field, const std::string& text) {
  std::size_t begin = 0;
  for (int i = 0; i < field; ++i) begin = name.find('-', begin) + 1;
  const std::size_t end = std::min(name.find('-', begin), name.size());
  return name.substr(0, begin) + text + name.substr(end);
}

TEST(TemporaryName, HasSixFieldsAndIsNeverTheSame) {
  std::set<std::string> names;
  for (int i = 0; i < 100; ++i) names.insert(temporary_name());
  EXPECT_EQ(names.size(), 100U);
  for (const std::string& name : names) {
    EXPECT_EQ(std::ranges::count(name, '-'), 5) << name;
    EXPECT_TRUE(name.starts_with(".sl-"));
    EXPECT_LT(name.size(), 255U);
  }
}

TEST(TemporaryName, TellsTheLivingFromTheGone) {
  EXPECT_EQ(owner_of(temporary_name()), TemporaryOwner::kAlive);
  EXPECT_EQ(owner_of(name_of_the_gone()), TemporaryOwner::kGone);
  // The number of a living process that began at another time.
  EXPECT_EQ(owner_of(with_field(temporary_name(), 4, "1")), TemporaryOwner::kGone);
}

TEST(TemporaryName, KnowsNothingOfOtherMachinesAndBoots) {
  const std::string gone = name_of_the_gone();
  EXPECT_EQ(owner_of(with_field(gone, 1, "elsewhere.4026531836")), TemporaryOwner::kUnknown);
  EXPECT_EQ(owner_of(with_field(gone, 2, std::string(32, '0'))), TemporaryOwner::kUnknown);
  EXPECT_EQ(owner_of(with_field(gone, 3, "-1")), TemporaryOwner::kNone);
  EXPECT_EQ(owner_of(with_field(gone, 3, "99999999999999999999")), TemporaryOwner::kUnknown);
  EXPECT_EQ(owner_of(with_field(gone, 3, "0")), TemporaryOwner::kUnknown);
}

TEST(TemporaryName, IsNotSeenInOtherNames) {
  for (const char* name :
       {"", ".sl", ".sl-", "map.slmap.12.tmp", "x.tmp", ".sl-a-b-c-d", "-----"}) {
    EXPECT_EQ(owner_of(name), TemporaryOwner::kNone) << name;
  }
}

TEST(TemporaryName, LeftoversOfTheGoneAloneAreRemoved) {
  const fs::path folder = scratch_folder();
  fs::remove_all(folder);
  fs::create_directories(folder);
  const std::string gone = name_of_the_gone();
  const std::vector<std::string> stay = {temporary_name(), with_field(gone, 1, "elsewhere.1"),
                                         "mine.tmp", "town.slmap.99.tmp", ".sl-mine"};
  for (const std::string& name : stay) std::ofstream(folder / name) << "kept";
  std::ofstream(folder / gone) << "half";
  remove_leftovers(folder);
  EXPECT_FALSE(fs::exists(folder / gone));
  for (const std::string& name : stay) EXPECT_TRUE(fs::exists(folder / name)) << name;
  fs::remove_all(folder);
}

}  // namespace
}  // namespace sightline
