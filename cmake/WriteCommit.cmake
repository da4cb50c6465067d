# Writes the header OUTPUT with the commit of the sources in SOURCE_DIR, "" outside of a repository, if it differs.
execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT [[
#pragma once
namespace simplexseg {
inline constexpr const char* kCommit = "@commit@";  ///< commit of the sources, or ""
}  // namespace simplexseg
]] @ONLY)
