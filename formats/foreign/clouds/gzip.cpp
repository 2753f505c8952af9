#include "formats/foreign/clouds/cloud_parsers.h"

#include <zlib.h>

#include <algorithm>
#include <limits>

// A gzip file is one member or several, one after the other; what they hold belongs together (RFC
// 1952, 2.2). Behind the last one gzip itself passes over zeros, as tapes leave them, and warns of
// anything else. Here anything else is refused: it may be a member whose first bytes are damaged,
// and then points are missing.

namespace sightline {
namespace {

constexpr std::size_t kMost = std::size_t{1} << 30U;
// inflateInit2: 15 bits of window, and 16 asks for a gzip header.
constexpr int kGzipWindow = 15 + 16;

// Unpacks member after member.
class Unpacker {
 public:
  explicit Unpacker(const FileBytes& file) : file_(file) {
    SIGHTLINE_CHECK(inflateInit2(&stream_, kGzipWindow) == Z_OK);
  }
  ~Unpacker() { inflateEnd(&stream_); }
  Unpacker(const Unpacker&) = delete;
  Unpacker& operator=(const Unpacker&) = delete;

  [[nodiscard]] std::string_view rest() const { return file_.text().substr(read_); }
  std::vector<std::byte> take() { return std::move(bytes_); }

  // Appends what one member holds.
  Result<void> add_member() {
    SIGHTLINE_CHECK(inflateReset(&stream_) == Z_OK);
    int status = Z_OK;
    while (status == Z_OK && bytes_.size() <= kMost) status = step();
    if (bytes_.size() > kMost) {
      return file_.error(ErrorCode::kUnsupportedFormat,
                         "unpacks to more than 1 GiB, expected a single scan", at_byte(0));
    }
    if (status == Z_STREAM_END) return {};
    return file_.error(ErrorCode::kTruncatedScan, "the gzip stream is cut or damaged",
                       at_byte(read_));
  }

 private:
  // Through a buffer of its own: a file of many small members costs what it holds.
  int step() {
    const std::size_t given =
        std::min<std::size_t>(rest().size(), std::numeric_limits<uInt>::max());
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(rest().data()));
    stream_.avail_in = static_cast<uInt>(given);
    stream_.next_out = reinterpret_cast<Bytef*>(buffer_.data());
    stream_.avail_out = static_cast<uInt>(buffer_.size());
    const int status = inflate(&stream_, Z_NO_FLUSH);
    read_ += given - stream_.avail_in;
    bytes_.insert(bytes_.end(), buffer_.begin(), buffer_.end() - stream_.avail_out);
    return status;
  }

  const FileBytes& file_;
  z_stream stream_{};
  std::size_t read_ = 0;  // of the file, bytes
  std::vector<std::byte> bytes_;
  std::vector<std::byte> buffer_ = std::vector<std::byte>(std::size_t{1} << 17U);
};

}  // namespace

bool is_gzip(std::string_view text) {
  return text.size() >= 4 && text.starts_with("\x1f\x8b\x08") &&
         static_cast<unsigned char>(text[3]) < 0x20;
}

Result<std::vector<std::byte>> unpack_gzip(const FileBytes& file) {
  Unpacker unpacker(file);
  do {
    SIGHTLINE_TRY(unpacker.add_member());
  } while (is_gzip(unpacker.rest()));
  if (!is_padding(unpacker.rest())) {
    return file.error(
        ErrorCode::kMalformedHeader,
        concat("found ", unpacker.rest().size(),
               " bytes after the gzip stream; points may be missing. Compress the scan again"),
        at_byte(file.bytes.size() - unpacker.rest().size()));
  }
  return unpacker.take();
}

}  // namespace sightline
