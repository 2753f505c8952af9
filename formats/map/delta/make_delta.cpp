#include "formats/map/delta/make_delta.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <string>

#include "formats/base/bytes.h"
#include "formats/map/delta/delta_steps.h"
#include "formats/map/delta/map_digest_check.h"
#include "formats/reader/map_container.h"
#include "formats/reader/mapped_file.h"
#include "map_generated.h"

namespace sightline {
namespace {

using Bytes = std::span<const std::byte>;
using Blocks = flatbuffers::Vector<flatbuffers::Offset<schema::Block>>;

// Larger parts are cut, so that a step and its prefix stay within the format's bounds. A prefix
// then begins before the piece: what was inserted since moves the old bytes.
constexpr std::uint64_t kPiece = std::uint64_t{2} << 20;
constexpr std::uint64_t kPrefixLead = std::uint64_t{1} << 20;

// A run of a file from the beginning of one thing to that of the next, gap included.
struct Part {
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
  const schema::Block* block = nullptr;
};
using Parts = std::map<std::string, Part>;

void add_blocks(const Blocks& blocks, const std::string& owner,
                std::map<std::uint64_t, std::pair<std::string, const schema::Block*>>& starts) {
  for (const schema::Block* block : blocks) {
    starts[block->offset()] = {owner + block->name()->str(), block};
  }
}

// Every byte of a map lies in one part. Equal names are the same thing in two maps.
Parts parts_of(const MapContainer& map) {
  std::map<std::uint64_t, std::pair<std::string, const schema::Block*>> starts;
  for (const schema::Tile* tile : *map.directory->tiles()) {
    add_blocks(*tile->layers(), concat(tile->x(), ",", tile->y(), "/"), starts);
  }
  add_blocks(*map.directory->sections(), "section/", starts);
  starts[0] = {"header", nullptr};
  starts[map.header.manifest_offset] = {"manifest", nullptr};
  starts[map.header.directory_offset] = {"directory", nullptr};
  starts[map.file.size() - kTrailerSize] = {"trailer", nullptr};
  Parts parts;
  for (auto start = starts.begin(); start != starts.end(); ++start) {
    const auto next = std::next(start);
    const std::uint64_t end = next == starts.end() ? map.file.size() : next->first;
    parts[start->second.first] = {start->first, end - start->first, start->second.second};
  }
  return parts;
}

// Finds the cheapest way to send a piece, and keeps its payload.
class DeltaMaker {
 public:
  DeltaMaker(Bytes base, Bytes result, const DeltaOptions& options)
      : base_(base), result_(result), options_(options) {}

  void add(const Part& part, const std::optional<Part>& old);
  std::vector<DeltaStep> steps;
  std::vector<std::byte> payloads;
  bool repacks = false;

 private:
  bool add_copy(Bytes piece, std::uint64_t base_offset);
  bool add_repack(const Part& part, const Part& old, std::size_t size_without);
  void add_packed(Bytes piece, const std::vector<std::byte>& packed,
                  const std::vector<std::byte>& patched, std::uint64_t base_offset,
                  std::uint64_t base_size);
  void push(DeltaStep step, Bytes piece, Bytes payload);

