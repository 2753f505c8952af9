#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/recording/recording.h"
#include "formats/foreign/recording/same_recording.h"

namespace sightline {

// Lists the scans of a folder, bag or pcap, each with a time and a pose, and takes digests of all
// on up to `threads` threads (0: all). With a memory, files that were not written to since another
// run opened them are not read.
// Times: the stamps file, by row; else those of the file that holds the scans; else file names that
// are times (15 digits and more, or decimals); else those of the pose file; else index / rate_hz.
// Poses: Apollo by id = number in the scan's name; TUM by time where the scans have times of their
// own, interpolated between rows at most 1.5 s apart; others by row: that of the scan's number
// where there are more rows than scans and names are numbers, else of its position. Warnings count
// rows that no scan uses and scans that are left out (left_out_scans.h). Columns of .bin: those of
// the options, refused where the floats of a scan contradict them; else the one count of floats a
// point that fits all scans, with a warning where it is not 4. Inertial unit and wheels: those of
// the scans' bag (vehicle_sensors.h). Errors: file-not-found, cannot-open, cannot-read,
// empty-directory, mixed-formats, truncated-scan, unsupported-format, unknown-name, bad-value,
// fewer-poses-than-scans, mismatched-inputs, and those of read_poses, read_bag_poses, read_stamps
// and open_scan_container.
Result<Recording> open_recording(const RecordingOptions& options, int threads = 1,
                                 const DigestMemory* memory = nullptr);

// The same without digests, so that no scan file is read: what there is, when and from where.
// read_recorded_scan cannot read from it.
Result<Recording> list_recording(const RecordingOptions& options);

// One scan with its counts, read from its file. Errors: those of read_point_cloud, and
// mismatched-inputs where the file is not the one that was opened.
Result<PointCloudFile> read_recorded_scan(const Recording& recording, std::size_t index);

// The scan as it lies there now, whether or not it is the one that was opened. Errors: those of
// read_point_cloud.
Result<PointCloudFile> read_listed_scan(const Recording& recording, std::size_t index);

// Reads scans one at a time and checks their files again each time, except those that
// recording.memory holds; index = position in recording.scans. Point times are offsets from the
// scan's stamp (settle_point_times). Keeps what it needs of the recording.
std::shared_ptr<const ScanStore> recorded_scan_store(const Recording& recording);

// Gives every file a time and, where there are any, a pose, by the rules of open_recording; adds to
// recording.scans and recording.warnings. Part of open_recording.
Result<void> describe_scans(const RecordingOptions& options,
                            const std::vector<std::filesystem::path>& files, Recording& recording);

}  // namespace sightline
