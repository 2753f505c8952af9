#include "compiler/driver/known_drive.h"

#include <algorithm>
#include <optional>

#include "compiler/config/inputs.h"
#include "formats/drive/shared_scans.h"

namespace sightline {
namespace {

// Of a finished map nothing is recorded.
bool is_of_file(const RecordingCard& card) { return card.role == "map" || card.role == "base"; }

bool lists_scans(const RecordingCards& recordings) {
  return std::ranges::all_of(recordings.cards, [](const RecordingCard& card) {
    return is_of_file(card) || !card.scans.empty();
  });
}

// "60 of 60 scans of 'drive 2' are copies of scans of 'north'"
std::string copies_text(const RecordingCard& drive, const RecordingCard& other) {
  if (other.scans.empty()) return concat("'", drive.name, "' is the recording '", other.name, "'");
  return concat(shared_count(drive, other), " of ", drive.scans.size(), " scans of '", drive.name,
                "' are copies of scans of '", other.name, "'");
}

std::string use_of(const RecordingCard& card) {
  return card.role.starts_with("map") ? ", which made the map"
                                      : ", whose errors were measured in the map";
}

// What the drive is to the map; nothing: it is another one.
std::optional<std::string> known_to_map(const RecordingCard& drive,
                                        const RecordingCards& recordings) {
  for (const RecordingCard& card : recordings.cards) {
    if (have_common_scans(drive, card)) return copies_text(drive, card) + use_of(card);
  }
  return std::nullopt;
}

std::optional<std::string> known_to_model(const RecordingCard& drive, const TrainingCard& model,
                                          const RecordingCards& own) {
  for (const PlaceCard& place : model.places) {
    for (const RecordingCard& card : place.recordings.cards) {
      const bool is_own =
          std::ranges::find(own.cards, card.digest, &RecordingCard::digest) != own.cards.end();
      if (is_own || !have_common_scans(drive, card)) continue;
      return concat(copies_text(drive, card), ", on which the map's model was trained (place '",
                    place.name, "')");
    }
  }
  return std::nullopt;
}

// The drive is, scan by scan, the one recording whose even scans made the map.
bool is_split_drive(const RecordingCard& drive, const EvaluatePlan& evaluate,
                    const RecordingCards& recordings) {
  if (!evaluate.judges_other_scans) return false;
  std::size_t known = 0;
  bool is_same = false;
  for (const RecordingCard& card : recordings.cards) {
    if (!have_common_scans(drive, card)) continue;
    ++known;
    is_same = card.scans == drive.scans;
  }
  return known == 1 && is_same;
}

}  // namespace

Result<KnownDrive> known_drive(const CompiledMap& map, const CompileConfig& config,
                               const EvaluatePlan& evaluate, const ArtifactSet& artifacts) {
  const RecordingCard& drive = artifacts.get(evaluate.identified).cards.front();
  const RecordingCards own = map.recordings.value_or(RecordingCards{});
  TrainingCard trained;
  if (!map.model.bytes.empty()) {
    // That of a map of an earlier program cannot be read, and its origin is unknown.
    const Result<ByFamily<ErrorModel>> model = model_of(map.model);
    const bool is_of_another_program =
        !model && error_class(model.error().code) == ErrorClass::kVersion;
    if (!model && !is_of_another_program) return model.error();
    if (model) trained = model->ranges.card;
  }
  std::optional<std::string> why = known_to_model(drive, trained, own);
  if (!why && is_split_drive(drive, evaluate, own)) return KnownDrive{DriveOrigin::kOtherScans, ""};
  if (!why) why = known_to_map(drive, own);
  if (!why && !map.recordings && is_known_evaluation(config)) {
    if (evaluate.judges_other_scans) return KnownDrive{DriveOrigin::kOtherScans, ""};
    why = concat("'", drive.name, "' is a mapping or localization drive of the configuration");
  }
  if (why) return KnownDrive{DriveOrigin::kKnown, *why};
  if (!map.recordings || !lists_scans(own)) {
    return KnownDrive{DriveOrigin::kUnknown, "the map does not list the scans it was made from"};
  }
  const bool is_traced =
      !trained.places.empty() && std::ranges::all_of(trained.places, [](const PlaceCard& place) {
        return lists_scans(place.recordings);
      });
  if (is_traced) return KnownDrive{};
  return KnownDrive{DriveOrigin::kUnknown,
                    "the map's model does not list the scans that it was trained on"};
}

}  // namespace sightline