  Bytes base_;
  Bytes result_;
  DeltaOptions options_;
  std::uint64_t copied_to_ = 0;
};

void DeltaMaker::push(DeltaStep step, Bytes piece, Bytes payload) {
  step.size = piece.size();
  step.checksum = xxh3(piece);
  step.packed_size = payload.size();
  if (!payload.empty()) step.packed_checksum = xxh3(payload);
  steps.push_back(step);
  payloads.insert(payloads.end(), payload.begin(), payload.end());
}

// Joined to the copy before it where they are one run of both files.
bool DeltaMaker::add_copy(Bytes piece, std::uint64_t base_offset) {
  if (base_offset < copied_to_ || base_offset + piece.size() > base_.size()) return false;
  if (std::memcmp(base_.data() + base_offset, piece.data(), piece.size()) != 0) return false;
  const bool joins = !steps.empty() && steps.back().kind == DeltaStepKind::kCopy &&
                     base_offset == copied_to_ && steps.back().size + piece.size() <= kLargestStep;
  copied_to_ = base_offset + piece.size();
  if (joins) {
    DeltaStep& step = steps.back();
    step.size = step.base_size = step.size + piece.size();
    step.checksum = xxh3(base_.subspan(step.base_offset, step.size));
    return true;
  }
  push({DeltaStepKind::kCopy, 0, base_offset, piece.size(), 0, 0, 0}, piece, {});
  return true;
}

// The plainest way that costs at most a sixteenth more than the cheapest.
void DeltaMaker::add_packed(Bytes piece, const std::vector<std::byte>& packed,
                            const std::vector<std::byte>& patched, std::uint64_t base_offset,
                            std::uint64_t base_size) {
  const std::size_t packed_size = std::min(packed.size(), piece.size());
  if (base_size > 0 && patched.size() + packed_size / 16 < packed_size) {
    push({DeltaStepKind::kPatch, 0, base_offset, base_size, 0, 0, 0}, piece, patched);
  } else if (packed.size() + piece.size() / 16 < piece.size()) {
    push({DeltaStepKind::kPacked, 0, 0, 0, 0, 0, 0}, piece, packed);
  } else {
    push({DeltaStepKind::kPlain, 0, 0, 0, 0, 0, 0}, piece, piece);
  }
}

// Both blocks are zstd frames: what they hold is nearer to each other than the frames are.
bool DeltaMaker::add_repack(const Part& part, const Part& old, std::size_t size_without) {
  if (options_.is_portable || part.block == nullptr || old.block == nullptr) return false;
  const auto is_small = [](const schema::Block& block) {
    return block.codec() == schema::Codec::Zstd && block.raw_size() <= kLargestRepack &&
           block.stored_size() <= kLargestPrefix;
  };
  if (!is_small(*part.block) || !is_small(*old.block) || part.size > kLargestStep) return false;
  const Bytes new_frame = result_.subspan(part.offset, part.block->stored_size());
  const Bytes old_frame = base_.subspan(old.offset, old.block->stored_size());
  const Result<std::vector<std::byte>> raw = unpack_delta(new_frame, {}, part.block->raw_size());
  const Result<std::vector<std::byte>> prefix = unpack_delta(old_frame, {}, old.block->raw_size());
  if (!raw || !prefix) return false;
  const std::vector<std::byte> packed = pack_delta(*raw, *prefix);
  const bool pays = packed.size() + size_without / 16 < size_without;
  // Maps from another version of zstd, or another program, are packed in another way.
  if (!pays || !std::ranges::equal(pack_anew(*raw, kRepackLevel), new_frame)) return false;
  const Bytes piece = result_.subspan(part.offset, part.size);
  const auto is_zero = [](std::byte byte) { return byte == std::byte{0}; };
  const Bytes gap = piece.subspan(new_frame.size());
  if (!std::all_of(gap.begin(), gap.end(), is_zero)) return false;
  push({DeltaStepKind::kRepack, 0, old.offset, old_frame.size(), 0, 0, 0}, piece, packed);
  repacks = true;
  return true;
}

void DeltaMaker::add(const Part& part, const std::optional<Part>& old) {
  for (std::uint64_t begin = 0; begin < part.size; begin += kPiece) {
    const std::uint64_t size = std::min(kPiece, part.size - begin);
    const Bytes piece = result_.subspan(part.offset + begin, size);
    if (old && begin < old->size && add_copy(piece, old->offset + begin)) continue;
    const std::vector<std::byte> packed = pack_delta(piece, {});
    std::uint64_t prefix_offset = 0;
    std::uint64_t prefix_size = 0;
    std::vector<std::byte> patched;
    if (old) {
      const std::uint64_t lead = std::min(begin, kPrefixLead);
      prefix_offset = old->offset + std::min(begin - lead, old->size);
      prefix_size = std::min(kLargestPrefix, old->offset + old->size - prefix_offset);
      if (prefix_size > 0) patched = pack_delta(piece, base_.subspan(prefix_offset, prefix_size));
    }
    if (old && begin == 0 && size == part.size) {
      std::size_t cheapest = std::min(packed.size(), piece.size());
      if (prefix_size > 0) cheapest = std::min(cheapest, patched.size());
      if (add_repack(part, *old, cheapest)) continue;
    }
    add_packed(piece, packed, patched, prefix_offset, prefix_size);
  }
}

Result<std::vector<std::byte>> finished(const DeltaMaker& maker, const MapContainer& base,
                                        const MapContainer& result) {
  if (maker.steps.size() > kMostSteps || result.file.size() > kLargestResult) {
    return Error{ErrorCode::kTooLarge, concat("a delta of ", maker.steps.size(), " steps for ",
                                              result.file.size(), " bytes; send the whole map")};
  }
  DeltaHeader header;
  SIGHTLINE_ASSIGN(header.base, identity_of(base.file));
  header.result_size = result.file.size();
  header.result_root = result.header.root_digest;
  header.result_sha256 = sha256(result.file);
  header.zstd_version = maker.repacks ? zstd_version() : 0;
  header.zstd_level = maker.repacks ? kRepackLevel : 0;
  std::vector<std::byte> file = encode_delta_front(header, maker.steps);
  file.insert(file.end(), maker.payloads.begin(), maker.payloads.end());
  return file;
}

}  // namespace

Result<MapIdentity> identity_of(std::span<const std::byte> file) {
  SIGHTLINE_ASSIGN(const FileHeader header, decode_header(file));
  MapIdentity identity;
  identity.size = header.file_size;
  identity.root_digest = header.root_digest;
  ByteReader(file.subspan(kHeaderSize - 8, 8)).get(identity.header_checksum);
  return identity;
}

Result<std::vector<std::byte>> make_delta(std::span<const std::byte> base,
                                          std::span<const std::byte> result,
                                          const DeltaOptions& options) {
  SIGHTLINE_ASSIGN(const MapContainer old_map, open_container(base));
  SIGHTLINE_ASSIGN(const MapContainer new_map, open_container(result));
  const Parts old_parts = parts_of(old_map);
  std::map<std::uint64_t, std::pair<Part, std::optional<Part>>> in_order;
  for (const auto& [name, part] : parts_of(new_map)) {
    const auto old = old_parts.find(name);
    in_order[part.offset] = {
        part, old == old_parts.end() ? std::nullopt : std::optional<Part>(old->second)};
  }
  DeltaMaker maker(base, result, options);
  for (const auto& [offset, parts] : in_order) maker.add(parts.first, parts.second);
  return finished(maker, old_map, new_map);
}

Result<std::vector<std::byte>> make_delta(const std::filesystem::path& base,
                                          const std::filesystem::path& result,
                                          const DeltaOptions& options) {
  SIGHTLINE_TRY(check_map_digests(base));
  SIGHTLINE_TRY(check_map_digests(result));
  SIGHTLINE_ASSIGN(const MappedFile old_file, MappedFile::open(base.string()));
  SIGHTLINE_ASSIGN(const MappedFile new_file, MappedFile::open(result.string()));
  return make_delta(old_file.bytes(), new_file.bytes(), options);
}

}  // namespace sightline
