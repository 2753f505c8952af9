#include "formats/model/stored_error_model.h"

#include <optional>
#include <utility>

namespace sightline {

Result<void> validate(const StoredErrorModel& model) { return validate(model.head.card.localizer); }

Table dump(const StoredErrorModel& model) {
  Table table;
  table.name = "error-model";
  table.facts = card_facts(model.head, model.training_row_count).facts;
  return table;
}

std::uint64_t payload_size(const StoredErrorModel& model) { return model.payload.size(); }

Result<void> visit_payload(const StoredErrorModel& model, const ByteSink& sink) {
  return model.payload.visit(sink);
}

Result<void> open_payload(const StoredBytes& payload, StoredErrorModel& model) {
  StoredErrorModel opened;
  const auto decode = [&](ByteReader& reader) {
    opened.head = ErrorModel();
    decode_head(reader, opened.head);
    reader.get(opened.training_row_count);
  };
  SIGHTLINE_ASSIGN(const std::optional<std::uint64_t> begin, decode_front(payload, decode));
  if (!begin || opened.training_row_count > (payload.size() - *begin) / sizeof(double)) {
    return Error{ErrorCode::kBadLayer, "the payload of an error-model cannot be decoded"};
  }
  opened.payload = payload;
  SIGHTLINE_TRY(validate(opened));
  model = std::move(opened);
  return {};
}

}  // namespace sightline
