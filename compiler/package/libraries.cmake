# The libraries that this program is built with, for --version and for the package's bill of materials. Included last, when
# all folders have found theirs: those without a file for pkg-config leave their version in a global property.

# name | licence (SPDX) | module of pkg-config, or @ for the property SIGHTLINE_VERSION_name
set(rows
  "bzip2|bzip2-1.0.6|@"
  "Ceres|BSD-3-Clause|@"
  "CLI11|BSD-3-Clause|CLI11"
  "Eigen|MPL-2.0|eigen3"
  "Embree|Apache-2.0|@"
  "FLANN|BSD-2-Clause|flann"
  "FlatBuffers|Apache-2.0|flatbuffers"
  "fmt|MIT|fmt"
  "GeographicLib|MIT|geographiclib"
  "libpng|libpng-2.0|libpng"
  "libsodium|ISC|libsodium"
  "lz4|BSD-2-Clause|liblz4"
  "nlohmann-json|MIT|nlohmann_json"
  "OctoMap|BSD-3-Clause|octomap"
  "oneTBB|Apache-2.0|tbb"
  "OpenSSL|Apache-2.0|libcrypto"
  "PCL|BSD-3-Clause|pcl_common"
  "spdlog|MIT|spdlog"
  "SQLite|blessing|sqlite3"
  "TinyXML-2|Zlib|tinyxml2"
  "xxHash|BSD-2-Clause|libxxhash"
  "yaml-cpp|MIT|yaml-cpp"
  "zlib|Zlib|zlib"
  "zstd|BSD-3-Clause|libzstd")

set(libraries "")  # name | licence | version
foreach(row ${rows})
  string(REPLACE "|" ";" row ${row})
  list(GET row 0 name)
  list(GET row 1 licence)
  list(GET row 2 module)
  if(name MATCHES "^(PCL|FLANN)$" AND NOT SIGHTLINE_PCL)
    continue()
  endif()
  if(module STREQUAL "@")
    get_property(version GLOBAL PROPERTY SIGHTLINE_VERSION_${name})
  else()
    execute_process(COMMAND ${PKG_CONFIG_EXECUTABLE} --modversion ${module}
      OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  endif()
  if(version)
    list(APPEND libraries "${name}|${licence}|${version}")
  endif()
endforeach()

# For --version.
set(text "")
foreach(library ${libraries})
  string(REPLACE "|" ";" library ${library})
  list(GET library 0 name)
  list(GET library 2 version)
  string(APPEND text "${name} ${version}, ")
endforeach()
string(REGEX REPLACE ", $" "" SIGHTLINE_LIBRARIES "${text}")
set(config_schema ${PROJECT_SOURCE_DIR}/schemas/config.schema.json)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${config_schema})
file(SHA256 ${config_schema} SIGHTLINE_CONFIG_SCHEMA)
string(SUBSTRING ${SIGHTLINE_CONFIG_SCHEMA} 0 12 SIGHTLINE_CONFIG_SCHEMA)
configure_file(${PROJECT_SOURCE_DIR}/compiler/package/built_with.h.in
               ${PROJECT_BINARY_DIR}/built_with/built_with.h @ONLY)
include(compiler/package/bill_of_materials.cmake)
