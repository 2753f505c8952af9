#pragma once

#include <string>

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

}  // namespace sightline
