#include "tests/bench/looks/look_rule.h"

#include <charconv>

namespace sightline {
namespace {

constexpr std::string_view kOneIn = ", one voxel in ";

}  // namespace

bool needs_normals(const LookRule& rule) {
  return rule.kind == LookRule::Kind::kLook && rule.look.is_by_normals;
}

std::string to_text(const LookRule& rule) {
  if (rule.kind == LookRule::Kind::kReference) return "50 m, every return, searching";
  if (rule.kind == LookRule::Kind::kAutoware) {
    return "Autoware's sampling: 60 m, voxels of 3 m, 1500 at random";
  }
  std::string text = to_text(rule.look);
  if (rule.voxels_apart > 1) {
    text += std::string(kOneIn) + std::to_string(rule.voxels_apart);
  }
  return text;
}

Result<LookRule> parse_look_rule(std::string_view text) {
  LookRule rule;
  const std::size_t one_in = text.rfind(kOneIn);
  if (one_in != std::string_view::npos) {
    const char* begin = text.data() + one_in + kOneIn.size();
    const char* end = text.data() + text.size();
    const std::from_chars_result read = std::from_chars(begin, end, rule.voxels_apart);
    if (read.ptr != end || read.ec != std::errc() || rule.voxels_apart < 1) {
      return Error{ErrorCode::kBadArgument,
                   "'" + std::string(text) + "' does not say one voxel in how many",
                   {},
                   {}};
    }
    text = text.substr(0, one_in);
  }
  SIGHTLINE_ASSIGN(rule.look, parse_look(text));
  if (rule.voxels_apart > 1 && (takes_every_return(rule.look) || rule.look.point_count > 0)) {
    return Error{
        ErrorCode::kBadArgument,
        "'" + std::string(text) + "', one voxel in so many: expected returns and no points",
        {},
        {}};
  }
  return rule;
}

std::vector<std::string> usual_looks() {
  return {"100 m, 650 returns, even beyond 30 m, 80 points",
          "100 m, 1000 returns, even beyond 40 m, 80 points",
          "100 m, 1300 returns, even beyond 40 m, 100 points",
          "100 m, 2850 returns, even beyond 50 m, 100 points",
          "100 m, 4000 returns, even beyond 50 m, 256 points",
          "100 m, 6000 returns, even beyond 50 m, 384 points",
          "100 m, 8000 returns, even beyond 50 m, 512 points",
          "100 m, 400 returns, even beyond 20 m, 32 points by normals",
          "100 m, 650 returns, even beyond 30 m, 40 points by normals",
          "100 m, 1000 returns, even beyond 30 m, 64 points by normals",
          "100 m, 1944 returns, even beyond 40 m, 80 points by normals",
          "100 m, 2850 returns, even beyond 40 m, 100 points by normals",
          "100 m, 4000 returns, even beyond 50 m, 128 points by normals",
          "100 m, 6000 returns, even beyond 50 m, 256 points by normals",
          "50 m, 1944 returns, even beyond 50 m, 250 points",
          "50 m, 1944 returns, even beyond 30 m, 80 points by normals"};
}

}  // namespace sightline
