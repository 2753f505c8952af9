#include "formats/foreign/pcd_unpack.h"

#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <exception>
#include <mutex>

// The one file that includes PCL. PCL believes what a file says of itself, so it sees a file only
// after pcd_header.cpp and pcd_file.cpp have checked it, and it is given bytes in memory: nothing
// can change between check and use.

namespace sightline {
namespace {

// Its messages would end up between our own lines, without the name of the file.
void silence_pcl() {
  static std::once_flag once;
  std::call_once(once, [] { pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); });
}

// PCL only moves the bytes of each field to their place; what they mean is read by us, so each
// field is told to it as bytes. That also carries 64-bit integers, which it does not know.
pcl::PCLPointCloud2 empty_cloud(const PcdHeader& header) {
  pcl::PCLPointCloud2 cloud;
  for (const PcdField& field : header.fields) {
    pcl::PCLPointField& told = cloud.fields.emplace_back();
    told.offset = static_cast<std::uint32_t>(field.offset);
    told.name = "bytes_" + std::to_string(field.offset);  // "_" would make PCL lose count
    told.datatype = pcl::PCLPointField::UINT8;
    told.count = static_cast<std::uint32_t>(field.bytes());
  }
  cloud.width = header.point_count;
  cloud.height = 1;
  cloud.point_step = static_cast<std::uint32_t>(header.point_size);
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.data.resize(static_cast<std::size_t>(header.point_count) * header.point_size);
  return cloud;
}

}  // namespace

Result<std::vector<std::uint8_t>> unpack_pcd_body(const FileBytes& file, const PcdHeader& header) {
  constexpr int kPcdVersion7 = 1;
  silence_pcl();
  const Error damaged = file.error(ErrorCode::kTruncatedScan, "the compressed points do not unpack",
                                   at_byte(header.data_offset));
  try {
    pcl::PCLPointCloud2 cloud = empty_cloud(header);
    const std::size_t size = cloud.data.size();
    // The decompressor may look one byte past a damaged stream's end.
    std::vector<unsigned char> body(file.bytes.size() - header.data_offset + 8, 0);
    std::copy(file.bytes.begin() + static_cast<std::ptrdiff_t>(header.data_offset),
              file.bytes.end(), reinterpret_cast<std::byte*>(body.data()));
    pcl::PCDReader reader;
    const int status = reader.readBodyBinary(body.data(), cloud, kPcdVersion7,
                                             header.encoding == PcdEncoding::kBinaryCompressed, 0);
    if (status != 0 || cloud.data.size() != size) return damaged;
    return std::move(cloud.data);
  } catch (const std::bad_alloc&) {
    return file.error(ErrorCode::kOutOfMemory, "the points do not fit into memory", "");
  } catch (const std::exception& failure) {
    Error error = damaged;
    error.message += std::string(": ") + failure.what();
    return error;
  }
}

}  // namespace sightline
