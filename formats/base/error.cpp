#include "formats/base/error.h"

#include <utility>

#include "formats/base/check.h"

namespace sightline {

const std::vector<ErrorCodeInfo>& all_error_codes() {
  using enum ErrorCode;
  static const std::vector<ErrorCodeInfo> kCodes = {
      {kBadArgument, "bad-argument"},
      {kUnknownKey, "unknown-key"},
      {kBadValue, "bad-value"},
      {kMissingKey, "missing-key"},
      {kOutputExists, "output-exists"},
      {kUnknownPass, "unknown-pass"},
      {kUnknownName, "unknown-name"},
      {kFileNotFound, "file-not-found"},
      {kEmptyDirectory, "empty-directory"},
      {kGitLfsPointer, "git-lfs-pointer"},
      {kUnsupportedFormat, "unsupported-format"},
      {kMalformedHeader, "malformed-header"},
      {kTruncatedScan, "truncated-scan"},
      {kEmptyScan, "empty-scan"},
      {kMissingField, "missing-field"},
      {kMalformedPose, "malformed-pose"},
      {kFewerPosesThanScans, "fewer-poses-than-scans"},
      {kNotARotation, "not-a-rotation"},
      {kTimeRunsBackwards, "time-runs-backwards"},
      {kNoFinitePoints, "no-finite-points"},
      {kDriveTooShort, "drive-too-short"},
      {kNoPoses, "no-poses"},
      {kNoOverlap, "no-overlap"},
      {kTrajectoryLost, "trajectory-lost"},
      {kEmptyMap, "empty-map"},
      {kMixedFormats, "mixed-formats"},
      {kMalformedText, "malformed-text"},
      {kNoTrainingRows, "no-training-rows"},
      {kMismatchedInputs, "mismatched-inputs"},
      {kInvalidArtifact, "invalid-artifact"},
      {kWrongBase, "wrong-base"},
      {kUnlikeProfile, "unlike-profile"},
      {kNoGround, "no-ground"},
      {kTwoFloors, "two-floors"},
      {kTooManyPlaces, "too-many-places"},
      {kKnownDrive, "known-drive"},
      {kFutureVersion, "future-version"},
      {kUnknownRequiredFeature, "unknown-required-feature"},
      {kOldVersion, "old-version"},
      {kBadMagic, "bad-magic"},
      {kTruncatedFile, "truncated-file"},
      {kChecksumMismatch, "checksum-mismatch"},
      {kDigestMismatch, "digest-mismatch"},
      {kOutOfBounds, "out-of-bounds"},
      {kBadManifest, "bad-manifest"},
      {kBadOrder, "bad-order"},
      {kBadLayer, "bad-layer"},
      {kTooLarge, "too-large"},
      {kBadDelta, "bad-delta"},
      {kWrongKey, "wrong-key"},
      {kTooFewSignatures, "too-few-signatures"},
      {kBadSignature, "bad-signature"},
      {kMalformedSignature, "malformed-signature"},
      {kMalformedRecord, "malformed-record"},
      {kUnsafeName, "unsafe-name"},
      {kReplayedRelease, "replayed-release"},
      {kExpired, "expired"},
      {kRootOutOfOrder, "root-out-of-order"},
      {kWrongFleet, "wrong-fleet"},
      {kWrongSensor, "wrong-sensor"},
      {kNotAsReleased, "not-as-released"},
      {kLongerThanReleased, "longer-than-released"},
      {kGateFailed, "gate-failed"},
      {kInterrupted, "interrupted"},
      {kWorkMissing, "work-missing"},
      {kCannotOpen, "cannot-open"},
      {kCannotRead, "cannot-read"},
      {kCannotWrite, "cannot-write"},
      {kDiskFull, "disk-full"},
      {kOutOfMemory, "out-of-memory"},
  };
  return kCodes;
}

std::string_view error_name(ErrorCode code) {
  for (const ErrorCodeInfo& info : all_error_codes()) {
    if (info.code == code) return info.name;
  }
  return "unknown";
}

ErrorClass error_class(ErrorCode code) {
  using enum ErrorClass;
  constexpr ErrorClass kByThousand[] = {kUsage,     kInput, kVersion,   kCorrupt,
                                        kSignature, kGate,  kIncomplete};
  const int thousand = static_cast<int>(code) / 1000;
  return thousand >= 1 && thousand <= 7 ? kByThousand[thousand - 1] : kSystem;
}

int exit_status(ErrorCode code) {
  constexpr int kByClass[] = {64, 65, 66, 67, 68, 69, 75, 74};
  return kByClass[static_cast<std::size_t>(error_class(code))];
}

std::string to_string(const Error& error) {
  std::string text = concat("SL", static_cast<int>(error.code), " ");
  text += error_name(error.code);
  text += ": ";
  if (!error.file.empty()) text += error.file;
  if (!error.place.empty()) text += concat((error.file.empty() ? "(" : " ("), error.place, ")");
  if (!error.file.empty() || !error.place.empty()) text += ": ";
  return text + error.message;
}

Error invalid_artifact(std::string message, std::string place) {
  return {ErrorCode::kInvalidArtifact, std::move(message), "", std::move(place)};
}

Error in_file(Error error, const std::string& path) {
  if (error.file.empty()) error.file = path;
  return error;
}

}  // namespace sightline
