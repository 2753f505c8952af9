#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "formats/base/files/stored_bytes.h"
#include "formats/base/hash.h"
#include "formats/base/result.h"

namespace sightline {

// What an object of the store is: made by whom ("build-ndt", "measure-error part 12"), from what.
struct ObjectName {
  std::string kind;
  Digest key{};
  friend bool operator==(const ObjectName&, const ObjectName&) = default;
};

struct SealedObject {
  ObjectName name;
  StoredBytes content;  // within the sealed bytes
};

// A sealed object, piece by piece: the content, then the kind, then little-endian the key, u64
// length of the content, u32 length of the kind, SHA-256 of all before it, magic "SLO\x1a". It
// shows damage, and objects that lie where others belong; who may write to the store can seal
// anything. Errors: those of the content and of the sink.
Result<void> write_sealed(const ObjectName& name, const WriteInto& content, const ByteSink& sink);

// Reads all of it once. Errors: bad-magic, out-of-bounds, digest-mismatch, cannot-read.
Result<SealedObject> open_object(const StoredBytes& sealed);

// Finished artifacts on disk, by the key of the pass that made them, and for each pass a record of
// what its last key was made of, so that a rebuild can be explained. Files appear whole or not at
// all, so that a cache survives any interruption and processes may share it without locks; only
// leftovers of ended processes are deleted (formats/base/files/temporary_name.h). Each object
// contains its name, and is refused under another one.
class ArtifactCache {
 public:
  // An empty directory name keeps nothing.
  explicit ArtifactCache(std::filesystem::path directory);
  // One that is only asked what it holds: it removes nothing either.
  static ArtifactCache to_look_at(std::filesystem::path directory);

  // `pass` may have a label, as steps do ("ingest:mapping"). Steps of one pass share their objects,
  // so that equal keys are found under any label; each step has a record of its own.

  // Whether there is a file of that name; load() checks whether it is whole.
  [[nodiscard]] bool has(const std::string& pass, const Digest& key) const;

  // What was stored, or nothing: in memory, or checked and still in its file. Errors, which cost no
  // more than making it again: those of open_object(); bad-layer (another object lies there);
  // cannot-open, cannot-read.
  using Content = std::optional<std::vector<std::byte>>;
  [[nodiscard]] Result<Content> load(const std::string& pass, const Digest& key) const;
  [[nodiscard]] Result<std::optional<StoredBytes>> open(const std::string& pass,
                                                        const Digest& key) const;
  [[nodiscard]] Result<void> store(const std::string& pass, const Digest& key,
                                   std::span<const std::byte> content) const;
  [[nodiscard]] Result<void> store(const std::string& pass, const Digest& key,
                                   const WriteInto& content) const;

  // What a run counts on without loading it is used too: its files are as if written now, so that
  // they outlive prune_cache(). Where that is not allowed nothing is lost but time.
  void mark_used(const std::string& pass, const Digest& key) const;

  // Parts of artifacts, each by a key of its own, since artifacts of two keys may have parts in
  // common: in a folder of the pass. A part that cannot be kept is made again by the next run, so
  // that is not reported.
  [[nodiscard]] Result<Content> load_part(const std::string& pass, const Digest& part) const;
  void store_part(const std::string& pass, const Digest& part,
                  std::span<const std::byte> content) const;
  // The keys of the parts of an artifact, as its pass reported them before it made them: some at
  // once, the number-th time, in a file of its own that no later one replaces. And how many of all
  // are there, each counted once; nothing where it did not begin.
  void store_part_list(const std::string& pass, const Digest& key, std::span<const Digest> parts,
                       std::size_t number = 0) const;
  struct PartCount {
    std::size_t there = 0;
    std::size_t all = 0;
  };
  [[nodiscard]] std::optional<PartCount> part_count(const std::string& pass,
                                                    const Digest& key) const;

  // What a pass had to say when it made an artifact; nothing where there is none or it is damaged.
  [[nodiscard]] Result<void> store_warnings(const std::string& pass, const Digest& key,
                                            const std::vector<std::string>& warnings) const;
  [[nodiscard]] std::vector<std::string> load_warnings(const std::string& pass,
                                                       const Digest& key) const;

  // Lines "name = value" that made the last key of this pass; empty where it never ran.
  [[nodiscard]] std::string last_record(const std::string& pass) const;
  [[nodiscard]] Result<void> store_record(const std::string& pass, const std::string& record) const;

  [[nodiscard]] bool is_enabled() const { return !directory_.empty(); }

  // Whether files can be made in its folder, or the folder itself. Errors: cannot-write.
  [[nodiscard]] Result<void> check_writable() const;

 private:
  ArtifactCache() = default;
  std::filesystem::path directory_;
};

// Where an object of this name lies in a cache, relative to its folder.
std::filesystem::path place_of(const ObjectName& name);
// Of the parts that a list of parts names; none where it is none.
std::vector<std::filesystem::path> places_of_parts(const ObjectName& list,
                                                   std::span<const std::byte> content);

}  // namespace sightline
