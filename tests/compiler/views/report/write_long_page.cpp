// Writes the page of a made-up road, all that a report can show: write_long_page METRES FILE.html

#include <cstdio>
#include <cstdlib>

#include "formats/base/files/atomic_file.h"
#include "tests/compiler/views/report/long_road.h"

int main(int argc, char** argv) {
  using namespace sightline;
  if (argc != 3) return 64;
  const MadeSources made = long_road(std::atoi(argv[1]));
  const Result<std::string> html = report_html(made.sources());
  const Result<void> written =
      html ? write_file_atomically(argv[2], *html, IfExists::kReplace) : html.error();
  if (!written) std::fprintf(stderr, "%s\n", to_string(written.error()).c_str());
  return written ? 0 : 1;
}
