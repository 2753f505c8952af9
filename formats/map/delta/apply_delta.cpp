#include "formats/map/delta/apply_delta.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

#include "formats/base/hash.h"
#include "formats/map/delta/delta_steps.h"
#include "formats/map/delta/make_delta.h"
#include "formats/map/delta/map_digest_check.h"
#include "formats/map/delta/part_file.h"
#include "formats/reader/mapped_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

Error failure(ErrorCode code, const fs::path& path, const char* what, int number) {
  return {code, concat(what, ": ", std::strerror(number)), path.string()};
}

Result<void> check_base(const OpenedDelta& delta, const fs::path& map) {
  SIGHTLINE_ASSIGN(const MappedFile file, MappedFile::open(map.string()));
  const Result<MapIdentity> found = identity_of(file.bytes());
  if (!found) return in_file(found.error(), map.string());
  const MapIdentity& expected = delta.header.base;
  if (*found == expected) return {};
  const bool is_other_packing = found->root_digest == expected.root_digest;
  return Error{ErrorCode::kWrongBase,
               is_other_packing
                   ? "the delta is for the same map with other optional parts or another packing"
                   : "found the map " + to_hex(found->root_digest) + ", the delta is for " +
                         to_hex(expected.root_digest),
               map.string()};
}

Result<bool> is_result(const OpenedDelta& delta, const fs::path& map) {
  SIGHTLINE_ASSIGN(const PieceReader file, PieceReader::open(map));
  if (file.size() != delta.header.result_size) return false;
  Sha256Stream digest;
  for (std::uint64_t offset = 0; offset < file.size(); offset += kLargestStep) {
    SIGHTLINE_ASSIGN(const std::vector<std::byte> piece,
                     file.read(offset, std::min(kLargestStep, file.size() - offset)));
    digest.add(piece);
  }
  return digest.finish() == delta.header.result_sha256;
}

Result<void> check_room(const OpenedDelta& delta, const fs::path& part) {
  struct statvfs room {};
  const fs::path folder = part.has_parent_path() ? part.parent_path() : ".";
  if (::statvfs(folder.c_str(), &room) != 0) return {};  // the write will tell
  struct stat there {};
  const bool exists = ::lstat(part.c_str(), &there) == 0 && S_ISREG(there.st_mode);
  const std::uint64_t have = std::uint64_t{room.f_bavail} * room.f_frsize +
                             (exists ? static_cast<std::uint64_t>(there.st_size) : 0);
  if (have >= delta.header.result_size) return {};
  return Error{ErrorCode::kDiskFull,
               concat("the result needs ", delta.header.result_size, " bytes, but free are ", have),
               part.string()};
}

// Makes all of the result in the part, checks it, and leaves it there on the disk.
Result<ApplyReport> make_part(const OpenedDelta& delta, const fs::path& map, const fs::path& part,
                              PartFile& file) {
  SIGHTLINE_TRY(check_room(delta, part));
  SIGHTLINE_ASSIGN(const PieceReader base, PieceReader::open(map));
  Sha256Stream digest;
  ApplyReport report;
  std::uint64_t payload = kDeltaHeaderSize + delta.steps.size() * kDeltaStepSize;
  for (const DeltaStep& step : delta.steps) {
    SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, make_step(delta, base, step, payload));
    digest.add(bytes);
    SIGHTLINE_TRY(file.put(bytes));
    payload += step.packed_size;
    if (step.kind == DeltaStepKind::kCopy) report.copied_bytes += step.size;
  }
  SIGHTLINE_TRY(file.finish());
  if (digest.finish() != delta.header.result_sha256) {
    return Error{ErrorCode::kDigestMismatch, "the steps do not produce the map of the delta",
                 delta.file.path().string(), "byte 128"};
  }
  SIGHTLINE_ASSIGN(const Digest root, check_map_digests(part));
  if (root != delta.header.result_root) {
    return Error{ErrorCode::kDigestMismatch, "the result has another root digest than the delta",
                 delta.file.path().string(), "byte 96"};
  }
  report.root_digest = root;
  report.result_size = delta.header.result_size;
  report.kept_bytes = file.kept();
  return report;
}

// Kept, where a later attempt may continue: the system failed, not the delta.
Result<ApplyReport> make_part_or_discard(const OpenedDelta& delta, const fs::path& map,
                                         const fs::path& part, PartFile& file) {
  Result<ApplyReport> made = make_part(delta, map, part, file);
  if (!made && error_class(made.error().code) != ErrorClass::kSystem) file.discard();
  return made;
}

