#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "formats/base/concat.h"  // messages are made by it

namespace sightline {

// The class of a failure; it alone decides the exit status of the command (exit_status()).
enum class ErrorClass {
  kUsage,
  kInput,
  kVersion,
  kCorrupt,
  kSignature,
  kGate,
  kIncomplete,
  kSystem
};

// Stable codes, listed with cause and remedy in schemas/error_codes.md. A number is never reused;
// the thousands digit names the class.
enum class ErrorCode : int {
  // 1xxx usage: the command line or the configuration.
  kBadArgument = 1001,
  kUnknownKey = 1002,
  kBadValue = 1003,
  kMissingKey = 1004,
  kOutputExists = 1005,
  kUnknownPass = 1006,
  kUnknownName = 1007,
  // 2xxx input: recordings, poses, anything a user brings.
  kFileNotFound = 2001,
  kEmptyDirectory = 2002,
  kGitLfsPointer = 2003,
  kUnsupportedFormat = 2004,
  kMalformedHeader = 2005,
  kTruncatedScan = 2006,
  kEmptyScan = 2007,
  kMissingField = 2008,
  kMalformedPose = 2009,
  kFewerPosesThanScans = 2010,
  kNotARotation = 2011,
  kTimeRunsBackwards = 2012,
  kNoFinitePoints = 2013,
  kDriveTooShort = 2014,
  kNoPoses = 2015,
  kNoOverlap = 2016,
  kTrajectoryLost = 2017,
  kEmptyMap = 2018,
  kMixedFormats = 2019,
  kMalformedText = 2020,
  kNoTrainingRows = 2021,
  kMismatchedInputs = 2022,
  kInvalidArtifact = 2023,
  kWrongBase = 2024,
  kUnlikeProfile = 2025,
  kNoGround = 2026,
  kTwoFloors = 2027,
  kTooManyPlaces = 2028,
  kKnownDrive = 2029,
  // 3xxx version: written by a program that this one does not understand.
  kFutureVersion = 3001,
  kUnknownRequiredFeature = 3002,
  kOldVersion = 3003,
  // 4xxx corrupt: our own files, damaged.
  kBadMagic = 4001,
  kTruncatedFile = 4002,
  kChecksumMismatch = 4003,
  kDigestMismatch = 4004,
  kOutOfBounds = 4005,
  kBadManifest = 4006,
  kBadOrder = 4007,
  kBadLayer = 4008,
  kTooLarge = 4009,
  kBadDelta = 4010,
  // 5xxx signature: who said so, and is it still said.
  kWrongKey = 5001,
  kTooFewSignatures = 5002,
  kBadSignature = 5003,
  kMalformedSignature = 5004,
  kMalformedRecord = 5005,
  kUnsafeName = 5006,
  kReplayedRelease = 5007,
  kExpired = 5008,
  kRootOutOfOrder = 5009,
  kWrongFleet = 5010,
  kWrongSensor = 5011,
  kNotAsReleased = 5012,
  kLongerThanReleased = 5013,
  // 6xxx gate: the map is not what its rules ask for.
  kGateFailed = 6001,
  // 7xxx incomplete: stopped before the end; what was done is kept.
  kInterrupted = 7001,
  kWorkMissing = 7002,
  // 8xxx system: the machine said no.
  kCannotOpen = 8001,
  kCannotRead = 8002,
  kCannotWrite = 8003,
  kDiskFull = 8004,
  kOutOfMemory = 8005,
};

struct ErrorCodeInfo {
  ErrorCode code;
  std::string_view name;  // "file-not-found"
};

// Every code there is, ascending, as schemas/error_codes.md lists them.
const std::vector<ErrorCodeInfo>& all_error_codes();

std::string_view error_name(ErrorCode code);
ErrorClass error_class(ErrorCode code);

// Process exit status of a failure: usage 64, input 65, version 66, corrupt 67, signature 68,
// gate 69, incomplete 75, system 74. (`diff` alone uses 0, 1, 2.)
int exit_status(ErrorCode code);

// What went wrong, and where. `file` is a path or empty; `place` is "byte 128", "line 7",
// "pass build-ndt", "tile 3,-1" or empty.
struct Error {
  ErrorCode code{};
  std::string message;  // what was found and what was expected, one sentence without a full stop
  std::string file = {};
  std::string place = {};
};

// "SL2006 truncated-scan: drive/0001.pcd (byte 4096): message"
std::string to_string(const Error& error);

// kInvalidArtifact: an artifact holds what cannot be, at `place` of it ("": the whole).
Error invalid_artifact(std::string message, std::string place);

// The same error, of a file where it names none yet.
Error in_file(Error error, const std::string& path);

}  // namespace sightline
