// Runs a fuzz target on the files of the folders named, without a fuzzer: what was found once must
// stay found. usage: replay_TARGET FOLDER...

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "tests/fuzz/fuzz.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* /*data*/, std::size_t size,
                                        std::size_t /*max_size*/) {
  return size;  // only a fuzzer mutates
}

int main(int argc, char** argv) {
  std::vector<std::filesystem::path> files;
  for (int i = 1; i < argc; ++i) {
    for (const auto& entry : std::filesystem::directory_iterator(argv[i])) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  for (const std::filesystem::path& file : files) {
    const auto content = sightline::read_file(file);
    if (!content) {
      std::fprintf(stderr, "%s\n", sightline::to_string(content.error()).c_str());
      return 1;
    }
    std::fprintf(stderr, "%s\n", file.c_str());  // the last one printed is the guilty one
    const auto* data = reinterpret_cast<const std::uint8_t*>(content->data());
    (void)LLVMFuzzerTestOneInput(data, content->size());
  }
  std::printf("%zu inputs\n", files.size());
  return files.empty() ? 1 : 0;
}
