#include "formats/model/error_model_at_rest.h"

#include <optional>
#include <utility>

#include "formats/annotation/of_samples.h"

namespace sightline {

Result<void> validate(const ErrorModelAtRest& model) { return validate(model.head.card.localizer); }

Table dump(const ErrorModelAtRest& model) {
  Table table;
  table.name = "error-model";
  table.facts = card_facts(model.head, model.training_row_count);
  return table;
}

std::uint64_t payload_size(const ErrorModelAtRest& model) { return model.payload.size(); }

Result<void> visit_payload(const ErrorModelAtRest& model, const ByteSink& sink) {
  return model.payload.visit(sink);
}

Result<void> open_payload(const StoredBytes& payload, ErrorModelAtRest& model) {
  std::uint64_t offset = 0;
  ErrorModelAtRest opened;
  SIGHTLINE_ASSIGN(const std::optional<std::uint64_t> rows,
                   read_head(payload, offset, opened.head, sizeof(double)));
  if (!rows) {
    return Error{ErrorCode::kBadLayer, "the payload of an error-model cannot be decoded"};
  }
  opened.training_row_count = *rows;
  opened.payload = payload;
  SIGHTLINE_TRY(validate(opened));
  model = std::move(opened);
  return {};
}

}  // namespace sightline
