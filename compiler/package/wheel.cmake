# The wheel `sightline-map`: `import sightline` with reader and localizer inside, for any Linux with glibc 2.34:
#   ninja -C build sightline_wheel       # sightline_map-VERSION-py3-none-manylinux_2_34_ARCHITECTURE.whl in build/
# The same objects as those of the shared libraries, linked again: OpenSSL, zlib and zstd are inside, oneTBB lies beside
# them. Needs Python, objdump and patchelf.
find_package(Python3 COMPONENTS Interpreter)
find_program(SIGHTLINE_PATCHELF patchelf)
find_library(SIGHTLINE_STATIC_CRYPTO libcrypto.a)
find_library(SIGHTLINE_STATIC_ZLIB libz.a)
find_library(SIGHTLINE_STATIC_ZSTD libzstd.a)
set(folder ${PROJECT_BINARY_DIR}/wheel)

# sightline_wheel_library(NAME OBJECTS_OF TARGET... ARCHIVES FILE... [LIBRARIES FILE...]): folder/libNAME.so.0. What no
# function of the C interface uses is left out, with the libraries that it would need.
function(sightline_wheel_library name)
  cmake_parse_arguments(ARG "" "OBJECTS_OF" "ARCHIVES;LIBRARIES" ${ARGN})
  set(output ${folder}/lib${name}.so.0)
  set(map ${PROJECT_SOURCE_DIR}/compiler/package/c_interface.map)
  set(older ${PROJECT_SOURCE_DIR}/compiler/package/older_libstdcxx.cpp)
  set(archives "")
  foreach(archive ${ARG_ARCHIVES})
    if(TARGET ${archive})
      list(APPEND archives $<TARGET_FILE:${archive}>)
    else()
      list(APPEND archives ${archive})
    endif()
  endforeach()
  add_custom_command(OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${folder}
    COMMAND ${CMAKE_CXX_COMPILER} -std=c++20 -O2 -fPIC -fvisibility=hidden -shared -s -o ${output}
      $<TARGET_OBJECTS:${ARG_OBJECTS_OF}> ${older}
      -Wl,-soname,lib${name}.so.0 -Wl,--version-script=${map} -Wl,--as-needed -Wl,--gc-sections -Wl,-z,defs
      -Wl,--start-group ${archives} -Wl,--end-group ${ARG_LIBRARIES}
    DEPENDS $<TARGET_OBJECTS:${ARG_OBJECTS_OF}> ${older} ${map} ${archives}
    COMMAND_EXPAND_LISTS VERBATIM)
endfunction()

if(Python3_FOUND AND SIGHTLINE_PATCHELF AND SIGHTLINE_STATIC_CRYPTO AND SIGHTLINE_STATIC_ZLIB AND SIGHTLINE_STATIC_ZSTD)
  sightline_wheel_library(sightline-reader OBJECTS_OF sightline_reader ARCHIVES sightline_base)
  sightline_wheel_library(sightline-localizer OBJECTS_OF sightline_localizer
    ARCHIVES sightline_matching sightline_foreign sightline_geodesy sightline_map sightline_mapping sightline_reader
      sightline_pass sightline_formats sightline_runtime sightline_base
      ${SIGHTLINE_STATIC_CRYPTO} ${SIGHTLINE_STATIC_ZLIB} ${SIGHTLINE_STATIC_ZSTD}
    LIBRARIES $<TARGET_FILE:TBB::tbb>)
  set(writer ${PROJECT_SOURCE_DIR}/compiler/package/write_wheel)
  file(GLOB modules CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/formats/reader/python/sightline/*)
  add_custom_target(sightline_wheel
    COMMAND ${Python3_EXECUTABLE} ${writer} --version ${PROJECT_VERSION} --output ${PROJECT_BINARY_DIR}
      --work ${folder} --bill ${PROJECT_BINARY_DIR}/sightline.spdx.json --patchelf ${SIGHTLINE_PATCHELF}
      --libraries ${folder}/libsightline-reader.so.0 ${folder}/libsightline-localizer.so.0
      --beside $<TARGET_FILE:TBB::tbb>
    DEPENDS ${folder}/libsightline-reader.so.0 ${folder}/libsightline-localizer.so.0 ${modules} ${writer}
    VERBATIM)
else()
  add_custom_target(sightline_wheel
    COMMAND ${CMAKE_COMMAND} -E echo "sightline_wheel: Python, patchelf and the static libraries of OpenSSL, zlib and zstd are needed"
    COMMAND ${CMAKE_COMMAND} -E false)
endif()
