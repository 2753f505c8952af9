#pragma once

#include <functional>
#include <string>

namespace sightline {

// What some file systems cannot do (FUSE, SMB, NFS without locks), and a file is written without.
enum class FileSystemGap { kSync, kRenameWithoutReplacing, kLock };

// Whether a call that failed with this errno is not supported there, and is done without.
bool is_gap(FileSystemGap gap, int number);

// Sends the receiver a message that names the file and the consequence: the first time in this
// process for each kind of gap.
void report_gap(FileSystemGap gap, const std::string& path, int number);

// The receiver of the messages, for the whole process; none at first.
void receive_gaps(std::function<void(const std::string& message)> receiver);

}  // namespace sightline
