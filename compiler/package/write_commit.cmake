# Writes the commit of SOURCE into the header OUTPUT; "unknown" where that is no checkout. Run by every build, and writes
# only what changed.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND git -C ${SOURCE} rev-parse --short=12 HEAD
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#define SIGHTLINE_COMMIT \"${commit}\"\n" @ONLY)