Result<void> refuse_link(const fs::path& map) {
  struct stat status {};
  if (::lstat(map.c_str(), &status) != 0) {
    return failure(errno == ENOENT ? ErrorCode::kFileNotFound : ErrorCode::kCannotOpen, map,
                   "cannot open", errno);
  }
  if (S_ISREG(status.st_mode)) return {};
  return Error{ErrorCode::kCannotOpen, "not a regular file; name the map itself, not a link",
               map.string()};
}

Result<void> rename_file(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) {
    return failure(ErrorCode::kCannotWrite, to, "cannot rename the finished file to its name",
                   errno);
  }
  const fs::path folder = to.has_parent_path() ? to.parent_path() : ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return {};  // some file systems cannot sync a folder
  (void)::fsync(descriptor);
  ::close(descriptor);
  return {};
}

// The map gets a second name before the part takes its first one.
Result<void> put_in_place(const fs::path& part, const fs::path& map) {
  const fs::path third = map.string() + ".keep";
  if (::unlink(third.c_str()) != 0 && errno != ENOENT) {
    return failure(ErrorCode::kCannotWrite, third, "cannot remove", errno);
  }
  if (::link(map.c_str(), third.c_str()) != 0) {
    return failure(ErrorCode::kCannotWrite, third, "cannot link the map to a second name", errno);
  }
  const Result<void> kept = rename_file(third, previous_path(map));
  // Where both were names of one file already, rename does nothing.
  (void)::unlink(third.c_str());
  if (!kept) return kept;
  return rename_file(part, map);
}

// Nothing to do where the map is the result already; else what the check of the base said.
Result<ApplyReport> report_done(const OpenedDelta& delta, const fs::path& map, const Error& error) {
  const Result<bool> is_done = is_result(delta, map);
  if (!is_done || !*is_done) return error;
  ApplyReport report;
  report.was_there = true;
  report.root_digest = delta.header.result_root;
  report.result_size = delta.header.result_size;
  return report;
}

// With the part locked from the check of the base to the last rename: another process would write
// into the very file that has become the map, or on a base that is no longer there.
Result<ApplyReport> apply_locked(const OpenedDelta& delta, const fs::path& map, PartFile& part) {
  const Result<void> base = check_base(delta, map);
  if (!base) return report_done(delta, map, base.error());
  SIGHTLINE_ASSIGN(ApplyReport report, make_part_or_discard(delta, map, part_path(map), part));
  SIGHTLINE_TRY(put_in_place(part_path(map), map));
  return report;
}

}  // namespace

fs::path part_path(const fs::path& map) { return map.string() + ".part"; }
fs::path previous_path(const fs::path& map) { return map.string() + ".previous"; }

Result<ApplyReport> apply_delta(const fs::path& delta_path, const fs::path& map) {
  SIGHTLINE_ASSIGN(const OpenedDelta delta, open_delta(delta_path));
  SIGHTLINE_TRY(refuse_link(map));
  // Nothing is written where the delta is for another map.
  const Result<void> base = check_base(delta, map);
  if (!base) return report_done(delta, map, base.error());
  SIGHTLINE_ASSIGN(PartFile part, PartFile::open(part_path(map)));
  return apply_locked(delta, map, part);
}

Result<ApplyReport> apply_delta_to(const fs::path& delta_path, const fs::path& map,
                                   const fs::path& out) {
  SIGHTLINE_ASSIGN(const OpenedDelta delta, open_delta(delta_path));
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(out, ignored))) {
    return Error{ErrorCode::kOutputExists, "the output exists already", out.string()};
  }
  SIGHTLINE_TRY(check_base(delta, map));
  SIGHTLINE_ASSIGN(PartFile part, PartFile::open(part_path(out)));
  SIGHTLINE_ASSIGN(ApplyReport report, make_part_or_discard(delta, map, part_path(out), part));
  SIGHTLINE_TRY(rename_file(part_path(out), out));
  return report;
}

Result<Digest> roll_back(const fs::path& map) {
  const fs::path previous = previous_path(map);
  if (const Result<void> refused = refuse_link(previous); !refused) {
    // A rollback that was killed behind its rename left the empty file that it had locked.
    std::error_code failure;
    if (fs::exists(part_path(map), failure)) (void)PartFile::open(part_path(map));
    return refused.error();
  }
  SIGHTLINE_ASSIGN(const PartFile part, PartFile::open(part_path(map)));
  SIGHTLINE_ASSIGN(Digest root, check_map_digests(previous));
  SIGHTLINE_TRY(rename_file(previous, map));
  return root;
}

}  // namespace sightline
