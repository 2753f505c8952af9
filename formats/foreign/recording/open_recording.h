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

// Lists the scans of a folder or of a bag or pcap, gives each a time and a pose, and takes digests
// of all of them on up to `threads` threads (0: all).
//
// Times: the stamps file, by row; else those of the file that holds the scans; else file names that
// are times (15 digits and more, or decimals); else the times of the pose file; else index /
// rate_hz. Poses: Apollo by id = number in the scan's name; TUM by time where the scans have times
// of their own, interpolated between rows at most 1 s apart; all others by row: that of the scan's
// number where there are more rows than scans and names are numbers, else of its position. Warnings
// count rows that no scan uses and scans without a pose of a bag.
//
// Columns of .bin: those of the options, refused where the floats of a scan speak against them;
// else the one count of floats a point that fits all scans, with a warning where it is not 4.
// Turn rates: those of the bag that holds the scans (read_bag_turns), about the vehicle's axes,
// from a second before the first scan to a second behind the last one; none for imu_topic "none".
//
// Errors: file-not-found, cannot-open, cannot-read, empty-directory, mixed-formats, truncated-scan,
// unsupported-format, unknown-name, bad-value, fewer-poses-than-scans, mismatched-inputs, and those
// of read_poses, read_bag_poses, read_stamps and open_scan_container.
// With a memory, files that were not written to since another run opened them are not read.
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

// Reads scans from their files one at a time and checks them again each time, but for those that
// recording.memory still holds; index = position in recording.scans. Point times become offsets
// from the scan's stamp; where they count from a clock of their own (the first point is over 2 s
// from the stamp, or the last one over 2.1 s behind it), the first point is at the stamp. Keeps
// what it needs of the recording.
std::shared_ptr<const ScanStore> recorded_scan_store(const Recording& recording);

// Gives every file a time and, where there are any, a pose, by the rules of open_recording; adds to
// recording.scans and recording.warnings. Part of open_recording.
Result<void> describe_scans(const RecordingOptions& options,
                            const std::vector<std::filesystem::path>& files, Recording& recording);

}  // namespace sightline
