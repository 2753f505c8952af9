#include "compiler/pipeline/artifact_set.h"

#include <limits>

#include "formats/base/files/stored_bytes.h"

namespace sightline {

Result<std::shared_ptr<const void>> in_form(const ArtifactSet::Entry& entry,
                                            const ArtifactType& form) {
  if (entry.type == &form) return entry.value;
  SIGHTLINE_CHECK(entry.type->name == form.name && entry.type->write && form.read);
  // Forms are of the same bytes.
  constexpr std::size_t kMostOfForm = std::size_t{4} << 20;
  GrowingBytes bytes(entry.type->is_form ? kMostOfForm : std::numeric_limits<std::size_t>::max());
  SIGHTLINE_TRY(entry.type->write(
      entry.value.get(), [&](std::span<const std::byte> piece) { return bytes.append(piece); }));
  return form.read(bytes.take());
}

}  // namespace sightline
