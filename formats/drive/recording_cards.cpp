#include "formats/drive/recording_cards.h"

#include <set>

namespace sightline {
namespace {

Error invalid_card(const RecordingCard& card, const std::string& message) {
  return {ErrorCode::kInvalidArtifact, message, "", concat("recording '", card.role, "'")};
}

}  // namespace

Result<void> validate(const RecordingCards& recordings) {
  if (recordings.cards.empty()) {
    return Error{ErrorCode::kInvalidArtifact, "found no recording, expected at least one"};
  }
  std::set<std::string> roles;
  for (const RecordingCard& card : recordings.cards) {
    if (card.role.empty() || card.name.empty()) {
      return invalid_card(card, "its role or name is empty");
    }
    if (!roles.insert(card.role).second) return invalid_card(card, "its role is listed twice");
    if (card.digest == Digest{}) return invalid_card(card, "its digest is missing");
  }
  return {};
}

Table dump(const RecordingCards& recordings) {
  Table table{"recordings", {"role", "name", "sha256"}, {}, {}};
  for (const RecordingCard& card : recordings.cards) {
    table.rows.push_back({card.role, card.name, to_hex(card.digest)});
  }
  return table;
}

}  // namespace sightline
