#include "formats/base/machine.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <fstream>

#include "tests/support/scratch_folder.h"

namespace sightline {
namespace {

// A root that stands in for "/", with the groups of this process and where they are mounted.
class Machine : public TestInFolder {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }
  void mount(const std::string& lines) const { write("proc/self/mountinfo", lines); }
  void group(const std::string& lines) const { write("proc/self/cgroup", lines); }
};

constexpr const char* kUnified = "31 23 0:28 / /sys/fs/cgroup rw - cgroup2 cgroup2 rw,nsdelegate\n";

TEST_F(Machine, HasNoLimitsWithoutGroups) {
  EXPECT_FALSE(processor_limit(folder_));
  EXPECT_FALSE(memory_left_mib(folder_));
}

TEST_F(Machine, TakesTheLeastLimitOfAllGroupsAround) {
  group("0::/user/job\n");
  mount(kUnified);
  write("sys/fs/cgroup/user/cpu.max", "150000 100000\n");
  write("sys/fs/cgroup/user/job/cpu.max", "max 100000\n");
  EXPECT_EQ(processor_limit(folder_), 1.5);
  write("sys/fs/cgroup/user/job/cpu.max", "25000 50000\n");
  EXPECT_EQ(processor_limit(folder_), 0.5);
  write("sys/fs/cgroup/user/memory.max", "max\n");
  write("sys/fs/cgroup/user/memory.current", "1\n");
  EXPECT_FALSE(memory_left_mib(folder_));
  write("sys/fs/cgroup/user/job/memory.max", "67108864\n");
  write("sys/fs/cgroup/user/job/memory.current", "33554432\n");
  EXPECT_EQ(memory_left_mib(folder_), 32.0);
  // What files hold is taken back when it is needed.
  write("sys/fs/cgroup/user/job/memory.stat", "anon 4\ninactive_file 16777216\nactive_file 8\n");
  EXPECT_EQ(memory_left_mib(folder_), 48.0);
  write("sys/fs/cgroup/user/job/memory.current", "99999999\n");
  write("sys/fs/cgroup/user/job/memory.stat", "inactive_file 0\n");
  EXPECT_EQ(memory_left_mib(folder_), 0.0);
}

TEST_F(Machine, ReadsGroupsOfVersionOneBesideThoseOfVersionTwo) {
  group("4:memory:/jobs/7\n3:cpu,cpuacct:/jobs/7\n0::/\n");
  mount(std::string("33 31 0:30 / /sys/fs/cgroup/cpu,cpuacct rw - cgroup cgroup rw,cpu,cpuacct\n"
                    "35 31 0:32 / /sys/fs/cgroup/memory rw - cgroup cgroup rw,memory\n") +
        "41 31 0:38 / /sys/fs/cgroup/unified rw - cgroup2 cgroup2 rw\n");
  const std::string cpu = "sys/fs/cgroup/cpu,cpuacct/jobs/7/";
  write(cpu + "cpu.cfs_quota_us", "-1\n");
  write(cpu + "cpu.cfs_period_us", "100000\n");
  EXPECT_FALSE(processor_limit(folder_));
  write(cpu + "cpu.cfs_quota_us", "300000\n");
  EXPECT_EQ(processor_limit(folder_), 3.0);
  const std::string memory = "sys/fs/cgroup/memory/jobs/7/";
  write(memory + "memory.limit_in_bytes", "9223372036854771712\n");
  write(memory + "memory.usage_in_bytes", "1048576\n");
  EXPECT_FALSE(memory_left_mib(folder_));
  write(memory + "memory.limit_in_bytes", "62914560\n");
  EXPECT_EQ(memory_left_mib(folder_), 59.0);
}

// A container sees its own group as the root of the mount, and the names of its host in
// /proc/self/cgroup.
TEST_F(Machine, FindsTheGroupOfAContainer) {
  group("0::/docker/4f2a/inner\n");
  mount("31 23 0:28 /docker/4f2a /sys/fs/cgroup ro - cgroup2 cgroup2 rw\n");
  write("sys/fs/cgroup/cpu.max", "200000 100000\n");
  EXPECT_EQ(processor_limit(folder_), 2.0);
  write("sys/fs/cgroup/inner/cpu.max", "100000 100000\n");
  EXPECT_EQ(processor_limit(folder_), 1.0);
  group("0::/../elsewhere\n");
  mount(kUnified);
  EXPECT_EQ(processor_limit(folder_), 2.0);
}

TEST_F(Machine, ReadsNothingOutOfWhatIsNoLimit) {
  group("0::/\nno group\n");
  mount(kUnified);
  for (const char* text : {"", "max", "0 100000", "-5 100000", "100000", "100000 0", "a b"}) {
    write("sys/fs/cgroup/cpu.max", text);
    EXPECT_FALSE(processor_limit(folder_)) << text;
  }
}

TEST(MachineOfThisProcess, HasTheProcessorsOfItsAffinity) {
  cpu_set_t before;
  ASSERT_EQ(::sched_getaffinity(0, sizeof(before), &before), 0);
  EXPECT_EQ(usable_processors(), CPU_COUNT(&before));
  cpu_set_t one;
  CPU_ZERO(&one);
  for (int i = 0; CPU_COUNT(&one) == 0; ++i) {
    if (CPU_ISSET(i, &before)) CPU_SET(i, &one);
  }
  ASSERT_EQ(::sched_setaffinity(0, sizeof(one), &one), 0);
  EXPECT_EQ(usable_processors(), 1);
  ASSERT_EQ(::sched_setaffinity(0, sizeof(before), &before), 0);
  ASSERT_TRUE(free_memory_mib());
  EXPECT_GT(*free_memory_mib(), 1.0);
}

}  // namespace
}  // namespace sightline
